"""The edges of mirrors and lenses, each once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.scene.connected import connected_mirrors, welded
from anamorph.scene.model import Glass, Scene


@dataclass(frozen=True, eq=False)
class Wireframe:
    """Edges of a scene's specular meshes.

    Parameters
    ----------
    ends : (N, 2, 3) float32
        World points.
    planes : (N, 2, 4) float64
        (n, c) of the planes of the two triangles at each edge, with n.p + c > 0 before them; of a border's edge
        twice the same.
    lengths : (N,) float32
        Metres.
    """

    ends: np.ndarray
    planes: np.ndarray
    lengths: np.ndarray

    def facing(self, eye: np.ndarray) -> np.ndarray:
        """Which edges, (N,) bool, some triangle shows its front to `eye` (3,)."""
        return (self.planes @ np.append(eye, 1.0) > 0.0).any(axis=1)


def wireframe_of(scene: Scene) -> Wireframe:
    """The edges of all mirrors and lenses; where meshes of one mirror meet, their common edges are one."""
    glass = [(number,) for number, mesh in enumerate(scene.meshes) if isinstance(mesh.material, Glass)]
    parts = [_edges(scene, group) for group in (*connected_mirrors(scene), *glass)]
    ends = np.concatenate([np.zeros((0, 2, 3), np.float32), *(each for each, _ in parts)])
    planes = np.concatenate([np.zeros((0, 2, 4)), *(each for _, each in parts)])
    return Wireframe(ends, planes, np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))


def _edges(scene: Scene, group: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
    """The ends of a body's edges, and the planes beside them."""
    meshes = [scene.meshes[number] for number in group]
    starts = np.cumsum([0, *(len(mesh.positions) for mesh in meshes)])
    positions = np.concatenate([np.asarray(mesh.positions, float) for mesh in meshes])
    faces = np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)])
    corners = positions[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    planes = np.column_stack([normals, -np.einsum("fi,fi->f", normals, corners[:, 0])])
    vertices = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    places = np.sort(welded(positions)[vertices], axis=1)
    keys = places[:, 1].astype(np.int64) * len(positions) + places[:, 0]
    first = np.unique(keys, return_index=True)[1]
    last = len(keys) - 1 - np.unique(keys[::-1], return_index=True)[1]
    # Triangles without area have edges that are points.
    kept = places[first, 0] != places[first, 1]
    first, last = first[kept], last[kept]
    return positions[vertices[first]].astype(np.float32), np.stack([planes[first // 3], planes[last // 3]], axis=1)
