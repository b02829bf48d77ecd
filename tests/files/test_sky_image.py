"""The image of a sky, from files that hold as much light as there is, and in the scene."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scenes import drawn

from anamorph.base.errors import AnamorphError
from anamorph.base.exr import encode_exr
from anamorph.base.radiance import encode_radiance
from anamorph.files.opening import open_scene
from anamorph.files.sky_image import read_sky_image
from anamorph.gallery.solids import grid
from anamorph.scene.camera import Camera
from anamorph.scene.checks import check_scene
from anamorph.scene.model import Diffuse, LinearImage, Scene, Sky

LIGHT = np.zeros((4, 8, 3), np.float32)
LIGHT[1, 5] = (2000.0, 1000.0, 500.0)
LIGHT[2] = (0.25, 0.5, 0.125)
ENCODED = {".hdr": encode_radiance, ".exr": lambda light: encode_exr(light, {})}


def sky_file(folder: Path, suffix: str, light: np.ndarray = LIGHT) -> Path:
    (folder / f"sky{suffix}").write_bytes(ENCODED[suffix](light))
    return folder / f"sky{suffix}"


@pytest.mark.parametrize("suffix", ENCODED)
def test_light_beyond_white_is_read(tmp_path: Path, suffix: str) -> None:
    image = read_sky_image(sky_file(tmp_path, suffix))
    assert isinstance(image, LinearImage)
    assert image.pixels == pytest.approx(LIGHT, rel=0.01)


def test_a_sun_beyond_all_numbers_and_light_below_none_are_brought_into_range(tmp_path: Path) -> None:
    light = LIGHT.copy()
    light[0, 0], light[0, 1] = np.inf, -1e-3
    image = read_sky_image(sky_file(tmp_path, ".exr", light))
    assert np.isfinite(image.pixels).all() and image.pixels[0, 0].min() > 1e30 and (image.pixels[0, 1] == 0.0).all()


def look(row: int, column: int) -> Camera:
    """At the middle of a texel of LIGHT, magnified."""
    longitude, latitude = ((column + 0.5) / 8 - 0.5) * 2 * np.pi, (0.5 - (row + 0.5) / 4) * np.pi
    x, y, z = np.cos(latitude) * np.sin(longitude), np.sin(latitude), -np.cos(latitude) * np.cos(longitude)
    return Camera((0.0, 0.0, 0.0), (float(x), float(y), float(z)), (0.3, 0.9, 0.1), 0.1)


FAR = grid((50.0, 50.0, 50.0), (1e-3, 0.0, 0.0), (0.0, 1e-3, 0.0)).mesh("far", Diffuse())


@pytest.mark.parametrize(("row", "column"), [(1, 5), (2, 0), (0, 3)])
def test_the_sky_is_as_bright_as_its_file_says(row: int, column: int) -> None:
    camera = look(row, column)
    frame = drawn(Scene("sky", (FAR,), camera, (), Sky(image=LinearImage(LIGHT))), "raytrace", (3, 3))
    assert frame.color[1, 1] == pytest.approx(LIGHT[row, column], rel=0.02, abs=1e-3)


def test_light_beyond_half_floats_is_as_bright_as_they_can_be() -> None:
    light = np.full((2, 4, 3), 1e30, np.float32)
    frame = drawn(Scene("sky", (FAR,), look(1, 1), (), Sky(image=LinearImage(light))), "raytrace", (3, 3))
    assert (frame.color == np.finfo(np.float16).max).all()


@pytest.mark.parametrize("suffix", ENCODED)
def test_a_scene_file_names_it(tmp_path: Path, suffix: str) -> None:
    sky_file(tmp_path, suffix)
    (tmp_path / "s.toml").write_text(f'builtin = "flat-mirror"\n[sky]\nimage = "sky{suffix}"\n')
    scene, _ = open_scene(tmp_path / "s.toml")
    assert isinstance(scene.sky.image, LinearImage)


def test_a_part_takes_no_linear_image(tmp_path: Path) -> None:
    sky_file(tmp_path, ".hdr")
    text = 'builtin = "flat-mirror"\n[[part]]\nname = "*"\ndiffuse = { image = "sky.hdr" }\n'
    (tmp_path / "s.toml").write_text(text)
    with pytest.raises(AnamorphError, match=r"sky\.hdr: holds linear light, which only the sky takes; save it as PNG"):
        open_scene(tmp_path / "s.toml")


@pytest.mark.parametrize("suffix", ENCODED)
def test_a_damaged_file_is_named(tmp_path: Path, suffix: str) -> None:
    path = sky_file(tmp_path, suffix)
    path.write_bytes(path.read_bytes()[:-20])
    with pytest.raises(AnamorphError, match=rf"sky\{suffix}: cannot be read, it has .*; save it again"):
        read_sky_image(path)


def test_no_number_is_refused(tmp_path: Path) -> None:
    light = LIGHT.copy()
    light[0, 0, 0] = np.nan
    with pytest.raises(AnamorphError, match=r"sky\.exr: 1 pixels are NaN; mend the image"):
        read_sky_image(sky_file(tmp_path, ".exr", light))


@pytest.mark.parametrize(
    ("pixels", "words"),
    [
        (LIGHT.astype(float), "give .H, W, 3. float32"),
        (LIGHT[..., :2], "give .H, W, 3. float32"),
        (-LIGHT, "negative light"),
        (LIGHT * np.float32(np.nan), "NaN"),
    ],
)
def test_a_sky_that_cannot_be_drawn_is_refused(pixels: np.ndarray, words: str) -> None:
    with pytest.raises(AnamorphError, match=f"sky: its image .*{words}"):
        check_scene(Scene("sky", (FAR,), look(1, 1), (), Sky(image=LinearImage(pixels))))
