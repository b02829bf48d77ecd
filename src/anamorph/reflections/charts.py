"""Mirrors and lenses as charts: what of a face the search for reflection points reads, whatever eye looks at it.

A chart is the mesh's triangles, cut into pieces so small that interpolated rays say well enough where to search. The
corners of pieces are places of the exact surface, as `Surface.places` gives them. Of a mesh without one, a place is the
weights of a triangle's second and third corner, and the triangle's number.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from anamorph.base.compiled import compiled
from anamorph.optics.borders import RoundBorder, mirror_borders
from anamorph.scene.lens_pairs import border_edges
from anamorph.scene.model import Mesh
from anamorph.surfaces.expansion import expand
from anamorph.surfaces.intersection import NONE, PATCHES, PLANE, pack
from anamorph.surfaces.patch import POLE
from anamorph.surfaces.sphere import Sphere

CELLS = 64
"""Pieces along the longest side of the box around a mirror. Triangles of planes and plain meshes are whole."""

BEND = 0.03
"""How far the normal in the middle of a piece's edge may be from the mean of those at its ends, as a share of how far
the mirror's pieces turn: a wave then has about 25 pieces."""

INWARD = 1e-3
"""How far into a triangle that ends at a pole the normal at the pole is taken, as a share of the way to its middle."""

BEYOND = 1.1
"""How far beyond an arc the tangents at its ends meet, in its heights over its chord: the arcs of borders are short."""

SAME_NORMAL = 1e-7

HALVINGS, FINEST = 40, 1e-10
"""How often pieces beside an eye are halved, and how long their edges are at least, as a share of the mirror's size."""

MOST_CUTS = 64
MOST_PIECES = 200_000


class Trim(NamedTuple):
    """What bounds a mirror.

    Parameters
    ----------
    triangles : (T, 3, 3) float64
        The places of the corners of triangles.
    arcs : (T, 3) int64
        For the edge that faces each corner the number of its circle, from 1; 0 where it is straight. Negative where the
        mirror is outside the circle.
    circles : (C, 7) float64
        Of each circle: a point of its axis, the axis, and the radius; or 0, and inside is what lies ahead of its plane.
    """

    triangles: np.ndarray
    arcs: np.ndarray
    circles: np.ndarray


@dataclass(frozen=True, eq=False)
class Chart:
    """A mirror for the search.

    Parameters
    ----------
    kind : int
    numbers : (K,) float64
        The exact surface, from `intersection.pack`; of a plain mesh, the corners and normals of each triangle.
    size : float
        The longest side of the box around it, metres.
    side : float
        1 where slope a x slope b points to the mirror's outside, else -1.
    trim : Trim
    faces : (T,) int64
        The triangle of the mesh for each of the trim's: at a pole of a patch, two stand for one.
    parents : (P,) int64
        Which of the trim's triangles each piece is of.
    corners, positions, normals : (P, 3, 3) float64
        The places of its corners, where these are, and the unit normals to the mirror's outside.
    """

    kind: int
    numbers: np.ndarray
    size: float
    side: float
    trim: Trim
    faces: np.ndarray
    parents: np.ndarray
    corners: np.ndarray
    positions: np.ndarray
    normals: np.ndarray


def chart_of(mesh: Mesh, rounds: Sequence[RoundBorder] | None = None) -> Chart:
    """The chart of a mirror, or of the face of a lens, which the borders `rounds` end.

    A face of a lens is cut where it is flat, too: what a flat mirror does to rays is interpolated exactly, but not what
    a flat face does.
    """
    size = float(np.ptp(np.asarray(mesh.positions, float)[np.unique(mesh.faces)], axis=0).max())
    if mesh.surface is None or mesh.parameters is None:
        return _plain_chart(mesh, size)
    kind, numbers = pack(mesh.surface)
    triangles, faces = mesh.surface.places(mesh.parameters)[mesh.faces], np.arange(len(mesh.faces))
    whole = kind == PLANE and rounds is None
    rounds = mirror_borders(mesh) if rounds is None else rounds
    arcs, circles = _arcs(mesh, rounds)
    if kind in PATCHES:
        triangles, faces = _with_poles(kind, numbers, triangles, size)
        arcs = arcs[faces]
    toward = np.asarray(mesh.normals, float)[mesh.faces[faces]].sum(axis=1)
    trim = Trim(triangles, arcs, circles)
    parents, corners = _with_caps(mesh, rounds, arcs, triangles)
    if not whole:
        edges = longest(_expanded(kind, numbers, corners)[0])
        parents, corners = _cut(parents, corners, np.ceil(edges * CELLS / size))
        parents, corners = _cut(parents, corners, _waves(kind, numbers, corners))
    positions, normals = _expanded(kind, numbers, corners)
    side = 1.0 if np.sum(normals.sum(axis=1) * toward[parents]) > 0.0 else -1.0
    corners, normals = np.ascontiguousarray(corners), side * normals
    return Chart(kind, numbers, size, side, trim, faces, parents, corners, positions, normals)


def _plain_chart(mesh: Mesh, size: float) -> Chart:
    positions = np.asarray(mesh.positions, float)[mesh.faces]
    normals = np.asarray(mesh.normals, float)[mesh.faces]
    normals = normals / np.linalg.norm(normals, axis=2, keepdims=True)
    count = len(mesh.faces)
    numbers = np.concatenate([positions.reshape(count, 9), normals.reshape(count, 9)], axis=1).ravel()
    places = np.zeros((count, 3, 3))
    places[:, 1, 0] = places[:, 2, 1] = 1.0
    places[:, :, 2] = np.arange(count)[:, None]
    trim = Trim(places, np.zeros((count, 3), np.int64), np.zeros((0, 7)))
    # Between corners of one normal, rays are interpolated exactly.
    flat = _even(normals)
    parents, corners = _cut(np.arange(count), places, np.where(flat, 1.0, np.ceil(longest(positions) * CELLS / size)))
    corners[:, :, 2] = parents[:, None]
    return Chart(NONE, numbers, size, 1.0, trim, np.arange(count), parents, corners, *_interpolated(numbers, corners))


def _even(normals: np.ndarray) -> np.ndarray:
    """Which triangles have one normal at all corners, (P,) bool, of their unit normals (P, 3, 3)."""
    return np.abs(normals - normals[:, :1]).max(axis=(1, 2)) <= SAME_NORMAL


def _interpolated(numbers: np.ndarray, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions and unit normals of the corners (P, 3, 3) of pieces of a plain mesh."""
    rows = numbers.reshape(-1, 2, 3, 3)[corners[:, 0, 2].astype(int)]
    u, v = corners[..., :1], corners[..., 1:2]
    weights = np.concatenate([1.0 - u - v, u, v], axis=2)
    positions, normals = weights @ rows[:, 0], weights @ rows[:, 1]
    return positions, normals / np.linalg.norm(normals, axis=2, keepdims=True)


def cut_beside(chart: Chart, eye: np.ndarray, flat: bool = False) -> Chart:
    """The chart with smaller pieces where an eye at (3,) is so close that it sees them at wide angles.

    Flat pieces are cut only if they are those of a lens, `flat`.
    """
    if chart.kind == PLANE and not flat:
        return chart
    for _ in range(HALVINGS):
        edges = longest(chart.positions)
        close = np.linalg.norm(chart.positions.mean(axis=1) - eye, axis=1) < edges
        close &= edges > FINEST * chart.size
        if not flat:
            close &= ~_even(chart.normals)
        if not close.any():
            break
        parents, corners = _cut(chart.parents[close], chart.corners[close], np.full(close.sum(), 2.0))
        if chart.kind == NONE:
            corners[:, :, 2] = parents[:, None]
            positions, normals = _interpolated(chart.numbers, corners)
        else:
            positions, normals = _expanded(chart.kind, chart.numbers, corners)
            normals = chart.side * normals
        parts = (parents, corners, positions, normals)
        held = (chart.parents, chart.corners, chart.positions, chart.normals)
        joined = [np.concatenate([old[~close], new]) for old, new in zip(held, parts, strict=True)]
        chart = replace(
            chart, parents=joined[0], corners=joined[1], positions=joined[2], normals=joined[3]
        )  # fmt: skip
    return chart


def _with_poles(kind: int, numbers: np.ndarray, triangles: np.ndarray, size: float) -> tuple[np.ndarray, np.ndarray]:
    """Triangles (T, 3, 3) of a patch with all that lies between their corners, and which of the given ones each is of.

    At a pole one parameter moves nothing. A corner there is a whole edge in the parameters, from where one of the
    others has that parameter to where the other has it.
    """
    # A parameter of a patch goes from 0 to 1.
    pole = (
        np.stack([np.linalg.norm(each, axis=2) for each in _slopes(kind, numbers, triangles)[1:]], axis=-1)
        <= POLE * size
    )
    whole = ~pole.any(axis=(1, 2))
    found, faces = [triangles[whole]], [np.flatnonzero(whole)]
    for face in np.flatnonzero(~whole):
        corner, axis = np.argwhere(pole[face])[0]
        c, p, q = np.roll(triangles[face], -corner, axis=0)
        at_p, at_q = c.copy(), c.copy()
        at_p[axis], at_q[axis] = p[axis], q[axis]
        found.append(np.array([[at_p, p, q], [at_p, q, at_q]]))
        faces.append(np.array([face, face]))
    return np.concatenate(found), np.concatenate(faces)


def longest(positions: np.ndarray) -> np.ndarray:
    """The longest edges of triangles (P, 3, 3), (P,)."""
    return np.linalg.norm(positions - np.roll(positions, 1, axis=1), axis=2).max(axis=1)


def _arcs(mesh: Mesh, rounds: Sequence[RoundBorder]) -> tuple[np.ndarray, np.ndarray]:
    """The arcs and circles of a `Trim`."""
    assert mesh.surface is not None
    arcs = np.zeros(mesh.faces.shape, np.int64)
    # The border of a mirror on a sphere is where a plane cuts it, whichever of the two caps the mirror is.
    flat = [isinstance(mesh.surface, Sphere) and not each.of_lens for each in rounds]
    radii = [0.0 if plane else each.radius for each, plane in zip(rounds, flat, strict=True)]
    rows = [[*each.middle, *each.axis, radius] for each, radius in zip(rounds, radii, strict=True)]
    circles = np.array(rows).reshape(-1, 7)
    if not rounds:
        return arcs, circles
    count, places = len(mesh.positions), mesh.exact_positions()
    low, high = border_edges(mesh)
    for corner in range(3):
        ends = np.sort(mesh.faces[:, [(corner + 1) % 3, (corner + 2) % 3]], axis=1).astype(np.int64)
        border = np.isin(ends[:, 0] * count + ends[:, 1], low * count + high)
        facing = places[mesh.faces[:, corner]]
        for number, circle in enumerate(rounds, start=1):
            on = border & (arcs[:, corner] == 0) & circle.arcs(places[ends])
            heights = (facing - circle.middle) @ circle.axis
            inside = (
                heights > 0.0 if flat[number - 1] else np.linalg.norm(circle.across(facing), axis=1) < circle.radius
            )
            arcs[on, corner] = np.where(inside[on], number, -number)
    return arcs, circles


def _with_caps(
    mesh: Mesh, rounds: Sequence[RoundBorder], arcs: np.ndarray, triangles: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Triangles (T, 3, 3), and others that hold what lies between their edges and the arcs that these stand for.

    Returns
    -------
    parents : (T + C,) int64
        The triangle of each.
    corners : (T + C, 3, 3) float64
    """
    parents, corners = [np.arange(len(triangles))], [triangles]
    for number, circle in enumerate(rounds, start=1):
        for corner in range(3):
            own = np.flatnonzero(arcs[:, corner] == number)
            ends = np.stack([triangles[own, (corner + 1) % 3], triangles[own, (corner + 2) % 3]], axis=1)
            assert mesh.surface is not None
            points = mesh.surface.position(mesh.surface.placed(ends.reshape(-1, 3))).reshape(-1, 2, 3)
            middles = mesh.surface.places(mesh.surface.parameters(circle.middles(points)))
            # The tangents of an arc meet about twice as far out as the arc itself is.
            tips = middles + BEYOND * (middles - ends.mean(axis=1))
            parents.append(own)
            corners.append(np.concatenate([ends, tips[:, None]], axis=1))
    return np.concatenate(parents), np.concatenate(corners)


def _cut(parents: np.ndarray, corners: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangles (P, 3, 3) whose edges are cut into `counts` (P,) parts each."""
    counts = np.clip(counts, 1, MOST_CUTS)
    # Where all that is wanted would be too much, everything is cut less.
    share = np.sqrt(min(1.0, MOST_PIECES / np.sum(counts**2)))
    counts = np.maximum(np.floor(counts * share) if share < 1.0 else counts, 1).astype(int)
    found = []
    for count in np.unique(counts):
        own = np.flatnonzero(counts == count)
        weights = _cells(int(count))
        found.append((np.repeat(parents[own], len(weights)), (weights @ corners[own, None]).reshape(-1, 3, 3)))
    new_parents, new_corners = zip(*found, strict=True)
    return np.concatenate(new_parents), np.concatenate(new_corners)


def _cells(count: int) -> np.ndarray:
    """The weights of the corners, (count^2, 3, 3), of the equal parts of a triangle."""
    i, j = (each.ravel() for each in np.meshgrid(np.arange(count), np.arange(count), indexing="ij"))
    lower, upper = i + j < count, i + j < count - 1
    first = [np.stack([i + a, j + b], axis=-1)[lower] for a, b in ((0, 0), (1, 0), (0, 1))]
    second = [np.stack([i + a, j + b], axis=-1)[upper] for a, b in ((1, 1), (0, 1), (1, 0))]
    pairs = np.concatenate([np.stack(first, axis=1), np.stack(second, axis=1)]) / count
    return np.concatenate([1.0 - pairs.sum(axis=2, keepdims=True), pairs], axis=2)


def _waves(kind: int, numbers: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Into how many parts pieces have to be cut so that the normal changes evenly along each, (P,)."""
    middles = (corners + np.roll(corners, -1, axis=1)) / 2.0
    normals, between = _expanded(kind, numbers, corners)[1], _expanded(kind, numbers, middles)[1]
    following = np.roll(normals, -1, axis=1)
    turns = np.linalg.norm(following - normals, axis=2)
    mean = normals + following
    mean /= np.maximum(np.linalg.norm(mean, axis=2, keepdims=True), np.finfo(float).tiny)
    leaves = np.linalg.norm(between - mean, axis=2).max(axis=1)
    typical = np.sqrt(np.mean(turns**2))
    return np.ceil(leaves / max(BEND * typical, 1e-9))


def _expanded(kind: int, numbers: np.ndarray, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions and unit normals along slope a x slope b, of the corners of triangles (T, 3, 3)."""
    positions, a, b = _slopes(kind, numbers, places)
    normals = np.cross(a, b)
    lengths = np.linalg.norm(normals, axis=2, keepdims=True)
    # At a pole, the normal is that of a place a little further inside.
    pole = lengths <= POLE * lengths.max(axis=1, keepdims=True)
    if pole.any():
        inside = places + INWARD * (places.mean(axis=1, keepdims=True) - places)
        normals = np.where(pole, np.cross(*_slopes(kind, numbers, inside)[1:]), normals)
        lengths = np.linalg.norm(normals, axis=2, keepdims=True)
    return positions, normals / np.maximum(lengths, np.finfo(float).tiny)


def _slopes(kind: int, numbers: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Positions, and slopes along both parameters, of places (T, 3, 3): (3, T, 3, 3)."""
    found = np.zeros((3, places.size // 3, 3))
    _expand_all(kind, numbers, np.ascontiguousarray(places.reshape(-1, 3)), found)
    return found.reshape(3, *places.shape)


@compiled
def _expand_all(kind: int, numbers: np.ndarray, places: np.ndarray, found: np.ndarray) -> None:
    for i in range(len(places)):
        _, position, a, b, _, _, _ = expand(kind, numbers, (places[i, 0], places[i, 1], places[i, 2]))
        for axis in range(3):
            found[0, i, axis], found[1, i, axis], found[2, i, axis] = position[axis], a[axis], b[axis]
