"""An eye before a specular surface, as a ray mesh: the reflected ray at every vertex."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.optics.laws import reflect
from anamorph.raymesh import RayMesh, RayStatus
from anamorph.scene.camera import Eye
from anamorph.scene.model import Mesh, Mirror


@dataclass(frozen=True, eq=False)
class Reflector:
    """What of a mirror does not depend on the eye.

    Parameters
    ----------
    positions, normals : (V, 3) float64
        Those of the exact surface where the mesh has one.
    faces : (F, 3) int32
    """

    positions: np.ndarray
    normals: np.ndarray
    faces: np.ndarray


def reflector(mesh: Mesh) -> Reflector:
    """Prepare a mirror mesh for `reflected_rays`, once for all frames."""
    if not isinstance(mesh.material, Mirror):
        raise AnamorphError(f"mesh {mesh.name!r}: does not reflect; give it the material Mirror")
    if mesh.surface is not None and mesh.parameters is not None:
        exact = mesh.surface.normal(mesh.parameters)
        # The mesh says which side is the mirror: one cut from a sphere may be its inside.
        turned = np.sum(exact * mesh.normals, axis=1, keepdims=True) < 0.0
        return Reflector(mesh.surface.position(mesh.parameters), np.where(turned, -exact, exact), mesh.faces)
    normals = np.asarray(mesh.normals, float)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    if not length.all():
        raise AnamorphError(f"mesh {mesh.name!r}: normals has a zero vector; give unit normals")
    return Reflector(np.asarray(mesh.positions, float), normals / length, mesh.faces)


def reflected_rays(mirror: Reflector, eye: Eye) -> RayMesh:
    """The ray mesh of `mirror` as `eye` sees it.

    A vertex that turns its back on the eye is BACK_FACING; its direction still follows the formula, so that
    what is interpolated between it and a front-facing neighbour changes smoothly across the silhouette.

    Parameters
    ----------
    mirror : Reflector
    eye : Eye

    Returns
    -------
    RayMesh
    """
    offset = eye.offsets(mirror.positions)
    image = eye.image(mirror.positions)
    away = np.einsum("ij,ij->i", offset, mirror.normals) >= 0.0
    status = np.where(away, np.uint8(RayStatus.BACK_FACING), np.uint8(RayStatus.OK))
    # Directions as long as the eye's distance are linear on a flat mirror, so that interpolating them is exact there.
    return RayMesh(image, mirror.positions, reflect(offset, mirror.normals), mirror.faces, status)
