"""Sessions of `trilinear`: what moves, what is drawn twice, and scenes and ray meshes with little to see."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import CAMERA, SIZE, drawn, flat_mirror, open_view, scene_with, spherical_mirror

from anamorph import cameras
from anamorph.frame import Frame, Status, View
from anamorph.gallery import make
from anamorph.gallery.cube import CAMERA as CUBE_CAMERA
from anamorph.gallery.cube import cube_scene
from anamorph.gallery.flat_mirror import plane_mirror
from anamorph.methods import Session, Specification
from anamorph.raymesh import RayMesh
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Scene

BUFFERS = ("color", "position", "object_id", "specular", "status")
ELSEWHERE = Camera(position=(-0.3, 0.6, 0.8), target=(0.0, 0.5, 0.0), field_of_view=32.0)


def assert_same(one: Frame, other: Frame) -> None:
    for name in BUFFERS:
        assert (getattr(one, name) == getattr(other, name)).all(), name


def again(session: Session, camera: Camera | RayMesh, shift=(0.0, 0.0)) -> Frame:
    session.draw(camera, shift)
    return session.frame(seen=True)


def waved(scene: Scene, time: float) -> Scene:
    """All that is no mirror, swaying."""
    meshes = []
    for mesh in scene.meshes:
        if not mesh.specular:
            sway = 0.15 * np.sin(3.0 * mesh.positions[:, 1:2] + time) * np.float32([1.0, 0.3, 0.5])
            mesh = replace(mesh, positions=(mesh.positions + sway).astype(np.float32))
        meshes.append(mesh)
    return replace(scene, meshes=tuple(meshes))


@pytest.mark.parametrize("method", ["trilinear", "trilinear:edges=straight", "trilinear:antialias=4"])
def test_a_scene_that_moves_is_drawn_as_if_anew(method):
    scene = scene_with(spherical_mirror())
    session = open_view(scene, method)
    before = again(session, CAMERA)
    for time in (0.5, 2.0, 40.0):
        moved = waved(scene, time)
        geometry = flatten(moved)
        session.deform(geometry.positions, geometry.normals)
        frame, fresh = again(session, CAMERA), drawn(moved, method)
        assert (frame.object_id != before.object_id).sum() > 50
        # In another tree the triangles have another order, by which nothing but ties is decided.
        assert (frame.object_id != fresh.object_id).sum() <= 2
        assert (frame.status != fresh.status).sum() <= 2
        assert np.percentile(np.abs(frame.color - fresh.color), 99.9) <= 1e-3
    geometry = flatten(scene)
    session.deform(geometry.positions, geometry.normals)
    assert (again(session, CAMERA).object_id == before.object_id).all()


def test_a_deformed_scene_is_followed_through_a_ray_mesh_as_well():
    scene, camera = cube_scene(), cameras.pinhole(CUBE_CAMERA, SIZE)
    session = Specification.parse("trilinear").open(View(scene, camera, SIZE))
    again(session, camera)
    moved = waved(scene, 1.0)
    geometry = flatten(moved)
    session.deform(geometry.positions, geometry.normals)
    frame = again(session, camera)
    fresh = again(Specification.parse("trilinear").open(View(moved, camera, SIZE)), camera)
    assert (frame.object_id != fresh.object_id).sum() <= 2
    assert np.abs(frame.position - fresh.position).max() <= 1e-3


@pytest.mark.parametrize("method", ["trilinear", "trilinear:edges=straight", "trilinear:antialias=4"])
def test_an_eye_that_moves_and_comes_back_sees_the_same(method):
    scene = scene_with(spherical_mirror())
    session = open_view(scene, method)
    first, away = again(session, CAMERA), again(session, ELSEWHERE)
    # Borders are as fine as the camera of the view asks for, so that the other session has the same view.
    assert_same(away, again(open_view(scene, method), ELSEWHERE))
    shifted = again(session, CAMERA, (0.3, 0.2))
    assert (shifted.color != first.color).any()
    assert_same(again(session, CAMERA), first)
    assert_same(again(session, CAMERA), first)


def test_an_eye_that_turns_from_mirrors_in_mirrors_leaves_none_behind():
    scene = make("facing-mirrors")
    session = open_view(scene, "trilinear:bounces=3")
    again(session, scene.camera)
    away = Camera(scene.camera.position, (2.0, 1.4, 0.9), field_of_view=30.0)
    assert_same(again(session, away), drawn(scene, "trilinear:bounces=3", camera=away))
    assert_same(again(session, scene.camera), drawn(scene, "trilinear:bounces=3"))


def test_ray_meshes_may_change_from_frame_to_frame():
    scene = cube_scene()
    meshes = [cameras.pinhole(CUBE_CAMERA, SIZE), cameras.detail_and_context(CUBE_CAMERA, SIZE)]
    session = Specification.parse("trilinear").open(View(scene, meshes[0], SIZE))
    frames = [again(session, mesh) for mesh in (*meshes, *meshes)]
    assert_same(frames[0], frames[2])
    assert_same(frames[1], frames[3])
    assert (frames[0].color != frames[1].color).any()


def test_without_mirrors_the_plain_scene_is_drawn():
    scene = scene_with()
    for method in ("trilinear", "trilinear:edges=straight"):
        assert_same(drawn(scene, method), drawn(scene, "pervertex"))
    smooth, others = drawn(scene, "trilinear:antialias=4"), drawn(scene, "pervertex:antialias=4")
    assert (smooth.color == others.color).all()


def test_mirrors_behind_the_eye_or_turned_away_are_as_if_not_there():
    behind = plane_mirror("mirror", (-1.0, -0.5, 4.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0))
    scene = scene_with(behind)
    frame, plain = drawn(scene, "trilinear"), drawn(scene_with(), "pervertex")
    assert not frame.specular.any() and (frame.color == plain.color).all()
    backward = Camera(position=(0.02, 0.5, -1.0), target=(0.0, 0.5, 0.0), field_of_view=32.0)
    for mirror in (flat_mirror(), spherical_mirror()):
        turned = scene_with(mirror, camera=backward)
        frame, reference = (drawn(turned, method) for method in ("trilinear", "raytrace"))
        assert not frame.specular.any()
        # The diffuse back of a mirror is seen.
        assert (frame.object_id == reference.object_id).all() and (frame.object_id == 1).sum() > 100


def test_ray_meshes_without_triangles_in_the_image_see_nothing():
    scene, whole = cube_scene(), cameras.pinhole(CUBE_CAMERA, SIZE)
    empty = {
        "no triangle": replace(whole, faces=whole.faces[:0]),
        "beside the image": replace(whole, image=whole.image + np.array([500.0, 0.0, 0.0])),
        "of no area": replace(whole, image=whole.image * [1.0, 0.0, 1.0] + [0.0, 20.3, 0.0]),
        "no direction": replace(whole, directions=np.zeros_like(whole.directions)),
    }
    for name, camera in empty.items():
        for specification in ("", "edges=straight", "antialias=4"):
            chosen = Specification.parse(f"trilinear:{specification}")
            frame = again(chosen.open(View(scene, camera, SIZE)), camera)
            assert (frame.status == Status.OUTSIDE).all(), name
            assert not frame.color.any() and not frame.object_id.any() and np.isfinite(frame.position).all(), name
    session = Specification.parse("trilinear").open(View(scene, whole, SIZE))
    first = again(session, whole)
    again(session, empty["no triangle"])
    assert_same(again(session, whole), first)


def test_single_rays_of_no_direction_leave_the_others_alone():
    """Where one corner of a triangle has no direction, the others decide; where none has, there is no ray."""
    scene, whole = cube_scene(), cameras.detail_and_context(CUBE_CAMERA, SIZE)
    directions = whole.directions.copy()
    silenced = whole.faces[len(whole.faces) // 2]
    directions[silenced] = 0.0
    camera = replace(whole, directions=directions)
    reference, frame, before = (
        again(Specification.parse(method).open(View(scene, mesh, SIZE)), mesh)
        for method, mesh in (("raytrace", camera), ("trilinear", camera), ("trilinear", whole))
    )
    assert np.isfinite(frame.color).all() and np.isfinite(frame.position).all()
    nothing = reference.status == Status.OUTSIDE
    assert nothing.sum() > 20
    assert ((frame.status == Status.OUTSIDE) == nothing).mean() > 0.998
    assert (frame.object_id == reference.object_id).mean() > 0.995
    unchanged = (reference.position == again_of(scene, whole).position).all(axis=-1)
    assert unchanged.any() and (frame.color == before.color)[unchanged].all(axis=-1).mean() > 0.99


def again_of(scene: Scene, camera: RayMesh) -> Frame:
    return again(Specification.parse("raytrace").open(View(scene, camera, SIZE)), camera)
