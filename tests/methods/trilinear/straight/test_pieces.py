"""Straight-edged pieces of scene triangles in ray triangles, against the exact image and the shapes of the thesis."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from ray_triangles import EXACT, ROUNDED, examples, scene

from anamorph.base.errors import AnamorphError
from anamorph.methods.trilinear import straight
from anamorph.methods.trilinear.straight import bulk, fill, project_triangle, straight_pieces
from anamorph.methods.trilinear.straight.cutting import GUARD

PLAIN = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]])
"""An image in which places are u and v."""

ONE = np.zeros((1, 2), int)
QUICK = settings(max_examples=40, phases=(Phase.explicit, Phase.generate))
SEEDS = st.integers(0, 2**32 - 1)


def pieces_of(p, n, corners, image=PLAIN, **options):
    return straight_pieces(image[None], p[None], n[None], corners[None], ONE, **options)


def seen_exactly(image, p, n, corners, places, near=0.0):
    """Where the triangle is seen at places (N, 2) inside a ray triangle: the signs of three quadratics; t as well."""
    w = np.linalg.inv(image).T @ np.vstack([places.T, np.ones(len(places))])
    o, d, s = w.T @ p, w.T @ n, w.sum(axis=0)[:, None]
    a, b, c = corners
    edges = [np.sum(d * np.cross(x * s - o, y - x), axis=1) for x, y in ((a, b), (b, c), (c, a))]
    normal = np.cross(b - a, c - a)
    along = d @ normal
    # A ray within the triangle's plane meets it at no t of its own.
    along = np.where(np.abs(along) > 1e-4 * np.linalg.norm(normal), along, np.nan)
    t = np.sum((a * s - o) * normal, axis=1) / along
    return np.all(np.array(edges) * np.sign(along) >= 0.0, axis=0) & (t >= near), t


def covered(pieces, places):
    """Where places (N, 2) lie in some piece."""
    a, b, c = np.moveaxis(pieces.place.astype(float)[:, :, None], 1, 0)

    def side(x, y):
        return (y - x)[..., 0] * (places - x)[..., 1] - (y - x)[..., 1] * (places - x)[..., 0]

    sides = np.array([side(a, b), side(b, c), side(c, a)])
    return ((sides >= 0.0).all(axis=0) | (sides <= 0.0).all(axis=0)).any(axis=0)


def drawn_in(image, random, count):
    """Random places in a ray triangle's image."""
    weights = random.dirichlet([1.0, 1.0, 1.0], count)
    corners = image[:, :2] / image[:, 2:]
    return weights @ corners


def wrong(p, n, corners, image=PLAIN, count=2000, near=0.0, **options):
    """The share of the ray triangle's image that the pieces have wrong."""
    places = drawn_in(image, np.random.default_rng(0), count)
    pieces = pieces_of(p, n, corners, image, near=near, **options)
    return np.mean(covered(pieces, places) != seen_exactly(image, p, n, corners, places, near)[0])


def cut_to_triangle(polygon):
    """What of a polygon (N, 2) lies where u, v and 1 - u - v are not negative."""
    for line in (lambda x: x[0], lambda x: x[1], lambda x: 1.0 - x[0] - x[1]):
        kept = []
        for x, y in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
            if line(x) >= 0.0:
                kept.append(x)
            if (line(x) >= 0.0) != (line(y) >= 0.0):
                kept.append(x + line(x) / (line(x) - line(y)) * (y - x))
        polygon = np.array(kept).reshape(-1, 2)
    return polygon


def area(polygon):
    x, y = polygon.T
    return 0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)


@QUICK
@given(st.sampled_from(["any", "narrow", "thin"]), SEEDS, st.sampled_from([0.0, 0.5, -100.0]))
def test_shapes_of_three_corners_are_filled_up_to_straight_edges(kind, seed, near):
    p, n, corners, _ = scene(seed, kind)
    shapes = project_triangle(p, n, corners, near)
    if not all(len(s) <= 3 and (s.valid & (np.abs(s.u) + np.abs(s.v) < 1e3)).all() for s in shapes):
        return
    outlines = [np.stack([shape.u, shape.v], axis=1) for shape in shapes]
    pieces = pieces_of(p, n, corners, near=near, scene_clip=False)
    filled = sum(area(cut_to_triangle(piece)) for piece in pieces.place.astype(float))
    assert -filled == pytest.approx(sum(area(cut_to_triangle(outline)) for outline in outlines), abs=2e-5)


def test_every_corner_of_a_shape_of_seven_is_a_corner_of_its_pieces():
    numbers = np.array(examples()["2,7"], float)
    corners, p, n = numbers[:, :3], numbers[:, 3:6], numbers[:, 6:9]
    shape = max(project_triangle(p, n, corners, 1e-3), key=len)
    pieces = pieces_of(p, n, corners, near=1e-3, scene_clip=False)
    places = pieces.place.reshape(-1, 2)
    for place in np.stack([shape.u, shape.v], axis=1):
        assert np.abs(places - place).max(axis=1).min() < 1e-5
    # Joined in the order of t without points on the other chain, they would spill over its hollows.
    assert wrong(p, n, corners, near=1e-3, scene_clip=False) < 0.02


@pytest.mark.parametrize("label", [*EXACT, *ROUNDED])
def test_the_examples_of_the_thesis_come_out_exact_when_divided_finely(label):
    numbers = np.array(examples()[label], float)
    corners, p, n = numbers[:, :3], numbers[:, 3:6], numbers[:, 6:9]
    for option in ("tessellate", "slices"):
        off = [wrong(p, n, corners, near=1e-3, **{option: factor}) for factor in (1, 4, 16)]
        assert off[1] <= off[0] and off[2] <= 0.3 * off[0] + 5e-4


@pytest.mark.parametrize(
    ("options", "most"),
    [
        ({"scene_clip": False}, 0.1),
        ({}, 0.01),
        ({"slices": 12, "scene_clip": False}, 0.006),
        ({"slices": 48}, 3e-4),
        ({"tessellate": 8}, 0.003),
        ({"tessellate": 32}, 5e-4),
    ],
)
def test_curved_rays_see_triangles_as_they_are_but_for_the_straightness_of_edges(options, most):
    off = []
    for seed in range(60):
        p, n, corners, _ = scene(seed, "narrow")
        corners[:, 2] += 4.0
        off.append(wrong(p, n, corners, count=500, **options))
    assert np.mean(off) < most


def test_weights_and_t_on_the_pieces_are_those_of_the_scene_triangle():
    met = 0
    for seed in range(20):
        p, n, corners, _ = scene(seed, "narrow")
        if seed % 2:
            # Rays with a narrow waist, from which the frame's t counts.
            p = 0.05 * p - 2.0 * n
        corners[:, 2] += 4.0
        pieces = pieces_of(p, n, corners, slices=6)
        places, weights = pieces.place.reshape(-1, 2).astype(float), pieces.weights.reshape(-1, 2).astype(float)
        inside = (places.min(axis=1) > 0.0) & (places.sum(axis=1) < 1.0)
        _, t = seen_exactly(PLAIN, p, n, corners, places)
        inside &= np.isfinite(t)
        t = t[inside]
        assert pieces.t.ravel()[inside] == pytest.approx(t, rel=1e-3)
        whole = np.hstack([1.0 - places.sum(axis=1, keepdims=True), places])[inside]
        points = whole @ p + t[:, None] * (whole @ n)
        on = np.hstack([1.0 - weights.sum(axis=1, keepdims=True), weights])[inside] @ corners
        assert np.abs(points - on).max(initial=0.0) < 1e-3
        assert weights.min(initial=0.0) > -1e-6 and weights.sum(axis=1).max(initial=0.0) < 1.0 + 1e-6
        met += inside.sum()
    assert met > 100


def on_the_border(pieces):
    """The stretches of y that pieces cover of the line x = 0, as ends ascending."""
    stretches = []
    for piece in pieces.place.astype(float):
        piece[np.abs(piece[:, 0]) < 1e-7, 0] = 0.0
        ys = list(piece[piece[:, 0] == 0.0, 1])
        for a, b in zip(piece, np.roll(piece, -1, axis=0), strict=True):
            if a[0] * b[0] < 0.0:
                ys.append(a[1] + a[0] / (a[0] - b[0]) * (b[1] - a[1]))
        if len(ys) > 1 and max(ys) > 0.0 and min(ys) < 1.0:
            stretches.append((min(ys), max(ys)))
    ends = []
    for low, high in sorted(stretches):
        if ends and low <= ends[-1] + 1e-6:
            ends[-1] = max(ends[-1], high)
        else:
            ends += [low, high]
    return np.clip(ends, 0.0, 1.0)


def test_pieces_of_neighbours_meet_at_their_common_border_if_cut_in_the_scene():
    left = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [-1.0, 0.5, 1.0]])
    right = left * [-1.0, 1.0, 1.0]
    met, apart = 0, 0
    for seed in range(60):
        p, n, corners, random = scene(seed, "narrow")
        corners = 2.0 * corners + [0.0, 0.0, 4.0]
        q, m = p.copy(), n.copy()
        q[2], m[2] = random.normal(size=3), [0.0, 0.0, 1.0] + 0.4 * random.normal(size=3)
        for clip in (True, False):
            one = on_the_border(pieces_of(p, n, corners, left, scene_clip=clip))
            other = on_the_border(pieces_of(q, m, corners, right, scene_clip=clip))
            same = len(one) == len(other) and np.abs(one - other).max(initial=0.0) <= 1e-6
            if clip:
                assert same
                met += len(one) > 0
            else:
                apart += not same
    assert met > 30 and apart > 20


def test_what_lies_before_near_is_left_out():
    for seed in range(30):
        p, n, corners, _ = scene(seed, "any")
        for near in (0.0, 0.7):
            pieces = pieces_of(p, n, corners, near=near, slices=3)
            assert pieces.t.min(initial=near) >= near - 1e-6
            assert wrong(p, n, corners, near=near, slices=12) < 0.03


@pytest.mark.parametrize("kind", ["pinhole", "parallel", "focus", "slit"])
def test_degenerate_rays_see_what_is_there(kind):
    """A pinhole, parallel rays and a focus have straight images: nothing but rounding is wrong."""
    seen = 0
    for seed in range(60):
        p, n, corners, random = scene(seed, "narrow")
        if kind == "pinhole":
            p = p[0] + 0.0 * p
        if kind == "parallel":
            n = n[0] + 0.0 * n
        if kind == "focus":
            p = p[0] - 2.0 * n
        if kind == "slit":
            p = np.outer(random.normal(size=3), [1.0, 0.0, 0.0]) - 2.0 * n
        corners = 2.0 * corners + p.mean(axis=0) + 2.0 * n.mean(axis=0) * (seed % 2)
        pieces = pieces_of(p, n, corners)
        assert np.isfinite(pieces.place).all() and np.isfinite(pieces.t).all()
        off = wrong(p, n, corners, count=400, slices=16 if kind == "slit" else 0)
        assert off <= (0.05 if kind == "slit" else 0.0), seed
        seen += len(pieces.t) > 0
    assert seen > 25


def test_rays_parallel_to_one_plane_see_shapes_that_reach_infinity():
    p = np.array([[0.0, 0.0, 0.0], [0.1, 1.0, 0.0], [-0.1, 0.5, 0.1]])
    n = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.5], [-0.6, 0.0, 0.7]])
    random = np.random.default_rng(0)
    off = [wrong(p, n, 3.0 * random.normal(size=(3, 3)), count=400) for _ in range(40)]
    assert np.mean(off) < 0.02


def test_rays_without_a_triangle_between_them_see_nothing():
    p, n, corners, _ = scene(0)
    assert len(pieces_of(p[[0, 0, 1]], n[[0, 0, 1]], corners).t) == 0


@QUICK
@given(SEEDS, st.integers(0, 3), st.integers(1, 3), st.booleans())
def test_pieces_stay_in_the_neighbourhood_of_their_ray_triangle(seed, slices, tessellate, behind):
    p, n, corners, random = scene(seed, "any")
    image = np.hstack([random.uniform(0, 50, (3, 2)), np.ones((3, 1))]) * random.uniform(0.5, 3.0, (3, 1))
    if behind:
        image[0] *= -1.0
    pieces = pieces_of(p, n, corners, image, slices=slices, tessellate=tessellate)
    assert np.isfinite(pieces.place).all() and np.isfinite(pieces.weights).all() and np.isfinite(pieces.t).all()
    if not behind:
        shares = np.linalg.solve(
            (image / image[:, 2:]).T, np.vstack([pieces.place.reshape(-1, 2).T, np.ones(pieces.t.size)])
        )
        assert shares.min(initial=0.0) >= -GUARD - 1e-2
        assert wrong(p, n, corners, image, count=300, slices=40) < 0.05


def test_many_pairs_are_drawn_as_one_by_one_in_their_order_on_any_number_of_cores(monkeypatch):
    random = np.random.default_rng(3)
    p, n, corners = random.normal(size=(3, 6, 3, 3))
    image = np.tile(PLAIN, (6, 1, 1))
    pairs = np.argwhere(np.ones((6, 6)))
    options = {"tessellate": 2, "slices": 1}
    together = straight_pieces(image, p, n, corners, pairs, **options)
    monkeypatch.setattr(bulk, "GRAIN", 5)
    parts = straight_pieces(image, p, n, corners, pairs, **options)
    for name in ("place", "weights", "t", "pair"):
        assert (getattr(together, name) == getattr(parts, name)).all()
    assert (np.diff(together.pair) >= 0).all()
    for k, (ray, triangle) in enumerate(pairs):
        alone = pieces_of(p[ray], n[ray], corners[triangle], **options)
        assert (together.place[together.pair == k] == alone.place).all()


def test_small_buffers_are_filled_one_after_the_other(monkeypatch):
    p, n, corners, _ = scene(2, "narrow")
    whole = pieces_of(p, n, corners, tessellate=12, slices=30)
    monkeypatch.setattr(fill, "USUAL", 0)
    assert (pieces_of(p, n, corners, tessellate=12, slices=30).place == whole.place).all()


def test_nothing_to_draw_is_no_pieces():
    none = straight_pieces(PLAIN[None], PLAIN[None], PLAIN[None], PLAIN[None], np.zeros((0, 2), int))
    assert none.place.shape == (0, 3, 2) and none.weights.shape == (0, 3, 2) and none.t.shape == (0, 3)
    assert none.pair.shape == (0,) and none.place.dtype == none.weights.dtype == none.t.dtype == np.float32
    nowhere = np.zeros((0, 3, 3))
    assert len(straight_pieces(nowhere, nowhere, nowhere, nowhere, np.zeros((0, 2), int)).t) == 0
    assert none.pair.dtype == np.int32


def test_rays_without_a_direction_are_refused_in_one_line():
    with pytest.raises(AnamorphError, match="all three directions are 0") as raised:
        pieces_of(PLAIN, np.zeros((3, 3)), PLAIN)
    assert "\n" not in str(raised.value)


def test_one_module_of_the_method_takes_the_room():
    own = Path(straight.__file__).parent
    others = [module for module in own.parent.glob("*.py") if "trilinear.straight" in module.read_text()]
    assert [module.name for module in others] == ["trilinear.py"]
