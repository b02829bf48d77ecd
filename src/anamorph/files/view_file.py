"""Scene files that keep a view: what it starts from, what has been changed, and from where it is seen.

Such a file is a scene file like any other, and draws as what was seen. But whoever opens it to go on changing gets the
scene as it was before, and the changes apart from it.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from glob import escape
from pathlib import Path
from typing import Any

from anamorph import gallery
from anamorph.base.errors import AnamorphError
from anamorph.base.output import check_output, save_text
from anamorph.editing.edit import Edit
from anamorph.files.models import Part
from anamorph.files.opening import open_source, scene_in
from anamorph.files.part_tables import EDIT, edit_of, selected
from anamorph.files.scene_file import BASE, Settings, camera_of, eye_of, start_of
from anamorph.files.source import FaceChoice, Source
from anamorph.files.tables import Table, read_tables
from anamorph.files.toml import toml_text
from anamorph.scene.camera import Camera
from anamorph.scene.checks import check_camera
from anamorph.scene.model import Scene
from anamorph.scene.parts import specular_parts

OF_A_VIEW = ("name", *BASE, "size", "method", "part", "eye", "view")


@dataclass(frozen=True, eq=False)
class Opened:
    """A scene, opened to be looked at and changed.

    Parameters
    ----------
    scene : Scene
        Before any change.
    settings : Settings
    camera : Camera
        The eye from which to look first.
    edits : mapping of str to Edit
        The changes that the file notes, by the name of the part.
    source : Source or None
        What names the scene; None for one that was made in Python.
    """

    scene: Scene
    settings: Settings
    camera: Camera
    edits: Mapping[str, Edit] = field(default_factory=dict)
    source: Source | None = None


def open_view(
    source: str | Path,
    choice: FaceChoice | None = None,
    mirror_of: str | Path | None = None,
    units: str = "",
    axes: str = "",
) -> Opened:
    """Whatever names a scene, opened with its changes apart from it. Parameters as for `open_scene`."""
    path, named = Path(source), Source(source, choice, mirror_of, units, axes)
    in_file = path.suffix.lower() == ".toml" and str(source) not in gallery.names()
    if in_file and named == Source(source):
        opened = _opened(read_tables(path))
        if opened is not None:
            return opened
    scene, settings = open_source(named)
    return Opened(scene, settings, scene.camera, {}, named)


def _opened(top: Table) -> Opened | None:
    """The view that a file keeps; None if the file does more than that."""
    tables = top.tables("part")
    if "view" not in top.values or not set(top.values) <= set(OF_A_VIEW) or not all(map(_only_edits, tables)):
        return None
    # The changes may be what puts the saved eye before its mirror: the scene alone is checked with its own.
    bare = {key: value for key, value in top.values.items() if key not in ("part", "eye")}
    scene, settings = scene_in(replace(top, values=bare))
    for table in tables:
        selected([Part(mesh) for mesh in scene.meshes], table)
    edits = {_unescaped(table.text("name")): edit_of(table) for table in tables}
    if len(edits) < len(tables) or not edits.keys() <= specular_parts(scene.meshes).keys():
        return None
    camera = eye_of(top, scene)
    check_camera(camera, f"{top.path}: eye")
    return Opened(scene, settings, camera, edits, start_of(top))


def _only_edits(table: Table) -> bool:
    """Whether a [[part]] names one part, and says nothing of it but what a view keeps."""
    pattern = table.text("name")
    return escape(_unescaped(pattern)) == pattern != "" and set(table.values) <= {"name", *EDIT}


def _unescaped(pattern: str) -> str:
    return re.sub(r"\[([*?[])\]", r"\1", pattern)


def _part(name: str, by: Edit) -> dict[str, Any]:
    """What is changed of a part, as the values of a [[part]]."""
    said = {key: value for key, value in asdict(by).items() if value != getattr(Edit, key)}
    return {"name": escape(name), **said}


def save_view(
    path: str | Path,
    opened: Opened,
    camera: Camera,
    size: tuple[int, int],
    method: str,
    edits: Mapping[str, Edit],
    view: Mapping[str, Any],
) -> None:
    """Write a scene file that opens the same view.

    Parameters
    ----------
    path : str or Path
        Ends in .toml.
    opened : Opened
        What the view shows.
    camera : Camera
        The eye.
    size : (width, height)
        Of the image, pixels.
    method : str
    edits : mapping of str to Edit
        What has been changed, by the name of the part.
    view : mapping
        What else `viewer/view_table.py` wants to find again.

    Raises
    ------
    AnamorphError
        Where nothing names the scene, or the file cannot be written.
    """
    path = check_output(path, (".toml",))
    if opened.source is None:
        raise AnamorphError(
            f"scene '{opened.scene.name}' was made in Python, so that no scene file can name its parts; "
            "save the image, or give the viewer a file"
        )
    document = {
        "name": opened.scene.name,
        **_base(opened.source, path.resolve().parent),
        "size": list(size),
        "method": method,
        "part": [_part(name, by) for name, by in edits.items() if by != Edit()],
        "eye": eye_values(camera),
        "view": view,
    }
    save_text(path, toml_text({key: value for key, value in document.items() if value != []}))


def eye_values(camera: Camera) -> dict[str, Any]:
    """A camera as the values of an [eye] table."""
    vectors = {"position": camera.position, "target": camera.target, "up": camera.up}
    written: dict[str, Any] = {key: [float(entry) for entry in vector] for key, vector in vectors.items()}
    return {**written, "field_of_view": float(camera.field_of_view)}


def views_of(table: Table | None) -> tuple[Camera, ...]:
    """The remembered views that a [view] table keeps; none where there is no table."""
    views = []
    for number, each in enumerate([] if table is None else table.tables("views"), start=1):
        views.append(camera_of(each))
        check_camera(views[-1], f"{each.path}: number {number} of views")
    return tuple(views)


def _base(source: Source, directory: Path) -> dict[str, Any]:
    values: dict[str, Any] = {}
    values["builtin" if str(source.name) in gallery.names() else "base"] = _named(source.name, directory)
    if source.mirror_of:
        values["mirror_of"] = _named(source.mirror_of, directory)
    if source.choice:
        faces: Sequence[int | str] = source.choice.faces
        values |= {"faces": list(faces), "density": source.choice.density, "flip": source.choice.flip}
    values |= {key: said for key, said in (("units", source.units), ("axes", source.axes)) if said}
    return values


def _named(name: str | Path, directory: Path) -> str:
    """A built-in scene by its name, a file by its way from `directory`."""
    if str(name) in gallery.names():
        return str(name)
    path = Path(name).resolve()
    try:
        return Path(os.path.relpath(path, directory)).as_posix()
    # From one drive of Windows to another there is no way.
    except ValueError:
        return path.as_posix()
