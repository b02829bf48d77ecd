"""Where a part is and how it is turned: the middle of its box, and axes to its right, up and outward."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.scene.model import Mesh
from anamorph.scene.triangles import doubled_areas

WORLD_UP = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True, eq=False)
class Pose:
    """Where a mirror is, and how it is turned.

    Parameters
    ----------
    center : (3,) float64
        The middle of its box along the axes.
    axes : (3, 3) float64
        Rows: unit vectors to the right as seen by who looks at the mirror, up, and along its mean normal.
    """

    center: np.ndarray
    axes: np.ndarray


def bounding_pose(meshes: tuple[Mesh, ...], up: np.ndarray, where: str) -> Pose:
    """The pose of meshes that together are one mirror.

    `up` (3,) gives way to the y axis where the mirror faces along it more than across.
    """
    outward = mean_normal(meshes)
    if outward is None:
        names = ", ".join(mesh.name for mesh in meshes[:12]) + (", ..." if len(meshes) > 12 else "")
        raise AnamorphError(f"{where}: its faces look all ways; choose the mirror's with --faces (they are: {names})")
    axes = upright_axes(outward, up)
    return Pose(box_middle(meshes, axes), axes)


def mean_normal(meshes: Sequence[Mesh]) -> np.ndarray | None:
    """Where the triangles face on the whole, (3,) unit float64; None where they look all ways."""
    areas = np.concatenate([doubled_areas(mesh.positions, mesh.faces) for mesh in meshes])
    mean = areas.sum(axis=0)
    if np.linalg.norm(mean) <= 0.2 * np.linalg.norm(areas, axis=1).sum():
        return None
    return mean / np.linalg.norm(mean)


def upright_axes(outward: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Rows right, up and `outward`, (3, 3); `up` (3,) gives way to the y axis where that points along it."""
    if abs(outward @ up) > np.sqrt(0.5):
        up = np.array([0.0, 1.0, 0.0]) if abs(outward[1]) < np.sqrt(0.5) else np.array([0.0, 0.0, -np.sign(outward[1])])
    right = np.cross(up, outward)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(outward, right), outward])


def box_middle(meshes: Sequence[Mesh], axes: np.ndarray) -> np.ndarray:
    """The middle, (3,) float64, of the box along `axes` (3, 3) that holds all vertices."""
    inside = np.concatenate([mesh.positions for mesh in meshes]).astype(float) @ axes.T
    return (inside.min(axis=0) + inside.max(axis=0)) / 2.0 @ axes
