"""What a camera may see, bounded: nothing that one of its rays meets is left out, nor any weight of such a ray."""

from __future__ import annotations

import numpy as np
import pytest

from anamorph.raytriangle.bounds import boxes_seen, seen_weights
from anamorph.raytriangle.camera_frames import frames_of

COUNT = 10_000

KINDS = [
    "spreading", "converging", "nearly a focus", "a focus", "parallel", "nearly parallel", "flat", "one ray",
    "two rays", "grazing", "sliver", "wide", "far", "tiny", "uneven",
]  # fmt: skip


def cameras(kind: str, random: np.random.Generator, count: int = COUNT) -> tuple[np.ndarray, np.ndarray]:
    """Origins and directions of cameras, (count, 3, 3) each."""
    origins = random.normal(size=(count, 3, 3)) * [1.0, 1.0, 0.2]
    outward = origins + [0.0, 0.0, 4.0] + 0.3 * random.normal(size=(count, 3, 3))
    focus = random.normal(size=(count, 1, 3)) * 0.3 + [0.0, 0.0, 3.0]
    stray = {"converging": 0.3, "nearly a focus": 1e-4}.get(kind, 0.0)
    toward = focus + stray * random.normal(size=(count, 3, 3)) - origins
    if kind in ("converging", "nearly a focus", "a focus"):
        return origins, toward
    if kind == "parallel":
        return origins, np.repeat(outward[:, :1], 3, axis=1)
    if kind == "nearly parallel":
        return origins, outward[:, :1] + 1e-8 * random.normal(size=(count, 3, 3))
    if kind == "flat":
        return origins * [1.0, 1.0, 0.0], outward * [1.0, 1.0, 0.0]
    if kind == "one ray":
        return np.repeat(origins[:, :1], 3, axis=1), np.repeat(outward[:, :1], 3, axis=1)
    if kind == "two rays":
        return origins[:, [0, 1, 1]], outward[:, [0, 1, 1]]
    if kind == "grazing":
        return origins, np.roll(origins, 1, axis=1) - origins + 1e-6 * outward
    if kind == "sliver":
        origins[:, 2] = 0.5 * (origins[:, 0] + origins[:, 1]) + 1e-9 * random.normal(size=(count, 3))
        return origins, outward
    if kind == "wide":
        return origins, random.normal(size=(count, 3, 3))
    if kind == "far":
        return origins + 1e5, outward
    if kind == "tiny":
        return 1e-6 * origins, outward
    if kind == "uneven":
        return origins, outward * random.uniform(0.01, 10.0, (count, 3, 1))
    return origins, outward


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(7))
def test_no_box_is_left_out_that_a_ray_meets(kind, seed):
    random = np.random.default_rng(seed)
    origins, directions = cameras(kind, random)
    weights = random.dirichlet((0.6, 0.6, 0.6), COUNT)
    weights[::5] = np.eye(3)[random.integers(0, 3, len(weights[::5]))]
    t = random.uniform(0.0, 3.0, COUNT) * random.choice([0.0, 1e-3, 1.0, 30.0], COUNT)
    points = np.einsum("ki,kij->kj", weights, origins + t[:, None, None] * directions)
    half = random.uniform(0.0, 1.0, (COUNT, 3)) * 10.0 ** random.uniform(-6.0, 0.5, (COUNT, 1))
    half[::4, 1] = 0.0
    middle = points + random.uniform(-1.0, 1.0, (COUNT, 3)) * half
    # Rounding puts points off by so much; a box in the tree is widened by as much.
    half += 1e-12 * np.abs(points)
    frames = frames_of(origins, directions)
    assert boxes_seen(frames, middle, half).all()


@pytest.mark.parametrize("kind", KINDS)
def test_weights_of_rays_that_meet_a_surfel_are_within_its_bounds(kind):
    random, count = np.random.default_rng(11), 600
    origins, directions = cameras(kind, random, count)
    weights = random.dirichlet((1.0, 1.0, 1.0), count)
    t = random.uniform(0.1, 3.0, count)
    points = np.einsum("ki,kij->kj", weights, origins + t[:, None, None] * directions)
    frames = frames_of(origins, directions)
    for c in range(count):
        vectors = random.normal(size=(3, 3)) * 10.0 ** random.uniform(-4.0, 0.0)
        vectors -= vectors.mean(axis=0)
        # The point lies in the triangle with these corners.
        middle = points[c] - random.dirichlet((1.0, 1.0, 1.0)) @ vectors
        first, second = [0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]
        row = 2.0 / 3.0 * (vectors[:, first] * vectors[:, second]).sum(axis=0)
        seen, low, high = seen_weights(frames, c, tuple(middle), tuple(row), False)
        assert seen
        # Where one triangle of weights leads to the point, these are it; else there may be others, within bounds too.
        assert (np.array(low) <= weights[c] + 1e-6).all() and (np.array(high) >= weights[c] - 1e-6).all()


def test_most_of_what_is_beside_or_behind_a_camera_is_left_out():
    random = np.random.default_rng(2)
    origins, directions = cameras("spreading", random)
    frames = frames_of(0.1 * origins, directions)
    middle = random.normal(size=(COUNT, 3)) * 8.0
    seen = boxes_seen(frames, middle, np.full((COUNT, 3), 0.05))
    assert seen.mean() < 0.1
    behind = boxes_seen(frames, middle * [1.0, 1.0, 0.0] - [0.0, 0.0, 9.0], np.full((COUNT, 3), 0.05))
    assert not behind.any()


def test_bounds_are_close_for_small_surfels_far_from_any_crossing():
    random, count = np.random.default_rng(4), 300
    origins, directions = cameras("spreading", random, count)
    # As of a mirror's triangles, which are small beside what they see, and turn their rays by little.
    origins, directions = origins * [0.1, 0.1, 0.01], origins * [0.1, 0.1, 0.0] + [0.0, 0.0, 1.0]
    weights = random.dirichlet((3.0, 3.0, 3.0), count)
    points = np.einsum("ki,kij->kj", weights, origins + 5.0 * directions)
    frames = frames_of(origins, directions)
    widths = []
    for c in range(count):
        seen, low, high = seen_weights(frames, c, tuple(points[c]), (1e-6, 1e-6, 1e-6, 0.0, 0.0, 0.0), False)
        assert seen
        widths.append(np.subtract(high, low).max())
    assert np.median(widths) < 0.03
