"""Model files as meshes: OBJ, STL and PLY through trimesh, glTF and GLB through `files/gltf`, STEP and IGES through
`files/cad.py`.

Lengths are taken as they are (glTF's are metres) unless a scale is given. Axes too: y should be up.
"""

from __future__ import annotations

import io
import logging
import re
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from anamorph.base.errors import AnamorphError, nearest
from anamorph.files import cad
from anamorph.files.gltf.gltf_shapes import gltf_shapes
from anamorph.files.materials import appearance
from anamorph.files.model_shape import ModelShape, cofactors
from anamorph.files.normals import creased, repaired, with_winding
from anamorph.files.reading import Folder, as_utf8, read
from anamorph.files.source import FaceChoice
from anamorph.scene.checks import check_triangles
from anamorph.scene.model import Mesh, Texture
from anamorph.scene.triangles import has_area
from anamorph.surfaces.similarity import Similarity

UNNAMED = re.compile(r"^geometry(_\d+)?$")
"""What trimesh calls a mesh that has no name."""

FAR = 1e-3
"""A model smaller than this share of its coordinates is far from the origin."""

SUFFIXES = (".glb", ".gltf", ".obj", ".stl", ".ply", *cad.SUFFIXES)


@dataclass(frozen=True, eq=False)
class Part:
    """A mesh of a model file, and the name of its material there ("" for none)."""

    mesh: Mesh
    material: str = ""


def load_model(path: str | Path, scale: float = 1.0, choice: FaceChoice | None = None) -> tuple[Mesh, ...]:
    """The meshes of a model file, in world coordinates.

    Parameters
    ----------
    path : str or Path
        A .glb, .gltf, .obj, .stl, .ply, .step, .stp, .iges or .igs file.
    scale : float
        Metres in one unit of the file: 0.001 for millimetres. CAD files name their unit, and need none.
    choice : FaceChoice, optional
        Which faces of a CAD file, and how fine.
    """
    return tuple(part.mesh for part in load_parts(path, scale, choice))


def load_parts(
    path: str | Path, scale: float = 1.0, choice: FaceChoice | None = None, near: bool = False
) -> tuple[Part, ...]:
    """Like `load_model`, with the materials' names.

    With `near`, a model that lies so far from the origin that float32 would blur it is moved there: one whose
    extent is below a thousandth of its coordinates, as of a building in map coordinates.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        hint = nearest(suffix, SUFFIXES)
        raise AnamorphError(f"{path}: is no known model; give one that ends in {', '.join(SUFFIXES)}{hint}")
    if not (np.isfinite(scale) and scale > 0):
        raise AnamorphError(f"{path}: scale is {scale}; give a positive number of metres for one unit")
    if suffix in cad.SUFFIXES:
        by = Similarity(scale, np.eye(3), np.zeros(3))
        return uniquely_named(Part(mesh.moved(by)) for mesh in cad.load_cad(path, choice))
    if choice is not None:
        raise AnamorphError(f"{path}: faces and density are for CAD files ({', '.join(cad.SUFFIXES)}); leave them out")
    data = read(path, "model file")
    shapes = gltf_shapes(data, path) if suffix in (".glb", ".gltf") else _shapes(_in_utf8(data, suffix), path)
    placed = [replace(shape, matrix=scale * shape.matrix) for shape in shapes]
    away = trimesh.transformations.translation_matrix(-_far_middle(placed) if near else np.zeros(3))
    parts = [_part(path, replace(shape, matrix=away @ shape.matrix)) for shape in placed]
    kept = [part for part in parts if part is not None]
    if not kept:
        raise AnamorphError(f"{path}: has no triangles with an area; give a model with faces, not points or lines")
    return uniquely_named(kept)


def _far_middle(shapes: list[ModelShape]) -> np.ndarray:
    """The middle of all vertices, float64, where they are far from the origin; else the origin."""
    with np.errstate(all="ignore"):
        points = [shape.positions @ shape.matrix[:3, :3].T + shape.matrix[:3, 3] for shape in shapes]
        ends = np.concatenate([*points, np.zeros((0, 3))])
        low, high = ends.min(axis=0, initial=np.inf), ends.max(axis=0, initial=-np.inf)
        far = np.isfinite(low + high).all() and np.max(high - low) < FAR * np.max(np.abs([low, high]))
    return (low + high) / 2.0 if far else np.zeros(3)


def _in_utf8(data: bytes, suffix: str) -> bytes:
    """A model whose text, of whatever encoding, is in UTF-8, the only one that trimesh reads."""
    if suffix == ".ply":
        header, end, body = data.partition(b"end_header")
        return as_utf8(header) + end + body
    # The length of a binary STL file follows from its count, and a text one may start with the same word "solid".
    text = suffix == ".obj" or (suffix == ".stl" and len(data) != 84 + 50 * int.from_bytes(data[80:84], "little"))
    return as_utf8(data) if text else data


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep what trimesh logs, and numpy warns of on its behalf, off the terminal: the checks after it say more."""
    logger = logging.getLogger("trimesh")
    before = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            yield
    finally:
        logger.setLevel(before)


def _parse(data: bytes, path: Path) -> trimesh.Scene:
    folder = Folder(path)
    kind = path.suffix.lower()[1:]
    options: dict[str, Any] = {"split_objects": True} if kind == "obj" else {}
    damage = None
    scene = trimesh.Scene()
    try:
        with _quiet():
            scene = trimesh.load_scene(io.BytesIO(data), file_type=kind, resolver=folder, process=False, **options)
    # Damage of every kind surfaces in the parser as an error of some kind.
    except Exception as error:
        said = (str(error).splitlines() or [""])[0][:120] or type(error).__name__
        damage = AnamorphError(f"{path}: is damaged or no {kind.upper()} file ({said}); export it again")
    if complaint := folder.complaint or damage:
        raise complaint
    return scene


def _shapes(data: bytes, path: Path) -> list[ModelShape]:
    """The shapes of a file that trimesh reads, in an order that is always the same."""
    scene, textures = _parse(data, path), dict[int, Texture]()
    order = {name: number for number, name in enumerate(scene.geometry)}
    with _quiet():
        placed = [scene.graph[node] for node in scene.graph.nodes_geometry]
    return [
        _shape(path, UNNAMED.sub(path.stem, name), scene.geometry[name], np.asarray(matrix, float), textures)
        for matrix, name in sorted(placed, key=lambda entry: -order[entry[1]])
        if isinstance(scene.geometry[name], trimesh.Trimesh) and len(scene.geometry[name].faces)
    ]


def _shape(path: Path, name: str, geometry: Any, matrix: np.ndarray, textures: dict[int, Texture]) -> ModelShape:
    where = f"{path}: part '{name}'"
    positions, faces = np.asarray(geometry.vertices, float), np.asarray(geometry.faces, np.int64).reshape(-1, 3)
    check_triangles(where, positions, faces)
    # Whether the file itself brought normals shows only in trimesh's cache: asking for them computes them.
    cache = geometry._cache
    normals = np.asarray(cache["vertex_normals"], float) if "vertex_normals" in cache else None
    material, material_name, texcoords, colors = appearance(where, geometry, textures)
    if geometry.visual.kind == "face":
        # One colour a face: each face gets vertices of its own, and `appearance` has given each of them its colour.
        positions, normals = positions[faces].reshape(-1, 3), None if normals is None else normals[faces].reshape(-1, 3)
        faces = np.arange(len(positions)).reshape(-1, 3)
    return ModelShape(name, positions, faces, normals, matrix, material, material_name, texcoords, colors)


def _part(path: Path, shape: ModelShape) -> Part | None:
    """A shape in the world; None where none of its triangles has an area."""
    where = f"{path}: part '{shape.name}'"
    positions, faces, normals, matrix = shape.positions, shape.faces, shape.normals, shape.matrix
    if not len(faces):
        return None
    check_triangles(where, positions, faces)
    if not np.isfinite(matrix).all():
        raise AnamorphError(f"{where}: its transform has NaN or infinite numbers; export it again")
    if shape.texcoords is not None and not np.isfinite(shape.texcoords).all():
        raise AnamorphError(f"{where}: its texture coordinates have NaN or infinite numbers; export it again")
    with np.errstate(over="ignore"):
        # Unlike a product of matrices, this gives equal vertices the same place.
        positions = np.einsum("vi,ji->vj", positions, matrix[:3, :3]) + matrix[:3, 3]
        check_triangles(where, positions.astype(np.float32), faces)
    # A transform that mirrors turns triangles inside out; the cofactors carry normals, mirrored or not.
    if np.linalg.det(matrix[:3, :3]) < 0:
        faces = faces[:, ::-1]
    if normals is not None:
        normals = normals @ cofactors(matrix[:3, :3]).T
    faces = faces[has_area(positions, faces)]
    if not len(faces):
        return None
    source = np.unique(faces)
    faces = np.searchsorted(source, faces)
    if normals is None:
        copies, faces, normals = creased(positions[source], faces)
        source = source[copies]
    else:
        normals = with_winding(repaired(normals[source], positions[source], faces), positions[source], faces)
    return Part(
        Mesh(
            name=shape.name,
            positions=positions[source],
            faces=faces.astype(np.int32),
            normals=normals.astype(np.float32),
            material=shape.material,
            texcoords=None if shape.texcoords is None else shape.texcoords[source].astype(np.float32),
            colors=None if shape.colors is None else shape.colors[source].astype(np.float32),
        ),
        shape.material_name,
    )


def uniquely_named(parts: Iterable[Part]) -> tuple[Part, ...]:
    """Give every part a name of its own: the second 'wheel' is 'wheel-2'."""
    taken: set[str] = set()
    named = []
    for part in parts:
        name, number = part.mesh.name, 1
        while name in taken:
            number += 1
            name = f"{part.mesh.name}-{number}"
        taken.add(name)
        named.append(replace(part, mesh=replace(part.mesh, name=name)))
    return tuple(named)
