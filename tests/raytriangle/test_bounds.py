"""What a camera may see: nothing that one of its rays meets is left out, nor any weight of such a ray."""

from __future__ import annotations

import numpy as np
import pytest

from anamorph.raytriangle import project_points
from anamorph.raytriangle.bounds import weights_seen
from anamorph.raytriangle.camera_frames import frames_of
from anamorph.raytriangle.walls import volumes_met, walls_of

COUNT, EACH = 7_000, 10
"""Cameras, and boxes of each: over all kinds of cameras 10^6 pairs."""

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


def told(culling: str, origins: np.ndarray, directions: np.ndarray, middle: np.ndarray, half: np.ndarray) -> np.ndarray:
    """Which of their boxes (K, N, 3) cameras (K, 3, 3) may see, (K, N) bool."""
    frames, camera = frames_of(origins, directions), np.repeat(np.arange(len(middle)), middle.shape[1])
    places, sides = middle.reshape(-1, 3), half.reshape(-1, 3)
    if culling == "walls":
        met = volumes_met(frames, walls_of(origins, directions), camera, places, sides)
    else:
        met, _, _ = weights_seen(frames, camera, places, np.concatenate([sides, np.zeros_like(sides)], axis=1), True)
    return met.reshape(middle.shape[:2])


@pytest.mark.parametrize("kind", KINDS)
def test_no_box_is_left_out_that_a_ray_meets(kind):
    random = np.random.default_rng(KINDS.index(kind))
    origins, directions = cameras(kind, random)
    shape = COUNT, EACH
    weights = random.dirichlet((0.6, 0.6, 0.6), shape)
    weights[:, ::5] = np.eye(3)[random.integers(0, 3, weights[:, ::5].shape[:2])]
    t = random.uniform(0.0, 3.0, shape) * random.choice([0.0, 1e-3, 1.0, 30.0], shape)
    # Every third point is not made to be seen: brute force says whether it is.
    weights[:, ::3] += random.normal(size=(COUNT, 1, 1)) * [1.0, -1.0, 0.0]
    ways = origins[:, None] + t[..., None, None] * directions[:, None]
    points = np.einsum("kni,knij->knj", weights, ways)
    seen = np.ones(shape, bool)
    seen[:, ::3] = project_points(origins, directions, points[:, ::3]).seen.any(axis=2)
    half = random.uniform(0.0, 1.0, points.shape) * 10.0 ** random.uniform(-6.0, 0.5, (*shape, 1))
    half[:, ::4, 1] = 0.0
    middle = points + random.uniform(-1.0, 1.0, points.shape) * half
    # Rounding puts points off by so much; a box in the tree is widened by as much.
    half += 1e-12 * np.abs(points)
    for culling in ("bounds", "walls"):
        assert told(culling, origins, directions, middle, half)[seen].all(), culling


@pytest.mark.parametrize("kind", KINDS)
def test_weights_of_rays_that_meet_a_surfel_are_within_its_bounds(kind):
    random, count = np.random.default_rng(11), 20_000
    origins, directions = cameras(kind, random, count)
    weights = random.dirichlet((1.0, 1.0, 1.0), count)
    t = random.uniform(0.1, 3.0, count)
    points = np.einsum("ki,kij->kj", weights, origins + t[:, None, None] * directions)
    vectors = random.normal(size=(count, 3, 3)) * 10.0 ** random.uniform(-4.0, 0.0, (count, 1, 1))
    vectors -= vectors.mean(axis=1, keepdims=True)
    # The point lies in the triangle with these corners.
    middle = points - np.einsum("ki,kij->kj", random.dirichlet((1.0, 1.0, 1.0), count), vectors)
    first, second = [0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]
    covariance = 2.0 / 3.0 * (vectors[..., first] * vectors[..., second]).sum(axis=1)
    seen, low, high = weights_seen(frames_of(origins, directions), np.arange(count), middle, covariance, False)
    assert seen.all()
    # Where one triangle of weights leads to the point, these are it; else there may be others, within bounds too.
    assert (low <= weights + 1e-6).all() and (high >= weights - 1e-6).all()


@pytest.mark.parametrize("culling", ["bounds", "walls"])
def test_most_of_what_is_beside_or_behind_a_camera_is_left_out(culling):
    random = np.random.default_rng(2)
    origins, directions = cameras("spreading", random)
    middle = random.normal(size=(COUNT, EACH, 3)) * 8.0
    half = np.full(middle.shape, 0.05)
    assert told(culling, 0.1 * origins, directions, middle, half).mean() < 0.1
    behind = told(culling, 0.1 * origins, directions, middle * [1.0, 1.0, 0.0] - [0.0, 0.0, 9.0], half)
    assert not behind.any()


def test_walls_leave_out_all_but_boxes_that_hold_something_seen():
    random, count, steps = np.random.default_rng(3), 200, 7
    origins, directions = cameras("converging", random, count)
    middle = random.normal(size=(count, EACH, 3)) * 2.0 + [0.0, 0.0, 4.0]
    half = np.full(middle.shape, 0.3)
    met = told("walls", origins, directions, middle, half)
    beyond = (np.abs(origins.mean(axis=1)[:, None] - middle) > 3.0).any(axis=2)
    grid = np.stack(np.meshgrid(*[np.linspace(-0.3, 0.3, steps)] * 3), axis=-1).reshape(-1, 3)
    points = (middle[:, :, None] + grid).reshape(count, -1, 3)
    held = project_points(origins, directions, points).seen.any(axis=2).reshape(count, EACH, -1).any(axis=2)
    assert met[held].all() and 0.02 < met[beyond].mean() < 0.5
    # What is seen may pass between the points of the grid, but seldom.
    assert (met & ~held)[beyond].sum() < 0.1 * held[beyond].sum()


def test_bounds_are_close_for_small_surfels_far_from_any_crossing():
    random, count = np.random.default_rng(4), 300
    origins, directions = cameras("spreading", random, count)
    # As of a mirror's triangles, which are small beside what they see, and turn their rays by little.
    origins, directions = origins * [0.1, 0.1, 0.01], origins * [0.1, 0.1, 0.0] + [0.0, 0.0, 1.0]
    weights = random.dirichlet((3.0, 3.0, 3.0), count)
    points = np.einsum("ki,kij->kj", weights, origins + 5.0 * directions)
    small = np.tile([1e-6, 1e-6, 1e-6, 0.0, 0.0, 0.0], (count, 1))
    seen, low, high = weights_seen(frames_of(origins, directions), np.arange(count), points, small, False)
    assert seen.all()
    assert np.median((high - low).max(axis=1)) < 0.03
