"""Polished cookware on exact surfaces: closed convex bodies, turned or nearly square, and bowls to look into."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from anamorph.gallery.solids import lattice
from anamorph.scene.model import Mesh, Mirror
from anamorph.surfaces.nurbs import NurbsSurface
from anamorph.surfaces.sphere import Sphere

ROUND = 0.5**0.5
"""The weight of a square's corners that makes its conic arcs a circle; a larger one comes nearer to the square."""

STEEL = Mirror(tint=(0.97, 0.98, 1.0), reflectance=0.86)
COPPER = Mirror(tint=(1.0, 0.78, 0.62), reflectance=0.88)


def turned_body(
    name: str,
    profile: Sequence[tuple[float, float]],
    place: tuple[float, float, float],
    material: Mirror,
    corner: float = ROUND,
    stretch: tuple[float, float] = (1.0, 1.0),
    rows: int = 32,
    columns: int = 64,
) -> Mesh:
    """A closed body on one NURBS surface.

    Parameters
    ----------
    name, material
        Of the mesh.
    profile : sequence of (radius, height)
        Poles of a cubic spline from the middle of the bottom to that of the top, metres. If their polygon is convex,
        so is the body.
    place : (3,) float
        Where its origin stands, metres.
    corner : float
        How square it is seen from above: the weight of corners.
    stretch : (x, z) float
        Of the radius along these axes.
    rows, columns : int
        Of cells.
    """
    radius, height = np.asarray(profile, float).T
    around = np.array([(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)], float)
    poles = np.empty((len(around), len(radius), 3))
    poles[..., 0] = stretch[0] * np.multiply.outer(around[:, 0], radius)
    poles[..., 1] = height
    poles[..., 2] = -stretch[1] * np.multiply.outer(around[:, 1], radius)
    weights = np.repeat(np.where(np.arange(len(around)) % 2, corner, 1.0)[:, None], len(radius), axis=1)
    inner = np.arange(1, len(radius) - 3) / (len(radius) - 3)
    surface = NurbsSurface(
        poles=poles + place,
        weights=weights,
        knots_u=np.repeat([0.0, 0.25, 0.5, 0.75, 1.0], [3, 2, 2, 2, 3]),
        knots_v=np.concatenate([np.zeros(4), inner, np.ones(4)]),
        degree_u=2,
        degree_v=3,
    )
    u, v = np.meshgrid(np.linspace(0.0, 1.0, columns + 1), np.linspace(0.0, 1.0, rows + 1))
    faces = lattice(rows + 1, columns + 1).reshape(rows, columns, 2, 3)
    faces = np.concatenate([faces[0, :, 1], faces[1:-1].reshape(-1, 3), faces[-1, :, 0]])
    parameters = np.stack([u.ravel(), v.ravel()], axis=-1)
    return Mesh.exact(name, surface, parameters, faces, material, decimals=9)


def bowl(name: str, middle: tuple[float, float, float], radius: float, depth: float, material: Mirror) -> Mesh:
    """The inside of the part of a sphere around `middle` that is no more than `depth` above its lowest point."""
    rows, columns = 24, 64
    highest = np.arcsin(depth / radius - 1.0)
    u, v = np.meshgrid(np.linspace(-np.pi, np.pi, columns + 1), np.linspace(-0.5 * np.pi, highest, rows + 1))
    faces = lattice(rows + 1, columns + 1).reshape(rows, columns, 2, 3)
    faces = np.concatenate([faces[0, :, 1], faces[1:].reshape(-1, 3)])
    return Mesh.exact(
        name,
        Sphere(np.asarray(middle, float), radius),
        np.stack([u.ravel(), v.ravel()], axis=-1),
        faces[:, ::-1],
        material,
        toward=np.array([0.0, 1.0, 0.0]),
        decimals=9,
    )
