"""Meshes over shapes, and the plain ones: discs, squares, balls, tubes, boxes and height fields."""

from __future__ import annotations

import numpy as np
from scipy.spatial import Delaunay

from oracle.sags import ASPHERE, TOROID, sag, sag_numbers
from oracle.scene import Mesh, Shape, Trim


def disc(rings: int) -> tuple[np.ndarray, np.ndarray]:
    """Points in a unit circle, (N, 2), and triangles; ring k has 6 k points, the last of them at the border."""
    points = [np.zeros((1, 2))]
    for ring in range(1, rings + 1):
        angle = np.arange(6 * ring) * np.pi / (3 * ring)
        points.append(ring / rings * np.stack([np.cos(angle), np.sin(angle)], axis=-1))
    places = np.concatenate(points)
    return places, _counter_clockwise(places, Delaunay(places).simplices)


def square(cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Points in the square from -1 to 1, (N, 2), and triangles."""
    ticks = np.linspace(-1.0, 1.0, cells + 1)
    places = np.stack(np.meshgrid(ticks, ticks), axis=-1).reshape(-1, 2)
    return places, lattice(cells + 1, cells + 1)


def lattice(rows: int, columns: int) -> np.ndarray:
    """Two triangles for each cell of a lattice of points that are numbered row by row."""
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    two = np.array([[0, 1, columns + 1], [0, columns + 1, columns]])
    return (first[:, None] + two[:, None]).reshape(-1, 3)


def _counter_clockwise(places: np.ndarray, faces: np.ndarray) -> np.ndarray:
    a, b, c = np.moveaxis(places[faces], 1, 0)
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    return np.where(area[:, None] > 0.0, faces, faces[:, ::-1])[np.abs(area) > 1e-9]


def over(shape: Shape, trim: Trim, places: np.ndarray, faces: np.ndarray) -> Mesh:
    """A mesh over a shape whose axis is the trim's: at `places` (N, 2) across it, metres in the trim's axes."""
    points = trim.origin + places @ trim.axes[:2]
    local = (points - shape.origin) @ shape.axes.T
    across, height, slopes = local[:, :2], *heights(shape, local[:, :2])
    positions = shape.origin + np.column_stack([across, height]) @ shape.axes
    normals = np.column_stack([-slopes, np.ones(len(slopes))]) @ shape.axes
    normals *= shape.side / np.linalg.norm(normals, axis=1, keepdims=True)
    outward = shape.side * (trim.axes[2] @ shape.axes[2]) > 0.0
    parameters = across
    if shape.kind == "sphere":
        up = np.arcsin(np.clip(across[:, 1] / shape.numbers[0], -1.0, 1.0))
        parameters = np.column_stack([np.arctan2(across[:, 0], height), up])
    return Mesh(positions, normals, faces if outward else faces[:, ::-1], parameters)


def heights(shape: Shape, across: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A shape's height along its axis, (N,), at x and y across it, (N, 2), and the height's slopes, (N, 2)."""
    if shape.kind == "plane":
        return np.zeros(len(across)), np.zeros(across.shape)
    if shape.kind == "sphere":
        height = np.sqrt(shape.numbers[0] ** 2 - np.sum(across**2, axis=1))
        return height, -across / height[:, None]
    kind, numbers = {"toroid": TOROID, "asphere": ASPHERE}[shape.kind], np.array(sag_numbers(shape), float)
    found = np.array([sag(kind, numbers, x, y) for x, y in across], float)
    if not found[:, 0].all():
        raise ValueError(f"{shape.kind} does not reach {np.linalg.norm(across, axis=1).max():g} m from its axis")
    return -found[:, 1], -found[:, 2:]


def ball(center: np.ndarray, radius: float, rows: int, columns: int, side: float = 1.0) -> Mesh:
    """A whole ball by latitude and longitude; turned inside out where `side` is -1."""
    up, around = np.meshgrid(
        np.linspace(-0.5 * np.pi, 0.5 * np.pi, rows + 1), np.linspace(-np.pi, np.pi, columns + 1), indexing="ij"
    )
    parameters = np.stack([around.ravel(), up.ravel()], axis=-1)
    flat = np.cos(up)
    normals = np.stack([flat * np.sin(around), np.sin(up), flat * np.cos(around)], axis=-1).reshape(-1, 3)
    normals = _closed(normals)
    faces = lattice(rows + 1, columns + 1)
    first = np.arange(len(faces)) < rows * columns
    cell = np.arange(len(faces)) % (rows * columns) // columns
    # At a pole one of a cell's two triangles has no area.
    faces = faces[np.where(first, cell > 0, cell < rows - 1)]
    return Mesh(center + radius * normals, side * normals, faces if side > 0 else faces[:, ::-1], parameters)


def tube(origin: np.ndarray, axes: np.ndarray, radii: tuple[float, float], length: float, around: int, up: int) -> Mesh:
    """A cylinder or cone about the third axis, from the origin to `length`, open at both ends."""
    share, angle = np.meshgrid(np.linspace(0.0, 1.0, up + 1), np.linspace(0.0, 2.0 * np.pi, around + 1), indexing="ij")
    radius = radii[0] + share * (radii[1] - radii[0])
    way = _closed(np.stack([np.cos(angle), np.sin(angle)], axis=-1))
    local = np.concatenate([radius[..., None] * way, length * share[..., None]], axis=-1).reshape(-1, 3)
    lean = np.full((*share.shape, 1), (radii[0] - radii[1]) / length)
    normals = np.concatenate([way, lean], axis=-1).reshape(-1, 3)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Mesh(origin + local @ axes, normals @ axes, lattice(up + 1, around + 1))


def _closed(values: np.ndarray) -> np.ndarray:
    """Cosines and sines that are the same after a whole turn: else the seam is a crack as wide as their rounding."""
    return np.round(values, 15)


CUBE = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
SIDES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))


def box(center: np.ndarray, axes: np.ndarray, half: np.ndarray) -> Mesh:
    """A box with flat sides, and its middle, axes and half lengths."""
    corners = (CUBE[np.array(SIDES)] * half) @ axes + center
    normals = np.repeat(np.cross(corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0]), 4, axis=0)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    faces = np.concatenate([4 * np.arange(6)[:, None] + [0, 1, 2], 4 * np.arange(6)[:, None] + [0, 2, 3]])
    return Mesh(corners.reshape(-1, 3), normals, faces)


def rectangle(center: np.ndarray, right: np.ndarray, up: np.ndarray) -> Mesh:
    """Two triangles: the middle and two half sides; it looks along right x up."""
    corners = np.array(center) + np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) @ np.array([right, up], float)
    normal = np.cross(right, up)
    return Mesh(corners, np.tile(normal / np.linalg.norm(normal), (4, 1)), np.array([[0, 1, 2], [0, 2, 3]]))
