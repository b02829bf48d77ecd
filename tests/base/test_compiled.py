"""Loops compiled to machine code that is kept on disk."""

from __future__ import annotations

from anamorph.base.compiled import compiled_modules


def test_kept_machine_code_depends_on_compiled_functions_of_every_room():
    found = {file.name for file in compiled_modules()}
    assert {"vectors.py", "embree.py", "solve.py", "bounces.py", "pixel_errors.py"} <= found, found
