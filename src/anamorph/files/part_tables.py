"""The [[model]] and [[part]] tables of a scene file: what stands in the scene, and what is changed of it."""

from __future__ import annotations

from dataclasses import fields, replace
from fnmatch import fnmatchcase
from itertools import chain

import numpy as np

from anamorph.base.errors import AnamorphError, nearest
from anamorph.editing.edit import Edit, edit
from anamorph.files.models import Part, load_parts
from anamorph.files.reading import read_texture
from anamorph.files.source import FaceChoice
from anamorph.files.tables import Table
from anamorph.files.units_and_axes import metres_in, turn_of
from anamorph.scene.model import Diffuse, Glass, Material, Mesh, Mirror
from anamorph.scene.parts import part_names
from anamorph.surfaces.similarity import Similarity, rotation

UNITS_AND_AXES = ("units", "axes")
TRANSFORM = ("scale", "rotate", "translate")
EDIT = tuple(field.name for field in fields(Edit))
CHOICE = ("faces", "density", "flip")


def model_parts(table: Table) -> list[Part]:
    """What a [[model]] brings."""
    table.only("file", *UNITS_AND_AXES, *CHOICE, "mirror", "glass", "diffuse", *TRANSFORM)
    by, material = _similarity(table), _material(table)

    def placed(mesh: Mesh) -> Mesh:
        return replace(mesh.moved(by), material=material or mesh.material)

    units, axes = units_and_axes(table)
    parts = load_parts(table.file("file"), choice=choice_of(table), units=units, axes=axes)
    return [replace(part, mesh=placed(part.mesh)) for part in parts]


def units_and_axes(table: Table) -> tuple[str, str]:
    """What a table says of the unit and the axes of a model file, each "" where it says nothing."""
    for key, meaning in (("units", metres_in), ("axes", turn_of)):
        try:
            meaning(table.text(key))
        except AnamorphError as error:
            table.wrong(key, str(error))
    return table.text("units"), table.text("axes")


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


def changed_parts(parts: list[Part], table: Table) -> list[Part]:
    """The parts, with the change that a [[part]] table asks for made to those that it selects."""
    table.only("name", "material", "rename", "remove", "mirror", "glass", "diffuse", *TRANSFORM, *EDIT)
    hits = selected(parts, table)
    if table.flag("remove"):
        return [part for part, hit in zip(parts, hits, strict=True) if not hit]
    by, material, name = _similarity(table), _material(table), table.text("rename")

    def changed(part: Part) -> Part:
        mesh = part.mesh.moved(by) if any(key in table.values for key in TRANSFORM) else part.mesh
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
    """Which parts a [[part]] names, by their names, those of what they are parts of, or their materials."""
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


def _similarity(table: Table) -> Similarity:
    scale = table.number("scale", 1.0)
    if scale <= 0:
        table.wrong("scale", f"scale is {scale:g}; give a positive number")
    degrees = table.vector("rotate", (0.0, 0.0, 0.0))
    return Similarity(scale, rotation(degrees), np.array(table.vector("translate", (0.0, 0.0, 0.0))))


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
