"""The errors of a frame once more, in plain numpy: an image at a time, and singular values by LAPACK."""

from __future__ import annotations

import numpy as np

from anamorph.frame import Frame
from anamorph.measure.angles import RESOLUTION, normalized


def seen_directions(origins: np.ndarray, positions: np.ndarray, object_ids: np.ndarray) -> np.ndarray:
    """Directions in which seen points lie, as seen from S.

    Parameters
    ----------
    origins : (N, 3)
        S, metres.
    positions : (N, 3)
        World points, metres; unit directions where `object_ids` is 0.
    object_ids : (N,)

    Returns
    -------
    (N, 3) float64
        Unit vectors; zero for a point at S itself, which lies in no direction.
    """
    positions = np.asarray(positions, float)
    toward = np.where((object_ids == 0)[:, None], positions, positions - origins)
    return normalized(toward)


def errors_of(reference: Frame, frame: Frame, specular: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angular errors in milliradians and errors in pixels, (H, W) each, of the pixels that count."""
    through = np.where(specular, reference.specular.astype(np.int64), -1)
    origin, direction = reference.ray_origin.astype(float), normalized(reference.ray_direction.astype(float))
    position, object_id = frame.position[specular], frame.object_id[specular]
    toward = seen_directions(origin[specular], position, object_id)
    angular, pixels = np.zeros((2, *specular.shape))
    angular[specular] = 1000.0 * _angles(direction[specular], toward)
    along = np.einsum("ij,ij->i", position - origin[specular], direction[specular])
    distances = np.full(specular.shape, np.inf)
    distances[specular] = np.where((object_id == 0) | (along <= 0.0), np.inf, along)
    footprints = _footprints(origin, direction, through, distances)[specular]
    limit = float(np.linalg.norm(specular.shape))
    pixels[specular] = _image_distances(
        origin[specular], direction[specular], toward, distances[specular], footprints, limit
    )
    return angular, pixels


def _angles(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Angles between vectors (N, 3), radians, exact for small ones; pi where either vector is zero."""
    sine = np.linalg.norm(np.cross(first, second), axis=1)
    cosine = np.einsum("ij,ij->i", first, second)
    return np.where((sine == 0.0) & (cosine == 0.0), np.pi, np.arctan2(sine, cosine))


def _footprints(origins: np.ndarray, directions: np.ndarray, surface: np.ndarray, distances: np.ndarray) -> np.ndarray:
    """How the point at a distance along each pixel's last ray moves when one moves by one pixel in the image."""
    infinite = ~np.isfinite(distances)
    weight = np.where(infinite, 1.0, distances)[..., None]
    footprints = np.zeros((*surface.shape, 3, 2))
    for column, axis in ((0, 1), (1, 0)):
        sides = []
        for ahead in (True, False):
            here, there = _neighbours(axis, ahead)
            sign = 1.0 if ahead else -1.0
            step = np.zeros(origins.shape)
            step[here] = sign * (weight[here] * (directions[there] - directions[here]))
            step[here] += sign * np.where(infinite[here][..., None], 0.0, origins[there] - origins[here])
            exists = np.zeros(surface.shape, bool)
            exists[here] = surface[there] == surface[here]
            sides.append((step, exists, np.where(exists, np.linalg.norm(step, axis=-1), np.inf)))
        (ahead_step, has_ahead, ahead_size), (behind_step, has_behind, behind_size) = sides
        smaller = np.where((ahead_size <= behind_size)[..., None], ahead_step, behind_step)
        smaller[~(has_ahead | has_behind)] = 0.0
        alike = has_ahead & has_behind
        alike &= np.maximum(ahead_size, behind_size) <= 2.0 * np.minimum(ahead_size, behind_size)
        footprints[..., column] = np.where(alike[..., None], 0.5 * (ahead_step + behind_step), smaller)
    return footprints


def _neighbours(axis: int, ahead: bool) -> tuple[tuple[slice, slice], tuple[slice, slice]]:
    """Index of all pixels that have a neighbour one step along an axis of the array, and index of the neighbours."""
    first, second = slice(None, -1), slice(1, None)
    here, there = (first, second) if ahead else (second, first)
    return ((here, slice(None)), (there, slice(None))) if axis == 0 else ((slice(None), here), (slice(None), there))


def _image_distances(
    origins: np.ndarray,
    directions: np.ndarray,
    toward: np.ndarray,
    distances: np.ndarray,
    footprints: np.ndarray,
    limit: float,
) -> np.ndarray:
    """How far one must move in the image for the truth to see another point, to first order, pixels."""
    along = np.einsum("ij,ij->i", directions, toward)
    across = toward - along[:, None] * directions
    sine = np.linalg.norm(across, axis=1)
    at_infinity = ~np.isfinite(distances)
    distances = np.where(at_infinity, 0.0, distances)
    # tan(angle) t metres away from the ray, or the angle itself where only directions count
    per_sine = np.divide(distances, along, out=np.zeros_like(along), where=~at_infinity)
    angle = _angles(directions, toward)
    np.divide(angle, sine, out=per_sine, where=at_infinity & (sine > 0.0))
    basis = _perpendicular(directions)
    offset = np.einsum("nij,nj->ni", basis, per_sine[:, None] * across)
    left, singular, right = np.linalg.svd(basis @ footprints)
    coordinates = np.where(at_infinity, 1.0, np.abs(origins).max(axis=1, initial=0.0) + distances)
    singular = np.maximum(singular, RESOLUTION * coordinates[:, None])
    moved = np.einsum("nji,nj->ni", left, offset) / singular
    pixels = np.linalg.norm(np.einsum("nji,nj->ni", right, moved), axis=1)
    opposite = (sine == 0.0) & (along <= 0.0)
    return np.where(opposite, limit, np.minimum(pixels, limit))


def _perpendicular(directions: np.ndarray) -> np.ndarray:
    """Two unit vectors perpendicular to each unit vector (N, 3) and to each other: (N, 2, 3)."""
    helper = np.eye(3)[np.abs(directions).argmin(axis=1)]
    first = np.cross(directions, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(directions, first)], axis=1)
