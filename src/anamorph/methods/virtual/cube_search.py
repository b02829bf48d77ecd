"""The paper's search for where a reflector shows a point, on cube maps of its positions and normals. Compiled, float64.

At the place P with normal N, B is the unit bisector of the directions to the eye O and to the point V. The error is
(1 - B . N) / 2, which is 0 where V is seen. Steps lead along B - N, which is projected onto the cube: from P it is as
long as P is far from the middle, so that on a ball its end is seen from the middle along B.

A point that the reflector hides has no such place. Its own mirror image in the tangent plane at P takes its place in
each step, so that the search ends where the ray from the eye to the hidden point enters; and that image is its virtual
point. So a triangle that is partly hidden goes on beyond the reflector's horizon, where nothing of it is seen.

Source: Estalella et al. 2005, sections 4.2, 4.3 and 6.1. The paper does not say how the step is adapted: here it is
halved where the two bisector directions of a step differ by more than `DIFFERENT` of their length, and lengthened by
half where they differ by less than `ALIKE`.
"""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import compiled, over_all_cores
from anamorph.base.vectors import Vector, along, dot, unit
from anamorph.methods.virtual.reflector_maps import BORDER, ReflectorMaps

REFLECTED = np.dtype([("place", "f4", 3), ("error", "f4"), ("behind", "f4", 3), ("length", "f4")])
"""`Reflected` of cube_search.wgsl."""

SHOWN, HIDDEN, WITHIN = 0.0, 1.0, 2.0
"""Of a point: the reflector shows it, or hides it, or it is inside."""

DIFFERENT, ALIKE = 0.4, 0.2

CUTS = 16
"""Of the way to a point, until it is in the reflector or nearest to it."""

LARGEST_STEP, LEAST_STEP = 2.0, 1.0 / 64.0

FIRST_STEP, AGAIN_STEP = 1.0, 0.25
"""The first step; from the last places it is shorter, because too long a one would lead astray anew for each frame."""

GRAIN = 1024


def search(
    maps: ReflectorMaps, eye: np.ndarray, points: np.ndarray, iterations: int, last: np.ndarray | None = None
) -> np.ndarray:
    """Search for the reflection places of points (N, 3), with so many steps each.

    Parameters
    ----------
    maps : ReflectorMaps
    eye : (3,) array
    points : (N, 3) array
        Metres.
    iterations : int
    last : (N, 12) float64, optional
        What was found of these points before, from which the search starts; but not for points that the reflector now
        hides, or now shows, and not inside of it.

    Returns
    -------
    found : (N, 12) float64
        The place on the reflector, the normal there, the virtual point behind it, the length of the path, the error,
        and `SHOWN`, `HIDDEN` or `WITHIN`. Metres. The virtual point of a hidden one is its mirror image in the tangent
        plane, so that virtual objects go on beyond the horizon.
    """
    found = np.empty((len(points), 12))
    center, side = np.asarray(maps.center, float), 1.0 if maps.outside else -1.0
    origin = tuple(float(each) for each in np.asarray(eye, float) - center)
    sought = np.asarray(points, float) - center
    before = np.full((len(points), 4), np.nan)
    if last is not None:
        before[:, :3], before[:, 3] = last[:, :3] - center, last[:, 11]

    def work(start: int, stop: int) -> None:
        _search_all(
            maps.positions, maps.normals, side, maps.reach, origin, sought, before, iterations, start, stop, found
        )

    over_all_cores(work, len(points), GRAIN)
    found[:, :3] += center
    found[:, 6:9] += center
    return found


@compiled
def _search_all(
    positions: np.ndarray,
    normals: np.ndarray,
    side: float,
    reach: float,
    eye: Vector,
    points: np.ndarray,
    before: np.ndarray,
    iterations: int,
    start: int,
    stop: int,
    found: np.ndarray,
) -> None:
    for i in range(start, stop):
        point = (points[i, 0], points[i, 1], points[i, 2])
        hidden = side > 0.0 and is_hidden(positions, reach, eye, point)
        # The bisector of the directions from the middle; of a hidden point the direction to the eye alone is of use.
        place = unit(eye) if hidden else bisector(eye, (0.0, 0.0, 0.0), point)
        place, step = along((0.0, 0.0, 0.0), side, place), FIRST_STEP
        if before[i, 3] == (HIDDEN if hidden else SHOWN):
            place, step = (before[i, 0], before[i, 1], before[i, 2]), AGAIN_STEP
        place = _settled(positions, normals, side, eye, point, hidden, place, step, iterations)
        p, n = lookup(positions, place), unit(lookup(normals, place))
        seen = mirrored(point, p, n) if hidden else point
        b = bisector(eye, p, seen)
        from_eye = along(p, -1.0, eye)
        away = math.sqrt(dot(from_eye, from_eye))
        offset = along(point, -1.0, p)
        far = math.sqrt(dot(offset, offset))
        behind = seen if hidden else along(p, far / max(away, 1e-300), from_eye)
        for k in range(3):
            found[i, k], found[i, 3 + k], found[i, 6 + k] = p[k], n[k], behind[k]
        found[i, 9], found[i, 10], found[i, 11] = away + far, 0.5 * (1.0 - dot(b, n)), HIDDEN if hidden else SHOWN
        if side > 0.0 and depth_in(positions, point) < 1.0:
            found[i, 11] = WITHIN


@compiled
def _settled(
    positions: np.ndarray,
    normals: np.ndarray,
    side: float,
    eye: Vector,
    point: Vector,
    hidden: bool,
    place: Vector,
    step: float,
    iterations: int,
) -> Vector:
    """Where, seen from the middle, a search that starts at `place` is after its steps, the first of them `step`."""
    for _ in range(iterations):
        p = lookup(positions, place)
        first = toward(positions, normals, side, eye, point, hidden, p, place)
        middle = along(p, 0.5 * step, first)
        second = toward(positions, normals, side, eye, point, hidden, lookup(positions, middle), middle)
        change = along(second, -1.0, first)
        differs = math.sqrt(dot(change, change)) / max(math.sqrt(dot(first, first)), 1e-300)
        place = along(p, step, second)
        if differs > DIFFERENT:
            step = max(0.5 * step, LEAST_STEP)
        elif differs < ALIKE:
            step = min(1.5 * step, LARGEST_STEP)
    return place


@compiled
def toward(
    positions: np.ndarray,
    normals: np.ndarray,
    side: float,
    eye: Vector,
    point: Vector,
    hidden: bool,
    p: Vector,
    place: Vector,
) -> Vector:
    """B - N at a place, as long as that is far from the middle."""
    n = unit(lookup(normals, place))
    b = bisector(eye, p, mirrored(point, p, n) if hidden else point)
    scale = side * math.sqrt(dot(p, p))
    return (scale * (b[0] - n[0]), scale * (b[1] - n[1]), scale * (b[2] - n[2]))


@compiled
def bisector(eye: Vector, p: Vector, point: Vector) -> Vector:
    """The unit vector between the directions from p to the eye and to a point."""
    to_eye, to_point = unit(along(eye, -1.0, p)), unit(along(point, -1.0, p))
    return unit(along(to_eye, 1.0, to_point))


@compiled
def mirrored(point: Vector, p: Vector, n: Vector) -> Vector:
    """The image of a point in the plane through p with unit normal n."""
    return along(point, -2.0 * dot(along(point, -1.0, p), n), n)


@compiled
def depth_in(positions: np.ndarray, point: Vector) -> float:
    """How far a point is from the middle, where the reflector is 1."""
    surface = lookup(positions, point)
    return math.sqrt(dot(point, point)) / max(math.sqrt(dot(surface, surface)), 1e-300)


@compiled
def is_hidden(positions: np.ndarray, reach: float, eye: Vector, point: Vector) -> bool:
    """Whether a convex reflector, no farther from its middle than `reach`, stands between the eye and a point.

    Along a line the depths in a convex body have one minimum.
    """
    way = along(point, -1.0, eye)
    nearest = along(eye, min(max(-dot(eye, way) / max(dot(way, way), 1e-300), 0.0), 1.0), way)
    if math.sqrt(dot(nearest, nearest)) >= reach:
        return False
    low, high, cut = 0.0, 1.0, 0
    while cut < CUTS and depth_in(positions, along(eye, 0.5 * (low + high), way)) >= 1.0:
        third = (high - low) / 3.0
        if depth_in(positions, along(eye, low + third, way)) < depth_in(positions, along(eye, high - third, way)):
            high -= third
        else:
            low += third
        cut += 1
    between = along(eye, 0.5 * (low + high), way)
    return depth_in(positions, between) < 1.0


@compiled
def lookup(texels: np.ndarray, direction: Vector) -> Vector:
    """What a map (6, n + 2, n + 2, 3) shows in a direction, between its four texels."""
    x, y, z = abs(direction[0]), abs(direction[1]), abs(direction[2])
    axis = 0 if x >= y and x >= z else (1 if y >= z else 2)
    along_axis = direction[axis]
    face = 2 * axis + (1 if along_axis < 0.0 else 0)
    scale = 1.0 / max(abs(along_axis), 1e-300)
    size = texels.shape[1] - 2 * BORDER
    s = 0.5 * size * (direction[(axis + 1) % 3] * scale + 1.0) - 0.5 + BORDER
    t = 0.5 * size * (direction[(axis + 2) % 3] * scale + 1.0) - 0.5 + BORDER
    i, j = min(max(int(s), 0), size), min(max(int(t), 0), size)
    a, b = s - i, t - j
    found = (0.0, 0.0, 0.0)
    for row, column, weight in (
        (j, i, (1.0 - a) * (1.0 - b)), (j, i + 1, a * (1.0 - b)), (j + 1, i, (1.0 - a) * b), (j + 1, i + 1, a * b),
    ):  # fmt: skip
        texel = (texels[face, row, column, 0], texels[face, row, column, 1], texels[face, row, column, 2])
        found = along(found, weight, texel)
    return found
