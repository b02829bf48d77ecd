"""Files appear whole or not at all, in the format of their suffix."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from anamorph.base.errors import AnamorphError
from anamorph.base.exr import decode_exr
from anamorph.base.output import (
    IMAGES,
    PIXELS,
    check_output,
    save_array,
    save_image,
    save_text,
    whole_file,
)
from anamorph.base.radiance import decode_radiance
from anamorph.base.srgb import encode_srgb

IMAGE = np.linspace(0.0, 1.0, 4 * 5 * 3, dtype=np.float32).reshape(4, 5, 3)


def test_srgb_follows_its_standard():
    assert encode_srgb(np.array([0.0, 0.001, 0.0031308, 0.18, 1.0])) == pytest.approx(
        [0.0, 0.01292, 0.04045, 0.46136, 1.0], abs=1e-5
    )
    assert encode_srgb(np.array([-1.0, 7.0])) == pytest.approx([0.0, 1.0])


@pytest.mark.parametrize("suffix", PIXELS)
def test_an_image_comes_back_as_srgb(tmp_path, suffix):
    path = tmp_path / f"a{suffix.upper()}"
    grey = np.full((16, 16, 3), 0.18, np.float32)
    save_image(path, grey)
    with Image.open(path) as image:
        pixels = np.asarray(image.convert("RGB"))
    assert pixels.shape == (16, 16, 3)
    assert np.abs(pixels.astype(int) - 118).max() <= 1


def test_a_png_is_exact_and_the_first_row_is_on_top(tmp_path):
    save_image(tmp_path / "a.png", IMAGE)
    with Image.open(tmp_path / "a.png") as image:
        assert np.array_equal(np.asarray(image), np.round(255 * encode_srgb(IMAGE)).astype(np.uint8))


def test_npy_keeps_linear_floats(tmp_path):
    bright = 10.0 * IMAGE
    save_image(tmp_path / "a.npy", bright)
    assert np.array_equal(np.load(tmp_path / "a.npy"), bright)


def test_exr_keeps_linear_floats_and_layers_and_hdr_what_it_has_place_for(tmp_path):
    bright = 10.0 * IMAGE
    save_image(tmp_path / "a.exr", bright, {"status": np.ones((4, 5), np.uint8)})
    assert np.array_equal(decode_exr((tmp_path / "a.exr").read_bytes(), 100), bright)
    save_image(tmp_path / "a.hdr", bright)
    assert decode_radiance((tmp_path / "a.hdr").read_bytes(), 100) == pytest.approx(bright, abs=10.0 / 256)


@pytest.mark.parametrize("suffix", [suffix for suffix in IMAGES if suffix != ".exr"])
def test_layers_are_refused_where_there_is_no_place_for_them(tmp_path, suffix):
    with pytest.raises(AnamorphError, match=r"has no place for status; end the name in \.exr"):
        save_image(tmp_path / f"a{suffix}", IMAGE, {"status": np.ones((4, 5), np.uint8)})
    assert not list(tmp_path.iterdir())


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "a.txt"
    save_text(path, "old")

    def interrupted() -> None:
        with whole_file(path) as file:
            file.write(b"half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["a.txt"]


def test_an_unfinished_file_does_not_have_the_name_yet(tmp_path):
    path = tmp_path / "a.txt"
    with whole_file(path) as file:
        file.write(b"whole")
        assert not path.exists()
    assert path.read_bytes() == b"whole"
    assert os.listdir(tmp_path) == ["a.txt"]


def test_a_link_stays_a_link(tmp_path):
    (tmp_path / "link.txt").symlink_to(tmp_path / "real.txt")
    save_text(tmp_path / "link.txt", "text")
    assert (tmp_path / "link.txt").is_symlink()
    assert (tmp_path / "real.txt").read_text() == "text"


@pytest.mark.parametrize("name", ["a.gif", "a", "a.tif", ".png"])
def test_an_unknown_suffix_is_refused_with_the_known_ones(tmp_path, name):
    with pytest.raises(AnamorphError, match=r"end the name in \.png"):
        check_output(tmp_path / name, IMAGES)


def test_a_missing_directory_and_a_directory_in_the_way_are_refused(tmp_path):
    with pytest.raises(AnamorphError, match="there is no directory"):
        save_image(tmp_path / "no" / "a.png", IMAGE)
    with pytest.raises(AnamorphError, match="not a plain file"):
        (tmp_path / "b.png").mkdir()
        save_image(tmp_path / "b.png", IMAGE)
    with pytest.raises(AnamorphError, match="not a plain file"):
        save_text(Path("/dev/null"), "text")
    assert Path("/dev/null").is_char_device()


def test_arrays_are_saved_as_npy_only(tmp_path):
    save_array(tmp_path / "a.npy", np.arange(3))
    assert np.load(tmp_path / "a.npy").tolist() == [0, 1, 2]
    with pytest.raises(AnamorphError, match=r"end the name in \.npy"):
        save_array(tmp_path / "a.txt", np.arange(3))


@pytest.mark.parametrize("suffix", [suffix for suffix in IMAGES if suffix != ".npy"])
def test_an_image_that_is_not_finite_is_refused_and_not_written(tmp_path, suffix):
    with pytest.raises(AnamorphError, match="not finite"):
        save_image(tmp_path / f"a{suffix}", np.full((2, 2, 3), np.nan))
    assert not os.listdir(tmp_path)
