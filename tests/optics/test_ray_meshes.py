"""The maker of ray meshes: the bodies of a scene, the side of each that an eye sees, and the rays that leave it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import CAMERA, CENTER, SIZE, flat_mirror, part_of_mesh, scene_with, spherical_mirror, surroundings

from anamorph import gallery
from anamorph.base.errors import AnamorphError
from anamorph.lenses.making import make_lens
from anamorph.lenses.prescription import Prescription
from anamorph.optics.ray_meshes import bodies_of, rays_of, side_rays
from anamorph.optics.reflection import reflected_rays, reflector
from anamorph.optics.refraction import Refractor
from anamorph.raymesh import RayStatus
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Glass, Scene


def scene_of(*meshes):
    return Scene("test", meshes, CAMERA)


def bodies(scene):
    return bodies_of(scene, flatten(scene))


def test_a_body_of_parts_has_the_rays_of_the_whole():
    whole = spherical_mirror()
    parts = [part_of_mesh(whole, faces, f"part-{faces[0]}") for faces in np.array_split(np.arange(len(whole.faces)), 3)]
    plain = replace(parts[1], surface=None, parameters=None)
    scene = scene_of(parts[0], *surroundings(), plain, parts[2])
    (body,) = bodies(scene)
    last = len(scene.meshes) - 1
    assert body.meshes == (0, last - 1, last)
    (side,) = body.sides
    body_rays = rays_of(body, CAMERA.eye(SIZE))
    assert body_rays.side is side and not side.refracts and body_rays.others == ()
    geometry = flatten(scene)
    # Each face of the body is the scene's triangle of that number.
    corners = geometry.positions[geometry.faces[side.triangles]]
    assert corners == pytest.approx(body_rays.rays.origins[body_rays.rays.faces], abs=1e-6)
    assert side.smooth.tolist() == [True] * len(parts[0].faces) + [False] * len(plain.faces) + [True] * len(
        parts[2].faces
    )
    alone = [reflected_rays(reflector(mesh), CAMERA.eye(SIZE)) for mesh in (parts[0], plain, parts[2])]
    assert body_rays.rays.directions.tolist() == np.concatenate([each.directions for each in alone]).tolist()
    assert body_rays.side.outward.tolist() == side.optics.normals.tolist()


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
    body_rays = rays_of(body, eye)
    scene = lens_scene()
    face = scene.meshes[body_rays.side.meshes[0]]
    assert face.name == ("lens/front" if side > 0.0 else "lens/back")
    assert body_rays.side.refracts and isinstance(body_rays.side.optics, Refractor)
    # Rays go on, through the lens and away from the eye.
    through = body_rays.rays.directions[body_rays.rays.status == RayStatus.OK] @ -away
    assert (through > 0.0).all()
    assert body_rays.side.outward @ away == pytest.approx(np.full(len(body_rays.side.outward), -np.cos(turn)))


def test_a_lens_is_one_body_of_two_sides_with_its_edge():
    scene = lens_scene()
    (body,) = bodies(scene)
    names = {mesh.name: number for number, mesh in enumerate(scene.meshes)}
    assert body.meshes == (names["lens/front"], names["lens/back"])
    assert [side.meshes for side in body.sides] == [(names["lens/front"],), (names["lens/back"],)]
    assert {side.edge for side in body.sides} == {names["lens/edge"] + 1}
    body_rays = rays_of(body, CAMERA.eye(SIZE))
    middle, axis = body_rays.side.lens_edge()
    assert middle[3] == names["lens/edge"] + 1
    assert axis[3] == pytest.approx(body_rays.side.optics.radius)
    assert axis[:3] == pytest.approx([0.0, 0.0, -1.0], abs=1e-9)


def test_glass_that_is_no_face_of_a_lens_is_refused_in_one_line():
    ball = replace(spherical_mirror(0.3), name="pebble", material=Glass(1.5))
    with pytest.raises(AnamorphError, match=r"'pebble'.*no face of a lens.*raytrace") as caught:
        bodies(scene_of(ball, *surroundings()))
    assert "\n" not in str(caught.value)


def test_a_scene_without_mirrors_has_no_bodies():
    assert bodies(scene_of(*surroundings())) == ()


EYES = st.tuples(st.floats(-1.0, 1.0), st.floats(-0.5, 1.5), st.floats(0.3, 3.0))


@given(EYES)
def test_all_rays_of_a_flat_mirror_come_from_the_mirrored_eye(position):
    (body,) = bodies(scene_of(flat_mirror()))
    rays = rays_of(body, Camera(position, tuple(CENTER.tolist())).eye(SIZE)).rays
    image = np.array(position) * [1.0, 1.0, -1.0]
    assert rays.directions == pytest.approx(rays.origins - image, abs=1e-6)
    assert rays.origins == pytest.approx(flat_mirror().positions, abs=1e-7)


@given(EYES, st.sampled_from([1.4, 0.3, -0.5]))
def test_the_radius_of_a_sphere_halves_the_angle_between_the_eye_and_the_ray(position, radius):
    mirror = spherical_mirror(radius)
    (body,) = bodies(scene_of(mirror))
    rays = rays_of(body, Camera(position, tuple(CENTER.tolist())).eye(SIZE)).rays
    toward, away = position - rays.origins, rays.directions
    lengths = np.linalg.norm(toward, axis=1)
    assert np.linalg.norm(away, axis=1) == pytest.approx(lengths)
    outward = np.sign(radius) * (rays.origins - mirror.surface.center) / abs(radius)
    assert toward + away == pytest.approx(2.0 * np.sum(toward * outward, axis=1, keepdims=True) * outward, abs=1e-9)
    assert ((rays.status == RayStatus.OK) == (np.sum(toward * outward, axis=1) > 0.0)).all()


@pytest.mark.parametrize("name", sorted(gallery.SCENES))
def test_every_specular_triangle_belongs_to_one_side_of_one_body(name):
    scene = gallery.make(name)
    geometry = flatten(scene)
    found = bodies_of(scene, geometry)
    sides = [side for body in found for side in body.sides]
    specular = np.array([mesh.specular for mesh in scene.meshes])[geometry.face_object - 1]
    uses = np.bincount(np.concatenate([side.triangles for side in sides]), minlength=len(geometry.faces))
    assert uses.tolist() == specular.astype(int).tolist()
    for body in found:
        assert sorted(body.meshes) == sorted(mesh for side in body.sides for mesh in side.meshes)
        assert len(body.sides) == (2 if body.sides[0].refracts else 1)
    for side in sides:
        assert (side.vertices[side.optics.faces] == geometry.faces[side.triangles]).all()
        assert side.optics.positions == pytest.approx(geometry.positions[side.vertices], abs=1e-5)
        assert set(geometry.face_object[side.triangles].tolist()) == set(side.objects)


@pytest.mark.parametrize("name", sorted(gallery.SCENES))
def test_colours_part_only_where_glass_disperses(name):
    scene = gallery.make(name)
    eye = scene.camera.eye(SIZE)
    for body in bodies(scene):
        seen = rays_of(body, eye)
        materials = [scene.meshes[mesh].material for mesh in body.meshes]
        disperses = any(isinstance(each, Glass) and each.abbe is not None for each in materials)
        lines = red, green, blue = [side_rays(seen.side, eye, line).directions for line in (0, 1, 2)]
        assert np.array_equal(seen.rays.directions, green)
        if disperses:
            assert [rays.directions.tolist() for rays in seen.others] == [red.tolist(), blue.tolist()]
            assert not np.array_equal(red, green) and not np.array_equal(blue, green)
        else:
            assert seen.others == () and all(np.array_equal(each, green) for each in lines)
        alone = rays_of(body, eye, dispersion=False)
        assert alone.others == () and np.array_equal(alone.rays.directions, green)
