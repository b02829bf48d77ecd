"""Putting the mirror that somebody brings where a scene has its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.files.cad import CadFace, meshes_of
from anamorph.files.models import Part, uniquely_named
from anamorph.scene.model import Mirror, Scene
from anamorph.scene.pose import WORLD_UP, bounding_pose
from anamorph.surfaces.similarity import Similarity

POSE_DENSITY = 48
DRAWING_UP = np.array([0.0, 0.0, 1.0])
"""z is up in CAD programs."""


def replace_mirror(scene: Scene, faces: tuple[CadFace, ...], density: int, where: str) -> Scene:
    """The scene with CAD faces in place of its mirror, of the same material, their pose laid on that mirror's.

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
    here = bounding_pose(meshes_of(faces, POSE_DENSITY, where), DRAWING_UP, where)
    there = bounding_pose((old,), WORLD_UP, f"scene '{scene.name}'")
    rotation = there.axes.T @ here.axes
    by = Similarity(1.0, rotation, there.center - rotation @ here.center)
    moved = [mesh.moved(by) for mesh in meshes_of(faces, density, where, old.material)]
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
