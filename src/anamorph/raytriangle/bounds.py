"""What a three-ray camera can see of a box or a surfel, bounded linearly, and what it cannot see at all. Compiled.

What is bounded has a middle and a support: how far it reaches along a vector. Over its range of t, each weight w_i of
the rays that meet it is compared with a linear function of the place, L(x) = g . x with any g. The difference w_i - L
is linear in t for each ray and linear in the weights for each t, so that it is least and greatest at one of the three
corners at one of the two ends of the range. With g = g_i in the middle of the range, the differences are small. So
nothing is missed, also where rays cross and a point is seen more than once, and no root is looked for.

Source: it stands in place of the test of side walls of Mei, Popescu and Sacks 2007, section 5.2.
"""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import compiled, inlined, over_all_cores
from anamorph.base.vectors import Vector, along, dot
from anamorph.raytriangle.camera_frames import SINGULAR, Frames, vector

GRAIN = 1024

PAD = 1e-9
"""What bounds are widened by: weights by this, and reaches by this share."""

ROUNDING = 1e-12
"""And by this share of what they are computed from."""

Shape = tuple[float, float, float, float, float, float]
"""A box's half sides and three zeros, or a covariance: see `support`."""

Range = tuple[float, float]


@inlined
def support(shape: Shape, box: bool, a: Vector) -> float:
    """How far a box or a surfel reaches from its middle along a vector, in the vector's lengths."""
    if box:
        return (1.0 + PAD) * (abs(a[0]) * shape[0] + abs(a[1]) * shape[1] + abs(a[2]) * shape[2])
    square = a[0] * a[0] * shape[0] + a[1] * a[1] * shape[1] + a[2] * a[2] * shape[2]
    mixed = a[0] * a[1] * shape[3] + a[0] * a[2] * shape[4] + a[1] * a[2] * shape[5]
    return (1.0 + PAD) * math.sqrt(max(square + 2.0 * mixed, 0.0) + ROUNDING * square)


@inlined
def size_of(frames: Frames, c: int, place: Vector) -> float:
    """How large the numbers are that bounds are computed from: a place's, and the camera's own."""
    return abs(place[0]) + abs(place[1]) + abs(place[2]) + frames.size[c]


@inlined
def before_hull(frames: Frames, c: int, place: Vector, shape: Shape, box: bool, size: float) -> bool:
    """Whether it is beyond a plane of the camera's hull; `place` is its middle, seen from the camera's origin."""
    for i in range(4):
        normal = vector(frames.planes[c, i])
        if dot(normal, place) + support(shape, box, normal) + ROUNDING * size < frames.planes[c, i, 3]:
            return True
    return False


@inlined
def range_of(frames: Frames, c: int, place: Vector, shape: Shape, box: bool, size: float) -> Range:
    """The range of t in which the camera's rays may meet it; it ends below 0 if that is behind their origins."""
    axis = vector(frames.axis[c])
    height, reach = dot(axis, place), support(shape, box, axis) + ROUNDING * size
    near, far = height - reach - frames.reach[c, 1], height + reach - frames.reach[c, 0]
    slowest, fastest = frames.reach[c, 2], frames.reach[c, 3]
    return max(near / fastest if near > 0.0 else 0.0, 0.0), far / slowest if far > 0.0 else -1.0


@inlined
def weight_range(
    frames: Frames,
    c: int,
    i: int,
    ends: Range,
    scale: float,
    place: Vector,
    shape: Shape,
    box: bool,
    size: float,
) -> Range:
    """The least and greatest weight of corner i of rays that meet it between two `ends` of t, with `scale` 1 / det."""
    middle = 0.5 * (ends[0] + ends[1])
    gradient = along(vector(frames.gradients[c, i, 0]), middle, vector(frames.gradients[c, i, 1]))
    value, reach = dot(gradient, place), support(shape, box, gradient)
    low, high = math.inf, -math.inf
    for corner in range(3):
        at_0 = frames.products[c, i, 0, corner, 0] + middle * frames.products[c, i, 1, corner, 0]
        more = frames.products[c, i, 0, corner, 1] + middle * frames.products[c, i, 1, corner, 1]
        own = 1.0 if corner == i else 0.0
        one, other = own - scale * (at_0 + ends[0] * more), own - scale * (at_0 + ends[1] * more)
        low, high = min(low, one, other), max(high, one, other)
    value, reach = scale * value, abs(scale) * reach
    pad = PAD + ROUNDING * abs(scale) * (abs(gradient[0]) + abs(gradient[1]) + abs(gradient[2])) * size
    return max(low + value - reach - pad, 0.0), min(high + value + reach + pad, 1.0)


@inlined
def inverse_determinant(frames: Frames, c: int, t: float) -> float:
    """1 / det at t, or 0 where the sweeping triangle there is a line or a point, or its plane holds the rays."""
    value = frames.determinant[c, 0] + t * (frames.determinant[c, 1] + t * frames.determinant[c, 2])
    side = frames.factors[c, 1] + abs(t) * frames.factors[c, 2]
    return 1.0 / value if abs(value) > SINGULAR * frames.factors[c, 0] * side * side else 0.0


@inlined
def seen_weights(frames: Frames, c: int, middle: Vector, shape: Shape, box: bool) -> tuple[bool, Vector, Vector]:
    """Whether camera c may see something of a box or surfel, and the least and greatest weights of the rays that do."""
    low, high = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
    place = along(middle, -1.0, vector(frames.origin[c]))
    size = size_of(frames, c, place)
    if (box or frames.reach[c, 2] <= 0.0) and before_hull(frames, c, place, shape, box, size):
        return False, low, high
    if frames.reach[c, 2] <= 0.0:
        return True, low, high
    ends = range_of(frames, c, place, shape, box, size)
    if ends[1] < 0.0:
        return False, low, high
    scale = inverse_determinant(frames, c, 0.5 * (ends[0] + ends[1]))
    if scale == 0.0:
        return True, low, high
    low_0, high_0 = weight_range(frames, c, 0, ends, scale, place, shape, box, size)
    if low_0 > high_0:
        return False, low, high
    low_1, high_1 = weight_range(frames, c, 1, ends, scale, place, shape, box, size)
    if low_1 > high_1:
        return False, low, high
    low_2, high_2 = weight_range(frames, c, 2, ends, scale, place, shape, box, size)
    return low_2 <= high_2, (low_0, low_1, low_2), (high_0, high_1, high_2)


def weights_seen(
    frames: Frames, camera: np.ndarray, middle: np.ndarray, shape: np.ndarray, box: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What `seen_weights` says of camera[n] and a box or a surfel n.

    Parameters
    ----------
    frames : Frames
    camera : (N,) int64
    middle : (N, 3) float64
        Metres.
    shape : (N, 6) float64
        See `Shape`.
    box : bool
        Whether they are boxes.

    Returns
    -------
    seen : (N,) bool
    low, high : (N, 3) float64
    """
    seen, low, high = np.zeros(len(camera), bool), np.zeros((len(camera), 3)), np.zeros((len(camera), 3))

    def work(start: int, stop: int) -> None:
        _see(frames, camera, middle, shape, box, seen, low, high, start, stop)

    over_all_cores(work, len(camera), GRAIN)
    return seen, low, high


@compiled
def _see(
    frames: Frames,
    camera: np.ndarray,
    middle: np.ndarray,
    shape: np.ndarray,
    box: bool,
    seen: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    start: int,
    stop: int,
) -> None:
    for n in range(start, stop):
        v = shape[n]
        six = (v[0], v[1], v[2], v[3], v[4], v[5])
        found, least, most = seen_weights(frames, camera[n], vector(middle[n]), six, box)
        seen[n] = found
        for i in range(3):
            low[n, i], high[n, i] = least[i], most[i]
