"""What a scene triangle becomes in a ray triangle: one to four shapes of two to nine vertices, and their visible part.

Source: Vallance 2005, sections 4.1 to 4.3 (with `chains`), and 4.6: what lies behind the origins is cut away, exactly,
on the edges of the scene triangle. Here for one scene triangle and for looking at; `bulk` draws many.

Deviation: corners count by the roots of their cubics, whether or not float64 can tell the ray that leads there, so that
no far vertex breaks a shape.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.methods.trilinear.straight.chains import LINKS, OPEN, SHAPES, connected
from anamorph.methods.trilinear.straight.traces import edge_ray, edge_weight
from anamorph.raytriangle.rows import PACE, SHIFT, packed
from anamorph.raytriangle.scaled import scaled_rays
from anamorph.raytriangle.solve import AFTER, BEFORE, ROOT, ROOTS, VALID, WORDS, solve_point


@dataclass(frozen=True, eq=False)
class Shape:
    """A polygon over the plane of the ray triangle's weights; what of it lies outside the ray triangle is not seen.

    Parameters
    ----------
    t, u, v : (K,) float64
        Its K vertices around the outline. t is infinite where the shape goes on to infinity, which happens only if
        all rays are parallel to one plane.
    valid : (K,) bool
        Where a ray leads to the vertex, as in `Projections.valid`; elsewhere u and v are 0.
    weights : (K, 3) float64
        Where the vertex lies on the scene triangle. A corner has one weight of 1.
    edges : (K,) int
        From each vertex to the next the outline follows the scene edge opposite to this corner, 0 to 2, with t rising
        or falling all the way; -1 where it follows none: along the view plane, or at infinity.
    """

    t: np.ndarray
    u: np.ndarray
    v: np.ndarray
    valid: np.ndarray
    weights: np.ndarray
    edges: np.ndarray

    def __len__(self) -> int:
        return len(self.t)


class _Vertex(NamedTuple):
    """A vertex of a chain, and the scene edge that is followed from it; its corner, or OPEN for what is none."""

    t: float
    u: float
    v: float
    valid: bool
    weights: np.ndarray
    edge: int
    corner: int


def project_triangle(
    origins: np.ndarray, directions: np.ndarray, corners: np.ndarray, nearest: float = -np.inf
) -> tuple[Shape, ...]:
    """The shapes of a scene triangle in a ray triangle, in the order in which they end as t grows.

    Two vertices enclose nothing as long as lines between vertices are straight; in truth they are curved.

    Parameters
    ----------
    origins, directions : (3, 3) array
        A row for each of the three rays.
    corners : (3, 3) array
        The corners of the scene triangle.
    nearest : float
        Keep only what has t >= nearest: 0 for what lies before the origins. Where the three origins coincide, no ray
        leads to a vertex at t = 0; give a little more. By default everything is kept, negative t included.

    Raises
    ------
    AnamorphError
        If a shape or a number is not as stated.
    """
    origins, directions, corners = (np.asarray(array, float) for array in (origins, directions, corners))
    if any(array.shape != (3, 3) for array in (origins, directions, corners)):
        raise AnamorphError("project_triangle: origins, directions and corners must be three rows of three numbers")
    if not np.isfinite(corners).all():
        raise AnamorphError("project_triangle: corners must be finite numbers")
    rays = scaled_rays(origins[None], directions[None])
    if rays.flat[0]:
        return ()
    row, solved = packed(rays)[0], np.zeros((3, WORDS))
    for corner, place in zip(solved, corners, strict=True):
        solve_point(row, *place, np.zeros(8), corner)
    links, ends = np.zeros((2, LINKS, 3), np.int64), np.zeros((SHAPES, 2), np.int64)
    shapes, starts = [], np.zeros(2, np.int64)
    for stops in ends[: connected(solved, links, ends)]:
        left, right = (_chain(row, solved, links[side, starts[side] : stops[side]], nearest) for side in range(2))
        shapes += [_joined(left, right)] if left else []
        starts = stops
    return tuple(shapes)


def _chain(row: np.ndarray, solved: np.ndarray, links: np.ndarray, nearest: float) -> list[_Vertex]:
    """The vertices of a chain from `nearest` on."""
    chain: list[_Vertex] = []
    followed = -1
    for corner, which, edge in links.tolist():
        if corner == OPEN:
            i, j = _ends(edge if edge >= 0 else followed)
            beyond = solved[:, AFTER if which else BEFORE]
            weights = _between(i, j, edge_weight(beyond[i], beyond[j]))
            chain.append(_Vertex(np.inf if which else -np.inf, 0.0, 0.0, False, weights, edge, corner))
        else:
            t, u, v, known = solved[corner, ROOTS + ROOT * which :][:ROOT]
            chain.append(_vertex(_world(row, t), u, v, known, np.eye(3)[corner], edge, corner))
        followed = edge
    kept = [vertex for vertex in chain if vertex.t >= nearest]
    if kept and len(kept) < len(chain):
        edge = chain[-len(kept) - 1].edge
        weight, u, v, known = edge_ray(row, solved, edge, nearest / row[PACE] - row[SHIFT])
        kept.insert(0, _vertex(nearest, u, v, known, _between(*_ends(edge), weight), edge, OPEN))
    return kept


def _world(row: np.ndarray, t: float) -> float:
    return float((t + row[SHIFT]) * row[PACE])


def _vertex(t: float, u: float, v: float, known: float, weights: np.ndarray, edge: int, corner: int) -> _Vertex:
    valid = known == VALID
    return _Vertex(t, u if valid else 0.0, v if valid else 0.0, valid, weights, edge, corner)


def _ends(edge: int) -> tuple[int, int]:
    return (edge + 1) % 3, (edge + 2) % 3


def _between(i: int, j: int, weight: float) -> np.ndarray:
    """Weights on the scene triangle of what lies on the edge from corner i, with that weight, to corner j."""
    return weight * np.eye(3)[i] + (1.0 - weight) * np.eye(3)[j]


def _joined(left: list[_Vertex], right: list[_Vertex]) -> Shape:
    """Up along one chain and down along the other, whose ends are the same where they are corners."""
    starts_open, ends_open = left[0].corner == OPEN, left[-1].corner == OPEN
    outline = left + right[0 if starts_open else 1 : None if ends_open else -1][::-1]
    edges = [vertex.edge for vertex in (*left[:-1], *left[-1:] * ends_open, *right[-2::-1])] + [-1] * starts_open
    t, u, v, valid, weights = (np.array([vertex[k] for vertex in outline]) for k in range(5))
    return Shape(t, u, v, valid, weights, np.array(edges))
