"""Triangles on a trimmed surface: a lattice in (u, v), joined to points on the very curves that trim it.

The triangulation is Delaunay's, in lattice cells for a unit of length; where it does not follow a trim curve, the
curve gets a point more (J. Ruppert, "A Delaunay refinement algorithm for quality 2-dimensional mesh generation", 1995).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.spatial import Delaunay, KDTree

from anamorph.gallery.solids import lattice
from anamorph.surfaces.bsplines import basis
from anamorph.surfaces.nurbs import NurbsSurface

BOW = 0.01
"""How far a trim curve may leave the straight line between two of its points, in cells."""
CLEARANCE = 0.5
"""Lattice points nearer than this to a trim curve are left out, in cells."""
JOINED = 1e-4
"""Points nearer than this are one, in cells."""
LEAST = 0.125
"""Cells along the shorter side of a flat face, as a share of those along the longer."""
ROUNDS = 24


@dataclass(frozen=True, eq=False)
class TrimCurve:
    """A rational B-spline curve in the parameters of a surface: part of the border of a face.

    Parameters
    ----------
    poles : (P, 2) float64
    weights : (P,) float64
    knots : (P + degree + 1,) float64
    degree : int
    """

    poles: np.ndarray
    weights: np.ndarray
    knots: np.ndarray
    degree: int

    def points(self, at: np.ndarray) -> np.ndarray:
        """(u, v), (N, 2), at shares (N,) of the way from the start, 0, to the end, 1."""
        low, high = self.knots[self.degree], self.knots[-self.degree - 1]
        values = basis(self.knots, self.degree, low + (high - low) * np.asarray(at, float)) * self.weights
        return values @ self.poles / values.sum(axis=1, keepdims=True)


def tessellate(surface: NurbsSurface, curves: Sequence[TrimCurve], density: int) -> tuple[np.ndarray, np.ndarray]:
    """Triangles on the part of `surface` inside `curves`.

    Parameters
    ----------
    surface : NurbsSurface
    curves : sequence of TrimCurve
        All borders of the face, in any order: inside is what a line from outside reaches by crossing an odd number of
        them. None for the whole surface.
    density : int
        Cells of the lattice along the longer side of the face, and to a full turn of its normal along either.

    Returns
    -------
    parameters : (V, 2) float64
    faces : (F, 3) int32
        Counter-clockwise in (u, v).
    """
    low, high = surface.domain
    start = np.linspace(0.0, 1.0, 33)
    borders = [curve.points(start) for curve in curves]
    if borders:
        points = np.concatenate(borders)
        low, high = np.maximum(low, points.min(axis=0)), np.minimum(high, points.max(axis=0))
    cells = _cells(surface, low, high, density)
    on_box = [_on_box((border - low) / (high - low)) for border in borders]
    if all(on_box):
        return _lattice(low, high, cells)
    scale = (high - low) / cells
    segments = [segment for number, curve in enumerate(curves) for segment in _sampled(curve, number, low, scale)]
    inside = _outline(curves, segments, low, scale)[0]
    corners = inside[:, :2], inside[:, 2:]
    inner = _lattice(np.zeros(2), cells.astype(float), cells)[0]
    inner = inner[_within(inner, *corners)]
    along = np.linspace(0.0, 1.0, 5)[:, None, None]
    near = ((1.0 - along) * corners[0] + along * corners[1]).reshape(-1, 2)
    inner = inner[KDTree(near).query(inner)[0] > CLEARANCE] if len(inner) else inner
    points, triangles, outline = _triangulated(curves, segments, inner, low, scale)
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    triangles = np.where(area[:, None] < 0.0, triangles[:, ::-1], triangles)
    kept = (np.abs(area) > JOINED**2) & _within((a + b + c) / 3.0, outline[:, :2], outline[:, 2:])
    used, faces = np.unique(triangles[kept], return_inverse=True)
    parameters = np.clip(low + points[used] * scale, *surface.domain)
    return parameters, faces.reshape(-1, 3).astype(np.int32)


def _triangulated(
    curves: Sequence[TrimCurve], segments: list[Segment], inner: np.ndarray, low: np.ndarray, scale: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points (V, 2) in cells, triangles between them, and the straight pieces of the border, all sides of triangles."""
    for _ in range(ROUNDS):
        outline, ends, border = _outline(curves, segments, low, scale)
        points = np.concatenate([border, inner])
        triangles = Delaunay(points).simplices
        sides = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
        missing = ~np.isin(_key(np.sort(ends, axis=1)), _key(sides)) & (ends[:, 0] != ends[:, 1])
        if not missing.any():
            break
        segments = [piece for segment, cut in zip(segments, missing, strict=True) for piece in _halves(segment, cut)]
    return points, triangles, outline


Segment = tuple[int, float, float]
"""A curve's number, and the shares of it between which this piece of the border runs."""


def _cells(surface: NurbsSurface, low: np.ndarray, high: np.ndarray, density: int) -> np.ndarray:
    """Cells of the lattice along u and v, (2,) int: about as long as broad, and `density` of them to a full turn."""
    steps = np.linspace(0.0, 1.0, 9)
    uv = low + np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2) * (high - low)
    normals = surface.normal(uv).reshape(9, 9, 3)
    lengths, turns = [], []
    for axis, orders in enumerate(((1, 0), (0, 1))):
        lengths.append(np.linalg.norm(surface.derivative(uv, *orders), axis=1).mean() * (high - low)[axis])
        cosines = np.sum(np.moveaxis(normals, axis, 0)[1:] * np.moveaxis(normals, axis, 0)[:-1], axis=-1)
        turns.append(np.arccos(np.clip(cosines, -1.0, 1.0)).sum(axis=0).max() / (2.0 * np.pi))
    shares = np.maximum.reduce([np.array(lengths) / max(*lengths, 1e-300), turns, np.full(2, LEAST)])
    return np.ceil(density * np.minimum(shares, 1.0) - 1e-6).astype(int)


def _on_box(points: np.ndarray) -> bool:
    """Whether a border runs along one side of the unit square."""
    sides = np.abs(np.concatenate([points, 1.0 - points], axis=1)) < 1e-7
    return bool(sides.all(axis=0).any())


def _lattice(low: np.ndarray, high: np.ndarray, cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    u, v = (np.linspace(low[axis], high[axis], cells[axis] + 1) for axis in range(2))
    points = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    return points, lattice(cells[1] + 1, cells[0] + 1).astype(np.int32)


def _sampled(curve: TrimCurve, number: int, low: np.ndarray, scale: np.ndarray) -> list[Segment]:
    """A curve in pieces that are at most a cell long and nearly straight."""
    inner = np.unique(curve.knots[curve.degree : len(curve.knots) - curve.degree])
    borders = (inner - inner[0]) / (inner[-1] - inner[0])
    todo, done = list(pairwise(borders)), []
    while todo:
        first, last = todo.pop()
        points = (curve.points(first + (last - first) * np.linspace(0.0, 1.0, 5)) - low) / scale
        line = points[0] + np.linspace(0.0, 1.0, 5)[:, None] * (points[4] - points[0])
        bow = np.linalg.norm(points - line, axis=1).max()
        if (bow > BOW or np.linalg.norm(points[4] - points[0]) > 1.0) and last - first > 1e-5:
            middle = (first + last) / 2.0
            todo += [(first, middle), (middle, last)]
        else:
            done.append((number, first, last))
    return done


def _halves(segment: Segment, cut: bool) -> list[Segment]:
    number, first, last = segment
    middle = (first + last) / 2.0
    return [(number, first, middle), (number, middle, last)] if cut else [segment]


def _outline(
    curves: Sequence[TrimCurve], segments: list[Segment], low: np.ndarray, scale: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The border in cells: its straight pieces (S, 4), their ends (S, 2) as rows of its points (P, 2)."""
    shares = np.array([segment[1:] for segment in segments])
    numbers = np.array([segment[0] for segment in segments])
    ends = np.empty((len(segments), 2, 2))
    for number, curve in enumerate(curves):
        own = numbers == number
        ends[own] = ((curve.points(shares[own].ravel()) - low) / scale).reshape(-1, 2, 2)
    points = ends.reshape(-1, 2)
    # Curves that meet end at one point, but for the tolerance of the program that made them.
    group = np.arange(len(points))
    for one, other in sorted(KDTree(points).query_pairs(JOINED)):
        group[other] = group[one]
    chosen, rows = np.unique(group, return_inverse=True)
    points = points[chosen]
    index = rows.reshape(-1, 2)
    return points[index].reshape(-1, 4), index, points


def _within(points: np.ndarray, starts: np.ndarray, stops: np.ndarray) -> np.ndarray:
    """Whether points (N, 2) lie inside a border of straight pieces (S, 2): a line to the side meets an odd number."""
    odd = np.zeros(len(points), bool)
    x, y = points.T
    for (x0, y0), (x1, y1) in zip(starts, stops, strict=True):
        if y0 != y1:
            odd ^= ((y0 <= y) != (y1 <= y)) & (x < x0 + (y - y0) * ((x1 - x0) / (y1 - y0)))
    return odd


def _key(pairs: np.ndarray) -> np.ndarray:
    """One integer for two vertices, the lesser first."""
    return pairs[:, 0].astype(np.int64) << 32 | pairs[:, 1]
