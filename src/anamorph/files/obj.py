"""OBJ files: polygons with their groups, materials, normals and texture coordinates.

Format: Wavefront's "Advanced Visualizer" manual, appendix B, object files.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NoReturn

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.base.notes import note
from anamorph.files.materials import linear_colors
from anamorph.files.model_shape import ModelShape
from anamorph.files.mtl import MtlMaterials
from anamorph.files.polygons import triangulated
from anamorph.files.reading import as_utf8
from anamorph.scene.checks import check_triangles
from anamorph.scene.model import WHITE

WIDTHS = {"v": 3, "vt": 2, "vn": 3}
"""The numbers that are read of a vertex, of texture coordinates and of a normal, in the order of a corner's v/vt/vn."""

LEFT_OUT = {"l": "lines", "p": "points", "curv": "curves", "curv2": "curves", "surf": "free-form surfaces"}
NO_GROUP = ("", "default", "off", "(null)")
"""What programs write where no group follows."""


@dataclass(frozen=True, eq=False)
class Faces:
    """The polygons of one part: the numbers of their corners in turn, and how many each polygon has."""

    corners: list[int] = field(default_factory=list)
    counts: list[int] = field(default_factory=list)


@dataclass(frozen=True, eq=False)
class ObjLines:
    """What the lines of an OBJ file say.

    Parameters
    ----------
    numbers : dict of str to array
        Of the lines v, vt and vn, one line after another.
    colors : array
        Three for each vertex, NaN for one that has none; it ends at the last that has one.
    corners : dict of str to int
        A number for each different corner, as "v/vt/vn".
    parts : dict of (object, group, material) to Faces
    """

    path: Path
    materials: MtlMaterials
    numbers: dict[str, array[float]] = field(default_factory=lambda: {kind: array("d") for kind in WIDTHS})
    colors: array[float] = field(default_factory=lambda: array("d"))
    corners: dict[str, int] = field(default_factory=dict)
    parts: dict[tuple[str, str, str], Faces] = field(default_factory=dict)

    def damaged(self, why: str) -> NoReturn:
        """Raise an error that names the file."""
        raise AnamorphError(f"{self.path}: is damaged or no OBJ file ({why}); export it again")


def obj_shapes(data: bytes, path: Path) -> list[ModelShape]:
    """The shapes of an OBJ file: one for each material of each group, or of each object that has no groups."""
    lines = ObjLines(path, MtlMaterials(path))
    _read(as_utf8(data).decode(), lines)
    tables = [np.array(lines.numbers[kind]).reshape(-1, width) for kind, width in WIDTHS.items()]
    colors = np.full((len(tables[0]), 3), np.nan)
    colors.reshape(-1)[: len(lines.colors)] = lines.colors
    corners = _corners(lines, [len(table) for table in tables])
    return [
        _shape(lines, name, group, material, faces, corners, tables, colors)
        for (name, group, material), faces in lines.parts.items()
        if faces.corners
    ]


def _read(text: str, lines: ObjLines) -> None:
    name, group, material, faces, left_out = "", "", "", None, set[str]()
    for number, line in enumerate(text.replace("\r\n", "\n").replace("\\\n", " ").split("\n"), start=1):
        words = line.split()
        match words[:1]:
            case ["v" | "vt" | "vn"]:
                _read_numbers(words, number, lines)
            case ["f" | "fo"]:
                if faces is None:
                    faces = lines.parts.setdefault((name, group, material), Faces())
                own = list(_absolute(words, number, lines)) if "-" in line or "#" in line else words[1:]
                faces.corners.extend(lines.corners.setdefault(corner, len(lines.corners)) for corner in own)
                faces.counts.append(len(own))
            case ["o" | "g" | "usemtl" as kind]:
                called, faces = " ".join(words[1:]), None
                if kind == "o":
                    name, group = called, ""
                elif kind == "g":
                    group = "" if called.lower() in NO_GROUP else called
                else:
                    material = called
            case ["mtllib"]:
                lines.materials.add(line.split(maxsplit=1)[1].strip() if words[1:] else "")
            case [kind] if kind in LEFT_OUT:
                left_out.add(LEFT_OUT[kind])
    if left_out:
        note(f"{lines.path}: its {' and '.join(sorted(left_out))} are left out")


def _read_numbers(words: list[str], number: int, lines: ObjLines) -> None:
    kind = words[0]
    width = WIDTHS[kind]
    try:
        values = [float(word) for word in words[1 : width + 1]]
        # Texture coordinates of one number are a place on a line.
        values += [0.0] * (kind == "vt" and len(values) == 1)
        if len(values) != width:
            raise ValueError(f"{kind} needs {width} numbers")
        if kind == "v" and len(words) >= 7 and words[4] != "#":
            lines.colors.extend([np.nan] * (len(lines.numbers["v"]) - len(lines.colors)))
            lines.colors.extend(float(word) for word in words[4:7])
    except ValueError as error:
        lines.damaged(f"line {number}: {error}")
    lines.numbers[kind].extend(values)


def _absolute(words: list[str], number: int, lines: ObjLines) -> Iterator[str]:
    """The corners of a face, with those that count backwards from its own line counted from the file's start."""
    for word in words[1:]:
        if word.startswith("#"):
            return
        indices = word.split("/")
        for place, (index, (kind, width)) in enumerate(zip(indices, WIDTHS.items(), strict=False)):
            if index.startswith("-"):
                above = len(lines.numbers[kind]) // width
                if not (index[1:].isdecimal() and 0 < int(index[1:]) <= above):
                    lines.damaged(f"line {number}: a face names {kind} {index:.20}, and {above} stand above it")
                indices[place] = str(above + 1 + int(index))
        yield "/".join(indices)


def _corners(lines: ObjLines, counts: list[int]) -> np.ndarray:
    """Rows of the three tables for each corner, (C, 3): -1 where the corner names none."""
    corners = np.zeros((len(lines.corners), 3), np.int64)
    for number, word in enumerate(lines.corners):
        try:
            corners[number] = [int(index or 0) for index in (*word.split("/"), "0", "0")[:3]]
        except (ValueError, OverflowError):
            lines.damaged(f"a face has the corner '{word:.40}'")
    for kind, indices, count in zip(WIDTHS, corners.T, counts, strict=True):
        if len(indices) and (indices.max() > count or indices.min() < (kind == "v")):
            wrong = indices.max() if indices.max() > count else indices.min()
            lines.damaged(f"a face names {kind} {wrong}, and there are {count}")
    return corners - 1


def _shape(
    lines: ObjLines,
    name: str,
    group: str,
    material: str,
    faces: Faces,
    corners: np.ndarray,
    tables: list[np.ndarray],
    colors: np.ndarray,
) -> ModelShape:
    name = group or name or lines.path.stem
    where = f"{lines.path}: part '{name}'"
    used, local = np.unique(np.array(faces.corners, np.int64), return_inverse=True)
    vertex, texcoord, normal = corners[used].T
    positions, texcoords, normals = tables[0][vertex], _chosen(tables[1], texcoord), _chosen(tables[2], normal)
    check_triangles(where, positions, local)
    rows = triangulated(positions[local], np.array(faces.counts), where)[0]
    own = colors[vertex]
    colored = np.isfinite(own).any()
    looks = lines.materials.look(material, texcoords is not None, where)
    if texcoords is not None:
        image = lines.materials.image(material)
        if image is not None:
            texcoords = texcoords * image.scale + image.offset
        # The file counts them from the bottom left.
        texcoords = texcoords * (1.0, -1.0) + (0.0, 1.0)
    return ModelShape(
        name=name,
        positions=positions,
        faces=local[rows],
        normals=normals,
        matrix=np.eye(4),
        material=replace(looks, color=WHITE) if colored and not material else looks,
        material_name=material,
        texcoords=texcoords,
        colors=np.where(np.isfinite(own), linear_colors(own), 1.0) if colored else None,
    )


def _chosen(table: np.ndarray, rows: np.ndarray) -> np.ndarray | None:
    """Rows of a table, zeros for -1; None where all are -1."""
    return np.where(rows[:, None] >= 0, table[rows], 0.0) if (rows >= 0).any() else None
