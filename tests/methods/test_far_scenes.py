"""A scene far from the origin looks as it does at the origin, in every method."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import drawn, flat_mirror, open_view, scene_with, spherical_mirror

from anamorph.cameras.panorama import panorama
from anamorph.files.opening import open_scene
from anamorph.frame import View
from anamorph.gallery import make
from anamorph.gallery.solids import box
from anamorph.methods import METHODS, Specification
from anamorph.scene.geometry import flatten
from anamorph.scene.model import AmbientLight, Diffuse, PointLight
from anamorph.scene.nearness import moved_scene, origin_of

AWAY = np.array([5040.3, -310.7, 7020.1])
SIZE = (160, 120)


def with_lamp(scene):
    return replace(scene, lights=(PointLight((0.3, 1.5, 1.0)), AmbientLight()))


def assert_alike(near, far, share=1e-3):
    """But for pixels that are on an edge to the last bit."""
    other = near.object_id != far.object_id
    assert other.mean() <= share
    met = ~other & (near.object_id > 0)
    away = np.linalg.norm(far.position - AWAY - near.position, axis=-1)[met]
    assert (away > 2e-5).mean() <= share
    assert np.median(away) < 2e-6
    assert (np.abs(near.color - far.color).max(axis=-1) > 4e-3).mean() <= 4 * share


@pytest.mark.parametrize("method", [*METHODS, "raytrace:truth=raymesh", "pervertex:tolerance=0.5"])
@pytest.mark.parametrize("mirror", [spherical_mirror(), flat_mirror()], ids=["sphere", "plane"])
def test_every_method_draws_it_as_at_the_origin(method, mirror):
    scene = with_lamp(scene_with(mirror))
    assert not origin_of(scene).any()
    far = moved_scene(scene, AWAY)
    assert_alike(drawn(scene, method, SIZE), drawn(far, method, SIZE))


@pytest.mark.parametrize("method", ["raytrace", "pervertex", "trilinear"])
def test_a_lens_far_away_refracts_as_at_the_origin(method):
    scene = make("spectacles-minus")
    assert_alike(drawn(scene, method, SIZE), drawn(moved_scene(scene, AWAY), method, SIZE))


def test_rays_are_told_in_world_coordinates():
    scene = scene_with(spherical_mirror())
    near, far = (drawn(each, "raytrace", SIZE) for each in (scene, moved_scene(scene, AWAY)))
    same = (near.object_id == far.object_id) & (near.status == far.status)
    np.testing.assert_allclose(far.ray_origin[same] - AWAY, near.ray_origin[same], atol=2e-6)
    assert np.abs(far.ray_direction - near.ray_direction)[same].max() < 1e-5


@pytest.mark.parametrize("method", ["raytrace", "trilinear"])
def test_a_ray_mesh_far_away_sees_as_at_the_origin(method):
    scene = with_lamp(scene_with(flat_mirror()))
    rays = panorama(scene.camera, (160, 80))
    frames = []
    for by in (np.zeros(3), AWAY):
        moved = moved_scene(scene, by)
        session = Specification.parse(method).open(View(moved, rays.moved(by), (160, 80)))
        for _ in range(2):
            session.draw(rays.moved(by))
        frames.append(session.frame(seen=True))
    assert_alike(*frames)


def test_the_camera_of_a_session_far_away_may_move():
    scene = with_lamp(scene_with(spherical_mirror()))
    far = moved_scene(scene, AWAY)
    eye = replace(scene.camera, position=(0.1, 0.7, 0.8))
    session = open_view(far, "raytrace", SIZE)
    session.draw(eye.moved(AWAY))
    assert_alike(drawn(replace(scene, camera=eye), "raytrace", SIZE), session.frame(seen=True))


def test_it_deforms_in_world_coordinates():
    scene = with_lamp(scene_with(spherical_mirror()))
    far = moved_scene(scene, AWAY)
    frames = []
    for each, by in ((scene, np.zeros(3)), (far, AWAY)):
        session, geometry = open_view(each, "raytrace", SIZE), flatten(scene)
        positions = geometry.positions + by
        positions[geometry.first_vertex[1] :] += [0.0, 0.05, 0.0]
        session.deform(positions, geometry.normals)
        session.draw(each.camera)
        frames.append(session.frame(seen=True))
    assert_alike(*frames)


def test_a_model_that_a_scene_file_translates_keeps_its_shape(tmp_path):
    """A cube of a centimetre, whose corners float32 would move by a twentieth of its edge."""
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    quads = ("1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4")
    text = "".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "".join(f"f {quad}\n" for quad in quads)
    (tmp_path / "cube.obj").write_text(text)
    (tmp_path / "far.toml").write_text(
        "[eye]\nposition = [8000.0, 0.0, 8000.1]\ntarget = [8000.0, 0.0, 8000.0]\n"
        '[[model]]\nfile = "cube.obj"\nscale = 0.01\ntranslate = [8000.0, 0.0, 8000.0]\n'
    )
    scene, _ = open_scene(tmp_path / "far.toml")
    cube = next(mesh for mesh in scene.meshes if "cube" in mesh.name)
    local = flatten(moved_scene(scene, -origin_of(scene)))
    assert np.ptp(cube.positions, axis=0) == pytest.approx([0.01] * 3, abs=1e-9)
    own = local.positions[local.vertex_object == 1 + scene.meshes.index(cube)]
    assert np.ptp(own, axis=0) == pytest.approx([0.01] * 3, abs=1e-7)


def test_a_mirror_on_a_large_ground_is_not_moved():
    ground = box((-5e3, -3.0, -5e3), (5e3, -2.0, 5e3)).mesh("ground", Diffuse())
    assert not origin_of(scene_with(flat_mirror(), ground)).any()
