"""Frames of virtual objects against traced ones: what is said to be proved is what the pixel's own ray meets."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import CAMERA, drawn, flat_mirror, open_view, plane_mirror, scene_with, spherical_mirror, surroundings

from anamorph.frame import Frame, Status
from anamorph.gallery import make
from anamorph.gallery.solids import box
from anamorph.gallery.spheres import mirror_ball
from anamorph.methods.virtual import meeting_rays
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Diffuse, Scene, Sky

MIRRORS = {
    "flat": flat_mirror(),
    "convex": spherical_mirror(count=4),
    "concave": spherical_mirror(-1.4, count=4),
    "strongly concave": spherical_mirror(-0.3, count=5),
    "coarse": spherical_mirror(count=1),
    "ball": mirror_ball("ball", (0.0, 0.5, 0.0), 0.15, rows=12, columns=18),
    "plain": replace(spherical_mirror(count=3), surface=None, parameters=None),
}


def check(reference: Frame, frame: Frame, found: float = 0.5) -> None:
    """Every pixel shows what it shows in the reference, but for a few at edges; and so many are found, not traced."""
    specular = reference.specular > 0
    assert specular.sum() > 500 and (frame.specular == reference.specular).mean() > 0.9998
    both = specular & (frame.specular > 0)
    assert (frame.object_id == reference.object_id)[both].mean() > 0.9995
    assert (np.abs(frame.color - reference.color).max(axis=-1) < 0.01)[both].mean() > 0.997
    proved = np.isin(frame.status[both], [Status.PROVED, Status.SKY])
    assert proved.mean() >= found
    traced = np.isin(frame.status[both], [Status.TRACED, Status.TOTAL_REFLECTION, Status.OUTSIDE])
    assert (proved | traced).mean() > 0.999


@pytest.mark.parametrize("name", MIRRORS)
def test_a_mirror_shows_what_its_own_rays_meet(name):
    scene = scene_with(MIRRORS[name])
    check(drawn(scene, "raytrace"), drawn(scene, "virtual"), found=0.0 if name == "ball" else 0.9)


def test_a_wall_of_two_triangles_has_its_curved_edges():
    wall = plane_mirror("wall", (-3.0, -1.0, 2.5), (0.0, 3.0, 0.0), (3.4, 0.0, 0.3))
    wall = replace(wall, material=Diffuse((0.9, 0.8, 0.1)), surface=None, parameters=None)
    scene = Scene("wall", (mirror_ball("ball", (0.0, 0.5, 0.0), 0.15), wall), CAMERA, sky=Sky())
    reference, frame = drawn(scene, "raytrace", (320, 240)), drawn(scene, "virtual", (320, 240))
    check(reference, frame, found=1.0)
    assert (frame.object_id == 2)[frame.specular == 1].mean() > 0.05
    both = (frame.object_id == 2) & (reference.object_id == 2) & (frame.specular == 1)
    assert np.linalg.norm(frame.position - reference.position, axis=-1)[both].max() < 1e-3


@pytest.mark.parametrize("name", ["room", "torus", "curvature-series", "spheres", "car-mirror", "saddle"])
def test_built_in_scenes_are_those_that_are_traced(name):
    scene, size = make(name), (320, 240)
    check(drawn(scene, "raytrace", size), drawn(scene, "virtual", size), found=0.1)


@pytest.mark.parametrize("name", ["spectacles-minus", "magnifier"])
def test_lenses_send_each_color_its_own_way(name):
    scene = make(name)
    check(drawn(scene, "raytrace"), drawn(scene, "virtual"), found=0.2)


def test_of_a_tile_that_may_see_too_much_each_ray_is_traced(monkeypatch):
    monkeypatch.setattr(meeting_rays, "MOST", 0)
    scene = scene_with(spherical_mirror(count=4))
    reference, frame = drawn(scene, "raytrace"), drawn(scene, "virtual")
    check(reference, frame, found=0.0)
    assert (frame.status[(reference.specular > 0) & (reference.object_id > 0)] == Status.TRACED).all()


def test_paths_go_on_from_mirror_to_mirror():
    scene = make("facing-mirrors")
    frame = drawn(scene, "virtual")
    check(drawn(scene, "raytrace"), frame)
    assert (frame.status == Status.TRACED).sum() > 50
    check(drawn(scene, "raytrace:bounces=1"), drawn(scene, "virtual:bounces=1"), found=0.0)


def test_what_stands_before_a_mirror_hides_it():
    post = box((-0.02, 0.2, 0.25), (0.04, 0.55, 0.3)).mesh("post", Diffuse(color=(0.9, 0.1, 0.1)))
    scene = Scene("post", (spherical_mirror(count=4), *surroundings(), post), CAMERA, sky=Sky())
    check(drawn(scene, "raytrace"), drawn(scene, "virtual"))


def test_four_samples_a_pixel_are_those_of_traced_rays():
    scene = scene_with(spherical_mirror(count=4))
    traced, found = (drawn(scene, f"{method}:antialias=4").color for method in ("raytrace", "virtual"))
    assert (np.abs(traced - found).max(axis=-1) > 0.01).mean() < 1e-3


@pytest.mark.parametrize("moves", [(2,), (3, 4), (2, 3, 4, 5, 6, 7)])
def test_a_scene_that_deforms_is_seen_where_it_is(moves):
    scene = scene_with(spherical_mirror(count=4))
    geometry = flatten(scene)
    session = open_view(scene, "virtual")
    others = replace(CAMERA, position=(0.3, 0.6, 0.95))
    # First some objects move, then one of these only, and the eye between.
    for moving, offset, camera in [
        (moves, (0.2, 0.1, 0.15), CAMERA),
        (moves[:1], (0.3, -0.1, 0.1), CAMERA),
        (moves[:1], (0.3, 0.2, 0.1), others),
        ((7,), (0.0, 0.1, 0.1), others),
    ]:
        session.draw(camera)
        own = np.isin(geometry.vertex_object, moving)[:, None]
        session.deform(geometry.positions + np.where(own, np.float32(offset), np.float32(0.0)), geometry.normals)
        session.draw(camera)
        meshes = [
            replace(mesh, positions=mesh.positions + np.float32(offset)) if number in moving else mesh
            for number, mesh in enumerate(scene.meshes, start=1)
        ]
        check(drawn(replace(scene, meshes=tuple(meshes), camera=camera), "raytrace"), session.frame(seen=True))


def test_of_a_scene_in_which_one_object_moves_only_that_is_asked_for():
    scene = scene_with(spherical_mirror(count=4))
    geometry = flatten(scene)
    session = open_view(scene, "virtual")
    session.draw(CAMERA)
    whole = session.frame(seen=True).figures["asked"]
    for height in (0.1, 0.2):
        own = (geometry.vertex_object == 3)[:, None]
        session.deform(
            geometry.positions + np.where(own, np.float32([0, height, 0]), np.float32(0.0)), geometry.normals
        )
        session.draw(CAMERA)
        assert 0 < session.frame(seen=True).figures["asked"] < 0.2 * whole


def test_the_same_view_gives_the_same_frame():
    scene = scene_with(spherical_mirror(-0.5, count=5))
    one, other = (drawn(scene, "virtual") for _ in range(2))
    assert (one.color == other.color).all() and (one.status == other.status).all()


def test_without_mirrors_or_with_nothing_else_there_is_an_image():
    scene = Scene("plain", surroundings(), CAMERA, sky=Sky())
    assert (drawn(scene, "virtual").color == drawn(scene, "raytrace").color).all()
    frame = drawn(Scene("sky", (spherical_mirror(count=3),), CAMERA, sky=Sky()), "virtual")
    assert (frame.status[frame.specular > 0] == Status.SKY).all()
