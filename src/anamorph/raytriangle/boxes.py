"""Which boxes a ray triangle may see into, so that not every scene triangle has to be projected by every ray triangle.

Source: Vallance 2005, section 3.7, which has a test of points only. The rays from t = near on stay within the convex
hull of where they start, swept along all three directions. Where that hull lies wholly on one side of a plane and a box
on the other, no ray meets the box. The planes tried are those along the faces that such a hull can have, and those of a
box.

The volume itself caves in between its curved sides and, beyond where rays cross, folded. The hull knows nothing of
that: a box may pass that no ray meets, never the other way round. In float32, with planes made in float64 and their
distances lowered by 1e-6 of the scene's size, that still holds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.raytriangle.scaled import checked

SLACK = 1e-12
"""By how much more than it must a plane is moved off the hull, as a share of what its distance is computed from."""

OPPOSED = 0.01
"""Less than this of any unit direction along the middle one: rays between them may be much shorter than they are."""


@dataclass(frozen=True, eq=False)
class BoundingPlanes:
    """Planes before which nothing is seen: a point is seen only if normals . point >= distances - slack, for all.

    Parameters
    ----------
    normals : (..., N, 3) float64
        Unit vectors; 0 for a plane that does not bound the ray triangle. 32 for a ray triangle.
    distances : (..., N) float64
    slack : (..., N) float64
        What rounding may have done to the distances.
    """

    normals: np.ndarray
    distances: np.ndarray
    slack: np.ndarray

    def may_see(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Whether a ray may meet each box.

        Parameters
        ----------
        low, high : (B, 3) array
            Least and greatest corner of each box. A box may be a point.

        Returns
        -------
        (..., B) bool
            False only for boxes in which no point is seen.
        """
        low, high = np.asarray(low, float), np.asarray(high, float)
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        across = np.einsum("...pi,bi->...pb", np.abs(self.normals), half)
        nearest = np.einsum("...pi,bi->...pb", self.normals, middle) + across
        slack = self.slack[..., None] + SLACK * (np.linalg.norm(middle, axis=1) + across)
        return (nearest >= self.distances[..., None] - slack).all(axis=-2)


def bounding_planes(origins: np.ndarray, directions: np.ndarray, near: float = 0.0) -> BoundingPlanes:
    """The planes of ray triangles, for rays from t = near on without end.

    Parameters
    ----------
    origins, directions : (..., 3, 3) array
        A row for each of the three rays.
    near : float
        Where the rays start.

    Raises
    ------
    AnamorphError
        If a number is not finite, or all directions of a ray triangle are 0.
    """
    origins, directions = checked(origins, directions)
    return _planes(origins + near * directions, _units(directions))


def _units(directions: np.ndarray) -> np.ndarray:
    return directions / np.maximum(np.linalg.norm(directions, axis=-1, keepdims=True), np.finfo(float).tiny)


def _planes(origins: np.ndarray, along: np.ndarray) -> BoundingPlanes:
    """The planes of rays (..., 3, 3) from their origins along unit vectors."""
    sides = np.roll(origins, -1, axis=-2) - origins
    candidates = np.concatenate(
        [
            np.cross(along, np.roll(along, -1, axis=-2)),
            *(np.cross(sides, np.roll(along, k, axis=-2)) for k in (0, 1, -1)),
            np.cross(sides[..., :1, :], sides[..., 1:2, :]),
            np.broadcast_to(np.eye(3), (*sides.shape[:-2], 3, 3)),
        ],
        axis=-2,
    )
    lengths = np.linalg.norm(candidates, axis=-1, keepdims=True)
    normals = candidates / np.where(lengths > 0.0, lengths, 1.0)
    normals = np.concatenate([normals, -normals], axis=-2)
    # Of a product of small matrices numpy takes least time to find the least along rows.
    ahead = (along @ normals.swapaxes(-1, -2)).min(axis=-2)
    # Running against a plane by a rounding error leads past it by less than the slack, unless opposed directions leave
    # so short a ray between them that t grows out of proportion to the way.
    middle = along.mean(axis=-2, keepdims=True)
    opposed = np.sum(along * middle, axis=-1).min(axis=-1) < OPPOSED
    rounding = 4.0 * np.finfo(float).eps
    normals = np.where((ahead >= np.where(opposed, rounding, -rounding)[..., None])[..., None], normals, 0.0)
    distances = (origins @ normals.swapaxes(-1, -2)).min(axis=-2)
    reach = np.linalg.norm(origins, axis=-1).max(axis=-1)
    return BoundingPlanes(normals, distances, np.broadcast_to(SLACK * reach[..., None], distances.shape))
