"""Machine code that is kept on disk is made anew when any compiled function of the package has changed."""

from __future__ import annotations

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
