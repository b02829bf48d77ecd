"""Pairs of a ray triangle and a small scene triangle turned into pieces one after the other, compiled.

A core works through a stretch of them and starts a new set of arrays when one is full. Each pair is worked out once,
and its pieces are where they would be on any number of cores.
"""

from __future__ import annotations

import numpy as np

from anamorph.base.compiled import compiled
from anamorph.methods.trilinear.straight.barycentric_grid import small_triangle
from anamorph.methods.trilinear.straight.chains import LINKS, SHAPES, connected, link_t
from anamorph.methods.trilinear.straight.cutting import CORNERS, MOST, Pieces
from anamorph.methods.trilinear.straight.strips import strip
from anamorph.methods.trilinear.straight.traces import BESIDE, CUTS, TRACE, has_ray, levels_of, side_crossings, traced
from anamorph.raytriangle.rows import LINES, PACE, SHIFT
from anamorph.raytriangle.solve import WORDS, solve_point

ENDLESS = 1e6
"""In place of an infinite t: this many times the distance of the corners from the middle, scaled."""

POINTS = 4 * LINKS + 6 * CUTS + 4 * SHAPES
"""Most points of both traces of a triangle's shapes, without extra levels: links on either trace and those beside them,
each edge's cuts on both traces, and the ends of parts."""

USUAL = 4
"""Pieces of a small triangle, as arrays are made for; where there are more, more arrays are."""


def pieces_for(count: int) -> Pieces:
    """Arrays for so many."""
    shapes = ((count, 3, 2), np.float32), ((count, 3, 2), np.float32), ((count, 3), np.float32), ((count,), np.int32)
    place, weights, t, pair = (np.empty(shape, kind) for shape, kind in shapes)
    return place, weights, t, pair


def filled(
    rows: np.ndarray,
    corners: np.ndarray,
    pairs: np.ndarray,
    start: int,
    stop: int,
    near: float,
    slices: int,
    tessellate: int,
    scene_clip: bool,
) -> list[tuple[np.ndarray, ...]]:
    """The pieces of some small triangles, in as many parts as it takes to hold them."""
    capacity = POINTS + 2 * SHAPES * slices
    work = (
        np.zeros((3, 3)),
        np.zeros((3, 2)),
        np.zeros(8),
        np.zeros((3, WORDS)),
        np.zeros((2, LINKS, 3), np.int64),
        np.zeros((SHAPES, 2), np.int64),
        np.full((3, CUTS), np.inf),
        np.zeros((2, capacity, TRACE)),
        np.zeros(capacity),
        np.zeros(2, np.int64),
        np.zeros((3, CORNERS, TRACE)),
    )
    most = MOST * capacity
    result = []
    while start < stop:
        pieces = pieces_for(most + USUAL * (stop - start))
        start, used = _fill(rows, corners, pairs, start, stop, near, slices, tessellate, scene_clip, most, work, pieces)
        result.append(tuple(array[:used].copy() for array in pieces))
    return result


@compiled
def _fill(
    rows: np.ndarray,
    corners: np.ndarray,
    pairs: np.ndarray,
    begin_item: int,
    end_item: int,
    near: float,
    slices: int,
    tessellate: int,
    scene_clip: bool,
    most: int,
    work: tuple[np.ndarray, ...],
    pieces: Pieces,
) -> tuple[int, int]:
    """Fill `pieces` from small triangle `begin_item` on; with which to go on, and how many pieces there are."""
    points, within, found, solved, links, ends, cuts, traces, levels, start, polygon = work
    divided = tessellate * tessellate
    used = 0
    for item in range(begin_item, end_item):
        if used + most > len(pieces[3]):
            return item, used
        pair = item // divided
        row = rows[pairs[pair, 0]]
        small_triangle(corners[pairs[pair, 1]], tessellate, item - pair * divided, points, within)
        distance = 1.0
        for k in range(3):
            solve_point(row, points[k, 0], points[k, 1], points[k, 2], found, solved[k])
            distance = max(distance, max(abs(solved[k, 0]), abs(solved[k, 1]), abs(solved[k, 2])))
        shapes = connected(solved, links, ends)
        if shapes and scene_clip:
            side_crossings(row, solved, cuts)
        nearest = near / row[PACE] - row[SHIFT]
        endless = max(nearest, 0.0) + ENDLESS * distance
        start[0], start[1] = 0, 0
        for shape in range(shapes):
            stop = ends[shape]
            first, last = link_t(solved, links, 0, start[0]), link_t(solved, links, 0, stop[0] - 1)
            begin = max(first, nearest)
            # Where the rays meet in a line or a point, what is before is one part and what is behind another.
            for part in range(3):
                end = min(last, endless)
                if part < 2:
                    if not begin < row[LINES + part] < end:
                        continue
                    end = row[LINES + part]
                if begin > end:
                    break
                low, high = begin, end
                beside = BESIDE * (high - low)
                for line in range(2):
                    if abs(row[LINES + line] - begin) <= beside:
                        low = begin + beside
                    if abs(row[LINES + line] - end) <= beside:
                        high = end - beside
                begin = end
                one_start = low == first and has_ray(solved, links, 0, start[0])
                one_end = high == last and has_ray(solved, links, 0, stop[0] - 1)
                corners_there = stop[0] - start[0] + stop[1] - start[1] - one_start - one_end
                count = 0
                if scene_clip or slices > 0 or corners_there > 3:
                    count = levels_of(solved, links, start, stop, low, high, slices, cuts, levels)
                lefts = traced(row, solved, within, links, 0, start[0], stop[0], low, high, levels[:count], traces[0])
                rights = traced(row, solved, within, links, 1, start[1], stop[1], low, high, levels[:count], traces[1])
                if lefts and rights:
                    used = strip(row, pair, traces, lefts, rights, one_start, one_end, polygon, pieces, used)
            start[0], start[1] = stop[0], stop[1]
    return item + 1, used
