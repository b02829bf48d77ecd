"""A scene as flat arrays: the one numbering of vertices and triangles that rays and drawing share."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.scene.model import Mesh, Scene


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


def flatten(scene: Scene) -> Geometry:
    """Join the meshes of `scene`, in their order."""
    meshes = scene.meshes
    first_vertex = np.cumsum([0, *(len(mesh.positions) for mesh in meshes)])
    first_face = np.cumsum([0, *(len(mesh.faces) for mesh in meshes)])
    objects = np.arange(1, len(meshes) + 1, dtype=np.uint32)

    def texcoords(mesh: Mesh) -> np.ndarray:
        return np.zeros((len(mesh.positions), 2)) if mesh.texcoords is None else mesh.texcoords

    def colors(mesh: Mesh) -> np.ndarray:
        return np.ones((len(mesh.positions), 3)) if mesh.colors is None else mesh.colors

    return Geometry(
        positions=np.concatenate([mesh.positions for mesh in meshes]).astype(np.float32),
        normals=np.concatenate([mesh.normals for mesh in meshes]).astype(np.float32),
        texcoords=np.concatenate([texcoords(mesh) for mesh in meshes]).astype(np.float32),
        colors=np.concatenate([colors(mesh) for mesh in meshes]).astype(np.float32),
        faces=np.concatenate([mesh.faces + offset for mesh, offset in zip(meshes, first_vertex, strict=False)]).astype(
            np.int32
        ),
        vertex_object=np.repeat(objects, np.diff(first_vertex)),
        face_object=np.repeat(objects, np.diff(first_face)),
        first_vertex=first_vertex,
        first_face=first_face,
    )
