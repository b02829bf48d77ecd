"""What the culling tests may never do: reject what is seen. And that they reject most of what is not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import Phase, example, given, settings
from hypothesis import strategies as st

from anamorph.base.errors import AnamorphError
from anamorph.raytriangle import project_points, side_surfaces

KINDS = ["any", "narrow", "beam", "pinhole", "parallel", "opposed", "plane side", "crossing", "thin", "two alike"]
QUICK = settings(max_examples=100, phases=(Phase.explicit, Phase.generate))


def ray_triangle(kind, random):
    p, n = random.normal(size=(2, 3, 3))
    if kind == "narrow":
        n = [0.0, 0.0, 1.0] + 0.3 * n
    elif kind == "beam":
        p = 0.1 * p * [1.0, 1.0, 0.0]
        n = [0.0, 0.0, 1.0] + 3.0 * p + 0.01 * n
    elif kind == "pinhole":
        p = p[0] + 0.0 * p
    elif kind == "parallel":
        n = n[0] * [[1.0], [2.0], [1.0]]
    elif kind == "opposed":
        n[1] = -n[0]
    elif kind == "plane side":
        n[1] = n[0] + 0.7 * (p[1] - p[0])
    elif kind == "crossing":
        n = random.normal(size=3) - p + 0.01 * n
    elif kind == "thin":
        p[2] = 0.5 * (p[0] + p[1]) + random.choice([0.0, 1e-12, 1e-6]) * p[2]
    elif kind == "two alike":
        p[1], n[1] = p[0], n[0]
    return p, n


def seen_points(p, n, random, count=60):
    w, t = random.dirichlet([0.4] * 3, count), random.exponential(4.0, count) * random.choice([0.0, 1.0, 50.0], count)
    w[:3] = np.eye(3)
    return w @ p + t[:, None] * (w @ n), t


@QUICK
@given(st.sampled_from(KINDS), st.integers(0, 2**32 - 1), st.sampled_from([np.inf, 5.0]))
@example("thin", 29, 5.0)
@example("thin", 170973560, 5.0)
def test_no_side_rejects_a_seen_point(kind, seed, reach):
    random = np.random.default_rng(seed)
    p, n = ray_triangle(kind, random)
    points, t = seen_points(p, n, random)
    sides = side_surfaces(p, n, reach)
    assert not (sides.outside(points) & (t <= reach)).any()
    anywhere = 4.0 * random.normal(size=(60, 3))
    found = project_points(p, n, anywhere)
    assert not (sides.outside(anywhere) & (found.seen & (found.t < reach)).any(axis=1)).any()


def test_what_a_beam_does_not_see_is_culled():
    random = np.random.default_rng(4)
    sides_decide, passed_sides, seen = [], [], []
    for _ in range(50):
        p, n = ray_triangle("beam", random)
        points = random.uniform(-3, 3, (300, 3))
        sides = side_surfaces(p, n)
        sides_decide.append((sides.inner != 0).mean())
        if sides.inner.all():
            passed_sides.append(~sides.outside(points) & (points[:, 2] > 0.0))
        seen.append(project_points(p, n, points).seen.any(axis=1))
    share = np.mean(seen)
    assert 0.001 < share < 0.05 and np.mean(sides_decide) > 0.7
    assert np.mean(passed_sides) < 0.1


def test_the_sign_changes_at_the_swept_surface():
    random = np.random.default_rng(6)
    for _ in range(50):
        p, n = ray_triangle("beam", random)
        sides = side_surfaces(p, n)
        a, t = random.uniform(0, 1, (2, 20))
        for edge in range(3):
            w = np.zeros((20, 3))
            w[:, edge], w[:, (edge + 1) % 3] = 1.0 - a, a
            on = w @ p + t[:, None] * (w @ n)
            inwards = p[(edge + 2) % 3] - p[edge] + t[:, None] * (n[(edge + 2) % 3] - n[edge])
            if sides.inner[edge]:
                assert not sides.outside(on + 1e-6 * inwards)[(a > 0.1) & (a < 0.9)].any()
                assert sides.outside(on - 1e-6 * inwards).all()


def test_many_ray_triangles_are_culled_as_one_by_one():
    random = np.random.default_rng(5)
    p, n = np.swapaxes([ray_triangle("narrow", random) for _ in range(6)], 0, 1).reshape(2, 3, 2, 3, 3)
    points = 2.0 * random.normal(size=(40, 3))
    sides = side_surfaces(p, n).outside(points)
    for i, j in np.ndindex(3, 2):
        assert (sides[i, j] == side_surfaces(p[i, j], n[i, j]).outside(points)).all()


def test_rays_that_cannot_be_used_are_refused():
    with pytest.raises(AnamorphError, match="directions are 0"):
        side_surfaces(np.eye(3), np.zeros((3, 3)))
    with pytest.raises(AnamorphError, match="finite"):
        side_surfaces(np.eye(3) * np.nan, np.eye(3))
