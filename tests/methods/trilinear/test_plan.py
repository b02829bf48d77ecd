"""What ray triangles see of scene triangles, against a ray for each of many image points, by brute force."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from trilinear_twin import (
    IMAGES,
    RAYS,
    TRIANGLES,
    RayTriangles,
    evaluated,
    image_points,
    magnitudes,
    meet,
    planned,
    ray_triangle,
    scene_triangles,
    within,
)

from anamorph.methods.trilinear import plan as plan_module
from anamorph.methods.trilinear.pairs import ALL, FRONTS, NONE, Own
from anamorph.methods.trilinear.plan import Plan, Planner
from anamorph.methods.trilinear.terms import TERMS

QUICK = settings(max_examples=150, phases=(Phase.explicit, Phase.generate))
NOISE = 1e-11
"""Of float64 in the pair's functions, as a share of what they are the differences of."""


def check(rays: RayTriangles, triangles: np.ndarray, points: np.ndarray, near: float = 0.0) -> int:
    """Hold a plan against brute force at image points. Returns the number of hits."""
    beams, plan = planned(rays, triangles, near)
    if not len(beams.number):
        return 0
    points = points[within(beams, 0, points)]
    pace = np.linalg.norm(rays.directions[0], axis=1).max()
    meeting = meet(rays, triangles, points)
    sure = meeting.own[:, None] & meeting.sure(near / pace)
    hits = sure & meeting.hit(near / pace)
    places = points - beams.center[0]
    rows = {(face, side): row for row, (_, face, side) in enumerate(plan.pair.tolist())}
    assert len(rows) == len(plan.pair)
    for face in range(len(triangles)):
        for side in range(2):
            hit = hits[:, face] & (meeting.front[:, face] == (side == 1))
            row = rows.get((face, side))
            if row is None:
                assert not hit.any(), "no pair"
                continue
            values, _ = evaluated(plan.terms[row], places)
            noise = NOISE * magnitudes(rays, triangles[face], beams, places)
            assert (values >= -noise)[hit].all(), "inside"
            missed = sure[:, face] & ~hit
            assert (values <= noise)[missed].any(axis=1).all(), "outside"
            exact(meeting, face, hit, values, noise, beams.near[0])
    return int(np.count_nonzero(hits))


def exact(meeting, face, hit, values, noise, near):
    """The quadratics' shares are the weights, and N t over N is t."""
    total = values[hit, :3].sum(axis=1)
    weights = values[hit, :3] / total[:, None]
    doubt = noise[hit, :3].sum(axis=1) / total
    expected = meeting.weights[hit, face].astype(float)
    assert (np.abs(weights - expected) <= 2.0 * doubt[:, None]).all(), "weights"
    t = near + values[hit, 4] / values[hit, 3]
    expected = meeting.t[hit, face].astype(float)
    doubt = (noise[hit, 4] + noise[hit, 3] * expected) / values[hit, 3]
    assert (np.abs(t - expected) <= doubt).all(), "t"


@QUICK
@given(
    st.sampled_from(RAYS),
    st.sampled_from(IMAGES),
    st.sampled_from(TRIANGLES),
    st.sampled_from([0.0, 0.7]),
    st.integers(0, 2**32 - 1),
)
def test_a_plan_holds_what_rays_meet(rays, image, kind, near, seed):
    random = np.random.default_rng(seed)
    seen_by = ray_triangle(rays, image, random)
    triangles, places = scene_triangles(kind, seen_by, 12, random)
    check(seen_by, triangles, np.concatenate([places, image_points(seen_by, 150, random)]), near)


def scene(count: int = 40, seed: int = 0, rays: int = 30) -> tuple[RayTriangles, np.ndarray]:
    """Many ray triangles, and triangles that several of them see."""
    random = np.random.default_rng(seed)
    parts = [ray_triangle("any", "any", random) for _ in range(rays)]
    seen_by = RayTriangles(*(np.concatenate(each) for each in zip(*parts, strict=True)))
    middles = random.normal(size=(count, 1, 3)) + np.array([0.0, 0.0, 3.0])
    return seen_by, middles + random.normal(scale=0.5, size=(count, 3, 3))


def rows_of(plan: Plan) -> set[tuple[int, int, int]]:
    return set(map(tuple, plan.pair.tolist()))


def test_many_ray_triangles_are_planned_as_one_by_one():
    rays, triangles = scene()
    beams, plan = planned(rays, triangles)
    for k, number in enumerate(beams.number):
        _, alone = planned(RayTriangles(*(each[number : number + 1] for each in rays)), triangles)
        rows = plan.pair[:, 0] == k
        assert (plan.pair[rows, 1:] == alone.pair[:, 1:]).all()
        assert (plan.terms[rows] == alone.terms).all()


@pytest.mark.parametrize("count", [0, 1, 3])
def test_nothing_to_see_and_nothing_that_sees(count):
    rays, triangles = scene()
    none = RayTriangles(*(each[:0] for each in rays))
    few = RayTriangles(*(each[:count] for each in rays))
    for seen_by, seen in ((none, triangles), (few, triangles[:0]), (few, triangles - [0.0, 0.0, 1000.0])):
        _, plan = planned(seen_by, seen)
        assert plan.pair.shape == (0, 3) and plan.terms.shape == (0, TERMS)


@pytest.mark.parametrize("use", [1, 2, 5])
def test_any_number_of_cores_and_any_capacity_give_the_same_plan(use, monkeypatch):
    rays, triangles = scene(200)
    _, expected = planned(rays, triangles)
    assert len(expected.pair) > 500
    monkeypatch.setattr(plan_module, "cores", lambda: use)
    monkeypatch.setattr(plan_module, "FIRST_PAIRS", 3)
    planner = Planner()
    for _ in range(2):
        _, plan = planned(rays, triangles, planner=planner)
        for name in ("pair", "terms"):
            assert (getattr(plan, name) == getattr(expected, name)).all()


@pytest.mark.parametrize("sees", [ALL, FRONTS, NONE])
def test_a_ray_triangle_sees_of_its_own_group_what_it_may(sees):
    rays, triangles = scene()
    group = (np.arange(len(triangles)) % 3).astype(np.int32)
    count = len(rays.image)
    own = Own(
        np.arange(count, dtype=np.int32),
        (np.arange(count) % 3).astype(np.int32),
        np.full(count, sees, np.int32),
    )
    beams, everything = planned(rays, triangles)
    _, plan = planned(rays, triangles, group=group, own=own)
    expected = {
        (k, face, side)
        for k, face, side in rows_of(everything)
        if face != beams.number[k]
        and (group[face] != beams.number[k] % 3 or sees == ALL or (sees == FRONTS and side == 1))
    }
    assert rows_of(plan) == expected
    assert 0 < len(expected) < len(everything.pair)


def test_the_front_is_where_corners_run_counter_clockwise():
    rays = RayTriangles(
        np.array([[[0.0, 0.0, 1.0], [100.0, 0.0, 1.0], [0.0, 100.0, 1.0]]]),
        np.array([[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]),
        np.array([[[0.0, 0.0, -1.0]] * 3]),
    )
    upward = np.array([[[0.1, 0.1, -2.0], [0.3, 0.1, -2.0], [0.1, 0.3, -2.0]]])
    for triangles, side in ((upward, 1), (upward[:, ::-1], 0)):
        _, plan = planned(rays, triangles)
        assert plan.pair.tolist() == [[0, 0, side]]
    for near, count in ((1.9, 1), (2.1, 0)):
        assert len(planned(rays, upward, near)[1].pair) == count


def test_what_is_nearer_than_near_is_not_seen():
    """In metres along the longest of the three rays."""
    rays = RayTriangles(
        np.array([[[0.0, 0.0, 1.0], [100.0, 0.0, 1.0], [0.0, 100.0, 1.0]]]),
        np.array([[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]),
        np.array([[[0.0, 0.0, 5.0]] * 3]),
    )
    leaning = np.array([[[-1.0, -1.0, -1.0], [3.0, -1.0, 3.0], [0.3, 4.0, 0.3]]])
    points = np.random.default_rng(1).uniform(0.0, 50.0, (300, 2))
    assert 20 < check(rays, leaning, points, 0.4) < check(rays, leaning, points, 0.0)
