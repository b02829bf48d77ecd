"""Scene triangles drawn through ray triangles in the thesis's own way, with straight edges, in bulk.

Source: Vallance 2005, chapters 4 and 5: corners projected and joined into shapes (4.2, 4.3), cut at the view plane
(4.6), with points added where they leave the ray triangle (5.2), at extra levels of t (4.5.2), or by dividing the scene
triangle first (4.5.1). Here to be compared with exact edges, and therefore compiled.

Deviations: a shape of two corners is a line in the thesis and nothing here. A shape that goes on to infinity (rays
parallel to one plane) ends at `fill.ENDLESS`, close to the point of the picture to which it goes. Where the rays of a
ray triangle all meet in a point or a line ahead, the picture of what extends across it goes through infinity, and is
cut in two there. Shapes of more than three corners, and those with cuts or extra levels, get points on both chains at
the same t, instead of being drawn as polygons of any form. And see `traces` and `strips`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from anamorph.base.compiled import over_all_cores
from anamorph.base.errors import AnamorphError
from anamorph.methods.trilinear.straight.fill import filled, pieces_for
from anamorph.raytriangle.coefficients import ray_triangle_frame
from anamorph.raytriangle.packed import packed

GRAIN = 4096
"""Small triangles that one core takes at a time; enough for neighbours to share their corners."""


@dataclass(frozen=True, eq=False)
class StraightPieces:
    """Triangles of the picture, T of them, in the order of their pairs.

    Parameters
    ----------
    place : (T, 3, 2) float32
        Corners in pixels. They may lie outside the ray triangle, which the drawing has to respect.
    weights : (T, 3, 2) float32
        Of the scene triangle's second and third corner.
    t : (T, 3) float32
        Along the rays, in lengths of their interpolated directions.
    pair : (T,) int32
        The row of `pairs`.
    """

    place: np.ndarray
    weights: np.ndarray
    t: np.ndarray
    pair: np.ndarray


def straight_pieces(
    picture: np.ndarray,
    origins: np.ndarray,
    directions: np.ndarray,
    corners: np.ndarray,
    pairs: np.ndarray,
    *,
    near: float = 0.0,
    slices: int = 0,
    tessellate: int = 1,
    scene_clip: bool = True,
) -> StraightPieces:
    """What each ray triangle of `pairs` sees of its scene triangle, with straight edges between projected points.

    t and weights are meant to be interpolated linearly over each piece, as in the thesis. It is the same on any number
    of cores. Fastest where pairs are in the order of ray triangles and neighbouring scene triangles follow each other.

    Parameters
    ----------
    picture : (K, 3, 3) array
        The ray triangles' homogeneous picture corners (x w, y w, w), pixels.
    origins, directions : (K, 3, 3) array
        A row for each of the three rays; directions of any length, but not all 0.
    corners : (M, 3, 3) array
        Of the scene triangles.
    pairs : (P, 2) int array
        Ray triangle and scene triangle.
    near : float
        Only what has t >= near is kept.
    slices : int
        Extra levels of t for each shape.
    tessellate : int
        Into how many parts each edge of a scene triangle is divided, which makes so many squared of it.
    scene_clip : bool
        Whether points are added where a shape leaves the ray triangle, so that those of neighbours meet there.

    Raises
    ------
    AnamorphError
        If a shape, a number or an index is not as stated.
    """
    picture, origins, directions, corners, pairs = _checked(picture, origins, directions, corners, pairs)
    if not math.isfinite(near):
        raise AnamorphError(f"straight pieces: near is {near}; it must be a finite number")
    for name, factor, least in (("slices", slices, 0), ("tessellate", tessellate, 1)):
        if factor < least:
            raise AnamorphError(f"straight pieces: {name} is {factor}; it must be {least} or more")
    rows = packed(ray_triangle_frame(origins, directions), picture)
    divided = tessellate * tessellate
    total = len(pairs) * divided
    found: list[list[tuple[np.ndarray, ...]]] = [[] for _ in range(0, total, GRAIN)]

    def work(start: int, stop: int) -> None:
        found[start // GRAIN] = filled(rows, corners, pairs, start, stop, near, slices, tessellate, scene_clip)

    over_all_cores(work, total, GRAIN)
    parts = [pieces_for(0), *(part for chunk in found for part in chunk)]
    return StraightPieces(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


def _checked(
    picture: np.ndarray, origins: np.ndarray, directions: np.ndarray, corners: np.ndarray, pairs: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    picture, origins, directions, corners = (
        np.ascontiguousarray(array, float) for array in (picture, origins, directions, corners)
    )
    pairs = np.ascontiguousarray(pairs, np.int64)
    if any(array.ndim != 3 or array.shape[1:] != (3, 3) for array in (picture, origins, directions, corners)):
        raise AnamorphError("straight pieces: picture, origins, directions and corners must be (N, 3, 3) arrays")
    if not len(picture) == len(origins) == len(directions):
        raise AnamorphError("straight pieces: picture, origins and directions must have a row for each ray triangle")
    if not (np.isfinite(picture).all() and np.isfinite(corners).all()):
        raise AnamorphError("straight pieces: picture and corners must be finite numbers")
    if pairs.ndim != 2 or pairs.shape[1] != 2:
        raise AnamorphError("straight pieces: pairs must be (P, 2): ray triangle, scene triangle")
    if len(pairs) and (pairs.min() < 0 or (pairs.max(axis=0) >= (len(origins), len(corners))).any()):
        raise AnamorphError("straight pieces: pairs name a ray triangle or a scene triangle that is not there")
    return picture, origins, directions, corners, pairs
