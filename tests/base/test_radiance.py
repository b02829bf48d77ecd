"""Radiance images: bytes as its manual has them, and light that comes back within its rounding."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from anamorph.base.radiance import decode_radiance, encode_radiance

HEADER = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n"
MOST = 10**6


def test_a_pixel_is_its_mantissas_times_two_to_its_exponent_less_136() -> None:
    data = HEADER % (1, 3) + bytes([128, 64, 0, 129, 255, 1, 0, 136, 9, 9, 9, 0])
    assert decode_radiance(data, MOST).tolist() == [[[1.0, 0.5, 0.0], [255.0, 1.0, 0.0], [0.0, 0.0, 0.0]]]


def test_rows_packed_in_runs_by_their_channels() -> None:
    row = (
        bytes([2, 2, 0, 8]) + bytes([136, 7]) + bytes([8, *range(8)]) + bytes([133, 1, 3, 2, 3, 4]) + bytes([136, 136])
    )
    (pixels,) = decode_radiance(HEADER % (1, 8) + row, MOST)
    assert pixels.tolist() == [[7, green, blue] for green, blue in zip(range(8), [1, 1, 1, 1, 1, 2, 3, 4], strict=True)]


def test_rows_packed_in_repeated_pixels() -> None:
    """Runs of runs count in 256s: 2 and 1 * 256 repetitions after the first pixel."""
    row = bytes([5, 6, 7, 136, 1, 1, 1, 2, 1, 1, 1, 1, 9, 9, 9, 136])
    (pixels,) = decode_radiance(HEADER % (1, 260) + row, MOST)
    assert (pixels[:259] == [5, 6, 7]).all() and (pixels[259] == [9, 9, 9]).all()


def test_exposures_are_taken_back() -> None:
    data = b"#?RADIANCE\n# made by hand\nEXPOSURE=2\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=4\n\n-Y 1 +X 1\n" + bytes(
        [128, 64, 0, 132]
    )
    assert decode_radiance(data, MOST).tolist() == [[[1.0, 0.5, 0.0]]]


light = st.one_of(st.just(0.0), st.floats(1e-30, 1e30), st.sampled_from([1.0, 255 / 256, 255.6 / 256, 1e-38, 2.0**126]))


@given(st.lists(st.tuples(light, light, light), min_size=1, max_size=20))
def test_light_comes_back_within_half_a_step_of_its_brightest_colour(colors: list[tuple[float, float, float]]) -> None:
    color = np.array([colors])
    back = decode_radiance(encode_radiance(color), MOST)
    assert (np.abs(back - color) <= color.max(axis=-1, keepdims=True) / 255.0 + 2.0**-128).all()


def test_light_that_no_exponent_holds_is_refused() -> None:
    with pytest.raises(ValueError, match="beyond"):
        encode_radiance(np.full((1, 1, 3), 1e39))


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "no Radiance header"),
        (b"P6\n1 1\n255\n", "no Radiance header"),
        (HEADER.replace(b"rgbe", b"xyze") % (1, 1) + bytes(4), "no FORMAT"),
        (b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n+X 1 -Y 1\n" + bytes(4), "not -Y"),
        (HEADER % (10**4, 10**4), "at most"),
        (HEADER % (0, 4), "at most"),
        (HEADER % (2, 2) + bytes(12), "too few pixels"),
        (HEADER % (1, 8) + bytes([2, 2, 0, 8, 200, 1]), "damaged row|too few"),
        (HEADER % (1, 8) + bytes([2, 2, 0, 8, 0]), "damaged row"),
        (HEADER % (1, 8) + bytes([2, 2, 0, 8, 4, 1]), "damaged row"),
        (HEADER % (1, 2) + bytes([1, 1, 1, 2, 0, 0, 0, 0]), "damaged row"),
        (HEADER.replace(b"\n\n", b"\nEXPOSURE=nan\n\n") % (1, 1) + bytes(4), "EXPOSURE"),
        (HEADER.replace(b"\n\n", b"\nEXPOSURE=bright\n\n") % (1, 1) + bytes(4), "float"),
    ],
)
def test_what_is_damaged_is_refused(data: bytes, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        decode_radiance(data, MOST)


@given(st.binary(max_size=60))
def test_no_bytes_do_worse(pixels: bytes) -> None:
    for width in (3, 8):
        try:
            assert decode_radiance(HEADER % (2, width) + pixels, MOST).shape == (2, width, 3)
        except ValueError:
            continue
