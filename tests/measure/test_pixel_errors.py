"""The compiled errors of every pixel: what plain numpy finds, over frames that hold everything that can go wrong."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from error_twin import errors_of
from frames import frame_of, plane_truth, sphere_truth
from hypothesis import given, settings
from hypothesis import strategies as st

from anamorph.frame import Frame
from anamorph.measure.errors import counted, error_maps, geometry_statistics, measure, silhouettes
from anamorph.measure.pixel_errors import NOTHING, pixel_errors


def wild_frame(random: np.random.Generator, height: int, width: int) -> tuple[Frame, Frame]:
    """A truth and a frame of blocks of sky, of nothing, of missing rays, of other objects, and of caustics."""

    def blocks(values: list, chances: list[float]) -> np.ndarray:
        coarse = random.choice(values, (height // 3 + 1, width // 3 + 1), p=chances)
        return coarse.repeat(3, axis=0).repeat(3, axis=1)[:height, :width]

    shape = (height, width, 3)
    place = np.stack(
        [*np.meshgrid(np.linspace(-1, 1, width), np.linspace(-1, 1, height)), np.zeros((height, width))], -1
    )
    origin = place + blocks([0.0, 1e-3, 5.0], [0.7, 0.2, 0.1])[..., None] * random.normal(size=shape)
    direction = np.array([0.0, 0.0, 1.0]) + blocks([0.0, -0.9, 0.3], [0.2, 0.3, 0.5])[..., None] * place
    direction += blocks([0.0, 1.0], [0.8, 0.2])[..., None] * random.normal(size=shape)
    direction *= blocks([1.0, 0.0, 1e-20, 1e10], [0.7, 0.1, 0.1, 0.1])[..., None]
    unit = direction / np.maximum(np.linalg.norm(direction, axis=-1, keepdims=True), 1e-30)
    far = blocks([9.0, 1e-6, 1e6, -2.0], [0.6, 0.1, 0.2, 0.1])[..., None]
    reference = replace(
        frame_of(origin + far * unit, 5, origin, direction),
        object_id=blocks([5, 6, 0], [0.6, 0.3, 0.1]).astype(np.uint32),
        specular=blocks([7, 8, 0], [0.6, 0.3, 0.1]).astype(np.uint32),
    )
    scatter = blocks([0.0, 1e-6, 0.1, 30.0], [0.2, 0.3, 0.3, 0.2])[..., None] * random.normal(size=shape)
    position = reference.position + scatter.astype(np.float32)
    position[blocks([False, True], [0.9, 0.1])] = 0.0
    on_the_mirror = blocks([False, True], [0.9, 0.1])
    position[on_the_mirror] = reference.ray_origin[on_the_mirror]
    frame = replace(
        reference,
        position=position,
        object_id=np.where(blocks([False, True], [0.8, 0.2]), 0, reference.object_id).astype(np.uint32),
        specular=np.where(blocks([False, True], [0.9, 0.1]), 0, reference.specular).astype(np.uint32),
    )
    return reference, frame


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), st.integers(1, 40), st.integers(1, 14))
def test_plain_numpy_finds_the_same_errors(seed: int, height: int, width: int) -> None:
    reference, frame = wild_frame(np.random.default_rng(seed), height, width)
    maps = error_maps(reference, frame)
    angular, pixels = errors_of(reference, frame, counted(reference))
    assert maps.angular == pytest.approx(angular, rel=1e-9, abs=1e-9)
    assert maps.pixels == pytest.approx(pixels, rel=1e-6, abs=1e-9)
    assert not maps.angular[~maps.specular].any() and not maps.pixels[~maps.specular].any()


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), st.integers(1, 12), st.integers(1, 12))
def test_silhouettes_and_other_objects_are_what_one_finds_pixel_by_pixel(seed: int, height: int, width: int) -> None:
    reference, frame = wild_frame(np.random.default_rng(seed), height, width)
    maps = error_maps(reference, frame)
    surface = np.where(counted(reference), reference.specular.astype(int), NOTHING)
    for row in range(height):
        for column in range(width):
            around = np.s_[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2]
            border = any(len(np.unique(label[around])) > 1 for label in (surface, reference.object_id))
            assert silhouettes(surface, reference.object_id)[row, column] == border
            counts = surface[row, column] != NOTHING
            assert maps.silhouette[row, column] == (counts and border)
            wrong = frame.object_id[row, column] != reference.object_id[row, column]
            wrong |= frame.specular[row, column] == 0 and reference.specular[row, column] != 0
            wrong |= frame.object_id[row, column] == 0 and not frame.position[row, column].any()
            assert maps.other_object[row, column] == (counts and not border and wrong)


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_the_statistics_alone_are_those_of_the_whole_measure(seed: int) -> None:
    reference, frame = wild_frame(np.random.default_rng(seed), 30, 20)
    errors, alone = measure(reference, frame), geometry_statistics(error_maps(reference, frame))
    for name in ("angular_mrad", "pixels", "other_object_percent", "silhouette_percent"):
        assert getattr(errors, name) == getattr(alone, name)


def test_every_row_is_measured_whichever_core_takes_it() -> None:
    reference = sphere_truth()
    tall = [np.tile(array, (9, 1, 1)) for array in (reference.ray_origin, reference.ray_direction, reference.position)]
    surface = np.tile(reference.specular.astype(np.int64), (9, 1))
    surface[:: reference.specular.shape[0]] = NOTHING
    angular, _ = pixel_errors(tall[0], tall[1], surface, tall[2] + np.float32(0.01), np.full(surface.shape, 5))
    for part in np.split(angular, 9):
        assert np.array_equal(part, angular[: len(part)])
        assert (part[1:] > 0.0).all() and not part[0].any()


def test_arrays_that_lie_in_memory_otherwise_are_read_alike() -> None:
    reference = plane_truth()
    moved = replace(reference, position=reference.position + np.float32(0.01))
    flipped = replace(moved, position=np.asfortranarray(moved.position), object_id=moved.object_id[::-1][::-1])
    assert np.array_equal(error_maps(reference, moved).pixels, error_maps(reference, flipped).pixels)
