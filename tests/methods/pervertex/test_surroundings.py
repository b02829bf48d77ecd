"""What maps may leave out, and how far rays go past the bodies that send them."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import CAMERA, SIZE, flat_mirror

from anamorph.gallery.solids import box, grid
from anamorph.methods.pervertex.mounting import what_is_behind
from anamorph.methods.pervertex.surroundings import MOST_LAYERS, Surroundings, surroundings_of
from anamorph.optics.ray_meshes import bodies_of
from anamorph.projection import MapFrame, camera_projection, far_projection, map_projection, pinhole_projection
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Diffuse, Scene

SEEDS = st.integers(0, 2**32 - 1)


def random_axes(generator):
    axes = np.linalg.qr(generator.normal(size=(3, 3)))[0]
    axes[2] = np.cross(axes[0], axes[1])
    return axes


def projection_of(kind, generator):
    axes, center = random_axes(generator), generator.normal(size=3)
    if kind == "pinhole":
        return pinhole_projection(center, axes[2], 0.7 * axes[0], 0.4 * axes[1], 1e-3)
    convergence = {"near": -1.0, "far": -1.0, "parallel": 0.0, "spread": 0.8}[kind] * generator.uniform(0.1, 3.0)
    frame = MapFrame(center, axes, generator.uniform(-0.4, 0.4, 2), convergence)
    low = generator.uniform(-1.0, 0.0, 2)
    bounds = np.stack([low, low + generator.uniform(0.1, 1.5, 2)])
    if kind == "far":
        return far_projection(frame, bounds)
    corners = center + 9.0 * (np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3), axis=-1).reshape(-1, 3))
    return map_projection(frame, bounds, np.append(axes[2], -axes[2] @ center + 0.05), corners)


@settings(max_examples=200)
@given(SEEDS, st.sampled_from(["pinhole", "parallel", "spread", "near", "far"]), st.sampled_from([0.0, 0.05, 1.0, 8.0]))
def test_a_mesh_with_a_visible_point_is_never_left_out(seed, kind, extent):
    generator = np.random.default_rng(seed)
    clip = projection_of(kind, generator).clip
    positions = generator.normal(size=(12, 1, 3)) * 3.0 + extent * generator.uniform(-1, 1, (12, 200, 3))
    low, high = positions.min(axis=1), positions.max(axis=1)
    boxes = np.stack([np.stack(np.meshgrid(*pair), axis=-1).reshape(-1, 3) for pair in np.stack([low, high], axis=2)])
    around = Surroundings(SimpleNamespace(), np.zeros(0), boxes[0], boxes, 1.0)
    x, y, z, w = np.moveaxis(positions @ clip[:, :3].T + clip[:, 3], -1, 0)
    shown = (w > 0.0) & (np.abs(x) <= w) & (np.abs(y) <= w) & (z >= 0.0) & (z <= w)
    assert not (shown.any(axis=1) & ~around.visible(clip)).any()


def scene_of(*meshes):
    return Scene("test", meshes, CAMERA)


def cube(middle, half=0.1):
    middle = np.asarray(middle, float)
    return box(tuple(middle - half), tuple(middle + half)).mesh("cube", Diffuse())


def test_what_is_behind_or_beside_is_left_out():
    camera = replace(CAMERA, position=(0.0, 0.0, 0.0), target=(0.0, 0.0, -1.0))
    places = [(0, 0, -2), (0, 0, 2), (5, 0, -2), (-5, 0, -2), (0, 5, -2), (0, -5, -2), (0.7, 0, -2), (0, 0, 0)]
    around = surroundings_of(flatten(scene_of(*(cube(place) for place in places))))
    visible = around.visible(camera_projection(camera, SIZE).clip)
    assert visible.tolist() == [True, False, False, False, False, False, True, True]


def test_beyond_their_crossing_and_before_it_maps_see_their_own_part():
    frame = MapFrame(np.zeros(3), np.eye(3), np.zeros(2), -1.0)
    bounds = np.array([[-0.5, -0.5], [0.5, 0.5]])
    around = surroundings_of(
        flatten(scene_of(cube((0, 0, 0.5)), cube((0, 0, 3.0)), cube((0, 0, 1.0)), cube((0, 0, -3.0))))
    )
    far = far_projection(frame, bounds)
    near = map_projection(frame, bounds, np.array([0.0, 0.0, 1.0, 0.0]), around.corners)
    assert around.visible(far.clip).tolist() == [False, True, True, False]
    assert around.visible(near.clip).tolist() == [True, False, True, False]


def wall(height, name="wall"):
    """Upright across z, looking along +z."""
    return grid((-9.0, -9.0, height), (18.0, 0.0, 0.0), (0.0, 18.0, 0.0)).mesh(name, Diffuse())


def test_what_stands_behind_is_as_far_as_it_is_unless_the_body_itself_comes_first():
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    outward = np.tile([0.0, 0.0, 1.0], (3, 1))
    body, back, before = wall(0.0, "body"), wall(-0.7), wall(2.0)

    def behind(own, *meshes):
        around = surroundings_of(flatten(scene_of(*meshes)))
        return what_is_behind(around.caster, around.face_object, points, outward, own)

    assert behind((1,), body, back, before)[0] == pytest.approx([0.7] * 3)
    assert np.isinf(behind((1,), body, before)[0]).all()
    # The body's own back stands between.
    own = body, back, wall(-0.3, "back")
    distances, closed = behind((1, 3), *own)
    assert np.isinf(distances).all() and closed
    assert not behind((1,), *own)[1]
    assert behind((1,), *own)[0] == pytest.approx([0.3] * 3)
    # Something that only part of the surface has behind it.
    assert behind((1,), body, cube((0.0, 0.0, -0.5)))[0] == pytest.approx([0.4, np.inf, np.inf])


def test_a_mirror_knows_what_stands_behind_it():
    scene = scene_of(flat_mirror(), box((-1.0, 0.0, -0.5), (1.0, 1.0, -0.2)).mesh("block", Diffuse()))
    geometry = flatten(scene)
    bodies = bodies_of(scene, geometry)
    (mounting,) = surroundings_of(geometry, bodies).mountings.values()
    assert mounting.behind == pytest.approx([0.2] * 4)


@pytest.mark.parametrize("layers", range(MOST_LAYERS + 2))
def test_rays_pass_through_their_own_body(layers):
    own = [wall(0.1 + 0.1 * number, "own") for number in range(layers)]
    around = surroundings_of(flatten(scene_of(wall(0.0, "body"), wall(3.0), *own)))
    numbers = (1, *range(3, 3 + layers))
    origins, directions = np.zeros((2, 3)), np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    distances, met = around.cast_past(origins, directions, np.full(2, 1e-6), numbers)
    # What lies behind more layers than are followed counts as the sky.
    assert distances == pytest.approx([3.0 if layers < MOST_LAYERS else np.inf, np.inf])
    assert met.tolist() == [layers > 0, False]


def test_rays_of_one_body_pass_each_its_own_layers():
    """Two layers before one ray, one before another, none before the third."""
    own = [cube((0.0, 0.0, 1.0)), cube((1.0, 0.0, 1.0)), cube((0.0, 0.0, 1.5))]
    around = surroundings_of(flatten(scene_of(wall(0.0, "body"), wall(3.0), *own)))
    origins = np.array([[0.03, 0.02, 0.0], [1.03, 0.02, 0.0], [2.0, 0.0, 0.0]])
    directions = np.tile([0.0, 0.0, 1.0], (3, 1))
    distances, met = around.cast_past(origins, directions, np.full(3, 1e-6), (1, 3, 4, 5))
    assert met.tolist() == [True, True, False]
    assert distances[1:] == pytest.approx([3.0, 3.0])


def test_rays_start_where_they_are_told():
    around = surroundings_of(flatten(scene_of(wall(0.2), wall(1.0), wall(2.0))))
    origins, directions = np.zeros((3, 3)), np.tile([0.0, 0.0, 1.0], (3, 1))
    distances, met = around.cast_past(origins, directions, np.array([0.0, 0.5, 1.5]), (9,))
    assert distances == pytest.approx([0.2, 1.0, 2.0]) and not met.any()


def test_a_occluder_stands_between_the_eye_and_the_point():
    around = surroundings_of(flatten(scene_of(wall(0.0, "body"), cube((0.0, 0.0, 0.5)), cube((1.0, 0.0, -0.5)))))
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    assert around.occluders(np.array([0.0, 0.0, 2.0]), points).tolist() == [2, 0]
    assert around.occluders(np.array([1.0, 0.0, -2.0]), points).tolist() == [0, 3]
