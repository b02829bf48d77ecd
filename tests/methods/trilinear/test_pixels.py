"""Which pixels see a scene triangle, and what is handed to the device for the rays that go on from it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scenes import SIZE, open_view

from anamorph.base.compiled import compiled
from anamorph.gallery import make
from anamorph.methods.trilinear.pixels import seen_samples
from anamorph.methods.trilinear.plan import Plan
from anamorph.methods.trilinear.polygons import span
from anamorph.methods.trilinear.ray_layer import piece_corners
from anamorph.methods.trilinear.ray_records import RAY_TRIANGLE, SPECULAR, following_records
from anamorph.methods.trilinear.terms import is_inside

QUICK = settings(max_examples=60)
SEEDS = st.integers(0, 2**32 - 1)


@compiled
def _inside(terms: np.ndarray, places: np.ndarray, found: np.ndarray) -> None:
    for k in range(len(places)):
        found[k] = is_inside(terms, places[k, 0], places[k, 1])


@compiled
def _spans(polygon: np.ndarray, count: int, heights: np.ndarray, found: np.ndarray) -> None:
    for k in range(len(heights)):
        found[k, 0], found[k, 1] = span(polygon, count, heights[k])


def signs(terms: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Whether none of the three quadratics and the two linear functions is negative at places (N, 2)."""
    x, y = places.T
    square = np.stack([x * x, x * y, y * y, x, y, np.ones_like(x)])
    return (terms[:18].reshape(3, 6) @ square >= 0.0).all(axis=0) & (terms[18:].reshape(2, 3) @ square[3:] >= 0.0).all(
        axis=0
    )


@QUICK
@given(SEEDS)
def test_a_place_is_inside_where_no_term_is_negative(seed):
    random = np.random.default_rng(seed)
    terms = random.normal(size=24) * random.integers(0, 2, 24)
    terms[[5, 11, 17, 20, 23]] += 1.5
    places = random.uniform(-2.0, 2.0, (200, 2))
    found = np.zeros(len(places), bool)
    _inside(terms, places, found)
    assert (found == signs(terms, places)).all()
    assert not signs(np.where(np.arange(24) == 20, -1e9, terms), places).any()


def test_nothing_is_outside_of_its_own_border():
    found = np.zeros(2, bool)
    _inside(np.zeros(24), np.array([[0.0, 0.0], [-3.0, 4.0]]), found)
    assert found.all()
    for last in (5, 11, 17, 20, 23):
        below = np.zeros(24)
        below[last] = -1e-300
        _inside(below, np.zeros((2, 2)), found)
        assert not found.any()


@QUICK
@given(st.integers(3, 8), SEEDS)
@example(3, 0)
def test_a_line_crosses_a_convex_polygon_between_the_ends_of_its_span(count, seed):
    random = np.random.default_rng(seed)
    turn = np.sort(random.uniform(0.0, 2.0 * np.pi, count))
    polygon = np.stack([np.cos(turn), np.sin(turn)], axis=1) * random.uniform(0.1, 40.0) + random.normal(size=2)
    heights = np.linspace(polygon[:, 1].min() - 1.0, polygon[:, 1].max() + 1.0, 41)
    found = np.empty((len(heights), 2))
    _spans(np.vstack([polygon, np.full((2, 2), np.nan)]), count, heights, found)
    start, stop = polygon, np.roll(polygon, -1, axis=0)
    for y, (low, high) in zip(heights, found, strict=True):
        crossed = (start[:, 1] <= y) != (stop[:, 1] <= y)
        if not crossed.any():
            assert low == np.inf and high == -np.inf
            continue
        share = (y - start[crossed, 1]) / (stop[crossed, 1] - start[crossed, 1])
        x = start[crossed, 0] + share * (stop[crossed, 0] - start[crossed, 0])
        assert (low, high) == pytest.approx((x.min(), x.max()), abs=1e-9)


def plan_of(random: np.random.Generator, pairs: int) -> Plan:
    """Pairs whose quadratics are of discs and half-planes, with up to three pieces each: the fan of a quadrangle."""
    terms = np.zeros((pairs, 24))
    terms[:, [0, 2]] = -1.0
    terms[:, 5] = random.uniform(1.0, 60.0, pairs)
    terms[:, 6:18] = 0.0
    terms[:, 9:11] = random.normal(size=(pairs, 2))
    terms[:, [11, 17, 20, 23]] = 2.0
    places, owner = [], []
    for pair in range(pairs):
        half = random.uniform(0.2, 12.0)
        corners = half * np.array([[-1.0, -1.0], [1.0, -0.7], [0.9, 1.0], [-0.8, 1.1]]) + random.normal(size=2)
        places += [corners[[0, 1, 2]], corners[[0, 2, 3]]][: random.integers(0, 3)]
        owner += [pair] * (len(places) - len(owner))
    faces = np.column_stack([np.zeros(pairs), np.arange(pairs), np.ones(pairs)]).astype(np.int32)
    return Plan(faces, terms, np.array(places, np.float32).reshape(-1, 3, 2), np.array(owner, np.int32))


@QUICK
@given(SEEDS)
def test_pixels_are_those_whose_middle_sees_the_triangle(seed):
    random = np.random.default_rng(seed)
    plan = plan_of(random, 12)
    chosen = np.sort(random.choice(12, 7, replace=False))
    box, count = seen_samples(plan, chosen)
    x, y = np.meshgrid(np.arange(-40, 40) + 0.5, np.arange(-40, 40) + 0.5)
    middles = np.stack([x.ravel(), y.ravel()], axis=1)
    for row, pair in enumerate(chosen):
        seen, twice = np.zeros(len(middles), bool), 0
        for a, b, c in plan.place[plan.owner == pair].astype(float):
            sides = [(middles - p) @ [p[1] - q[1], q[0] - p[0]] for p, q in ((a, b), (b, c), (c, a))]
            within = (np.array(sides) >= 0.0).all(axis=0) & signs(plan.terms[pair], middles)
            seen, twice = seen | within, twice + int(within.sum())
        assert abs(count[row] - twice) <= 2
        if count[row] and seen.sum() == twice == count[row]:
            assert (box[row] == [*middles[seen].min(axis=0), *middles[seen].max(axis=0)]).all()
        if not count[row]:
            assert (box[row] == [np.inf, np.inf, -np.inf, -np.inf]).all()


@pytest.fixture(scope="module")
def sights():
    """What two layers see between facing mirrors."""
    scene = make("facing-mirrors")
    session = open_view(scene, "trilinear", SIZE)
    session.draw(scene.camera)
    held = session.diagnostics()
    return held["layers"], held["triangles"]


def test_following_rays_know_what_they_follow_and_how_light_came(sights):
    (first, second), world = sights
    records = second.records
    shown = records[records["number"] > 0]
    assert len(shown) > 0 and (records["number"][records["number"] > 0] == np.flatnonzero(records["number"]) + 1).all()
    sources = {source["number"]: source for source in first.records}
    seen = set(zip(first.pairs["ray_triangle"].tolist(), first.pairs["seen"].tolist(), strict=True))
    for record in shown:
        source = sources[record["before"]]
        # Through the front of a mirror, which is the triangle that sends them on.
        assert record["through"] == (record["face"] + 1) | SPECULAR
        assert (record["before"], record["through"]) in seen
        assert world.mirror[record["face"]] and record["object"] == world.object[record["face"]]
        assert record["first"] == source["object"] != record["object"]
    # The direction before the mirror is that of the rays which come to it, wherever its own center is.
    for record in shown[:20]:
        source = sources[record["before"]]
        place = np.array([100.0, 60.0])
        here, there = ((place - [each["center_x"], each["center_y"]]) for each in (record, source))
        incident = here[0] * record["incident_x"] + here[1] * record["incident_y"] + record["incident_one"]
        before = there[0] * source["direction_x"] + there[1] * source["direction_y"] + source["direction_one"]
        assert incident == pytest.approx(before, rel=1e-3, abs=1e-4 * np.linalg.norm(before))


def test_what_follows_nothing_shown_stays_blank(sights):
    (first, second), _ = sights
    chosen = np.flatnonzero(first.plan.pair[:, 2] == 1)[:3]
    nobody = second.beams._replace(
        **{name: getattr(second.beams, name)[:0] for name in ("number", "center", "direction")}
    )
    found = following_records(
        np.zeros(3, RAY_TRIANGLE), nobody, first.beams, first.plan, first.records, first.pairs, chosen
    )
    assert (found["before"] > 0).all() and (found["through"] == first.pairs["seen"][chosen]).all()
    assert not found["number"].any() and not found["incident_x"].any()


def test_following_rays_are_drawn_where_the_pieces_of_their_pairs_are():
    random = np.random.default_rng(7)
    plan = plan_of(random, 9)
    records = np.zeros(4, RAY_TRIANGLE)
    records["number"], records["face"] = [1, 0, 3, 4], [10, 11, 12, 13]
    chosen = np.array([1, 3, 4, 7])

    class Beams:
        center = np.array([[5.0, -2.0]])

    drawn = piece_corners(records, Beams, plan, chosen)
    expected = [
        (piece, row) for piece, owner in enumerate(plan.owner) for row in range(4) if chosen[row] == owner and row != 1
    ]
    assert len(drawn) == len(expected) > 0
    for record, (piece, row) in zip(drawn, expected, strict=True):
        assert record["face"] == 10 + row
        for corner in range(3):
            assert record[f"corner_{corner}"] == pytest.approx([*(plan.place[piece, corner] + Beams.center[0]), 1.0])
