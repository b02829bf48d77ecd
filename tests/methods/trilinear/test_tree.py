"""The tree over scene triangles: what its boxes hold, and that moving triangles give the boxes of a new tree."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from anamorph.methods.trilinear.box_tree import LEAF, BoxTree, make_tree, moved_tree

COUNTS = [0, 1, 2, LEAF, LEAF + 1, 8 * LEAF, 8 * LEAF + 1, 1000]
KINDS = ["anywhere", "in a plane", "on a line", "at a point", "two heaps", "huge and tiny"]
QUICK = settings(max_examples=60)


def soup(kind: str, count: int, seed: int = 0) -> np.ndarray:
    random = np.random.default_rng(seed)
    corners = random.uniform(-1, 1, (count, 1, 3)) + random.normal(scale=0.1, size=(count, 3, 3))
    if kind == "in a plane":
        corners[..., 1] = 0.3
    elif kind == "on a line":
        corners[..., :2] = 0.3
    elif kind == "at a point":
        corners[:] = [0.1, 0.2, 0.3]
    elif kind == "two heaps":
        corners = 1e-6 * corners + 1000.0 * random.integers(0, 2, (count, 1, 1))
    elif kind == "huge and tiny":
        corners *= 10.0 ** random.uniform(-6, 6, (count, 1, 1))
    return corners


def assert_sound(tree: BoxTree, corners: np.ndarray) -> None:
    """Each triangle stands in one leaf, boxes hold what is below them, and no box is much larger than that."""
    assert tree.faces.dtype == np.int32
    assert sorted(tree.faces) == list(range(len(corners)))
    assert (tree.corners == corners[tree.faces]).all()
    assert tree.size[0] == len(tree.size)
    largest = np.abs(corners).max(initial=0.0)
    stands = np.zeros(len(corners), int)
    for node in range(len(tree.size)):
        below = slice(node, node + tree.size[node])
        leaves = np.flatnonzero(tree.held[below] > 0) + node
        held = [np.zeros((0, 3)), *(tree.corners[tree.first[n] :][: tree.held[n]].reshape(-1, 3) for n in leaves)]
        points = np.concatenate(held)
        if tree.size[node] == 1:
            stands[tree.first[node] :][: tree.held[node]] += 1
        else:
            left = node + 1
            assert tree.held[node] == 0 and tree.size[node] == 1 + tree.size[left] + tree.size[left + tree.size[left]]
        if not len(points):
            assert (tree.half[node] < 0.0).all()
            continue
        low, high = points.min(axis=0), points.max(axis=0)
        slack = 1e-8 * (high - low) + 1e-10 * largest
        assert (tree.middle[node] - tree.half[node] <= low).all() and (
            tree.middle[node] + tree.half[node] >= high
        ).all()
        assert (2.0 * tree.half[node] <= high - low + slack).all()
    assert (stands == 1).all()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("count", COUNTS)
def test_boxes_hold_their_triangles_tightly(kind, count):
    corners = soup(kind, count)
    assert_sound(make_tree(corners), corners)


@QUICK
@given(st.sampled_from(KINDS), st.sampled_from(KINDS), st.integers(0, 100), st.integers(0, 2**32 - 1))
def test_a_tree_whose_triangles_moved_has_the_boxes_of_where_they_are(kind, after, count, seed):
    tree = make_tree(soup(kind, count, seed))
    moved = soup(after, count, seed + 1)
    refitted = moved_tree(tree, moved)
    assert (refitted.faces == tree.faces).all()
    assert_sound(refitted, moved)
    back = moved_tree(refitted, soup(kind, count, seed))
    assert all((getattr(back, name) == getattr(tree, name)).all() for name in BoxTree._fields)


@pytest.mark.parametrize("kind", KINDS)
def test_the_same_triangles_give_the_same_tree(kind):
    corners = soup(kind, 300)
    one, other = make_tree(corners), make_tree(corners.copy())
    assert all((getattr(one, name) == getattr(other, name)).all() for name in BoxTree._fields)


def test_triangles_of_one_middle_share_a_leaf_and_others_do_not():
    corners = np.zeros((1000, 3, 3)) + (np.arange(1000) % 2)[:, None, None]
    tree = make_tree(corners)
    assert tree.held.tolist() == [0, 500, 500]
    assert make_tree(soup("anywhere", 1000)).held.max() <= LEAF


def test_float32_corners_are_taken_as_they_are():
    corners = soup("anywhere", 20).astype(np.float32)
    tree = make_tree(corners)
    assert tree.middle.dtype == np.float64 and (tree.corners == corners[tree.faces]).all()


def test_neighbours_share_boxes():
    """Parted at random, the leaves' boxes would each be as large as the whole."""
    random = np.random.default_rng(3)
    corners = random.uniform(-1, 1, (4096, 1, 3)) + random.normal(scale=0.005, size=(4096, 3, 3))
    tree = make_tree(corners)
    extents = tree.half[tree.held > 0]
    assert np.prod(extents, axis=1).mean() < 0.01 * np.prod(tree.half[0])
