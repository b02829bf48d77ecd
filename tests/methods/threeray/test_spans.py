"""No sample whose weights are within bounds is outside of their polygon."""

from __future__ import annotations

import numpy as np
import pytest

from anamorph.methods.threeray.sample_spans import columns_within, rows_within
from anamorph.raytriangle.owners import EDGE, places_of

SIZE = (96, 72)


def corners(kind: str, random: np.random.Generator, count: int) -> np.ndarray:
    """Homogeneous image corners of cameras, (count, 3, 3)."""
    if kind == "lattice":
        # Sides run through samples.
        places = np.stack([random.integers(-4, size + 4, (count, 3)) for size in SIZE], axis=-1).astype(float)
        places[::2, 1, 1] = places[::2, 0, 1]
    elif kind == "sliver":
        start, along = random.uniform(10.0, 60.0, (2, count, 1, 2))
        places = start + random.uniform(-1.0, 1.0, (count, 3, 1)) * along + 0.3 * random.normal(size=(count, 3, 2))
    else:
        places = random.uniform(-10.0, 90.0, (count, 3, 2))
    depth = random.uniform(0.2, 3.0, (count, 3, 1))
    if kind == "behind the eye":
        depth[:, 0] *= -1.0
    return np.concatenate([places * depth, depth], axis=2)


@pytest.mark.parametrize("kind", ["any", "lattice", "sliver", "behind the eye"])
def test_no_sample_within_bounds_is_lost(kind):
    random = np.random.default_rng(5)
    image = corners(kind, random, 60)
    places = places_of(image, SIZE)
    columns, rows = np.arange(SIZE[0]), np.arange(SIZE[1])
    asked, within = 0, 0
    for c in np.flatnonzero((places.box[:, 2:] > places.box[:, :2]).all(axis=1)):
        x0, y0, x1, y1 = places.box[c]
        at = np.stack(np.broadcast_arrays(columns[x0:x1] - x0, (rows[y0:y1] - y0)[:, None], 1.0), axis=-1)
        weights = at @ places.weights[c].T
        total = weights.sum(axis=-1, keepdims=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            weights = np.where(total > 0.0, weights / total, np.nan)
        owned = weights.min(axis=-1) >= -EDGE
        for _ in range(12):
            ends = np.sort(random.choice([random.uniform(0.0, 1.0, (3, 2)), random.integers(0, 2, (3, 2))]), axis=1)
            low, high = ends.T.astype(float)
            # What a camera owns on its sides has weights that rounding puts beyond 0 and 1.
            inside = owned & ((weights >= np.where(low > 0.0, low, -EDGE)) & (weights <= high + EDGE)).all(axis=-1)
            first, stop = rows_within(image[c], tuple(low), tuple(high), y0, y1)
            assert y0 <= first and stop <= y1
            found = np.zeros_like(inside)
            for row in range(first - y0, stop - y0):
                left, right = columns_within(places.weights[c], row, tuple(low), tuple(high), x1 - x0)
                found[row, left:right] = True
            assert found[inside].all()
            asked, within = asked + found.sum(), within + inside.sum()
    assert within > 300
    if kind == "any":
        assert asked < 1.5 * within
