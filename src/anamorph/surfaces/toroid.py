"""The toroid: a piece of a torus, as on a lens for astigmatism."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from anamorph.base.compiled import compiled
from anamorph.base.vectors import Vector
from anamorph.surfaces.base import Expansion
from anamorph.surfaces.sag import SagSurface, check_sag, root
from anamorph.surfaces.sag_search import Sag, expand_sag, meet_sag
from anamorph.surfaces.similarity import Similarity


@compiled
def _sag(shape: np.ndarray, x: float, y: float) -> Sag:
    """`shape`: base curvature, cross curvature."""
    base, cross = shape[0], shape[1]
    arc_square = 1.0 - cross * cross * y * y
    if arc_square <= 0.0:
        return False, 0.0, 0.0, 0.0
    arc_root = math.sqrt(arc_square)
    arc = cross * y * y / (1.0 + arc_root)
    lever = 1.0 - base * arc
    square = lever * lever - base * base * x * x
    if square <= 0.0 or lever <= 0.0:
        return False, 0.0, 0.0, 0.0
    root = math.sqrt(square)
    sag = (2.0 * arc - base * arc * arc + base * x * x) / (1.0 + root)
    return True, sag, base * x / root, lever * cross * y / (arc_root * root)


@compiled
def _bends(shape: np.ndarray, x: float, y: float) -> Vector:
    """The second derivatives of the sag, where it has one: xx, xy, yy."""
    base, cross = shape[0], shape[1]
    arc_root = math.sqrt(1.0 - cross * cross * y * y)
    arc_slope, arc_bend = cross * y / arc_root, cross / (arc_root * arc_root * arc_root)
    lever = 1.0 - base * cross * y * y / (1.0 + arc_root)
    square = lever * lever - base * base * x * x
    root = math.sqrt(square)
    steep = base * lever * arc_slope
    return (
        base * lever * lever / (square * root),
        base * x * steep / (square * root),
        (lever * arc_bend - base * arc_slope * arc_slope) / root + steep * lever * arc_slope / (square * root),
    )


@compiled
def _meet(
    numbers: np.ndarray, origin: Vector, direction: Vector, distance: float, u: float, v: float, facing: Vector
) -> tuple[bool, float, Vector]:
    return meet_sag(_sag, numbers, origin, direction, distance, facing)


@compiled
def _expand(numbers: np.ndarray, place: Vector) -> Expansion:
    return expand_sag(_sag, _bends, numbers, place)


@dataclass(frozen=True, eq=False)
class Toroid(SagSurface):
    """A piece of a torus: an arc along `up`, turned about an axis along `up`.

    Parameters
    ----------
    apex : (3,) array
        Metres.
    base_curvature : float
        One over the radius of the section along `right`, the circle of turning; 0 makes a cylinder. In 1/m.
    cross_curvature : float
        One over the radius of the section along `up`, the turned arc. In 1/m.
    axes : (3, 3) array
        Rows: the unit vectors right, up and outward at the apex, right-handed and perpendicular.
    """

    apex: np.ndarray
    base_curvature: float
    cross_curvature: float
    axes: np.ndarray = field(default_factory=lambda: np.eye(3))

    meet = staticmethod(_meet)
    expand = staticmethod(_expand)

    def __post_init__(self) -> None:
        check_sag("toroid", self)

    @property
    def shape(self) -> tuple[float, ...]:
        return self.base_curvature, self.cross_curvature

    @property
    def apex_curvatures(self) -> tuple[float, ...]:
        return self.base_curvature, self.cross_curvature

    def with_apex_curvatures(self, curvatures: tuple[float, ...]) -> Toroid:
        return replace(self, base_curvature=curvatures[0], cross_curvature=curvatures[1])

    def sag(self, uv: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        x, y = np.asarray(uv, float).T
        base, cross = self.base_curvature, self.cross_curvature
        arc_root, lever = self._arc(y)
        arc = cross * y**2 / (1.0 + arc_root)
        across = root("toroid", np.where(lever > 0.0, lever**2 - (base * x) ** 2, -1.0))
        sag = (2.0 * arc - base * arc**2 + base * x**2) / (1.0 + across)
        return sag, np.stack([base * x / across, lever * cross * y / (arc_root * across)], axis=-1)

    def curvatures(self, uv: np.ndarray) -> np.ndarray:
        """Those of a torus: the arc's own, and that of the circle of turning by Meusnier's theorem."""
        arc_root, lever = self._arc(np.asarray(uv, float)[:, 1])
        turned = self.base_curvature * arc_root / lever
        arc = np.full_like(turned, self.cross_curvature)
        return np.stack([np.maximum(turned, arc), np.minimum(turned, arc)], axis=-1)

    def moved(self, by: Similarity) -> Toroid:
        base, cross = self.base_curvature / by.scale, self.cross_curvature / by.scale
        return Toroid(by.points(self.apex), base, cross, by.directions(self.axes))

    def _arc(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """At heights y on the arc, the cosine of its slope, and the share of the radius that the circle there has."""
        cross = self.cross_curvature
        arc_root = root("toroid", 1.0 - (cross * y) ** 2)
        return arc_root, 1.0 - self.base_curvature * (cross * y**2 / (1.0 + arc_root))
