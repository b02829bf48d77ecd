"""Errors against the reference: closed forms for a plane and a sphere, silhouettes, and what must hold for any
frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from frames import SIZE, WALL, plane_truth, sphere_truth
from hypothesis import given, settings
from hypothesis import strategies as st

from anamorph.base.errors import AnamorphError
from anamorph.frame import Frame
from anamorph.measure.angles import angles_between, image_distances
from anamorph.measure.errors import measure, silhouettes
from anamorph.measure.pixel_errors import footprint


def test_the_truth_has_no_error_against_itself():
    for reference in (plane_truth(), plane_truth(sky=True), sphere_truth()):
        errors = measure(reference, reference)
        assert errors.angular_mrad.max < 1e-3
        assert errors.pixels.max < 0.02
        assert errors.other_object_percent == errors.silhouette_percent == 0.0
        assert errors.rmse == errors.flip == errors.relative_error == 0.0


@pytest.mark.parametrize("shift", [(0.02, 0.0), (0.0, -0.05), (0.03, 0.04)])
def test_a_shift_on_a_flat_mirror_is_a_known_angle_and_a_known_number_of_pixels(shift):
    reference = plane_truth()
    # the mirrored wall is 10 m from the eye, and the image's scale is 50 pixels a metre at 1 m
    moved = replace(reference, position=reference.position + np.float32([*shift, 0.0]))
    errors = measure(reference, moved)
    pixels = np.hypot(*shift) * 50.0 / 10.0
    assert errors.maps.pixels == pytest.approx(np.full(reference.specular.shape, pixels), rel=1e-2)
    first = reference.position.astype(float) - reference.ray_origin
    second = moved.position.astype(float) - reference.ray_origin
    cosine = np.sum(first * second, -1) / np.linalg.norm(first, axis=-1) / np.linalg.norm(second, axis=-1)
    assert errors.maps.angular == pytest.approx(1000.0 * np.arccos(cosine), rel=1e-2)
    assert errors.pixels.median == pytest.approx(np.median(errors.maps.pixels))


def test_pixels_stay_true_far_from_the_ray():
    reference = plane_truth()
    errors = measure(reference, replace(reference, position=reference.position + np.float32([6.0, 0.0, 0.0])))
    assert errors.maps.pixels[16, 24] == pytest.approx(6.0 * 50.0 / 10.0, rel=2e-2)


def test_footprints_do_not_reach_across_to_another_surface():
    reference = plane_truth()
    surface = reference.specular.astype(np.int64)
    surface[:, 24:] = 8
    origins, directions = reference.ray_origin, reference.ray_direction

    def rightwards(column: int) -> np.ndarray:
        return np.array(footprint(origins, directions, surface, 16, column, 0, 1, 9.0))

    whole = rightwards(23), rightwards(24)
    # the other surface is a little nearer: not enough to be taken for an inner silhouette
    origins[:, 24:, 0] += 0.1
    assert np.allclose((rightwards(23), rightwards(24)), whole, atol=1e-6)
    assert whole[0] == pytest.approx([10.0 / 50.0, 0.0, 0.0], abs=2e-2)


def test_the_same_direction_from_afar_is_no_angular_error_but_a_nearer_point_on_another_ray_is():
    reference = plane_truth()
    along = replace(reference, position=reference.position + 3.0 * reference.ray_direction)
    assert measure(reference, along).angular_mrad.max < 1e-3
    assert measure(reference, along).pixels.max < 0.02


def test_a_turned_sky_is_a_known_angle_and_a_known_number_of_pixels():
    reference = plane_truth(sky=True)
    turned = reference.ray_direction + np.float32([0.001, 0.0, 0.0])
    errors = measure(reference, replace(reference, position=turned))
    assert errors.angular_mrad.max == pytest.approx(1.0, rel=1e-2)
    # in the middle of the image one pixel is 1/50 rad
    assert errors.maps.pixels[16, 24] == pytest.approx(0.05, rel=1e-2)


def test_a_convex_sphere_shows_a_wall_smaller_by_its_magnification():
    radius = 1.4
    reference = sphere_truth(radius)
    errors = measure(reference, replace(reference, position=reference.position + np.float32([0.01, 0.0, 0.0])))
    # near the axis d = (2 x / R, 2 y / R, 1): one millimetre of mirror is 1 + 2 D / R millimetres of wall
    assert errors.maps.pixels[16, 24] == pytest.approx(10.0 / (1.0 + 2.0 * WALL / radius), rel=2e-3)
    assert errors.maps.angular[16, 24] == pytest.approx(1000.0 * 0.01 / WALL, rel=2e-3)


def test_a_sphere_magnifies_the_sky_by_twice_its_curvature():
    reference = sphere_truth(1.4)
    seen = reference.ray_direction + np.float32([0.001, 0.0, 0.0])
    errors = measure(reference, replace(reference, position=seen, object_id=np.zeros_like(reference.object_id)))
    assert errors.maps.pixels[16, 24] == pytest.approx(0.001 / (2 * 0.001 / 1.4), rel=3e-3)


def test_silhouettes_are_the_pixels_with_a_different_neighbour():
    label = np.zeros((5, 6), int)
    label[2, 3] = 1
    expected = np.zeros((5, 6), bool)
    expected[1:4, 2:5] = True
    assert np.array_equal(silhouettes(label), expected)
    assert not silhouettes(np.ones((1, 1))).any()


def test_a_wrong_object_counts_only_away_from_silhouettes():
    reference = plane_truth()
    reference.object_id[:, 24:] = 6
    shifted = np.roll(reference.object_id, 1, axis=1)
    shifted[:, 0] = 5
    errors = measure(reference, replace(reference, object_id=shifted))
    assert errors.silhouette_percent == pytest.approx(100.0 * 2 / 48)
    assert errors.other_object_percent == 0.0
    wrong = reference.object_id.copy()
    wrong[:, 3] = 9
    assert measure(reference, replace(reference, object_id=wrong)).other_object_percent == pytest.approx(100.0 / 46)


def test_silhouettes_are_left_out_of_the_statistics():
    reference = plane_truth()
    reference.object_id[:, 24:] = 6
    wild = reference.position.copy()
    wild[:, 23:25] += 5.0
    errors = measure(reference, replace(reference, position=wild))
    assert errors.angular_mrad.max < 1e-3
    assert errors.pixels.max < 0.02
    assert errors.maps.angular[:, 23:25].min() > 100.0


def test_a_pixel_that_misses_the_mirror_sees_another_object():
    reference = plane_truth()
    specular = reference.specular.copy()
    specular[10, :12] = 0
    errors = measure(reference, replace(reference, specular=specular))
    assert errors.other_object_percent == pytest.approx(100.0 * 12 / reference.specular.size)


def test_an_image_of_no_mirror_has_no_statistics():
    reference = plane_truth()
    reference.specular[:] = 0
    errors = measure(reference, reference)
    assert errors.angular_mrad.median is errors.pixels.max is errors.rmse is errors.flip is None
    assert errors.other_object_percent is errors.silhouette_percent is errors.relative_error is None


def test_pixels_whose_truth_has_no_last_ray_do_not_count():
    reference = plane_truth()
    reference.ray_direction[0, :] = 0.0
    errors = measure(reference, reference)
    assert not errors.maps.specular[0].any()
    assert errors.angular_mrad.max < 1e-3


def test_a_point_on_the_mirror_itself_is_the_worst_answer():
    reference = plane_truth()
    errors = measure(reference, replace(reference, position=reference.ray_origin))
    assert errors.angular_mrad.median == pytest.approx(1000.0 * np.pi)
    assert errors.pixels.median == pytest.approx(np.hypot(*SIZE))


def test_an_inner_silhouette_does_not_make_errors_look_small():
    reference = plane_truth()
    reference.ray_direction[:, 24:] = np.float32([0.8, 0.0, 0.6])
    reference.ray_direction[:, 24:, 1] = 0.001 * np.arange(SIZE[1])[:, None]
    shift = np.float32([0.02, 0.0, 0.0])
    errors = measure(reference, replace(reference, position=reference.position + shift))
    assert errors.maps.pixels[16, 23] == pytest.approx(0.02 * 50.0 / 10.0, rel=1e-2)


def test_where_moving_in_the_image_moves_nothing_the_error_is_the_limit_and_not_a_division_by_zero():
    directions = np.array([[0.0, 0.0, 1.0]] * 2)
    toward = np.array([[0.0, 0.0, 1.0], [0.0, 0.6, 0.8]])
    pixels = image_distances(np.zeros((2, 3)), directions, toward, np.ones(2), np.zeros((2, 3, 2)), limit=60.0)
    assert pixels.tolist() == [0.0, 60.0]


def test_colour_errors_have_their_closed_forms():
    reference = plane_truth()
    errors = measure(reference, replace(reference, color=reference.color + np.float32(0.1)))
    assert errors.rmse == pytest.approx(0.1, rel=1e-5)
    assert errors.relative_error == pytest.approx(0.2, rel=1e-5)
    white, black = np.ones_like(reference.color), np.zeros_like(reference.color)
    opposite = measure(replace(reference, color=white), replace(reference, color=black))
    assert opposite.flip == pytest.approx(0.967, abs=0.01)
    assert measure(replace(reference, color=black), replace(reference, color=white)).relative_error is None


def test_colours_count_only_at_the_mirror():
    reference = plane_truth()
    reference.specular[:, :24] = 0
    color = reference.color.copy()
    color[:, :10] = 0.0
    errors = measure(reference, replace(reference, color=color))
    assert errors.rmse == errors.relative_error == 0.0


@pytest.mark.parametrize("field", ["object_id", "specular", "ray_origin"])
def test_a_missing_buffer_is_named(field):
    with pytest.raises(AnamorphError, match=f"reference: has no '{field}'.*seen=True"):
        measure(replace(plane_truth(), **{field: None}), plane_truth())


def test_values_that_are_not_finite_and_other_sizes_are_refused():
    reference = plane_truth()
    bad = reference.position.copy()
    bad[3, 4, 1] = np.nan
    with pytest.raises(AnamorphError, match="frame: 'position' holds values that are not finite"):
        measure(reference, replace(reference, position=bad))
    with pytest.raises(AnamorphError, match="differ in size"):
        measure(reference, plane_truth((20, 20)))


def test_angles_are_exact_when_tiny_and_when_opposite():
    ahead = np.array([[0.0, 0.0, 1.0]])
    assert angles_between(ahead, np.array([[1e-9, 0.0, 1.0]])) == pytest.approx(1e-9, rel=1e-12)
    assert angles_between(ahead, -ahead) == pytest.approx(np.pi)
    assert angles_between(ahead, np.zeros((1, 3))) == pytest.approx(np.pi)


COORDINATE = st.floats(-1e3, 1e3, width=32) | st.sampled_from([0.0, 1e-30, -1.0, 9.0])


@settings(max_examples=60)
@given(st.tuples(COORDINATE, COORDINATE, COORDINATE), st.booleans(), st.integers(1, 4), st.integers(1, 4))
def test_any_seen_point_has_a_finite_error_within_its_bounds(point, sky, width, height):
    reference = plane_truth((width, height))
    position = np.broadcast_to(np.float32(point), reference.position.shape)
    object_id = np.full(reference.object_id.shape, 0 if sky else 5, np.uint32)
    errors = measure(reference, replace(reference, position=position, object_id=object_id))
    assert 0.0 <= errors.maps.angular.min() <= errors.angular_mrad.max <= 1000.0 * np.pi + 1e-9
    assert 0.0 <= errors.maps.pixels.min() <= errors.pixels.max <= np.hypot(width, height) + 1e-9
    assert errors.angular_mrad.median <= errors.angular_mrad.p95 <= errors.angular_mrad.max


@settings(max_examples=25)
@given(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(0.1, 1e3))
def test_turning_and_scaling_the_world_changes_no_error_in_pixels(turn, tilt, scale):
    def rotation(angle, axis):
        first, second = [i for i in range(3) if i != axis]
        matrix = np.eye(3)
        matrix[[first, second], [first, second]] = np.cos(angle)
        matrix[first, second], matrix[second, first] = -np.sin(angle), np.sin(angle)
        return matrix

    matrix = rotation(turn, 1) @ rotation(tilt, 0)

    def moved(frame: Frame) -> Frame:
        turned = [np.float32(array @ matrix.T) for array in (frame.position, frame.ray_origin, frame.ray_direction)]
        factor = np.float32(scale)
        return replace(frame, position=factor * turned[0], ray_origin=factor * turned[1], ray_direction=turned[2])

    reference = sphere_truth()
    frame = replace(reference, position=reference.position + np.float32([0.01, 0.02, 0.0]))
    before, after = measure(reference, frame), measure(moved(reference), moved(frame))
    assert after.pixels.median == pytest.approx(before.pixels.median, rel=1e-2)
    assert after.angular_mrad.median == pytest.approx(before.angular_mrad.median, rel=1e-3)
