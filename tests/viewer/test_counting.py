"""How often vertices are seen, as colours: the colours, and the halves that show them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import CAMERA, SIZE, drawn, flat_mirror, scene_with, spherical_mirror

from anamorph.base.errors import AnamorphError
from anamorph.base.steps import drain
from anamorph.frame import Frame
from anamorph.measure.heatmap import faint
from anamorph.methods import Specification
from anamorph.scene.model import Scene
from anamorph.viewer import counting
from anamorph.viewer.counting import COUNT_COLORS, Counting, count_colors
from anamorph.viewer.point_search import vertex_counts
from anamorph.viewer.showing import Showing
from anamorph.viewer.state import Aspect, Half, State

METHOD, TRUTH = Specification.parse("pervertex"), Specification.parse("raytrace")
STATE = State(CAMERA, Half(METHOD, Aspect.COUNTS), Half(TRUTH), samples=1)
COLORS = np.array(list(COUNT_COLORS.values()), float)


def scene() -> Scene:
    return scene_with(flat_mirror())


def rest(showing: Showing, of: Scene, state: State) -> np.ndarray | None:
    """What the first half shows as false colours once nothing is left to do."""
    showing.update(of, state, SIZE)
    for _ in range(10_000):
        if not showing.rest():
            break
    assert showing.finished and not showing.counting
    return showing.halves[0].false_color


def test_each_pixel_has_the_colour_of_the_vertex_nearest_to_what_it_shows_in_the_images_brightness():
    of = scene()
    frame = drawn(of, "raytrace")
    counts = [np.arange(len(mesh.positions)) % 7 for mesh in of.meshes]
    colors = count_colors(frame, of, counts)
    grey = faint(frame.color)
    assert colors.shape == grey.shape and (colors[..., 3] == 255).all()
    diffuse = frame.object_id > 1
    assert (colors[~diffuse] == grey[~diffuse]).all() and diffuse.any() and not diffuse.all()
    for row, column in np.argwhere(diffuse)[::101]:
        number = frame.object_id[row, column] - 1
        away = np.linalg.norm(of.meshes[number].positions - frame.position[row, column].astype(float), axis=1)
        allowed = [COLORS[min(counts[number][each], 4)] for each in np.flatnonzero(away < away.min() + 1e-6)]
        shade = grey[row, column, 0] / 242.0
        assert min(np.abs(colors[row, column, :3] - shade * each).max() for each in allowed) <= 1.0
        assert 0.75 < shade <= 1.0
    with pytest.raises(AnamorphError, match="seen=True"):
        count_colors(Frame(frame.color), of, counts)


def test_counts_are_shown_at_rest_and_the_image_while_it_moves():
    of, showing = scene(), Showing()
    shown = rest(showing, of, STATE)
    assert shown is not None and shown.size[:2] == SIZE
    assert showing.update(of, replace(STATE, camera=replace(CAMERA, field_of_view=30.0)), SIZE)
    assert showing.halves[0].false_color is None and showing.halves[0].image is not None


def test_they_are_counted_for_the_eye_wherever_an_observer_stands(monkeypatch):
    of, asked = scene(), []

    def counted(scene, eye, size):
        asked.append(eye)
        return vertex_counts(scene, eye, size)

    monkeypatch.setattr(counting, "vertex_counts", counted)
    showing, observer = Showing(), replace(CAMERA, position=(1.0, 1.0, 2.0))
    rest(showing, of, replace(STATE, observer=observer))
    assert asked == [CAMERA]
    nearer = replace(CAMERA, position=(0.2, 0.6, 0.8))
    rest(showing, of, replace(STATE, observer=observer, camera=nearer))
    assert asked == [CAMERA, nearer]
    rest(showing, of, replace(STATE, observer=observer, camera=nearer, unit="px"))
    assert asked == [CAMERA, nearer]


def test_where_nothing_can_be_counted_the_image_stays_and_why_is_said():
    of, showing = replace(scene(), meshes=scene().meshes[1:]), Showing()
    assert rest(showing, of, STATE) is None and showing.halves[0].image is not None
    assert len(showing.failures) == 1 and "has no mirror" in showing.failures[0]
    assert rest(showing, scene_with(spherical_mirror()), STATE) is not None and showing.failures == ()


def test_counting_waits_in_steps_for_what_takes_long(monkeypatch):
    monkeypatch.setattr(counting, "PATIENCE", 0.0)
    own, of, steps = Counting(), scene(), []
    counts = drain(own.counting(of, CAMERA, SIZE), steps.append)
    assert steps and all(
        (one == other).all() for one, other in zip(counts, vertex_counts(of, CAMERA, SIZE), strict=True)
    )
    assert not own.busy and own.failure == ""
