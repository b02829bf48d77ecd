"""Rays, points and planes as solid things, so that the package itself can draw diagrams of what it computes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

import anamorph as an
from anamorph.gallery.solids import Solid, icosphere, join, lattice
from anamorph.projection import Projection
from anamorph.scene.model import Color

SIDES = 6
"""Of a rod."""
PAPER = (1.0, 1.0, 1.0)
EYE: Color = (0.06, 0.08, 0.12)
INCIDENT: Color = (0.05, 0.16, 0.62)
REFLECTED: Color = (0.02, 0.42, 0.62)
EXTENDED: Color = (0.86, 0.50, 0.02)
VIEWPOINT: Color = (0.80, 0.02, 0.02)
VOLUME: Color = (0.02, 0.34, 0.08)
SURFACE: Color = (0.25, 0.29, 0.34)


def rods(segments: np.ndarray, radius: float, color: Color, name: str) -> an.Mesh:
    """Thin straight tubes between pairs of points, `segments` (N, 2, 3), as one diffuse mesh."""
    segments = np.asarray(segments, float)
    along = segments[:, 1] - segments[:, 0]
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    other = np.where(np.abs(along[:, 1:2]) < 0.9, [[0.0, 1.0, 0.0]], [[1.0, 0.0, 0.0]])
    across = np.cross(along, other)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    beside = np.cross(along, across)
    angle = np.arange(SIDES) * 2.0 * np.pi / SIDES
    normals = np.cos(angle)[:, None] * across[:, None] + np.sin(angle)[:, None] * beside[:, None]
    rings = segments[:, :, None] + radius * normals[:, None]
    one = lattice(2, SIDES, closed=True)
    faces = (one + 2 * SIDES * np.arange(len(segments))[:, None, None]).reshape(-1, 3)
    return an.Mesh(
        name,
        rings.reshape(-1, 3).astype(np.float32),
        faces.astype(np.int32),
        np.repeat(normals[:, None], 2, axis=1).reshape(-1, 3).astype(np.float32),
        an.Diffuse(color),
    )


def balls(centers: Sequence[np.ndarray], radius: float, color: Color, name: str) -> an.Mesh:
    """Balls around points, as one diffuse mesh."""
    points, faces = icosphere(3)
    flat = np.zeros((len(points), 2))
    parts = [Solid(points * radius + center, points, flat, np.ones_like(points), faces) for center in centers]
    return join(parts).mesh(name, an.Diffuse(color))


def edges(mesh: an.Mesh, diagonals: bool = False) -> np.ndarray:
    """The edges of a mesh once each, (N, 2, 3); of two triangles that make a quadrangle not the longest one."""
    corners = mesh.faces[:, [[0, 1], [1, 2], [2, 0]]]
    if not diagonals:
        points = np.asarray(mesh.positions, float)
        lengths = np.linalg.norm(points[corners[..., 1]] - points[corners[..., 0]], axis=-1)
        keep = np.arange(3) != lengths.argmax(axis=1)[:, None]
        corners = corners[keep]
    pairs = np.unique(np.sort(corners.reshape(-1, 2), axis=1), axis=0)
    return np.asarray(mesh.positions, float)[pairs]


def volume(projection: Projection, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Corners of a view volume's near plane, (4, 3), and of its sides `reach` metres further on."""
    places = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    points = np.column_stack([places, np.ones((4, 2))]) @ np.linalg.inv(projection.clip).T
    near = points[:, :3] / points[:, 3:]
    lines = projection.base + places @ np.stack([projection.right, projection.up])
    return near, near + reach * lines / np.linalg.norm(lines, axis=1, keepdims=True)


def loop(corners: np.ndarray) -> np.ndarray:
    """The sides, (N, 2, 3), of a closed polygon (N, 3)."""
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)


def sheet(corners: np.ndarray, color: Color, name: str) -> an.Mesh:
    """A flat convex polygon (N, 3), to be seen from both sides."""
    count = len(corners)
    fan = np.array([[0, i, i + 1] for i in range(1, count - 1)])
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    normal /= np.linalg.norm(normal)
    return an.Mesh(
        name,
        np.concatenate([corners, corners]).astype(np.float32),
        np.concatenate([fan, fan[:, ::-1] + count]).astype(np.int32),
        np.repeat([normal, -normal], count, axis=0).astype(np.float32),
        an.Diffuse(color),
    )


def drawing(name: str, meshes: Sequence[an.Mesh], camera: an.Camera) -> an.Scene:
    """Things on white paper."""
    return an.Scene(
        name,
        tuple(meshes),
        camera,
        (an.AmbientLight((0.95, 0.95, 0.95), (0.80, 0.80, 0.80)),),
        an.Sky(PAPER, PAPER, PAPER),
    )


def far_camera(target: np.ndarray, toward: ArrayLike, up: ArrayLike, height: float) -> an.Camera:
    """A camera so far away that parallels stay parallel, which sees `height` metres around `target`."""
    distance = 40.0 * height
    x, y, z = np.asarray(target) + distance * np.asarray(toward, float) / np.linalg.norm(toward)
    fov = float(np.degrees(2.0 * np.arctan(0.5 * height / distance)))
    a, b, c = target
    u, v, w = np.asarray(up, float)
    return an.Camera(
        (float(x), float(y), float(z)), (float(a), float(b), float(c)), (float(u), float(v), float(w)), fov
    )
