"""Eyes at a point, at infinity, and towards which lines run: what they see in mirrors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import CAMERA, CENTER, SIZE, flat_mirror, spherical_mirror

from anamorph.optics.reflection import Reflector, reflected_rays, reflector
from anamorph.raymesh import RayStatus
from anamorph.scene.camera import Camera, Eye

SEEDS = st.integers(0, 2**32 - 1)
MATRIX = CAMERA.eye(SIZE).matrix


def eye_of(point):
    return Eye(np.asarray(point, float), MATRIX, SIZE)


def test_lines_of_sight_leave_a_cameras_eye():
    eye = CAMERA.eye(SIZE)
    points = np.random.default_rng(1).normal(size=(5, 3))
    assert eye.offsets(points) == pytest.approx(points - CAMERA.position)
    assert eye_of(2.0 * eye.point).offsets(points) == pytest.approx(2.0 * (points - CAMERA.position))
    assert eye_of(-eye.point).offsets(points) == pytest.approx(CAMERA.position - points)
    assert eye_of([0.0, 0.0, 3.0, 0.0]).offsets(points).tolist() == [[0.0, 0.0, -3.0]] * 5
    assert eye.image(points).tolist() == CAMERA.image(points, SIZE).tolist()


@given(SEEDS, st.sampled_from([-0.5, 0.5, 1.4]), st.floats(3.0, 9.0))
def test_an_eye_at_infinity_is_the_limit_of_distant_ones(seed, radius, power):
    generator = np.random.default_rng(seed)
    mirror = reflector(spherical_mirror(radius))
    toward = generator.normal(size=3)
    toward /= np.linalg.norm(toward)
    parallel = reflected_rays(mirror, eye_of([*toward, 0.0]))
    distant = reflected_rays(mirror, eye_of([*(CENTER + 10.0**power * toward), 1.0]))
    assert distant.unit_directions() == pytest.approx(parallel.unit_directions(), abs=2.0 * 10.0**-power)
    # A homogeneous point is the same eye at any scale.
    scaled = reflected_rays(mirror, eye_of(1e-3 * np.array([*(CENTER + 10.0**power * toward), 1.0])))
    assert scaled.unit_directions() == pytest.approx(distant.unit_directions(), abs=1e-9)
    clear = np.abs(mirror.normals @ toward) > 10.0 ** (1.0 - power)
    assert (parallel.status == distant.status)[clear].all()
    assert ((parallel.status == RayStatus.OK) == (mirror.normals @ toward > 0.0))[clear].all()


@given(SEEDS, st.sampled_from([-0.5, 0.5, 1.4]))
def test_lines_that_run_towards_a_point_are_reflected_before_they_reach_it(seed, radius):
    generator = np.random.default_rng(seed)
    mirror = reflector(spherical_mirror(radius))
    target = CENTER + generator.normal(size=3) * [0.3, 0.3, 0.1] - [0.0, 0.0, generator.uniform(0.3, 5.0)]
    rays = reflected_rays(mirror, eye_of(-np.append(target, 1.0)))
    incident = target - mirror.positions
    incident /= np.linalg.norm(incident, axis=1, keepdims=True)
    cosine = np.sum(incident * mirror.normals, axis=1, keepdims=True)
    assert rays.unit_directions() == pytest.approx(incident - 2.0 * cosine * mirror.normals, abs=1e-12)
    assert ((rays.status == RayStatus.OK) == (cosine[:, 0] < 0.0)).all()
    # Backwards from an eye at that point light takes the same line, and meets the mirror from behind.
    back = reflected_rays(replace(mirror, normals=-mirror.normals), eye_of(np.append(target, 1.0)))
    assert rays.unit_directions() == pytest.approx(-back.unit_directions(), abs=1e-12)


def test_a_flat_mirror_makes_one_point_of_lines_that_run_towards_another():
    """The mirror image of the point behind it, which lies before it: there all reflected lines meet."""
    mirror = reflector(flat_mirror())
    target = np.array([0.1, 0.6, -0.8])
    image = target * [1.0, 1.0, -1.0]
    rays = reflected_rays(mirror, eye_of(-np.append(target, 1.0)))
    assert (rays.status == RayStatus.OK).all()
    # As long as the way to the point: linear on the mirror, as from an eye.
    assert rays.origins + rays.directions == pytest.approx(np.tile(image, (4, 1)), abs=1e-12)
    eye = np.array([0.2, 0.6, 0.7])
    rays = reflected_rays(mirror, eye_of(np.append(eye, 1.0)))
    assert rays.origins - rays.directions == pytest.approx(np.tile(eye * [1.0, 1.0, -1.0], (4, 1)), abs=1e-12)


def test_a_parabolic_mirror_sends_parallel_lines_to_its_focus():
    """Closed form of an eye at infinity before a concave mirror: y^2 + x^2 = 4 f (z + f) around a focus at 0."""
    focal = 0.7
    x, y = np.random.default_rng(2).uniform(-0.8, 0.8, (2, 60))
    points = np.stack([x, y, (x * x + y * y) / (4.0 * focal) - focal], axis=-1)
    normals = np.stack([-x, -y, np.full(60, 2.0 * focal)], axis=-1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    mirror = Reflector(points, normals, np.array([[0, 1, 2]], np.int32))
    rays = reflected_rays(mirror, eye_of([0.0, 0.0, 1.0, 0.0]))
    assert (rays.status == RayStatus.OK).all()
    toward = -points / np.linalg.norm(points, axis=1, keepdims=True)
    assert rays.unit_directions() == pytest.approx(toward, abs=1e-12)
    # And back: from the focus all lines leave along the axis.
    rays = reflected_rays(mirror, eye_of([0.0, 0.0, 0.0, 1.0]))
    assert rays.unit_directions() == pytest.approx(np.tile([0.0, 0.0, 1.0], (60, 1)), abs=1e-12)


def test_a_camera_and_its_eye_agree_on_the_image():
    camera = Camera((1.0, 2.0, 3.0), (-0.5, 1.0, -2.0), (0.1, 1.0, 0.0), 50.0)
    pixels = np.random.default_rng(3).uniform((0, 0), SIZE, (40, 2))
    depths = np.random.default_rng(4).uniform(0.1, 90.0, (40, 1))
    x, y, w = camera.eye(SIZE).image(camera.position + depths * camera.directions(pixels, SIZE)).T
    assert np.stack([x / w, y / w], axis=-1) == pytest.approx(pixels, abs=1e-9)
    assert w == pytest.approx(depths[:, 0] * (camera.directions(pixels, SIZE) @ camera.axes()[2]))


@settings(max_examples=40)
@given(SEEDS, st.integers(1, 30), st.integers(1, 30), st.floats(1.0, 170.0))
def test_all_pixels_at_once_look_where_each_does(seed, width, height, field):
    generator = np.random.default_rng(seed)
    position, target, up = generator.normal(size=(3, 3))
    camera = Camera(tuple(position), tuple(target), tuple(up), field)
    shift = tuple(generator.uniform(-0.5, 0.5, 2))
    pixels = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1) + 0.5 + shift
    directions = camera.pixel_directions((width, height), shift)
    assert directions == pytest.approx(camera.directions(pixels, (width, height)), abs=1e-14)
