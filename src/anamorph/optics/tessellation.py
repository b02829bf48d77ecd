"""A scene whose mirrors and lenses have the outlines of their exact surfaces.

Between its vertices a mesh has straight edges. Where the exact surface is known, so is how far they leave it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from anamorph.scene.camera import Camera
from anamorph.scene.model import Mesh, Scene
from anamorph.scene.subdivision import split
from anamorph.surfaces.plane import Plane

MOST_CUTS = 6
MOST_TRIANGLES = 200_000

OUTLINE = 0.33
"""How far the edges of a mesh may leave its exact surface, in pixels: its outline then lies within half a pixel."""


def outlined_scene(scene: Scene, camera: Camera, size: tuple[int, int]) -> Scene:
    """A scene whose mirrors and lenses have the outlines of their exact surfaces, to half a pixel.

    That is for meshes that turn away from the camera somewhere: between their vertices, none of their edges
    leaves the surface by more than that at its own distance from the eye. Where a surface ends, its border is the
    mesh's: straight from vertex to vertex, and where that is cut, along the surface.

    Only meshes with an exact surface are cut. Each triangle is judged for itself, and meshes that share an edge cut it
    alike; one that is shared with a mesh without an exact surface stays whole. A triangle is cut at most six times. Of
    all these meshes together there are never more than 200,000 triangles: those that err the most come first.

    Parameters
    ----------
    scene : Scene
    camera : Camera
    size : (width, height)

    Returns
    -------
    Scene
        With the same objects in the same order, and in each mesh the vertices that were there before, first.
    """
    chosen = [
        number
        for number, mesh in enumerate(scene.meshes)
        if mesh.specular and mesh.surface is not None and mesh.parameters is not None
    ]
    meshes = list(scene.meshes)
    for _ in range(MOST_CUTS if chosen else 0):
        errors = np.concatenate([outline_errors(meshes[number], camera, size) for number in chosen])
        # Cutting the three edges of a triangle makes three more of it, and one more of each neighbour.
        most = max(MOST_TRIANGLES - len(errors), 0) // 6
        coarse = np.flatnonzero(errors > OUTLINE)
        coarse = coarse[np.argsort(-errors[coarse], kind="stable")][:most]
        if not len(coarse):
            break
        refined = [meshes[number] for number in chosen]
        edges, kept = _edges(refined, _beside(meshes, chosen))
        wanted = np.setdiff1d(edges[coarse], kept)
        if not len(wanted):
            break
        cuts = np.split(np.isin(edges, wanted), np.cumsum([len(mesh.faces) for mesh in refined[:-1]]))
        for number, cut in zip(chosen, cuts, strict=True):
            meshes[number] = split(meshes[number], cut) if cut.any() else meshes[number]
    return replace(scene, meshes=tuple(meshes))


def outline_errors(mesh: Mesh, camera: Camera, size: tuple[int, int]) -> np.ndarray:
    """How far the edges of each triangle leave its exact surface, (F,) float64, pixels at its distance from the eye.

    It is told from the normals at their ends, as of an arc; 0 for a mesh that does not turn away from the eye anywhere.
    """
    eye, positions = np.asarray(camera.position, float), np.asarray(mesh.positions, float)
    facing = np.einsum("vi,vi->v", eye - positions, mesh.normals)
    if isinstance(mesh.surface, Plane) or facing.min() >= 0.0 or facing.max() <= 0.0:
        return np.zeros(len(mesh.faces))
    corners, normals = positions[mesh.faces], np.asarray(mesh.normals, float)[mesh.faces]
    edges, turns = (np.roll(each, -1, axis=1) - each for each in (corners, normals))
    leaves = np.abs(np.einsum("fei,fei->fe", edges, turns)).max(axis=1) / 8.0
    distance = np.linalg.norm(corners - eye, axis=2).min(axis=1)
    return leaves / np.maximum(distance, leaves) * size[1] / (2.0 * np.tan(np.radians(camera.field_of_view) / 2.0))


def _beside(meshes: list[Mesh], chosen: list[int]) -> np.ndarray:
    """The triangles, (B, 3, 3) float32, of all other meshes that may share an edge with those that are chosen.

    That is those with two corners in the box around these: in a large scene, few.
    """
    own = np.concatenate([np.asarray(meshes[number].positions, np.float32) for number in chosen])
    low, high = own.min(axis=0, initial=np.inf), own.max(axis=0, initial=-np.inf)
    found = [np.zeros((0, 3, 3), np.float32)]
    for number, mesh in enumerate(meshes):
        positions = np.asarray(mesh.positions, np.float32)
        inside = ((positions >= low) & (positions <= high)).all(axis=1)
        if number not in chosen and inside.any():
            found.append(positions[mesh.faces[np.count_nonzero(inside[mesh.faces], axis=1) >= 2]])
    return np.concatenate(found)


def _edges(meshes: list[Mesh], beside: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A number for each edge of each triangle of meshes, (F, 3) int64, and of triangles `beside` them, (B, 3).

    Edges between the same two places have the same.
    """
    positions = np.concatenate([*(np.asarray(mesh.positions, np.float32) for mesh in meshes), beside.reshape(-1, 3)])
    first = np.cumsum([0, *(len(mesh.positions) for mesh in meshes)])
    faces = [mesh.faces + start for mesh, start in zip(meshes, first, strict=False)]
    faces.append(first[-1] + np.arange(3 * len(beside)).reshape(-1, 3))
    place = np.unique(positions, axis=0, return_inverse=True)[1].reshape(-1).astype(np.int64)
    start = place[np.concatenate(faces)]
    stop = np.roll(start, -1, axis=1)
    edges = np.minimum(start, stop) << 32 | np.maximum(start, stop)
    return edges[: len(edges) - len(beside)], edges[len(edges) - len(beside) :]
