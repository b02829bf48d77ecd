"""What every exact surface says of itself. Each has a file beside this one.

To add another surface:

1. Write its file: a frozen dataclass that derives from `Surface` and has all that is abstract here, and compiled
   `meet` and `expand`. One that is a height above a plane derives from `SagSurface` (sag.py), and one with two
   parameters and derivatives from `Patch` (patch.py); these leave little to write.
2. Add the class to `SURFACES` in intersection.py, and its `expand` to expansion.py.
3. Add it to device_numbers.py and meet.wgsl; until then the device bends its rays at the mesh.
4. Add some of it to `SURFACES` in tests/surface_instances.py: the contract test then holds it to every law.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import ClassVar, Self

import numpy as np

from anamorph.base.vectors import Vector
from anamorph.surfaces.similarity import Similarity

Expansion = tuple[bool, Vector, Vector, Vector, Vector, Vector, Vector]
"""Whether there is a surface; the position, its slopes along two parameters a and b, and its bends aa, ab and bb."""


class Surface(ABC):
    """A smooth surface by two parameters (u, v). Lengths are metres; N points are (N, 3), their parameters (N, 2)."""

    meet: ClassVar[Callable]
    """Compiled: meet(numbers, origin, direction, distance, u, v, facing), as `intersection.meet` without the kind."""

    expand: ClassVar[Callable]
    """Compiled: expand(numbers, place), as `expansion.expand` without the kind."""

    metric: ClassVar[bool] = False
    """Whether u and v are lengths, which grow with the surface."""

    @property
    @abstractmethod
    def numbers(self) -> np.ndarray:
        """What `meet` reads, (K,) float64."""

    @abstractmethod
    def position(self, uv: np.ndarray) -> np.ndarray:
        """World points, (N, 3) float64."""

    @abstractmethod
    def normal(self, uv: np.ndarray) -> np.ndarray:
        """Unit normals to the surface's own outside, (N, 3) float64."""

    @abstractmethod
    def curvatures(self, uv: np.ndarray) -> np.ndarray:
        """Principal curvatures, (N, 2) float64, 1/m, the greater first; positive where it bends from its normal."""

    @abstractmethod
    def parameters(self, points: np.ndarray, near: np.ndarray | None = None) -> np.ndarray:
        """The (u, v), (N, 2) float64, of points on the surface or near it; `near` (N, 2) says where to search first."""

    @abstractmethod
    def moved(self, by: Similarity) -> Self:
        """The surface moved. A point keeps its parameters, but for the scale where they are `metric`."""

    def between(self, parameters: np.ndarray, positions: np.ndarray) -> np.ndarray:
        """Parameters, (N, 2) float64, of a point in the middle of K others each: their (N, K, 2) and (N, K, 3)."""
        return np.mean(np.asarray(parameters, float), axis=1)

    def places(self, uv: np.ndarray) -> np.ndarray:
        """Parameters (N, 2) as `expand` reads them, (N, 3) float64; what lies on a line between two is between them."""
        return np.column_stack([uv, np.ones(len(uv))])

    def placed(self, places: np.ndarray) -> np.ndarray:
        """The (u, v), (N, 2) float64, of places (N, 3)."""
        return places[:, :2] / places[:, 2:]

    def normals_toward(self, uv: np.ndarray, side: np.ndarray) -> np.ndarray:
        """Unit normals, (N, 3) float64, on the side to which vectors (N, 3) point."""
        normals = self.normal(uv)
        return np.where(np.sum(normals * side, axis=1, keepdims=True) < 0.0, -normals, normals)
