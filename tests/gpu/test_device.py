"""A lost device ends nothing: all that was made on it is forgotten with it, and made anew."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

import anamorph
from anamorph.gpu.device import device_lost

PACKAGE = Path(anamorph.__file__).parent

PLAIN = {"bool", "bytes", "dict", "float", "frozenset", "int", "list", "ndarray", "np", "set", "str", "tuple"}
"""What a function may give that `functools` remembers: nothing of these is on the device."""

LOSS = textwrap.dedent(
    """
    import gc, weakref
    import numpy as np
    import wgpu
    from anamorph.frame import View
    from anamorph.gpu.device import device_lost, forget_device, get_device
    from anamorph.methods import METHODS, Specification
    from scenes import scene_with, spherical_mirror

    SCENE = scene_with(spherical_mirror())
    KINDS = [*METHODS, "pervertex:map=image,antialias=4,overlay=mesh", "trilinear:antialias=4",
             "trilinear:edges=straight"]

    def drawn(kind):
        session = Specification.parse(kind).open(View(SCENE, SCENE.camera, (48, 36)))
        session.draw(SCENE.camera)
        return session, session.frame(seen=True)

    sessions, frames = zip(*map(drawn, KINDS))
    lost = weakref.ref(get_device())
    assert device_lost() is None
    get_device().destroy()
    assert device_lost() == "Parent device is lost"
    for each in sessions:
        for use in (lambda: each.draw(SCENE.camera), each.wait, each.frame):
            try:
                use()
            except wgpu.GPUError as error:
                assert "lost" in str(error)
            else:
                raise AssertionError(f"{each} notices nothing")
    del sessions, each, use
    forget_device()
    gc.collect()
    assert lost() is None, "something made on the lost device is still remembered"
    assert device_lost() is None
    for kind, frame in zip(KINDS, frames):
        again = drawn(kind)[1]
        for buffer in ("color", "position", "object_id", "specular", "status"):
            assert np.array_equal(getattr(frame, buffer), getattr(again, buffer)), (kind, buffer)
    """
)


def remembering(source: str) -> list[str]:
    """The functions of a module on the device that `functools` remembers for good, and that may give parts of it."""
    tree = ast.parse(source)
    names = {
        alias.name if isinstance(node, ast.Import) else f"{node.module}.{alias.name}"
        for node in ast.walk(tree)
        if isinstance(node, ast.Import | ast.ImportFrom)
        for alias in node.names
    }
    if not any(name.split(".")[0] == "wgpu" or name.startswith("anamorph.gpu") for name in names):
        return []
    found = []
    scopes: list[ast.Module | ast.ClassDef] = [tree, *(node for node in tree.body if isinstance(node, ast.ClassDef))]
    for function in (each for scope in scopes for each in scope.body if isinstance(each, ast.FunctionDef)):
        words = {part for mark in function.decorator_list for part in ast.walk(mark)}
        called = {part.id for part in words if isinstance(part, ast.Name)}
        called |= {part.attr for part in words if isinstance(part, ast.Attribute)}
        gives = [part for part in ast.walk(function.returns or ast.Name("unknown")) if isinstance(part, ast.Name)]
        if called & {"cache", "lru_cache"} and any(part.id not in PLAIN for part in gives):
            found.append(function.name)
    return found


def test_a_device_at_work_is_not_lost():
    assert device_lost() is None


def test_after_a_loss_everything_is_made_anew_and_nothing_old_is_kept():
    # In a process of its own: other tests keep sessions on this one's device.
    paths = {"PYTHONPATH": os.pathsep.join(map(str, (PACKAGE.parent, Path(__file__).parents[1])))}
    command = [sys.executable, "-c", LOSS]
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, **paths})
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("module", sorted(PACKAGE.rglob("*.py")), ids=lambda path: str(path.relative_to(PACKAGE)))
def test_what_lives_on_the_device_is_remembered_with_it(module):
    assert remembering(module.read_text()) == [], "say @of_device, from anamorph.gpu.device"


def test_the_guard_sees_every_form_of_remembering():
    source = """
import functools
from functools import cache, lru_cache
from anamorph.gpu.drawing import make_pipeline

@cache
def first() -> wgpu.GPUBuffer: ...
@functools.lru_cache(maxsize=3)
def second() -> tuple[Target, int]: ...
class Some:
    @functools.cache
    def third(self): ...
@cache
def plain() -> tuple[tuple[float, np.ndarray], ...]: ...
@of_device
def forgetful() -> Target: ...
"""
    assert remembering(source) == ["first", "second", "third"]
    assert remembering(source.replace("anamorph.gpu.drawing", "anamorph.scene")) == []
