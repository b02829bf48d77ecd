"""Which versions made a result."""

from __future__ import annotations

import platform
from importlib import metadata

LIBRARIES = ("anamorph", "wgpu", "embreex", "trimesh", "numpy", "numba")


def versions() -> dict[str, str]:
    """Name to version, of this package, what it stands on, and Python."""
    found = {}
    for name in LIBRARIES:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = "not installed"
    return {**found, "python": platform.python_version()}
