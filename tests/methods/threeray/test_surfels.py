"""Surfels and the tree over them: they cover their triangles, and nothing is outside of its box."""

from __future__ import annotations

import numpy as np
import pytest

from anamorph.base.errors import AnamorphError
from anamorph.methods.threeray import surfel_tree
from anamorph.methods.threeray import surfels as module
from anamorph.methods.threeray.surfel_tree import LEAF, make_tree
from anamorph.methods.threeray.surfels import evenly, magnified, sample
from anamorph.raytriangle.bounds import PAD, support


def triangles(seed: int, count: int = 60) -> np.ndarray:
    """Triangles of all shapes: slivers, tiny and far ones, and some without an area."""
    random = np.random.default_rng(seed)
    corners = random.normal(size=(count, 1, 3)) * 3.0 + random.normal(size=(count, 3, 3))
    corners[::7, 2] = corners[::7, 0] + 0.4 * (corners[::7, 1] - corners[::7, 0]) + 1e-6
    corners[1::7] = corners[1::7, :1] + 1e-5 * (corners[1::7] - corners[1::7, :1])
    corners[2::14, 1] = corners[2::14, 0]
    return corners


def area(corners: np.ndarray) -> np.ndarray:
    return 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("spacing", [0.1, 0.5, 3.0])
def test_surfels_are_the_pieces_of_their_triangles(seed, spacing):
    corners = triangles(seed)
    found = sample(corners, evenly(corners, spacing))
    pieces = found.weights @ corners[found.triangle]
    whole = area(corners)
    covered = np.bincount(found.triangle, area(pieces), len(corners))
    assert np.abs(covered - whole).max() <= 1e-9 * whole.max()
    assert set(found.triangle.tolist()) == set(np.flatnonzero(whole > 0.0).tolist())
    assert (found.weights >= 0.0).all() and np.abs(found.weights.sum(axis=2) - 1.0).max() < 1e-12
    away = np.linalg.norm(pieces - found.center[:, None], axis=2).max(axis=1)
    assert away.max() <= spacing
    # No further than needed: a triangle that is small enough stays one piece.
    own = np.linalg.norm(corners - corners.mean(axis=1, keepdims=True), axis=2).max(axis=1)
    assert (np.bincount(found.triangle, minlength=len(corners))[(own <= spacing) & (whole > 0.0)] == 1).all()


def test_surfels_grow_with_the_distance_to_the_mirrors():
    corners = triangles(1)
    mirrors = np.array([[0.0, 0.0, 0.0], [0.3, 0.0, 0.0]])
    found = sample(corners, magnified(mirrors, 0.05))
    pieces = found.weights @ corners[found.triangle]
    away = np.linalg.norm(pieces - found.center[:, None], axis=2).max(axis=1)
    distance = np.linalg.norm(found.center[:, None] - mirrors, axis=2).min(axis=1)
    assert (away <= np.maximum(distance, 0.05)).all()
    assert len(found) > (area(corners) > 0.0).sum()


@pytest.mark.parametrize("seed", range(5))
def test_the_support_holds_all_of_a_piece_and_is_met_at_its_corners(seed):
    """The ellipse goes through the three corners: along a vector it reaches as far as any of them, or farther."""
    corners = triangles(seed)
    found = sample(corners, evenly(corners, 1.0))
    pieces = found.weights @ corners[found.triangle]
    random = np.random.default_rng(seed)
    vectors = np.concatenate([np.eye(3), random.normal(size=(20, 3))])
    for number, (middle, row) in enumerate(zip(found.center, found.covariance, strict=True)):
        reach = np.array([support(tuple(row), False, tuple(vector)) for vector in vectors])
        farthest = (np.abs((pieces[number] - middle) @ vectors.T)).max(axis=0)
        assert (reach >= farthest * (1.0 - 1e-12)).all()
    # By its definition, sqrt(n' S n).
    full = found.covariance[0][[[0, 3, 4], [3, 1, 5], [4, 5, 2]]]
    expected = np.sqrt(np.einsum("ni,ij,nj->n", vectors, full, vectors))
    reach = np.array([support(tuple(found.covariance[0]), False, tuple(vector)) for vector in vectors])
    np.testing.assert_allclose(reach, (1.0 + PAD) * expected, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("points", [False, True])
def test_every_surfel_is_in_one_leaf_and_every_box_holds_what_is_below_it(seed, points):
    corners, objects = triangles(seed, 200), np.random.default_rng(seed).integers(1, 6, 200)
    tree = make_tree(sample(corners, evenly(corners, 0.4)), objects, points)
    leaves = tree.count > 0
    taken = np.concatenate(
        [np.arange(first, first + count) for first, count in zip(tree.first[leaves], tree.count[leaves], strict=True)]
    )
    assert np.sort(taken).tolist() == list(range(len(tree.surfels)))
    assert tree.count.max() <= LEAF
    pieces = tree.surfels.weights @ corners[tree.surfels.triangle]
    for node in range(len(tree.size)):
        below = slice(node, node + tree.size[node])
        firsts, counts = tree.first[below], tree.count[below]
        held = np.concatenate([np.arange(f, f + n) for f, n in zip(firsts, counts, strict=True)]).astype(int)
        assert (np.abs(pieces[held] - tree.middle[node]) <= tree.half[node]).all()
    assert tree.size[0] == len(tree.size)


def test_no_leaf_has_surfels_of_two_objects():
    corners, objects = triangles(3, 100), np.repeat([1, 2, 3, 4], 25)
    tree = make_tree(sample(corners, evenly(corners, 0.5)), objects)
    for first, count in zip(tree.first, tree.count, strict=True):
        own = objects[tree.surfels.triangle[first : first + count]]
        assert len(set(own.tolist())) <= 1


def test_what_moves_keeps_its_tree_and_the_same_scene_has_the_same():
    corners, objects = triangles(4, 100), np.repeat([1, 2], 50)
    tree, again = (make_tree(sample(corners, evenly(corners, 0.5)), objects) for _ in range(2))
    assert (tree.first == again.first).all() and (tree.middle == again.middle).all()
    turn, _ = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))
    moved = corners @ turn.T + [1.0, 2.0, 3.0]
    there = tree.moved(moved)
    assert there.first is tree.first and there.size is tree.size
    pieces = there.surfels.weights @ moved[there.surfels.triangle]
    np.testing.assert_allclose(there.surfels.center, pieces.mean(axis=1), atol=1e-12)
    assert (np.abs(pieces.reshape(-1, 3) - there.middle[0]) <= there.half[0]).all()


def test_a_spacing_that_makes_too_many_surfels_is_refused_before_they_are_made():
    corners = triangles(0)
    with pytest.raises(AnamorphError, match="spacing 1e-07 makes more than"):
        evenly(corners, 1e-7)


def test_so_is_one_that_only_sampling_finds_out(monkeypatch):
    monkeypatch.setattr(module, "MOST", 100)
    corners = triangles(0)
    with pytest.raises(AnamorphError, match="the scene makes more than 100 surfels; give spacing"):
        sample(corners, lambda center: np.full(len(center), 0.05))


def test_objects_of_no_extent_have_no_surfels():
    corners = np.zeros((5, 3, 3))
    found = sample(corners, evenly(corners, 1.0))
    tree = make_tree(found, np.ones(5, int))
    assert len(found) == 0 and tree.size.tolist() == [1] and tree.count.tolist() == [0]


def test_many_surfels_at_one_place_are_one_leaf():
    corners = np.tile(np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]]), (100_000, 1, 1))
    tree = make_tree(sample(corners, evenly(corners, 2.0)), np.ones(len(corners), int))
    assert tree.count.tolist() == [100_000]


def test_rays_meet_fewer_of_what_is_parted_than_of_what_is_halved(monkeypatch):
    monkeypatch.setattr(surfel_tree, "POINTS", LEAF)
    corners = triangles(6, 2000)
    found, one = sample(corners, evenly(corners, 0.4)), np.ones(len(corners), int)
    asked = []
    for points in (False, True):
        tree = make_tree(found, one, points)
        x, y, z = tree.half.T
        surface = x * y + y * z + z * x
        asked.append((surface * (1.0 + tree.count)).sum() / surface[0])
    assert asked[0] < 0.8 * asked[1]


def test_surfels_that_crowd_toward_a_place_are_parted():
    """Each cut parts only a few from all the others."""
    at = 0.5 ** np.arange(900.0)
    corners = at[:, None, None] * np.array([[[1.0, 0, 0], [1.1, 0, 0], [1.0, 0.1, 0]]])
    tree = make_tree(sample(corners, evenly(corners, 2.0)), np.ones(len(corners), int))
    assert tree.count.sum() == len(tree.surfels) and tree.count.max() <= LEAF
