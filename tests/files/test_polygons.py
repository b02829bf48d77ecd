"""Polygons as triangles: whatever their form, they are covered once, and no corner is lost."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from anamorph.base.notes import AnamorphNote
from anamorph.files.polygons import triangulated

# A wall with a notch, in the shape of a C.
NOTCHED = [(-1, 0), (1, 0), (1, 2), (-1, 2), (-1, 1.6), (0.6, 1.6), (0.6, 0.4), (-1, 0.4)]
DART = [(-1.0, 0.0), (0.0, 0.4), (1.0, 0.0), (0.0, 1.0)]
# A frame: outline and hole, joined by a bridge that is walked there and back.
FRAME = [(0, 0), (4, 0), (4, 4), (0, 4), (0, 0), (1, 1), (1, 3), (3, 3), (3, 1), (1, 1)]
TWO_HOLES = [(0, 0), (9, 0), (9, 4), (0, 4), (0, 0), (1, 1), (1, 3), (3, 3), (3, 1), (6, 1), (6, 3), (8, 3), (8, 1),
             (6, 1), (3, 1), (1, 1)]  # fmt: skip
REPEATED = [(0, 0), (2, 0), (2, 0), (2, 2), (1, 0.5), (1, 0.5), (0, 2), (0, 2)]
ON_LINES = [(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 1), (0, 2), (0, 1)]
SPIKE = [(0, 0), (2, 0), (2, 1), (2, 3), (2, 1), (1, 0.5), (0, 1)]

TURN = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
TURN *= np.linalg.det(TURN)


def doubled(corners: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    one, two, three = np.moveaxis(corners[triangles], 1, 0)
    return np.cross(two - one, three - one)


def shoelace(outline: np.ndarray) -> float:
    x, y = outline.T
    return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) / 2.0)


@pytest.mark.parametrize(
    ("outline", "area"),
    [
        (NOTCHED, 2.08),
        (DART, 0.6),
        (FRAME, 12.0),
        (TWO_HOLES, 28.0),
        (REPEATED, 2.5),
        (ON_LINES, 3.0),
        (SPIKE, 1.5),
    ],
)
@pytest.mark.parametrize(("place", "size"), [(0.0, 1.0), (0.0, 1e-6), (5e6, 1.0)])
def test_concave_polygons_are_covered_once(
    outline: list[tuple[float, float]], area: float, place: float, size: float
) -> None:
    """From every first corner, either way round, and turned in space; far away too."""
    flat = size * np.array(outline, float)
    for shift in range(len(flat)):
        for way in (1, -1):
            corners = np.column_stack([np.roll(flat, shift, axis=0)[::way], np.zeros(len(flat))]) @ TURN.T + place
            triangles, polygons = triangulated(corners, np.array([len(corners)]), "part")
            areas = doubled(corners, triangles) / 2.0
            assert areas.sum(axis=0) == pytest.approx(way * area * size**2 * TURN[:, 2], abs=1e-6 * size**2)
            assert np.linalg.norm(areas, axis=1).sum() == pytest.approx(area * size**2, rel=1e-6)
            assert not polygons.any()


def test_polygons_of_all_kinds_stand_beside_one_another() -> None:
    outlines = [
        DART,
        [(0, 0), (1, 0)],
        NOTCHED,
        [(0, 0), (1, 0), (0, 1)],
        [(0, 0), (1, 0), (1, 1), (0, 1)],
        [(5, 5)],
        DART,
    ]
    corners = np.array([(x, y, 0.0) for outline in outlines for x, y in outline])
    triangles, polygons = triangulated(corners, np.array([len(outline) for outline in outlines]), "part")
    areas = np.bincount(polygons, doubled(corners, triangles)[:, 2] / 2.0, minlength=len(outlines))
    assert areas == pytest.approx([0.6, 0.0, 2.08, 0.5, 1.0, 0.0, 0.6])
    assert (np.diff(polygons) >= 0).all()
    owners = np.repeat(np.arange(len(outlines)), [len(outline) for outline in outlines])
    assert (owners[triangles] == polygons[:, None]).all()


def test_no_polygons_have_no_triangles() -> None:
    triangles, polygons = triangulated(np.zeros((0, 3)), np.zeros(0, int), "part")
    assert triangles.shape == (0, 3) and polygons.shape == (0,)


def border(triangles: np.ndarray) -> set[tuple[int, int]]:
    """The edges that one triangle alone has."""
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    each, times = np.unique(edges, axis=0, return_counts=True)
    return {(int(one), int(two)) for one, two in each[times == 1]}


# Seen along the normal, which is z, what sticks out of the plane lies on straight edges.
BENT = [(0, 0, 0), (1.5, 0, 0.1), (3, 0, 0), (3, 2, 0), (2, 2, 0), (2, 1, 0), (1.5, 1, 0.3), (1, 1, 0), (1, 2, 0),
        (0, 2, 0)]  # fmt: skip


def test_the_border_of_the_triangles_is_the_polygon_s() -> None:
    """Corners that lie on its edges as they are seen stay corners."""
    for shift in range(len(BENT)):
        corners = np.roll(np.array(BENT, float), shift, axis=0)
        triangles, _ = triangulated(corners, np.array([len(corners)]), "part")
        around = [sorted((row, (row + 1) % len(corners))) for row in range(len(corners))]
        assert border(triangles) == {(one, two) for one, two in around}


def test_a_bent_quadrilateral_keeps_its_outline() -> None:
    corners = np.array([[0, 0, 0], [1, 0, 0.3], [1, 1, 0], [0, 1, 0.3]], float)
    triangles, _ = triangulated(corners, np.array([4]), "part")
    assert len(triangles) == 2 and set(triangles.reshape(-1).tolist()) == {0, 1, 2, 3}


def test_a_polygon_that_crosses_itself_is_told() -> None:
    bow_tie = np.array([[0, 0, 0], [1, 1, 0], [1, 0, 0], [0, 1, 0]], float)
    with pytest.warns(AnamorphNote, match=r"^wall: 1 of its polygons cross themselves"):
        triangulated(bow_tie, np.array([4]), "wall")


@given(st.lists(st.floats(0.05, 1.0), min_size=4, max_size=24), st.integers(0, 23))
def test_stars_are_covered_once(radii: list[float], first: int) -> None:
    """Polygons around a point are simple, and concave wherever a radius is short beside its neighbours."""
    angles = np.linspace(0.0, 2.0 * np.pi, len(radii), endpoint=False)
    flat = np.roll(np.array(radii)[:, None] * np.column_stack([np.cos(angles), np.sin(angles)]), first, axis=0)
    corners = np.column_stack([flat, np.full(len(flat), 3.0)]) @ TURN.T
    with warnings.catch_warnings():
        warnings.simplefilter("error", AnamorphNote)
        triangles, _ = triangulated(corners, np.array([len(corners)]), "part")
    sizes = np.linalg.norm(doubled(corners, triangles), axis=1) / 2.0
    assert sizes.sum() == pytest.approx(shoelace(flat), rel=1e-6)
