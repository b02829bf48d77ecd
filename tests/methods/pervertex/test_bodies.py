"""Mirrors and lenses of a scene, whole: which meshes are one body, and which side of it an eye sees."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import CAMERA, CENTER, SIZE, flat_mirror, scene_with, spherical_mirror, surroundings

from anamorph import gallery
from anamorph.base.errors import AnamorphError
from anamorph.gallery.shapes import box
from anamorph.lenses.lens import Prescription, make_lens
from anamorph.methods.pervertex.bodies import bodies_of, see
from anamorph.methods.pervertex.world import world_of
from anamorph.optics.reflection import reflected_rays, reflector
from anamorph.optics.refraction import Refractor
from anamorph.raymesh import RayStatus
from anamorph.scene.camera import Camera
from anamorph.scene.connected import connected_mirrors
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Diffuse, Glass, Scene


def scene_of(*meshes):
    return Scene("test", meshes, CAMERA)


def bodies(scene):
    geometry = flatten(scene)
    return bodies_of(scene, geometry, world_of(geometry))


def part(mesh, faces, name):
    """Some faces of a mesh, with the vertices that they need."""
    vertices, corners = np.unique(mesh.faces[faces], return_inverse=True)
    return replace(
        mesh,
        name=name,
        positions=mesh.positions[vertices],
        normals=mesh.normals[vertices],
        parameters=mesh.parameters[vertices],
        faces=corners.reshape(-1, 3).astype(np.int32),
    )


@settings(max_examples=30)
@given(st.data())
def test_the_parts_of_one_surface_are_one_body_in_any_order(data):
    """Strips of a mirror, and of another that stands apart, among matt meshes."""
    count = data.draw(st.integers(2, 5))
    mirrors = [
        spherical_mirror(),
        replace(spherical_mirror(), positions=spherical_mirror().positions + np.float32(1.0)),
    ]
    strips = {
        (number, strip): part(mirror, faces, f"{number}-{strip}")
        for number, mirror in enumerate(mirrors)
        for strip, faces in enumerate(np.array_split(np.arange(len(mirror.faces)), count))
    }
    matt = {("matt", number): mesh for number, mesh in enumerate(surroundings()[:3])}
    order = data.draw(st.permutations([*strips, *matt]))
    found = connected_mirrors(scene_of(*({**strips, **matt}[key] for key in order)))
    assert sorted(found) == sorted(
        tuple(place for place, key in enumerate(order) if key[0] == number) for number in (0, 1)
    )


def triangle(*corners, name=None):
    return replace(
        flat_mirror(),
        name=name or str(corners),
        positions=np.array(corners, np.float32),
        normals=np.tile(np.float32([0, 0, 1]), (len(corners), 1)),
        faces=np.array([[0, 1, 2]] if len(corners) == 3 else [[0, 1, 2], [3, 2, 1]], np.int32),
        surface=None,
        parameters=None,
    )


def test_meshes_that_share_one_point_alone_are_two_bodies():
    """An edge is two; a place that one mesh has twice is one."""
    first = triangle((0, 0, 0), (1, 0, 0), (0, 1, 0))
    touching = triangle((1, 0, 0), (2, 0, 0), (1, -1, 0))
    joined = triangle((1, 0, 0), (1, 1, 0), (0, 1, 0))
    twice = triangle((1, 0, 0), (1, 0, 0), (2, 0, 0), (3, 1, 0))
    assert connected_mirrors(scene_of(first, touching)) == [(0,), (1,)]
    assert connected_mirrors(scene_of(first, twice)) == [(0,), (1,)]
    assert connected_mirrors(scene_of(first, joined)) == [(0, 1)]
    # By way of a third.
    assert connected_mirrors(scene_of(touching, joined, first, replace(flat_mirror()))) == [(0,), (1, 2), (3,)]


def test_matt_meshes_join_nothing():
    first = triangle((0, 0, 0), (1, 0, 0), (0, 1, 0))
    between = replace(triangle((1, 0, 0), (1, 1, 0), (0, 1, 0)), material=Diffuse())
    last = triangle((1, 0, 0), (2, 0, 0), (1, 1, 0))
    assert connected_mirrors(scene_of(first, between, last)) == [(0,), (2,)]
    assert connected_mirrors(scene_of(between)) == []


def test_meshes_of_one_name_that_touch_are_one_body():
    first = triangle((0, 0, 0), (1, 0, 0), (0, 1, 0), name="pot/body")
    spout = triangle((0.5, 0.2, 0), (2, 0.2, 0), (2, 0.5, 0), name="pot/spout")
    beside = triangle((5, 0, 0), (6, 0, 0), (6, 1, 0), name="pot/other")
    other = replace(spout, name="pan/spout")
    assert connected_mirrors(scene_of(first, spout, beside)) == [(0, 1), (2,)]
    assert connected_mirrors(scene_of(first, other)) == [(0,), (1,)]


def test_the_teapot_is_one_body():
    scene = gallery.make("room")
    assert connected_mirrors(scene) == [tuple(i for i, mesh in enumerate(scene.meshes) if mesh.specular)]


def test_a_body_of_parts_has_the_rays_of_the_whole():
    whole = spherical_mirror()
    parts = [part(whole, faces, f"part-{faces[0]}") for faces in np.array_split(np.arange(len(whole.faces)), 3)]
    plain = replace(parts[1], surface=None, parameters=None)
    scene = scene_of(parts[0], *surroundings(), plain, parts[2])
    (body,) = bodies(scene)
    last = len(scene.meshes) - 1
    assert body.meshes == (0, last - 1, last)
    (side,) = body.sides
    sight = see(body, CAMERA.eye(SIZE))
    assert sight.side is side and not sight.bends and sight.others == ()
    geometry = flatten(scene)
    # Each face of the body is the scene's triangle of that number.
    corners = geometry.positions[geometry.faces[side.triangles]]
    assert corners == pytest.approx(sight.rays.origins[sight.rays.faces], abs=1e-6)
    assert side.smooth.tolist() == [True] * len(parts[0].faces) + [False] * len(plain.faces) + [True] * len(
        parts[2].faces
    )
    alone = [reflected_rays(reflector(mesh), CAMERA.eye(SIZE)) for mesh in (parts[0], plain, parts[2])]
    assert sight.rays.directions.tolist() == np.concatenate([each.directions for each in alone]).tolist()
    assert sight.outward.tolist() == side.optics.normals.tolist()


def test_a_mirror_knows_what_stands_behind_it():
    scene = scene_of(flat_mirror(), box((-1.0, 0.0, -0.5), (1.0, 1.0, -0.2)).mesh("block", Diffuse()))
    (body,) = bodies(scene)
    assert body.sides[0].behind == pytest.approx([0.2] * 4)


@cache
def lens_scene(abbe=None):
    lens = make_lens(Prescription(-2.0), tuple(CENTER.tolist()), (0.0, 0.0, 1.0), name="lens", vertices=60)
    glass = (
        replace(mesh, material=replace(mesh.material, abbe=abbe)) if isinstance(mesh.material, Glass) else mesh
        for mesh in lens.meshes
    )
    return scene_with(*glass)


DIRECTIONS = st.floats(-1.2, 1.2).flatmap(lambda turn: st.tuples(st.just(turn), st.sampled_from([1.0, -1.0])))


@settings(max_examples=25)
@given(DIRECTIONS, st.sampled_from([0.05, 0.5, 1e4]), st.sampled_from(["from", "towards", "parallel"]))
def test_a_lens_is_seen_by_the_face_that_the_lines_of_sight_meet(direction, distance, kind):
    (body,) = bodies(lens_scene())
    turn, side = direction
    away = np.array([np.sin(turn), 0.0, side * np.cos(turn)])
    camera = Camera(tuple((CENTER + distance * away).tolist()), tuple(CENTER.tolist()))
    eye = camera.eye(SIZE)
    if kind == "parallel":
        eye = replace(eye, point=np.append(away, 0.0))
    elif kind == "towards":
        # Lines that run towards a point on the far side come from this one.
        eye = replace(eye, point=-1e-3 * np.append(CENTER - distance * away, 1.0))
    sight = see(body, eye)
    scene = lens_scene()
    face = scene.meshes[sight.side.meshes[0]]
    assert face.name == ("lens/front" if side > 0.0 else "lens/back")
    assert sight.bends and isinstance(sight.side.optics, Refractor)
    # Rays go on, through the lens and away from the eye.
    through = sight.rays.directions[sight.rays.status == RayStatus.OK] @ -away
    assert (through > 0.0).all()
    assert sight.outward @ away == pytest.approx(np.full(len(sight.outward), -np.cos(turn)))


def test_a_lens_is_one_body_of_two_sides_with_its_edge():
    scene = lens_scene()
    (body,) = bodies(scene)
    names = {mesh.name: number for number, mesh in enumerate(scene.meshes)}
    assert body.meshes == (names["lens/front"], names["lens/back"])
    assert [side.meshes for side in body.sides] == [(names["lens/front"],), (names["lens/back"],)]
    assert {side.edge for side in body.sides} == {names["lens/edge"] + 1}
    sight = see(body, CAMERA.eye(SIZE))
    middle, axis = sight.edge()
    assert middle[3] == names["lens/edge"] + 1
    assert axis[3] == pytest.approx(sight.side.optics.radius)
    assert axis[:3] == pytest.approx([0.0, 0.0, -1.0], abs=1e-9)


@pytest.mark.parametrize(("abbe", "colors"), [(None, 1), (40.0, 3)])
def test_a_lens_hands_on_the_rays_of_each_colour(abbe, colors):
    (body,) = bodies(lens_scene(abbe))
    sight = see(body, CAMERA.eye(SIZE))
    status = np.resize([RayStatus.TOTAL_REFLECTION, RayStatus.LEFT_BY_EDGE, RayStatus.OK], len(sight.rays.status))
    sight = replace(sight, rays=replace(sight.rays, status=status))
    faces = np.array([3, 1, 4])
    rays = sight.corner_rays(faces)
    assert rays.shape == (3, 3, colors, 2, 4)
    for number, each in enumerate((sight.rays, *sight.others)):
        corners = each.faces[faces]
        assert rays[:, :, number, 0, :3].tolist() == each.origins[corners].tolist()
        assert rays[:, :, number, 0, 3].tolist() == each.share[corners].tolist()
        assert rays[:, :, number, 1, :3].tolist() == each.directions[corners].tolist()
        assert (rays[:, :, number, 1, 3] == (each.status[corners] == RayStatus.TOTAL_REFLECTION)).all()
    assert len(see(body, CAMERA.eye(SIZE), dispersion=False).others) == 0


def test_glass_that_is_no_face_of_a_lens_is_refused_in_one_line():
    ball = replace(spherical_mirror(0.3), name="pebble", material=Glass(1.5))
    with pytest.raises(AnamorphError, match=r"'pebble'.*no face of a lens.*raytrace") as caught:
        bodies(scene_of(ball, *surroundings()))
    assert "\n" not in str(caught.value)


def test_a_scene_without_mirrors_has_no_bodies():
    assert bodies(scene_of(*surroundings())) == ()
