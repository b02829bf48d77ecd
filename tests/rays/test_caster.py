"""Casting rays: both ways against a brute-force search."""

from __future__ import annotations

import os
from concurrent import futures
from threading import Event

import numpy as np
import pytest
import trimesh
from triangle_soup import brute_force, geometry_of, random_rays, soup

from anamorph.base import compiled
from anamorph.base.errors import AnamorphError
from anamorph.rays import caster as rays
from anamorph.rays.caster import Caster


@pytest.fixture(params=["embree", "embreex"])
def way(request, monkeypatch):
    monkeypatch.setenv("ANAMORPH_RAYS", request.param)
    return request.param


def test_direct_way_is_there():
    assert rays.direct_works()


def test_way_follows_the_environment(way):
    assert Caster(soup()).way == way


def test_unknown_way_is_refused(monkeypatch):
    monkeypatch.setenv("ANAMORPH_RAYS", "optix")
    with pytest.raises(AnamorphError, match="ANAMORPH_RAYS"):
        Caster(soup())


def test_a_failed_check_falls_back(monkeypatch):
    monkeypatch.setattr(rays, "direct_works", lambda: False)
    assert Caster(soup()).way == "embreex"


def test_a_wrong_layout_fails_the_check(monkeypatch):
    def wrong(tree, origins, directions, near, coherent, distance, triangle, barycentric):
        distance[:], triangle[:], barycentric[:] = np.inf, -1, 0.0

    monkeypatch.setattr(rays.embree.EmbreeForest, "cast", wrong)
    assert not rays.direct_works.__wrapped__()


def test_a_missing_library_fails_the_check(monkeypatch):
    def missing():
        raise rays.embree.EmbreeUnavailable("no libembree4 inside embreex")

    monkeypatch.setattr(rays.embree, "embree4", missing)
    assert not rays.direct_works.__wrapped__()


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e5])
@pytest.mark.parametrize("coherent", [False, True])
def test_agrees_with_brute_force(way, scale, coherent):
    geometry = soup(scale=scale)
    origins, directions = random_rays(1003, scale)
    hits = Caster(geometry).cast(origins, directions, coherent=coherent)
    distance, triangle, barycentric = brute_force(geometry, origins, directions)
    same = hits.triangle == triangle
    # A ray along an edge may go either way after rounding.
    assert same.mean() > 0.998
    hit = same & (triangle >= 0)
    assert hit.sum() > 100
    assert np.allclose(hits.distance[hit], distance[hit], rtol=1e-4, atol=1e-5 * scale)
    assert np.allclose(hits.barycentric[hit], barycentric[hit], atol=2e-3)
    missed = hits.triangle < 0
    assert np.isinf(hits.distance[missed]).all() and not hits.barycentric[missed].any()


def test_near_skips_the_nearest_hit(way):
    geometry = soup()
    caster = Caster(geometry)
    origins, directions = random_rays(500)
    first = caster.cast(origins, directions)
    hit = first.triangle >= 0
    beyond = first.distance[hit] * 1.001 + 1e-5
    second = caster.cast(origins[hit], directions[hit], near=beyond)
    distance, triangle, _ = brute_force(geometry, origins[hit], directions[hit], beyond[:, None])
    assert (second.triangle == triangle).mean() > 0.99
    assert (second.distance > beyond).all()
    found = (second.triangle == triangle) & (triangle >= 0)
    assert np.allclose(second.distance[found], distance[found], rtol=1e-4)


def test_many_rays_on_all_cores_are_those_of_few(way):
    caster = Caster(soup())
    origins, directions = random_rays(20011)
    whole = caster.cast(origins, directions)
    piece = caster.cast(origins[19000:], directions[19000:])
    assert np.array_equal(whole.triangle[19000:], piece.triangle)
    assert np.array_equal(whole.distance[19000:], piece.distance)


@pytest.mark.parametrize("count", [0, 1, 15, 16, 17])
def test_any_number_of_rays(way, count):
    hits = Caster(geometry_of([[-9, -9, 0], [9, -9, 0], [0, 9, 0]], [[0, 1, 2]])).cast(
        np.tile([0.0, 0.0, 2.0], (count, 1)), np.tile([0.0, 0.0, -1.0], (count, 1))
    )
    assert hits.triangle.tolist() == [0] * count
    assert np.allclose(hits.distance, 2.0)


def test_degenerate_triangles_are_never_hit(way):
    positions = [[-1, -1, 0], [1, -1, 0], [0, 1, 0], [0, 0, 1], [0, 0, 1], [0, 0, 1], [-1, 0, 0.5], [1, 0, 0.5]]
    hits = Caster(geometry_of(positions, [[3, 4, 5], [6, 7, 6], [0, 1, 2]])).cast([[0, 0, 2.0]], [[0, 0, -1.0]])
    assert hits.triangle[0] == 2


def test_a_scene_without_triangles_is_all_miss(way):
    hits = Caster(geometry_of([[0, 0, 0]], np.zeros((0, 3)))).cast([[0, 0, 2.0]], [[0, 0, -1.0]])
    assert hits.triangle[0] == -1


def test_undefined_rays_miss(way):
    hits = Caster(soup()).cast([[np.nan, 0, 0], [0, 0, 0]], [[0, 0, 1.0], [np.nan, 0, 0]])
    assert (hits.triangle == -1).all()


@pytest.mark.parametrize("coherent", [False, True])
def test_rays_that_hardly_turn_from_an_axis_hit(way, coherent):
    """Neighbours' directions may be -1e-19 and -0.1 along an axis: those at the poles of a map are, by rounding."""
    ball = trimesh.creation.icosphere(subdivisions=3)
    directions = np.column_stack([-1e-19 - np.linspace(0.0, 0.3, 64), np.ones(64), np.full(64, -0.2)])
    hits = Caster(geometry_of(ball.vertices, ball.faces)).cast(np.zeros((64, 3)), directions, coherent=coherent)
    assert (hits.triangle >= 0).all()


def test_a_closed_mesh_has_no_gap(monkeypatch):
    """From inside a ball, rays at points of shared edges hit one of the two triangles. The wrapper promises less."""
    monkeypatch.setenv("ANAMORPH_RAYS", "embree")
    ball = trimesh.creation.icosphere(subdivisions=3)
    caster = Caster(geometry_of(ball.vertices, ball.faces))
    random = np.random.default_rng(0)
    ends = ball.vertices[random.choice(ball.edges, 40000)]
    points = ends[:, 0] + random.integers(1, 8, (40000, 1)) / 8.0 * (ends[:, 1] - ends[:, 0])
    origins = random.uniform(-0.5, 0.5, (40000, 3))
    for coherent in (False, True):
        assert (caster.cast(origins, points - origins, coherent=coherent).triangle >= 0).all()


def test_after_a_failed_piece_none_is_running_and_no_other_starts(monkeypatch):
    monkeypatch.setattr(compiled, "cores", lambda: 2)
    begun, ended, given_up = [], [], Event()

    def wait(pieces):
        given_up.set()
        futures.wait(pieces)

    def work(start: int, stop: int) -> None:
        begun.append(start)
        if start == 0:
            raise ValueError("the first piece")
        assert given_up.wait(60.0)
        ended.append(start)

    monkeypatch.setattr(compiled, "wait", wait)
    with pytest.raises(ValueError, match="the first piece"):
        compiled.over_all_cores(work, 400, 1)
    # One that each thread had begun, and the failed one.
    assert len(begun) <= 1 + os.cpu_count()
    assert len(ended) == len(begun) - 1


def test_a_tree_that_cannot_be_built_falls_back(monkeypatch):
    def unavailable(positions, faces, upkeep):
        raise rays.embree.EmbreeUnavailable("Embree could not build its tree")

    assert rays.direct_works()
    monkeypatch.setattr(rays.embree, "EmbreeTree", unavailable)
    rays.embree.tree_over.cache_clear()
    caster = Caster(soup())
    assert caster.way == "embreex"
    assert caster.cast(*random_rays(100)).triangle.max() >= 0
