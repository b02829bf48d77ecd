"""A tree whose vertices move: what rays hit is what they hit in a tree made afresh."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from triangle_soup import geometry_of, random_rays, soup

from anamorph.gallery.solids import lattice
from anamorph.rays import caster as rays
from anamorph.rays import embree
from anamorph.rays.caster import Caster


@pytest.fixture(params=["embree", "embreex"])
def way(request, monkeypatch):
    monkeypatch.setenv("ANAMORPH_RAYS", request.param)
    return request.param


def sea(count=40, time=0.0):
    x, z = np.meshgrid(np.linspace(-2, 2, count), np.linspace(-2, 2, count))
    positions = np.stack([x, 0.4 * np.sin(3.0 * x + time) + 0.2 * np.cos(5.0 * z - time), z], axis=-1).reshape(-1, 3)
    return geometry_of(positions, lattice(count, count))


def assert_like_a_fresh_tree(caster, positions, faces, scale=1.0, ties=False):
    origins, directions = random_rays(700, scale)
    fresh = Caster(geometry_of(positions, faces)).cast(origins, directions)
    found = caster.cast(origins, directions)
    # Triangles that share an edge may both be right for a ray along it, and those that overlap, anywhere.
    assert ties or (found.triangle == fresh.triangle).mean() > 0.998
    assert (np.isinf(found.distance) == np.isinf(fresh.distance)).all()
    hit = np.isfinite(fresh.distance)
    assert hit.sum() > 20
    np.testing.assert_allclose(found.distance[hit], fresh.distance[hit], rtol=1e-5, atol=1e-5 * scale)


@pytest.mark.parametrize("rebuild", [False, True])
def test_small_motions_again_and_again(way, rebuild):
    start = sea()
    caster = Caster(start)
    for time in (0.1, 0.2, 0.9, 4.0, 0.0):
        caster.moved(sea(time=time).positions, rebuild)
        assert_like_a_fresh_tree(caster, sea(time=time).positions, start.faces)
    assert caster.way == way


@pytest.mark.parametrize("rebuild", [False, True])
@settings(max_examples=12)
@given(seed=st.integers(0, 100), scale=st.sampled_from([1e-3, 1.0, 1e4]), flat=st.booleans())
def test_vertices_may_go_anywhere(rebuild, seed, scale, flat):
    """Each to a place of its own: also onto a plane, into points, and into another order of size."""
    start = soup()
    caster = Caster(start)
    for number in range(3):
        positions = soup(scale=scale, seed=100 * seed + number).positions * np.float32([1, 0 if flat else 1, 1])
        positions[:9] = positions[0]
        caster.moved(positions, rebuild)
        assert_like_a_fresh_tree(caster, positions, start.faces, scale, ties=flat)


def test_one_may_change_from_refitting_to_rebuilding_and_back():
    caster = Caster(sea())
    for number, rebuild in enumerate((True, False, False, True)):
        caster.moved(sea(time=number).positions, rebuild)
        assert_like_a_fresh_tree(caster, sea(time=number).positions, sea().faces)


def test_the_caller_may_write_into_its_positions_afterwards():
    caster, positions = Caster(sea()), sea(time=1.0).positions
    for _ in range(2):
        caster.moved(positions)
        positions += 0.125
    assert_like_a_fresh_tree(caster, positions - np.float32(0.125), sea().faces)


def test_without_triangles_there_is_nothing_to_hit(way):
    nothing = geometry_of([[0, 0, 0]], np.zeros((0, 3)))
    caster = Caster(nothing)
    for _ in range(2):
        caster.moved(nothing.positions + np.float32(1.0))
        assert caster.cast([[0, 0, 2.0]], [[0, 0, -1.0]]).triangle[0] == -1


@pytest.fixture
def held():
    """Tells how many bytes Embree holds more than at the beginning."""
    library, device, _ = embree.embree4()
    count = [0]

    @ctypes.CFUNCTYPE(ctypes.c_bool, ctypes.c_void_p, ctypes.c_ssize_t, ctypes.c_bool)
    def monitor(_, more, done):
        count[0] += more
        return True

    library.rtcSetDeviceMemoryMonitorFunction.argtypes = [ctypes.c_void_p] * 3
    library.rtcSetDeviceMemoryMonitorFunction(device, ctypes.cast(monitor, ctypes.c_void_p), None)
    yield lambda: count[0]
    library.rtcSetDeviceMemoryMonitorFunction(device, None, None)


@pytest.mark.parametrize("ways", [(False, False), (True, True), (False, True)], ids=["refit", "rebuild", "in turn"])
def test_moving_takes_no_more_memory_each_time(ways, held):
    start = sea(count=80)
    caster = Caster(start)

    def move_and_look(count: int) -> int:
        for _ in range(count):
            for rebuild in ways:
                caster.moved(start.positions, rebuild)
        return held()

    # One tree over these 12,482 triangles takes more than a megabyte.
    before = move_and_look(5)
    assert before > 1 << 20
    assert move_and_look(20) - before < 1 << 20


def test_a_tree_that_cannot_be_moved_falls_back(monkeypatch):
    def unavailable(tree, positions):
        raise rays.embree.EmbreeUnavailable("Embree could not build its tree")

    caster = Caster(sea())
    caster.moved(sea().positions)
    monkeypatch.setattr(rays.embree.EmbreeTree, "move", unavailable)
    caster.moved(sea(time=2.0).positions)
    assert caster.way == "embreex"
    assert_like_a_fresh_tree(caster, sea(time=2.0).positions, sea().faces)


def test_trees_that_move_to_the_wrong_place_fail_the_check(monkeypatch):
    monkeypatch.setattr(rays.embree.EmbreeTree, "move", lambda tree, positions: None)
    assert not rays.direct_works.__wrapped__()
