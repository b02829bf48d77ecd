"""The contract of exact surfaces: laws that every one keeps, and another one that is added as surfaces/base.py says."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from surface_instances import SURFACES, Instance, axes, instance, places

from anamorph.base.compiled import compiled
from anamorph.base.vectors import Vector
from anamorph.surfaces import intersection
from anamorph.surfaces.base import Surface
from anamorph.surfaces.even_asphere import EvenAsphere
from anamorph.surfaces.intersection import dispatch, intersect, pack
from anamorph.surfaces.plane import Plane
from anamorph.surfaces.sag import SagSurface, check_sag
from anamorph.surfaces.sag_search import Sag, meet_sag
from anamorph.surfaces.similarity import Similarity
from anamorph.surfaces.sphere import Sphere
from anamorph.surfaces.toroid import Toroid

STEP = 1e-5
"""Of differences, as a share of the range of a parameter."""


def differences(function, at: Instance) -> np.ndarray:
    """How values (N, 3) of `function` change along u and along v, by the whole range of each: (N, 3, 2)."""
    found = []
    for axis in range(2):
        aside = STEP * (at.high - at.low) * np.eye(2)[axis]
        found.append((function(at.uv + aside) - function(at.uv - aside)) / (2.0 * STEP))
    return np.stack(found, axis=-1)


def sound(tangents: np.ndarray) -> np.ndarray:
    """Where tangents (N, 3, 2) span a plane well enough for differences to tell of it, (N,) bool."""
    values = np.linalg.svd(tangents, compute_uv=False)
    return values[:, 1] > 0.02 * values.max()


def meet_each(surface: Surface, origins, directions, uv) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What `intersect` does, by the surface's own function."""
    facing = surface.normal(uv)
    facing = np.where(np.sum(facing * directions, axis=1, keepdims=True) > 0.0, -facing, facing)
    distances = np.sum((surface.position(uv) - origins) * directions, axis=1)
    found = [
        surface.meet(surface.numbers, tuple(origin), tuple(direction), distance, *parameters, tuple(normal))
        for origin, direction, distance, parameters, normal in zip(
            origins, directions, distances, uv, facing, strict=True
        )
    ]
    met, lengths, normals = (np.array(each) for each in zip(*found, strict=True))
    return origins + lengths[:, None] * directions, normals, met & (lengths > 0.0)


def a_normal_is_unit_and_perpendicular(at: Instance) -> None:
    """On borders and at poles it is the limit of those inside."""
    for uv in (at.uv, at.special):
        np.testing.assert_allclose(np.linalg.norm(at.surface.normal(uv), axis=1), 1.0, atol=1e-12)
    leaning = np.einsum("nij,ni->nj", differences(at.surface.position, at), at.surface.normal(at.uv))
    assert np.abs(leaning).max() <= 1e-6 * at.size
    inward = np.where(at.special < (at.low + at.high) / 2.0, 1e-5, -1e-5) * (at.high - at.low)
    inside = at.surface.normal(at.special + inward)
    np.testing.assert_allclose(at.surface.normal(at.special), inside, atol=5e-3)


def parameters_undo_position(at: Instance) -> None:
    """Everywhere they lead to the same point, and where only one pair does, to themselves."""
    uv = np.concatenate([at.uv, at.special])
    points, near = at.surface.position(uv), uv + 1e-3 * ((at.low + at.high) / 2.0 - uv)
    again = at.surface.parameters(points, near)
    np.testing.assert_allclose(at.surface.position(again), points, rtol=0.0, atol=1e-7 * at.size)
    smooth = sound(differences(at.surface.position, at))
    change = (again[: len(at.uv)] - at.uv)[smooth]
    np.testing.assert_allclose(change, 0.0, atol=1e-7 * np.max(at.high - at.low))


def a_middle_lies_between(at: Instance) -> None:
    """The middle of two near points is near the middle of their chord."""
    ends = np.stack([at.uv, at.uv + 1e-3 * (at.high - at.low)], axis=1)
    points = np.stack([at.surface.position(ends[:, 0]), at.surface.position(ends[:, 1])], axis=1)
    chord = np.linalg.norm(points[:, 1] - points[:, 0], axis=1)
    aside = at.surface.position(at.surface.between(ends, points)) - points.mean(axis=1)
    assert (np.linalg.norm(aside, axis=1) <= 0.05 * chord + 1e-5 * at.size).all()


def rays_meet_it(at: Instance) -> None:
    """A ray that is found to meet it does so on the surface, with its normal there; a steep one at its own point.

    A grazing ray may pass it by, or meet it in another point, and so may one beside it; at a pole it may meet nothing.
    """
    surface, tangents = at.surface, differences(at.surface.position, at)
    points, normals, steep = surface.position(at.uv), surface.normal(at.uv), sound(tangents)
    along = tangents[..., 0] - np.sum(tangents[..., 0] * normals, axis=1, keepdims=True) * normals
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    off = 1e-9 * at.size + 1e-13 * np.abs(points).max()
    for side in (1.0, -1.0):
        for cosine in (1.0, 0.6, 0.05, 1e-3):
            directions = -side * cosine * normals + np.sqrt(1.0 - cosine**2) * along
            origins = points - 0.1 * at.size * directions
            found, facing, ok = meet_each(surface, origins, directions, at.uv)
            uv = surface.parameters(found[ok], at.uv[ok])
            np.testing.assert_allclose(surface.position(uv), found[ok], rtol=0.0, atol=off)
            np.testing.assert_allclose(facing[ok], surface.normal(uv), atol=1e-5)
            if cosine > 0.5:
                assert ok[steep].all()
                np.testing.assert_allclose(found[steep], points[steep], rtol=0.0, atol=off)
        # A ray beside the surface meets it further on, if at all.
        origins = points + side * 0.3 * at.size * normals - 0.1 * at.size * along
        found, _, ok = meet_each(surface, origins, along, at.uv)
        uv = surface.parameters(found[ok], at.uv[ok])
        looked_at = ((uv > at.low) & (uv < at.high)).all(axis=1)
        np.testing.assert_allclose(surface.position(uv[looked_at]), found[ok][looked_at], rtol=0.0, atol=off)
    points, outward = surface.position(at.special), surface.normal(at.special)
    found, facing, ok = meet_each(surface, points + at.size * outward, -outward, at.special)
    assert np.isfinite(found).all() and np.isfinite(facing).all()
    np.testing.assert_allclose(facing[ok], outward[ok], atol=1e-4)


def curvatures_are_those_of_its_normals(at: Instance) -> None:
    """They are the eigenvalues of the shape operator: how normals change along the surface."""
    tangents, turning = differences(at.surface.position, at), differences(at.surface.normal, at)
    found, fit = at.surface.curvatures(at.uv), sound(tangents)
    assert found.shape == at.uv.shape and (found[:, 0] >= found[:, 1]).all()
    for tangent, turn, curvatures in zip(tangents[fit], turning[fit], found[fit], strict=True):
        frame, stretch = np.linalg.qr(tangent)
        shape = frame.T @ turn @ np.linalg.inv(stretch)
        expected = np.linalg.eigvalsh((shape + shape.T) / 2.0)[::-1]
        np.testing.assert_allclose(curvatures, expected, rtol=0.0, atol=1e-3 * (np.abs(expected).max() + 0.1 / at.size))


def all_of_it_moves_along(at: Instance) -> None:
    """Position, normal, curvatures and the hits of rays."""
    by, surface, moved = at.motion, at.surface, at.surface.moved(at.motion)
    uv = np.concatenate([at.uv, at.special])
    there = by.scale * uv if surface.metric else uv
    points, normals = by.points(surface.position(uv)), by.directions(surface.normal(uv))
    off = 1e-13 * (np.abs(points).max() + np.abs(by.translation).max() + by.scale)
    np.testing.assert_allclose(moved.position(there), points, rtol=0.0, atol=off)
    np.testing.assert_allclose(moved.normal(there), normals, atol=1e-6)
    curvatures = surface.curvatures(at.uv)
    found = moved.curvatures(there[: len(at.uv)])
    np.testing.assert_allclose(by.scale * found, curvatures, rtol=1e-6, atol=1e-6 / at.size)
    fit, first = sound(differences(surface.position, at)), len(at.uv)
    points, normals = points[:first], normals[:first]
    found, _, ok = meet_each(moved, points + by.scale * at.size * normals, -normals, there[:first])
    assert ok[fit].all()
    np.testing.assert_allclose(found[fit], points[fit], rtol=0.0, atol=1e-9 * by.scale * at.size + off)


LAWS = (
    a_normal_is_unit_and_perpendicular,
    parameters_undo_position,
    a_middle_lies_between,
    rays_meet_it,
    curvatures_are_those_of_its_normals,
    all_of_it_moves_along,
)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.__name__)
@pytest.mark.parametrize("kind", SURFACES, ids=lambda kind: kind.__name__)
@settings(max_examples=40)
@given(st.data())
def test_every_surface_keeps(kind, law, data):
    law(data.draw(SURFACES[kind]))


def test_every_surface_that_rays_can_meet_is_held_to_the_contract():
    assert set(SURFACES) == set(intersection.SURFACES)


@pytest.mark.parametrize("kind", SURFACES, ids=lambda kind: kind.__name__)
@settings(max_examples=40)
@given(st.data())
def test_compiled_loops_find_the_surfaces_own_function(kind, data):
    at = data.draw(SURFACES[kind])
    points, normals = at.surface.position(at.uv), at.surface.normal(at.uv)
    rays = points + 0.1 * at.size * normals, -normals
    for found, own in zip(intersect(at.surface, *rays, at.uv), meet_each(at.surface, *rays, at.uv), strict=True):
        np.testing.assert_array_equal(found, own)


lens_curvatures = st.floats(-15.0, 15.0)
near_apex = np.random.default_rng(0).uniform(-0.02, 0.02, (20, 2))


@given(lens_curvatures, lens_curvatures, st.floats(-3.0, 0.5), st.floats(-200.0, 200.0))
def test_curvatures_are_those_of_closed_forms(one, other, conic, fourth):
    apex = np.zeros((1, 2))
    pair = [sorted((one, other), reverse=True)]
    np.testing.assert_allclose(Toroid(np.zeros(3), one, other).curvatures(apex), pair, rtol=1e-14)
    np.testing.assert_allclose(
        EvenAsphere(np.zeros(3), one, conic, (fourth,)).curvatures(apex), [[one] * 2], rtol=1e-14
    )
    # Everywhere on a cylinder and on a sphere, whatever it is made as.
    cylinder = Toroid(np.zeros(3), 0.0, one).curvatures(near_apex)
    np.testing.assert_allclose(cylinder, np.tile([max(one, 0.0), min(one, 0.0)], (20, 1)), rtol=1e-14)
    for sphere in (EvenAsphere(np.zeros(3), one), Toroid(np.zeros(3), one, one)):
        np.testing.assert_allclose(sphere.curvatures(near_apex), one, rtol=1e-12)
    np.testing.assert_allclose(Sphere(np.zeros(3), abs(one) + 0.1).curvatures(apex), 1.0 / (abs(one) + 0.1), rtol=1e-15)
    assert not Plane(*np.eye(3)).curvatures(near_apex).any()


@compiled
def _sag(shape: np.ndarray, x: float, y: float) -> Sag:
    return True, (shape[0] * x * x + shape[1] * y * y) / 2.0, shape[0] * x, shape[1] * y


@compiled
def _meet(
    numbers: np.ndarray, origin: Vector, direction: Vector, distance: float, u: float, v: float, facing: Vector
) -> tuple[bool, float, Vector]:
    return meet_sag(_sag, numbers, origin, direction, distance, facing)


@dataclass(frozen=True, eq=False)
class Paraboloid(SagSurface):
    """An elliptic or hyperbolic paraboloid, which is none of the package's: sag = (first u^2 + second v^2) / 2."""

    apex: np.ndarray
    first: float
    second: float
    axes: np.ndarray

    meet = staticmethod(_meet)

    def __post_init__(self) -> None:
        check_sag("paraboloid", self)

    @property
    def shape(self) -> tuple[float, ...]:
        return self.first, self.second

    apex_curvatures = shape

    def with_apex_curvatures(self, curvatures: tuple[float, ...]) -> Paraboloid:
        return Paraboloid(self.apex, *curvatures, self.axes)

    def sag(self, uv: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        slopes = np.asarray(uv, float) * self.shape
        return np.sum(slopes * uv, axis=1) / 2.0, slopes

    def curvatures(self, uv: np.ndarray) -> np.ndarray:
        (x, y), (a, b) = self.sag(uv)[1].T, self.shape
        square = 1.0 + x**2 + y**2
        mean, gauss = ((1.0 + y**2) * a + (1.0 + x**2) * b) / (2.0 * square**1.5), a * b / square**2
        half = np.sqrt(np.maximum(mean**2 - gauss, 0.0))
        return np.stack([mean + half, mean - half], axis=-1)

    def moved(self, by: Similarity) -> Paraboloid:
        scaled = self.first / by.scale, self.second / by.scale
        return Paraboloid(by.points(self.apex), *scaled, by.directions(self.axes))


paraboloids = st.builds(Paraboloid, places, lens_curvatures, lens_curvatures, axes)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.__name__)
@settings(max_examples=40)
@given(st.data())
def test_another_surface_keeps(law, data):
    law(data.draw(instance(data.draw(paraboloids), [-0.03, -0.03], [0.03, 0.03])))


def test_another_surface_takes_its_file_and_one_entry(monkeypatch):
    surfaces = (*intersection.SURFACES, Paraboloid)
    monkeypatch.setattr(intersection, "SURFACES", surfaces)
    ray = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0), 0.7, 0.0, 0.0, (0.0, 0.0, 1.0)
    meet = dispatch(surfaces)
    for surface in (Paraboloid(np.array([0.0, 0.0, 0.25]), 2.0, 3.0, np.eye(3)), Sphere(np.zeros(3), 0.25)):
        kind, numbers = pack(surface)
        assert surfaces[kind - 1] is type(surface)
        assert meet(kind, numbers, *ray) == (True, 0.75, (0.0, 0.0, 1.0))


def test_machine_code_that_is_kept_cannot_take_one_dispatch_for_another():
    # By their names it finds the functions that it calls, also those of the process that has loaded it.
    several = [dispatch(intersection.SURFACES[first:]) for first in range(len(intersection.SURFACES))]
    several.append(dispatch((*intersection.SURFACES, Paraboloid)))
    assert len({each.py_func.__qualname__ for each in several}) == len(several)
