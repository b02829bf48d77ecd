"""What a scene triangle becomes in a ray triangle: one to four shapes of two to nine vertices, and their visible part.

Source: Vallance 2005, sections 4.1 to 4.3 (with `connect`), and 4.6: what lies behind the origins is cut away, exactly,
on the edges of the scene triangle.

Deviation: corners count by the roots of their cubics, whether or not float64 can tell the ray that leads there, so that
no far vertex breaks a shape.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.methods.trilinear.straight.connect import FIRST, Outline, connect
from anamorph.raytriangle.coefficients import RayTriangleFrame, ray_triangle_frame
from anamorph.raytriangle.cubic import values_before
from anamorph.raytriangle.points import INFINITE, Projections, project_into, rays_at


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


def project_triangle(
    origins: np.ndarray, directions: np.ndarray, corners: np.ndarray, nearest: float | None = None
) -> tuple[Shape, ...]:
    """The shapes of a scene triangle in a ray triangle, in the order in which they end as t grows.

    Two vertices enclose nothing as long as lines between vertices are straight; in truth they are curved.

    Parameters
    ----------
    origins, directions : (3, 3) array
        A row for each of the three rays.
    corners : (3, 3) array
        The corners of the scene triangle.
    nearest : float, optional
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
    frame = ray_triangle_frame(origins, directions)
    if frame.flat:
        return ()
    projections = project_into(frame, corners)
    local = frame.local(corners)
    cubics = frame.cubics(local)
    first, last = values_before(cubics, INFINITE * (1.0 + np.linalg.norm(local, axis=-1)))
    found = [(corner, which) for corner in range(3) for which in range(3) if projections.real[corner, which]]
    found.sort(key=lambda vertex: projections.t[vertex])
    shapes = (_shape(outline, projections, first, last) for outline in connect(found, first >= 0.0))
    if nearest is None:
        return tuple(shapes)
    clipped = (_clipped(shape, frame, corners, float(nearest)) for shape in shapes)
    return tuple(shape for shape in clipped if len(shape))


def _shape(outline: Outline, projections: Projections, first: np.ndarray, last: np.ndarray) -> Shape:
    count = len(outline.vertices)
    t, u, v, valid, weights = np.zeros(count), np.zeros(count), np.zeros(count), np.zeros(count, bool), []
    for k, vertex in enumerate(outline.vertices):
        corner, which = vertex
        if corner >= 0:
            t[k], u[k], v[k] = projections.t[vertex], projections.u[vertex], projections.v[vertex]
            valid[k] = projections.valid[vertex]
            weights.append(np.eye(3)[corner])
        else:
            t[k] = -np.inf if corner == FIRST else np.inf
            weights.append(_crossing(first if corner == FIRST else last, which))
    return Shape(t, u, v, valid, np.array(weights), np.array(outline.edges))


def _crossing(values: np.ndarray, edge: int) -> np.ndarray:
    """Where an edge meets the plane from which its corners lie `values` away: weights on the scene triangle."""
    i, j = (edge + 1) % 3, (edge + 2) % 3
    weights = np.zeros(3)
    between = values[j] - values[i]
    # Corners that rounding no longer sets apart: the whole edge lies in the plane, and its middle does for a vertex.
    weights[i] = np.clip(values[j] / between, 0.0, 1.0) if between else 0.5
    weights[j] = 1.0 - weights[i]
    return weights


def _clipped(shape: Shape, frame: RayTriangleFrame, corners: np.ndarray, nearest: float) -> Shape:
    """What of a shape has t >= nearest; of no vertices where nothing has."""
    values = frame.values(frame.local(corners), nearest)
    kept = shape.t >= nearest
    index: list[int] = []
    cuts: list[np.ndarray] = []
    edges: list[int] = []
    for k in range(len(shape)):
        following = (k + 1) % len(shape)
        if kept[k]:
            index.append(k)
            edges.append(int(shape.edges[k]))
        if kept[k] != kept[following] and shape.edges[k] >= 0:
            index.append(len(shape) + len(cuts))
            cuts.append(_crossing(values, int(shape.edges[k])))
            edges.append(-1 if kept[k] else int(shape.edges[k]))
    if not cuts:
        return Shape(*(array[kept] for array in (shape.t, shape.u, shape.v, shape.valid, shape.weights, shape.edges)))
    weights = np.array(cuts)
    u, v, valid = rays_at(frame, weights @ corners, nearest)

    def joined(old: np.ndarray, new: np.ndarray) -> np.ndarray:
        return np.concatenate([old, new])[index]

    return Shape(
        joined(shape.t, np.full(len(cuts), nearest)),
        joined(shape.u, u),
        joined(shape.v, v),
        joined(shape.valid, valid),
        joined(shape.weights, weights),
        np.array(edges),
    )
