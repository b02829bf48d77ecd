"""Straight-edged pieces of scene triangles in ray triangles, against the exact picture and the shapes of the thesis."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from test_trilinear_shapes import EXACT, ROUNDED, examples, scene

from anamorph.errors import AnamorphError
from anamorph.trilinear import project_triangle, straight, straight_pieces
from anamorph.trilinear.strips import GUARD

PLAIN = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]])
"""A picture in which places are u and v."""

ONE = np.zeros((1, 2), int)
QUICK = settings(max_examples=40, deadline=None, phases=(Phase.explicit, Phase.generate))
SEEDS = st.integers(0, 2**32 - 1)


def pieces_of(p, n, corners, picture=PLAIN, **options):
    return straight_pieces(picture[None], p[None], n[None], corners[None], ONE, **options)


def seen_exactly(picture, p, n, corners, places, near=0.0):
    """Where the triangle is seen at places (N, 2) inside a ray triangle: the signs of three quadratics; t as well."""
    w = np.linalg.inv(picture).T @ np.vstack([places.T, np.ones(len(places))])
    o, d, s = w.T @ p, w.T @ n, w.sum(axis=0)[:, None]
    a, b, c = corners
    edges = [np.sum(d * np.cross(x * s - o, y - x), axis=1) for x, y in ((a, b), (b, c), (c, a))]
    normal = np.cross(b - a, c - a)
    along = d @ normal
    t = np.sum((a * s - o) * normal, axis=1) / along
    return np.all(np.array(edges) * np.sign(along) >= 0.0, axis=0) & (t >= near), t


def covered(pieces, places):
    """Where places (N, 2) lie in some piece."""
    a, b, c = np.moveaxis(pieces.place.astype(float)[:, :, None], 1, 0)

    def side(x, y):
        return (y - x)[..., 0] * (places - x)[..., 1] - (y - x)[..., 1] * (places - x)[..., 0]

    sides = np.array([side(a, b), side(b, c), side(c, a)])
    return ((sides >= 0.0).all(axis=0) | (sides <= 0.0).all(axis=0)).any(axis=0)


def drawn_in(picture, random, count):
    """Random places in a ray triangle's picture."""
    weights = random.dirichlet([1.0, 1.0, 1.0], count)
    corners = picture[:, :2] / picture[:, 2:]
    return weights @ corners


def wrong(p, n, corners, random, picture=PLAIN, count=2000, near=0.0, **options):
    """The share of the ray triangle's picture that the pieces have wrong."""
    places = drawn_in(picture, random, count)
    pieces = pieces_of(p, n, corners, picture, near=near, **options)
    return np.mean(covered(pieces, places) != seen_exactly(picture, p, n, corners, places, near)[0])


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
def test_the_pieces_fill_the_shapes_as_often_as_their_outlines_go_round(kind, seed, near):
    p, n, corners, _ = scene(seed, kind)
    shapes = project_triangle(p, n, corners, near)
    if not all((shape.valid & (np.abs(shape.u) + np.abs(shape.v) < 1e3)).all() for shape in shapes):
        return
    outlines = [np.stack([shape.u, shape.v], axis=1) for shape in shapes]
    pieces = pieces_of(p, n, corners, near=near, scene_clip=False)
    filled = sum(area(cut_to_triangle(piece)) for piece in pieces.place.astype(float))
    assert -filled == pytest.approx(sum(area(cut_to_triangle(outline)) for outline in outlines), abs=2e-5)


@pytest.mark.parametrize("label", [*EXACT, *ROUNDED])
def test_the_examples_of_the_thesis_are_filled_and_come_out_exact_when_divided_finely(label):
    numbers = np.array(examples()[label], float)
    corners, p, n = numbers[:, :3], numbers[:, 3:6], numbers[:, 6:9]
    outlines = [np.stack([s.u, s.v], axis=1) for s in project_triangle(p, n, corners, 1e-3)]
    pieces = pieces_of(p, n, corners, near=1e-3, scene_clip=False)
    filled = sum(area(cut_to_triangle(piece)) for piece in pieces.place.astype(float))
    assert -filled == pytest.approx(sum(area(cut_to_triangle(outline)) for outline in outlines), abs=1e-4)
    for option in ("tessellate", "slices"):
        for factor in (1, 4, 16):
            print(label, option, factor, wrong(p, n, corners, np.random.default_rng(0), near=1e-3, **{option: factor}))
