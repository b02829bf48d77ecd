"""The virtual viewpoint is the least-squares point of lines, and goes to infinity without a jump."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from anamorph.optics.viewpoint import virtual_viewpoint
from anamorph.projection import map_frame

SEEDS = st.integers(0, 2**32 - 1)


def normal_equations(origins, directions):
    """Matrix and right side of the least-squares point: mean(I - d d^T) x = mean((I - d d^T) o)."""
    across = np.eye(3) - directions[:, :, None] * directions[:, None]
    return across.mean(axis=0), np.einsum("nij,nj->i", across, origins) / len(origins)


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def stacked_least_squares(origins, directions):
    """The point nearest to all the lines, by numpy, from one (I - d d^T) x = (I - d d^T) o for each."""
    across = np.eye(3) - directions[:, :, None] * directions[:, None, :]
    return np.linalg.lstsq(across.reshape(-1, 3), np.einsum("nij,nj->ni", across, origins).ravel(), rcond=None)[0]


@settings(max_examples=60)
@given(SEEDS, st.integers(2, 40), st.sampled_from([0.05, 0.3, 1.0]), st.sampled_from([0.0, 1.0, 1e3]))
def test_it_is_the_least_squares_point(seed, count, spread, shift):
    generator = np.random.default_rng(seed)
    origins = generator.normal(size=(count, 3)) + shift
    directions = unit(generator.normal(size=3) + spread * generator.normal(size=(count, 3)))
    viewpoint = virtual_viewpoint(origins, directions)
    expected = stacked_least_squares(origins, directions)
    smallest = np.linalg.eigvalsh(normal_equations(origins, directions)[0])[0]
    tolerance = 1e-9 * (1.0 + abs(shift)) / smallest
    assert np.linalg.norm(viewpoint[:3] / viewpoint[3] - expected) <= tolerance


@settings(max_examples=60)
@given(SEEDS, st.integers(2, 30), st.sampled_from([0.05, 0.3]), st.sampled_from([-1.0, 1.0]))
def test_it_satisfies_its_normal_equations_and_its_sign_tells_the_side(seed, count, spread, side):
    """Positive weight is a point behind the rays' origins; rays that converge before them give a negative one."""
    generator = np.random.default_rng(seed)
    axis = unit(generator.normal(size=3))
    directions = unit(axis + spread * generator.normal(size=(count, 3)))
    apex = generator.normal(size=3)
    origins = apex + side * generator.uniform(3.0, 5.0, (count, 1)) * directions
    origins += 0.01 * generator.normal(size=(count, 3))
    matrix, right_side = normal_equations(origins, directions)
    viewpoint = virtual_viewpoint(origins, directions)
    residual = matrix @ viewpoint[:3] - viewpoint[3] * right_side
    assert np.abs(residual).max() <= 1e-12 * max(np.abs(viewpoint).max(), 1.0)
    assert np.isfinite(viewpoint).all()
    behind = directions.mean(axis=0) @ (viewpoint[3] * origins.mean(axis=0) - viewpoint[:3])
    if count >= 5:
        assert viewpoint[3] > 0.0
        assert np.sign(behind) == side


@settings(max_examples=40)
@given(SEEDS, st.integers(2, 30))
def test_lines_through_one_point_give_it_back(seed, count):
    generator = np.random.default_rng(seed)
    point = 10.0 * generator.normal(size=3)
    directions = unit(generator.normal(size=(count, 3)))
    origins = point + generator.normal(size=(count, 1)) * directions
    viewpoint = virtual_viewpoint(origins, directions)
    smallest = np.linalg.eigvalsh(normal_equations(origins, directions)[0])[0]
    assert viewpoint[:3] / viewpoint[3] == pytest.approx(point, abs=1e-12 * 30.0 / smallest)


@settings(max_examples=40)
@given(SEEDS, st.integers(1, 30), st.sampled_from([1e-3, 1.0, 1e3]))
def test_parallel_rays_and_one_ray_lead_to_infinity(seed, count, size):
    generator = np.random.default_rng(seed)
    direction = unit(generator.normal(size=3))
    origins = size * (generator.normal(size=(count, 3)) + 5.0)
    viewpoint = virtual_viewpoint(origins, np.tile(direction, (count, 1)))
    assert viewpoint[3] == 0.0
    assert viewpoint[:3] == pytest.approx(-direction, abs=1e-7)


@pytest.mark.parametrize("size", [1e-2, 1.0, 50.0])
@pytest.mark.parametrize("seed", range(3))
def test_ever_more_distant_viewpoints_run_into_the_parallel_projection(size, seed):
    """A true apex 10 to 10^12 times the size away: slope and convergence approach the parallel ones all the way."""
    generator = np.random.default_rng(seed)
    axes = np.linalg.qr(generator.normal(size=(3, 3)))[0]
    origins = size * (generator.normal(size=(25, 3)) * 0.5 + 3.0)
    along = unit(axes[2] + 0.3 * axes[0])
    center = origins.mean(axis=0) + size * axes[2]
    parallel = map_frame(virtual_viewpoint(origins, np.tile(along, (25, 1))), center, axes)
    assert parallel.convergence == 0.0
    assert parallel.slope == pytest.approx([-0.3, 0.0], abs=1e-7)
    for power in range(1, 13):
        apex = origins.mean(axis=0) - 10.0**power * size * along
        frame = map_frame(virtual_viewpoint(origins, unit(origins - apex)), center, axes)
        # What the paper's point would be, or the parallel projection, to what float64 can tell of directions.
        expected = 1.0 / ((center - apex) @ axes[2])
        blur = 1e-15 / (size * 10.0 ** (-2 * power)) if power < 5 else 1e-6 if power < 8 else 2.0
        assert frame.convergence == pytest.approx(expected, rel=max(blur, 1e-6))
        assert frame.convergence >= 0.0
        assert frame.slope == pytest.approx(parallel.slope, abs=5.0 * 10.0**-power + 1e-7)


def test_two_parallel_rays_and_one_askew_are_not_parallel():
    origins = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    directions = unit(np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 1e-3, 1.0]]))
    viewpoint = virtual_viewpoint(origins, directions)
    assert viewpoint[3] > 0.0
    assert viewpoint[:3] / viewpoint[3] == pytest.approx(stacked_least_squares(origins, directions), rel=1e-6, abs=1e-9)
