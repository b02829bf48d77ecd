"""Light through a lens step by step, on roots found by halving: what the tests of lenses compare with."""

from __future__ import annotations

from typing import cast

import numpy as np

from anamorph.lenses.lens import Lens
from anamorph.surfaces.base import Surface


def surfaces(lens: Lens) -> tuple[Surface, Surface]:
    """Front and back."""
    front, back = lens.front.surface, lens.back.surface
    assert front is not None and back is not None
    return cast(Surface, front), cast(Surface, back)


def meet(surface: Surface, origins: np.ndarray, directions: np.ndarray, low: float, high: float) -> np.ndarray:
    """Points, (N, 3), at which rays meet a surface between two distances: one root each, found by halving."""

    def height(distance: np.ndarray) -> np.ndarray:
        points = origins + distance[:, None] * directions
        uv = surface.parameters(points)
        return np.sum((points - surface.position(uv)) * surface.normal(uv), axis=1)

    a, b = np.full(len(origins), low), np.full(len(origins), high)
    rising = height(b) > height(a)
    assert (rising == (height(a) < 0.0)).all() and (np.sign(height(a)) != np.sign(height(b))).all()
    for _ in range(64):
        middle = 0.5 * (a + b)
        above = (height(middle) > 0.0) == rising
        a, b = np.where(above, a, middle), np.where(above, middle, b)
    return origins + (0.5 * (a + b))[:, None] * directions


def snell(directions: np.ndarray, normals: np.ndarray, eta: float) -> np.ndarray:
    """Refracted unit directions, by angles in the plane of incidence."""
    normals = normals * -np.sign(np.sum(normals * directions, axis=1, keepdims=True))
    cosine = -np.sum(normals * directions, axis=1, keepdims=True)
    tangent = directions + cosine * normals
    sine = np.linalg.norm(tangent, axis=1, keepdims=True)
    angle = np.arcsin(eta * sine)
    return np.sin(angle) * tangent / np.maximum(sine, 1e-300) - np.cos(angle) * normals


def through(
    lens: Lens, origins: np.ndarray, directions: np.ndarray, index: float, from_back: bool = False, reach: float = 0.06
) -> tuple[np.ndarray, np.ndarray]:
    """Where rays (N, 3) that start within `reach` metres of the lens leave it, and their unit directions then."""
    origins, directions = np.atleast_2d(origins), np.atleast_2d(directions)
    first, second = surfaces(lens)[::-1] if from_back else surfaces(lens)
    points = meet(first, origins, directions, 0.0, reach)
    inside = snell(directions, first.normal(first.parameters(points)), 1.0 / index)
    ends = meet(second, points, inside, 1e-6, 0.02)
    return ends, snell(inside, second.normal(second.parameters(ends)), index)
