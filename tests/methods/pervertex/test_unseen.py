"""Lists of what no map sees: nothing that a ray of the triangle meets there is left out of its list."""

from __future__ import annotations

import numpy as np
import pytest

from anamorph.methods.pervertex import unseen
from anamorph.methods.pervertex.unseen import MOST, listed, parts_of

FACES = 40


def rays(random, spread):
    """Three rays each from small triangles, (FACES, 3, 3) twice, that spread by about so many radians."""
    middles, ways = random.normal(size=(2, FACES, 1, 3))
    origins = middles + 0.1 * random.normal(size=(FACES, 3, 3))
    directions = ways + spread * np.linalg.norm(ways, axis=2, keepdims=True) * random.normal(size=(FACES, 3, 3))
    return origins, directions / np.linalg.norm(directions, axis=2, keepdims=True)


def meets(origin, direction, corners, longest):
    """Whether a ray meets triangles (T, 3, 3) within so much, by volumes in float64."""
    a, b, c = (corners[:, i] - origin for i in range(3))
    volumes = np.stack([np.cross(c, b) @ direction, np.cross(a, c) @ direction, np.cross(b, a) @ direction], axis=1)
    weights = volumes / volumes.sum(axis=1, keepdims=True)
    distance = np.einsum("tc,tci->ti", weights, np.stack([a, b, c], axis=1)) @ direction
    return (weights >= 0.0).all(axis=1) & (distance > 0.0) & (distance < longest)


@pytest.mark.parametrize("spread", [0.0, 0.05, 0.5])
def test_no_triangle_that_a_ray_between_the_corners_meets_is_left_out(spread, monkeypatch):
    monkeypatch.setattr(unseen, "MOST", 400)
    random = np.random.default_rng(7)
    origins, directions = rays(random, spread)
    corners = (random.normal(size=(400, 1, 3)) + 0.2 * random.normal(size=(400, 3, 3))).astype(np.float32)
    ranges = np.column_stack([np.full(FACES, 1.5), np.zeros(FACES), np.zeros(FACES)])
    first, found, whole = listed(*parts_of(origins, directions, ranges), corners, np.ones(400, bool))
    assert whole.all() and len(found) < 0.5 * FACES * 400
    met = 0
    for weights in random.dirichlet(np.ones(3), 30):
        for face in range(FACES):
            direction = weights @ directions[face]
            there = meets(weights @ origins[face], direction / np.linalg.norm(direction), corners.astype(float), 1.4)
            met += there.sum()
            assert set(np.flatnonzero(there) + 1) <= set(found[first[face] : first[face + 1]].tolist())
    assert met > 100


def test_a_list_that_is_too_long_is_none_and_says_so():
    random = np.random.default_rng(3)
    origins, directions = rays(random, 0.05)
    corners = np.repeat(origins[:1], MOST + 1, axis=0).astype(np.float32) + 0.01
    ranges = np.tile([1.0, 0.0, 0.0], (FACES, 1))
    first, found, whole = listed(*parts_of(origins, directions, ranges), corners, np.ones(MOST + 1, bool))
    assert not whole[0] and first[1] == 0 and len(found) == first[-1]


def test_what_does_not_count_and_parts_of_no_length_list_nothing():
    random = np.random.default_rng(3)
    origins, directions = rays(random, 0.05)
    corners = origins.astype(np.float32) + np.float32(0.01)
    ranges = np.tile([1.0, 0.0, 0.0], (FACES, 1))
    _, found, whole = listed(*parts_of(origins, directions, ranges), corners, np.zeros(FACES, bool))
    assert whole.all() and not len(found)
    _, found, whole = listed(*parts_of(origins, directions, 0.0 * ranges), corners, np.ones(FACES, bool))
    assert whole.all() and not len(found)
