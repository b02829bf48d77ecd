"""What is drawn over an image, as arrays: line segments and dots in the world."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike


@dataclass(frozen=True, eq=False)
class Strokes:
    """Straight lines; one without length is a disc that faces whoever looks.

    Parameters
    ----------
    ends : (N, 2, 3) float32
        World points, metres.
    colors : (N, 4) float32
        Linear, with alpha.
    widths : (N,) float32
        Logical pixels.
    """

    ends: np.ndarray
    colors: np.ndarray
    widths: np.ndarray


@dataclass(frozen=True, eq=False)
class Marks:
    """Segments, and dots over them; what comes later covers what comes first."""

    segments: Strokes
    dots: Strokes


def line_marks(ends: ArrayLike, color: ArrayLike, width: ArrayLike = 1.0) -> Marks:
    """Segments, (N, 2, 3), of one colour and width, or of one for each."""
    return Marks(_strokes(ends, color, width), _NOTHING)


def dot_marks(centers: ArrayLike, color: ArrayLike, radius: ArrayLike) -> Marks:
    """Dots, (N, 3), of one colour and radius, or of one for each."""
    points = np.reshape(centers, (-1, 3))
    return Marks(_NOTHING, _strokes(between(points, points), color, np.multiply(radius, 2.0)))


def joined(parts: Sequence[Marks]) -> Marks:
    """All marks as one, in their order."""
    return Marks(joined_strokes([part.segments for part in parts]), joined_strokes([part.dots for part in parts]))


def joined_strokes(parts: Sequence[Strokes]) -> Strokes:
    """All strokes as one, in their order."""
    return Strokes(*map(np.concatenate, zip(*(vars(part).values() for part in (_NOTHING, *parts)), strict=True)))


def between(starts: ArrayLike, stops: ArrayLike) -> np.ndarray:
    """The ends, (N, 2, 3), of segments from `starts` to `stops`, (N, 3) each or one point for all."""
    return np.stack(np.broadcast_arrays(np.atleast_2d(starts), np.atleast_2d(stops)), axis=1)


def _strokes(ends: ArrayLike, colors: ArrayLike, widths: ArrayLike) -> Strokes:
    lines = np.asarray(ends, np.float32).reshape(-1, 2, 3)
    return Strokes(lines, _each(colors, (len(lines), 4)), _each(widths, (len(lines),)))


def _each(value: ArrayLike, shape: tuple[int, ...]) -> np.ndarray:
    return np.ascontiguousarray(np.broadcast_to(np.asarray(value, np.float32), shape))


_NOTHING = _strokes([], (0.0, 0.0, 0.0, 0.0), 0.0)
NO_MARKS = Marks(_NOTHING, _NOTHING)
