"""The sphere, and what stands for one of any curvature: a sphere or a plane."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from anamorph.base.compiled import compiled
from anamorph.base.errors import AnamorphError
from anamorph.base.vectors import Vector, across, along, dot, unit
from anamorph.surfaces.axes import check_axes
from anamorph.surfaces.base import Expansion, Surface
from anamorph.surfaces.plane import Plane
from anamorph.surfaces.similarity import Similarity

FLAT = 1e-6
"""A curvature, in 1/m, below which a round surface is a plane."""


@compiled
def _meet(
    numbers: np.ndarray, origin: Vector, direction: Vector, distance: float, u: float, v: float, facing: Vector
) -> tuple[bool, float, Vector]:
    met, normal = False, (0.0, 0.0, 0.0)
    to_center = along((numbers[0], numbers[1], numbers[2]), -1.0, origin)
    middle = dot(to_center, direction)
    across = along(to_center, -middle, direction)
    square = numbers[3] * numbers[3] - dot(across, across)
    if square >= 0.0:
        half = math.sqrt(square)
        # Which side of the sphere the mesh is on: near a silhouette the distances do not tell.
        from_center = along(along((0.0, 0.0, 0.0), distance, direction), -1.0, to_center)
        distance = middle - half if dot(from_center, facing) > 0.0 else middle + half
        normal = unit(along(along((0.0, 0.0, 0.0), distance, direction), -1.0, to_center))
        met = True
    return met, distance, normal


@compiled
def _expand(numbers: np.ndarray, place: Vector) -> Expansion:
    """`place` is a vector from the center, and the parameters are those of the plane that touches the sphere there."""
    out, radius = unit(place), numbers[3]
    right, up = across(out)
    zero = (0.0, 0.0, 0.0)
    inward = along(zero, -radius, out)
    position = along((numbers[0], numbers[1], numbers[2]), radius, out)
    return True, position, along(zero, radius, right), along(zero, radius, up), inward, zero, inward


@dataclass(frozen=True, eq=False)
class Sphere(Surface):
    """A sphere, by angles in axes of its own: (u, v) = (0, 0) lies on the outward axis.

    u is the longitude about the up axis, positive to the right; v is the latitude, positive upward; both in radians.
    position = center + radius * (cos v sin u right + sin v up + cos v cos u outward).

    Parameters
    ----------
    center : (3,) array
        Metres.
    radius : float
        Metres.
    axes : (3, 3) array
        Rows: the unit vectors right, up and outward, right-handed and perpendicular.
    """

    center: np.ndarray
    radius: float
    axes: np.ndarray = field(default_factory=lambda: np.eye(3))

    meet = staticmethod(_meet)
    expand = staticmethod(_expand)

    def __post_init__(self) -> None:
        if not (np.isfinite(self.radius) and self.radius > 0):
            raise AnamorphError(f"sphere: radius is {self.radius}; give a positive length in metres")
        check_axes("sphere", self.axes)

    @property
    def numbers(self) -> np.ndarray:
        return np.append(np.asarray(self.center, float), self.radius)

    def position(self, uv: np.ndarray) -> np.ndarray:
        return np.asarray(self.center) + self.radius * self.normal(uv)

    def normal(self, uv: np.ndarray) -> np.ndarray:
        u, v = np.asarray(uv, float).T
        local = np.stack([np.cos(v) * np.sin(u), np.sin(v), np.cos(v) * np.cos(u)], axis=-1)
        return local @ np.asarray(self.axes, float)

    def curvatures(self, uv: np.ndarray) -> np.ndarray:
        return np.full((len(uv), 2), 1.0 / self.radius)

    def parameters(self, points: np.ndarray, near: np.ndarray | None = None) -> np.ndarray:
        """The (u, v), (N, 2) float64, of the surface points in the directions of `points` (N, 3) from the center."""
        right, up, outward = np.asarray(self.axes, float) @ (np.asarray(points, float) - self.center).T
        return np.stack([np.arctan2(right, outward), np.arctan2(up, np.hypot(right, outward))], axis=-1)

    def places(self, uv: np.ndarray) -> np.ndarray:
        """Unit vectors from the center, which have no poles."""
        return self.normal(uv)

    def placed(self, places: np.ndarray) -> np.ndarray:
        return self.parameters(np.asarray(self.center) + places)

    def moved(self, by: Similarity) -> Sphere:
        return Sphere(by.points(self.center), by.scale * self.radius, by.directions(self.axes))

    def between(self, parameters: np.ndarray, positions: np.ndarray) -> np.ndarray:
        """Parameters of the middle of the positions: their own jump at the back, and have no meaning at a pole."""
        middle = np.mean(np.asarray(positions, float), axis=1)
        if (np.linalg.norm(middle - self.center, axis=1) < 1e-3 * self.radius).any():
            raise AnamorphError("sphere: an edge of its mesh goes through its centre; give it more triangles")
        return self.parameters(middle)


def round_surface(apex: np.ndarray, axes: np.ndarray, curvature: float) -> Sphere | Plane:
    """The sphere or plane through `apex` (3,), bulging along the outward axis where `curvature` (1/m) is positive."""
    right, up, outward = axes = np.asarray(axes, float)
    if abs(curvature) < FLAT:
        return Plane(np.asarray(apex, float), right, up)
    # Where the surface is concave, the sphere's own outward axis points the other way.
    own = axes if curvature > 0.0 else np.stack([right, -up, -outward])
    return Sphere(apex - outward / curvature, 1.0 / abs(curvature), own)
