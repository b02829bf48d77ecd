"""Which scene triangles a ray triangle sees, exactly where, and within which pieces of the picture. Compiled.

In a ray triangle, the ray of a picture point q = (x, y, 1) has Pluecker coordinates (L, M) quadratic in q (`beams`);
so has the side on which it passes an edge from a to b of the scene:

    E(q) = L . (a x b) - M . (b - a).

Around a scene triangle the three sides add up to s N, where N = d . n is linear in q and n = (b - a) x (c - a). The ray
goes through the triangle where all three have the sign of N, for s > 0 in the ray triangle's part of the picture; their
shares of their sum are the weights of the opposite corners; and t = (s a - o) . n / N. That is exact: edges are curved,
as conics in the picture, and nothing is projected.

What remains is to say where in the picture to ask. Over a box a quadratic is at most its tangent at the middle plus a
bound on its second-order terms: three half-planes that hold all that is seen. Cutting a polygon by them makes its box
smaller and the bound, which falls with its square, tighter, so that two or three rounds leave little more than the
straight triangle; where they do not, the polygon is parted in two.

Source: exact edges in place of Vallance 2005, chapter 4; three-ray cameras were drawn by vertex and fragment programs
before, with a bounding triangle an image, by Hou, Wei, Shum and Guo (2006).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from anamorph.base.compiled import compiled, inlined
from anamorph.methods.trilinear.beams import PADDING, Beams
from anamorph.methods.trilinear.inside import is_inside, span
from anamorph.methods.trilinear.polygons import ROOM, area, box, cut
from anamorph.methods.trilinear.tree import LEAF

ROUNDS = 4
"""Of cutting before a polygon is parted."""

DEEPEST = 5
"""How often a polygon is halved at most."""

WORTH_PARTING = 400.0
"""Square pixels: a smaller polygon is drawn as it is."""

WORTH_CUTTING = 0.75
"""A round that leaves more than this share of the area is the last one."""

BENT = 0.1
"""A polygon is parted where the bound on some edge's bend is more than this share of its box's extent."""

FEW_SAMPLES = 32
"""Of a polygon that are asked one by one whether they see anything."""

ROUNDING = 8.0 * 2.0**-24
"""What float32 may lose of a quadratic's value, as a share of its terms: eight roundings."""

TERMS = 24
"""Numbers a pair: the quadratics of its three corners' weights, times s N; N; and N (t - near)."""

ACROSS, AHEAD = 18, 21

ALL, FRONTS, NONE = range(3)
"""What a ray triangle sees of its own group of scene triangles."""


class Triangles(NamedTuple):
    """The scene's triangles as the compiled loop reads them: a `Tree`'s arrays, and to which group each belongs."""

    faces: np.ndarray
    low: np.ndarray
    high: np.ndarray
    corners: np.ndarray
    group: np.ndarray
    """(M,) int32, by the caller's numbers."""


class Own(NamedTuple):
    """What each ray triangle sees of the surface that its rays leave."""

    face: np.ndarray
    """(K,) int32: the scene triangle that it is itself, or -1."""
    group: np.ndarray
    """(K,) int32"""
    sees: np.ndarray
    """(K,) int32: ALL, FRONTS or NONE of its group."""


class Room(NamedTuple):
    """Arrays to be filled, for one thread."""

    terms: np.ndarray
    """(P, 24) float64"""
    pair: np.ndarray
    """(P, 3) int32: ray triangle (its place in `Beams`), scene triangle, and 1 where it is seen from its front."""
    place: np.ndarray
    """(T, 3, 2) float32: triangles of the picture, pixels."""
    owner: np.ndarray
    """(T,) int32: the pair of each."""
    polygons: np.ndarray
    """(DEEPEST + 2, ROOM, 2) float64"""
    counts: np.ndarray
    """(DEEPEST + 2,) int64"""
    depths: np.ndarray
    """(DEEPEST + 2,) int64"""
    spare: np.ndarray
    """(ROOM, 2) float64"""
    stack: np.ndarray
    """(64,) int64"""


def make_room(pairs: int, pieces: int) -> Room:
    """Arrays for so many pairs and pieces."""
    return Room(
        np.empty((pairs, TERMS)), np.empty((pairs, 3), np.int32),
        np.empty((pieces, 3, 2), np.float32), np.empty(pieces, np.int32),
        np.empty((DEEPEST + 2, ROOM, 2)), np.empty(DEEPEST + 2, np.int64), np.empty(DEEPEST + 2, np.int64),
        np.empty((ROOM, 2)), np.empty(64, np.int64),
    )  # fmt: skip


@inlined
def _may_see(normals: np.ndarray, distances: np.ndarray, low: np.ndarray, high: np.ndarray) -> bool:
    for plane in range(len(distances)):
        furthest = 0.0
        for axis in range(3):
            normal = normals[plane, axis]
            furthest += normal * (high[axis] if normal > 0.0 else low[axis])
        # Written so that an empty box, whose sums are not numbers, is not seen.
        if not furthest >= distances[plane]:
            return False
    return True


@inlined
def _edge(beams: Beams, k: int, a: np.ndarray, b: np.ndarray, sign: float, terms: np.ndarray, first: int) -> None:
    """The quadratic of the side of the edge from a to b, at terms[first:first + 6]; corners relative to the anchor."""
    m0, m1, m2 = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
    e0, e1, e2 = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    for term in range(6):
        line, moment = beams.line[k, term], beams.moment[k, term]
        terms[first + term] = sign * (
            line[0] * m0 + line[1] * m1 + line[2] * m2 - moment[0] * e0 - moment[1] * e1 - moment[2] * e2
        )


@inlined
def _quadratic(terms: np.ndarray, first: int, x: float, y: float) -> tuple[float, float, float]:
    """Value and gradient."""
    xx, xy, yy, cx, cy = terms[first], terms[first + 1], terms[first + 2], terms[first + 3], terms[first + 4]
    return (
        (xx * x + xy * y + cx) * x + (yy * y + cy) * y + terms[first + 5],
        2.0 * xx * x + xy * y + cx,
        xy * x + 2.0 * yy * y + cy,
    )


@inlined
def _bend(terms: np.ndarray, first: int, x: float, y: float) -> float:
    """How far a quadratic rises above its tangent at most, within (x, y) of where that touches."""
    return max(terms[first], 0.0) * x * x + abs(terms[first + 1]) * x * y + max(terms[first + 2], 0.0) * y * y


@inlined
def _lies_beyond(
    beams: Beams, k: int, a: np.ndarray, b: np.ndarray, sign: float, terms: np.ndarray, first: int
) -> bool:
    """Find the quadratic of an edge's side; whether it is negative all over the ray triangle's part of the picture."""
    _edge(beams, k, a, b, sign, terms, first)
    x, y, half_x, half_y = beams.extent[k]
    value, slope_x, slope_y = _quadratic(terms, first, x, y)
    rise = abs(slope_x) * half_x + abs(slope_y) * half_y + _bend(terms, first, half_x, half_y)
    reach_x, reach_y = abs(x) + half_x, abs(y) + half_y
    return value + rise < -_rounding(terms, first, reach_x, reach_y)


@inlined
def _rounding(terms: np.ndarray, first: int, x: float, y: float) -> float:
    """What float32 may lose of a quadratic within (x, y) of the center."""
    size = abs(terms[first]) * x * x + abs(terms[first + 1]) * x * y + abs(terms[first + 2]) * y * y
    return ROUNDING * (size + abs(terms[first + 3]) * x + abs(terms[first + 4]) * y + abs(terms[first + 5]))


@inlined
def _widen(terms: np.ndarray, x: float, y: float) -> None:
    """Let each side be inside by what float32 may lose within (x, y) of the center, so that no pixel falls between."""
    for first in (0, 6, 12):
        terms[first + 5] += _rounding(terms, first, x, y)


@inlined
def _fit(terms: np.ndarray, polygon: np.ndarray, count: int, spare: np.ndarray) -> tuple[int, bool]:
    """Cut a polygon down to what may be seen in it; whether it is worth parting it after that."""
    size = area(polygon, count)
    for _ in range(ROUNDS):
        x, y, half_x, half_y = box(polygon, count)
        worst = 0.0
        for corner in range(3):
            value, slope_x, slope_y = _quadratic(terms, 6 * corner, x, y)
            bend = _bend(terms, 6 * corner, half_x, half_y)
            if value + abs(slope_x) * half_x + abs(slope_y) * half_y + bend < 0.0:
                return 0, False
            steepness = np.sqrt(slope_x * slope_x + slope_y * slope_y)
            worst = max(worst, bend / max(steepness, 1e-300))
            offset = value - slope_x * x - slope_y * y + bend + PADDING * steepness
            count = cut(polygon, count, spare, slope_x, slope_y, offset)
            if count == 0:
                return 0, False
        before, size = size, area(polygon, count)
        if size > WORTH_CUTTING * before:
            break
    return count, size > WORTH_PARTING and worst > BENT * max(half_x, half_y)


@inlined
def _holds_sample(terms: np.ndarray, polygon: np.ndarray, count: int, spacing: float) -> bool:
    """Whether a sample of the polygon sees the scene triangle, as far as a few of them can tell."""
    if spacing == 0.0:
        return True
    _, middle, _, half = box(polygon, count)
    asked = 0
    for row in range(int(np.ceil((middle - half) / spacing - 0.5)), int(np.floor((middle + half) / spacing - 0.5)) + 1):
        y = (row + 0.5) * spacing
        low, high = span(polygon, count, y)
        if low > high:
            continue
        for column in range(int(np.ceil(low / spacing - 0.5)), int(np.floor(high / spacing - 0.5)) + 1):
            asked += 1
            if asked > FEW_SAMPLES or is_inside(terms, (column + 0.5) * spacing, y):
                return True
    return False


@inlined
def _copy(polygon: np.ndarray, count: int, into: np.ndarray) -> None:
    for k in range(count):
        into[k, 0], into[k, 1] = polygon[k, 0], polygon[k, 1]


@inlined
def _emit(room: Room, polygon: np.ndarray, count: int, pair: int, pieces: int) -> int:
    for k in range(1, count - 1):
        for axis in range(2):
            room.place[pieces, 0, axis] = polygon[0, axis]
            room.place[pieces, 1, axis] = polygon[k, axis]
            room.place[pieces, 2, axis] = polygon[k + 1, axis]
        room.owner[pieces] = pair
        pieces += 1
    return pieces


@compiled
def _pieces(beams: Beams, k: int, room: Room, pair: int, pieces: int) -> int:
    """The pieces of a pair whose terms stand in the room; their number with those before, or -1 if there is no room."""
    terms = room.terms[pair]
    _copy(beams.domain[k], beams.corners[k], room.polygons[0])
    first = room.polygons[0]
    count = beams.corners[k]
    x, y, half_x, half_y = beams.extent[k]
    _widen(terms, abs(x) + half_x, abs(y) + half_y)
    for side in (ACROSS, AHEAD):
        a, b = terms[side], terms[side + 1]
        count = cut(first, count, room.spare, a, b, terms[side + 2] + PADDING * np.sqrt(a * a + b * b))
    if count == 0:
        return pieces
    room.counts[0], room.depths[0] = count, 0
    waiting = 1
    while waiting > 0:
        waiting -= 1
        polygon, depth = room.polygons[waiting], room.depths[waiting]
        count, parts = _fit(terms, polygon, room.counts[waiting], room.spare)
        if count == 0:
            continue
        if not parts or depth == DEEPEST:
            if not _holds_sample(terms, polygon, count, beams.spacing):
                continue
            if pieces + count > len(room.owner):
                return -1
            pieces = _emit(room, polygon, count, pair, pieces)
            continue
        x, y, half_x, half_y = box(polygon, count)
        other = room.polygons[waiting + 1]
        _copy(polygon, count, other)
        a, b = (1.0, 0.0) if half_x > half_y else (0.0, 1.0)
        middle = a * x + b * y
        room.counts[waiting] = cut(polygon, count, room.spare, a, b, PADDING - middle)
        room.counts[waiting + 1] = cut(other, count, room.spare, -a, -b, PADDING + middle)
        room.depths[waiting], room.depths[waiting + 1] = depth + 1, depth + 1
        waiting += 2
    return pieces


@compiled
def _meet(
    beams: Beams, triangles: Triangles, own: Own, k: int, place: int, room: Room, pairs: int, pieces: int
) -> tuple[int, int]:
    """Add what ray triangle k sees of one scene triangle. Pairs and pieces with those before; -1 for no room."""
    face = triangles.faces[place]
    if face == own.face[k]:
        return pairs, pieces
    sees = own.sees[k] if triangles.group[face] == own.group[k] else ALL
    if sees == NONE:
        return pairs, pieces
    if pairs + 2 > len(room.pair):
        return -1, pieces
    corners, anchor = triangles.corners[place], beams.anchor[k]
    a = (corners[0, 0] - anchor[0], corners[0, 1] - anchor[1], corners[0, 2] - anchor[2])
    b = (corners[1, 0] - anchor[0], corners[1, 1] - anchor[1], corners[1, 2] - anchor[2])
    c = (corners[2, 0] - anchor[0], corners[2, 1] - anchor[1], corners[2, 2] - anchor[2])
    e0, e1, e2 = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    f0, f1, f2 = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    n0, n1, n2 = e1 * f2 - e2 * f1, e2 * f0 - e0 * f2, e0 * f1 - e1 * f0
    height = a[0] * n0 + a[1] * n1 + a[2] * n2
    direction, origin, scale = beams.direction[k], beams.origin[k], beams.scale[k]
    across0 = n0 * direction[0, 0] + n1 * direction[1, 0] + n2 * direction[2, 0]
    across1 = n0 * direction[0, 1] + n1 * direction[1, 1] + n2 * direction[2, 1]
    across2 = n0 * direction[0, 2] + n1 * direction[1, 2] + n2 * direction[2, 2]
    ahead0 = height * scale[0] - n0 * origin[0, 0] - n1 * origin[1, 0] - n2 * origin[2, 0]
    ahead1 = height * scale[1] - n0 * origin[0, 1] - n1 * origin[1, 1] - n2 * origin[2, 1]
    ahead2 = height * scale[2] - n0 * origin[0, 2] - n1 * origin[1, 2] - n2 * origin[2, 2]
    low, high = np.inf, -np.inf
    ahead_low, ahead_high = np.inf, -np.inf
    for corner in range(beams.corners[k]):
        x, y = beams.domain[k, corner, 0], beams.domain[k, corner, 1]
        value = across0 * x + across1 * y + across2
        low, high = min(low, value), max(high, value)
        value = ahead0 * x + ahead1 * y + ahead2
        ahead_low, ahead_high = min(ahead_low, value), max(ahead_high, value)
    for side in range(2):
        # From the back first: N > 0.
        sign = 1.0 - 2.0 * side
        seen = (high > 0.0 and ahead_high > 0.0) if side == 0 else (low < 0.0 and ahead_low < 0.0)
        if not seen or (side == 0 and sees == FRONTS):
            continue
        terms = room.terms[pairs]
        if (
            _lies_beyond(beams, k, b, c, sign, terms, 0)
            or _lies_beyond(beams, k, c, a, sign, terms, 6)
            or _lies_beyond(beams, k, a, b, sign, terms, 12)
        ):
            continue
        terms[ACROSS], terms[ACROSS + 1], terms[ACROSS + 2] = sign * across0, sign * across1, sign * across2
        terms[AHEAD], terms[AHEAD + 1], terms[AHEAD + 2] = sign * ahead0, sign * ahead1, sign * ahead2
        for term in range(3):
            terms[AHEAD + term] -= beams.near[k] * terms[ACROSS + term]
        room.pair[pairs, 0], room.pair[pairs, 1], room.pair[pairs, 2] = k, face, side
        after = _pieces(beams, k, room, pairs, pieces)
        if after < 0:
            return -1, pieces
        if after > pieces:
            pairs, pieces = pairs + 1, after
    return pairs, pieces


@compiled
def fill(beams: Beams, triangles: Triangles, own: Own, first: int, stop: int, room: Room) -> tuple[int, int, int]:
    """What ray triangles from `first` to `stop` see. The one at which the room ran out, or `stop`; pairs; pieces."""
    pairs, pieces = 0, 0
    leaves = len(triangles.low) // 2
    for k in range(first, stop):
        whole_pairs, whole_pieces = pairs, pieces
        room.stack[0] = 1
        waiting = 1
        while waiting > 0:
            waiting -= 1
            node = room.stack[waiting]
            if not _may_see(beams.normals[k], beams.distances[k], triangles.low[node], triangles.high[node]):
                continue
            if node < leaves:
                room.stack[waiting], room.stack[waiting + 1] = 2 * node + 1, 2 * node
                waiting += 2
                continue
            start = (node - leaves) * LEAF
            for place in range(start, min(start + LEAF, len(triangles.faces))):
                pairs, pieces = _meet(beams, triangles, own, k, place, room, pairs, pieces)
                if pairs < 0:
                    return k, whole_pairs, whole_pieces
    return stop, pairs, pieces
