"""Triangles anywhere, rays anywhere, and where they meet by a search through them all."""

from __future__ import annotations

import numpy as np

from anamorph.scene.camera import Camera
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Mesh, Scene


def geometry_of(positions, faces):
    positions = np.asarray(positions, np.float32)
    mesh = Mesh("soup", positions, np.asarray(faces, np.int32).reshape(-1, 3), np.zeros_like(positions))
    return flatten(Scene("test", (mesh,), Camera((0, 0, 1), (0, 0, 0))))


def soup(count=60, scale=1.0, seed=0):
    random = np.random.default_rng(seed)
    positions = (random.uniform(-1, 1, (count, 1, 3)) + random.normal(scale=0.3, size=(count, 3, 3))) * scale
    return geometry_of(positions.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3))


def brute_force(geometry, origins, directions, near: float | np.ndarray = 0.0):
    """Moeller and Trumbore's test of every ray with every triangle, in float64."""
    a, b, c = np.moveaxis(geometry.positions.astype(float)[geometry.faces], 1, 0)
    edge_1, edge_2 = b - a, c - a
    across = np.cross(directions[:, None], edge_2)
    determinant = np.sum(across * edge_1, axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        to_origin = origins[:, None] - a
        u = np.sum(to_origin * across, axis=-1) / determinant
        along = np.cross(to_origin, edge_1)
        v = np.sum(directions[:, None] * along, axis=-1) / determinant
        distance = np.sum(edge_2 * along, axis=-1) / determinant
        inside = (u >= 0) & (v >= 0) & (u + v <= 1) & (distance > near)
    distance = np.where(inside, distance, np.inf)
    triangle = np.where(np.isfinite(distance.min(axis=1)), distance.argmin(axis=1), -1)
    row = np.arange(len(origins))
    return distance.min(axis=1), triangle, np.stack([u, v], axis=-1)[row, triangle]


def random_rays(count, scale=1.0, seed=1):
    random = np.random.default_rng(seed)
    directions = random.normal(size=(count, 3))
    return random.uniform(-2, 2, (count, 3)) * scale, directions / np.linalg.norm(directions, axis=1, keepdims=True)
