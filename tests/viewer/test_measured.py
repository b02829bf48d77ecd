"""The viewer's error and status layers: what colour stands for what, and whether all eyes can tell them apart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from frames import plane_truth
from hypothesis import given, settings
from hypothesis import strategies as st

from anamorph.base.errors import AnamorphError
from anamorph.base.srgb import decode_srgb, encode_srgb
from anamorph.frame import Frame, Status
from anamorph.measure.errors import ErrorMaps
from anamorph.measure.heatmap import MILLIRADIANS, PIXELS, VIRIDIS, Scale, faint, heat_colors, heat_map, scale_colors
from anamorph.viewer.counting import COUNT_COLORS
from anamorph.viewer.measured import (
    ERROR_COLORS,
    OTHER_OBJECT,
    SILHOUETTE,
    STATUS_COLORS,
    error_colors,
    measure_half,
    scale_ticks,
    status_colors,
)

SCALES = (MILLIRADIANS, PIXELS)


def maps_of(errors: np.ndarray) -> ErrorMaps:
    """Maps with the same errors in both units, away from silhouettes."""
    none = np.zeros(errors.shape, bool)
    return ErrorMaps(errors, errors, np.ones(errors.shape, bool), none, none)


def stop(number: int) -> tuple[int, ...]:
    return tuple(int(VIRIDIS[number][i : i + 2], 16) for i in (1, 3, 5))


@pytest.mark.parametrize("scale", SCALES, ids=lambda scale: scale.unit)
def test_known_errors_have_known_colours(scale: Scale) -> None:
    middle = np.sqrt(scale.lowest * scale.highest)
    errors = np.array([[0.0, scale.lowest, middle, scale.highest, 1e30]])
    layer = heat_colors(maps_of(errors), np.zeros((1, 5, 3), np.float32), scale)
    expected = [(*stop(number), 255) for number in (0, 0, 4, 8, 8)]
    assert np.abs(layer[0].astype(int) - expected).max() <= 1


@settings(max_examples=100)
@given(st.floats(0.0, 1e38), st.sampled_from(SCALES))
def test_the_table_of_colours_is_as_good_as_logarithms(error: float, scale: Scale) -> None:
    errors = np.array([[error]])
    layer = heat_colors(maps_of(errors), np.zeros((1, 1, 3), np.float32), scale)
    assert np.abs(layer[..., :3].astype(int) - scale_colors(errors, scale)).max() <= 1


def test_what_is_no_number_has_the_colour_of_the_worst() -> None:
    errors = np.array([[np.nan, -np.nan, np.inf, 3e38]])
    layer = heat_colors(maps_of(errors), np.full((1, 4, 3), np.nan, np.float32))
    assert (layer == (*stop(8), 255)).all()


def test_each_unit_shows_its_own_map() -> None:
    maps = replace(maps_of(np.array([[1000.0]])), pixels=np.array([[0.0]]))
    color = np.zeros((1, 1, 3), np.float32)
    assert tuple(heat_colors(maps, color, MILLIRADIANS)[0, 0, :3]) == stop(8)
    assert tuple(heat_colors(maps, color, PIXELS)[0, 0, :3]) == stop(0)
    assert np.array_equal(heat_map(maps, color), heat_colors(maps, color)[..., :3])


@settings(max_examples=60)
@given(st.lists(st.floats(0.0, 8.0, width=16), min_size=3, max_size=3))
def test_the_image_stays_as_a_grey_between_three_quarters_and_white(color: list[float]) -> None:
    image = np.array([[color]], np.float32)
    grey = 255.0 * (0.75 + 0.2 * float(encode_srgb(image).mean()))
    layer = faint(image)
    assert np.abs(layer[0, 0, :3].astype(float) - grey).max() <= 1.0
    assert layer[0, 0, 3] == 255


def test_silhouettes_and_other_objects_are_marked_and_the_rest_is_the_image() -> None:
    reference = plane_truth()
    reference.object_id[:, 24:] = 6
    reference.specular[:8] = 0
    objects = reference.object_id.copy()
    objects[20, 5] = 9
    frame = replace(reference, object_id=objects, position=reference.position + np.float32([0.02, 0.0, 0.0]))
    measured = measure_half(reference, frame)
    for unit in ("mrad", "px"):
        layer = error_colors(measured, unit)[..., :3]
        assert (layer[10:, 23:25] == SILHOUETTE).all()
        assert (layer[20, 5] == OTHER_OBJECT).all()
        assert np.array_equal(layer[:7], faint(reference.color)[:7, :, :3])
        assert np.ptp(layer[21:, :20].astype(int), axis=-1).min() > 0
    assert set(ERROR_COLORS.values()) == {SILHOUETTE, OTHER_OBJECT}


def test_a_half_is_told_in_figures() -> None:
    reference = plane_truth()
    reference.status[:] = Status.TRACED
    reference.status[:, :12] = Status.OUTSIDE
    moved = replace(reference, position=reference.position + np.float32([0.02, 0.0, 0.0]))
    figures = measure_half(reference, moved).figures
    assert figures.pixels.median == pytest.approx(0.02 * 50.0 / 10.0, rel=2e-2)
    assert figures.other_object_percent == 0.0
    assert figures.status_percent == pytest.approx({"traced": 75.0, "outside": 25.0})


def test_an_image_without_mirrors_has_layers_and_no_figures() -> None:
    reference = plane_truth()
    reference.specular[:] = 0
    measured = measure_half(reference, reference)
    assert measured.figures.angular_mrad.max is measured.figures.other_object_percent is None
    assert np.array_equal(error_colors(measured, "px"), faint(reference.color))


@pytest.mark.parametrize("status", Status)
def test_every_status_has_its_colour(status: Status) -> None:
    reference = plane_truth()
    reference.status[:] = status
    layer = status_colors(reference)
    if status is Status.DIRECT:
        assert np.array_equal(layer, faint(reference.color))
        assert np.abs(layer[..., :3].astype(int) - STATUS_COLORS[status]).max() <= 40
    else:
        assert (layer == (*STATUS_COLORS[status], 255)).all()


def test_the_sky_beside_a_mirror_is_seen_directly_but_not_through_a_ray_mesh() -> None:
    reference = plane_truth()
    reference.status[:] = Status.SKY
    reference.specular[:16] = 0
    layer = status_colors(reference)
    assert np.array_equal(layer[:16], faint(reference.color)[:16])
    assert (layer[16:, :, :3] == STATUS_COLORS[Status.SKY]).all()
    assert (status_colors(replace(reference, ray_mesh=True))[..., :3] == STATUS_COLORS[Status.SKY]).all()


def test_ticks_stand_where_their_colours_do() -> None:
    for scale in SCALES:
        places, labels = zip(*scale_ticks(scale.unit), strict=True)
        assert places[0] == 0.0 and places[-1] == 1.0
        values = [float(label) for label in labels]
        assert values == list(scale.ticks) and (values[0], values[-1]) == (scale.lowest, scale.highest)
        assert np.log(np.array(values) / scale.lowest) / np.log(scale.highest / scale.lowest) == pytest.approx(places)
    assert [label for _, label in scale_ticks("px")] == ["0.01", "0.1", "1", "10", "100"]


def test_what_cannot_be_shown_is_named() -> None:
    reference = plane_truth()
    with pytest.raises(AnamorphError, match="'furlong'; give mrad or px"):
        error_colors(measure_half(reference, reference), "furlong")
    with pytest.raises(AnamorphError, match=r"'status' buffer.*seen=True"):
        status_colors(Frame(reference.color))


EYES = {
    "all cones": np.eye(3),
    "no long": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "no middle": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
    "no short": np.array(
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]
    ),
}
"""What eyes without one kind of cone see of linear colours: Machado, Oliveira and Fernandes 2009."""


def lab(colors: np.ndarray, eye: np.ndarray) -> np.ndarray:
    """CIELAB of 8-bit sRGB colours (N, 3) as an eye sees them."""
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    linear = np.clip(decode_srgb(colors / 255.0) @ eye.T, 0.0, 1.0)
    xyz = linear @ to_xyz.T / to_xyz.sum(axis=1)
    x, y, z = np.where(xyz > 216 / 24389, np.cbrt(xyz), (24389 / 27 * xyz + 16) / 116).T
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=1)


def least_difference(first: np.ndarray, second: np.ndarray, eye: np.ndarray) -> float:
    """CIE 1976; about 2.3 is just noticeable side by side."""
    differences = np.linalg.norm(lab(first, eye)[:, None] - lab(second, eye), axis=-1)
    return float(differences[differences > 0.0].min())


@pytest.mark.parametrize("eye", EYES)
def test_all_eyes_tell_the_colours_apart(eye: str) -> None:
    assert set(STATUS_COLORS) == set(Status)
    greys = faint(np.linspace(0.0, 1.0, 50, dtype=np.float32)[:, None, None].repeat(3, axis=2))[:, 0, :3].astype(float)
    statuses = np.array([color for status, color in STATUS_COLORS.items() if status is not Status.DIRECT], float)
    assert least_difference(statuses, statuses, EYES[eye]) > 20.0
    assert least_difference(statuses, greys, EYES[eye]) > 20.0
    counts = np.array([*COUNT_COLORS.values()], float)
    assert least_difference(counts, counts, EYES[eye]) > 20.0
    assert least_difference(counts, greys, EYES[eye]) > 20.0
    heat = scale_colors(np.geomspace(MILLIRADIANS.lowest, MILLIRADIANS.highest, 200)).astype(float)
    marks = np.array([*ERROR_COLORS.values()], float)
    for others in (heat, greys, marks):
        assert least_difference(marks, others, EYES[eye]) > 20.0
