"""Several hits of `trilinear`: what mirrors show of mirrors, against rays that the same ray meshes send on."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from lens_scenes import CAMERA as LENS_CAMERA
from lens_scenes import PLUS, lens_of, walls
from scenes import SIZE, drawn, open_view, scene_with

from anamorph import cameras
from anamorph.frame import Frame, Status, View
from anamorph.gallery import make
from anamorph.gallery.flat_mirror import plane_mirror
from anamorph.measure.errors import Errors, measure, silhouettes
from anamorph.methods import Specification
from anamorph.raymesh import RayMesh
from anamorph.scene.camera import Camera
from anamorph.scene.model import Mirror, Scene

REFERENCE = "raytrace:truth=raymesh,bounces={}"
METHOD = "trilinear:bounces={}"
SMALL = (160, 120)

BUILT_IN = {
    "car-windows": (0.01, 1.0, 0),
    "spheres": (0.05, 1.0, 0),
    "torus": (0.01, 10.0, 0),
    "room": (0.01, 40.0, 4),
}
"""Bounds on errors in pixels, 95th percentile and greatest, and how many pixels may show another object: among curved
mirrors what goes on is of second order."""


def errors_of(reference: Frame, frame: Frame) -> Errors:
    """Errors, of a frame that knows the same mirrors and the same ends of paths as the truth."""
    away = ~silhouettes(reference.object_id, reference.specular, reference.status == Status.OUTSIDE)
    assert (reference.specular == frame.specular)[away].all()
    outside = reference.status == Status.OUTSIDE
    assert ((frame.status == Status.OUTSIDE) == outside)[away].mean() > 0.999
    return measure(reference, frame)


def through(scene: Scene, camera: RayMesh, specification: str, size: tuple[int, int] = SMALL) -> Frame:
    session = Specification.parse(specification).open(View(scene, camera, size))
    session.draw(camera)
    return session.frame(seen=True)


@cache
def tunnel(specification: str) -> Frame:
    return drawn(make("facing-mirrors"), specification, SMALL)


@pytest.mark.parametrize("bounces", range(1, 7))
def test_among_flat_mirrors_every_hit_is_exact(bounces):
    reference, frame = tunnel(REFERENCE.format(bounces)), tunnel(METHOD.format(bounces))
    errors = errors_of(reference, frame)
    assert errors.pixels.p95 <= 1e-3 and errors.pixels.max <= 0.05
    assert not errors.maps.other_object.any()
    assert (
        frame.status == np.where(reference.status == Status.TRACED, Status.PROJECTED, reference.status)
    ).mean() > 0.9995
    assert errors.flip <= 0.003
    # Where a path goes on past the last of its mirrors, and there alone, it is cut off.
    assert (frame.status == Status.OUTSIDE).any()
    if bounces > 1:
        before = tunnel(METHOD.format(bounces - 1)).status == Status.OUTSIDE
        assert ((frame.status == Status.OUTSIDE) <= before).all()
        assert (frame.status == Status.OUTSIDE).sum() < 0.7 * before.sum()
        # Beside them, footprints are those of other neighbours.
        away = ~(before | silhouettes(before))
        assert away.sum() > 10000
        assert (frame.color == tunnel(METHOD.format(bounces - 1)).color)[away].all()


@pytest.mark.parametrize("name", BUILT_IN)
def test_among_curved_mirrors_the_second_hit_is_close(name):
    p95, most, others = BUILT_IN[name]
    reference, frame = (drawn(make(name), method.format(2), (320, 240)) for method in (REFERENCE, METHOD))
    errors = errors_of(reference, frame)
    assert errors.pixels.median <= 1e-3 and errors.pixels.p95 <= p95 and errors.pixels.max <= most
    assert errors.maps.other_object.sum() <= others
    once = drawn(make(name), METHOD.format(1), (320, 240))
    again = (once.status == Status.OUTSIDE) & (reference.status != Status.OUTSIDE)
    assert (frame.status[again] != Status.OUTSIDE).mean() > 0.98


@pytest.mark.parametrize("name", ["facing-mirrors", "flat-mirror", "spheres"])
@pytest.mark.parametrize("bounces", [1, 2])
def test_rays_of_a_ray_mesh_go_on_from_mirrors(name, bounces):
    scene = make(name)
    camera = cameras.pinhole(scene.camera, SMALL)
    reference, frame = (through(scene, camera, f"{method}:bounces={bounces}") for method in ("raytrace", "trilinear"))
    errors = errors_of(reference, frame)
    assert (frame.specular == reference.specular).mean() > 0.9999 and reference.specular.any()
    assert errors.pixels.p95 <= 0.03 and not errors.maps.other_object.any()
    assert errors.flip <= 0.005
    direct = reference.status == Status.DIRECT
    assert direct.any() and (frame.status[direct] == Status.PROJECTED).mean() > 0.999


def corner(tints: tuple[tuple[float, float, float], ...], reflectance: tuple[float, ...]) -> Scene:
    """Two flat mirrors at right angles, of a tint and a reflectance each, before the boxes of `scene_with`."""
    sides = (
        plane_mirror("left", (-0.3, 0.2, 0.0), (0.3, 0.0, -0.3), (0.0, 0.7, 0.0)),
        plane_mirror("right", (0.0, 0.2, -0.3), (0.3, 0.0, 0.3), (0.0, 0.7, 0.0)),
    )
    return scene_with(
        *(
            replace(side, material=Mirror(tint=tint, reflectance=share))
            for side, tint, share in zip(sides, tints, reflectance, strict=True)
        ),
        camera=Camera(position=(0.04, 0.65, 0.9), target=(0.0, 0.5, 0.0), field_of_view=40.0),
    )


def test_tints_multiply_along_the_path():
    white = corner(2 * ((1.0, 1.0, 1.0),), (1.0, 1.0))
    tinted = corner(((0.9, 0.4, 0.2), (0.3, 0.8, 0.7)), (0.9, 0.8))
    clear, frame, reference = drawn(white, "trilinear"), drawn(tinted, "trilinear"), drawn(tinted, REFERENCE.format(2))
    once = drawn(tinted, "trilinear:bounces=1")
    twice = (once.status == Status.OUTSIDE) & (frame.status != Status.OUTSIDE)
    assert twice.sum() > 1000
    # Twice at 45 degrees in all: what of the light the mirrors send on hardly depends on the angle.
    inner = twice & ~silhouettes(reference.object_id, reference.specular, twice)
    assert np.abs(frame.color - reference.color)[inner].max() <= 0.02
    share = np.prod([[0.9, 0.4, 0.2], [0.3, 0.8, 0.7]], axis=0) * 0.72
    found = np.median((frame.color / np.maximum(clear.color, 1e-6))[inner], axis=0)
    assert found == pytest.approx(share, rel=0.2)
    single = (once.specular > 0) & (once.status == Status.PROJECTED)
    assert (frame.color == once.color)[single].all()


def test_one_bounce_too_few_or_a_lens_is_where_a_path_is_cut_off():
    lens = lens_of(PLUS)
    behind = plane_mirror("mirror", (-0.5, 0.2, 0.3), (1.0, 0.0, 0.0), (0.0, 0.7, 0.0))
    camera = replace(LENS_CAMERA, position=(0.12, 0.55, 0.62), target=(0.0, 0.5, 0.3))
    lens_alone = Scene("lens", (*lens.meshes, *walls()), LENS_CAMERA)
    scene = replace(lens_alone, meshes=(behind, *lens_alone.meshes), camera=camera)
    frame = drawn(scene, "trilinear")
    reference = drawn(scene, "raytrace:truth=raymesh,bounces=1")
    in_mirror = (frame.specular == 1) & ~silhouettes(
        reference.object_id, reference.specular, reference.status == Status.OUTSIDE
    )
    cut = reference.status == Status.OUTSIDE
    assert (cut & in_mirror).sum() > 50 and (~cut & in_mirror).sum() > 1000
    assert (frame.status == Status.OUTSIDE)[cut & in_mirror].all()
    assert (frame.status == Status.PROJECTED)[~cut & in_mirror].all()


def test_mirrors_seen_through_a_lens_go_on():
    mirror = plane_mirror("mirror", (-0.6, 0.0, -0.3), (1.2, 0.0, 0.2), (0.0, 1.0, 0.0))
    lens = lens_of(PLUS)
    scene = Scene("lens", (*lens.meshes, mirror, *walls()), LENS_CAMERA)
    reference, frame = (drawn(scene, method.format(3), SIZE) for method in (REFERENCE, METHOD))
    errors = errors_of(reference, frame)
    assert errors.pixels.p95 <= 0.5
    lens_pixels = (reference.specular > 0) & (reference.specular <= 2)
    assert lens_pixels.sum() > 1000
    assert (
        frame.status[lens_pixels & ~silhouettes(reference.object_id, reference.specular)] == Status.PROJECTED
    ).mean() > 0.98


def test_depth_follows_the_option():
    scene = make("facing-mirrors")
    for bounces in (1, 4):
        session = open_view(scene, METHOD.format(bounces), SMALL)
        session.draw(scene.camera)
        assert len(session.diagnostics()["layers"]) == bounces
    camera = cameras.pinhole(scene.camera, SMALL)
    session = Specification.parse(METHOD.format(2)).open(View(scene, camera, SMALL))
    session.draw(camera)
    assert len(session.diagnostics()["layers"]) == 3
