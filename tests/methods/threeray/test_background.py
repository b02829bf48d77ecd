"""What is far from a mirror, shown by a map around its middle: exactly where that is, and how far off."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import CAMERA, SIZE, drawn, open_view, plane_mirror, scene_with, spherical_mirror, surroundings

from anamorph.base.errors import AnamorphError
from anamorph.cameras import pinhole
from anamorph.frame import Status
from anamorph.gallery.solids import box
from anamorph.gallery.spheres import mirror_ball
from anamorph.measure.errors import measure
from anamorph.methods.threeray.background import ERROR, are_near, least_distances
from anamorph.methods.threeray.cameras_seen import mesh_cameras
from anamorph.methods.threeray.surfels import sample
from anamorph.rays.caster import Caster
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Diffuse, Scene

MIRROR = spherical_mirror(count=4)


def test_with_everything_near_the_map_shows_nothing():
    scene = scene_with(MIRROR)
    whole, near = drawn(scene, "threeray"), drawn(scene, "threeray:background=map,near=1000")
    assert (whole.color == near.color).all() and (whole.status == near.status).all()
    assert not (near.status == Status.WARPED).any()


def test_with_nothing_near_each_pixel_shows_what_its_direction_meets_from_the_middle():
    scene = scene_with(MIRROR)
    frame = drawn(scene, "threeray:background=map,near=0.001")
    mapped = frame.status == Status.WARPED
    # The floor's surfels reach from below to the mirror's middle.
    assert mapped.mean() > 0.7 * (frame.specular > 0).mean() > 0.05
    geometry = flatten(replace(scene, meshes=tuple(mesh for mesh in scene.meshes if not mesh.specular)))
    low, high = MIRROR.positions.min(axis=0), MIRROR.positions.max(axis=0)
    middle = np.broadcast_to((low + high) / 2.0, (int(mapped.sum()), 3))
    directions = frame.position[mapped] - middle
    hits = Caster(geometry).cast(middle, directions)
    # Silhouettes are those of texels, and a place on a plane is that of the pixel's own direction.
    assert (np.abs(hits.distance - 1.0) < 1e-4).mean() > 0.99


def test_the_distance_by_itself_keeps_the_map_within_its_error():
    places = [(x, 3.0, 900.0) for x in (-300.0, -100.0, 100.0, 300.0)]
    far = [
        box(place, np.array(place) + 80.0).mesh(f"far-{number}", Diffuse((0.8, 0.3, 0.2)))
        for number, place in enumerate(places)
    ]
    scene = scene_with(MIRROR)
    scene = replace(scene, meshes=(*scene.meshes, *far))
    truth, frame = drawn(scene, "raytrace:truth=raymesh"), drawn(scene, "threeray:background=map")
    assert (frame.status == Status.WARPED).sum() > 100 < (frame.status == Status.PROJECTED).sum()
    errors = measure(truth, frame)
    assert errors.other_object_percent <= 0.05 and errors.pixels.max < ERROR


def test_a_flat_mirror_needs_the_distance_at_which_its_reach_is_half_a_pixel():
    camera = mesh_cameras(pinhole(CAMERA, SIZE), 1, (0.0, 0.0))
    body, everything = np.zeros(1, np.int64), np.arange(len(camera.item))
    assert least_distances(camera, everything, np.array([CAMERA.position]), body) == pytest.approx(0.0, abs=1e-9)
    beside = np.array(CAMERA.position)[None] + np.array([0.0, 0.3, 0.0])
    # Rays are apart least in the corners, by the square of the cosine and more.
    pixel = 2.0 * np.tan(np.radians(CAMERA.field_of_view / 2.0)) / SIZE[1]
    found = least_distances(camera, everything, beside, body)[0]
    assert 0.3 / (ERROR * pixel) <= found <= 1.5 * 0.3 / (ERROR * pixel)
    parallel = camera._replace(directions=np.ones_like(camera.directions))
    assert least_distances(parallel, everything, beside, body)[0] == np.inf


def test_surfels_are_near_a_middle_as_far_as_they_reach():
    corners = np.array([[[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0]] for x in (0.0, 5.0, 10.0)])
    surfels = sample(corners, lambda center: np.full(len(center), np.inf))
    middles = np.array([[0.0, 0.0, 0.0], [30.0, 0.0, 0.0]])
    assert are_near(surfels, middles, np.array([5.0, 0.0])).tolist() == [True, True, False]
    assert are_near(surfels, middles, np.array([-1.0, 20.0])).tolist() == [False, False, True]
    assert not are_near(surfels, np.zeros((0, 3)), np.zeros(0)).any()


def test_mirrors_are_near_wherever_they_are():
    ball = mirror_ball("ball", (0.0, 0.5, 0.0), 0.15, rows=12, columns=18)
    other = plane_mirror("other", (-2.0, 0.0, 2.9), (0.0, 1.5, 0.0), (4.0, 0.0, 0.0))
    scene = Scene("two", (ball, other, *surroundings()), CAMERA)
    whole, mapped = drawn(scene, "threeray"), drawn(scene, "threeray:background=map,near=0.01")
    assert (mapped.status == Status.WARPED).sum() > 100
    # From inside of the ball, what surrounds it is seen, and not the ball.
    assert not (mapped.object_id[mapped.status == Status.WARPED] <= 2).any()
    followed = whole.status == Status.TRACED
    assert followed.sum() > 20 and (mapped.status[followed] == Status.TRACED).all()
    assert (mapped.color[followed] == whole.color[followed]).all()


@pytest.mark.parametrize("behind", ["thing", "mirror"])
def test_what_is_far_hides_what_is_near_another_mirror_behind_it(behind):
    """A screen stands between two mirrors, far from both."""
    other = plane_mirror("other", (2.0, -1.0, 5.0), (-4.0, 0.0, 0.0), (0.0, 4.0, 0.0))
    thing = box((-2.0, -1.0, 4.7), (2.0, 3.0, 4.8)).mesh("thing", Diffuse((0.9, 0.1, 0.1)))
    screen = box((-2.0, -1.0, 2.5), (2.0, 0.5, 2.6)).mesh("screen", Diffuse((0.1, 0.1, 0.9)))
    scene = Scene("two", (MIRROR, other, *([thing] if behind == "thing" else []), screen), CAMERA)
    truth = drawn(scene, "raytrace:truth=raymesh,bounces=1")
    frame = drawn(scene, "threeray:background=map,near=0.8,bounces=1,spacing=0.2")
    both = (truth.specular == 1) & (frame.specular == 1)
    on_screen, beyond = (both & (truth.object_id == number) for number in (len(scene.meshes), len(scene.meshes) - 1))
    assert on_screen.sum() > 500 < beyond.sum()
    assert (frame.object_id[on_screen] == len(scene.meshes)).mean() > 0.97
    assert (frame.status[on_screen] == Status.WARPED).mean() > 0.97
    # At its edge the screen is off by what the map is.
    assert (frame.object_id[beyond] == len(scene.meshes) - 1).mean() > 0.85


def test_of_a_mirror_that_is_not_seen_everything_is_near():
    camera = mesh_cameras(pinhole(CAMERA, SIZE), 1, (0.0, 0.0))
    middles = np.array([CAMERA.position, [0.0, 0.0, 5.0]])
    found = least_distances(camera, np.arange(len(camera.item)), middles, np.zeros(1, np.int64))
    assert found[0] < 1e-9 and found[1] == np.inf


def test_what_moves_is_seen_where_it_is():
    scene = scene_with(MIRROR)
    scene = replace(scene, meshes=tuple(mesh for mesh in scene.meshes if mesh.name != "floor"))
    session = open_view(scene, "threeray:background=map,near=0.001")
    session.draw(scene.camera)
    geometry = flatten(scene)
    places = geometry.positions + np.where(geometry.vertex_object[:, None] > 1, np.float32([0.1, 0.0, 0.05]), 0.0)
    session.deform(places.astype(np.float32), geometry.normals)
    session.draw(scene.camera)
    meshes = [
        replace(mesh, positions=part)
        for mesh, part in zip(scene.meshes, np.split(places, geometry.first_vertex[1:-1]), strict=True)
    ]
    again = drawn(replace(scene, meshes=tuple(meshes)), "threeray:background=map,near=0.001")
    assert np.abs(session.frame().color - again.color).max() < 1e-3


def test_near_without_a_map_is_refused():
    with pytest.raises(AnamorphError, match="near is for a map behind; leave it out, or give background=map"):
        drawn(scene_with(MIRROR), "threeray:near=2")
