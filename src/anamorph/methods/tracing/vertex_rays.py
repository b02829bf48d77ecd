"""The ray meshes of a scene's mirrors and lenses as the ray tracer's first bounce interpolates them."""

from __future__ import annotations

from typing import Literal

import numpy as np

from anamorph.methods.tracing.bounces import VertexRays
from anamorph.optics.dispersion import line_indices
from anamorph.optics.reflection import Reflector, reflected_rays, reflector
from anamorph.optics.refraction import Refractor, refracted_rays, refractor
from anamorph.raymesh import RayStatus
from anamorph.scene.camera import Eye
from anamorph.scene.geometry import Geometry
from anamorph.scene.lens_pairs import scene_glass
from anamorph.scene.model import Scene

Line = Literal[0, 1, 2]
"""Red, green or blue light: the C, d or F line."""


class SceneRays:
    """What of the ray meshes does not depend on the eye; a lens has two, of which the eye sees one.

    Parameters
    ----------
    scene : Scene
    geometry : Geometry
        Of that scene.
    """

    def __init__(self, scene: Scene, geometry: Geometry) -> None:
        lenses = scene_glass(scene).lenses
        faces = {number for lens in lenses for number in (lens.front, lens.back)}
        self._first, self._meshes = geometry.first_vertex, scene.meshes
        self._mirrors = {
            number: reflector(mesh) for number, mesh in enumerate(scene.meshes) if mesh.specular and number not in faces
        }
        self._lenses = {
            (near, far): refractor(scene.meshes[near], scene.meshes[far])
            for lens in lenses
            for near, far in ((lens.front, lens.back), (lens.back, lens.front))
        }

    def seen_by(self, eye: Eye, line: Line) -> VertexRays:
        """The rays of light of one line."""
        count = int(self._first[-1])
        far = np.zeros(len(self._meshes) + 1, np.int64)
        origins, directions = np.zeros((2, count, 3))
        rays = VertexRays(origins, directions, np.zeros(count), np.zeros(count, np.bool_), far)
        for near, mirror in self._mirrors.items():
            self._write(rays, near, mirror, eye, line)
        for (near, other), lens in self._lenses.items():
            self._write(rays, near, lens, eye, line)
            far[near + 1] = other + 1
        return rays

    def _write(self, rays: VertexRays, number: int, optics: Reflector | Refractor, eye: Eye, line: Line) -> None:
        if isinstance(optics, Reflector):
            mesh = reflected_rays(optics, eye)
        else:
            mesh = refracted_rays(optics, eye, line_indices(optics.index, optics.abbe)[line])
        own = slice(int(self._first[number]), int(self._first[number]) + len(mesh.origins))
        rays.origins[own], rays.directions[own] = mesh.origins, mesh.directions
        if mesh.share is not None:
            rays.share[own] = mesh.share
            rays.leaves[own] = np.isin(mesh.status, (RayStatus.OK, RayStatus.BACK_FACING))
