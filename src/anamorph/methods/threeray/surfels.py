"""The reflected geometry as surfels: pieces of triangles, each with a centre, a covariance and its triangle's number.

A surfel with the centre c and the covariance S lies between c - s and c + s along a vector n, where s = sqrt(n' S n) is
its support. Of a piece with the corners c + v_i the covariance is 2/3 of the sum of v_i v_i': the ellipse through the
three corners. Clouds of points and Gaussians have the same support, by covariances of their own.

Source: Mei, Popescu and Sacks 2007, sections 3.1 and 6, where the samples are points. Deviation: a sample knows how far
it reaches, so that it can be bounded, and from which triangle it came, so that a ray meets it exactly.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from anamorph.base.errors import AnamorphError

MOST = 2**23
"""Surfels that a scene may have: more would take gigabytes."""

KAPPA = 1.0
"""The radius of a surfel as a share of its distance to the mirrors: what is near them is magnified most."""

LARGEST_SHARE = 1.3
"""No triangle has an area of more than this times the square of its corners' distance from its centre."""

MEAN_SHARE = 0.4
"""What the area of a surfel is in the mean, as such a share, where all have one radius."""

Limit = Callable[[np.ndarray], np.ndarray]
"""The radius (N,) that surfels at centres (N, 3) may have."""


@dataclass(frozen=True, eq=False)
class Surfels:
    """Pieces of triangles, N of them.

    Parameters
    ----------
    center : (N, 3) float64
        Metres.
    covariance : (N, 6) float64
        Its xx, yy, zz, xy, xz and yz, square metres.
    triangle : (N,) int32
        Which triangle each is a piece of.
    weights : (N, 3, 3) float64
        The piece's corners (rows) as weights of the triangle's corners.
    """

    center: np.ndarray
    covariance: np.ndarray
    triangle: np.ndarray
    weights: np.ndarray

    def __len__(self) -> int:
        return len(self.triangle)

    def half_extents(self) -> np.ndarray:
        """The supports along the axes, (N, 3): half the sides of the boxes around them."""
        return np.sqrt(self.covariance[:, :3])

    def chosen(self, numbers: np.ndarray) -> Surfels:
        """Some of them, in another order."""
        return Surfels(*(getattr(self, name)[numbers] for name in ("center", "covariance", "triangle", "weights")))

    def moved(self, corners: np.ndarray) -> Surfels:
        """The same pieces of triangles that have moved to `corners` (F, 3, 3)."""
        center, covariance = _shapes(self.weights @ corners[self.triangle])
        return replace(self, center=center, covariance=covariance)


def sample(corners: np.ndarray, limit: Limit) -> Surfels:
    """Bisect triangles at their longest edges until each piece is as small as it has to be.

    Parameters
    ----------
    corners : (F, 3, 3) float64
        Triangles. Those without an area are left out: no ray meets them.
    limit : callable
        See `Limit`.

    Raises
    ------
    AnamorphError
        There would be more than `MOST` surfels.
    """
    a, b, c = np.moveaxis(corners, 1, 0)
    triangle = np.flatnonzero(np.cross(b - a, c - a).any(axis=1)).astype(np.int32)
    weights = np.broadcast_to(np.eye(3), (len(triangle), 3, 3))
    done_weights, done_triangles, count = [weights[:0]], [triangle[:0]], 0
    while len(triangle):
        places = weights @ corners[triangle]
        center = places.mean(axis=1)
        wide = np.linalg.norm(places - center[:, None], axis=2).max(axis=1) > limit(center)
        done_weights.append(weights[~wide])
        done_triangles.append(triangle[~wide])
        count += len(triangle)
        if wide.any() and count + np.count_nonzero(wide) > MOST:
            raise AnamorphError(
                f"threeray: the scene makes more than {MOST} surfels; give spacing=METRES, or a larger one"
            )
        count -= int(np.count_nonzero(wide))
        weights = _bisected(weights[wide], places[wide])
        triangle = np.repeat(triangle[wide], 2)
    all_weights, all_triangles = np.concatenate(done_weights), np.concatenate(done_triangles)
    return Surfels(*_shapes(all_weights @ corners[all_triangles]), all_triangles, all_weights)


def evenly(corners: np.ndarray, spacing: float) -> Limit:
    """One radius everywhere, metres, if triangles (F, 3, 3) do not make too many surfels of it."""
    area = _area(corners)
    if area > LARGEST_SHARE * MOST * spacing**2:
        least = float(np.sqrt(area / (LARGEST_SHARE * MOST)))
        raise AnamorphError(
            f"threeray: spacing {spacing:g} makes more than {MOST} surfels; give at least {2.0 * least:.2g} metres"
        )
    return lambda center: np.full(len(center), spacing)


def about(corners: np.ndarray, count: int) -> Limit:
    """One radius everywhere, of which triangles (F, 3, 3) make about so many surfels, or more if they are more."""
    spacing = float(np.sqrt(_area(corners) / (MEAN_SHARE * count)))
    return lambda center: np.full(len(center), spacing)


def magnified(mirrors: np.ndarray, floor: float) -> Limit:
    """A radius that grows with the distance to the mirrors.

    Parameters
    ----------
    mirrors : (V, 3) float64
        Points on the mirrors and lenses: where rays start.
    floor : float
        Metres: what is nearer than this is not bisected any further.
    """
    tree = cKDTree(mirrors)
    return lambda center: KAPPA * np.maximum(tree.query(center)[0], floor)


def _area(corners: np.ndarray) -> float:
    a, b, c = np.moveaxis(corners, 1, 0)
    return 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def _bisected(weights: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Two pieces (2 N, 3, 3) of each (N, 3, 3), whose corners are at `places`."""
    lengths = np.linalg.norm(places - np.roll(places, -1, axis=1), axis=2)
    turn = (lengths.argmax(axis=1)[:, None] + np.arange(3)) % 3
    first, second, apex = np.moveaxis(np.take_along_axis(weights, turn[..., None], axis=1), 1, 0)
    middle = 0.5 * (first + second)
    halves = np.stack([first, middle, apex], axis=1), np.stack([middle, second, apex], axis=1)
    return np.stack(halves, axis=1).reshape(-1, 3, 3)


def _shapes(places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centres (N, 3) and covariances (N, 6) of pieces with these corners (N, 3, 3)."""
    center = places.mean(axis=1)
    around = places - center[:, None]
    first, second = [0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]
    return center, 2.0 / 3.0 * np.einsum("nik,nik->nk", around[..., first], around[..., second])
