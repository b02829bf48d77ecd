"""The sweeping triangle: what it says is seen once is seen once, and rays change sides where it says."""

from __future__ import annotations

import numpy as np
import pytest

from anamorph.base.errors import AnamorphError
from anamorph.raytriangle.points import project_points
from anamorph.raytriangle.sweeping import seen_once, sees_once, switches

COUNT = 20_000


def ray_triangles(kind: str, random: np.random.Generator, count: int = COUNT) -> tuple[np.ndarray, np.ndarray]:
    origins = random.normal(size=(count, 3, 3)) * [1.0, 1.0, 0.2]
    focus = random.normal(size=(count, 1, 3)) * 0.3 + [0.0, 0.0, 3.0]
    stray = {"wild": 1.0, "converging": 0.3, "nearly a focus": 1e-3, "a focus": 0.0}.get(kind, 0.3)
    directions = focus + stray * random.normal(size=(count, 3, 3)) - origins
    if kind == "parallel":
        directions = np.broadcast_to(directions[:, :1], directions.shape)
    elif kind == "nearly parallel":
        directions = directions[:, :1] + 1e-7 * random.normal(size=(count, 3, 3))
    elif kind == "flat":
        origins[..., 2], directions[..., 2] = 0.0, 0.0
    elif kind == "one ray":
        origins, directions = (np.broadcast_to(each[:, :1], each.shape) for each in (origins, directions))
    elif kind == "two rays":
        origins, directions = (each[:, [0, 1, 1]] for each in (origins, directions))
    elif kind == "grazing":
        directions = np.cross(origins[:, 1] - origins[:, 0], origins[:, 2] - origins[:, 0])[:, None] * 1e-6 + (
            np.roll(origins, 1, axis=1) - origins
        )
    elif kind == "sliver":
        origins[:, 2] = origins[:, 0] + 0.5 * (origins[:, 1] - origins[:, 0]) + 1e-9 * random.normal(size=(count, 3))
    elif kind == "far":
        origins, directions = origins + 1e5, 1e-3 * directions
    return origins, directions


KINDS = [
    "wild", "converging", "nearly a focus", "a focus", "parallel", "nearly parallel",
    "flat", "one ray", "two rays", "grazing", "sliver", "far",
]  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(5))
def test_what_is_seen_once_has_no_second_ray(kind, seed):
    random = np.random.default_rng(seed)
    origins, directions = ray_triangles(kind, random)
    weights, t = random.dirichlet((1.0, 1.0, 1.0), COUNT), random.uniform(0.2, 3.0, COUNT)
    points = np.einsum("ki,kij->kj", weights, origins + t[:, None, None] * directions)
    found = project_points(origins, directions, points[:, None])
    once = np.stack([seen_once(origins, directions, found.t[:, 0, k]) for k in range(3)], axis=-1) & found.seen[:, 0]
    times = found.seen[:, 0].sum(axis=1)
    assert (times[once.any(axis=1)] == 1).all()
    if kind in ("wild", "converging"):
        assert (times > 1).sum() > 300
        # And it says so of most.
        assert once.any(axis=1)[times == 1].mean() > 0.85
    if kind in ("flat", "one ray", "two rays"):
        assert not once.any()


@pytest.mark.parametrize("kind", KINDS)
def test_ray_triangles_that_see_once_have_no_second_ray_for_any_point(kind):
    random = np.random.default_rng(7)
    origins, directions = ray_triangles(kind, random)
    near, far = random.uniform(0.0, 0.5, COUNT), random.uniform(1.0, 30.0, COUNT)
    once = sees_once(origins, directions, near, far)
    weights, t = random.dirichlet((1.0, 1.0, 1.0), COUNT), random.uniform(near, far)
    points = np.einsum("ki,kij->kj", weights, origins + t[:, None, None] * directions)
    found = project_points(origins, directions, points[:, None])
    t = found.t[:, 0]
    times = (found.seen[:, 0] & (t >= near[:, None]) & (t <= far[:, None])).sum(axis=1)
    assert (times[once] <= 1).all()
    if kind == "wild":
        assert (times > 1).sum() > 300 and once.any()
    if kind in ("flat", "one ray", "two rays"):
        assert not once.any()
    spread = origins - [0.0, 0.0, -4.0]
    if kind not in ("flat", "one ray", "two rays", "grazing", "sliver", "far"):
        assert sees_once(origins, spread, near, far).mean() > 0.99


@pytest.mark.parametrize("kind", ["wild", "converging", "nearly a focus", "far"])
def test_rays_change_sides_where_they_lie_in_the_triangles_plane(kind):
    origins, directions = ray_triangles(kind, np.random.default_rng(1), 2000)
    t, real = switches(origins, directions)
    assert real.any() and (np.diff(t, axis=-1)[real.all(axis=-1)] >= 0.0).all()
    for ray in range(3):
        for which in range(2):
            some = real[:, ray, which]
            at = t[some, ray, which]
            corners = origins[some] + at[:, None, None] * directions[some]
            sides = corners[:, 1:] - corners[:, :1]
            normal = np.cross(sides[:, 0], sides[:, 1])
            along = directions[some, ray]
            volume = np.einsum("ki,ki->k", normal, along)
            size = np.linalg.norm(sides, axis=2).prod(axis=1) * np.linalg.norm(along, axis=1)
            # Where the triangle shrinks to a line, its sides are what rounding leaves of far larger numbers.
            far = np.abs(corners).max(axis=(1, 2)) * np.linalg.norm(sides, axis=2).max(axis=1)
            far *= np.linalg.norm(along, axis=1)
            assert (np.abs(volume) <= 1e-7 * size + 1e-10 * far).mean() > 0.99


def test_rays_that_spread_from_a_point_behind_them_never_change_sides_before_them():
    origins = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    directions = origins - [0.3, 0.3, -1.0]
    t, real = switches(origins, directions)
    assert (t[real] < 0.0).all()
    assert seen_once(np.tile(origins, (50, 1, 1)), np.tile(directions, (50, 1, 1)), np.linspace(0.0, 20.0, 50)).all()


def test_between_the_switches_of_rays_that_cross_points_may_be_seen_twice():
    """Two rays cross at t = 1, and the third stays apart: there the triangle is turned over."""
    origins = np.array([[-1.0, 0.0, 0.0], [1.0, 0.02, 0.0], [0.0, 2.0, 0.0]])
    directions = np.array([[1.0, 0.0, 1.0], [-1.0, 0.0, 1.0], [0.0, 0.1, 1.0]])
    t, real = switches(origins, directions)
    assert ((t[real] > 0.5) & (t[real] < 200.0)).any()
    assert seen_once(origins, directions, np.array(0.1))
    inner = np.sort(t[real & (t > 0.0)])
    assert not seen_once(origins, directions, np.array(0.5 * (inner[0] + inner[1])))


def test_numbers_that_are_not_finite_are_refused():
    with pytest.raises(AnamorphError, match="finite"):
        seen_once(np.full((3, 3), np.nan), np.eye(3), np.array(1.0))
