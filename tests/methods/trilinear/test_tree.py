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
    """Each triangle stands in one leaf, boxes hold what is below them, and no box is larger than that."""
    assert tree.faces.dtype == np.int32
    assert sorted(tree.faces) == list(range(len(corners)))
    assert (tree.corners == corners[tree.faces]).all()
    leaves = len(tree.low) // 2
    assert leaves & (leaves - 1) == 0 and leaves * LEAF >= len(corners)
    held = [np.zeros((0, 3))] * (2 * leaves)
    for node in range(2 * leaves - 1, 0, -1):
        start = (node - leaves) * LEAF
        below = tree.corners[start : start + LEAF] if node >= leaves else [*held[2 * node], *held[2 * node + 1]]
        held[node] = np.reshape(below, (-1, 3))
        assert (tree.low[node] == held[node].min(axis=0, initial=np.inf)).all()
        assert (tree.high[node] == held[node].max(axis=0, initial=-np.inf)).all()
    assert len(held[1]) == 3 * len(corners)


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
    assert all((getattr(back, name) == getattr(tree, name)).all() for name in ("faces", "low", "high", "corners"))


@pytest.mark.parametrize("kind", KINDS)
def test_the_same_triangles_give_the_same_tree(kind):
    corners = soup(kind, 300)
    one, other = make_tree(corners), make_tree(corners.copy())
    assert all((getattr(one, name) == getattr(other, name)).all() for name in ("faces", "low", "high", "corners"))


def test_triangles_of_one_place_keep_their_order():
    corners = np.zeros((1000, 3, 3)) + (np.arange(1000) % 2)[:, None, None]
    assert make_tree(corners).faces.tolist() == [*range(0, 1000, 2), *range(1, 1000, 2)]


def test_float32_corners_are_taken_as_they_are():
    corners = soup("anywhere", 20).astype(np.float32)
    tree = make_tree(corners)
    assert tree.low.dtype == np.float64 and (tree.corners == corners[tree.faces]).all()


def test_neighbours_share_boxes():
    """Sorted at random, the leaves' boxes would each be as large as the whole."""
    random = np.random.default_rng(3)
    corners = random.uniform(-1, 1, (4096, 1, 3)) + random.normal(scale=0.005, size=(4096, 3, 3))
    tree = make_tree(corners)
    leaves = len(tree.low) // 2
    extents = (tree.high - tree.low)[leaves:]
    assert np.prod(extents, axis=1).mean() < 0.01 * np.prod(tree.high[1] - tree.low[1])
