"""Which samples see a pair's scene triangle, where that has to be known before they are drawn. Compiled."""

from __future__ import annotations

import numpy as np

from anamorph.base.compiled import compiled, over_all_cores
from anamorph.methods.trilinear.plan import Plan
from anamorph.methods.trilinear.polygons import span
from anamorph.methods.trilinear.terms import is_inside

GRAIN = 256


def seen_samples(plan: Plan, chosen: np.ndarray, spacing: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """The samples that are inside what pairs see, without regard to what else is before it.

    Parameters
    ----------
    plan : Plan
    chosen : (S,) int array
        Rows of `plan.pair`.
    spacing : float
        Pixels between samples, as in `Beams`.

    Returns
    -------
    box : (S, 4) float64
        Least x and y, greatest x and y of such samples, in pixels from the ray triangle's center; empty without any.
    count : (S,) int64
        How many there are; those on the border of two pieces count twice.
    """
    box, count = np.empty((len(chosen), 4)), np.zeros(len(chosen), np.int64)
    first, last = (np.searchsorted(plan.owner, chosen, side) for side in ("left", "right"))

    def work(start: int, stop: int) -> None:
        _scan(plan.terms, plan.place, chosen, first, last, spacing, box, count, start, stop)

    over_all_cores(work, len(chosen), GRAIN)
    return box, count


@compiled
def _scan(
    terms: np.ndarray,
    place: np.ndarray,
    chosen: np.ndarray,
    first: np.ndarray,
    last: np.ndarray,
    spacing: float,
    box: np.ndarray,
    count: np.ndarray,
    start: int,
    stop: int,
) -> None:
    for k in range(start, stop):
        own, found = terms[chosen[k]], box[k]
        found[0], found[1], found[2], found[3] = np.inf, np.inf, -np.inf, -np.inf
        for piece in range(first[k], last[k]):
            corners = place[piece]
            low = min(corners[0, 1], min(corners[1, 1], corners[2, 1]))
            high = max(corners[0, 1], max(corners[1, 1], corners[2, 1]))
            y = spacing * (np.ceil(low / spacing - 0.5) + 0.5)
            while y <= high:
                left, right = span(corners, 3, y)
                x = spacing * (np.ceil(left / spacing - 0.5) + 0.5)
                while x <= right:
                    if is_inside(own, x, y):
                        found[0], found[1] = min(found[0], x), min(found[1], y)
                        found[2], found[3] = max(found[2], x), max(found[3], y)
                        count[k] += 1
                    x += spacing
                y += spacing
