"""Positions and derivatives of exact surfaces for compiled loops, against differences."""

from __future__ import annotations

import numpy as np
import pytest
from curved_surfaces import height_field, torus_surface, wavy

from anamorph.surfaces.even_asphere import EvenAsphere
from anamorph.surfaces.expansion import expand, shifted
from anamorph.surfaces.intersection import SURFACES, pack
from anamorph.surfaces.plane import Plane
from anamorph.surfaces.sphere import Sphere
from anamorph.surfaces.toroid import Toroid

KINDS = (
    Plane(np.array([0.1, 0.2, 0.3]), np.array([1.0, 0.2, 0.0]), np.array([0.1, 0.7, 0.4])),
    Sphere(np.array([0.1, 0.2, 0.3]), 1.3),
    wavy(),
    height_field(),
    torus_surface(1.0, 0.3),
    Toroid(np.zeros(3), 1.2, -0.7),
    EvenAsphere(np.zeros(3), 1.1, -0.6, (0.3, -0.2)),
)
STEP = 1e-4


@pytest.mark.parametrize("surface", KINDS, ids=lambda surface: type(surface).__name__)
@pytest.mark.parametrize("uv", [(0.31, 0.24), (0.62, 0.57)])
def test_an_expansion_is_the_position_and_its_derivatives(surface, uv):
    kind, numbers = pack(surface)
    place = tuple(surface.places(np.array([uv]))[0].tolist())

    def at(a: int, b: int) -> np.ndarray:
        return np.array(expand(kind, numbers, shifted(kind, place, a * STEP, b * STEP))[1])

    ok, position, *derivatives = expand(kind, numbers, place)
    expected = (
        (at(1, 0) - at(-1, 0)) / (2.0 * STEP),
        (at(0, 1) - at(0, -1)) / (2.0 * STEP),
        (at(1, 0) + at(-1, 0) - 2.0 * at(0, 0)) / STEP**2,
        (at(1, 1) + at(-1, -1) - at(1, -1) - at(-1, 1)) / (4.0 * STEP**2),
        (at(0, 1) + at(0, -1) - 2.0 * at(0, 0)) / STEP**2,
    )
    assert ok
    np.testing.assert_allclose(position, surface.position(np.array([uv]))[0], atol=1e-14)
    size = max(np.abs(each).max() for each in derivatives)
    for derivative, differences in zip(derivatives, expected, strict=True):
        np.testing.assert_allclose(derivative, differences, atol=2e-6 * size)
    np.testing.assert_allclose(surface.placed(surface.places(np.array([uv]))), [uv])


def test_every_kind_of_surface_is_held_to_it():
    assert {type(surface) for surface in KINDS} == set(SURFACES)
