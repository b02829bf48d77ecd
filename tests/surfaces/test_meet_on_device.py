"""Rays met with exact surfaces on the device, in float32, against float64.

The twin gets the ray as the device has it, rounded to float32. At a cosine of incidence c a point may then be off by
2e-7 of the mesh's size over c: that is what rounding a point near the mesh costs. The direction of a ray that is
reflected there may be off by what the surface turns on that way, and by some rounding of the normal itself.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from compute import computed
from hypothesis import given, settings
from hypothesis import strategies as st
from surface_instances import SURFACES, Instance, instance

from anamorph.optics.laws import reflect
from anamorph.surfaces.base import Surface
from anamorph.surfaces.device_numbers import (
    ROUND,
    UNKNOWN_SURFACE,
    DeviceFrame,
    device_numbers,
    device_parameters,
)
from anamorph.surfaces.even_asphere import EvenAsphere
from anamorph.surfaces.intersection import meet_all, pack
from anamorph.surfaces.nurbs import NurbsSurface
from anamorph.surfaces.patch import Patch
from anamorph.surfaces.plane import Plane
from anamorph.surfaces.similarity import Similarity
from anamorph.surfaces.sphere import Sphere, round_surface
from anamorph.surfaces.toroid import Toroid

SHADER = Path(__file__).with_name("meet_rays.wgsl")
GIVEN = np.dtype([("point", "f4", 3), ("u", "f4"), ("direction", "f4", 3), ("v", "f4"), ("facing", "f4", 4)])
FOUND = np.dtype([("normal", "f4", 3), ("step", "f4"), ("met", "u4"), ("padding", "u4", 3)])

AWAY = 10.0
"""From where float64's rays start, in units of the frame."""

POINT, NORMAL = 2e-7, 1e-6
"""What the place of a hit may be off by, of the mesh's size and at normal incidence, and what a direction may."""


class Rays(NamedTuple):
    """Rays near a surface in a frame: where they meet some mesh, the parameters there, and its normal."""

    points: np.ndarray
    directions: np.ndarray
    uv: np.ndarray
    facing: np.ndarray


class Hits(NamedTuple):
    met: np.ndarray
    steps: np.ndarray
    normals: np.ndarray


def on_device(surface: Surface, frame: DeviceFrame, rays: Rays, as_kind: int | None = None) -> tuple[np.ndarray, Hits]:
    """The rays as the device has them, and what it finds; where the surface is taken for one of another kind, that."""
    given = np.zeros(len(rays.points), GIVEN)
    given["point"], given["direction"], given["facing"][:, :3] = rays.points, rays.directions, rays.facing
    given["u"], given["v"] = device_parameters(surface, rays.uv).T
    kind, numbers = device_numbers(surface, frame)
    kind = kind if as_kind is None else as_kind
    found = computed(SHADER, {"SURFACE": kind}, len(given), FOUND, {0: [given], 3: [numbers]})
    return given, Hits(found["met"] == 1, found["step"].astype(float), found["normal"].astype(float))


def in_float64(surface: Surface, frame: DeviceFrame, given: np.ndarray) -> tuple[np.ndarray, Hits]:
    """The directions, and what `meet_all` finds on the same rays."""
    kind, numbers = pack(surface.moved(frame.motion))
    points, directions, facing = (given[name][:, :3].astype(float) for name in ("point", "direction", "facing"))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    low, high = surface.domain if isinstance(surface, Patch) else (np.zeros(2), np.ones(2))
    uv = low + np.stack([given["u"], given["v"]], axis=-1).astype(float) * (high - low)
    found, normals, met = np.empty_like(points), np.empty_like(points), np.empty(len(points), bool)
    away = np.full(len(points), AWAY)
    meet_all(kind, numbers, points - AWAY * directions, directions, away, uv, facing, found, normals, met)
    return directions, Hits(met, np.sum((found - points) * directions, axis=1), normals)


def rays_about(
    surface: Surface, uv: np.ndarray, size: float, random: np.random.Generator, coarse: bool
) -> tuple[Rays, np.ndarray]:
    """Rays from both sides through points of a surface, and their cosines of incidence.

    They meet a mesh a thousandth of its size before or behind, where normals are as much off; one that is coarse,
    which they do not graze, a twentieth.
    """
    points, normals = surface.position(uv), surface.normal(uv)
    cosines = random.choice([1.0, 0.7] if coarse else [1.0, 0.7, 0.3, 0.1, 0.05, 0.02], (len(uv), 1))
    along = np.cross(normals, random.normal(size=normals.shape))
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    side = random.choice([-1.0, 1.0], (len(uv), 1))
    directions = -side * cosines * normals + np.sqrt(1.0 - cosines**2) * along
    facing = side * normals + 0.02 * cosines * random.normal(size=normals.shape)
    meshes = points + random.uniform(-1.0, 1.0, (len(uv), 1)) * (0.05 if coarse else 1e-3) * size * directions
    return Rays(meshes, directions, uv, facing), cosines[:, 0]


def box_of(at: Instance, surface: Surface, stretch: float) -> np.ndarray:
    """Points all over what is looked at of a surface, whose parameters have grown by `stretch`."""
    shares = np.stack(np.meshgrid(*[np.linspace(0.0, 1.0, 9)] * 2), axis=-1).reshape(-1, 2)
    return surface.position(stretch * (at.low + shares * (at.high - at.low)))


def rounding_of_normals(surface: Surface, uv: np.ndarray, size: float) -> np.ndarray:
    """By what rounding turns normals, (N,) radians: near the poles of a patch its tangents are short."""
    if not isinstance(surface, Patch):
        return np.zeros(len(uv))
    low, high = surface.domain
    u, v = (surface.derivative(uv, *orders) * (high - low)[axis] for axis, orders in enumerate(((1, 0), (0, 1))))
    area = np.linalg.norm(np.cross(u, v), axis=1)
    return 1e-6 * size * np.maximum(np.linalg.norm(u, axis=1), np.linalg.norm(v, axis=1)) / np.maximum(area, 1e-300)


def assert_alike(at: Instance, scale: float, seed: int, coarse: bool = False) -> np.ndarray:
    """That both find the same on a surface that is made larger; the angles between directions after it, radians."""
    random = np.random.default_rng(seed)
    surface = at.surface.moved(Similarity(scale, np.eye(3), scale * random.uniform(-1.0, 1.0, 3)))
    stretch = scale if surface.metric else 1.0
    box = box_of(at, surface, stretch)
    frame, size = DeviceFrame.around(box), float(np.ptp(box, axis=0).max())
    uv = stretch * (at.low + random.uniform(0.02, 0.98, (100, 2)) * (at.high - at.low))
    uv = np.concatenate([stretch * at.uv, uv])
    rays, cosines = rays_about(surface, uv, size, random, coarse)
    given, found = on_device(surface, frame, rays._replace(points=frame.points(rays.points)))
    directions, hits = in_float64(surface, frame, given)
    aside = rounding_of_normals(surface, uv, size)
    clear = aside < 1e-3
    assert (found.met == hits.met)[clear].all() and hits.met[clear].mean() > 0.95
    both = hits.met & found.met & clear
    off = np.abs(found.steps - hits.steps)[both] * frame.unit
    assert (np.sum(found.normals * hits.normals, axis=1)[both] > 0.9).all()
    # A ray may meet the surface at another cosine than where it was aimed.
    steep = np.minimum(cosines, np.abs(np.sum(hits.normals * directions, axis=1)))[both]
    assert (off * steep <= POINT * size).all()
    angles = np.linalg.norm(reflect(directions, found.normals) - reflect(directions, hits.normals), axis=1)[both]
    turned = np.abs(surface.curvatures(uv[both])).max(axis=1) * size * POINT / steep
    assert (angles <= NORMAL + 2.0 * turned + aside[both]).all()
    return angles


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("kind", SURFACES, ids=lambda kind: kind.__name__)
@settings(max_examples=15)
@given(st.data())
def test_the_device_meets_what_float64_meets(kind, scale, data):
    angles = assert_alike(data.draw(SURFACES[kind]), scale, data.draw(st.integers(0, 2**32 - 1)))
    assert np.median(angles) <= 1e-6


@pytest.mark.parametrize("kind", SURFACES, ids=lambda kind: kind.__name__)
@settings(max_examples=15)
@given(st.data())
def test_from_a_coarse_mesh_the_device_finds_the_surface_as_well(kind, data):
    assert_alike(data.draw(SURFACES[kind]), 1.0, data.draw(st.integers(0, 2**32 - 1)), coarse=True)


@pytest.mark.parametrize("curvature", [0.0, 1e-7, 2e-6, 1e-4, 1e-2, -1e-2, -2e-6])
@settings(max_examples=5)
@given(st.data())
def test_a_surface_that_is_all_but_flat_is_met_as_well(curvature, data):
    for surface in (round_surface(np.ones(3), np.eye(3), curvature), Toroid(np.ones(3), curvature, -curvature)):
        if isinstance(surface, Sphere):
            low, high = surface.parameters(np.array([[0.9, 0.9, 1.0], [1.1, 1.1, 1.0]]))
            low, high = np.minimum(low, high), np.maximum(low, high)
        else:
            low, high = np.full(2, -0.1), np.full(2, 0.1)
        assert assert_alike(data.draw(instance(surface, low, high)), 1.0, 0).max() <= 1e-6


@pytest.mark.parametrize("radius", [1e-3, 1.0, 1e3])
def test_rays_beside_a_ball_pass_it_by(radius):
    random = np.random.default_rng(0)
    ball = Sphere(np.array([1.0, -2.0, 0.5]), radius)
    frame = DeviceFrame.around(ball.center + radius * np.array([[-1.0] * 3, [1.0] * 3]))
    directions = random.normal(size=(1000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    across = np.cross(directions, random.normal(size=(1000, 3)))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    beside = random.uniform(0.8, 1.2, 1000)
    rays = Rays(ball.center + radius * beside[:, None] * across, directions, np.zeros((1000, 2)), across)
    _, found = on_device(ball, frame, rays._replace(points=frame.points(rays.points)))
    clear = np.abs(beside - 1.0) > 1e-6
    assert (found.met == (beside < 1.0))[clear].all()


@pytest.mark.parametrize("surface", [Toroid(np.zeros(3), 10.0, 8.0), EvenAsphere(np.zeros(3), 10.0, 0.2)])
def test_what_lies_behind_the_sheet_of_a_lens_face_is_not_met(surface):
    # A torus and a conic close behind their apex.
    frame = DeviceFrame.around(np.array([[-0.1, -0.1, -0.2], [0.1, 0.1, 0.0]]))
    points, along = np.array([[0.01, 0.02, 0.0], [0.01, 0.02, -0.18]]), np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    _, found = on_device(surface, frame, Rays(frame.points(points), along, np.zeros((2, 2)), -along))
    assert found.met.tolist() == [True, False]


@pytest.mark.parametrize("kind", SURFACES, ids=lambda kind: kind.__name__)
@settings(max_examples=15)
@given(st.data())
def test_on_borders_and_poles_the_device_finds_numbers(kind, data):
    at = data.draw(SURFACES[kind])
    points, normals = at.surface.position(at.special), at.surface.normal(at.special)
    frame = DeviceFrame.around(box_of(at, at.surface, 1.0))
    rays = Rays(frame.points(points + 1e-3 * at.size * normals), -normals, at.special, normals)
    _, found = on_device(at.surface, frame, rays)
    assert np.isfinite(found.normals).all() and np.isfinite(found.steps).all()
    turned = np.linalg.norm(np.cross(found.normals, normals), axis=1)
    sound = found.met & (rounding_of_normals(at.surface, at.special, at.size) < 1e-4)
    assert (turned[sound] <= 1e-3).all()


class Bent(Plane):
    """A kind of surface that the device does not know."""


def test_what_the_device_does_not_know_has_no_numbers():
    frame = DeviceFrame.around(np.array([[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]]))
    assert device_numbers(Plane(*np.eye(3)), frame)[0] == ROUND
    for surface in (Bent(*np.eye(3)), None):
        kind, numbers = device_numbers(surface, frame)
        assert kind == UNKNOWN_SURFACE and len(numbers) == 0
        rays = Rays(np.zeros((2, 3)), np.eye(3)[:2], np.zeros((2, 2)), -np.eye(3)[:2])
        found = on_device(Plane(*np.eye(3)), frame, rays, kind)[1]
        assert not found.met.any() and np.isfinite(found.normals).all()


def test_a_patch_takes_the_same_numbers_whatever_the_scene_is_moved_by():
    surface = NurbsSurface(np.moveaxis(np.indices((2, 2, 1)), 0, -1)[:, :, 0].astype(float), np.ones((2, 2)),
                           np.array([0.0, 0, 1, 1]), np.array([0.0, 0, 1, 1]), 1, 1)  # fmt: skip
    far = surface.moved(Similarity.shift(np.array([4096.0, -8192.0, 2048.0])))
    packed = [device_numbers(each, DeviceFrame.around(each.poles.reshape(-1, 3))) for each in (surface, far)]
    np.testing.assert_array_equal(packed[0][1], packed[1][1])
