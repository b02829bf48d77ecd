"""Machine code that is kept on disk is made again when any compiled function of the package has changed."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import anamorph
from anamorph.base.compiled import compiled_modules


def test_the_modules_with_compiled_functions_are_found_in_every_room():
    package = Path(anamorph.__file__).parent
    rooms = {module.relative_to(package).parts[0] for module in compiled_modules()}
    assert {"base", "surfaces", "rays", "methods"} <= rooms


def test_modules_that_are_built_into_others_are_among_them():
    names = {module.name for module in compiled_modules()}
    assert {"vectors.py", "embree.py", "solve.py", "bounces.py", "pixel_errors.py"} <= names


def test_machine_code_for_types_that_have_moved_is_made_again(tmp_path):
    script = """
import sys
from pathlib import Path
from anamorph.base import compiled
compiled.compiled_modules = lambda: [Path("held.py")]
sys.path.insert(0, ".")
import held
print(held.first(held.{name}(7)))
"""
    module = """
from typing import NamedTuple
from anamorph.base.compiled import compiled
class {name}(NamedTuple):
    number: int
@compiled
def first(of):
    return of[0]
"""
    for name in ("Earlier", "Later"):
        (tmp_path / "held.py").write_text(module.format(name=name))
        command = [sys.executable, "-c", script.format(name=name)]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.stdout == "7\n", done.stderr
