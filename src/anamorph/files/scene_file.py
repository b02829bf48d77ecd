"""Scene files: TOML that puts models, mirrors, lights, sky and eye together. docs/scene-file.md describes them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from anamorph import gallery
from anamorph.base.errors import AnamorphError
from anamorph.files.cad import SUFFIXES
from anamorph.files.models import SUFFIXES as MODELS
from anamorph.files.models import Part, uniquely_named
from anamorph.files.part_tables import CHOICE, UNITS_AND_AXES, changed_parts, choice_of, model_parts, units_and_axes
from anamorph.files.sky_image import read_sky_image
from anamorph.files.source import Source
from anamorph.files.tables import Table
from anamorph.scene.camera import Camera
from anamorph.scene.checks import check_scene
from anamorph.scene.model import DEFAULT_LIGHTS, AmbientLight, DirectionalLight, Light, PointLight, Scene, Sky

LIGHTS = ("directional", "point", "ambient")
BASE = ("builtin", "base", "mirror_of", *CHOICE, *UNITS_AND_AXES)

DEFAULT_SIZE = (1024, 768)
"""Width and height of an image, pixels, unless someone says otherwise."""


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
    method: str = "auto"
    view: Table | None = None


def start_of(top: Table) -> Source | None:
    """What a scene file starts from; None where it starts from nothing."""
    if "builtin" in top.values and "base" in top.values:
        top.wrong("base", "a scene cannot start from builtin and base; keep one of them")
    name: str | Path | None = None
    if "builtin" in top.values:
        name = top.choice("builtin", gallery.names())
    elif "base" in top.values:
        name = top.file("base")
    for key in ("mirror_of", *CHOICE):
        if key in top.values and Path(name or "").suffix.lower() not in SUFFIXES:
            top.wrong(key, f"{key} is for a base that is a CAD file ({', '.join(SUFFIXES)}); leave it out")
    for key in UNITS_AND_AXES:
        if key in top.values and Path(name or "").suffix.lower() not in MODELS:
            top.wrong(key, f"{key} is for a base that is a model ({', '.join(MODELS)}); leave it out")
    if name is None:
        return None
    built_in = top.values.get("mirror_of", "") in ("", *gallery.names())
    mirror_of = top.text("mirror_of") or None if built_in else top.file("mirror_of")
    return Source(name, choice_of(top), mirror_of, *units_and_axes(top))


def scene_from(top: Table, start: Scene | None, settings: Settings) -> tuple[Scene, Settings]:
    """The scene that the tables of a file describe, checked, and how the file wants it drawn.

    Parameters
    ----------
    top : Table
        The whole file.
    start : Scene or None
        What `start_of` names, opened.
    settings : Settings
        How that wants to be drawn; the file may say otherwise.
    """
    top.only("name", *BASE, "size", "method", "model", "part", "light", "sky", "eye", "view")
    parts = [] if start is None else [Part(mesh) for mesh in start.meshes]
    for table in top.tables("model"):
        parts = list(uniquely_named(parts + model_parts(table)))
    if not parts:
        top.wrong(None, 'has nothing to show; add a [[model]] with a file, or builtin = "car-mirror"')
    for table in top.tables("part"):
        parts = changed_parts(parts, table)
    lights = tuple(_light(table) for table in top.tables("light"))
    scene = Scene(
        name=top.text("name", top.path.stem),
        meshes=tuple(part.mesh for part in uniquely_named(parts)),
        camera=eye_of(top, start),
        lights=lights or (start.lights if start else DEFAULT_LIGHTS),
        sky=_sky(top, start),
    )
    settings = Settings(top.size("size", settings.size), top.text("method", settings.method), top.table("view"))
    try:
        return check_scene(scene), settings
    except AnamorphError as error:
        raise AnamorphError(f"{top.path}: {error}") from None


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


def _sky(top: Table, start: Scene | None) -> Sky:
    default = start.sky if start else Sky()
    table = top.table("sky")
    if table is None:
        return default
    table.only("zenith", "horizon", "nadir", "image")
    colors = {name: table.color(name, getattr(default, name)) for name in ("zenith", "horizon", "nadir")}
    return Sky(**colors, image=read_sky_image(table.file("image")) if "image" in table.values else None)


def eye_of(top: Table, start: Scene | None) -> Camera:
    """The eye of a scene file, that of `start` where the file says nothing."""
    table = top.table("eye")
    if table is None:
        if start is None:
            top.wrong(None, "needs an [eye] with position and target")
        return start.camera
    return camera_of(table, start.camera if start else None)


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
