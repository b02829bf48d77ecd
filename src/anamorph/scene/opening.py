"""Whatever names a scene - a built-in, a scene file, a model file - as a scene that can be drawn."""

from __future__ import annotations

from pathlib import Path

from anamorph.errors import AnamorphError, nearest
from anamorph.scene import builtin
from anamorph.scene.checks import check_scene
from anamorph.scene.framing import stand_before_mirror
from anamorph.scene.load import SUFFIXES, load_parts
from anamorph.scene.model import Scene
from anamorph.scene.scenefile import Settings, load_scene_file


def open_scene(source: str | Path) -> tuple[Scene, Settings]:
    """The scene, checked, and how it wants to be drawn.

    Parameters
    ----------
    source : str or Path
        The name of a built-in scene, a .toml scene file, or a model file, which is stood before a convex mirror.
    """
    if str(source) in builtin.names():
        return check_scene(builtin.make(str(source))), Settings()
    path = Path(source)
    suffix = path.suffix.lower()
    if suffix == ".toml":
        return load_scene_file(path)
    if suffix in SUFFIXES or path.is_file():
        meshes = tuple(part.mesh for part in load_parts(path, near=True))
        return check_scene(stand_before_mirror(meshes, path.stem)), Settings()
    known = builtin.names()
    raise AnamorphError(
        f"'{source}' is no scene{nearest(str(source), known)} (built in: {', '.join(known)}); "
        f"or give a .toml scene file or a model ({', '.join(SUFFIXES)})"
    )
