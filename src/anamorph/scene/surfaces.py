"""Exact shapes of specular surfaces: what a tessellation only approximates.

To add a shape: a frozen dataclass with the two methods of `Surface`, and a case in `optics/exact.py`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np


class Surface(Protocol):
    """A parametric surface."""

    def position(self, uv: np.ndarray) -> np.ndarray:
        """World points, (N, 3) float64, at parameters (N, 2)."""
        ...

    def normal(self, uv: np.ndarray) -> np.ndarray:
        """Unit normals pointing outside, (N, 3) float64, at parameters (N, 2)."""
        ...


@dataclass(frozen=True, eq=False)
class Plane:
    """position = origin + u * edge_u + v * edge_v; the normal is edge_u x edge_v, normalised."""

    origin: np.ndarray
    edge_u: np.ndarray
    edge_v: np.ndarray

    def position(self, uv: np.ndarray) -> np.ndarray:
        u, v = np.asarray(uv, float).T
        return np.asarray(self.origin) + u[:, None] * self.edge_u + v[:, None] * self.edge_v

    def normal(self, uv: np.ndarray) -> np.ndarray:
        normal = np.cross(self.edge_u, self.edge_v)
        return np.broadcast_to(normal / np.linalg.norm(normal), (len(uv), 3)).copy()
