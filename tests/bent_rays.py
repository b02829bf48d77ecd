"""Rays that the device bends at the exact surfaces of a scene's mirrors and lenses, for tests."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from compute import computed

from anamorph.optics.exact_sides import ExactSides, exact_sides
from anamorph.optics.ray_meshes import bodies_of
from anamorph.rays.caster import Caster
from anamorph.scene.geometry import Geometry, flatten
from anamorph.scene.model import Scene

SHADER = Path(__file__).parent / "optics" / "bend_rays.wgsl"

GIVEN = np.dtype(
    [
        ("eye", "f4", 3), ("side", "u4"), ("direction", "f4", 3), ("line", "u4"),
        ("corners", "f4", (3, 4)), ("normals", "f4", (3, 4)), ("parameters", "f4", (3, 2)), ("padding", "f4", 2),
    ]
)  # fmt: skip

BENT = np.dtype(
    [("origin", "f4", 4), ("direction", "f4", 3), ("transmittance", "f4"), ("way", "u4"), ("padding", "u4", 3)]
)


class Meeting(NamedTuple):
    """Rays in float32 that meet specular meshes from outside, and where.

    `eyes` and `directions` are (N, 3); `meshes` (N,) and `faces` (N,) are numbers in the scene and in its geometry.
    """

    scene: Scene
    geometry: Geometry
    sides: ExactSides
    eyes: np.ndarray
    directions: np.ndarray
    meshes: np.ndarray
    faces: np.ndarray


def meeting(scene: Scene, eyes: np.ndarray, targets: np.ndarray) -> Meeting:
    """Those of the rays from `eyes` to `targets`, (N, 3) each, that first meet the front of a mirror or a lens."""
    geometry = flatten(scene)
    eyes = np.asarray(eyes, np.float32)
    directions = (targets - eyes).astype(float)
    directions = (directions / np.linalg.norm(directions, axis=1, keepdims=True)).astype(np.float32)
    faces = Caster(geometry).cast(eyes.astype(float), directions.astype(float)).triangle
    meshes = np.where(faces >= 0, geometry.face_object[faces].astype(int) - 1, -1)
    specular = np.array([*(mesh.specular for mesh in scene.meshes), False])
    a, b, c = np.moveaxis(geometry.positions[geometry.faces[faces]].astype(float), 1, 0)
    front = np.sum(np.cross(b - a, c - a) * directions, axis=1) < 0.0
    kept = specular[meshes] & front
    sides = exact_sides(scene, geometry, bodies_of(scene, geometry))
    return Meeting(scene, geometry, sides, eyes[kept], directions[kept], meshes[kept], faces[kept])


def bent(rays: Meeting, line: int = 1) -> np.ndarray:
    """What the device makes of the rays, (N,) of BENT, with origins in the world, in float64 there."""
    given, sides = np.zeros(len(rays.eyes), GIVEN), rays.sides
    corners = rays.geometry.faces[rays.faces]
    given["eye"], given["direction"] = rays.eyes, rays.directions
    given["side"], given["line"] = rays.meshes, line
    given["corners"][..., :3] = rays.geometry.positions[corners]
    given["normals"][..., :3] = rays.geometry.normals[corners]
    given["parameters"] = sides.parameters[corners]
    found = np.zeros(len(given), BENT)
    for kinds in np.unique(sides.kinds[rays.meshes], axis=0):
        own = (sides.kinds[rays.meshes] == kinds).all(axis=1)
        overrides = {"SURFACE": int(kinds[0]), "FAR_SURFACE": int(kinds[1]), "LENS": int(kinds[1] > 0)}
        groups = {0: [given[own]], 3: [sides.numbers, sides.records]}
        found[own] = computed(SHADER, overrides, own.sum(), BENT, groups)
    return found


def origins_of(rays: Meeting, found: np.ndarray) -> np.ndarray:
    """The world points where bent rays begin, (N, 3) float64."""
    return rays.sides.records["origin"][rays.meshes].astype(float) + found["origin"][:, :3]
