"""What is drawn over a picture, as arrays: line segments and dots in the world."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike


@dataclass(frozen=True, eq=False)
class Segments:
    """Straight lines.

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
class Dots:
    """Discs that face whoever looks.

    Parameters
    ----------
    centers : (N, 3) float32
        World points, metres.
    colors : (N, 4) float32
        Linear, with alpha.
    radii : (N,) float32
        Logical pixels.
    """

    centers: np.ndarray
    colors: np.ndarray
    radii: np.ndarray


@dataclass(frozen=True, eq=False)
class Marks:
    """Segments, and dots over them; what comes later covers what comes first."""

    segments: Segments
    dots: Dots


def line_marks(ends: ArrayLike, color: ArrayLike, width: ArrayLike = 1.0) -> Marks:
    """Segments, (N, 2, 3), of one colour and width, or of one for each."""
    lines = np.asarray(ends, np.float32).reshape(-1, 2, 3)
    return Marks(Segments(lines, _each(color, (len(lines), 4)), _each(width, (len(lines),))), _NO_DOTS)


def dot_marks(centers: ArrayLike, color: ArrayLike, radius: ArrayLike) -> Marks:
    """Dots, (N, 3), of one colour and radius, or of one for each."""
    points = np.asarray(centers, np.float32).reshape(-1, 3)
    return Marks(_NO_SEGMENTS, Dots(points, _each(color, (len(points), 4)), _each(radius, (len(points),))))


def joined(parts: Sequence[Marks]) -> Marks:
    """All marks as one, in their order."""
    parts = (NO_MARKS, *parts)
    segments, dots = [part.segments for part in parts], [part.dots for part in parts]
    return Marks(
        Segments(
            *(np.concatenate([getattr(each, name) for each in segments]) for name in ("ends", "colors", "widths"))
        ),
        Dots(*(np.concatenate([getattr(each, name) for each in dots]) for name in ("centers", "colors", "radii"))),
    )


def between(starts: ArrayLike, stops: ArrayLike) -> np.ndarray:
    """The ends, (N, 2, 3), of segments from `starts` to `stops`, (N, 3) each or one point for all."""
    return np.stack(np.broadcast_arrays(np.atleast_2d(starts), np.atleast_2d(stops)), axis=1)


def _each(value: ArrayLike, shape: tuple[int, ...]) -> np.ndarray:
    return np.ascontiguousarray(np.broadcast_to(np.asarray(value, np.float32), shape))


_NO_SEGMENTS = Segments(*(np.zeros(shape, np.float32) for shape in ((0, 2, 3), (0, 4), (0,))))
_NO_DOTS = Dots(*(np.zeros(shape, np.float32) for shape in ((0, 3), (0, 4), (0,))))
NO_MARKS = Marks(_NO_SEGMENTS, _NO_DOTS)
