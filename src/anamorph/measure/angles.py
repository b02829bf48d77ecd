"""How far a seen point is from the true one: as an angle at the specular surface, and in pixels of the image.

Both are computed from the last ray of the reference, in float64. Rays are S + t d: S on the specular surface, d unit.
The compiled functions take one ray, so that other compiled loops can use them.
"""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import compiled
from anamorph.base.vectors import Vector, along, cross, dot

RESOLUTION = 4.0 * float(np.finfo(np.float32).eps)
"""What the float32 buffers of a frame resolve, relative to the size of their coordinates."""


def normalized(vectors: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) made unit; zero stays zero."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0.0)


def angles_between(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Angles between vectors (N, 3), radians, exact for small ones; pi where either vector is zero.

    A point at the specular surface itself thus counts as the worst answer, not as the best.
    """
    sine, cosine = np.linalg.norm(np.cross(first, second), axis=-1), np.sum(np.multiply(first, second), axis=-1)
    return np.where((sine == 0.0) & (cosine == 0.0), np.pi, np.arctan2(sine, cosine))


def image_distances(
    origins: np.ndarray,
    directions: np.ndarray,
    toward: np.ndarray,
    distances: np.ndarray,
    footprints: np.ndarray,
    limit: float,
) -> np.ndarray:
    """How far one must move in the image for the reference to see another point: `image_distance` of N rays.

    Parameters
    ----------
    origins, directions : (N, 3)
        S and d of the reference.
    toward : (N, 3)
        Unit vectors from S to the seen point.
    distances : (N,)
        The seen point's t along the ray; infinite if only its direction counts.
    footprints : (N, 3, 2)
        How the point at the same distances moves when one moves by one pixel, right and down.
    limit : float

    Returns
    -------
    (N,) float64
    """
    vectors = (origins, directions, toward, *np.moveaxis(footprints, 2, 0))
    first, second, third, right, down = (map(tuple, np.asarray(array, float).tolist()) for array in vectors)
    rays = zip(first, second, third, distances.tolist(), right, down, strict=True)
    return np.array([image_distance(*ray, limit) for ray in rays], float)


@compiled
def length(a: Vector) -> float:
    """Of a tuple of three."""
    return math.sqrt(dot(a, a))


@compiled
def unit_or_zero(a: Vector) -> Vector:
    """A tuple of three at length one; zero stays zero."""
    size = length(a)
    return (a[0] / size, a[1] / size, a[2] / size) if size > 0.0 else (0.0, 0.0, 0.0)


@compiled
def angle_between(first: Vector, second: Vector) -> float:
    """The angle between two vectors, radians. See `angles_between`."""
    sine, cosine = length(cross(first, second)), dot(first, second)
    return math.pi if sine == 0.0 and cosine == 0.0 else math.atan2(sine, cosine)


@compiled
def image_distance(
    origin: Vector,
    direction: Vector,
    toward: Vector,
    distance: float,
    rightwards: Vector,
    downwards: Vector,
    limit: float,
) -> float:
    """How far one must move in the image for the reference to see another point, to first order, pixels.

    Solves, in the plane perpendicular to d, footprint (dx, dy) = offset, where the offset is that of the seen point
    from the reference's ray. Where the footprint is singular (a caustic: moving the pixel moves nothing) its singular
    values are raised to what float32 resolves, so the answer is large but defined.

    Parameters
    ----------
    origin, direction : three floats
        S and d of the reference.
    toward : three floats
        Unit vector from S to the seen point.
    distance : float
        The seen point's t along the ray, metres; infinite if only its direction counts.
    rightwards, downwards : three floats
        How the point at that distance moves when one moves by one pixel, metres (or radians).
    limit : float
        Answers beyond it (the image's diagonal) are cut to it: the first order says nothing that far away.
    """
    cosine = dot(direction, toward)
    across = along(toward, -cosine, direction)
    sine = length(across)
    if sine == 0.0:
        return limit if cosine <= 0.0 else 0.0
    # tan(angle) t metres away from the ray, or the angle itself where only directions count
    infinite = math.isinf(distance)
    per_sine = angle_between(direction, toward) / sine if infinite else distance / cosine
    # Two rows of a linear system, in a basis of the plane.
    first, second = _perpendicular(direction)
    a, b = dot(first, rightwards), dot(first, downwards)
    c, d = dot(second, rightwards), dot(second, downwards)
    u, v = per_sine * dot(first, across), per_sine * dot(second, across)
    # Turned until they are perpendicular to each other, their lengths are the singular values (Jacobi 1846).
    longer, shorter = a * a + b * b, c * c + d * d
    if longer < shorter:
        a, b, u, c, d, v = c, d, v, a, b, u
        longer, shorter = shorter, longer
    product = a * c + b * d
    spread = math.hypot(longer - shorter, 2.0 * product)
    if spread > 0.0:
        turned = math.sqrt(0.5 + 0.5 * (longer - shorter) / spread)
        aside = product / (spread * turned)
        a, b, u, c, d, v = (
            turned * a + aside * c, turned * b + aside * d, turned * u + aside * v,
            turned * c - aside * a, turned * d - aside * b, turned * v - aside * u,
        )  # fmt: skip
    size = 1.0 if infinite else max(abs(origin[0]), abs(origin[1]), abs(origin[2])) + distance
    resolved = RESOLUTION * size
    pixels = math.hypot(u / max(math.hypot(a, b), resolved), v / max(math.hypot(c, d), resolved))
    return pixels if pixels < limit else limit


@compiled
def _perpendicular(direction: Vector) -> tuple[Vector, Vector]:
    """Two unit vectors perpendicular to a unit vector and to each other."""
    x, y, z = abs(direction[0]), abs(direction[1]), abs(direction[2])
    if x <= y and x <= z:
        first = unit_or_zero((0.0, direction[2], -direction[1]))
    elif y <= z:
        first = unit_or_zero((-direction[2], 0.0, direction[0]))
    else:
        first = unit_or_zero((direction[1], -direction[0], 0.0))
    return first, cross(direction, first)
