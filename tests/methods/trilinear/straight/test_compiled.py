"""The compiled parts of straight-edged drawing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from ray_triangles import scene

from anamorph.methods.trilinear.straight.barycentric_grid import small_triangle
from anamorph.methods.trilinear.straight.chains import CORNER, EDGE, LINKS, OPEN, SHAPES, connected
from anamorph.methods.trilinear.straight.swept_sides import straight_rows
from anamorph.methods.trilinear.straight.traces import CUTS, quadratic_roots, side_crossings
from anamorph.raytriangle.rows import PACE, SHIFT
from anamorph.raytriangle.solve import BEFORE, COUNT, ROOT, ROOTS, WORDS, solve_point

SEEDS = st.integers(0, 2**32 - 1)
QUICK = settings(max_examples=150, phases=(Phase.explicit, Phase.generate))


def row_of(p, n):
    return straight_rows(np.eye(3)[None], p[None], n[None])[0]


def solved_by(row, points):
    solved = np.zeros((len(points), WORDS))
    for k, (x, y, z) in enumerate(points):
        solve_point(row, x, y, z, np.zeros(8), solved[k])
    return solved


def test_quadratics_of_every_degree():
    assert sorted(quadratic_roots(-6.0, 1.0, 1.0)) == [-3.0, 2.0]
    assert quadratic_roots(1.0, 1e9, 1.0) == pytest.approx((-1e9, -1e-9))
    assert not np.isfinite(quadratic_roots(1.0, 0.0, 1.0)).any()
    at_infinity, single = quadratic_roots(4.0, -2.0, 0.0)
    assert np.isinf(at_infinity) and single == 2.0
    assert not np.isfinite(quadratic_roots(1.0, 0.0, 0.0)).any()


def chains_of(solved):
    """The shapes' outlines, up along one chain and down along the other: (corner, which) and edges."""
    links, ends = np.zeros((2, LINKS, 3), np.int64), np.zeros((SHAPES, 2), np.int64)
    shapes, start = [], np.zeros(2, int)
    for k in range(connected(solved, links, ends)):
        left, right = (links[side, start[side] : ends[k, side]] for side in range(2))
        assert (left[-1, EDGE], right[-1, EDGE]) == (-1, -1)
        # Chains that begin or end at infinity have ends of their own, others share them.
        down = right[0 if right[0, CORNER] == OPEN else 1 : None if right[-1, CORNER] == OPEN else -1][::-1]
        shapes.append(np.concatenate([left, down]))
        start = ends[k]
    return shapes


def joined(vertices, crossed):
    """The outlines of corners, given as (corner, which) in ascending order of t, as 4.3 joins them.

    `crossed` are the edges that are crossed at t = -infinity.
    """
    outlines, traces = [], [[(OPEN, 0)], [(OPEN, 0)]] if crossed else []
    on = sorted(crossed)
    for vertex in vertices:
        here = {0, 1, 2} - {vertex[0]}
        if not crossed:
            traces, on = [[vertex], []], sorted(here)
        elif crossed == here:
            outlines.append(traces[0] + [vertex] + traces[1][::-1])
        else:
            side = 0 if on[0] in here else 1
            traces[side].append(vertex)
            (on[side],) = here - crossed
        crossed = crossed ^ here
    return outlines + ([traces[0] + [(OPEN, 1), (OPEN, 1)] + traces[1][::-1]] if crossed else [])


@QUICK
@given(st.sampled_from(["any", "narrow", "one plane", "pinhole", "edge on", "thin"]), SEEDS)
def test_corners_are_joined_as_the_reference_joins_them(kind, seed):
    p, n, corners, _ = scene(seed, kind)
    solved = solved_by(row_of(p, n), corners)
    found = [(corner, which) for corner in range(3) for which in range(int(solved[corner, COUNT]))]
    found.sort(key=lambda vertex: solved[vertex[0], ROOTS + ROOT * vertex[1]])
    above = solved[:, BEFORE] >= 0.0
    crossed = {edge for edge in range(3) if above[(edge + 1) % 3] != above[(edge + 2) % 3]}
    assert [shape[:, :2].tolist() for shape in chains_of(solved)] == [
        [list(vertex) for vertex in outline] for outline in joined(found, crossed)
    ]


def solved_at(*t):
    """Three corners with such roots, on one side of the plane at first."""
    solved = np.zeros((3, WORDS))
    for corner, roots in zip(solved, t, strict=True):
        corner[COUNT], corner[ROOTS : ROOTS + ROOT * len(roots) : ROOT] = len(roots), roots
    return solved


def test_two_corners_at_one_t_are_joined_in_either_order():
    for t in ([1.0], [1.0], [2.0]), ([2.0], [1.0], [1.0]):
        (one,) = chains_of(solved_at(*t))
        assert sorted(one[:, CORNER]) == [0, 1, 2]
    # The step-by-step example of section 4.3: corners 2, 3, 3, 1, 3.
    (five,) = chains_of(solved_at([4.0], [1.0], [2.0, 3.0, 5.0]))
    assert five[:, :2].tolist() in (
        [[1, 0], [0, 0], [2, 2], [2, 1], [2, 0]],
        [[1, 0], [2, 0], [2, 1], [2, 2], [0, 0]],
    )


@QUICK
@given(st.sampled_from(["any", "narrow", "pinhole"]), SEEDS)
def test_scene_edges_meet_the_sides_where_a_weight_is_zero(kind, seed):
    p, n, corners, random = scene(seed, kind)
    # The first edge (from corner 1 to 2) passes through a point of the side opposite the third ray.
    w, t = np.array([0.3, 0.7, 0.0]), random.uniform(0.5, 2.0)
    corners[2] = corners[1] + 2.0 * (w @ p + t * (w @ n) - corners[1])
    row = row_of(p, n)
    cuts = np.zeros((3, CUTS))
    side_crossings(row, solved_by(row, corners), cuts)
    assert (np.diff(cuts[np.isfinite(cuts).all(axis=1)], axis=1) >= 0.0).all()
    found = (cuts + row[SHIFT]) * row[PACE]
    assert np.abs(found[0] - t).min() < 1e-6
    for edge in range(3):
        a, b = corners[(edge + 1) % 3], corners[(edge + 2) % 3]
        for at in found[edge][np.isfinite(found[edge])]:
            r = p + at * n
            values = [np.linalg.det([b - a, r[(k + 1) % 3] - a, r[(k + 2) % 3] - a]) for k in range(3)]
            scale = [np.linalg.norm(b - a) * (1 + np.abs(r - a).max()) ** 2] * 3
            assert np.min(np.abs(values) / scale) < 1e-9


@pytest.mark.parametrize("steps", [1, 2, 5, 16])
def test_small_triangles_fill_the_whole_and_share_their_corners_to_the_bit(steps):
    corners = np.random.default_rng(steps).normal(size=(3, 3))
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    places, total = {}, np.zeros(3)
    for which in range(steps * steps):
        points, within = np.zeros((3, 3)), np.zeros((3, 2))
        small_triangle(corners, steps, which, points, within)
        area = np.cross(points[1] - points[0], points[2] - points[0])
        assert area @ normal > 0.0
        total += area
        whole = np.hstack([1.0 - within.sum(axis=1, keepdims=True), within])
        assert whole.min() > -1e-15
        assert np.abs(whole @ corners - points).max() < 1e-14
        for key, point in zip(np.rint(within * steps).astype(int).tolist(), points.tolist(), strict=True):
            assert places.setdefault(tuple(key), point) == point
    assert total == pytest.approx(normal) and len(places) == (steps + 1) * (steps + 2) // 2
    assert [list(corner) in places.values() for corner in corners] == [True] * 3
