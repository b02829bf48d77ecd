"""Scene triangles drawn through ray triangles in the thesis's own way, with straight edges, in bulk.

Source: Vallance 2005, chapters 4 and 5: corners projected and joined into shapes (4.2, 4.3), cut at the view plane
(4.6), with points added where they leave the ray triangle (5.2), at extra levels of t (4.5.2), or by dividing the scene
triangle first (4.5.1). Here to be compared with exact edges, and therefore compiled.

Deviations: a shape of two corners is a line in the thesis and nothing here. A shape that goes on to infinity (rays
parallel to one plane) ends at `fill.ENDLESS`, close to the point of the image to which it goes. Where the rays of a
ray triangle all meet in a point or a line ahead, the image of what extends across it goes through infinity, and is
cut in two there. Shapes of more than three corners, and those with cuts or extra levels, get points on both chains at
the same t, instead of being drawn as polygons of any form. And see `traces` and `strips`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.base.compiled import over_all_cores
from anamorph.methods.trilinear.straight.fill import filled, pieces_for
from anamorph.methods.trilinear.straight.swept_sides import straight_rows

GRAIN = 4096
"""Small triangles that one core takes at a time."""


@dataclass(frozen=True, eq=False)
class StraightPieces:
    """Triangles of the image, T of them, in the order of their pairs.

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
    image: np.ndarray,
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
    of cores.

    Parameters
    ----------
    image : (K, 3, 3) array
        The ray triangles' homogeneous image corners (x w, y w, w), pixels.
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
        If a ray is not finite, or all directions of a ray triangle are 0.
    """
    rows = straight_rows(image, origins, directions)
    corners, pairs = np.ascontiguousarray(corners, float), np.ascontiguousarray(pairs, np.int64)
    divided = tessellate * tessellate
    total = len(pairs) * divided
    found: list[list[tuple[np.ndarray, ...]]] = [[] for _ in range(0, total, GRAIN)]

    def work(start: int, stop: int) -> None:
        found[start // GRAIN] = filled(rows, corners, pairs, start, stop, near, slices, tessellate, scene_clip)

    over_all_cores(work, total, GRAIN)
    parts = [pieces_for(0), *(part for chunk in found for part in chunk)]
    return StraightPieces(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))
