"""The rays of a patch that are seen: of a triangle that reaches out of the image, those at the corners of what is left.

A flat mirror may be two triangles, of which little is in the image. Its map must hold what is seen, as finely as that
needs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.raymesh import RayMesh, RayStatus

AROUND = 2.0
"""Pixels by which what is kept reaches out of the image."""

LEAST_DEPTH = 1e-4
"""Of the greatest in a triangle: what is nearer to the plane of the eye is cut away."""


@dataclass(frozen=True, eq=False)
class VisibleRays:
    """A patch's rays, on triangles of their own.

    Parameters
    ----------
    rays : RayMesh
    corners : (V, 3) int
        The vertices of the body's ray mesh between which each is interpolated.
    weights : (V, 3) float64
        How much of each.
    parent : (F,) int
        Which face of the patch each triangle is a part of.
    """

    rays: RayMesh
    corners: np.ndarray
    weights: np.ndarray
    parent: np.ndarray

    def blended(self, values: np.ndarray) -> np.ndarray:
        """Vectors (N, K) of the body's vertices, at these: (V, K)."""
        return np.einsum("vc,vck->vk", self.weights, values[self.corners])

    def least(self, values: np.ndarray) -> np.ndarray:
        """Numbers (N,) of the body's vertices: the least around each of these, (V,)."""
        return np.where(self.weights > 0.0, values[self.corners], np.inf).min(axis=1)


def visible_rays(rays: RayMesh, faces: np.ndarray, size: tuple[int, int]) -> VisibleRays:
    """Those of the patch of `faces` (F,) that an image of `size` (width, height) shows, or that lie close beside it."""
    triangles = rays.faces[faces]
    heights = _heights(rays.image, size)
    inside = np.all(heights >= 0.0, axis=1)
    inside = np.asarray(inside)[triangles].all(axis=1)
    vertices, local = np.unique(triangles[inside], return_inverse=True)
    corners = [np.repeat(vertices[:, None], 3, axis=1)]
    weights = [np.tile([1.0, 0.0, 0.0], (len(vertices), 1))]
    kept = [local.reshape(-1, 3)]
    parent = [np.flatnonzero(inside)]
    count = len(vertices)
    for number in np.flatnonzero(~inside):
        polygon = _cut(heights[triangles[number]])
        if len(polygon) < 3:
            continue
        corners.append(np.repeat(triangles[number][None], len(polygon), axis=0))
        weights.append(polygon)
        fan = np.arange(1, len(polygon) - 1)
        kept.append(count + np.stack([np.zeros_like(fan), fan, fan + 1], axis=1))
        parent.append(np.full(len(fan), number))
        count += len(polygon)
    corner, weight = np.concatenate(corners), np.concatenate(weights)
    image, origins, directions = (
        np.einsum("vc,vck->vk", weight, values[corner]) for values in (rays.image, rays.origins, rays.directions)
    )
    worst = np.where(weight > 0.0, rays.status[corner], RayStatus.OK).max(axis=1).astype(np.uint8)
    seen = RayMesh(image, origins, directions, np.concatenate(kept).astype(np.int32), worst)
    return VisibleRays(seen, corner, weight, np.concatenate(parent))


def _heights(image: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """How far homogeneous image points (V, 3) are inside each border of the image, and before the eye: (V, 5)."""
    x, y, w = image.T
    margin = AROUND * w
    least = LEAST_DEPTH * np.abs(w).max(initial=0.0)
    return np.stack([w - least, x + margin, size[0] * w + margin - x, y + margin, size[1] * w + margin - y], axis=1)


def _cut(heights: np.ndarray) -> np.ndarray:
    """The part of a triangle where all heights, (3, 5) at its corners, are positive: a polygon's weights, (N, 3)."""
    polygon = np.eye(3)
    for plane in heights.T:
        height = polygon @ plane
        corners = []
        for here, there, up, next_up in zip(
            polygon, np.roll(polygon, -1, axis=0), height, np.roll(height, -1), strict=True
        ):
            if up >= 0.0:
                corners.append(here)
            if (up >= 0.0) != (next_up >= 0.0):
                corners.append(here + up / (up - next_up) * (there - here))
        if not corners:
            return np.zeros((0, 3))
        polygon = np.array(corners)
    return polygon
