"""Moving meshes, with the exact shapes that they carry."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.scene.model import Mesh
from anamorph.surfaces.nurbs import NurbsSurface
from anamorph.surfaces.sag import EvenAsphere, Toroid
from anamorph.surfaces.shapes import BezierPatch, Plane, Sphere, Surface


@dataclass(frozen=True, eq=False)
class Similarity:
    """point -> scale * rotation @ point + translation, which keeps shapes alike.

    Parameters
    ----------
    scale : float
        Positive.
    rotation : (3, 3) float64
    translation : (3,) float64
        Metres.
    """

    scale: float
    rotation: np.ndarray
    translation: np.ndarray

    def points(self, points: np.ndarray) -> np.ndarray:
        """Points, (..., 3), moved."""
        return self.scale * np.asarray(points, float) @ self.rotation.T + self.translation

    def vectors(self, vectors: np.ndarray) -> np.ndarray:
        """Differences of points, (..., 3), moved."""
        return self.scale * np.asarray(vectors, float) @ self.rotation.T


def rotation(degrees: tuple[float, float, float]) -> np.ndarray:
    """Turn about the fixed x axis, then y, then z, each anticlockwise seen from its tip: (3, 3) float64."""
    matrix = np.eye(3)
    for axis, angle in enumerate(np.radians(degrees)):
        turn = np.eye(3)
        one, other = (axis + 1) % 3, (axis + 2) % 3
        turn[one, one] = turn[other, other] = np.cos(angle)
        turn[other, one] = np.sin(angle)
        turn[one, other] = -np.sin(angle)
        matrix = turn @ matrix
    return matrix


def transform(mesh: Mesh, by: Similarity) -> Mesh:
    """The mesh moved, with its exact surface."""
    return replace(
        mesh,
        positions=by.points(mesh.positions).astype(np.float32),
        normals=(np.asarray(mesh.normals, float) @ by.rotation.T).astype(np.float32),
        surface=None if mesh.surface is None else _surface(mesh.name, mesh.surface, by),
    )


def _surface(name: str, surface: Surface, by: Similarity) -> Surface:
    match surface:
        case Plane(origin=origin, edge_u=edge_u, edge_v=edge_v):
            return Plane(by.points(origin), by.vectors(edge_u), by.vectors(edge_v))
        case Sphere(center=center, radius=radius, axes=axes):
            return Sphere(by.points(center), by.scale * radius, np.asarray(axes, float) @ by.rotation.T)
        case BezierPatch(control=control):
            return BezierPatch(by.points(control))
        case NurbsSurface(poles=poles):
            return replace(surface, poles=by.points(poles))
        case Toroid(apex=apex, base_curvature=base, cross_curvature=cross, axes=axes):
            turned = np.asarray(axes, float) @ by.rotation.T
            return Toroid(by.points(apex), base / by.scale, cross / by.scale, turned)
        case EvenAsphere(apex=apex, curvature=curvature, conic=conic, coefficients=values, axes=axes):
            turned = np.asarray(axes, float) @ by.rotation.T
            scaled = tuple(value * by.scale ** (-3 - 2 * power) for power, value in enumerate(values))
            return EvenAsphere(by.points(apex), curvature / by.scale, conic, scaled, turned)
    raise AnamorphError(f"part '{name}': a {type(surface).__name__} cannot be moved; move the rest of the scene")
