"""Where mirrors show points, and what is hidden of that: closed forms of a flat mirror, and the reference's pixels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import CAMERA, SIZE, drawn, flat_mirror, pixels_of, scene_with, spherical_mirror

from anamorph.base.errors import AnamorphError
from anamorph.frame import Status
from anamorph.gallery import make
from anamorph.gallery.flat_mirror import plane_mirror
from anamorph.gallery.solids import box
from anamorph.reflections.reflection_points import reflection_points
from anamorph.scene.model import Diffuse, Mesh, Scene
from anamorph.viewer.facts import Reflection
from anamorph.viewer.point_search import reflections_of, vertex_counts, visible

POINT = (-0.2, 0.5, 2.0)
MIRRORED = np.array([1.0, 1.0, -1.0])
"""What takes a point to its place behind the flat mirror, which lies in the plane z = 0."""

ON_MIRROR = CAMERA.position[2] / (CAMERA.position[2] + POINT[2])


def obstacle(low: tuple[float, float, float], high: tuple[float, float, float]) -> Mesh:
    return box(low, high).mesh("obstacle", Diffuse())


def before(*others: Mesh) -> Scene:
    """A flat mirror with nothing else before it."""
    return Scene("test", (flat_mirror(), *others), CAMERA)


def only(scene: Scene, point: tuple[float, float, float] = POINT) -> Reflection:
    (found,) = reflections_of(scene, CAMERA, SIZE, point).found
    return found


def test_a_flat_mirror_shows_a_point_where_its_mirrored_one_is():
    found = only(before())
    behind = MIRRORED * POINT
    eye = np.array(CAMERA.position)
    assert found.pixel == pytest.approx(pixels_of(CAMERA, SIZE, behind), abs=1e-9)
    assert found.position == pytest.approx(eye + ON_MIRROR * (behind - eye), abs=1e-12)
    assert found.length == pytest.approx(np.linalg.norm(behind - eye), rel=1e-12)
    assert (found.name, found.order, found.hidden) == ("mirror", 1, False)
    assert reflections_of(before(), CAMERA, SIZE, (-0.2, 0.5, -2.0)).found == ()


@pytest.mark.parametrize("leg", [0, 1])
def test_what_stands_in_either_leg_hides_a_point_and_what_stands_beside_or_beyond_does_not(leg):
    place = np.array(only(before()).position)
    start, stop = (np.array(CAMERA.position), place) if leg == 0 else (place, np.array(POINT))

    def with_a_box(middle: np.ndarray) -> Scene:
        low, high = middle - 0.01, middle + 0.01
        return before(obstacle(tuple(low.tolist()), tuple(high.tolist())))

    for share in (0.1, 0.5, 0.9):
        assert only(with_a_box(start + share * (stop - start))).hidden
        assert not only(with_a_box(start + share * (stop - start) + [0.05, 0.0, 0.0])).hidden
    beyond = stop + 0.2 * (stop - start) if leg else start - 0.2 * (stop - start)
    assert not only(with_a_box(beyond)).hidden


def test_a_point_on_what_stands_there_is_not_hidden_by_it_unless_it_is_on_the_other_side():
    wall = obstacle((-1.0, 0.0, 2.0), (1.0, 2.0, 2.3))
    assert not only(before(wall), POINT).hidden
    assert only(before(wall), (-0.2, 0.5, 2.3)).hidden


def test_a_mirror_before_the_mirror_hides_what_it_shows():
    near = plane_mirror("near", (-0.3, 0.2, 0.3), (0.8, 0.0, 0.0), (0.0, 0.8, 0.0))
    found = reflections_of(before(near), CAMERA, SIZE, POINT).found
    assert {each.name: each.hidden for each in found} == {"near": False, "mirror": True}


def searched(
    scene: Scene, points: np.ndarray, size: tuple[int, int] = SIZE
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of each reflection point its point's number, its pixel, and whether it is visible."""
    found = reflection_points(scene, scene.camera, points, size)
    assert (found.image[:, 2] > 0.0).all()
    return found.point, found.image[:, :2] / found.image[:, 2:], visible(scene, scene.camera, size, points, found)


@pytest.mark.parametrize(("radius", "cells"), [(1.4, 8), (-0.6, 8), (0.5, 2)])
def test_a_pixel_that_sees_a_point_in_a_mirror_is_one_of_those_that_show_it(radius, cells):
    scene = scene_with(spherical_mirror(radius, cells))
    frame = drawn(scene, "raytrace:bounces=1")
    rows, columns = np.nonzero((frame.specular == 1) & (frame.object_id > 0) & (frame.status == Status.TRACED))
    point, pixels, seen = searched(scene, frame.position[rows, columns].astype(float))
    away = np.linalg.norm(pixels - np.column_stack([columns, rows])[point] - 0.5, axis=1)
    # The points are float32, and one of a concave mirror's may be magnified.
    own = np.bincount(point[(away < 0.02)], minlength=len(rows))
    shown = np.bincount(point[(away < 0.02) & seen], minlength=len(rows))
    # At the very border, it is rounding that tells whether there is one.
    assert len(rows) > 1000 and (own == 1).mean() > 0.999 and (shown == own).mean() > 0.999


def test_a_visible_place_is_where_the_image_shows_that_point():
    scene, size = make("torus"), (480, 360)
    frame = drawn(scene, "raytrace:bounces=1", size)
    rows, columns = (each[::29] for each in np.nonzero((frame.object_id > 0) & (frame.status != Status.OUTSIDE)))
    points = frame.position[rows, columns].astype(float)
    point, pixels, seen = searched(scene, points, size)
    x, y = pixels.astype(int).T
    around = [np.s_[y + down, x + right] for down in (-1, 0, 1) for right in (-1, 0, 1)]
    # Away from silhouettes, a pixel and those around it see one object, but for what is smaller than a pixel.
    here = frame.object_id[y, x]
    even = np.all([(frame.specular[each] == 1) & (frame.object_id[each] == here) for each in around], axis=0)
    same = here == frame.object_id[rows, columns][point]
    assert (seen & even).sum() > 1000 and (seen & even & ~same).sum() < 0.02 * (seen & even).sum()
    away = np.linalg.norm(frame.position[y, x] - points[point], axis=1)
    spread = np.max([np.linalg.norm(frame.position[each] - frame.position[y, x], axis=1) for each in around], axis=0)
    assert (away <= spread)[seen & even & same].all()
    # What is hidden there is not seen there.
    assert (~seen & even).sum() > 300 and (away > 1e-2)[~seen & even].all()


def test_vertices_before_a_flat_mirror_are_counted_where_the_mirrored_eye_sees_them_through_it():
    places = np.random.default_rng(7).uniform((-3.0, -1.0, -2.0), (3.0, 2.0, 4.0), (300, 3))
    faces = np.arange(300, dtype=np.int32).reshape(100, 3)
    # They are so small that none stands before another.
    small = places[::3, None] + 1e-6 * np.eye(3)
    up = np.tile(np.float32([0.0, 1.0, 0.0]), (300, 1))
    cloud = Mesh("cloud", small.reshape(-1, 3), faces, up, Diffuse())
    eye = np.array(CAMERA.position)
    to = cloud.positions * MIRRORED - eye
    hit = eye - to * (eye[2] / to[:, 2])[:, None]
    # The mirror goes from -0.2 to 0.2, and from 0.35 to 0.65.
    through = (cloud.positions[:, 2] > 0) & (np.abs(hit[:, 0]) < 0.2) & (np.abs(hit[:, 1] - 0.5) < 0.15)
    mirror, counts = vertex_counts(before(cloud), CAMERA, SIZE)
    assert mirror.tolist() == [0] * 4
    assert 5 < through.sum() < 250 and counts.tolist() == through.astype(int).tolist()
    hidden = before(cloud, obstacle((-1.0, 0.0, 0.4), (1.0, 1.5, 0.41)))
    assert (
        vertex_counts(hidden, CAMERA, SIZE)[1].tolist()
        == (through & (cloud.positions[:, 2] < 0.4)).astype(int).tolist()
    )


def test_the_counts_of_vertices_are_those_of_points():
    scene = scene_with(spherical_mirror(-0.6), flat_mirror())
    counts = vertex_counts(scene, CAMERA, SIZE)
    assert [len(each) for each in counts] == [len(mesh.positions) for mesh in scene.meshes]
    for mesh, own in zip(scene.meshes[2:4], counts[2:4], strict=True):
        for place, count in zip(mesh.positions.tolist()[::7], own[::7], strict=True):
            found = reflections_of(scene, CAMERA, SIZE, tuple(place)).found
            assert sum(not each.hidden for each in found) == count


def test_what_has_nothing_to_search_is_refused_in_one_line():
    scene = replace(before(), meshes=(obstacle((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)),))
    with pytest.raises(AnamorphError, match=r"^scene 'test': has no mirror[^\n]*$"):
        reflections_of(scene, CAMERA, SIZE, POINT)
    with pytest.raises(AnamorphError, match=r"^scene 'test': has no mirror[^\n]*$"):
        vertex_counts(scene, CAMERA, SIZE)
