"""Scene triangles projected into ray triangles: the thesis's seven examples, and what must hold of every shape."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import Phase, example, given, settings
from hypothesis import strategies as st
from ray_triangles import EXACT, ROUNDED, examples, scene

from anamorph.base.errors import AnamorphError
from anamorph.methods.trilinear.straight import project_triangle
from anamorph.methods.trilinear.straight.traces import edge_weight
from anamorph.raytriangle import project_points


def counts(numbers):
    """The numbers of vertices of an example's shapes, ascending."""
    return sorted(len(shape) for shape in project_triangle(numbers[:, 3:6], numbers[:, 6:9], numbers[:, :3]))


@pytest.mark.parametrize("label", EXACT)
def test_the_examples_have_the_shapes_of_their_labels(label):
    assert counts(np.array(examples()[label], float)) == EXACT[label]


@pytest.mark.parametrize("label", ROUNDED)
def test_two_labels_hold_for_numbers_that_round_to_the_printed_ones(label):
    texts = examples()[label]
    printed, labelled = ROUNDED[label]
    numbers = np.array(texts, float)
    assert counts(numbers) == printed
    # Scene numbers have three significant digits, view numbers two decimals.
    half = np.full(numbers.shape, 0.005)
    half[:, :3] = 0.5 * 10.0 ** (np.floor(np.log10(np.abs(numbers[:, :3]))) - 2.0)
    random = np.random.default_rng(1)
    drawn = [counts(numbers + half * random.uniform(-1, 1, numbers.shape)) for _ in range(200)]
    assert 0.08 < np.mean([count == labelled for count in drawn]) < 0.4


def outline(shape):
    """Each vertex with the one after it and the scene edge between them."""
    return zip(range(len(shape)), np.roll(np.arange(len(shape)), -1), shape.edges, strict=True)


def point_of(p, n, shape):
    w = np.stack([1.0 - shape.u - shape.v, shape.u, shape.v], axis=-1)
    return w @ p + shape.t[:, None] * (w @ n)


KINDS = st.sampled_from(["any", "narrow", "one plane", "pinhole", "edge on", "thin"])
SEEDS = st.integers(0, 2**32 - 1)
QUICK = settings(max_examples=60, phases=(Phase.explicit, Phase.generate))


@QUICK
@given(KINDS, SEEDS)
@example("one plane", 66965)
def test_shapes_hold_every_projected_corner_once_and_run_along_scene_edges(kind, seed):
    p, n, corners, _ = scene(seed, kind)
    shapes = project_triangle(p, n, corners)
    found = project_points(p, n, corners)
    placed = np.concatenate([np.zeros(0), *(shape.t for shape in shapes)])
    assert np.sort(placed[np.isfinite(placed)]) == pytest.approx(np.sort(found.t[found.real]), abs=0)
    if kind in ("any", "narrow", "thin"):
        assert len(placed) in (3, 5, 7, 9) and 1 <= len(shapes) <= 4
    for shape in shapes:
        # Rays parallel to one plane add where a shape passes through infinity.
        assert len(shape) >= 2 and np.isfinite(shape.t).sum() <= 9
        assert np.isfinite(shape.u).all() and np.isfinite(shape.v).all()
        assert shape.weights.sum(axis=1) == pytest.approx(np.ones(len(shape)))
        assert (shape.valid <= np.isfinite(shape.t)).all()
        off = (point_of(p, n, shape) - shape.weights @ corners)[shape.valid]
        assert np.abs(off).max(initial=0.0) <= 1e-8 * (1.0 + np.abs(p).max() + np.abs(corners).max())
        lowest, highest = shape.t.argmin(), shape.t.argmax()
        steps = [np.sign(shape.t[k] - shape.t[j]) for j, k, edge in outline(shape) if edge >= 0]
        assert sum(a != b for a, b in zip(steps, steps[1:] + steps[:1], strict=True)) <= 2 or len(set(steps)) == 3
        assert shape.t[lowest] <= shape.t[highest]
        for j, k, edge in outline(shape):
            if edge >= 0:
                assert shape.weights[j, edge] == shape.weights[k, edge] == 0.0
            else:
                assert np.isinf(shape.t[[j, k]]).all()


@QUICK
@given(st.sampled_from(["any", "narrow", "one plane", "pinhole"]), SEEDS)
def test_a_point_of_the_scene_triangle_is_seen_at_a_t_of_a_shape_and_the_edges_cross_there(kind, seed):
    p, n, corners, random = scene(seed, kind)
    shapes = project_triangle(p, n, corners)
    found = project_points(p, n, random.dirichlet([1.0, 1.0, 1.0], 30) @ corners)
    ranges = [(shape.t.min(), shape.t.max()) for shape in shapes]
    for t in found.t[found.valid]:
        assert any(low - 1e-7 * (1 + abs(t)) <= t <= high + 1e-7 * (1 + abs(t)) for low, high in ranges)
    # Halfway through a shape the plane of the parametric triangle cuts the scene triangle.
    for low, high in ranges:
        t = 0.5 * (max(low, -1e3) + min(high, 1e3))
        a, b, c = p + t * n
        sides = (corners - a) @ np.cross(b - a, c - a)
        if kind != "pinhole" and low < t < high:
            assert sides.min() <= 1e-9 * np.abs(sides).max() and sides.max() >= -1e-9 * np.abs(sides).max()


@QUICK
@given(st.sampled_from(["any", "narrow", "one plane", "thin"]), SEEDS, st.sampled_from([0.0, 0.1, -0.5, 2.0]))
def test_the_view_plane_cuts_shapes_on_the_scene_triangles_edges(kind, seed, nearest):
    p, n, corners, _ = scene(seed, kind)
    whole = project_triangle(p, n, corners)
    clipped = project_triangle(p, n, corners, nearest)
    assert len(clipped) == sum(shape.t.max() >= nearest for shape in whole)
    for before, after in zip((shape for shape in whole if shape.t.max() >= nearest), clipped, strict=True):
        assert (after.t >= nearest).all()
        kept = before.t[before.t >= nearest]
        cut = ~np.isin(after.t, kept)
        assert len(after) - cut.sum() == len(kept)
        assert cut.sum() == 2 * (len(kept) < len(before))
        off = (point_of(p, n, after) - after.weights @ corners)[after.valid]
        assert np.abs(off).max(initial=0.0) <= 1e-8 * (1.0 + np.abs(p).max() + np.abs(corners).max())
        for j, k, edge in outline(after):
            if edge >= 0:
                assert after.weights[j, edge] == after.weights[k, edge] == 0.0
            else:
                assert np.isinf(after.t[[j, k]]).all() or (cut[j] and cut[k])


def test_a_pinhole_sees_a_triangle_as_a_triangle_and_cuts_it_before_its_eye():
    eye, n = np.zeros((3, 3)), np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]])
    corners = np.array([[0.2, 0.4, 2.0], [1.0, 0.0, 4.0], [0.0, 0.3, 1.0]])
    (shape,) = project_triangle(eye, n, corners)
    order = shape.weights.argmax(axis=1)
    assert (shape.t == corners[order, 2]).all() and sorted(order) == [0, 1, 2]
    assert np.stack([shape.u, shape.v], axis=1) == pytest.approx((corners[:, :2] / corners[:, 2:])[order])
    corners[2, 2] = -1.0
    (cut,) = project_triangle(eye, n, corners, 0.5)
    assert len(cut) == 4 and (cut.t == 0.5).sum() == 2 and cut.valid.all()
    assert project_triangle(eye, n, corners - [0, 0, 10], 0.5) == ()


def test_rays_parallel_to_one_plane_lead_to_shapes_that_reach_infinity():
    # Horizontal rays, turning as they rise; the parametric triangle's plane tends to a level one.
    p = np.array([[0.0, 0.0, 0.0], [0.1, 1.0, 0.0], [-0.1, 0.5, 0.1]])
    n = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.5], [-0.6, 0.0, 0.7]])
    seen = 0
    random = np.random.default_rng(0)
    for _ in range(40):
        corners = random.normal(size=(3, 3)) * 3.0
        for shape in project_triangle(p, n, corners):
            infinite = np.isinf(shape.t)
            assert infinite.sum() in (0, 2, 4) and not shape.valid[infinite].any()
            assert (shape.edges == -1).sum() == infinite.sum() // 2
            seen += infinite.any()
        for shape in project_triangle(p, n, corners, 0.0):
            assert (shape.t >= 0.0).all()
    assert seen > 10


def test_an_edge_within_the_view_plane_is_cut_in_its_middle():
    assert edge_weight(0.0, 0.0) == 0.5
    assert edge_weight(-1.0, 3.0) == 0.75


def test_rays_with_no_triangle_between_them_and_bad_input():
    # Equal but for rounding, of which the sides of the corners are then made.
    for seed in range(40):
        p, n, corners, random = scene(seed)
        p[1], n[1] = p[0] + 5e-15 * random.normal(size=3), n[0] + 5e-15 * random.normal(size=3)
        assert project_triangle(p, n, corners) == ()
    with pytest.raises(AnamorphError, match="three rows of three"):
        project_triangle(p, n, corners[:2])
    with pytest.raises(AnamorphError, match="finite"):
        project_triangle(p, n, corners * np.nan)
