"""Exact surfaces that the gallery does not have, and meshes that stand on them."""

from __future__ import annotations

import numpy as np

from anamorph.gallery.solids import lattice
from anamorph.scene.model import Mesh, Mirror
from anamorph.scene.triangles import doubled_areas, has_area
from anamorph.surfaces.bezier import BezierPatch
from anamorph.surfaces.nurbs import NurbsSurface

HALF = np.sqrt(0.5)

QUARTERS = np.array([0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4.0])

CENTER, RADIUS = np.array([0.3, -0.2, 0.5]), 1.4
FIELDS = ("weights", "knots_u", "knots_v", "degree_u", "degree_v", "sign")


def ring():
    """A unit circle of four quarters, as poles (9, 2) and weights (9,)."""
    poles = np.array([[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1], [1, 0.0]])
    return poles, np.where(np.arange(9) % 2, HALF, 1.0)


def revolved(profile, weights, knots, sign=1.0):
    """Poles (P, 2) of radius and height turned about the z axis; its parts are rational quadrics."""
    circle, round_weights = ring()
    poles = np.zeros((9, len(profile), 3))
    poles[..., :2] = circle[:, None] * profile[None, :, :1]
    poles[..., 2] = profile[:, 1]
    return NurbsSurface(poles, np.outer(round_weights, weights), QUARTERS, knots, 2, 2, sign)


def sphere_surface(center=CENTER, radius=RADIUS, sign=1.0):
    profile = np.array([[0, -1], [1, -1], [1, 0], [1, 1], [0, 1.0]])
    surface = revolved(profile, np.array([1, HALF, 1, HALF, 1]), np.array([0, 0, 0, 1, 1, 2, 2, 2.0]), sign)
    return NurbsSurface(center + radius * surface.poles, *(getattr(surface, name) for name in FIELDS))


def torus_surface(major, minor, sign=1.0):
    circle, weights = ring()
    return revolved(minor * circle + [major, 0.0], weights, QUARTERS, sign)


def height_field(seed=0, degrees=(3, 4), spans=(3, 2)):
    """A rational height field with simple inner knots."""
    random = np.random.default_rng(seed)
    knots = [
        np.concatenate([[0.0] * d, np.linspace(0, 2, n + 1), [2.0] * d]) for d, n in zip(degrees, spans, strict=True)
    ]
    shape = tuple(d + n for d, n in zip(degrees, spans, strict=True))
    x, y = np.meshgrid(*(np.linspace(0, 1, n) for n in shape), indexing="ij")
    poles = np.stack([x, y, 0.1 * random.normal(size=shape)], axis=-1)
    return NurbsSurface(poles, random.uniform(0.7, 1.4, shape), *knots, *degrees)


def mesh_on(surface, low, high, cells=(6, 5), side=1.0):
    """A lattice over a box of parameters, without the triangles that have no area."""
    u, v = (np.linspace(low[axis], high[axis], cells[axis] + 1) for axis in range(2))
    uv = np.stack([each.ravel() for each in np.meshgrid(u, v)], axis=-1)
    positions = np.round(surface.position(uv), 9).astype(np.float32)
    faces = lattice(cells[1] + 1, cells[0] + 1)
    faces = faces[has_area(positions, faces)]
    normals = side * surface.normal(uv)
    area = doubled_areas(positions, faces)
    outward = np.sum(area * normals[faces].mean(axis=1), axis=1) > 0.0
    faces = np.where(outward[:, None], faces, faces[:, ::-1]).astype(np.int32)
    return Mesh("mesh", positions, faces, normals.astype(np.float32), Mirror(), surface=surface, parameters=uv)


def wavy():
    control = np.stack([*np.meshgrid(np.arange(4.0), np.arange(4.0), indexing="ij"), np.zeros((4, 4))], axis=-1)
    control[1:3, 1:3, 2] = [[1.5, -0.8], [0.4, 1.1]]
    return BezierPatch(0.1 * control)
