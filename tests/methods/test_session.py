"""What every method owes to the session that they share: the scene around the mirrors, and its buffers."""

from __future__ import annotations

import gc
import weakref
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from anamorph.base.errors import AnamorphError
from anamorph.files.opening import open_scene
from anamorph.frame import View
from anamorph.methods import METHODS, Specification
from anamorph.rendering import render
from anamorph.scene.camera import Camera

SIZE = (48, 36)


@pytest.mark.parametrize("method", METHODS)
def test_how_far_the_target_is_does_not_change_the_image(method: str) -> None:
    scene, _ = open_scene("flat-mirror")
    eye, target = np.array(scene.camera.position), np.array(scene.camera.target)
    far = eye + 1e4 * (target - eye)
    images = [
        render(scene, method, replace(scene.camera, target=tuple(map(float, point))), SIZE).color
        for point in (target, far)
    ]
    assert np.abs(images[0] - images[1]).max() < 0.02


def test_the_reference_tells_its_rays_where_no_mirror_is_in_the_image() -> None:
    scene, _ = open_scene("flat-mirror")
    camera = Camera((0.0, 1.0, 4.0), (0.0, 1.0, 9.0))
    frame = render(scene, "raytrace", camera, SIZE, seen=True)
    assert frame.specular is not None and frame.ray_origin is not None and frame.ray_direction is not None
    assert not frame.specular.any()
    assert np.allclose(frame.ray_origin, camera.position)
    assert np.allclose(frame.ray_direction[SIZE[1] // 2, SIZE[0] // 2], (0.0, 0.0, 1.0), atol=0.02)


@pytest.mark.parametrize("value", [4.7, None, float("inf")])
def test_an_option_that_is_no_whole_number_is_refused(value: object) -> None:
    with pytest.raises(AnamorphError, match="antialias"):
        Specification.parse("pervertex").with_options(antialias=value)


def test_a_scene_file_says_how_it_is_drawn(tmp_path: Path) -> None:
    file = tmp_path / "wall.toml"
    file.write_text('builtin = "flat-mirror"\nsize = [20, 10]\nmethod = "raytrace:bounces=2"\n')
    frame = render(file, seen=True)
    assert frame.color.shape == (10, 20, 3)
    assert frame.ray_origin is not None
    assert render(file, "environment", size=(8, 6), seen=True).ray_origin is None


@pytest.mark.parametrize("specification", [*METHODS, "pervertex:tolerance=0.5", "pervertex:map=image"])
def test_a_session_that_is_dropped_leaves_the_device_at_once(specification: str) -> None:
    scene, _ = open_scene("facing-mirrors")
    view = View(scene, scene.camera, SIZE)
    session = Specification.parse(specification).open(view)
    session.draw(view.camera)
    session.frame(seen=True)
    kept = weakref.ref(session.texture), weakref.ref(session.diagnostics()["buffers"].vertices)
    gc.disable()
    try:
        del session
        assert [each() for each in kept] == [None, None], "it waits for the collector of cycles"
    finally:
        gc.enable()
