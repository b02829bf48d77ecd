"""OpenEXR images: nothing is lost, and what is not read is refused."""

from __future__ import annotations

import io
import os
import subprocess
import sys

import numpy as np
import OpenEXR
import pytest

from anamorph.base.exr import decode_exr, encode_exr

MOST = 10**6
COLOR = np.random.default_rng(3).uniform(0.0, 1e5, (6, 9, 3)).astype(np.float32)


def made(header: dict[str, object] | None = None, **channels: np.ndarray) -> bytes:
    """The bytes of a file with these channels, by the library alone."""
    file = io.BytesIO()
    plain = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File({**plain, **(header or {})}, channels).write(file)
    return file.getvalue()


def plane(value: float, form: type = np.float32, shape: tuple[int, int] = (4, 5)) -> np.ndarray:
    return np.full(shape, value, form)


def test_colours_come_back_to_the_last_bit() -> None:
    assert np.array_equal(decode_exr(encode_exr(COLOR, {}), MOST), COLOR)


def test_layers_stand_beside_the_colours_under_their_names() -> None:
    numbers = np.arange(54, dtype=np.uint8).reshape(6, 9)
    data = encode_exr(COLOR, {"status": numbers, "position": COLOR.astype(float), "deviation": COLOR[..., 0]})
    channels = OpenEXR.File(io.BytesIO(data), separate_channels=True).channels()
    assert channels.keys() == {"R", "G", "B", "status", "position.X", "position.Y", "position.Z", "deviation"}
    assert channels["status"].pixels.dtype == np.uint32 and np.array_equal(channels["status"].pixels, numbers)
    assert np.array_equal(channels["position.Y"].pixels, COLOR[..., 1])
    assert channels["deviation"].pixels.dtype == np.float32


@pytest.mark.parametrize("form", [np.float16, np.float32])
def test_halves_greys_and_further_channels_are_read(form: type) -> None:
    colors = made(R=plane(1.0, form), G=plane(2.0, form), B=plane(3.0, form), A=plane(0.5, form), depth=plane(9.0))
    assert (decode_exr(colors, MOST) == [1.0, 2.0, 3.0]).all()
    assert (decode_exr(made(Y=plane(2.5, form)), MOST) == 2.5).all()


def test_what_is_not_read_is_refused() -> None:
    colors = {name: plane(1.0) for name in "RGB"}
    wide = (0.708, 0.292, 0.17, 0.797, 0.131, 0.046, 0.3127, 0.329)
    window = (np.array([0, 0], np.int32), np.array([9, 9], np.int32))
    for data, words in (
        (made({"chromaticities": wide}, **colors), "other primaries"),
        (made({"displayWindow": window}, **colors), "data window"),
        (made(Z=plane(1.0)), "the channels Z, and neither R, G, B nor Y"),
        (made(**{name: plane(1.0, shape=(1100, 1100)) for name in "RGB"}), "1100 x 1100 pixels"),
    ):
        with pytest.raises(ValueError, match=words):
            decode_exr(data, MOST)


@pytest.mark.parametrize("share", [0.0, 0.02, 0.3, 0.9])
def test_damage_is_refused_without_a_word_of_the_librarys(share: float, capfd: pytest.CaptureFixture[str]) -> None:
    data = encode_exr(COLOR, {})
    with pytest.raises(ValueError, match="no whole"):
        decode_exr(data[: int(share * len(data))], MOST)
    assert capfd.readouterr() == ("", "")


def test_an_attribute_of_another_type_is_refused() -> None:
    data = encode_exr(COLOR, {}).replace(b"chromaticities\0chromaticities\0", b"chromaticities\0chromaticitiez\0")
    with pytest.raises(ValueError, match="a damaged header"):
        decode_exr(data, MOST)


def test_a_program_without_a_terminal_reads_and_writes_all_the_same() -> None:
    code = """
import os, sys
import numpy as np, OpenEXR
from anamorph.base.exr import decode_exr, encode_exr
data = encode_exr(np.ones((2, 3, 3), np.float32), {})
os.closerange(0, 3)
sys.stdout = None
assert (decode_exr(data, 9) == 1.0).all()
"""
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_what_is_printed_afterwards_is_seen_again(capfd: pytest.CaptureFixture[str]) -> None:
    decode_exr(encode_exr(COLOR, {}), MOST)
    os.write(1, b"after\n")
    assert capfd.readouterr().out == "after\n"
