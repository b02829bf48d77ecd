"""The rays of cameras made by hand, at any places of their images."""

from __future__ import annotations

import numpy as np

from anamorph.raymesh import RayMesh


def centers(size: tuple[int, int]) -> np.ndarray:
    """Pixel centres, (H W, 2)."""
    width, height = size
    return np.stack(np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5), axis=-1).reshape(-1, 2)


def rays_at(mesh: RayMesh, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Origins and directions, (N, 3), at image points (N, 2), and how many triangles hold each."""
    weights = np.column_stack([points, np.ones(len(points))]) @ np.linalg.inv(mesh.image[mesh.faces])
    weights /= weights.sum(axis=2, keepdims=True)
    within = (weights >= -1e-9).all(axis=2)
    chosen = within.argmax(axis=0), np.arange(len(points))
    corners, share = mesh.faces[chosen[0]], weights[chosen]
    origins, directions = (np.einsum("nk,nki->ni", share, rays[corners]) for rays in (mesh.origins, mesh.directions))
    return origins, directions, within.sum(axis=0)


def unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def from_line(point: np.ndarray, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """How far a point is from lines, (N,)."""
    return np.linalg.norm(np.cross(np.asarray(point) - origins, unit(directions)), axis=1)
