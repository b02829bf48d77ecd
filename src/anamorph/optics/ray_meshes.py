"""The maker of ray meshes: what a scene's mirrors and lenses do to the rays of an eye.

A body is a mirror or a lens as a whole. `bodies_of` finds a scene's bodies, once for all eyes. `rays_of` gives what one
eye sees of a body: the side that it looks at, and the ray mesh of that side.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.optics.dispersion import line_indices
from anamorph.optics.reflection import Reflector, reflected_rays, reflector
from anamorph.optics.refraction import Refractor, refracted_rays, refractor
from anamorph.raymesh import RayMesh
from anamorph.scene.camera import Eye
from anamorph.scene.connected import connected_mirrors
from anamorph.scene.geometry import Geometry
from anamorph.scene.lens_pairs import scene_glass
from anamorph.scene.model import Scene

Line = Literal[0, 1, 2]
"""Red, green or blue light: the C, d or F line."""


@dataclass(frozen=True, eq=False)
class Side:
    """One way to look at a body: a mirror has one, a lens has two.

    Parameters
    ----------
    meshes : tuple of int
        The meshes of the scene that show this side.
    optics : Reflector or Refractor
        Their vertices, one mesh after the other, and what happens to light there.
    vertices, triangles : (V,), (F,) int64
        The numbers of these in the scene's geometry.
    smooth : (F,) bool
        Whether the exact surface of a triangle is known, which lies off the triangle.
    edge : int
        The object number of a lens's edge; 0 for none.
    """

    meshes: tuple[int, ...]
    optics: Reflector | Refractor
    vertices: np.ndarray
    triangles: np.ndarray
    smooth: np.ndarray
    edge: int = 0

    @property
    def objects(self) -> tuple[int, ...]:
        """The object numbers of its meshes."""
        return tuple(mesh + 1 for mesh in self.meshes)

    @property
    def refracts(self) -> bool:
        """Whether light goes through, so that only the ray mesh knows the rays."""
        return isinstance(self.optics, Refractor)

    @property
    def disperses(self) -> bool:
        """Whether colours go different ways."""
        return isinstance(self.optics, Refractor) and self.optics.abbe is not None

    @property
    def outward(self) -> np.ndarray:
        """Unit vectors that lead away from the body where each ray leaves it, (V, 3)."""
        optics = self.optics
        return optics.normals if isinstance(optics, Reflector) else np.broadcast_to(optics.axis, optics.positions.shape)

    def lens_edge(self) -> np.ndarray:
        """The cylinder around a lens, (2, 4): the middle of its far border and the edge's object number; its axis and
        its radius."""
        lens = self.optics
        assert isinstance(lens, Refractor)
        return np.array([[*lens.middle, self.edge], [*lens.axis, lens.radius]])

    def facing(self, eye: Eye) -> int:
        """How many vertices turn their front to an eye."""
        offsets = eye.offsets(self.optics.positions)
        return int(np.count_nonzero(np.einsum("ij,ij->i", offsets, self.optics.normals) < 0.0))


@dataclass(frozen=True, eq=False)
class Body:
    """A mirror or a lens.

    Parameters
    ----------
    meshes : tuple of int
        All of its specular meshes.
    sides : tuple of Side
        One for a mirror; two for a lens, in the order of its meshes.
    """

    meshes: tuple[int, ...]
    sides: tuple[Side, ...]


@dataclass(frozen=True, eq=False)
class BodyRays:
    """What one eye sees of a body.

    Parameters
    ----------
    body : Body
    side : Side
        The one that the eye looks at.
    rays : RayMesh
        Of green light, or of all light where the body does not disperse it.
    others : tuple of RayMesh
        Those of red and of blue light, where the glass disperses; `image` and `faces` are those of `rays`.
    """

    body: Body
    side: Side
    rays: RayMesh
    others: tuple[RayMesh, ...] = ()


def bodies_of(scene: Scene, geometry: Geometry) -> tuple[Body, ...]:
    """The mirrors of a scene, then its lenses.

    Mirror meshes that `connected_mirrors` joins are one body, as the patches of one surface are.

    Raises
    ------
    AnamorphError
        A mesh of glass is no face of a lens.
    """
    glass = scene_glass(scene)
    if glass.others:
        name = scene.meshes[glass.others[0]].name
        raise AnamorphError(
            f"mesh {name!r}: is of glass but no face of a lens that make_lens made; use raytrace:truth=surface"
        )
    bodies = [Body(group, (_mirror_side(scene, geometry, group),)) for group in connected_mirrors(scene)]
    for lens in glass.lenses:
        faces = lens.front, lens.back
        edge = 0 if lens.edge is None else lens.edge + 1
        bodies.append(Body(faces, tuple(_lens_side(scene, geometry, *pair, edge) for pair in (faces, faces[::-1]))))
    return tuple(bodies)


def rays_of(body: Body, eye: Eye, dispersion: bool = True) -> BodyRays:
    """The ray meshes of the side of a body that shows an eye most of its vertices.

    Without `dispersion`, all light goes where green light goes.
    """
    side = max(body.sides, key=lambda side: side.facing(eye)) if len(body.sides) > 1 else body.sides[0]
    rays = side_rays(side, eye)
    if not (dispersion and side.disperses):
        return BodyRays(body, side, rays)
    others = side_rays(side, eye, 0), side_rays(side, eye, 2)
    return BodyRays(body, side, rays, tuple(replace(each, image=rays.image) for each in others))


def side_rays(side: Side, eye: Eye, line: Line = 1) -> RayMesh:
    """The ray mesh of one side of a body for light of one line, whether or not the eye looks at that side."""
    optics = side.optics
    if isinstance(optics, Reflector):
        return reflected_rays(optics, eye)
    return refracted_rays(optics, eye, line_indices(optics.index, optics.abbe)[line])


def _mirror_side(scene: Scene, geometry: Geometry, group: tuple[int, ...]) -> Side:
    parts = [reflector(scene.meshes[index]) for index in group]
    starts = np.cumsum([0, *(len(part.positions) for part in parts)])
    optics = Reflector(
        np.concatenate([part.positions for part in parts]),
        np.concatenate([part.normals for part in parts]),
        np.concatenate([part.faces + start for part, start in zip(parts, starts, strict=False)]),
    )
    exact = [scene.meshes[index].surface is not None for index in group]
    smooth = np.repeat(exact, [len(part.faces) for part in parts])
    return Side(group, optics, *_numbers(geometry, group), smooth)


def _lens_side(scene: Scene, geometry: Geometry, near: int, far: int, edge: int) -> Side:
    optics = refractor(scene.meshes[near], scene.meshes[far])
    return Side((near,), optics, *_numbers(geometry, (near,)), np.ones(len(optics.faces), bool), edge)


def _numbers(geometry: Geometry, meshes: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """The numbers of all vertices and of all triangles of some meshes, one mesh after the other."""
    vertices, triangles = (
        np.concatenate([np.arange(*first[index : index + 2]) for index in meshes])
        for first in (geometry.first_vertex, geometry.first_face)
    )
    return vertices, triangles
