"""The plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.base.compiled import compiled
from anamorph.base.vectors import Vector, along, dot
from anamorph.surfaces.base import Expansion, Surface
from anamorph.surfaces.similarity import Similarity


@compiled
def _meet(
    numbers: np.ndarray, origin: Vector, direction: Vector, distance: float, u: float, v: float, facing: Vector
) -> tuple[bool, float, Vector]:
    met = False
    normal = (numbers[3], numbers[4], numbers[5])
    slope = dot(direction, normal)
    if abs(slope) > 1e-12:
        distance = dot(along((numbers[0], numbers[1], numbers[2]), -1.0, origin), normal) / slope
        met = True
    return met, distance, normal


@compiled
def _expand(numbers: np.ndarray, place: Vector) -> Expansion:
    edge_u, edge_v = (numbers[6], numbers[7], numbers[8]), (numbers[9], numbers[10], numbers[11])
    position = along(along((numbers[0], numbers[1], numbers[2]), place[0], edge_u), place[1], edge_v)
    return True, position, edge_u, edge_v, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Plane(Surface):
    """position = origin + u * edge_u + v * edge_v; the normal is edge_u x edge_v, normalised.

    Parameters
    ----------
    origin : (3,) array
        Metres.
    edge_u, edge_v : (3,) array
        Metres; they need be neither perpendicular nor of one length.
    """

    origin: np.ndarray
    edge_u: np.ndarray
    edge_v: np.ndarray

    meet = staticmethod(_meet)
    expand = staticmethod(_expand)

    @property
    def numbers(self) -> np.ndarray:
        return np.concatenate([self.origin, self.normal(np.zeros((1, 2)))[0], self.edge_u, self.edge_v])

    def position(self, uv: np.ndarray) -> np.ndarray:
        u, v = np.asarray(uv, float).T
        return np.asarray(self.origin) + u[:, None] * self.edge_u + v[:, None] * self.edge_v

    def normal(self, uv: np.ndarray) -> np.ndarray:
        normal = np.cross(self.edge_u, self.edge_v)
        return np.broadcast_to(normal / np.linalg.norm(normal), (len(uv), 3)).copy()

    def curvatures(self, uv: np.ndarray) -> np.ndarray:
        return np.zeros((len(uv), 2))

    def parameters(self, points: np.ndarray, near: np.ndarray | None = None) -> np.ndarray:
        edges = np.stack([self.edge_u, self.edge_v]).astype(float)
        return (np.asarray(points, float) - self.origin) @ np.linalg.pinv(edges)

    def moved(self, by: Similarity) -> Plane:
        return Plane(by.points(self.origin), by.vectors(self.edge_u), by.vectors(self.edge_v))
