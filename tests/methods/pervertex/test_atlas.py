"""Many maps in one texture: none lies on another, and each is drawn into its own rectangle alone."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scenes import CAMERA, scene_with, spherical_mirror

from anamorph.gpu.buffers import upload_scene
from anamorph.gpu.device import get_device
from anamorph.gpu.drawing import submit
from anamorph.gpu.targets import read_texture
from anamorph.methods.pervertex.atlas import Atlas, MapKind, MapView
from anamorph.methods.pervertex.rectangles import arrange, shrunk
from anamorph.projection import camera_projection
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import flatten

SIDES = st.one_of(st.integers(1, 700), st.sampled_from([1, 15, 16, 17]))
RECTANGLES = st.lists(st.tuples(SIDES, SIDES), min_size=1, max_size=20)


@given(RECTANGLES, st.sampled_from([704, 1024, 8192]), st.sampled_from([1, 16]))
def test_rectangles_lie_apart_and_within_the_width(sizes, widest, alignment):
    corners, (right, bottom) = arrange(sizes, widest, alignment)
    assert len(corners) == len(sizes) and right <= widest
    taken = np.zeros((bottom, right), bool)
    for (x, y), (width, height) in zip(corners, sizes, strict=True):
        # No cell of so many texels belongs to two.
        assert x % alignment == y % alignment == 0
        assert x + width <= right and y + height <= bottom
        place = slice(y, -(-(y + height) // alignment) * alignment), slice(x, -(-(x + width) // alignment) * alignment)
        assert not taken[place].any()
        taken[place] = True


@given(st.lists(st.tuples(st.integers(64, 128), st.integers(64, 128)), min_size=9, max_size=40))
def test_maps_of_like_sizes_leave_little_room_between_them(sizes):
    _, (right, bottom) = arrange(sizes, 8192)
    assert right * bottom <= 3.0 * sum(width * height for width, height in sizes)
    assert 0.25 <= right / bottom <= 4.0


@given(RECTANGLES, st.sampled_from([704, 1024, 8192]), st.sampled_from([2_000, 100_000, 1 << 24]))
def test_what_is_too_large_together_shrinks_alike_and_nothing_else_does(sizes, widest, most):
    fitting = shrunk(sizes, widest, most)
    assert max(arrange(fitting, widest)[1]) <= widest
    assert sum(width * height for width, height in fitting) <= max(most, len(sizes))
    if max(arrange(sizes, widest)[1]) <= widest and sum(width * height for width, height in sizes) <= most:
        assert fitting == sizes
    sides = [pair for pair in zip(np.ravel(fitting), np.ravel(sizes), strict=True) if pair[0] > 1]
    # One factor gives them all, rounded down.
    assert not sides or max(new / old for new, old in sides) < min((new + 1) / old for new, old in sides)


def test_maps_that_the_largest_texture_cannot_hold_are_drawn_smaller(buffers, monkeypatch):
    monkeypatch.setattr("anamorph.methods.pervertex.rectangles.LARGEST", 256)
    scene, count = buffers
    atlas = Atlas()
    atlas.place(views_of([(200, 200)] * 3, count))
    assert max(atlas.color.size[:2]) <= 256
    assert all(texels[..., :3].std() > 0.0 for texels in drawn_maps(atlas, scene, MapKind.COLOR))
    for words, view in zip(atlas.rectangles.projections, atlas.rectangles.maps, strict=True):
        assert words[-4:-2].tolist() == list(view.size)


def eyes():
    return [CAMERA, Camera((-0.6, 0.9, 2.4), (0.0, 0.5, 0.0)), Camera((0.2, 0.4, -2.0), (0.0, 0.5, 0.0))]


def views_of(sizes, count):
    return [
        MapView(camera_projection(camera, size), size, np.ones(count, bool))
        for camera, size in zip(eyes(), sizes, strict=True)
    ]


@pytest.fixture(scope="module")
def buffers():
    scene = scene_with(spherical_mirror())
    return upload_scene(scene, flatten(scene)), len(scene.meshes)


def drawn_maps(atlas, buffers, kind):
    """What lies in each map's rectangle."""
    encoder = get_device().create_command_encoder()
    atlas.draw(encoder, buffers, kind)
    submit(encoder)
    texels = read_texture(atlas.color if kind == MapKind.COLOR else atlas.depth)
    return [
        texels[y : y + view.size[1], x : x + view.size[0]]
        for view, (x, y) in zip(atlas.rectangles.maps, atlas.rectangles.corners, strict=True)
    ]


@pytest.mark.parametrize("kind", [MapKind.COLOR, MapKind.DEPTH])
def test_each_map_is_what_it_is_alone(buffers, kind):
    scene, count = buffers
    together = Atlas()
    views = views_of([(90, 60), (50, 100), (64, 64)], count)
    together.place(views)
    for view, texels in zip(views, drawn_maps(together, scene, kind), strict=True):
        alone = Atlas()
        alone.place([view])
        (expected,) = drawn_maps(alone, scene, kind)
        # Where it lies in the texture decides how triangles' edges are rounded.
        same = np.isclose(texels, expected, rtol=2e-3, atol=1e-6).all(axis=-1)
        assert same.mean() > 0.98
        assert texels[..., :3].std() > 0.0


def test_textures_stay_while_maps_change_a_little_and_shrink_after_much(buffers):
    _, count = buffers
    atlas = Atlas()
    assert atlas.place(views_of([(600, 400)] * 3, count))
    color = atlas.color
    assert not atlas.place(views_of([(630, 410), (590, 400), (600, 390)], count))
    assert not atlas.place(views_of([(500, 300)] * 3, count))
    assert atlas.color is color
    assert atlas.place(views_of([(1200, 400)] * 3, count)), "no room"
    assert atlas.place(views_of([(300, 200)] * 3, count)), "far too much room"
    assert not atlas.place(views_of([(16, 16)] * 3, count)[:1]) or atlas.color.size[0] <= 512
    assert atlas.color.size[0] >= 256


def test_shaders_get_each_maps_corner(buffers):
    _, count = buffers
    atlas = Atlas()
    views = views_of([(90, 60), (50, 100), (64, 64)], count)
    atlas.place(views)
    for words, view, corner in zip(atlas.rectangles.projections, views, atlas.rectangles.corners, strict=True):
        assert words[-4:].tolist() == [*view.size, *corner]
        assert words.tolist() == view.projection.uniform(view.size, corner).tolist()


def test_ends_are_kept_only_where_they_are_asked_for(buffers):
    _, count = buffers
    with_ends, without = Atlas(ends=True), Atlas()
    for atlas in (with_ends, without):
        atlas.place(views_of([(90, 60), (50, 100), (64, 64)], count))
    assert with_ends.end.size == with_ends.color.size
    assert without.end.size[:2] == (1, 1)
