"""Which triangles of the scene the rays of each tile may meet: triangles look for their tiles, many at once. Compiled.

A tile that may see too many is left as soon as that is known. Which tiles these are does not depend on the order in
which triangles look, nor on how many do so at once.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import NamedTuple

import numpy as np

from anamorph.base.compiled import compiled, steps_over_all_cores
from anamorph.base.vectors import Vector
from anamorph.methods.virtual.tile_tree import TileTree, may_meet, may_reach
from anamorph.methods.virtual.triangle_tree import TriangleNodes, TriangleTree

PART = 256
"""Triangles, about, that one core takes at a time."""

DEPTH = 512
"""Pairs of nodes that wait for their turn, at most: three more for each level of tiles, and one of triangles."""

ROOM = 1 << 14
"""Pairs that are written before they are taken away."""

LEVEL = 32
"""Bits of a node's place in its level."""


class Lists(NamedTuple):
    """The triangles that each tile may see.

    Parameters
    ----------
    begins : (tiles + 1,) int64
        Where each tile's triangles begin, and where the last one's end.
    triangles : (M,) uint32
    full : (tiles,) bool
        Which tiles may see too many: theirs are not all there.
    """

    begins: np.ndarray
    triangles: np.ndarray
    full: np.ndarray


def listing(tree: TileTree, triangles: TriangleTree, most: int) -> Generator[None, None, Lists]:
    """List the triangles for each tile that may see `most` or fewer, in steps."""
    tiles, parts, nodes = int(tree.first[1]), triangles.parts(PART), triangles.nodes
    found: list[list[np.ndarray]] = [[] for _ in parts]
    open_nodes, counts = tree.balls[:, 3] >= 0.0, np.zeros(tiles, np.int32)

    def work(start: int, stop: int) -> None:
        for part in range(start, stop):
            stack, waiting = np.empty((DEPTH, 2), np.int64), 1
            stack[0] = parts[part], len(tree.columns) - 2 << LEVEL
            while waiting:
                pairs = np.empty((ROOM, 2), np.uint32)
                waiting, count = _look(tree, nodes, open_nodes, counts, most, stack, waiting, pairs)
                found[part].append(pairs[:count])

    yield from steps_over_all_cores(work, len(parts), 1)
    pairs = np.concatenate([np.zeros((0, 2), np.uint32), *(pairs for part in found for pairs in part)])
    lengths = np.bincount(pairs[:, 0], minlength=tiles)
    begins = np.concatenate([[0], np.cumsum(lengths)])
    listed = np.empty(len(pairs), np.uint32)
    _sort(pairs, begins[:-1].copy(), listed)
    # Several threads count at once, and may lose some.
    return Lists(begins, listed, lengths > most)


@compiled
def _look(
    tree: TileTree,
    nodes: TriangleNodes,
    open_nodes: np.ndarray,
    counts: np.ndarray,
    most: int,
    stack: np.ndarray,
    waiting: int,
    pairs: np.ndarray,
) -> tuple[int, int]:
    """Fill pairs of a tile and a triangle while there is room: how many nodes wait then, and how many pairs."""
    count = 0
    while waiting > 0:
        node, level, place = stack[waiting - 1, 0], stack[waiting - 1, 1] >> LEVEL, stack[waiting - 1, 1] & 0xFFFFFFFF
        ends = nodes.held[node] > 0
        if ends and level == 0 and count + nodes.held[node] > len(pairs):
            return waiting, count
        waiting -= 1
        tile = tree.first[level] + place
        x, y, z, size = nodes.balls[node, 0], nodes.balls[node, 1], nodes.balls[node, 2], nodes.balls[node, 3]
        if not (open_nodes[tile] and may_reach(tree, tile, x, y, z, size)):
            continue
        if ends and not _may_meet_one(tree, tile, nodes, node):
            continue
        if ends and level == 0:
            for i in range(nodes.first[node], nodes.first[node] + nodes.held[node]):
                pairs[count, 0], pairs[count, 1] = place, nodes.order[i]
                count += 1
                counts[place] += 1
            if counts[place] > most:
                _close(tree, open_nodes, place)
        elif level == 0 or (not ends and size > tree.balls[tile, 3]):
            left = node + 1
            for child in (left, left + nodes.size[left]):
                stack[waiting, 0], stack[waiting, 1] = child, (level << LEVEL) + place
                waiting += 1
        else:
            below = tree.columns[level - 1]
            rows = (tree.first[level] - tree.first[level - 1]) // below
            row, column = place // tree.columns[level], place % tree.columns[level]
            for i in range(2 * row, min(2 * row + 2, rows)):
                for j in range(2 * column, min(2 * column + 2, below)):
                    stack[waiting, 0], stack[waiting, 1] = node, ((level - 1) << LEVEL) + i * below + j
                    waiting += 1
    return 0, count


@compiled
def _may_meet_one(tree: TileTree, tile: int, nodes: TriangleNodes, node: int) -> bool:
    """Whether rays of a tile may meet a triangle of a leaf."""
    for i in range(nodes.first[node], nodes.first[node] + nodes.held[node]):
        face = nodes.order[i]
        a, b, c = _corner(nodes.corners, face, 0), _corner(nodes.corners, face, 1), _corner(nodes.corners, face, 2)
        if may_meet(tree, tile, a, b, c):
            return True
    return False


@compiled
def _close(tree: TileTree, open_nodes: np.ndarray, place: int) -> None:
    """Leave a tile, and what has none left that is open."""
    open_nodes[place] = False
    for level in range(1, len(tree.columns) - 1):
        below = tree.columns[level - 1]
        rows = (tree.first[level] - tree.first[level - 1]) // below
        row, column = place // below // 2, place % below // 2
        for i in range(2 * row, min(2 * row + 2, rows)):
            for j in range(2 * column, min(2 * column + 2, below)):
                if open_nodes[tree.first[level - 1] + i * below + j]:
                    return
        place = row * tree.columns[level] + column
        open_nodes[tree.first[level] + place] = False


@compiled
def _corner(corners: np.ndarray, face: int, k: int) -> Vector:
    return corners[face, k, 0], corners[face, k, 1], corners[face, k, 2]


@compiled
def _sort(pairs: np.ndarray, next_of: np.ndarray, listed: np.ndarray) -> None:
    for i in range(len(pairs)):
        tile = pairs[i, 0]
        listed[next_of[tile]] = pairs[i, 1]
        next_of[tile] += 1
