"""What sends the rays of a picture: its mirrors and lenses as the eye sees them, or a ray mesh that is the camera.

Source: Vallance 2005, sections 7.2 (mirrors), 7.3 (refraction) and chapter 6 (cameras made by hand).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.methods.trilinear.pairs import ALL, FRONTS, NONE
from anamorph.optics.reflection import Reflector, reflected_rays, reflector
from anamorph.optics.refraction import Refractor, refracted_colors, refracted_rays, refractor
from anamorph.raymesh import RayMesh, RayStatus
from anamorph.scene.camera import Camera, Eye
from anamorph.scene.connected import connected_mirrors
from anamorph.scene.geometry import Geometry
from anamorph.scene.lens_pairs import scene_glass
from anamorph.scene.model import Scene


@dataclass(frozen=True, eq=False)
class Rays:
    """Ray triangles of light of one colour, K of them.

    Parameters
    ----------
    picture, origins, directions : (K, 3, 3) float64
        As in a `RayMesh`, for the three corners.
    share : (K, 3) float64
        What share of the light goes this way; 1 for mirrors, whose reflectance the pixels find for themselves.
    exists : (K,) bool
        Whether there are rays at all, and on a surface, whether the eye sees its front.
    total : (K,) bool
        Whether reflection in the glass is total.
    face : (K,) int32
        The triangle of the scene that each one is, or -1.
    object : (K,) int32
        The object number of that; 0 for none.
    group, sees : (K,) int32
        The group of scene triangles that the rays leave, and what they see of it: ALL, FRONTS or NONE.
    lens : (K,) int32
        The row, from 1, of the lens in `Sources.lenses`; 0 for none.
    """

    picture: np.ndarray
    origins: np.ndarray
    directions: np.ndarray
    share: np.ndarray
    exists: np.ndarray
    total: np.ndarray
    face: np.ndarray
    object: np.ndarray
    group: np.ndarray
    sees: np.ndarray
    lens: np.ndarray


def bare_rays(mesh: RayMesh) -> Rays:
    """The ray triangles of a ray mesh that is itself the camera."""
    count = len(mesh.faces)
    nothing = np.zeros(count, np.int32)
    return Rays(
        *_corners(mesh), np.ones((count, 3)), _any_direction(mesh), np.zeros(count, bool),
        np.full(count, -1, np.int32), nothing, np.full(count, -1, np.int32), np.full(count, ALL, np.int32), nothing,
    )  # fmt: skip


def _corners(mesh: RayMesh) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return mesh.picture[mesh.faces], mesh.origins[mesh.faces], mesh.directions[mesh.faces]


def _any_direction(mesh: RayMesh) -> np.ndarray:
    return mesh.directions[mesh.faces].any(axis=(1, 2))


def _faces_eye(mesh: RayMesh) -> np.ndarray:
    """Whether triangles turn their front to the eye, (K,): clockwise in the picture, whose y points down."""
    return np.linalg.det(mesh.picture[mesh.faces]) < 0.0


@dataclass(frozen=True, eq=False)
class _Surface:
    """One mesh that sends rays, or for a lens either of two, by which side the eye is on."""

    optics: tuple[Reflector | Refractor, ...]
    meshes: tuple[int, ...]
    group: int
    lens: int


class Sources:
    """The mirrors and lenses of a scene.

    Attributes
    ----------
    group : (F,) int32
        For each triangle of the scene the body that it belongs to, from 1; 0 for what is not specular.
    normals : (F, 3, 3) float64
        Unit vectors at the corners of mirrors' triangles, exact where the surface is; zeros elsewhere.
    lenses : (lenses, 2, 4) float64
        The middle of the edge of each lens's far face, and the edge's object number; its axis, and its radius. Two for
        each lens, one for either side.
    """

    def __init__(self, scene: Scene, geometry: Geometry) -> None:
        glass = scene_glass(scene)
        if glass.others:
            name = scene.meshes[glass.others[0]].name
            raise AnamorphError(f"mesh {name!r}: is of glass but no face of a lens that make_lens made; use raytrace")
        self._first_face = geometry.first_face
        self.group = np.zeros(len(geometry.faces), np.int32)
        self.normals = np.zeros((len(geometry.faces), 3, 3))
        self._surfaces: list[_Surface] = []
        lenses: list[list[list[float]]] = []
        for number, body in enumerate(connected_mirrors(scene), start=1):
            for mesh in body:
                optics = reflector(scene.meshes[mesh])
                self._surfaces.append(_Surface((optics,), (mesh,), number, 0))
                self._own(mesh, number)
                self.normals[slice(*self._first_face[mesh : mesh + 2])] = optics.normals[optics.faces]
        for number, pair in enumerate(glass.lenses, start=1 + int(self.group.max(initial=0))):
            meshes = pair.front, pair.back
            sides = tuple(refractor(scene.meshes[a], scene.meshes[b]) for a, b in (meshes, meshes[::-1]))
            self._surfaces.append(_Surface(sides, meshes, number, 1 + len(lenses)))
            edge = 0 if pair.edge is None else pair.edge + 1
            lenses += [[[*side.middle, edge], [*side.axis, side.radius]] for side in sides]
            for mesh in meshes:
                self._own(mesh, number)
        self.lenses = np.array(lenses).reshape(-1, 2, 4)

    def _own(self, mesh: int, group: int) -> None:
        self.group[slice(*self._first_face[mesh : mesh + 2])] = group

    @property
    def disperses(self) -> bool:
        """Whether some glass sends colours different ways."""
        return any(isinstance(each, Refractor) and each.abbe is not None for s in self._surfaces for each in s.optics)

    @property
    def meshes(self) -> tuple[int, ...]:
        """The meshes whose triangles send rays."""
        return tuple(mesh for surface in self._surfaces for mesh in surface.meshes)

    def rays(self, camera: Camera, size: tuple[int, int], dispersion: bool) -> list[Rays]:
        """What the eye's rays become: green light or all, and then red and blue where glass sends them other ways."""
        eye = camera.eye(size)
        lines: list[list[Rays]] = [[], [], []]
        for surface in self._surfaces:
            side = max(range(len(surface.optics)), key=lambda side: _facing(surface.optics[side], eye))
            optics = surface.optics[side]
            if isinstance(optics, Reflector):
                meshes = [reflected_rays(optics, eye)]
            elif dispersion and optics.abbe is not None:
                red, green, blue = refracted_colors(optics, eye)
                meshes = [green, red, blue]
            else:
                meshes = [refracted_rays(optics, eye)]
            for line, mesh in zip(lines, meshes, strict=False):
                line.append(self._rays(surface, side, mesh))
        return [_joined(line) for line in lines if line]

    def _rays(self, surface: _Surface, side: int, mesh: RayMesh) -> Rays:
        first, last = self._first_face[surface.meshes[side] : surface.meshes[side] + 2]
        count = last - first
        share = np.ones((count, 3)) if mesh.share is None else mesh.share[mesh.faces]
        total = (mesh.status == RayStatus.TOTAL_REFLECTION)[mesh.faces].any(axis=1)
        return Rays(
            *_corners(mesh), share, _any_direction(mesh) & _faces_eye(mesh), total,
            np.arange(first, last, dtype=np.int32),
            np.full(count, surface.meshes[side] + 1, np.int32),
            np.full(count, surface.group, np.int32),
            np.full(count, NONE if surface.lens else FRONTS, np.int32),
            np.full(count, surface.lens + side if surface.lens else 0, np.int32),
        )  # fmt: skip


def _facing(optics: Reflector | Refractor, eye: Eye) -> int:
    """How many vertices turn their front to the eye."""
    return int(np.count_nonzero(np.einsum("ij,ij->i", eye.offsets(optics.positions), optics.normals) < 0.0))


def _joined(parts: list[Rays]) -> Rays:
    return Rays(*(np.concatenate([getattr(part, name) for part in parts]) for name in Rays.__dataclass_fields__))
