"""Rays that go on from a mirror: exact among flat ones, and wrong by the square of the size among others."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import Phase, example, given, settings
from hypothesis import strategies as st

from anamorph.base.errors import AnamorphError
from anamorph.base.steps import drain
from anamorph.methods.trilinear.beams import making_beams
from anamorph.methods.trilinear.box_tree import make_tree
from anamorph.methods.trilinear.following import following_rays
from anamorph.methods.trilinear.pairs import ALL, Own
from anamorph.methods.trilinear.plan import Plan, Planner
from anamorph.methods.trilinear.samples import LEAST_EXTENT, OUTSIDE, samples

SIZE = (400, 400)
QUICK = settings(max_examples=60, phases=(Phase.explicit, Phase.generate))
KINDS = ["any", "flat", "parallel", "nearly parallel", "pinhole", "edge-on", "thin mirror", "thin image", "opposed"]


def plan_of(beams, corners):
    tree, count = make_tree(corners), len(beams.number)
    group = np.zeros(len(corners), np.int32)
    own = Own(np.full(count, -1, np.int32), np.ones(count, np.int32), np.full(count, ALL, np.int32))
    return drain(Planner().planning(beams, tree, group, own))


def fronts(plan):
    return np.flatnonzero(plan.pair[:, 2] == 1)


def rays_of(beams, k, places):
    """Origins, directions (not unit) and scale at places (Q, 2) of the image."""
    terms = np.column_stack([places - beams.center[k], np.ones(len(places))])
    scale = (terms @ beams.scale[k])[:, None]
    return terms @ beams.origin[k].T / scale + beams.anchor[k], terms @ beams.direction[k].T / scale, scale[:, 0]


def units(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def reflected(beams, k, places, corners, normals):
    """The exact ray after a mirror triangle, the weights of its corners, and -N, each with its own formula."""
    start, direction, _ = rays_of(beams, k, places)
    a, b, c = corners
    plane = units(np.cross(b - a, c - a))
    slant = -direction @ plane
    point = start + (((start - a) @ plane) / slant)[:, None] * direction
    basis = np.linalg.pinv(np.column_stack([b - a, c - a]))
    weights = (point - a) @ basis.T
    weights = np.column_stack([1.0 - weights.sum(axis=1), weights])
    at = units(weights @ normals)
    return point, units(direction - 2.0 * np.sum(direction * at, axis=1)[:, None] * at), weights, slant


def within(plan, row, center, random, count=8):
    """Places in the pieces of a pair."""
    pieces = plan.place[plan.owner == row].astype(float) + center
    mixed = random.dirichlet([0.7] * 3, (len(pieces), count))
    return np.einsum("tqk,tki->tqi", mixed, pieces).reshape(-1, 2)


def errors(beams, plan, chosen, corners, normals, random):
    """Of the following rays' origins and directions, at places where the mirror is seen."""
    found = following_rays(beams, plan, chosen, corners, normals)
    after = drain(making_beams(found.image, found.origins, found.directions, SIZE, domain=found.domain))
    origins, directions = [np.zeros(0)], [np.zeros(0)]
    for j, i in enumerate(after.number):
        k, face, _ = plan.pair[chosen[i]]
        places = within(plan, chosen[i], beams.center[k], random)
        point, away, weights, slant = reflected(beams, k, places, corners[face], normals[face])
        start, direction, scale = rays_of(after, j, places)
        seen = (weights >= 0.0).all(axis=1) & (slant > 0.0)
        assert (scale[seen] > 0.0).all()
        origins.append(np.linalg.norm(start - point, axis=1)[seen])
        directions.append(np.linalg.norm(units(direction) - away, axis=1)[seen])
    return np.concatenate(origins), np.concatenate(directions)


def flat(corners):
    normal = units(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    return np.repeat(normal[:, None], 3, axis=1)


def grid(low, high, count):
    """Places (V, 2) and triangles (T, 3), counter-clockwise in x and y."""
    line = np.linspace(low, high, count + 1)
    x, y = np.meshgrid(line, line)
    number = np.arange((count + 1) ** 2).reshape(count + 1, -1)
    a, b, c, d = (n.ravel() for n in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]))
    faces = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    return np.column_stack([x.ravel(), y.ravel()]), faces


def window(count=2, bend=0.0):
    """Rays into -z through a square of two metres at z = 1, as from a point behind it, or bent by a curved mirror."""
    places, faces = grid(-1.0, 1.0, count)
    origins = np.column_stack([places, np.ones(len(places))])
    directions = origins - [0.0, 0.0, 6.0]
    directions[:, 0] += bend * places[:, 0] ** 2
    directions[:, 1] += bend * places[:, 0] * places[:, 1]
    image = np.column_stack([200.0 + 200.0 * places[:, 0], 200.0 - 200.0 * places[:, 1], np.ones(len(places))])
    return drain(making_beams(image[faces], origins[faces], directions[faces], SIZE))


def ball(count, center=(0.3, 0.1, -5.0), radius=2.0):
    angles, faces = grid(-0.6, 0.6, count)
    u, v = angles.T
    normals = np.column_stack([np.sin(u) * np.cos(v), np.sin(v), np.cos(u) * np.cos(v)])
    return (center + radius * normals)[faces], normals[faces]


FLOOR = np.array(
    [[[-4, -1.2, 2], [4, -1.2, 2], [4, -1.2, -30]], [[-4, -1.2, 2], [4, -1.2, -30], [-4, -1.2, -30]]], float
)
SLANTING = np.array([[[-3, -3, -4], [3, -3, -6], [0, 4, -5]]], float)


@pytest.mark.parametrize("mirror", [FLOOR, SLANTING], ids=["floor", "slanting"])
def test_a_flat_mirror_in_a_flat_mirror_is_exact_everywhere(mirror):
    beams = window()
    plan = plan_of(beams, mirror)
    origins, directions = errors(beams, plan, fronts(plan), mirror, flat(mirror), np.random.default_rng(1))
    assert len(origins) > 50
    assert origins.max() < 1e-9
    assert directions.max() < 1e-9


def test_and_so_is_a_third_flat_mirror():
    beams, ceiling = window(), FLOOR[:, ::-1] * [1.0, -1.0, 1.0] + [0.0, 3.0, 0.0]
    plan = plan_of(beams, FLOOR)
    chosen = fronts(plan)
    second = following_rays(beams, plan, chosen, FLOOR, flat(FLOOR))
    after = drain(making_beams(second.image, second.origins, second.directions, SIZE, domain=second.domain))
    further = plan_of(after, ceiling)
    origins, directions = errors(after, further, fronts(further), ceiling, flat(ceiling), np.random.default_rng(2))
    assert len(origins) > 50
    assert origins.max() < 1e-9 * 30.0
    assert directions.max() < 1e-9


def test_directions_from_a_flat_mirror_are_exact_whatever_comes_to_it():
    beams = window(2, bend=0.2)
    plan = plan_of(beams, SLANTING)
    origins, directions = errors(beams, plan, fronts(plan), SLANTING, flat(SLANTING), np.random.default_rng(3))
    assert directions.max() < 1e-9
    assert 1e-6 < origins.max() < 0.02


@pytest.mark.parametrize("bend", [0.0, 0.15])
def test_the_error_falls_with_the_square_of_the_size(bend):
    worst = []
    for count in (2, 4, 8):
        beams = window(count, bend)
        corners, normals = ball(count)
        plan = plan_of(beams, corners)
        random = np.random.default_rng(4)
        found = errors(beams, plan, fronts(plan), corners, normals, random)
        worst.append([np.sqrt(np.mean(one**2)) for one in found])
    origins, directions = np.array(worst).T
    assert directions[0] < 0.06
    assert (directions[:-1] / directions[1:] > 3.0).all()
    if bend:
        assert (origins[:-1] / origins[1:] > 3.0).all()
    else:
        assert origins.max() < 1e-9


def case(kind, seed):
    """A ray triangle that looks into -z, mirrors before it, and their vertex normals."""
    random = np.random.default_rng(seed)
    image = np.column_stack([random.uniform(0.0, 400.0, (3, 2)), np.ones(3)])
    if kind == "thin image":
        image[2, :2] = image[:2, :2].mean(axis=0) + random.choice([1e-3, 0.05, 1.0]) * random.normal(size=2)
    place = (image[:, :2] - 200.0) / 200.0
    origins = np.column_stack([place, random.uniform(-0.1, 0.1, 3)])
    directions = np.column_stack([0.2 * place, np.full(3, -1.0)]) + 0.05 * random.normal(size=(3, 3))
    if kind in ("parallel", "nearly parallel"):
        directions = [0.0, 0.0, -1.0] + (1e-6 if kind == "nearly parallel" else 0.0) * random.normal(size=(3, 3))
    if kind == "pinhole":
        origins = np.zeros((3, 3))
    corners = random.normal(size=(12, 3, 3)) - np.array([0.0, 0.0, 4.0])
    if kind == "edge-on":
        corners[:, :, 0] = corners[:, :1, 0] + 0.3 * random.normal(size=(12, 1)) + 1e-3 * corners[:, :, 1]
    if kind == "thin mirror":
        corners[:, 2] = corners[:, :2].mean(axis=1) + random.choice([0.0, 1e-9, 1e-3]) * corners[:, 2]
    normals = flat(corners) if kind != "thin mirror" else units(random.normal(size=(12, 3, 3)))
    if kind == "opposed":
        normals[:, 1], normals[:, 2] = -normals[:, 0], normals[:, 0]
    elif kind != "flat":
        normals = units(normals + 0.1 * random.normal(size=normals.shape))
    return drain(making_beams(image[None], origins[None], directions[None], SIZE)), corners, normals


@QUICK
@given(st.sampled_from(KINDS), st.integers(0, 2**32 - 1))
def test_following_rays_of_any_pair(kind, seed):
    beams, corners, normals = case(kind, seed)
    plan = plan_of(beams, corners)
    chosen = np.arange(len(plan.pair))
    found = following_rays(beams, plan, chosen, corners, normals)
    for name in ("image", "origins", "directions", "domain"):
        assert np.isfinite(getattr(found, name)).all(), name
    assert (found.image[..., 2] > 0.0).all()
    assert (np.linalg.norm(found.directions, axis=-1) > 0.0).all()
    for row in chosen:
        k, face, side = plan.pair[row]
        a, b, c = corners[face]
        pieces = plan.place[plan.owner == row].reshape(-1, 2) + beams.center[k]
        low, high = found.domain[row].min(axis=0), found.domain[row].max(axis=0)
        if (low == high).any():
            continue
        assert (pieces >= low).all() and (pieces <= high).all()
        places = found.image[row, :, :2] / found.image[row, :, 2:]
        assert (places >= low - 0.13).all() and (places <= high + 0.13).all()
        normal = np.cross(b - a, c - a)
        start, direction, _ = rays_of(beams, k, places)
        # A thin triangle's normal loses digits itself.
        reach = 1.0 + np.linalg.norm(found.origins[row], axis=-1).max()
        rounding = (
            1e-12 * np.linalg.norm(normal) * reach + 1e-14 * reach * (np.abs(b - a).max() + np.abs(c - a).max()) ** 2
        )
        # The incident ray passes the sample's origin, which is on the plane.
        assert (np.abs((found.origins[row] - a) @ normal) <= rounding).all()
        sideways = np.cross(units(direction), found.origins[row] - start)
        slant = np.abs(units(direction) @ normal).min()
        assert (np.abs(sideways) * slant <= 1e3 * rounding).all()
        assert ((direction @ normal > -rounding) if side == 0 else (direction @ normal < rounding)).all()
        if kind in ("any", "flat", "parallel", "pinhole"):
            _, away, _, _ = reflected(beams, k, places, corners[face], normals[face])
            assert np.allclose(units(found.directions[row]), away, atol=1e-9)


@QUICK
@given(st.sampled_from(KINDS), st.integers(0, 2**32 - 1))
def test_samples_stand_for_the_region(kind, seed):
    beams, corners, _ = case(kind, seed)
    plan = plan_of(beams, corners)
    place, box = samples(plan, np.arange(len(plan.pair)))
    for row in range(len(plan.pair)):
        pieces = plan.place[plan.owner == row].reshape(-1, 2).astype(float)
        assert (box[row] == [*pieces.min(axis=0), *pieces.max(axis=0)]).all()
        (x1, y1), (x2, y2), (x3, y3) = place[row]
        length = np.hypot(x2 - x1, y2 - y1)
        width = abs((x2 - x1) * (y3 - y1) - (x3 - x1) * (y2 - y1)) / length
        assert min(length, width) >= LEAST_EXTENT * (1.0 - 1e-9)
        if min(length, width) > LEAST_EXTENT * (1.0 + 1e-9) and kind != "thin image":
            inside = least_weights(plan.terms[row], within(plan, row, 0.0, np.random.default_rng(seed), 100)).max()
            # Places inside may be too few to be found.
            assert inside < 0.1 or least_weights(plan.terms[row], place[row]).min() >= 1.001 * OUTSIDE


def least_weights(terms, places):
    """The least weight on a pair's scene triangle at each place."""
    x, y = places.T
    powers = np.stack([x * x, x * y, y * y, x, y, np.ones(len(x))])
    sides, across = terms[:18].reshape(3, 6) @ powers, terms[18:21] @ powers[3:]
    return np.where(across > 0.0, sides.min(axis=0) / np.where(across > 0.0, across, 1.0), -np.inf)


@example("any", 83150019)
@QUICK
@given(st.sampled_from(["any", "flat", "parallel", "nearly parallel", "pinhole"]), st.integers(0, 2**32 - 1))
def test_what_is_wrong_is_bounded_by_how_much_normals_and_rays_turn(kind, seed):
    beams, corners, normals = case(kind, seed)
    plan = plan_of(beams, corners)
    random = np.random.default_rng(seed)
    for row in fronts(plan):
        _, directions = errors(beams, plan, np.array([row]), corners, normals, random)
        vertices = normals[plan.pair[row, 1]]
        turn = np.linalg.norm(vertices - vertices[:, None], axis=-1).max()
        assert directions.max(initial=0.0) <= 1e-9 + 3.5 * turn


def test_a_pair_whose_rays_miss_the_plane_is_not_followed():
    beams, corners, normals = case("any", 1)
    plan = plan_of(beams, corners)
    turned = plan.pair.copy()
    turned[:, 2] = 1 - turned[:, 2]
    wrong = Plan(turned, plan.terms, plan.place, plan.owner)
    found = following_rays(beams, wrong, np.arange(len(plan.pair)), corners, normals)
    assert len(plan.pair)
    assert np.isfinite(found.directions).all()
    assert len(drain(making_beams(found.image, found.origins, found.directions, SIZE, domain=found.domain)).number) == 0


def test_nothing_follows_from_nothing():
    beams, corners, normals = case("any", 1)
    found = following_rays(beams, plan_of(beams, corners), np.zeros(0, int), corners, normals)
    assert found.domain.shape == (0, 4, 2)
    after = drain(making_beams(found.image, found.origins, found.directions, SIZE, domain=found.domain))
    assert after.domain.shape[0] == 0


def random_domain(seed):
    random = np.random.default_rng(seed)
    beams, _, _ = case(KINDS[seed % 5], seed)
    place = random.uniform(50.0, 350.0, (3, 2))
    weights = random.uniform(0.3, 3.0, 3)
    image = np.column_stack([place, np.ones(3)]) * weights[:, None]
    start, direction, _ = rays_of(beams, 0, place)
    low, high = np.sort(random.uniform(-50.0, 450.0, (2, 2)), axis=0)
    domain = np.array([low, [high[0], low[1]], high, [low[0], high[1]]])
    return image[None], start[None], direction[None], domain[None], random


@QUICK
@given(st.integers(0, 2**32 - 1))
def test_a_given_part_of_the_image_is_seen_whole(seed):
    image, origins, directions, domain, random = random_domain(seed)
    beams = drain(making_beams(image, origins, directions, SIZE, domain=domain))
    if not len(beams.number):
        return
    places = random.uniform(domain[0].min(axis=0), domain[0].max(axis=0), (150, 2))
    places = places[((places > 0.0) & (places < SIZE)).all(axis=1)]
    start, direction, scale = rays_of(beams, 0, places)
    known = scale > 2e-3 * rays_of(beams, 0, domain[0])[2].max()
    start, direction, places = start[known][:40], direction[known][:40], places[known][:40]
    middles = start + random.exponential(2.0, (len(start), 1)) * direction
    corners = middles[:, None] + 0.1 * random.normal(size=(len(start), 3, 3))
    plan = plan_of(beams, corners)
    for face, (a, b, c) in enumerate(corners):
        matrix = np.stack(np.broadcast_arrays(b - a, c - a, -direction), axis=-1)
        u, v, t = np.linalg.solve(matrix, (start - a)[..., None])[..., 0].T
        seen = np.minimum(np.minimum(u, v), np.minimum(1.0 - u - v, t)) > 1e-6
        rows = np.flatnonzero(plan.pair[:, 1] == face)
        pieces = plan.place[np.isin(plan.owner, rows)].astype(float) + beams.center[0]
        assert holds(pieces, places[seen]).all()


def holds(triangles, places):
    """Whether each place is in one of some triangles (T, 3, 2)."""
    offset = triangles[:, None] - places[:, None]
    following = np.roll(offset, -1, axis=2)
    sides = offset[..., 0] * following[..., 1] - offset[..., 1] * following[..., 0]
    return ((sides >= -1e-3).all(axis=2) | (sides <= 1e-3).all(axis=2)).any(axis=0)


@pytest.mark.parametrize("kind", ["any", "pinhole", "nearly parallel"])
def test_over_its_own_corners_a_given_part_changes_nothing(kind):
    image, origins, directions, _, _ = random_domain(KINDS.index(kind) + 5)
    own = image[..., :2] / image[..., 2:]
    plain, given = (
        drain(making_beams(image, origins, directions, SIZE)),
        drain(making_beams(image, origins, directions, SIZE, domain=own)),
    )
    for one, other in zip(rays_of(plain, 0, own[0])[:2], rays_of(given, 0, own[0])[:2], strict=True):
        assert np.allclose(one, other, rtol=1e-9, atol=1e-9)
    assert (given.corners == 3).all()


def test_a_given_part_ends_where_the_scale_does():
    place = np.array([[100.0, 100.0], [200.0, 100.0], [100.0, 200.0]])
    image = np.column_stack([place, np.ones(3)]) * np.array([[1.0], [4.0], [1.0]])
    domain = np.array([[0.0, 0.0], [400.0, 0.0], [400.0, 400.0], [0.0, 400.0]])
    beams = drain(making_beams(image[None], np.eye(3)[None], np.eye(3)[None] - 2.0, SIZE, domain=domain[None]))
    used = beams.domain[0, : beams.corners[0]]
    scale = rays_of(beams, 0, used + beams.center[0])[2]
    assert (scale > 0.0).all()
    # s falls by 3 / 400 a pixel from 1 at 100: it is 0 at 233.3.
    assert 232.0 < (used + beams.center[0])[:, 0].max() < 233.33
    flat_part = drain(
        making_beams(image[None], np.eye(3)[None], np.eye(3)[None] - 2.0, SIZE, domain=domain[None] * [1.0, 0.0])
    )
    assert len(flat_part.number) == 0


def test_given_parts_want_rays_too():
    image, origins, directions, _, _ = random_domain(5)
    with pytest.raises(AnamorphError, match="directions are 0"):
        drain(
            making_beams(
                image, origins, 0.0 * directions, SIZE, domain=np.array([[[0, 0], [400, 0], [400, 400], [0, 400]]])
            )
        )
