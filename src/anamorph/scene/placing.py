"""Putting the mirror that somebody brings where a scene has its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from anamorph.errors import AnamorphError
from anamorph.scene.cad import CadFace, meshes_of
from anamorph.scene.load import Part, uniquely_named
from anamorph.scene.model import Mesh, Mirror, Scene
from anamorph.scene.normals import doubled_areas
from anamorph.scene.transform import Similarity, transform

FRAME_DENSITY = 48
WORLD_UP = np.array([0.0, 1.0, 0.0])
DRAWING_UP = np.array([0.0, 0.0, 1.0])
"""z is up in CAD programs."""


@dataclass(frozen=True, eq=False)
class Frame:
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


def replace_mirror(scene: Scene, faces: tuple[CadFace, ...], density: int, where: str) -> Scene:
    """The scene with CAD faces in place of its mirror, of the same material, their frame laid on that mirror's.

    Parameters
    ----------
    scene : Scene
        One with a part called 'mirror', or a single mirror.
    faces : tuple of CadFace
        In the axes of a CAD file: z up, or y up for a mirror that faces along z.
    density : int
        Of the meshes; the place does not depend on it.
    where : str
        What to call the faces' file in messages.
    """
    number = _mirror_of(scene)
    old = scene.meshes[number]
    here = bounding_frame(meshes_of(faces, FRAME_DENSITY, where), DRAWING_UP, where)
    there = bounding_frame((old,), WORLD_UP, f"scene '{scene.name}'")
    rotation = there.axes.T @ here.axes
    by = Similarity(1.0, rotation, there.center - rotation @ here.center)
    moved = [transform(mesh, by) for mesh in meshes_of(faces, density, where, old.material)]
    parts = [*scene.meshes[:number], *moved, *scene.meshes[number + 1 :]]
    return replace(scene, meshes=tuple(part.mesh for part in uniquely_named(map(Part, parts))))


def _mirror_of(scene: Scene) -> int:
    """Which mesh of a scene is its mirror."""
    mirrors = [number for number, mesh in enumerate(scene.meshes) if isinstance(mesh.material, Mirror)]
    named = [number for number in mirrors if scene.meshes[number].name == "mirror"]
    if len(named) == 1 or len(mirrors) == 1:
        return (named or mirrors)[0]
    raise AnamorphError(
        f"scene '{scene.name}': has {len(mirrors)} mirrors, none of them called 'mirror'; choose another scene"
    )


def bounding_frame(meshes: tuple[Mesh, ...], up: np.ndarray, where: str) -> Frame:
    """The frame of meshes that together are one mirror.

    `up` (3,) gives way to the y axis where the mirror faces along it more than across.
    """
    outward = mean_normal(meshes)
    if outward is None:
        names = ", ".join(mesh.name for mesh in meshes[:12]) + (", ..." if len(meshes) > 12 else "")
        raise AnamorphError(f"{where}: its faces look all ways; choose the mirror's with --faces (they are: {names})")
    axes = upright_axes(outward, up)
    return Frame(box_middle(meshes, axes), axes)


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
