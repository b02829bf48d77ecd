"""The compiled parts of straight-edged drawing, against the ones that they repeat for many at once."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from ray_triangles import EXACT, KINDS, NEARLY, ROUNDED, examples, points_for, ray_triangle, scene

from anamorph.methods.trilinear.straight.chains import CORNER, EDGE, LINKS, OPEN, SHAPES, connected
from anamorph.methods.trilinear.straight.connect import FIRST, LAST, connect
from anamorph.methods.trilinear.straight.grid import small_triangle
from anamorph.methods.trilinear.straight.remembered import memory, solve_once
from anamorph.methods.trilinear.straight.shapes import project_triangle
from anamorph.methods.trilinear.straight.traces import CUTS, side_crossings
from anamorph.raytriangle.coefficients import ray_triangle_frame
from anamorph.raytriangle.cubic import real_roots
from anamorph.raytriangle.packed import PACE, SHIFT, packed
from anamorph.raytriangle.points import project_into
from anamorph.raytriangle.roots import cubic_roots, quadratic_roots
from anamorph.raytriangle.solve import BEFORE, COUNT, FAR, NOWHERE, ROOT, ROOTS, VALID, WORDS, solve_point

SEEDS = st.integers(0, 2**32 - 1)
QUICK = settings(max_examples=150, phases=(Phase.explicit, Phase.generate))


def row_of(p, n):
    return packed(ray_triangle_frame(p[None], n[None]), np.eye(3)[None])[0]


def solved_by(row, points):
    solved = np.zeros((len(points), WORDS))
    for k, (x, y, z) in enumerate(points):
        solve_point(row, x, y, z, np.zeros(8), solved[k])
    return solved


def roots_of(row, solved):
    """t, u, v and what is known of each root."""
    roots = solved[ROOTS:].reshape(3, ROOT)[: int(solved[COUNT])].copy()
    roots[:, 0] = (roots[:, 0] + row[SHIFT]) * row[PACE]
    return roots


@QUICK
@given(st.sampled_from(KINDS), st.sampled_from(NEARLY), SEEDS)
def test_a_point_is_solved_as_many_are_at_once_degenerate_ray_triangles_included(kind, nearly, seed):
    random = np.random.default_rng(seed)
    p, n = ray_triangle(kind, nearly, random)
    points = points_for(p, n, nearly, random)
    frame, row = ray_triangle_frame(p, n), row_of(p, n)
    many = project_into(frame, points)
    for k, solved in enumerate(solved_by(row, points)):
        roots = roots_of(row, solved)
        assert len(roots) == many.real[k].sum()
        assert (np.diff(roots[:, 0]) >= 0.0).all()
        # Where rays touch their envelope, rounding moves t, u and v, but no ray off the point.
        w = np.stack([1.0 - roots[:, 1] - roots[:, 2], roots[:, 1], roots[:, 2]], axis=1)
        off = np.linalg.norm(w @ p + roots[:, :1] * (w @ n) - points[k], axis=1)
        middle = p.mean(axis=0)
        size = max(np.linalg.norm(points[k] - middle), np.linalg.norm(p - middle, axis=1).max())
        allowed = 2e-9 * size + 1e-14 * np.abs(p).max() * (1.0 + np.abs(w).max(axis=1))
        assert ((off <= allowed) | (roots[:, 3] != VALID)).all()
        assert set(roots[:, 3]) <= {NOWHERE, FAR, VALID}


@QUICK
@given(st.sampled_from(["any", "narrow", "pinhole"]), SEEDS)
def test_points_in_general_position_have_the_same_roots_to_rounding(kind, seed):
    p, n, _, random = scene(seed, kind)
    points = random.normal(size=(20, 3)) * 2.0
    frame, row = ray_triangle_frame(p, n), row_of(p, n)
    many = project_into(frame, points)
    for k, solved in enumerate(solved_by(row, points)):
        roots, real = roots_of(row, solved), many.real[k]
        apart = np.abs(np.diff(roots[:, 0])).min(initial=1.0)
        if apart > 1e-2 and np.abs(roots[:, :3]).max() < 1e3:
            assert roots[:, 0] == pytest.approx(many.t[k, real], rel=1e-9, abs=1e-9)
            assert roots[:, 1] == pytest.approx(many.u[k, real], rel=1e-7, abs=1e-7)
            assert roots[:, 2] == pytest.approx(many.v[k, real], rel=1e-7, abs=1e-7)
            assert ((roots[:, 3] == VALID) == many.valid[k, real]).all()


@QUICK
@given(SEEDS, st.sampled_from([0.0, 1e-15, 1e-3]))
def test_cubics_of_every_degree_have_the_roots_that_many_at_once_have(seed, noise):
    random = np.random.default_rng(seed)
    roots = random.choice([0.0, 0.5, -2.0, 1e-3, 1e4, -1.0, 1.0], 3) * random.choice([1.0, random.normal()], 3)
    cubics = [np.poly(roots)[::-1], random.normal(size=4), random.normal(size=4) * random.integers(0, 2, 4)]
    cubics += [np.array([1.0, -2.0, 1.0, 0.0]), np.zeros(4), np.array([0.0, 0.0, 3.0, 0.0])]
    for cubic in cubics:
        found = np.zeros(8)
        many, real = real_roots(cubic[None], np.array([noise]), np.array([1e10]))
        count = cubic_roots(tuple(cubic), noise, 1e10, found)
        assert count == real.sum()
        assert found[:count] == pytest.approx(many[0, :count], rel=1e-6, abs=1e-9)


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


@QUICK
@given(st.sampled_from(["any", "narrow", "one plane", "pinhole", "edge on", "thin"]), SEEDS)
def test_corners_are_joined_as_the_reference_joins_them(kind, seed):
    p, n, corners, _ = scene(seed, kind)
    solved = solved_by(row_of(p, n), corners)
    found = [(corner, which) for corner in range(3) for which in range(int(solved[corner, COUNT]))]
    found.sort(key=lambda vertex: solved[vertex[0], ROOTS + ROOT * vertex[1]])
    outlines = connect(found, solved[:, BEFORE] >= 0.0)
    shapes = chains_of(solved)
    assert len(shapes) == len(outlines)
    for shape, outline in zip(shapes, outlines, strict=True):
        named = [
            vertex if vertex[0] not in (FIRST, LAST) else (OPEN, int(vertex[0] == LAST)) for vertex in outline.vertices
        ]
        assert [(corner, 0 if corner == OPEN and not which else which) for corner, which, _ in shape.tolist()] == named


@pytest.mark.parametrize("label", [*EXACT, *ROUNDED])
def test_the_examples_of_the_thesis_have_the_shapes_of_the_reference(label):
    numbers = np.array(examples()[label], float)
    p, n, corners = numbers[:, 3:6], numbers[:, 6:9], numbers[:, :3]
    counts = [len(shape) for shape in chains_of(solved_by(row_of(p, n), corners))]
    assert counts == [len(shape) for shape in project_triangle(p, n, corners)]
    assert sorted(counts) == (EXACT[label] if label in EXACT else ROUNDED[label][0])


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


def test_what_is_remembered_is_what_was_found_for_that_point_and_that_ray_triangle():
    random = np.random.default_rng(1)
    rows = [row_of(*random.normal(size=(2, 3, 3))) for _ in range(3)]
    points = np.concatenate([random.normal(size=(700, 3)), random.integers(-3, 4, (300, 3)).astype(float)])
    kept, solved = memory(), np.zeros(WORDS)
    for _ in range(2):
        for owner, row in enumerate(rows):
            for point, fresh in zip(points, solved_by(row, points), strict=True):
                solve_once(row, owner, point, point.view(np.int64), kept, solved)
                used = ROOTS + ROOT * int(fresh[COUNT])
                assert (solved[:used] == fresh[:used]).all()
    cells = len(set(map(tuple, kept.point.tolist())))
    assert cells > 200
