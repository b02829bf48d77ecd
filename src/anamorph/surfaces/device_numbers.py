"""Exact surfaces as the device reads them: numbers in float32, in a frame that is near and as large as their mesh.

A distant eye, a place far from the scene's origin and a radius of kilometres would each take the digits of float32.
So what is far is subtracted here, in float64, and meet.wgsl divides by no curvature.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.surfaces.base import Surface
from anamorph.surfaces.bezier import BezierPatch
from anamorph.surfaces.even_asphere import EvenAsphere
from anamorph.surfaces.intersection import SURFACES
from anamorph.surfaces.nurbs import NurbsSurface
from anamorph.surfaces.nurbs_pieces import COUNT_U, COUNT_V, DEGREE_U, DEGREE_V, EXTENT, HEAD
from anamorph.surfaces.patch import Patch
from anamorph.surfaces.plane import Plane
from anamorph.surfaces.similarity import Similarity
from anamorph.surfaces.sphere import Sphere
from anamorph.surfaces.toroid import Toroid

UNKNOWN_SURFACE, ROUND, TOROID, ASPHERE, PATCH = range(5)
"""The kinds of meet.wgsl: planes and spheres are round, and Bezier patches are NURBS."""

CUBIC = np.repeat([0.0, 1.0], 4)


@dataclass(frozen=True, eq=False)
class DeviceFrame:
    """Where shaders bend the rays of a mesh: its points are (world - origin) / unit there.

    Parameters
    ----------
    origin : (3,) float32
        Metres; of float32, so that a shader subtracts the same.
    unit : float
        Metres; a power of two, so that dividing by it rounds nothing.
    """

    origin: np.ndarray
    unit: float

    @classmethod
    def around(cls, positions: np.ndarray) -> DeviceFrame:
        """The frame of a mesh with vertices (V, 3)."""
        low, high = np.min(positions, axis=0).astype(float), np.max(positions, axis=0).astype(float)
        longest = max(float((high - low).max()), 1e-12)
        return cls(((low + high) / 2.0).astype(np.float32), float(2.0 ** np.ceil(np.log2(longest))))

    def points(self, points: np.ndarray) -> np.ndarray:
        """World points, (..., 3), in the frame: float64."""
        return (np.asarray(points, float) - self.origin.astype(float)) / self.unit

    @property
    def motion(self) -> Similarity:
        """From the world to the frame."""
        return Similarity(1.0 / self.unit, np.eye(3), -self.origin.astype(float) / self.unit)


def device_numbers(surface: Surface | None, frame: DeviceFrame) -> tuple[int, np.ndarray]:
    """The kind of a surface and its numbers, (N,) float32, as `meet` in meet.wgsl reads them.

    What that cannot meet is of the kind `UNKNOWN_SURFACE`, without numbers.
    """
    if surface is None or type(surface) not in SURFACES:
        return UNKNOWN_SURFACE, np.zeros(0, np.float32)
    kind, numbers = _numbers(surface.moved(frame.motion))
    return kind, np.asarray(numbers, np.float32)


def device_parameters(surface: Surface | None, parameters: np.ndarray) -> np.ndarray:
    """Parameters (V, 2) as meet.wgsl reads them, (V, 2) float32: from 0 to 1 over a patch, and unused elsewhere."""
    if not isinstance(surface, Patch):
        return np.zeros((len(parameters), 2), np.float32)
    low, high = surface.domain
    return ((parameters - low) / (high - low)).astype(np.float32)


def _numbers(surface: Surface) -> tuple[int, np.ndarray]:
    match surface:
        case Plane(origin=origin):
            outward = surface.normal(np.zeros((1, 2)))[0]
            foot = outward * (outward @ np.asarray(origin, float))
            return ROUND, np.concatenate([foot, outward, [0.0]])
        case Sphere(center=center, radius=radius):
            away = float(np.linalg.norm(center))
            outward = -np.asarray(center, float) / away if away > 1e-3 * radius else np.asarray(surface.axes[2], float)
            return ROUND, np.concatenate([center + radius * outward, outward, [1.0 / radius]])
        case Toroid():
            return TOROID, surface.numbers
        case EvenAsphere():
            return ASPHERE, surface.numbers
        case BezierPatch(control=control):
            flat = np.ones((4, 4))
            return PATCH, _patch_numbers(NurbsSurface(np.asarray(control, float), flat, CUBIC, CUBIC, 3, 3))
        case NurbsSurface():
            return PATCH, _patch_numbers(surface)
        case _:
            return UNKNOWN_SURFACE, np.zeros(0)


def _patch_numbers(surface: NurbsSurface) -> np.ndarray:
    """The numbers of patch.wgsl: each piece from its own middle, so that float32 rounds only what is small."""
    numbers = surface.numbers
    degrees, counts = numbers[[DEGREE_U, DEGREE_V]].astype(int), numbers[[COUNT_U, COUNT_V]].astype(int)
    borders = numbers[HEAD : HEAD + counts.sum() + 2]
    coefficients = numbers[HEAD + len(borders) : -1].reshape(counts.prod(), (degrees + 1).prod(), 4)
    middles = (coefficients[:, 0, :3] / coefficients[:, 0, 3:]).astype(np.float32).astype(float)
    numerators = coefficients[..., :3] - coefficients[..., 3:] * middles[:, None]
    pieces = np.concatenate([numerators, coefficients[..., 3:]], axis=-1).reshape(len(middles), -1)
    head = [*degrees, *counts, numbers[EXTENT], surface.sign]
    return np.concatenate([head, borders, np.hstack([middles, pieces]).ravel()])
