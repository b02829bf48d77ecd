"""What files ask for is looked at before memory, time or a program is spent on it: each refusal is one line."""

from __future__ import annotations

import io
import json
import os
import struct
import time
import zlib
from pathlib import Path

import pytest
from PIL import Image

from anamorph.base import limits
from anamorph.base.errors import AnamorphError
from anamorph.files import opening, reading
from anamorph.files.opening import open_scene
from anamorph.files.reading import read_texture
from anamorph.frame import View
from anamorph.gallery import make
from anamorph.methods import Specification


def refused(path: Path | str) -> str:
    """What is said of a scene; one line that a terminal shows as it is."""
    with pytest.raises(AnamorphError) as error:
        open_scene(path)
    said = str(error.value)
    assert said.isprintable()
    return said


def written(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


def png(width: int, height: int) -> bytes:
    """An image file with a header of such a size, and few bytes behind it."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = zlib.compress(bytes(1000), 9)
    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", rows) + chunk(b"IEND", b"")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no pipes among its files")
@pytest.mark.parametrize("name", ["pipe.toml", "pipe.glb", "pipe.obj", "pipe.stl", "pipe.ply"])
def test_a_pipe_is_refused_and_not_waited_for(name, tmp_path):
    os.mkfifo(tmp_path / name)
    assert "is a pipe or a device" in refused(tmp_path / name)


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="this system has no such device")
def test_a_device_behind_a_link_is_refused_as_a_scene_and_as_an_image(tmp_path):
    for name in ("endless.stl", "endless.png"):
        (tmp_path / name).symlink_to("/dev/zero")
    assert "is a pipe or a device" in refused(tmp_path / "endless.stl")
    with pytest.raises(AnamorphError, match=r"is a pipe or a device"):
        read_texture(tmp_path / "endless.png")


def test_a_file_that_is_too_long_is_refused_by_its_length(tmp_path):
    with open(tmp_path / "sparse.stl", "wb") as file:
        file.truncate(limits.MOST_BYTES + 1)
    assert "has 2048 MiB, more than 2048; make it smaller" in refused(tmp_path / "sparse.stl")
    with open(tmp_path / "sparse.toml", "wb") as file:
        file.truncate(limits.SCENE_BYTES + 1)
    assert "this scene file has 4 MiB" in refused(tmp_path / "sparse.toml")


def test_only_formats_that_are_meant_are_opened(tmp_path, monkeypatch):
    """Pillow has Ghostscript run what an EPS says, whatever the file is called."""
    eps = b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 8 8\n%%EndComments\nshowpage\n"
    (tmp_path / "paint.png").write_bytes(eps)
    monkeypatch.setenv("PATH", "")
    with pytest.raises(AnamorphError, match="is not an image that can be read"):
        read_texture(tmp_path / "paint.png")
    assert "EPS" not in reading.FORMATS
    for name in reading.FORMATS:
        data = io.BytesIO()
        Image.new("RGB", (3, 2), (200, 100, 50)).save(data, format=name)
        assert reading.decoded(data.getvalue(), name).pixels.shape[:2] == (2, 3)


@pytest.mark.parametrize(("width", "height"), [(limits.MOST_PIXELS // 8 + 1, 8), (30000, 30000)])
def test_an_image_of_too_many_pixels_is_refused_by_its_header(width, height, tmp_path):
    (tmp_path / "bomb.png").write_bytes(png(width, height))
    with pytest.raises(AnamorphError, match=r"make it at most 8192 x 8192"):
        read_texture(tmp_path / "bomb.png")


def test_a_picture_of_too_many_pixels_is_refused_before_it_is_drawn():
    scene = make("flat-mirror")
    with pytest.raises(AnamorphError, match=r"size 16384x16384: is more than 67 million pixels; give fewer"):
        Specification.parse("raytrace").open(View(scene, scene.camera, (16384, 16384)))


@pytest.mark.parametrize("key", ["a." * 20000 + "a", '"a".' * 20 + "a", "'b' . " * 17 + "c", "[" + "a." * 17 + "a]"])
def test_long_dotted_keys_are_refused_at_once(key, tmp_path):
    text = key if key.startswith("[") else f"{key} = 1\n"
    assert "has a key of more than 16 names" in refused(written(tmp_path / "deep.toml", text))


def test_what_only_looks_like_a_long_key_is_read(tmp_path):
    text = f'name = "{"w" * 100_000}"\nbuiltin = "flat-mirror"\n# {"-." * 8}\n'
    start = time.monotonic()
    scene, _ = open_scene(written(tmp_path / "wide.toml", text))
    assert len(scene.name) == 100_000 and time.monotonic() - start < 60.0


@pytest.mark.parametrize("text", ["size = [" + "9" * 5000 + ", 1]", "x = " + "[" * 5000 + "]" * 5000])
def test_numbers_and_brackets_without_end_are_not_toml(text, tmp_path):
    assert "is not TOML" in refused(written(tmp_path / "long.toml", text))


def test_a_long_chain_of_scene_files_is_refused_and_a_short_one_opened(tmp_path):
    written(tmp_path / "0.toml", 'builtin = "flat-mirror"')
    for number in range(1, 60):
        written(tmp_path / f"{number}.toml", f'base = "{number - 1}.toml"')
    assert open_scene(tmp_path / "20.toml")[0].meshes
    assert f"the end of {limits.LONGEST_CHAIN} scene files" in refused(tmp_path / "59.toml")
    assert opening.LONGEST_CHAIN == limits.LONGEST_CHAIN


def test_what_a_terminal_would_obey_is_shown(tmp_path):
    said = refused(written(tmp_path / "escapes.toml", '"\\u001b[2J\\u001b]0;title\\u0007" = 1'))
    assert "\\x1b[2J\\x1b]0;title\\x07" in said
    assert "\\x1b[2J" in refused("\x1b[2J.stl")


def test_a_model_that_is_too_large_is_named_and_not_the_mirror_beside_it(tmp_path):
    corner = [1e30, 0.0, 0.0]
    lines = [f"v {x} {y} {z}" for x, y, z in ([0.0, 0.0, 0.0], corner, [0.0, 1e30, 0.0])]
    said = refused(written(tmp_path / "vast.obj", "\n".join([*lines, "f 1 2 3"])))
    assert "vast.obj" in said and "1e+30" in said and json.dumps("mirror") not in said and "'mirror'" not in said
