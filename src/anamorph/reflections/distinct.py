"""From many starts to what is found from them, each once; and from there to its twins."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from anamorph.base.compiled import compiled
from anamorph.reflections.stationary import ORDER

SAME = 1e-6
"""Places nearer to each other than this share of the mirror's size are one."""

TWINS = 4
"""How often the twins of new places are searched for."""

Settled = Callable[[np.ndarray, np.ndarray, np.ndarray, bool], tuple[np.ndarray, np.ndarray, np.ndarray]]
"""Searches from some starts: of which points (S,), in which pieces (S,), at which places (S, K), and whether only where
two places may be about to merge. Of those that lead to something it returns the rows, whose last K numbers are the
place of a twin or NaN; the triangles there (F, T); and the numbers of the starts (F,)."""


def distinct(
    settled: Settled, point: np.ndarray, piece: np.ndarray, places: np.ndarray, size: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Search from starts, and from the twins of what is found.

    Parameters
    ----------
    settled : Settled
    point, piece : (S,) int64
    places : (S, K) float64
    size : float
        Of the mirror, metres.

    Returns
    -------
    point : (M,) int64
        Ascending.
    triangles : (M, T) int64
    rows : (M, W) float64
    """
    words, kept, rows = places.shape[1], np.zeros((0, 3), np.int64), np.zeros((0, 0))
    for turn in range(1 + TWINS):
        new, triangles, found = settled(point, piece, places, False)
        own = np.column_stack([point[found], piece[found], triangles])
        if not turn:
            rest = np.delete(np.arange(len(point)), found)
            more, there, again = settled(point[rest], piece[rest], places[rest], True)
            again = rest[again]
            own = np.concatenate([own, np.column_stack([point[again], piece[again], there])])
            new = np.concatenate([new, more])
        fresh = np.arange(len(kept) + len(own)) >= len(kept)
        kept, rows = (np.concatenate([kept, own]), np.concatenate([rows, new])) if turn else (own, new)
        order = np.argsort(kept[:, 0], kind="stable")
        kept, rows, fresh = kept[order], rows[order], fresh[order]
        keep = np.ones(len(kept), bool)
        _merge(kept[:, 0].copy(), rows, SAME * size, keep)
        kept, rows, fresh = kept[keep], rows[keep], fresh[keep]
        twins = fresh & ~np.isnan(rows[:, -1])
        point, piece, places = kept[twins, 0], kept[twins, 1], rows[twins, -words:].copy()
        if not len(point):
            break
    return kept[:, 0], kept[:, 2:], rows


@compiled
def _merge(point: np.ndarray, rows: np.ndarray, close: float, keep: np.ndarray) -> None:
    """Unmark what is the same as an earlier row of its point; all that are a focus are one."""
    for i in range(len(point)):
        j = i - 1
        while j >= 0 and point[j] == point[i] and keep[i]:
            if keep[j]:
                one, other = rows[i, ORDER], rows[j, ORDER]
                x, y, z = rows[i, 0] - rows[j, 0], rows[i, 1] - rows[j, 1], rows[i, 2] - rows[j, 2]
                same = x * x + y * y + z * z <= close * close and one * other >= 0.0
                keep[i] = not (same or (one == 0.0 and other == 0.0))
            j -= 1
