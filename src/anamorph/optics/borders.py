"""Where the border of a mirror or a lens is, between the vertices of its mesh.

It is on the exact surface. Of a lens it is a circle about the axis. Of a mirror each piece of it, from corner to
corner, is an arc if its vertices lie on a circle, four of them or more. Elsewhere, as on patches, it is straight from
vertex to vertex in the parameters of the surface, and on a sphere a great circle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from anamorph.lenses.lens import drop
from anamorph.optics.refraction import refractor
from anamorph.scene.lens_pairs import border_edges
from anamorph.scene.model import Mesh
from anamorph.scene.subdivision import cut_ends, split
from anamorph.scene.triangles import turned_over
from anamorph.surfaces.plane import Plane
from anamorph.surfaces.sag import SagSurface
from anamorph.surfaces.sphere import Sphere

CLOSE = 1e-6
"""How far a vertex of a round border may be from its circle, as a share of what there is of that."""

WIDEST = 30.0
"""Degrees between two vertices of a mirror's border. Where they are further apart it is straight between them, as a
hexagon is, whose corners lie on a circle too."""


@dataclass(frozen=True, eq=False)
class RoundBorder:
    """A cylinder that ends an exact surface: seen along the axis, the border is its circle.

    Parameters
    ----------
    middle, axis : (3,) float64
        A point of the axis, metres, and its unit direction.
    radius : float
        Metres.
    close : float
        How far from it a vertex may be that counts as on it, metres.
    of_lens : bool
        Of a lens every edge that ends on it is an arc, and the surface is met along the axis. Of a mirror long ones are
        straight, and the circle lies on the surface, or seen along the surface's own axis.
    """

    middle: np.ndarray
    axis: np.ndarray
    radius: float
    close: float
    of_lens: bool

    def across(self, points: np.ndarray) -> np.ndarray:
        """The offsets of points (N, 3) from the axis, at right angles to it."""
        offsets = points - self.middle
        return offsets - np.outer(offsets @ self.axis, self.axis)

    def holds(self, points: np.ndarray) -> bool:
        """Whether all points lie on it."""
        away = np.linalg.norm(self.across(points), axis=1) - self.radius
        return bool(np.abs(away).max(initial=0.0) <= self.close)

    def arcs(self, ends: np.ndarray) -> np.ndarray:
        """Which edges (E, 2, 3) are chords of it, (E,) bool."""
        first, second = (self.across(ends[:, end]) for end in (0, 1))
        lengths = np.stack([np.linalg.norm(each, axis=1) for each in (first, second)])
        on = (np.abs(lengths - self.radius) <= self.close).all(axis=0)
        least = -np.inf if self.of_lens else np.cos(np.radians(WIDEST)) - CLOSE
        return on & (np.einsum("ei,ei->e", first, second) >= least * self.radius**2)

    def middles(self, ends: np.ndarray) -> np.ndarray:
        """The middles, (E, 3), of the arcs over chords (E, 2, 3); along the axis they are halfway."""
        chords = ends.mean(axis=1)
        across = self.across(chords)
        length = np.linalg.norm(across, axis=1, keepdims=True)
        return chords + (self.radius / np.maximum(length, CLOSE * self.radius) - 1.0) * across


def lens_borders(front: Mesh, back: Mesh, edge: Mesh | None) -> tuple[RoundBorder, ...]:
    """What ends both faces of a lens; none if they are not round, or if the edge is more than a band between them."""
    lens = refractor(front, back)
    circle = RoundBorder(lens.middle, lens.axis, lens.radius, CLOSE * lens.radius, True)
    borders = [_border(face) for face in (front, back)]
    counts = {2 * len(border) for border in borders}
    if edge is not None:
        counts |= {len(edge.positions), len(edge.faces)}
    held = all(
        circle.holds(face.exact_positions()[border]) for face, border in zip((front, back), borders, strict=True)
    )
    return (circle,) if len(counts) == 1 and held else ()


def mirror_borders(mesh: Mesh) -> tuple[RoundBorder, ...]:
    """What ends a mesh on a plane, a sphere, a toroid or an asphere where it is round.

    There is one for each piece of its border, from corner to corner, whose vertices lie on a circle: in space, or seen
    along the axis of a toroid or an asphere.
    """
    if not isinstance(mesh.surface, Plane | Sphere | SagSurface) or mesh.parameters is None:
        return ()
    vertices, ends = np.unique(border_edges(mesh), return_inverse=True)
    ends = ends.reshape(2, -1)
    if not len(vertices):
        return ()
    points = mesh.surface.position(mesh.parameters[vertices])
    axis = np.asarray(mesh.surface.axes, float)[2] if isinstance(mesh.surface, SagSurface) else None
    places = points if axis is None else points - np.outer(points @ axis, axis)
    away = places[ends[::-1]] - places[ends]
    away /= np.maximum(np.linalg.norm(away, axis=2, keepdims=True), np.finfo(float).tiny)
    # Of two unit vectors to its neighbours, the sum says how far the border turns at a vertex.
    turns = np.stack([np.bincount(ends.ravel(), away[..., axis].ravel()) for axis in range(3)], axis=-1)
    corner = np.linalg.norm(turns, axis=1) > 2.0 * np.sin(np.radians(0.5 * WIDEST)) + CLOSE
    corner |= np.bincount(ends.ravel()) != 2
    edge = np.tile(np.arange(ends.shape[1]), 2)
    inner = np.flatnonzero(~corner[ends.ravel()])
    pairs = edge[inner[np.argsort(ends.ravel()[inner], kind="stable")]].reshape(-1, 2)
    joined = coo_array((np.ones(len(pairs)), tuple(pairs.T)), shape=(ends.shape[1], ends.shape[1]))
    piece = connected_components(joined, directed=False)[1]
    pieces = (points[np.unique(ends[:, piece == number])] for number in np.flatnonzero(np.bincount(piece) > 2))
    return tuple(circle for circle in (_through(each, axis) for each in pieces) if circle is not None)


def _through(points: np.ndarray, axis: np.ndarray | None) -> RoundBorder | None:
    """The round border through points (N, 3) about `axis`, or without one about the normal of their plane."""
    mean = points.mean(axis=0)
    sizes, directions = np.linalg.svd(points - mean, full_matrices=False)[1:]
    if axis is None:
        if len(points) < 4 or not sizes[2] <= CLOSE * sizes[0]:
            return None
        axis = directions[2]
    flat = np.linalg.svd(axis[None])[2][1:]
    scale = sizes[0]
    places = (points - mean) @ flat.T / scale
    # The circle by least squares: 2 c.p + (r^2 - c^2) = p^2 is linear in the centre c and in what follows it.
    rows = np.column_stack([2.0 * places, np.ones(len(places))])
    (x, y, rest), _, rank, _ = np.linalg.lstsq(rows, np.sum(places**2, axis=1), rcond=CLOSE)
    if len(points) < 4 or rank < 3:
        return None
    radius = scale * float(np.sqrt(rest + x * x + y * y))
    close = CLOSE * min(radius, scale)
    circle = RoundBorder(mean + scale * np.array([x, y]) @ flat, axis, radius, close, False)
    return circle if circle.holds(points) else None


def border_middles(mesh: Mesh, ends: np.ndarray, rounds: Sequence[RoundBorder]) -> tuple[np.ndarray, np.ndarray]:
    """Where the border is halfway between neighbouring vertices `ends` (E, 2) of it.

    Returns
    -------
    parameters : (E, 2) float64
        Of a point of the exact surface.
    arcs : (E,) bool
        Where the border is round.
    """
    assert mesh.surface is not None and mesh.parameters is not None
    parameters = mesh.surface.between(mesh.parameters[ends], mesh.positions[ends])
    arcs = np.zeros(len(ends), bool)
    places = mesh.surface.position(mesh.parameters[ends.ravel()]).reshape(-1, 2, 3)
    for circle in rounds:
        own = circle.arcs(places) & ~arcs
        if own.any():
            points = circle.middles(places[own])
            parameters[own] = (
                drop(mesh.surface, points, circle.axis) if circle.of_lens else mesh.surface.parameters(points)
            )
            arcs |= own
    return parameters, arcs


def split_within(mesh: Mesh, cut: np.ndarray, arcs: np.ndarray, rounds: Sequence[RoundBorder]) -> Mesh:
    """As `split`, with the new vertices of a round border, whose edges are `arcs` (F, 3), on its circle."""
    finer = split(mesh, cut)
    assert mesh.surface is not None and finer.parameters is not None
    ends, number = cut_ends(mesh.faces, cut)
    own = np.unique(number[arcs[cut]])
    new = len(mesh.positions) + own
    positions, normals, parameters = finer.positions.copy(), finer.normals.copy(), finer.parameters.copy()
    parameters[new] = border_middles(mesh, ends[own], rounds)[0]
    # No other mesh has these vertices, but for a lens's edge, which takes them as they are: nothing is rounded.
    positions[new] = mesh.surface.position(parameters[new])
    normals[new] = mesh.surface.normals_toward(parameters[new], normals[new])
    return replace(finer, positions=positions, normals=normals, parameters=parameters)


def split_edge(edge: Mesh, circle: RoundBorder, before: Sequence[Mesh], after: Sequence[Mesh]) -> Mesh:
    """The edge of a lens as its two faces are after they have been cut all around: the band between their borders.

    Returns
    -------
    Mesh
        The old vertices first, and then the faces' new ones, as they are there.
    """
    count = len(edge.positions) // 2
    fresh = [_border(new)[len(_border(old)) :] for old, new in zip(before, after, strict=True)]
    placed = [face.positions[new] for face, new in zip(after, fresh, strict=True)]
    positions = np.concatenate([edge.positions, *placed]).astype(edge.positions.dtype)
    theirs = np.concatenate([face.positions[_border(face)] for face in before])
    side = np.concatenate([KDTree(theirs).query(edge.positions)[1] >= count, np.repeat([False, True], count)])
    # Around the axis, from half a step before the first vertex, so that rounding does not part the first from the last.
    away = circle.across(positions)
    right = away[0] / np.linalg.norm(away[0])
    angle = np.arctan2(away @ np.cross(circle.axis, right), away @ right)
    order = np.argsort((angle + 0.5 * np.pi / count) % (2.0 * np.pi))
    rings = [order[side[order] == number] for number in (False, True)]

    def means(values: np.ndarray) -> np.ndarray:
        """With those of the new vertices, every second of a ring."""
        every = np.concatenate([values, np.zeros((len(positions) - len(values), *values.shape[1:]), values.dtype)])
        for ring in rings:
            new = np.flatnonzero(ring >= len(values))
            every[ring[new]] = 0.5 * (every[ring[new - 1]] + every[ring[(new + 1) % len(ring)]])
        return every

    normals = means(edge.normals)
    normals[2 * count :] /= np.linalg.norm(normals[2 * count :], axis=1, keepdims=True)
    (a, b), (c, d) = ((ring, np.roll(ring, -1)) for ring in rings)
    faces = np.concatenate([np.stack([c, d, b], axis=-1), np.stack([c, b, a], axis=-1)])
    faces = np.where(turned_over(positions, faces, normals)[:, None], faces[:, ::-1], faces)
    return replace(
        edge,
        positions=positions,
        normals=normals,
        faces=faces.astype(np.int32),
        texcoords=None if edge.texcoords is None else means(edge.texcoords),
        colors=None if edge.colors is None else means(edge.colors),
    )


def _border(face: Mesh) -> np.ndarray:
    """The vertices on the border."""
    return np.unique(border_edges(face))
