"""Rays that go on from a mirror: exact among flat ones, and wrong by the square of the size among others."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from trilinear_twin import looked

from anamorph.base.steps import drain
from anamorph.methods.trilinear.beams import Beams, making_beams
from anamorph.methods.trilinear.following import Sending, following_rays, sending
from anamorph.methods.trilinear.pairs import ALL, Own
from anamorph.methods.trilinear.samples import LEAST_EXTENT, spread
from anamorph.raytriangle.camera_frames import Frames
from anamorph.raytriangle.owners import owners_of, places_of

SIZE = (400, 400)
QUICK = settings(max_examples=60, phases=(Phase.explicit, Phase.generate))
KINDS = ["any", "flat", "parallel", "nearly parallel", "pinhole", "edge-on", "thin mirror", "thin image", "opposed"]


class Case(NamedTuple):
    """Ray triangles, whose samples are whose, and mirrors before them."""

    beams: Beams
    frames: Frames
    owner: np.ndarray
    corners: np.ndarray
    normals: np.ndarray


def case_of(image, origins, directions, corners, normals):
    places, owner = places_of(image, SIZE), np.empty(SIZE[::-1], np.int32)
    owners_of(places, SIZE, None, np.empty(SIZE[::-1]), owner)
    held = np.flatnonzero((places.box[:, :2] < places.box[:, 2:]).all(axis=1))
    beams, frames = drain(making_beams(image[held], origins[held], directions[held], places.box[held]))
    return Case(beams._replace(number=held.astype(np.int32)), frames, owner, corners, normals)


def sent_by(case):
    """Samples that see the fronts of mirrors, and how far these are."""
    count = len(case.corners)
    own = Own(*(np.full(len(case.beams.number), each, np.int32) for each in (-1, 1, ALL)))
    sights = looked(case.beams, case.frames, case.owner, case.corners, np.ones(count, bool), own)
    goes_on = np.ones(len(case.beams.number), bool)
    return sending(sights, case.beams, np.ones(count, bool), goes_on, (0, 0, *SIZE))


def following(case, sent):
    """The rays that are sent on: beams, frames and the numbers of their groups."""
    found = following_rays(case.beams, sent, case.corners, case.normals)
    met = np.flatnonzero(found.met)
    made = drain(making_beams(found.image[met], found.origins[met], found.directions[met], found.box[met]))
    return *made, met


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


def errors(case):
    """Of the following rays' origins and directions, at samples that see the mirrors."""
    sent = sent_by(case)
    after, _, met = following(case, sent)
    origins, directions = [np.zeros(0)], [np.zeros(0)]
    for j, group in enumerate(met):
        k, face = sent.ray_triangle[group], sent.face[group]
        places = sent.place[sent.first[group] : sent.first[group + 1]]
        point, away, weights, slant = reflected(case.beams, k, places, case.corners[face], case.normals[face])
        start, direction, scale = rays_of(after, j, places)
        assert (weights >= -1e-9).all() and (slant >= 0.0).all() and (scale > 0.0).all()
        origins.append(np.linalg.norm(start - point, axis=1))
        directions.append(np.linalg.norm(units(direction) - away, axis=1))
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


def window(mirror, normals, count=2, bend=0.0):
    """Rays into -z through a square of two metres at z = 1, as from a point behind it, or bent by a curved mirror."""
    places, faces = grid(-1.0, 1.0, count)
    origins = np.column_stack([places, np.ones(len(places))])
    directions = origins - [0.0, 0.0, 6.0]
    directions[:, 0] += bend * places[:, 0] ** 2
    directions[:, 1] += bend * places[:, 0] * places[:, 1]
    image = np.column_stack([200.0 + 200.0 * places[:, 0], 200.0 - 200.0 * places[:, 1], np.ones(len(places))])
    return case_of(image[faces], origins[faces], directions[faces], mirror, normals)


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
    origins, directions = errors(window(mirror, flat(mirror)))
    assert len(origins) > 5000
    assert origins.max() < 1e-9
    assert directions.max() < 1e-9


def test_and_so_is_a_third_flat_mirror():
    first, ceiling = window(FLOOR, flat(FLOOR)), FLOOR[:, ::-1] * [1.0, -1.0, 1.0] + [0.0, 3.0, 0.0]
    sent = sent_by(first)
    after, frames, met = following(first, sent)
    owner = np.full(SIZE[::-1], -1, np.int32)
    owner[sent.place[:, 1], sent.place[:, 0]] = np.repeat(np.arange(len(met)), np.diff(sent.first))
    origins, directions = errors(Case(after, frames, owner, ceiling, flat(ceiling)))
    assert len(origins) > 1000
    assert origins.max() < 1e-9 * 30.0
    assert directions.max() < 1e-9


def test_directions_from_a_flat_mirror_are_exact_whatever_comes_to_it():
    origins, directions = errors(window(SLANTING, flat(SLANTING), bend=0.2))
    assert directions.max() < 1e-9
    assert 1e-6 < origins.max() < 0.02


@pytest.mark.parametrize("bend", [0.0, 0.15])
def test_the_error_falls_with_the_square_of_the_size(bend):
    worst = []
    for count in (2, 4, 8):
        found = errors(window(*ball(count), count, bend))
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
    return case_of(image[None], origins[None], directions[None], corners, normals)


@QUICK
@given(st.sampled_from(KINDS), st.integers(0, 2**32 - 1))
def test_following_rays_of_any_samples(kind, seed):
    before = case(kind, seed)
    sent = sent_by(before)
    found = following_rays(before.beams, sent, before.corners, before.normals)
    for name in ("image", "origins", "directions"):
        assert np.isfinite(getattr(found, name)).all(), name
    assert (found.image[..., 2] > 0.0).all()
    after, _, met = following(before, sent)
    for j, group in enumerate(met):
        places = sent.place[sent.first[group] : sent.first[group + 1]]
        # The box holds the samples tightly, and the ray triangle them.
        assert (found.box[group] == [*places.min(axis=0), *places.max(axis=0) + 1]).all()
        weights = np.column_stack([places, np.ones(len(places))]) @ np.linalg.inv(found.image[group])
        assert (weights > 0.0).all()
        if kind in ("any", "flat", "parallel", "pinhole"):
            k, face = sent.ray_triangle[group], sent.face[group]
            _, away, _, _ = reflected(before.beams, k, places, before.corners[face], before.normals[face])
            _, direction, _ = rays_of(after, j, places)
            turn = np.linalg.norm(before.normals[face] - before.normals[face][:, None], axis=-1).max()
            assert np.linalg.norm(units(direction) - away, axis=1).max() <= 1e-9 + 3.5 * turn


@given(st.integers(1, 40), st.booleans(), st.integers(0, 2**32 - 1))
def test_three_places_stand_for_a_group_and_never_in_one_line(count, in_line, seed):
    random = np.random.default_rng(seed)
    place = random.integers(-30, 30, (2 * count, 2)).astype(float)
    if in_line:
        place[:, 1] = 2.0 * place[:, 0]
    three = spread(place, np.array([0, count]), np.array([count, 2 * count]))
    for (one, two, third), group in zip(three, np.split(place, 2), strict=True):
        assert (group == one).all(axis=1).any()
        length = np.linalg.norm(two - one)
        width = abs((two - one)[0] * (third - one)[1] - (two - one)[1] * (third - one)[0]) / length
        assert min(length, width) >= LEAST_EXTENT * (1.0 - 1e-9)
        if length > LEAST_EXTENT:
            assert length >= np.linalg.norm(group - one, axis=1).max() - 1e-9


def test_samples_whose_rays_miss_the_mirror_s_plane_are_not_followed():
    before = case("any", 1)
    sent = sent_by(before)
    turned = before.corners[:, ::-1].copy()
    assert len(sent.face)
    found = following_rays(before.beams, sent, turned, before.normals)
    assert np.isfinite(found.directions).all() and not found.met.any()


def test_nothing_follows_from_nothing():
    before = case("any", 1)
    nothing = Sending(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(1, np.int64), np.zeros((0, 2), np.int64))
    found = following_rays(before.beams, nothing, before.corners, before.normals)
    assert found.image.shape == (0, 3, 3) and found.box.shape == (0, 4) and found.met.shape == (0,)
