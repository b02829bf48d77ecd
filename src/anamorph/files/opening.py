"""Whatever names a scene - a built-in, a scene file, a model file - as a scene that can be drawn.

A scene file may start from anything that can be opened: that is opened first, then the file's tables change it.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from anamorph import gallery
from anamorph.base.errors import AnamorphError, nearest
from anamorph.base.limits import LONGEST_CHAIN
from anamorph.files import cad
from anamorph.files.cad import chosen_faces
from anamorph.files.model_scene import seen_as_itself, stand_before_mirror
from anamorph.files.models import SUFFIXES, Part, load_parts, uniquely_named
from anamorph.files.own_mirror import replace_mirror
from anamorph.files.reading import is_file
from anamorph.files.scene_file import Settings, scene_from, start_of
from anamorph.files.source import FaceChoice, Source
from anamorph.files.tables import Table, read_tables
from anamorph.scene.checks import check_place, check_scene
from anamorph.scene.model import Scene


def open_scene(
    source: str | Path,
    choice: FaceChoice | None = None,
    mirror_of: str | Path | None = None,
    units: str = "",
    axes: str = "",
) -> tuple[Scene, Settings]:
    """The scene, checked, and how it wants to be drawn.

    Parameters
    ----------
    source : str or Path
        The name of a built-in scene, a .toml scene file, or a model file. A model without mirrors and glass
        is stood before a convex mirror.
    choice : FaceChoice, optional
        Which faces of a CAD file, and how fine.
    mirror_of : str or Path, optional
        A scene whose mirror the CAD file `source` replaces.
    units, axes : str
        Of a model file, as for `load_model`.
    """
    return open_source(Source(source, choice, mirror_of, units, axes))


def open_source(source: Source) -> tuple[Scene, Settings]:
    """The same of what names a scene."""
    return _opened(source, ())


def scene_in(top: Table, above: tuple[Path, ...] = ()) -> tuple[Scene, Settings]:
    """The scene that the tables of a scene file describe, with what it starts from.

    `above` are the scene files that start from this one.
    """
    start, above = start_of(top), (*above, top.path.resolve())
    if start is None:
        return scene_from(top, None, Settings())
    for key, named in (("base", start.name), ("mirror_of", start.mirror_of)):
        if isinstance(named, Path) and named.resolve() in above:
            top.wrong(key, f"{key} names '{top.text(key)}', which starts from this file itself; name another")
        if len(above) >= LONGEST_CHAIN:
            top.wrong(key, f"{key} is the end of {LONGEST_CHAIN} scene files that start from each other; join some")
    return scene_from(top, *_opened(start, above))


def _opened(source: Source, above: tuple[Path, ...]) -> tuple[Scene, Settings]:
    name, choice = str(source.name), source.choice
    path = Path(name)
    suffix = path.suffix.lower()
    if suffix not in cad.SUFFIXES and (choice or source.mirror_of):
        raise AnamorphError(
            f"{name}: --scene, --faces, --density and --flip are for CAD files ({', '.join(cad.SUFFIXES)}); "
            "leave them out"
        )
    if (source.units or source.axes) and (source.mirror_of or suffix not in SUFFIXES):
        raise AnamorphError(f"{name}: --units and --axes are for a model ({', '.join(SUFFIXES)}); leave them out")
    if source.mirror_of:
        scene, settings = _opened(Source(source.mirror_of), above)
        choice = choice or FaceChoice()
        return check_scene(replace_mirror(scene, chosen_faces(path, choice), choice.density, name)), settings
    if name in gallery.names():
        return check_scene(gallery.make(name)), Settings()
    if suffix == ".toml":
        return scene_in(read_tables(path), above)
    if suffix in SUFFIXES:
        meshes = tuple(part.mesh for part in load_parts(path, 1.0, choice, source.units, source.axes, near=True))
        for mesh in meshes:
            # The mirror that is stood before it is as large as it is, and would be blamed first.
            check_place(f"{name}: part '{mesh.name}'", mesh.positions)
        own = any(mesh.specular for mesh in meshes)
        scene = seen_as_itself(meshes, path.stem) if own else stand_before_mirror(meshes, path.stem)
        named = uniquely_named(map(Part, scene.meshes))
        return check_scene(replace(scene, meshes=tuple(part.mesh for part in named))), Settings()
    if is_file(path):
        raise AnamorphError(
            f"{name}: is no scene file and no known model; give one that ends in .toml, {', '.join(SUFFIXES)}"
            f"{nearest(suffix, ('.toml', *SUFFIXES))}"
        )
    known = gallery.names()
    raise AnamorphError(
        f"'{name}' is no scene{nearest(name, known)} (built in: {', '.join(known)}); "
        f"or give a .toml scene file or a model ({', '.join(SUFFIXES)})"
    )
