"""A scene as flat arrays: the one numbering of vertices and triangles that rays and drawing share."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.scene.model import WHITE, Mesh, Scene
from anamorph.scene.parts import specular_parts

SPECULAR, BESIDE, APART = 0, 1, 2
"""What an edit may change of a scene: its mirrors and lenses, what else belongs to their parts, and nothing else."""


@dataclass(frozen=True, eq=False)
class Geometry:
    """All meshes of a scene, one after the other.

    Parameters
    ----------
    positions, normals : (V, 3) float32
    texcoords : (V, 2) float32
        Zeros where a mesh has none.
    colors : (V, 3) float32
        Ones where a mesh has none.
    faces : (F, 3) int32
    vertex_object, face_object : (V,), (F,) uint32
        Index into `Scene.meshes` plus one.
    first_vertex, first_face : (meshes + 1,) int64
        Mesh i owns vertices first_vertex[i] to first_vertex[i + 1], and faces likewise.
    kind : (meshes,) int64
        SPECULAR, BESIDE or APART.
    """

    positions: np.ndarray
    normals: np.ndarray
    texcoords: np.ndarray
    colors: np.ndarray
    faces: np.ndarray
    vertex_object: np.ndarray
    face_object: np.ndarray
    first_vertex: np.ndarray
    first_face: np.ndarray
    kind: np.ndarray


def flatten(scene: Scene) -> Geometry:
    """Join the meshes of `scene`, in their order."""
    meshes = scene.meshes
    first_vertex = np.cumsum([0, *(len(mesh.positions) for mesh in meshes)])
    first_face = np.cumsum([0, *(len(mesh.faces) for mesh in meshes)])
    objects = np.arange(1, len(meshes) + 1, dtype=np.uint32)

    kind = np.full(len(meshes), APART)
    kind[[number for part in specular_parts(meshes).values() for number in part]] = BESIDE
    kind[[number for number, mesh in enumerate(meshes) if mesh.specular]] = SPECULAR

    def joined(parts: list[np.ndarray], dtype: type) -> np.ndarray:
        return np.concatenate(parts, dtype=dtype, casting="unsafe")

    def each(values: np.ndarray | None, mesh: Mesh, missing: tuple[float, ...]) -> np.ndarray:
        return np.tile(missing, (len(mesh.positions), 1)) if values is None else values

    return Geometry(
        positions=joined([mesh.positions for mesh in meshes], np.float32),
        normals=joined([mesh.normals for mesh in meshes], np.float32),
        texcoords=joined([each(mesh.texcoords, mesh, (0.0, 0.0)) for mesh in meshes], np.float32),
        colors=joined([each(mesh.colors, mesh, WHITE) for mesh in meshes], np.float32),
        faces=joined([mesh.faces + int(start) for mesh, start in zip(meshes, first_vertex, strict=False)], np.int32),
        vertex_object=np.repeat(objects, np.diff(first_vertex)),
        face_object=np.repeat(objects, np.diff(first_face)),
        first_vertex=first_vertex,
        first_face=first_face,
        kind=kind,
    )
