"""What the viewer saves beside the view: images, comparisons and turntables, step by step, whole or not at all."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from anamorph.base.errors import AnamorphError
from anamorph.base.srgb import encode_srgb
from anamorph.cli.turntable import save_turntable
from anamorph.files.opening import open_scene
from anamorph.files.source import Source
from anamorph.measure.compare import Comparison, compare, comparison_steps
from anamorph.methods import Specification
from anamorph.rendering import render
from anamorph.scene.camera import Camera
from anamorph.viewer.facts import Progress
from anamorph.viewer.saving import Saving, free_name, save_comparison, save_image
from anamorph.viewer.turntable import orbit, turntable

SIZE = (48, 32)
CAMERA = Camera((1.0, 2.0, 5.0), (1.0, 1.5, 1.0), (0.1, 1.0, 0.0), 35.0)


def finished(steps: Saving) -> tuple[list[Progress], str]:
    """All that the work told, and what it says in the end."""
    told = []
    while True:
        try:
            told.append(next(steps))
        except StopIteration as end:
            return told, end.value


def test_names_are_numbered_and_never_taken_twice(tmp_path):
    first = free_name(tmp_path, "car-mirror", ".png")
    assert first == tmp_path / "car-mirror-1.png"
    first.touch()
    (tmp_path / "car-mirror-2.png").symlink_to(tmp_path / "nowhere")
    assert free_name(tmp_path, "car-mirror", ".png").name == "car-mirror-3.png"
    assert free_name(tmp_path, "car-mirror", "").name == "car-mirror-1"


@given(st.text(max_size=12))
def test_any_name_of_a_scene_makes_a_plain_one(stem):
    name = free_name("/nowhere", stem, ".png").name
    assert Path(name).name == name and name.endswith("-1.png") and not name.startswith((".", "-"))
    assert not set(name) & set('/\\:*?"<>|\0\n ')


def test_an_image_is_saved_as_it_is_shown(tmp_path):
    linear = np.linspace(0.0, 1.0, 4 * 5 * 3, dtype=np.float32).reshape(4, 5, 3)
    shown = np.round(255 * encode_srgb(linear)).astype(np.uint8)
    for name, color in (("shown.png", shown), ("turned.png", shown[::-1][::-1])):
        assert save_image(tmp_path / name, color) == f"saved {name}"
        with Image.open(tmp_path / name) as image:
            assert np.array_equal(np.asarray(image), shown)
    with pytest.raises(AnamorphError, match=r"end the name in \.png"):
        save_image(tmp_path / "a.gif", shown)
    with pytest.raises(AnamorphError, match="there is no directory"):
        save_image(tmp_path / "no" / "a.png", shown)


def figures(comparison: Comparison) -> dict:
    """All that a comparison says but times."""
    said = json.loads(comparison.to_json())
    del said["without_mirrors_ms"]
    for method in said["methods"].values():
        del method["frame_ms"]
    return said


def test_a_comparison_in_steps_is_the_comparison():
    scene, _ = open_scene("flat-mirror")
    told: list[tuple[int, int, str]] = []
    at_once = compare(scene, ["environment"], SIZE, frames=2, report=lambda *step: told.append(step))
    steps = comparison_steps(scene, ["environment"], SIZE, frames=2)
    yielded = []
    while True:
        try:
            yielded.append(next(steps))
        except StopIteration as end:
            assert figures(end.value) == figures(at_once)
            break
    assert yielded == told
    assert [done for done, _, _ in told] == sorted(done for done, _, _ in told)
    assert {total for _, total, _ in told} == {told[-1][0]} and {done for done, _, _ in told} == set(range(6))
    # More steps than methods: nothing waits for all rounds of timing.
    assert len({what for _, _, what in told}) >= 8


def test_a_comparison_page_is_saved_or_leaves_nothing(tmp_path):
    scene, _ = open_scene("flat-mirror")
    page = tmp_path / "page.html"
    steps = save_comparison(page, scene, ["environment"], SIZE)
    assert next(steps).done == 0
    next(steps)
    steps.close()
    assert not list(tmp_path.iterdir())
    told, said = finished(save_comparison(page, scene, ["environment"], SIZE, "from the viewer"))
    assert said == "saved page.html" and os.listdir(tmp_path) == ["page.html"]
    assert told[-1].done == told[-1].total and "from the viewer" in page.read_text()
    with pytest.raises(AnamorphError, match="there is no directory"):
        next(save_comparison(tmp_path / "no" / "page.html", scene, [], SIZE))


def test_an_orbit_goes_once_round_the_target():
    cameras = orbit(CAMERA, 8)
    assert cameras[0] is CAMERA and len({camera.position for camera in cameras}) == 8
    offsets = np.array([np.subtract(camera.position, camera.target) for camera in cameras])
    assert np.linalg.norm(offsets, axis=1) == pytest.approx(np.full(8, np.linalg.norm(offsets[0])))
    assert offsets @ CAMERA.up == pytest.approx(np.full(8, offsets[0] @ CAMERA.up))
    assert np.cross(offsets, np.roll(offsets, -1, axis=0)) @ CAMERA.up == pytest.approx(
        np.full(8, np.cross(offsets[0], offsets[1]) @ CAMERA.up)
    )
    # The eye sets out to its right.
    assert np.subtract(cameras[1].position, CAMERA.position) @ CAMERA.axes()[0] > 0.0
    assert all(replace(camera, position=CAMERA.position) == CAMERA for camera in cameras)


def test_a_swing_goes_to_both_sides_and_back():
    cameras = orbit(CAMERA, 8, swing=20.0)
    across = [np.subtract(camera.position, CAMERA.position) @ CAMERA.axes()[0] for camera in cameras]
    assert cameras[0] is CAMERA and across[4] == pytest.approx(0.0, abs=1e-12)
    assert across[2] == max(across) and across[6] == min(across)
    offset = np.subtract(CAMERA.position, CAMERA.target)
    up = np.array(CAMERA.up) / np.linalg.norm(CAMERA.up)
    radius = np.linalg.norm(offset - (offset @ up) * up)
    chord = np.linalg.norm(np.subtract(cameras[2].position, CAMERA.position))
    assert chord == pytest.approx(2.0 * radius * np.sin(np.radians(10.0)))


@pytest.mark.parametrize(("frames", "swing"), [(0, None), (10000, None), (8, 0.0), (8, -5.0), (8, 181.0), (8, np.nan)])
def test_an_orbit_of_no_sense_is_refused(frames, swing):
    with pytest.raises(AnamorphError, match=r"^(frames|swing) is [^\n]*$"):
        orbit(CAMERA, frames, swing)


def test_a_series_holds_each_frame_as_render_draws_it(tmp_path):
    scene, _ = open_scene("flat-mirror")
    path = orbit(scene.camera, 5, swing=15.0)
    told, said = finished(
        turntable(tmp_path / "series", scene, Specification.parse("pervertex"), path, SIZE, samples=2)
    )
    assert said == "saved series" and os.listdir(tmp_path) == ["series"]
    assert [step.done for step in told] == list(range(21)) and {step.total for step in told} == {20}
    images = []
    for number, camera in enumerate(path, start=1):
        with Image.open(tmp_path / "series" / f"frame-{number:04}.png") as image:
            images.append(np.asarray(image))
        drawn = render(scene, "pervertex", camera=camera, size=SIZE, samples=2)
        assert np.array_equal(images[-1], np.round(255 * encode_srgb(drawn.color)).astype(np.uint8))
    assert len({image.tobytes() for image in images}) == 5
    plain = render(scene, "pervertex", camera=path[-1], size=SIZE)
    assert np.mean(images[-1]) == pytest.approx(255 * np.mean(encode_srgb(plain.color)), abs=3.0)
    assert len(list((tmp_path / "series").iterdir())) == 5


@pytest.mark.parametrize("name", ["a.webm", "a.webp", "series"])
def test_a_turntable_that_is_ended_leaves_nothing(tmp_path, name):
    scene, _ = open_scene("flat-mirror")
    steps = turntable(tmp_path / name, scene, Specification.parse("environment"), orbit(scene.camera, 6), SIZE)
    while next(steps).done < 3:
        pass
    assert list(tmp_path.iterdir()) and not (tmp_path / name).exists()
    steps.close()
    assert not list(tmp_path.iterdir())


def test_what_is_wrong_with_a_turntable_is_said_before_the_first_step(tmp_path):
    scene, _ = open_scene("flat-mirror")
    for name, method in (("a.mp4", "pervertex"), ("no/a.webm", "pervertex")):
        with pytest.raises(AnamorphError):
            next(turntable(tmp_path / name, scene, Specification.parse(method), orbit(scene.camera, 6), SIZE))
    assert not list(tmp_path.iterdir())


def test_the_command_saves_an_animation(tmp_path):
    said = save_turntable(
        Source("flat-mirror"),
        tmp_path / "a.webp",
        method=Specification.parse("environment"),
        size=SIZE,
        frames=4,
        rate=10.0,
    )
    assert said == "saved a.webp"
    with Image.open(tmp_path / "a.webp") as image:
        image.load()
        assert (image.n_frames, image.size, image.info["duration"]) == (4, SIZE, 100)
    with pytest.raises(AnamorphError, match="end the name in"):
        save_turntable(Source("flat-mirror"), tmp_path / "a.avi")
