"""Silhouettes in maps of surfaces: edges of the scene that have all that they belong to on one side, as a map sees it.

A map holds what the middles of its texels see. What it misses is thinner than a texel, and has a silhouette there.
Compiled.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from anamorph.base.compiled import compiled, inlined, over_all_cores
from anamorph.methods.pervertex.rectangles import SceneMap
from anamorph.scene.geometry import Geometry

WORDS = 8
"""Of a `Silhouette` in silhouettes.wgsl."""

MARGIN = 2.0
"""Texels around a map in which its silhouettes go on: they are drawn wider than they are."""

Place = tuple[float, float, float, float]
"""Homogeneous, in clip space."""


@dataclass(frozen=True, eq=False)
class Edges:
    """The edges of a scene's triangles.

    Parameters
    ----------
    corners : (E, 4) int32
        Vertices: the edge's two, then the third of each of its triangles; twice the same at a border.
    first : (meshes + 1,) int64
        Mesh i owns edges first[i] to first[i + 1].
    twins : (N, 2) int32
        Vertices at one place each, by which triangles share an edge.
    """

    corners: np.ndarray
    first: np.ndarray
    twins: np.ndarray

    def moved(self, geometry: Geometry) -> Edges:
        """The edges after vertices have moved: found again where what were one place are two."""
        one, other = geometry.positions[self.twins].swapaxes(0, 1)
        return edges_of(geometry) if (one != other).any() else self


def edges_of(geometry: Geometry) -> Edges:
    """The edges of a scene: where two triangles of a mesh have both places in common, they share one."""
    record = np.dtype([("place", np.float32, 3), ("mesh", np.uint32)])
    owned = np.zeros(len(geometry.positions), record)
    # Minus zero is the same place as zero, but not the same bits.
    owned["place"], owned["mesh"] = geometry.positions + np.float32(0.0), geometry.vertex_object
    bits = owned.view(np.dtype((np.void, record.itemsize)))
    place = np.unique(bits, return_inverse=True)[1].ravel().astype(np.int64)
    starts, ends, thirds = (np.roll(geometry.faces, -turn, axis=1).ravel() for turn in range(3))
    keys = np.minimum(place[starts], place[ends]) * len(place) + np.maximum(place[starts], place[ends])
    order = np.argsort(keys, kind="stable")
    _, first, counts = np.unique(keys[order], return_index=True, return_counts=True)
    # Where more than two triangles meet, each of them has a border.
    alone = order[np.repeat(counts != 2, counts)]
    pairs = first[counts == 2]
    one, other = np.append(order[pairs], alone), np.append(order[pairs + 1], alone)
    turned = place[starts[one]] != place[starts[other]]
    theirs = np.where(turned, ends[other], starts[other]), np.where(turned, starts[other], ends[other])
    twins = np.stack([np.append(starts[one], ends[one]), np.append(*theirs)], axis=1)
    corners = np.stack([starts[one], ends[one], thirds[one], thirds[other]], axis=1)
    mesh = geometry.vertex_object[corners[:, 0]]
    by_mesh = np.argsort(mesh, kind="stable")
    bounds = np.searchsorted(mesh[by_mesh], np.arange(1, len(geometry.first_face) + 1))
    return Edges(corners[by_mesh].astype(np.int32), bounds, twins[twins[:, 0] != twins[:, 1]].astype(np.int32))


def silhouettes(edges: Edges, positions: np.ndarray, maps: Sequence[SceneMap]) -> list[np.ndarray]:
    """The silhouettes in each of some maps.

    Parameters
    ----------
    edges : Edges
    positions : (V, 3) float32
        Of the scene's vertices.
    maps : sequence of SceneMap

    Returns
    -------
    list of (N, 8) float32
        Where each silhouette starts in the map, from -1 to 1 to the right and up, its depth there, and nothing; its
        end likewise.
    """
    found: list[np.ndarray] = [np.zeros((0, WORDS), np.float32)] * len(maps)

    def work(first: int, stop: int) -> None:
        for number in range(first, stop):
            each = maps[number]
            records = np.empty((int(np.diff(edges.first)[each.visible].sum()), WORDS), np.float32)
            reach = 1.0 + 2.0 * MARGIN / np.asarray(each.size, float)
            count = _find(edges.corners, edges.first, each.visible, positions, each.projection.clip, reach, records)
            found[number] = records[:count]

    over_all_cores(work, len(maps), 1)
    return found


@compiled
def _find(
    corners: np.ndarray,
    first_edge: np.ndarray,
    visible: np.ndarray,
    positions: np.ndarray,
    clip: np.ndarray,
    reach: np.ndarray,
    records: np.ndarray,
) -> int:
    """Fill `records`, and return of how many edges."""
    count = 0
    for mesh in range(len(visible)):
        if not visible[mesh]:
            continue
        for number in range(first_edge[mesh], first_edge[mesh + 1]):
            own = corners[number]
            a, b = _projected(positions[own[0]], clip), _projected(positions[own[1]], clip)
            first, last = _clipped(0.0, 1.0, a[3] - a[2], b[3] - b[2])
            for axis in range(2):
                first, last = _clipped(first, last, reach[axis] * a[3] + a[axis], reach[axis] * b[3] + b[axis])
                first, last = _clipped(first, last, reach[axis] * a[3] - a[axis], reach[axis] * b[3] - b[axis])
            start_w, end_w = a[3] + first * (b[3] - a[3]), a[3] + last * (b[3] - a[3])
            if first > last or start_w <= 0.0 or end_w <= 0.0:
                continue
            c, d = _projected(positions[own[2]], clip), _projected(positions[own[3]], clip)
            if _side(a, b, c) * _side(a, b, d) < 0.0:
                continue
            for axis in range(3):
                records[count, axis] = (a[axis] + first * (b[axis] - a[axis])) / start_w
                records[count, 4 + axis] = (a[axis] + last * (b[axis] - a[axis])) / end_w
            count += 1
    return count


@inlined
def _projected(position: np.ndarray, clip: np.ndarray) -> Place:
    x, y, z = np.float64(position[0]), np.float64(position[1]), np.float64(position[2])
    return (
        clip[0, 0] * x + clip[0, 1] * y + clip[0, 2] * z + clip[0, 3],
        clip[1, 0] * x + clip[1, 1] * y + clip[1, 2] * z + clip[1, 3],
        clip[2, 0] * x + clip[2, 1] * y + clip[2, 2] * z + clip[2, 3],
        clip[3, 0] * x + clip[3, 1] * y + clip[3, 2] * z + clip[3, 3],
    )


@inlined
def _side(a: Place, b: Place, c: Place) -> float:
    """On which side of the edge from a to b the map sees c."""
    return (a[1] * b[3] - a[3] * b[1]) * c[0] + (a[3] * b[0] - a[0] * b[3]) * c[1] + (a[0] * b[1] - a[1] * b[0]) * c[3]


@inlined
def _clipped(first: float, last: float, at_start: float, at_end: float) -> tuple[float, float]:
    """What is left of the part of an edge from `first` to `last` where a number, linear along it, is not negative."""
    if at_start < 0.0 and at_end < 0.0:
        return 1.0, 0.0
    if at_start < 0.0:
        first = max(first, at_start / (at_start - at_end))
    elif at_end < 0.0:
        last = min(last, at_start / (at_start - at_end))
    return first, last
