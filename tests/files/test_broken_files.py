"""Files that are broken at random are opened, or refused in one line that names a file; none takes long."""

from __future__ import annotations

import os
import time
import warnings

from broken_files import broken_files, whole_files

from anamorph.base.errors import AnamorphError
from anamorph.base.notes import AnamorphNote
from anamorph.files.opening import open_scene

COUNT, SEED = 420, 7

PATIENCE = 20.0
"""Seconds for one file, on a busy machine."""


def test_the_files_that_are_broken_are_good_ones(tmp_path):
    names = list(whole_files(tmp_path))
    for what, path in broken_files(0, 0, tmp_path):
        raise AssertionError((what, path))
    for name in ("square.obj", "text.ply", "bytes.ply", "text.stl", "bytes.stl", "square.gltf", "mirror.glb"):
        assert name in names and open_scene(tmp_path / name)[0].meshes
    for name in ("scene.toml", "hdr.toml", "exr.toml"):
        assert open_scene(tmp_path / name)[0].sky.image is not None


def test_broken_files_are_opened_or_refused_in_one_line(tmp_path):
    outcomes = {True: 0, False: 0}
    before = None
    for what, path in broken_files(COUNT, SEED, tmp_path):
        before = before or sorted(os.listdir(tmp_path))
        start = time.monotonic()
        with warnings.catch_warnings():
            # Notes say what of a file is left out; anything else that warns is a fault.
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", AnamorphNote)
            try:
                open_scene(path)
                outcomes[True] += 1
            except AnamorphError as error:
                said = str(error)
                assert said.isprintable() and len(said) < 1500, what
                assert any(name in said for name in before), (what, said)
                outcomes[False] += 1
            except BaseException as error:
                raise AssertionError(what) from error
        assert time.monotonic() - start < PATIENCE, what
    assert sorted(os.listdir(tmp_path)) == before
    assert min(outcomes.values()) > COUNT // 5
