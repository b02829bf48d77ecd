"""Scene files: TOML that puts models, mirrors, lights, sky and eye together. docs/scene-file.md describes them."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from fnmatch import fnmatchcase
from itertools import chain
from pathlib import Path

import numpy as np

from anamorph import gallery
from anamorph.base.errors import AnamorphError, nearest
from anamorph.editing.edit import Edit, edit
from anamorph.files.cad import SUFFIXES, FaceChoice
from anamorph.files.models import Part, load_parts, uniquely_named
from anamorph.files.reading import read_texture
from anamorph.files.tables import Table, read_tables
from anamorph.scene.camera import Camera
from anamorph.scene.checks import check_scene
from anamorph.scene.model import (
    DEFAULT_LIGHTS,
    AmbientLight,
    Diffuse,
    DirectionalLight,
    Glass,
    Light,
    Material,
    Mesh,
    Mirror,
    PointLight,
    Scene,
    Sky,
)
from anamorph.scene.parts import part_names
from anamorph.scene.transform import Similarity, rotation, transform

TRANSFORM = ("scale", "rotate", "translate")
EDIT = tuple(field.name for field in fields(Edit))
LIGHTS = ("directional", "point", "ambient")
CHOICE = ("faces", "density", "flip")
BASE = ("builtin", "base", "mirror_of", *CHOICE)

DEFAULT_SIZE = (1024, 768)
"""Width and height of a picture, pixels, unless someone says otherwise."""


@dataclass(frozen=True)
class Settings:
    """How a scene is drawn unless the command says otherwise.

    Parameters
    ----------
    size : (width, height)
        Pixels.
    method : str
        NAME[:option=value,...], as after -m on the command line.
    view : Table, optional
        What the viewer noted in the file of how it showed the scene; `viewer/view_table.py` reads it.
    """

    size: tuple[int, int] = DEFAULT_SIZE
    method: str = "pervertex"
    view: Table | None = None


def load_scene_file(path: str | Path, above: tuple[Path, ...] = ()) -> tuple[Scene, Settings]:
    """The scene that a TOML file describes, checked, and how the file wants it drawn.

    `above` are the scene files that start from this one.
    """
    return scene_of(read_tables(Path(path)), above)


def scene_of(top: Table, above: tuple[Path, ...] = ()) -> tuple[Scene, Settings]:
    """The scene that the tables of a file describe. See `load_scene_file`."""
    top.only("name", *BASE, "size", "method", "model", "part", "light", "sky", "eye", "view")
    base, wanted = _base(top, (*above, top.path.resolve()))
    parts = [] if base is None else [Part(mesh) for mesh in base.meshes]
    for table in top.tables("model"):
        parts = list(uniquely_named(parts + _model(table)))
    if not parts:
        top.wrong(None, 'has nothing to show; add a [[model]] with a file, or builtin = "car-mirror"')
    for table in top.tables("part"):
        parts = _changed(parts, table)
    lights = tuple(_light(table) for table in top.tables("light"))
    scene = Scene(
        name=top.text("name", top.path.stem),
        meshes=tuple(part.mesh for part in uniquely_named(parts)),
        camera=eye_of(top, base),
        lights=lights or (base.lights if base else DEFAULT_LIGHTS),
        sky=_sky(top, base),
    )
    settings = Settings(top.size("size", wanted.size), top.text("method", wanted.method), top.table("view"))
    try:
        return check_scene(scene), settings
    except AnamorphError as error:
        raise AnamorphError(f"{top.path}: {error}") from None


def _base(top: Table, above: tuple[Path, ...]) -> tuple[Scene | None, Settings]:
    """What the file starts from, and how that wants to be drawn."""
    if "builtin" in top.values and "base" in top.values:
        top.wrong("base", "a scene cannot start from builtin and base; keep one of them")
    source = base_of(top)
    for key in ("mirror_of", *CHOICE):
        if key in top.values and Path(source or "").suffix.lower() not in SUFFIXES:
            top.wrong(key, f"{key} is for a base that is a CAD file ({', '.join(SUFFIXES)}); leave it out")
    if source is None:
        return None, Settings()
    other = mirror_of(top)
    for key, named in (("base", source), ("mirror_of", other)):
        if isinstance(named, Path) and named.resolve() in above:
            top.wrong(key, f"{key} names '{top.text(key)}', which starts from this file itself; name another")
    # Whatever can be opened can be started from, scene files too.
    from anamorph.files.opening import open_scene

    return open_scene(source, choice_of(top), other, above)


def base_of(top: Table) -> str | Path | None:
    """The built-in scene or the file that a scene file starts from, if any."""
    if "builtin" in top.values:
        return top.choice("builtin", gallery.names())
    return top.file("base") if "base" in top.values else None


def mirror_of(top: Table) -> str | Path | None:
    """The scene, built in or in a file, whose mirror gives way to the base."""
    built_in = top.values.get("mirror_of", "") in ("", *gallery.names())
    return top.text("mirror_of") or None if built_in else top.file("mirror_of")


def _similarity(table: Table) -> Similarity:
    scale = table.number("scale", 1.0)
    if scale <= 0:
        table.wrong("scale", f"scale is {scale:g}; give a positive number")
    degrees = table.vector("rotate", (0.0, 0.0, 0.0))
    return Similarity(scale, rotation(degrees), np.array(table.vector("translate", (0.0, 0.0, 0.0))))


def _model(table: Table) -> list[Part]:
    table.only("file", "faces", "density", "flip", "mirror", "glass", "diffuse", *TRANSFORM)
    by, material = _similarity(table), _material(table)

    def placed(mesh: Mesh) -> Mesh:
        return replace(transform(mesh, by), material=material or mesh.material)

    return [replace(part, mesh=placed(part.mesh)) for part in load_parts(table.file("file"), choice=choice_of(table))]


def choice_of(table: Table) -> FaceChoice | None:
    """What a table says of the faces of a CAD file; None where it says nothing."""
    if not set(CHOICE) & set(table.values):
        return None
    faces = table.values.get("faces", [])
    faces = faces if isinstance(faces, list) else [faces]
    if not all(type(entry) in (int, str) for entry in faces):
        table.wrong("faces", f"faces is {faces!r}; give numbers and names, as [1, 'glass']")
    density = table.values.get("density", FaceChoice.density)
    if type(density) is not int:
        table.wrong("density", f"density is {density!r}; give a whole number of cells along a face")
    return FaceChoice(tuple(faces), density, table.flag("flip"))


def _changed(parts: list[Part], table: Table) -> list[Part]:
    """The parts, with the change that a [[part]] table asks for made to those that it selects."""
    table.only("name", "material", "rename", "remove", "mirror", "glass", "diffuse", *TRANSFORM, *EDIT)
    hits = selected(parts, table)
    if table.flag("remove"):
        return [part for part, hit in zip(parts, hits, strict=True) if not hit]
    by, material, name = _similarity(table), _material(table), table.text("rename")

    def changed(part: Part) -> Part:
        mesh = transform(part.mesh, by) if any(key in table.values for key in TRANSFORM) else part.mesh
        mesh = replace(mesh, material=material or mesh.material, name=name or mesh.name)
        return replace(part, mesh=mesh)

    return [changed(part) if hit else part for part, hit in zip(_edited(parts, hits, table), hits, strict=True)]


def _edited(parts: list[Part], hits: list[bool], table: Table) -> list[Part]:
    """The parts, with the selected ones turned, moved and bent; those that share a name go together."""
    if not any(key in table.values for key in EDIT):
        return parts
    by = edit_of(table)
    names, edited = part_names([part.mesh for part in parts]), list(parts)
    for name in dict.fromkeys(name for name, hit in zip(names, hits, strict=True) if hit):
        own = [i for i, hit in enumerate(hits) if hit and names[i] == name]
        try:
            meshes = edit(tuple(parts[i].mesh for i in own), by)
        except AnamorphError as error:
            table.wrong(next(key for key in EDIT if key in table.values), str(error))
        for i, mesh in zip(own, meshes, strict=True):
            edited[i] = replace(parts[i], mesh=mesh)
    return edited


def edit_of(table: Table) -> Edit:
    """What a [[part]] says of how its parts are turned, moved and bent."""
    numbers = (key for key in EDIT if key in table.values and key not in ("turn", "move"))
    return Edit(
        table.vector("turn", Edit.turn),
        table.vector("move", Edit.move),
        **{key: table.number(key, 0.0) for key in numbers},
    )


def selected(parts: list[Part], table: Table) -> list[bool]:
    if "name" not in table.values and "material" not in table.values:
        table.wrong(None, "part needs the key 'name' or 'material', to say which parts it changes")

    def among(key: str, *values: list[str]) -> list[bool]:
        if key not in table.values:
            return [True] * len(parts)
        pattern, known = table.text(key), sorted({*chain(*values)} - {""})
        hits = [any(fnmatchcase(value, pattern) for value in of_part) for of_part in zip(*values, strict=True)]
        if not any(hits):
            shown = ", ".join(known[:12]) + (", ..." if len(known) > 12 else "")
            kind = "part" if key == "name" else "material"
            table.wrong(key, f"no {kind} is called '{pattern}'{nearest(pattern, known)} (known: {shown or 'none'})")
        return hits

    meshes = [part.mesh for part in parts]
    by_name = among("name", [mesh.name for mesh in meshes], part_names(meshes))
    by_material = among("material", [part.material for part in parts])
    return [one and other for one, other in zip(by_name, by_material, strict=True)]


def _material(table: Table) -> Material | None:
    kinds = [kind for kind in ("mirror", "glass", "diffuse") if kind in table.values]
    if len(kinds) > 1:
        table.wrong(kinds[1], f"a part cannot be {kinds[0]} and {kinds[1]}; keep one of them")
    values = table.table(kinds[0]) if kinds else None
    if values is None:
        return None
    if kinds[0] == "mirror":
        values.only("tint", "reflectance", "back")
        return Mirror(
            values.color("tint", Mirror.tint),
            values.number("reflectance", Mirror.reflectance, 0.0, 1.0),
            values.color("back", Mirror.back),
        )
    if kinds[0] == "glass":
        values.only("index", "tint")
        return Glass(values.number("index", Glass.index, 0.1, 10.0), values.color("tint", Glass.tint))
    values.only("color", "image")
    image = read_texture(values.file("image")) if "image" in values.values else None
    return Diffuse(values.color("color", (1.0, 1.0, 1.0) if image else Diffuse.color), image)


def _light(table: Table) -> Light:
    kind = table.choice("kind", LIGHTS)
    if kind == "directional":
        table.only("kind", "toward", "color")
        table.required("toward")
        toward = table.vector("toward", (0.0, 1.0, 0.0))
        length = sum(value * value for value in toward) ** 0.5
        if length == 0.0:
            table.wrong("toward", "toward is [0, 0, 0]; give a direction")
        x, y, z = (value / length for value in toward)
        return DirectionalLight((x, y, z), table.color("color", DirectionalLight.color))
    if kind == "point":
        table.only("kind", "position", "color")
        table.required("position")
        return PointLight(table.vector("position", (0.0, 0.0, 0.0)), table.color("color", PointLight.color))
    table.only("kind", "sky", "ground")
    return AmbientLight(table.color("sky", AmbientLight.sky), table.color("ground", AmbientLight.ground))


def _sky(top: Table, base: Scene | None) -> Sky:
    default = base.sky if base else Sky()
    table = top.table("sky")
    if table is None:
        return default
    table.only("zenith", "horizon", "nadir", "image")
    colors = {name: table.color(name, getattr(default, name)) for name in ("zenith", "horizon", "nadir")}
    return Sky(**colors, image=read_texture(table.file("image")) if "image" in table.values else None)


def eye_of(top: Table, base: Scene | None) -> Camera:
    """The eye of a scene file, that of `base` where the file says nothing."""
    table = top.table("eye")
    if table is None:
        if base is None:
            top.wrong(None, "needs an [eye] with position and target")
        return base.camera
    return camera_of(table, base.camera if base else None)


def camera_of(table: Table, default: Camera | None = None) -> Camera:
    """The camera that a table describes; without a default it must say where the eye is, and where it looks."""
    table.only("position", "target", "up", "field_of_view")
    if default is None:
        table.required("position")
        table.required("target")
        default = Camera((0.0, 0.0, 0.0), (0.0, 0.0, -1.0))
    return Camera(
        position=table.vector("position", default.position),
        target=table.vector("target", default.target),
        up=table.vector("up", default.up),
        field_of_view=table.number("field_of_view", default.field_of_view, 0.01, 179.0),
    )
