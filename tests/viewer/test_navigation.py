"""The laws of moving a camera."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from anamorph.scene.camera import Camera
from anamorph.viewer.navigation import (
    FARTHEST,
    NARROWEST,
    NEAREST,
    OUTERMOST,
    STEEPEST,
    WIDEST,
    look,
    magnify,
    orbit,
    pan,
    zoom,
)

SIZE = (640, 480)
CAMERA = Camera((1.0, 2.0, 3.0), (0.2, -0.4, 0.1), (0.1, 1.0, -0.2), 35.0)

angles = st.one_of(st.sampled_from([0.0, np.pi, -np.pi, 100.0]), st.floats(-7.0, 7.0))
shares = st.one_of(st.just(0.0), st.floats(-3.0, 3.0))
factors = st.one_of(st.just(1.0), st.floats(1e-6, 1e6))


@st.composite
def cameras(draw):
    """Eyes around their target, up to the poles' neighbourhood, near and far, with any up vector."""
    pole = np.array(draw(st.sampled_from([(0.0, 1.0, 0.0), (0.0, 0.0, 2.0), (0.3, -0.9, 0.4)])))
    rise, turn = draw(st.floats(-STEEPEST, STEEPEST)), draw(st.floats(-np.pi, np.pi))
    distance = draw(st.sampled_from([2.0 * NEAREST, 0.3, 1.0, 250.0, 0.5 * FARTHEST]))
    target = np.array([draw(st.sampled_from([0.0, -3.7, 1000.0])) for _ in range(3)])
    axis = pole / np.linalg.norm(pole)
    first = np.cross(axis, (0.6, 0.0, 0.8))
    first = first / np.linalg.norm(first)
    level = np.cos(turn) * first + np.sin(turn) * np.cross(axis, first)
    position = target + distance * (np.cos(rise) * level + np.sin(rise) * axis)
    field_of_view = draw(st.sampled_from([NARROWEST, 40.0, WIDEST]))
    return Camera(tuple(position.tolist()), tuple(target.tolist()), tuple(pole.tolist()), field_of_view)


def distance(camera):
    return float(np.linalg.norm(np.subtract(camera.position, camera.target)))


def rise(camera, vector):
    return float(np.arcsin(np.clip(vector @ camera.up / np.linalg.norm(vector) / np.linalg.norm(camera.up), -1, 1)))


def away(camera):
    return np.subtract(camera.position, camera.target)


def at_target(camera, right, up):
    """The world point at the target's distance that the image shows there, in shares of its height."""
    height = 2.0 * distance(camera) * np.tan(np.radians(camera.field_of_view) / 2.0)
    return camera.target + height * (right * camera.axes()[0] + up * camera.axes()[1])


def shown(camera, point):
    x, y, w = camera.image(np.array([point]), SIZE)[0]
    return np.array([(x / w - SIZE[0] / 2) / SIZE[1], (SIZE[1] / 2 - y / w) / SIZE[1]])


def is_allowed(target):
    """Short of the outermost place of a target, where it is held."""
    return bool((np.abs(target) < 0.999 * OUTERMOST).all())


def close(first, second, scale=1.0):
    """The rounding of coordinates up to 1000 m, against the distance."""
    tolerance = 1e-9 * scale + 1e-11 * (1.0 + np.abs(second.target).max())
    return (
        np.allclose(first.position, second.position, rtol=0, atol=tolerance * (1.0 + distance(second)))
        and np.allclose(first.target, second.target, rtol=0, atol=tolerance * (1.0 + distance(second)))
        and first.field_of_view == pytest.approx(second.field_of_view)
        and first.up == second.up
    )


@given(cameras(), angles, angles)
def test_orbiting_keeps_target_distance_and_horizon(camera, right, up):
    moved = orbit(camera, right, up)
    assert moved.target == camera.target and moved.up == camera.up
    assert distance(moved) == pytest.approx(distance(camera), rel=1e-9, abs=1e-9)
    assert abs(rise(moved, away(moved))) <= STEEPEST + 1e-6
    assert moved.axes()[1] @ camera.up > 0.0, "the image never stands on its head"


@given(cameras(), angles, angles)
def test_looking_around_keeps_eye_distance_and_horizon(camera, right, up):
    moved = look(camera, right, up)
    assert moved.position == pytest.approx(camera.position, rel=1e-9, abs=1e-9)
    assert distance(moved) == pytest.approx(distance(camera), rel=1e-9, abs=1e-9)
    assert abs(rise(moved, away(moved))) <= STEEPEST + 1e-6
    assert moved.axes()[1] @ camera.up > 0.0


@pytest.mark.parametrize("move", [orbit, look])
@given(camera=cameras(), right=angles, up=angles)
def test_there_and_back_again_is_nowhere(move, camera, right, up):
    side = 1.0 if move is orbit else -1.0
    start = rise(camera, side * away(camera))
    up = float(np.clip(up, -STEEPEST - start, STEEPEST - start))
    assert close(move(move(camera, right, up), -right, -up), camera, scale=100.0)
    assert close(move(camera, 0.0, 0.0), camera, scale=100.0)


def test_orbiting_goes_right_and_up_as_seen_by_the_eye():
    camera = Camera((0.0, 0.0, 2.0), (0.0, 0.0, 0.0))
    quarter = np.pi / 2
    assert orbit(camera, quarter, 0.0).position == pytest.approx((2.0, 0.0, 0.0))
    assert orbit(camera, 0.0, np.pi / 4).position == pytest.approx((0.0, np.sqrt(2.0), np.sqrt(2.0)))
    assert look(camera, quarter, 0.0).target == pytest.approx((2.0, 0.0, 2.0))
    assert look(camera, 0.0, np.pi / 4).target == pytest.approx((0.0, np.sqrt(2.0), 2.0 - np.sqrt(2.0)))


def test_at_the_pole_an_orbit_stops_and_comes_down_again():
    above = orbit(CAMERA, 0.0, 50.0)
    assert rise(above, away(above)) == pytest.approx(STEEPEST)
    assert close(orbit(above, 0.0, 1.0), above)
    assert rise(above, away(orbit(above, 0.0, -0.5))) == pytest.approx(STEEPEST - 0.5)


@given(cameras().filter(lambda camera: distance(camera) < 1000.0), shares, shares, shares, shares)
def test_what_is_panned_follows_the_pointer(camera, right, up, x, y):
    moved = pan(camera, right, up)
    before = at_target(camera, x, y)
    assert moved.axes() == pytest.approx(camera.axes(), abs=1e-6)
    assert distance(moved) == pytest.approx(distance(camera), rel=1e-6)
    assert shown(moved, before) == pytest.approx((x + right, y + up), abs=1e-6)
    assert close(pan(moved, -right, -up), camera, scale=100.0)


@given(cameras(), factors, shares, shares, shares, shares)
@example(Camera((0.24, 0.0, -0.18), (0.0, 0.0, 0.0), field_of_view=WIDEST), 1e-6, 0.0, 2.0, 0.0, 0.0)
def test_a_zoom_keeps_what_it_goes_toward_in_its_place(camera, factor, x, y, dx, dy):
    moved = zoom(camera, factor, (x, y))
    nearer = float(np.clip(distance(camera) / factor, NEAREST, FARTHEST))
    assert distance(moved) == pytest.approx(nearer, rel=1e-5)
    assert moved.axes() == pytest.approx(camera.axes(), abs=1e-4)
    scale = distance(camera) / nearer
    wanted = np.add(camera.target, (1.0 - nearer / distance(camera)) * (at_target(camera, x, y) - camera.target))
    assert moved.target == pytest.approx(np.clip(wanted, -OUTERMOST, OUTERMOST), rel=1e-5, abs=1e-5)
    if distance(moved) > 0.1 and scale < 1e4 and is_allowed(wanted):
        assert shown(moved, at_target(camera, x, y)) == pytest.approx((x, y), abs=1e-5)
        other = shown(moved, at_target(camera, x + dx / scale, y + dy / scale))
        assert other == pytest.approx((x + dx, y + dy), abs=1e-5)


@given(cameras(), st.floats(0.1, 10.0), shares, shares)
@example(Camera((0.0, 0.0, 0.5 * FARTHEST), (0.0, 0.0, 0.0), field_of_view=WIDEST), 0.506, 0.0, 3.0)
def test_a_zoom_is_undone_by_its_inverse(camera, factor, x, y):
    moved = zoom(camera, factor, (x, y))
    if 1.001 * NEAREST < distance(moved) < 0.999 * FARTHEST and is_allowed(moved.target):
        assert close(zoom(moved, 1.0 / factor, (x, y)), camera, scale=100.0)


@given(cameras(), factors)
def test_magnifying_scales_the_image_around_its_middle(camera, factor):
    moved = magnify(camera, factor)
    assert NARROWEST <= moved.field_of_view <= WIDEST
    assert (moved.position, moved.target) == (camera.position, camera.target)
    if NARROWEST < moved.field_of_view < WIDEST:
        point = at_target(camera, 0.2 / factor, -0.1 / factor)
        assert shown(moved, point) == pytest.approx((0.2, -0.1), abs=1e-6)
        assert magnify(moved, 1.0 / factor).field_of_view == pytest.approx(camera.field_of_view)


def test_a_target_stays_where_numbers_still_tell_it_from_the_eye():
    camera = replace(CAMERA, field_of_view=150.0)
    for _ in range(200):
        camera = pan(zoom(camera, 0.1), 5.0, 3.0)
    for _ in range(200):
        camera = zoom(pan(camera, 5.0, 3.0), 10.0)
    assert np.abs(camera.target).max() <= OUTERMOST
    assert distance(camera) == pytest.approx(NEAREST, rel=1e-4)
    assert np.isfinite(camera.axes()).all()
