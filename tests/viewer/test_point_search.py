"""Where mirrors show points, and what is hidden of that: closed forms of a flat mirror, and the reference's pixels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from lens_scenes import CAMERA as LENS_CAMERA
from lens_scenes import PLUS, lens_of, scene_of
from scenes import CAMERA, SIZE, flat_mirror, pixels_of, scene_with, spherical_mirror

from anamorph.base.errors import AnamorphError
from anamorph.gallery.flat_mirror import plane_mirror
from anamorph.gallery.solids import box
from anamorph.scene.model import Diffuse, Mesh, Scene
from anamorph.viewer.facts import Reflection
from anamorph.viewer.point_search import reflections_of, vertex_counts

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
    assert found.path == (pytest.approx(eye + ON_MIRROR * (behind - eye), abs=1e-12),)
    assert found.length == pytest.approx(np.linalg.norm(behind - eye), rel=1e-12)
    assert (found.name, found.order, found.hidden) == ("mirror", 1, False)
    assert reflections_of(before(), CAMERA, SIZE, (-0.2, 0.5, -2.0)).found == ()


@pytest.mark.parametrize("leg", [0, 1])
def test_what_stands_in_either_leg_hides_a_point_and_what_stands_beside_or_beyond_does_not(leg):
    place = np.array(only(before()).path[0])
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


def test_a_lens_shows_points_too_beside_mirrors_or_alone():
    lens = lens_of(PLUS)
    point = (0.05, 0.5, -1.5)
    alone = reflections_of(scene_of(lens), LENS_CAMERA, SIZE, point)
    both = reflections_of(Scene("both", (flat_mirror(), *lens.meshes), LENS_CAMERA), LENS_CAMERA, SIZE, point)
    assert [(each.name, len(each.path)) for each in alone.found] == [("lens/back", 2)]
    assert [(each.name, len(each.path)) for each in both.found] == [("lens/back", 2)]
    behind = reflections_of(
        Scene("both", (flat_mirror(), *lens.meshes), LENS_CAMERA), LENS_CAMERA, SIZE, (0.1, 0.6, 0.8)
    )
    assert [(each.name, len(each.path)) for each in behind.found] == [("mirror", 1)]
    counts = vertex_counts(scene_of(lens), LENS_CAMERA, SIZE)
    assert [each.any() for each in counts[:3]] == [False] * 3 and sum(each.sum() for each in counts) > 0


def test_what_has_nothing_to_search_is_refused_in_one_line():
    scene = replace(before(), meshes=(obstacle((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)),))
    with pytest.raises(AnamorphError, match=r"^scene 'test': has no mirror[^\n]*$"):
        reflections_of(scene, CAMERA, SIZE, POINT)
    with pytest.raises(AnamorphError, match=r"^scene 'test': has no mirror[^\n]*$"):
        vertex_counts(scene, CAMERA, SIZE)
