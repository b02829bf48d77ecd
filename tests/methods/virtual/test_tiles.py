"""Tiles of rays: no triangle that a ray meets is missed by its tile, nor by what holds several tiles."""

from __future__ import annotations

import numpy as np
import pytest

from anamorph.base.steps import drain
from anamorph.methods.virtual.listing import listing
from anamorph.methods.virtual.tile_tree import TILE_RAYS, may_meet, may_reach, tile_tree
from anamorph.methods.virtual.triangle_tree import triangle_tree

SPREADS = [0.0, 1e-7, 1e-3, 0.1, 1.0, 3.0]
"""How far the directions of a tile's rays are apart, radians."""

EXTENTS = [0.0, 1e-6, 1e-2, 1.0]
"""How far their starts are apart, metres."""

FORMS = ["any", "large", "tiny", "thin", "a line", "a point", "before the start"]


def unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def bundles(random: np.random.Generator, rows: int, columns: int, count: int = 12) -> tuple[np.ndarray, np.ndarray]:
    """Starts and directions of the rays of tiles, (rows, columns, count, 3)."""
    spread = random.choice(SPREADS, (rows, columns, 1, 1))
    extent = random.choice(EXTENTS, (rows, columns, 1, 1))
    middle = random.normal(size=(rows, columns, 1, 3))
    origins = middle + extent * random.uniform(-1, 1, (rows, columns, count, 3))
    axis = unit(random.normal(size=(rows, columns, 1, 3)))
    return origins, unit(axis + spread * random.uniform(-1, 1, (rows, columns, count, 3)))


def bounds(origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """What tiles.wgsl gives for these rays."""
    tiles = np.zeros(origins.shape[:2], TILE_RAYS)
    tiles["low"], tiles["high"], tiles["count"] = origins.min(axis=2), origins.max(axis=2), origins.shape[2]
    axis = unit(directions.mean(axis=2))
    tiles["axis"] = axis
    tiles["cosine"] = np.einsum("rci,rcki->rck", axis, directions).min(axis=-1)
    return tiles


def triangle_on(random: np.random.Generator, origin: np.ndarray, direction: np.ndarray, form: str) -> np.ndarray:
    """A triangle that a ray meets."""
    way = 0.0 if form == "before the start" else random.choice([1e-6, 1e-2, 1.0, 100.0])
    size = way * random.choice([0.1, 1.0]) if form == "any" else {"large": 50.0, "tiny": 1e-4}.get(form, 1.0)
    corners = random.normal(size=(3, 3))
    if form == "thin":
        corners[1] = corners[0] + 1e-6 * corners[1]
    if form == "a line":
        corners[2] = 0.3 * corners[0] + 0.7 * corners[1]
    if form == "a point":
        corners[:] = corners[0]
    weights = random.dirichlet([1.0, 1.0, 1.0]) * random.choice([0.0, 1.0], 3, p=[0.3, 0.7])
    weights = weights / weights.sum() if weights.any() else np.array([1.0, 0.0, 0.0])
    return origin + way * direction + size * (corners - weights @ corners)


@pytest.mark.parametrize("form", FORMS)
def test_no_tile_misses_what_one_of_its_rays_meets(form):
    random = np.random.default_rng(FORMS.index(form))
    for _ in range(30):
        rows, columns = random.integers(1, 6, 2)
        origins, directions = bundles(random, rows, columns)
        tree = tile_tree(bounds(origins, directions))
        for _ in range(40):
            row, column, ray = random.integers(0, [rows, columns, origins.shape[2]])
            corners = triangle_on(random, origins[row, column, ray], directions[row, column, ray], form)
            middle, half = 0.5 * (corners.min(axis=0) + corners.max(axis=0)), 0.5 * np.ptp(corners, axis=0)
            for level, width in enumerate(tree.columns[:-1]):
                node = tree.first[level] + (row >> level) * width + (column >> level)
                assert may_reach(tree, node, *middle, np.linalg.norm(half))
                assert may_meet(tree, node, *map(tuple, corners))


def test_what_no_ray_meets_is_mostly_left_out():
    random = np.random.default_rng(3)
    kept, met = 0, 0
    for _ in range(2000):
        origins, directions = bundles(random, 1, 1, count=40)
        origins = origins[:, :, :1] + 0.01 * (origins - origins[:, :, :1])
        directions = unit(directions[:, :, :1] + 0.05 * random.uniform(-1, 1, directions.shape))
        tree = tile_tree(bounds(origins, directions))
        corners = origins[0, 0, 0] + 2.0 * directions[0, 0, 0] + random.normal(size=3) + random.normal(size=(3, 3))
        kept += may_meet(tree, 0, *map(tuple, corners))
        met += bool(met_by(origins, directions, corners[None]).any())
    assert 100 < met <= kept < 1.3 * met


def met_by(origins: np.ndarray, directions: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Which of triangles (F, 3, 3) some rays of each tile meet, (rows, columns, F)."""
    a, b, c = (corners[:, k, None, None, None] - origins for k in range(3))
    volumes = np.stack(
        [np.einsum("...i,...i->...", directions, np.cross(*pair)) for pair in ((c, b), (a, c), (b, a))], axis=-1
    )
    weights = volumes / volumes.sum(axis=-1, keepdims=True)
    distance = sum(weights[..., k] * np.einsum("...i,...i->...", each, directions) for k, each in enumerate((a, b, c)))
    return np.moveaxis(((weights >= 0.0).all(axis=-1) & (distance > 0.0)).any(axis=-1), 0, -1)


def scattered(random: np.random.Generator, count: int) -> np.ndarray:
    return random.normal(size=(count, 1, 3)) * 3.0 + random.normal(size=(count, 3, 3))


def of_tile(lists, tile: int) -> list[int]:
    return sorted(lists.triangles[lists.begins[tile] : lists.begins[tile + 1]].tolist())


@pytest.mark.parametrize("most", [3, 20, 100_000])
def test_lists_hold_what_is_met_and_full_ones_are_known(most):
    random = np.random.default_rng(8)
    origins, directions = bundles(random, 7, 10)
    tiles = bounds(origins, directions)
    tiles["count"][2, 3] = tiles["count"][6] = 0
    tree, corners = tile_tree(tiles), scattered(random, 700)
    lists = drain(listing(tree, triangle_tree(corners, np.arange(len(corners))), most))
    met = met_by(origins, directions, corners).reshape(70, -1)
    assert met.sum() > 1000
    for tile in range(70):
        held, listed = tiles["count"].ravel()[tile] > 0, of_tile(lists, tile)
        assert len(set(listed)) == len(listed) and all(may_meet(tree, tile, *map(tuple, corners[f])) for f in listed)
        assert lists.full[tile] == (len(listed) > most) and (held or not listed)
        assert not held or lists.full[tile] or set(np.flatnonzero(met[tile])) <= set(listed)
    # What is full does not hang on how many look at once.
    again = drain(listing(tree, triangle_tree(corners, np.arange(len(corners))), 100_000))
    assert (lists.full == (np.diff(again.begins) > most)).all()


def test_triangles_of_one_place_and_one_triangle_alone_are_listed():
    random = np.random.default_rng(2)
    origins, directions = bundles(random, 1, 1)
    corners = triangle_on(random, origins[0, 0, 0], directions[0, 0, 0], "large")
    tree = tile_tree(bounds(origins, directions))
    for count in (1, 2, 5000):
        lists = drain(listing(tree, triangle_tree(np.repeat(corners[None], count, axis=0), np.arange(count)), 10**6))
        assert of_tile(lists, 0) == list(range(count))


def test_triangles_that_move_are_found_where_they_are():
    random = np.random.default_rng(5)
    before, after = scattered(random, 300), scattered(random, 300)
    origins, directions = bundles(random, 4, 4)
    lists = drain(
        listing(tile_tree(bounds(origins, directions)), triangle_tree(before, np.arange(300)).moved(after), 10**6)
    )
    met = met_by(origins, directions, after).reshape(16, -1)
    assert met.sum() > 50
    assert all(set(np.flatnonzero(met[tile])) <= set(of_tile(lists, tile)) for tile in range(16))
