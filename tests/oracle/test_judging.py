"""What the judgement says of frames that are made wrong by a known amount."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from oracle.families import make
from oracle.judging import judge, pixel_centres
from oracle.scene import Scene
from oracle.subrays import Shown
from oracle.tracer import Tracer

SIZE = (64, 48)


def shown_at(scene: Scene, tracer: Tracer, shift=(0.0, 0.0)) -> Shown:
    """What the tracer itself sees, each pixel looking `shift` pixels aside."""
    seen = tracer.look(scene.camera, pixel_centres(SIZE) + shift, SIZE)
    shape = SIZE[::-1]
    flat = Shown(
        seen.position, seen.object_id, seen.specular, np.full(len(seen.flags), 2), np.zeros((len(seen.flags), 3))
    )
    return Shown(**{name: values.reshape(*shape, *values.shape[1:]) for name, values in vars(flat).items()})


@pytest.fixture(scope="module", params=["convex-cap", "worn-lens", "wall-mirror"])
def scene_and_tracer(request):
    scene = make(request.param, 1)
    return scene, Tracer(scene)


def test_the_truth_is_right(scene_and_tracer):
    scene, tracer = scene_and_tracer
    found = judge(tracer, scene.camera, shown_at(scene, tracer))
    assert found.plain.sum() > 300 and found.silhouette.sum() > 30
    assert not found.wrong.any() and not found.missed.any() and not found.pixels.any()
    assert found.angles.max() < 1e-7


@pytest.mark.parametrize("shift", [(0.3, 0.0), (-0.2, 0.3)])
def test_a_shifted_frame_is_as_far_off_as_it_is_shifted(scene_and_tracer, shift):
    scene, tracer = scene_and_tracer
    found = judge(tracer, scene.camera, shown_at(scene, tracer, shift))
    pixels = found.pixels[found.plain & ~found.other]
    assert np.median(pixels) == pytest.approx(np.hypot(*shift), abs=1e-3)
    assert np.percentile(np.abs(pixels - np.hypot(*shift)), 99) < 0.02
    # Something thinner than the sub-rays stand apart may show in the one frame alone.
    assert not found.wrong.any() and found.missed.sum() <= 1


def test_a_frame_two_pixels_off_is_wrong_all_over(scene_and_tracer):
    scene, tracer = scene_and_tracer
    found = judge(tracer, scene.camera, shown_at(scene, tracer, (2.0, 0.0)))
    assert found.wrong[found.plain].mean() > 0.98
    assert found.wrong_by_status() == {2: found.wrong.sum()}
    assert found.missed[found.silhouette].mean() > 0.9


def test_a_lost_object_is_another_object(scene_and_tracer):
    scene, tracer = scene_and_tracer
    shown = shown_at(scene, tracer)
    floor = 1 + next(number for number, part in enumerate(scene.parts) if part.name == "floor")
    hidden = (shown.object_id == floor) & (shown.specular > 0)
    lost = replace(shown, object_id=np.where(hidden, 0, shown.object_id), status=np.where(hidden, 4, 2))
    found = judge(tracer, scene.camera, lost)
    assert hidden[found.plain].sum() > 20
    assert (found.wrong == (hidden & found.plain)).all() and (found.other == found.wrong).all()
    assert found.wrong_by_status() == {4: found.wrong.sum()}


def test_what_stands_behind_in_the_same_direction_is_wrong(scene_and_tracer):
    scene, tracer = scene_and_tracer
    shown = shown_at(scene, tracer)
    seen = tracer.look(scene.camera, pixel_centres(SIZE), SIZE)
    beyond = (seen.position + 0.5 * (seen.position - seen.origin)).reshape(shown.position.shape)
    deep = replace(shown, position=np.where((shown.object_id > 0)[..., None], beyond, shown.position))
    found = judge(tracer, scene.camera, deep)
    solid = found.plain & (shown.object_id > 0)
    assert solid.sum() > 100 and (found.wrong[solid]).mean() > 0.95 and not found.wrong[~solid].any()


def test_a_mirror_that_is_missing_from_a_frame_is_counted(scene_and_tracer):
    scene, tracer = scene_and_tracer
    shown = shown_at(scene, tracer)
    blank = replace(shown, specular=np.zeros_like(shown.specular), object_id=np.ones_like(shown.object_id))
    found = judge(tracer, scene.camera, blank)
    assert found.plain.sum() > 300 and found.wrong[found.plain].all()


def test_where_nothing_is_shown_all_is_wrong(scene_and_tracer):
    scene, tracer = scene_and_tracer
    shown = shown_at(scene, tracer)
    nothing = replace(shown, position=np.zeros_like(shown.position), object_id=np.zeros_like(shown.object_id))
    found = judge(tracer, scene.camera, nothing)
    assert found.wrong[found.plain].all() and found.missed[found.silhouette].all()
    assert np.isfinite(found.angles).all()
