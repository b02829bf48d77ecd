"""PLY files: polygons and triangle strips, with their colours and texture coordinates."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.base.notes import note
from anamorph.files.materials import linear_colors, plain
from anamorph.files.model_shape import ModelShape
from anamorph.files.ply_elements import Element, Ply, read_ply
from anamorph.files.polygons import triangulated
from anamorph.files.reading import texture_beside
from anamorph.scene.checks import check_triangles
from anamorph.scene.model import WHITE, Diffuse

INDICES = ("vertex_indices", "vertex_index")
TEXCOORDS = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"), ("s0", "t0"), ("u0", "v0"))
COLORS = (("red", "green", "blue"), ("diffuse_red", "diffuse_green", "diffuse_blue"), ("r", "g", "b"))
KNOWN = ("vertex", "face", "tristrips", "material", "camera")


def ply_shapes(data: bytes, path: Path) -> list[ModelShape]:
    """What a PLY file shows: one shape, or none where it has no faces."""
    ply, where = read_ply(data, path), f"{path}: part '{path.stem}'"
    for name in ply.elements.keys() - set(KNOWN):
        note(f"{path}: its element '{name}' is left out")
    vertex, face = ply.elements.get("vertex", Element("vertex", 0)), ply.elements.get("face", Element("face", 0))
    corners, counts = _polygons(ply, path)
    if not len(corners):
        return []
    positions = _columns(vertex, [("x", "y", "z")])
    if positions is None:
        raise AnamorphError(f"{path}: its vertices have no x, y and z; export it again")
    check_triangles(where, positions, corners)
    rows = triangulated(positions[corners], counts, where)[0]

    texcoords, normals = _columns(vertex, TEXCOORDS), _columns(vertex, [("nx", "ny", "nz")])
    colors = None if (encoded := _columns(vertex, COLORS)) is None else linear_colors(encoded)
    face_colors = _face_colors(face, counts) if colors is None else None
    wedges = _wedges(face, len(corners), path) if texcoords is None else None
    if face_colors is None and wedges is None:
        faces = corners[rows]
    else:
        # What differs from face to face at one vertex gives each corner a vertex of its own.
        faces, positions = rows, positions[corners]
        normals = None if normals is None else normals[corners]
        colors = face_colors if colors is None else colors[corners]
        texcoords = wedges if texcoords is None else texcoords[corners]
    return [
        ModelShape(
            name=path.stem,
            positions=positions.astype(float),
            faces=faces,
            normals=normals,
            matrix=np.eye(4),
            material=_material(ply, path, texcoords is not None, colors is not None),
            material_name="",
            # The file counts them from the bottom left.
            texcoords=None if texcoords is None else texcoords * (1.0, -1.0) + (0.0, 1.0),
            colors=colors,
        )
    ]


def _columns(element: Element, names: Iterable[tuple[str, ...]]) -> np.ndarray | None:
    """Properties of an element side by side: the first that are all there."""
    for group in names:
        if all(name in element.numbers for name in group):
            return np.stack([element.numbers[name] for name in group], axis=1)
    return None


def _polygons(ply: Ply, path: Path) -> tuple[np.ndarray, np.ndarray]:
    """The vertices at the corners of all polygons in turn, and how many each has: of faces, then of strips."""
    corners, counts = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    for kind in ("face", "tristrips"):
        element = ply.elements.get(kind)
        if element is None or not element.count:
            continue
        lists = next((element.lists[name] for name in INDICES if name in element.lists), None)
        if lists is None:
            raise AnamorphError(f"{path}: its element '{kind}' has no list {' or '.join(INDICES)}; export it again")
        values = lists.values.astype(np.int64)
        if kind == "face":
            corners.append(values)
            counts.append(lists.counts)
        else:
            triangles = _strips(np.insert(values, np.cumsum(lists.counts), -1))
            corners.append(triangles.reshape(-1))
            counts.append(np.full(len(triangles), 3))
    return np.concatenate(corners), np.concatenate(counts)


def _strips(values: np.ndarray) -> np.ndarray:
    """The triangles (T, 3) of strips that -1 ends: every other one is wound the other way."""
    ends = values < 0
    place = np.arange(len(values))
    within = place - np.maximum.accumulate(np.where(ends, place + 1, 0))
    strips = np.stack([values[:-2], values[1:-1], values[2:]], axis=1)
    strips = np.where((within[:-2] % 2 == 1)[:, None], strips[:, [1, 0, 2]], strips)
    return strips[(strips >= 0).all(axis=1)]


def _face_colors(face: Element, counts: np.ndarray) -> np.ndarray | None:
    """A linear colour for each corner; those of strips are grey, which have none."""
    encoded = _columns(face, COLORS)
    if encoded is None:
        return None
    colors = np.tile(Diffuse().color, (len(counts), 1))
    colors[: face.count] = linear_colors(encoded)
    return np.repeat(colors, counts, axis=0)


def _wedges(face: Element, count: int, path: Path) -> np.ndarray | None:
    """Texture coordinates that the file has for each corner of each face, (count, 2); (0, 0) for those of strips."""
    found = face.lists.get("texcoord")
    if found is None or not len(found.values):
        return None
    counts = next(face.lists[name].counts for name in INDICES if name in face.lists)
    if not np.array_equal(found.counts, 2 * counts):
        note(f"{path}: not every corner of its faces has two texture coordinates; all are left out")
        return None
    texcoords = np.zeros((count, 2))
    texcoords[: counts.sum()] = found.values.reshape(-1, 2)
    return texcoords


def _material(ply: Ply, path: Path, placed: bool, colored: bool) -> Diffuse:
    if ply.images and not placed:
        note(f"{path}: has no texture coordinates; its image '{ply.images[0]}' is left out")
    elif ply.images:
        if len(ply.images) > 1:
            note(f"{path}: names {len(ply.images)} images; only '{ply.images[0]}' is shown")
        return Diffuse(WHITE, texture_beside(path, ply.images[0]))
    return plain(colored)
