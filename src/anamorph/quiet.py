"""Keeping libraries' own messages off the user's terminal."""

from __future__ import annotations

import atexit
import logging
import os
import shutil
import tempfile
import warnings


def hush() -> None:
    """Silence what libraries print about themselves; call it before they are imported.

    Mesa's Vulkan driver writes to stderr, below Python, when there is no private run-time directory: it gets a
    temporary one, removed at exit.
    """
    if not os.environ.get("XDG_RUNTIME_DIR"):
        directory = tempfile.mkdtemp(prefix="anamorph-")
        atexit.register(shutil.rmtree, directory, ignore_errors=True)
        os.environ["XDG_RUNTIME_DIR"] = directory
    for name in ("trimesh", "wgpu", "numba", "PIL"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    warnings.simplefilter("ignore")
