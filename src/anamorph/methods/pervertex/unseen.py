"""What no map sees: for each triangle of a body, the triangles of the scene that its rays may meet there. Compiled."""

from __future__ import annotations

import numpy as np

from anamorph.base.compiled import compiled, inlined
from anamorph.base.vectors import Vector, along, cross, dot

MOST = 6
"""Triangles of a list; with more to look through, casting the rays is cheaper."""

ASTRAY = 0.02, 0.15
"""How far rays may stray from the hull of those at the corners, in its size: always, and by the square of the angle
between them."""


def parts_of(origins: np.ndarray, directions: np.ndarray, ranges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The listed parts of triangles' rays.

    Parameters
    ----------
    origins, directions : (F, 3, 3) float64
        Of the rays at the corners; unit directions.
    ranges : (F, 3) float64
        As in `SurfacePlan`.

    Returns
    -------
    ends : (F, 2, 6, 3) float64
        Of the part at the start and of that around the crossing: where the rays are at its beginning and at its end.
    margin : (F, 2) float64
        How far the part may reach beyond the hull of these; negative where there is none.
    """
    start = np.stack([np.zeros(len(ranges)), ranges[:, 1]], axis=1)
    stop = np.where(np.isfinite(ranges[:, [0, 2]]), ranges[:, [0, 2]], -1.0)
    ends = np.concatenate(
        [origins[:, None] + each[:, :, None, None] * directions[:, None] for each in (start, stop)], axis=2
    )
    spread = np.linalg.norm(directions - np.roll(directions, 1, axis=1), axis=2).max(axis=1)
    size = np.ptp(ends, axis=2).max(axis=2)
    margin = (ASTRAY[0] + ASTRAY[1] * spread[:, None] ** 2) * size
    return ends, np.where(stop > start, margin, -1.0)


def listed(
    ends: np.ndarray, margin: np.ndarray, corners: np.ndarray, counted: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """List for each triangle of a body what reaches into the parts of its rays.

    Parameters
    ----------
    ends, margin
        From `parts_of`.
    corners : (T, 3, 3) float32
        The triangles of the scene.
    counted : (T,) bool
        Which of these count.

    Returns
    -------
    first : (F + 1,) int32
    unseen : (N,) int32
        Numbers of the triangles, from 1: face f's are unseen[first[f]:first[f + 1]].
    whole : (F,) bool
        Whether a list has all; it is empty where there are too many.
    """
    count, found = np.zeros(len(ends), np.int32), np.zeros((len(ends), MOST), np.int32)
    there = margin >= 0.0
    low = (ends.min(axis=2) - margin[..., None])[there].min(axis=0, initial=np.inf)
    high = (ends.max(axis=2) + margin[..., None])[there].max(axis=0, initial=-np.inf)
    near = np.flatnonzero(
        counted & (corners.min(axis=1) <= high).all(axis=1) & (corners.max(axis=1) >= low).all(axis=1)
    )
    _reaching(ends, margin, corners[near].astype(float), near, count, found)
    whole = count <= MOST
    count[~whole] = 0
    first = np.concatenate([[0], np.cumsum(count)]).astype(np.int32)
    return first, found[np.arange(MOST) < count[:, None]], whole


@inlined
def _point(points: np.ndarray, number: int) -> Vector:
    return (points[number, 0], points[number, 1], points[number, 2])


@inlined
def _apart(normal: Vector, ends: np.ndarray, corners: np.ndarray, margin: float) -> bool:
    """Whether a plane of this normal, of any length, separates a triangle from the ends by more than the margin."""
    length = dot(normal, normal) ** 0.5
    least, most = np.inf, -np.inf
    for i in range(6):
        height = dot(normal, _point(ends, i))
        least, most = min(least, height), max(most, height)
    low, high = np.inf, -np.inf
    for i in range(3):
        height = dot(normal, _point(corners, i))
        low, high = min(low, height), max(high, height)
    return low > most + margin * length or high < least - margin * length


@inlined
def _reaches(ends: np.ndarray, corners: np.ndarray, margin: float) -> bool:
    """Whether a triangle may reach into the hull of six ends: no plane along their sides, or of its own, is between."""
    for axis in range(3):
        normal = (1.0 if axis == 0 else 0.0, 1.0 if axis == 1 else 0.0, 1.0 if axis == 2 else 0.0)
        if _apart(normal, ends, corners, margin):
            return False
    a = _point(corners, 0)
    own = cross(along(_point(corners, 1), -1.0, a), along(_point(corners, 2), -1.0, a))
    if _apart(own, ends, corners, margin):
        return False
    for i in range(3):
        j = (i + 1) % 3
        edge = along(_point(ends, j), -1.0, _point(ends, i))
        for k in (i, j):
            side = cross(edge, along(_point(ends, k + 3), -1.0, _point(ends, k)))
            if _apart(side, ends, corners, margin):
                return False
    first = _point(ends, 0)
    return not _apart(
        cross(along(_point(ends, 1), -1.0, first), along(_point(ends, 2), -1.0, first)), ends, corners, margin
    )


@compiled
def _reaching(
    ends: np.ndarray,
    margin: np.ndarray,
    corners: np.ndarray,
    numbers: np.ndarray,
    count: np.ndarray,
    found: np.ndarray,
) -> None:
    for face in range(len(ends)):
        for k in range(len(corners)):
            for part in range(2):
                if margin[face, part] >= 0.0 and _reaches(ends[face, part], corners[k], margin[face, part]):
                    if count[face] < found.shape[1]:
                        found[face, count[face]] = numbers[k] + 1
                    count[face] += 1
                    break
            if count[face] > found.shape[1]:
                break
