"""Polygons as triangles: concave ones, bent ones, and those whose holes are joined to their outline by bridges."""

from __future__ import annotations

import mapbox_earcut
import numpy as np

from anamorph.base.notes import note
from anamorph.base.vectors import across, tuple_of

SLACK = 1e-9
"""The share of a polygon's area that a triangle may be wound against it by rounding."""

CROSSING = 1e-6
"""A polygon whose triangles have another area than itself, by this share of it, crosses itself."""


def triangulated(corners: np.ndarray, counts: np.ndarray, where: str) -> tuple[np.ndarray, np.ndarray]:
    """Part polygons into triangles that cover them once.

    Where the triangles from the first corner to all edges do so, they are taken. Else ears are cut off the polygon
    as seen along its normal (the mean over its area), by mapbox_earcut; spikes and repeated corners go.

    Parameters
    ----------
    corners : (C, 3) float64
        The corners of all polygons, one polygon after another.
    counts : (P,) int
        How many each polygon has; what has fewer than three is no polygon.
    where : str
        What to call the part in the note on polygons that cross themselves.

    Returns
    -------
    triangles : (T, 3) int64
        Rows of `corners`, in the polygons' order, each wound as its polygon is.
    polygons : (T,) int64
        The polygon of each.
    """
    counts = np.asarray(counts, np.int64)
    starts = np.cumsum(counts) - counts
    triangles, polygons, crossing = [np.zeros((0, 3), np.int64)], [np.zeros(0, np.int64)], 0
    for count in np.unique(counts[counts >= 3]):
        alike = np.flatnonzero(counts == count)
        rows = starts[alike, None] + np.arange(count)
        parts = np.stack(np.broadcast_arrays(rows[:, :1], rows[:, 1:-1], rows[:, 2:]), axis=-1)
        normals, covered = _covered(corners[rows]) if count > 3 else (np.zeros((0, 3)), np.ones(len(rows), bool))
        triangles.append(parts[covered].reshape(-1, 3))
        polygons.append(np.repeat(alike[covered], count - 2))
        for number in np.flatnonzero(~covered):
            own, crosses = _cut(corners[rows[number]], normals[number])
            triangles.append(rows[number][own])
            polygons.append(np.repeat(alike[number], len(own)))
            crossing += crosses
    if crossing:
        note(f"{where}: {crossing} of its polygons cross themselves, and their triangles may overlap")
    found = np.concatenate(polygons)
    order = np.argsort(found, kind="stable")
    return np.concatenate(triangles)[order], found[order]


def _covered(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Normals of polygons (P, N, 3) as long as twice their areas, and which the fans of their first corners cover."""
    spokes = corners - corners[:, :1]
    doubled = np.cross(spokes[:, 1:-1], spokes[:, 2:])
    normals = doubled.sum(axis=1)
    along = np.einsum("pti,pi->pt", doubled, normals)
    sizes = np.linalg.norm(doubled, axis=2).sum(axis=1)
    flat = np.einsum("pi,pi->p", normals, normals)
    # A polygon of no area has no side from which to look; where its triangles have one, it crosses itself.
    unseen = (flat <= (SLACK * sizes) ** 2) & (sizes > 0.0)
    return normals, (along >= -SLACK * flat[:, None]).all(axis=1) & ~unseen


def _cut(corners: np.ndarray, normal: np.ndarray) -> tuple[np.ndarray, bool]:
    """The triangles of one polygon (N, 3) that has a normal, and whether it crosses itself."""
    count = len(corners)
    length = float(np.linalg.norm(normal))
    fan = np.stack(np.broadcast_arrays(0, np.arange(1, count - 1), np.arange(2, count)), axis=1)
    if not length > 0.0:
        return fan, True
    flat = np.einsum("ni,ki->nk", corners - corners[0], np.array(across(tuple_of(normal / length))))
    cut = mapbox_earcut.triangulate_float64(flat, np.array([count], np.uint32)).reshape(-1, 3).astype(np.int64)
    if not len(cut):
        return fan, True
    area = np.abs(_area(flat[None])).sum()
    crosses = abs(np.abs(_area(flat[cut])).sum() - area) > CROSSING * area
    return cut, bool(crosses)


def _area(polygons: np.ndarray) -> np.ndarray:
    """Twice the areas of polygons (P, N, 2): what is wound clockwise is negative."""
    following = np.roll(polygons, -1, axis=1)
    return (polygons[..., 0] * following[..., 1] - polygons[..., 1] * following[..., 0]).sum(axis=1)
