"""Videos are whole, frame by frame, or not there; other programs read what is in them."""

from __future__ import annotations

import resource
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageSequence

from anamorph.base.errors import AnamorphError
from anamorph.base.video import LARGEST, QUALITY, check_video, video

SIZE = (49, 31)


def frames(count: int) -> list[np.ndarray]:
    """Smooth images, each of another brightness and tint."""
    x, y = np.meshgrid(np.linspace(0, 80, SIZE[0]), np.linspace(0, 80, SIZE[1]))
    return [
        np.stack([x + 15 * i, y + 5 * i, np.full_like(x, 200 - 15 * i)], axis=-1).astype(np.uint8) for i in range(count)
    ]


def write(path: Path, images: list[np.ndarray], rate: float = 30.0) -> None:
    with video(path, SIZE, rate) as add:
        for pixels in images:
            add(pixels)


def test_an_animation_holds_every_frame_for_its_time(tmp_path):
    images = frames(7)
    write(tmp_path / "a.webp", images)
    with Image.open(tmp_path / "a.webp") as image:
        assert (image.size, image.n_frames, image.info["loop"]) == (SIZE, 7, 0)
        shown = [(np.asarray(frame.convert("RGB")), frame.info["duration"]) for frame in ImageSequence.Iterator(image)]
    for pixels, (read, _) in zip(images, shown, strict=True):
        assert np.abs(read.astype(int) - pixels).mean() < 2.0
    # 33 or 34 ms each, so that they do not drift apart from a thirtieth of a second.
    assert [duration for _, duration in shown] == [33, 34, 33, 33, 34, 33, 33]


def elements(data: bytes) -> list[tuple[str, bytes, int]]:
    """The elements of EBML in `data`: number, content, and where they start. Written after RFC 8794."""
    found, at = [], 0
    while at < len(data):
        start = at
        width = 9 - data[at].bit_length()
        name, at = data[at : at + width].hex().upper(), at + width
        wide = 9 - data[at].bit_length()
        length = int.from_bytes(data[at : at + wide], "big") & (1 << 7 * wide) - 1
        at += wide
        found.append((name, data[at : at + length], start))
        at += length
    assert at == len(data)
    return found


def tree(data: bytes) -> dict[str, bytes]:
    return {name: content for name, content, _ in elements(data)}


def number(content: bytes) -> int:
    return int.from_bytes(content, "big")


def test_a_webm_file_says_what_it_holds_and_where(tmp_path):
    images = frames(8)
    write(tmp_path / "a.webm", images, rate=25.0)
    header, segment = elements((tmp_path / "a.webm").read_bytes())
    assert header[0] == "1A45DFA3" and tree(header[1])["4282"] == b"webm"
    assert segment[0] == "18538067"
    top = elements(segment[1])
    assert [name for name, _, _ in top] == ["114D9B74", "1549A966", "1654AE6B", *["1F43B675"] * 8, "1C53BB6B"]
    seek = tree(tree(top[0][1])["4DBB"])
    assert seek["53AB"].hex().upper() == "1C53BB6B" and number(seek["53AC"]) == top[-1][2]
    info = tree(top[1][1])
    assert number(info["2AD7B1"]) == 1_000_000 and np.frombuffer(info["4489"], ">f8")[0] == 320.0
    track = tree(tree(top[2][1])["AE"])
    assert track["86"] == b"V_VP8" and number(track["23E383"]) == 40_000_000
    assert (number(tree(track["E0"])["B0"]), number(tree(track["E0"])["BA"])) == SIZE
    cues = [tree(content) for name, content, _ in elements(top[-1][1])]
    for i, (pixels, cue) in enumerate(zip(images, cues, strict=True)):
        _, cluster, start = top[3 + i]
        inside = tree(cluster)
        assert number(inside["E7"]) == number(cue["B3"]) == 40 * i
        assert number(tree(cue["B7"])["F1"]) == start
        block = inside["A3"]
        assert block[:4] == b"\x81\0\0\x80"
        # The frame tag of RFC 6386, section 9.1: a key frame, its start code, and its size.
        assert block[4] & 1 == 0 and block[7:10] == b"\x9d\x01\x2a"
        assert tuple(np.frombuffer(block[10:14], "<u2") & 0x3FFF) == SIZE
        Image.fromarray(pixels).save(tmp_path / "whole.webp", quality=QUALITY)
        assert riff(block[4:]) == (tmp_path / "whole.webp").read_bytes()
        (tmp_path / "frame.webp").write_bytes(riff(block[4:]))
        with Image.open(tmp_path / "frame.webp") as image:
            assert np.abs(np.asarray(image.convert("RGB")).astype(int) - pixels).mean() < 2.0


def riff(frame: bytes) -> bytes:
    chunk = b"VP8 " + len(frame).to_bytes(4, "little") + frame + bytes(len(frame) % 2)
    return b"RIFF" + (4 + len(chunk)).to_bytes(4, "little") + b"WEBP" + chunk


def test_a_folder_gets_every_frame_exactly(tmp_path):
    images = frames(5)
    (tmp_path / "empty").mkdir()
    for name in ("series", "empty"):
        write(tmp_path / name, images)
        names = sorted(path.name for path in (tmp_path / name).iterdir())
        assert names == [f"frame-{i:04}.png" for i in range(1, 6)]
        for path, pixels in zip(names, images, strict=True):
            with Image.open(tmp_path / name / path) as image:
                assert np.array_equal(np.asarray(image), pixels)


@pytest.mark.parametrize("name", ["a.webm", "a.webp", "series"])
def test_what_is_interrupted_leaves_nothing(tmp_path, name):
    def interrupted() -> None:
        with video(tmp_path / name, SIZE, 30.0) as add:
            add(frames(1)[0])
            assert not (tmp_path / name).exists() and list(tmp_path.iterdir())
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["a.webm", "a.webp", "series"])
def test_a_full_disk_is_told_in_one_line_and_leaves_nothing(tmp_path, name):
    noise = np.random.default_rng(1).integers(0, 256, (SIZE[1], SIZE[0], 3)).astype(np.uint8)
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (3000, hard))
    try:
        with pytest.raises(AnamorphError, match=r"cannot be written \([^\n]*\); free space or choose another$"):
            write(tmp_path / name, [noise] * 20)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["a.mp4", "no/a.webm", "no/series", "full", "file", "dir.webm"])
def test_a_name_that_cannot_be_written_is_refused_at_once(tmp_path, name):
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "a").touch()
    (tmp_path / "file").touch()
    (tmp_path / "dir.webm").mkdir()
    before = sorted(tmp_path.rglob("*"))
    for attempt in (lambda: check_video(tmp_path / name, SIZE), lambda: write(tmp_path / name, frames(1))):
        with pytest.raises(AnamorphError, match=r"^[^\n]*(choose|end the name|make it first|give a new)[^\n]*$"):
            attempt()
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize("rate", [0.0, -30.0, np.nan, np.inf])
def test_a_rate_of_no_sense_is_refused(tmp_path, rate):
    with pytest.raises(AnamorphError, match="frames a second; give 1 to 120"):
        video(tmp_path / "a.webm", SIZE, rate)


def test_an_animation_longer_than_its_count_of_bytes_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("anamorph.base.video.LONGEST", 2000)
    with pytest.raises(AnamorphError, match=r"too long for a WebP file at frame \d+; give a \.webm file"):
        write(tmp_path / "a.webp", frames(3) * 30)
    assert not list(tmp_path.iterdir())


def test_a_video_too_large_for_its_format_is_refused(tmp_path):
    check_video(tmp_path / "a.webm", (LARGEST, 1))
    check_video(tmp_path / "series", (LARGEST + 1, 1))
    with pytest.raises(AnamorphError, match=f"at most {LARGEST} pixels"):
        check_video(tmp_path / "a.webm", (1, LARGEST + 1))
