"""Model files as meshes: the shapes that each kind's reader finds, brought into the world.

Lengths are metres and y is up, as in glTF, unless units, axes or a scale are given.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from anamorph.base.errors import AnamorphError, nearest
from anamorph.files import cad
from anamorph.files.gltf.gltf_shapes import gltf_shapes
from anamorph.files.model_shape import ModelShape, cofactors
from anamorph.files.normals import creased, repaired, with_winding
from anamorph.files.obj import obj_shapes
from anamorph.files.ply import ply_shapes
from anamorph.files.reading import read
from anamorph.files.source import FaceChoice
from anamorph.files.stl import stl_shapes
from anamorph.files.units_and_axes import metres_in, turn_of
from anamorph.scene.checks import check_triangles
from anamorph.scene.model import Mesh
from anamorph.scene.triangles import has_area
from anamorph.surfaces.similarity import Similarity

FAR = 1e-3
"""A model smaller than this share of its coordinates is far from the origin."""

READERS = {".glb": gltf_shapes, ".gltf": gltf_shapes, ".obj": obj_shapes, ".stl": stl_shapes, ".ply": ply_shapes}
"""What reads the bytes of a file, by how its name ends."""

SUFFIXES = (*READERS, *cad.SUFFIXES)


@dataclass(frozen=True, eq=False)
class Part:
    """A mesh of a model file, and the name of its material there ("" for none)."""

    mesh: Mesh
    material: str = ""


def load_model(
    path: str | Path, scale: float = 1.0, choice: FaceChoice | None = None, units: str = "", axes: str = ""
) -> tuple[Mesh, ...]:
    """The meshes of a model file, in world coordinates.

    Parameters
    ----------
    path : str or Path
        A .glb, .gltf, .obj, .stl, .ply, .step, .stp, .iges or .igs file.
    scale : float
        Metres in one unit of the file: 0.001 for millimetres. CAD files name their unit, and need none.
    choice : FaceChoice, optional
        Which faces of a CAD file, and how fine.
    units : str
        The file's unit, as "mm" or "in", times `scale`. CAD files name theirs.
    axes : str
        Which way the file's axes point, as "z up" or "x back, z up"; where "", y is up and z points back.
    """
    return tuple(part.mesh for part in load_parts(path, scale, choice, units, axes))


def load_parts(
    path: str | Path,
    scale: float = 1.0,
    choice: FaceChoice | None = None,
    units: str = "",
    axes: str = "",
    near: bool = False,
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
    if units and suffix in cad.SUFFIXES:
        raise AnamorphError(f"{path}: names its unit itself; leave units out, or give a scale")
    try:
        by = Similarity(scale * metres_in(units), turn_of(axes), np.zeros(3))
    except AnamorphError as error:
        raise AnamorphError(f"{path}: {error}") from None
    if suffix in cad.SUFFIXES:
        return uniquely_named(Part(mesh.moved(by)) for mesh in cad.load_cad(path, choice))
    if choice is not None:
        raise AnamorphError(f"{path}: faces and density are for CAD files ({', '.join(cad.SUFFIXES)}); leave them out")
    # Numbers that overflow are no warning here: what comes of them is looked at, part by part.
    with np.errstate(over="ignore", invalid="ignore"):
        shapes = READERS[suffix](read(path, "model file"), path)
        placed = [replace(shape, matrix=_after(shape.matrix, by)) for shape in shapes]
        away = Similarity.shift(-_far_middle(placed) if near else np.zeros(3))
        parts = [_part(path, replace(shape, matrix=_after(shape.matrix, away))) for shape in placed]
    kept = [part for part in parts if part is not None]
    if not kept:
        raise AnamorphError(f"{path}: has no triangles with an area; give a model with faces, not points or lines")
    return uniquely_named(kept)


def _after(matrix: np.ndarray, by: Similarity) -> np.ndarray:
    """A transform (4, 4) with a motion after it."""
    return np.vstack(
        [np.column_stack([by.vectors(matrix[:3, :3].T).T, by.points(matrix[:3, 3])]), [0.0, 0.0, 0.0, 1.0]]
    )


def _far_middle(shapes: list[ModelShape]) -> np.ndarray:
    """The middle of all vertices, float64, where they are far from the origin; else the origin."""
    with np.errstate(all="ignore"):
        points = [shape.positions @ shape.matrix[:3, :3].T + shape.matrix[:3, 3] for shape in shapes]
        ends = np.concatenate([*points, np.zeros((0, 3))])
        low, high = ends.min(axis=0, initial=np.inf), ends.max(axis=0, initial=-np.inf)
        far = np.isfinite(low + high).all() and np.max(high - low) < FAR * np.max(np.abs([low, high]))
    return (low + high) / 2.0 if far else np.zeros(3)


LARGEST = 1e9
"""Of texture coordinates and colours: what float32 can tell apart of larger ones is of no use."""


def _part(path: Path, shape: ModelShape) -> Part | None:
    """A shape in the world; None where none of its triangles has an area."""
    where = f"{path}: part '{shape.name}'"
    positions, faces, normals, matrix = shape.positions, shape.faces, shape.normals, shape.matrix
    if not len(faces):
        return None
    check_triangles(where, positions, faces)
    if not np.isfinite(matrix).all():
        raise AnamorphError(f"{where}: its transform has NaN or infinite numbers; export it again")
    for what, values in (("texture coordinates", shape.texcoords), ("vertex colours", shape.colors)):
        if values is not None and not (np.abs(values) <= LARGEST).all():
            raise AnamorphError(f"{where}: its {what} have NaN, infinite or far too large numbers; export it again")
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
