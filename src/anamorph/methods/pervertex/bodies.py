"""What bends light in a scene, whole: mirrors of one or more meshes, and lenses of two."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.methods.pervertex.world import World
from anamorph.optics.reflection import Reflector, reflected_rays, reflector
from anamorph.optics.refraction import Refractor, refracted_colors, refracted_rays, refractor
from anamorph.raymesh import RayMesh, RayStatus
from anamorph.scene.camera import Eye
from anamorph.scene.connected import connected_mirrors, welded
from anamorph.scene.geometry import Geometry
from anamorph.scene.lens_pairs import scene_glass
from anamorph.scene.model import Scene


@dataclass(frozen=True, eq=False)
class Side:
    """One way to look at a body: a mirror has one, a lens has two.

    Parameters
    ----------
    meshes : tuple of int
        The meshes whose triangles show what the body bends.
    optics : Reflector or Refractor
        Their vertices, one mesh after the other, and what happens to light there.
    triangles : (F,) int64
        Their numbers in the scene's geometry.
    smooth : (F,) bool
        Whether the true surface lies off the triangle.
    behind : (V,) float64
        How far behind each vertex something else of the scene stands; infinite for nothing, 0 where the body has a
        frame.
    covered : (V,) float64
        How high a rim that lies on it rises over each vertex; 0 for none.
    closed : bool
        Whether the surface is closed, so that no map sees anything behind it.
    edge : int
        The object number of a lens's edge; 0 for none.
    """

    meshes: tuple[int, ...]
    optics: Reflector | Refractor
    triangles: np.ndarray
    smooth: np.ndarray
    behind: np.ndarray
    covered: np.ndarray
    closed: bool
    edge: int = 0


@dataclass(frozen=True, eq=False)
class Body:
    """A mirror or a lens.

    Parameters
    ----------
    meshes : tuple of int
        All of its specular meshes.
    sides : tuple of Side
    """

    meshes: tuple[int, ...]
    sides: tuple[Side, ...]


@dataclass(frozen=True, eq=False)
class Sight:
    """A body as one eye sees it.

    Parameters
    ----------
    side : Side
    rays : RayMesh
    others : tuple of RayMesh
        Those of red and of blue light, where the glass disperses.
    outward : (V, 3) float64
        At each ray's origin, which way leads away from the body.
    """

    side: Side
    rays: RayMesh
    others: tuple[RayMesh, ...]
    outward: np.ndarray

    @property
    def bends(self) -> bool:
        """Whether light goes through, so that only the ray mesh knows the rays."""
        return isinstance(self.side.optics, Refractor)

    def corner_rays(self, faces: np.ndarray) -> np.ndarray:
        """A lens's rays at the corners of `faces`, (F, 3, C, 2, 4), for one colour or for green, red and blue.

        First the origin and the share of the light that goes this way, then the direction and 1 where reflection in
        the glass is total.
        """
        records = []
        for rays in (self.rays, *self.others):
            assert rays.share is not None
            total = rays.status == RayStatus.TOTAL_REFLECTION
            rows = np.stack([np.column_stack([rays.origins, rays.share]), np.column_stack([rays.directions, total])], 1)
            records.append(rows[self.rays.faces[faces]])
        return np.stack(records, axis=2)

    def edge(self) -> np.ndarray:
        """A lens's edge, (2, 4): the middle of its far border and its object number; its axis, and its radius."""
        lens = self.side.optics
        assert isinstance(lens, Refractor)
        return np.array([[*lens.middle, self.side.edge], [*lens.axis, lens.radius]])


def see(body: Body, eye: Eye, dispersion: bool = True) -> Sight:
    """The ray mesh of the side of `body` that `eye` sees most of."""
    side = max(body.sides, key=lambda side: _facing(side, eye)) if len(body.sides) > 1 else body.sides[0]
    optics = side.optics
    if isinstance(optics, Reflector):
        return Sight(side, reflected_rays(optics, eye), (), optics.normals)
    outward = np.broadcast_to(optics.axis, optics.positions.shape)
    if dispersion and optics.abbe is not None:
        red, green, blue = refracted_colors(optics, eye)
        return Sight(side, green, (red, blue), outward)
    return Sight(side, refracted_rays(optics, eye), (), outward)


def _facing(side: Side, eye: Eye) -> int:
    """How many of a side's vertices turn their front to the eye."""
    offsets = eye.offsets(side.optics.positions)
    return int(np.count_nonzero(np.einsum("ij,ij->i", offsets, side.optics.normals) < 0.0))


def bodies_of(scene: Scene, geometry: Geometry, world: World) -> tuple[Body, ...]:
    """The mirrors and lenses of a scene.

    Mirror meshes that share vertices are one body, as the patches of one surface are.

    Raises
    ------
    AnamorphError
        A mesh of glass is no face of a lens.
    """
    glass = scene_glass(scene)
    if glass.others:
        name = scene.meshes[glass.others[0]].name
        raise AnamorphError(f"mesh {name!r}: is of glass but no face of a lens that make_lens made; use raytrace")
    bodies = [Body(group, (_mirror_side(scene, geometry, world, group),)) for group in connected_mirrors(scene)]
    for lens in glass.lenses:
        faces = lens.front, lens.back
        edge = 0 if lens.edge is None else lens.edge + 1
        sides = tuple(_lens_side(scene, geometry, near, far, edge) for near, far in (faces, faces[::-1]))
        bodies.append(Body(faces, sides))
    return tuple(bodies)


def border_vertices(optics: Reflector) -> np.ndarray:
    """The vertices, (B,), on edges that one triangle alone has."""
    place = welded(optics.positions)[optics.faces]
    edges = np.sort(np.concatenate([place[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]), axis=1)
    _, kind, uses = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
    vertices = np.concatenate([optics.faces[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
    return np.unique(vertices[uses[kind.ravel()] == 1])


def _mirror_side(scene: Scene, geometry: Geometry, world: World, group: Sequence[int]) -> Side:
    parts = [reflector(scene.meshes[index]) for index in group]
    starts = np.cumsum([0, *(len(part.positions) for part in parts)])
    optics = Reflector(
        np.concatenate([part.positions for part in parts]),
        np.concatenate([part.normals for part in parts]),
        np.concatenate([part.faces + start for part, start in zip(parts, starts, strict=False)]),
    )
    exact = [scene.meshes[index].surface is not None for index in group]
    smooth = np.repeat(exact, [len(part.faces) for part in parts])
    own = tuple(index + 1 for index in group)
    behind, closed = world.behind(optics.positions, optics.normals, own)
    border = border_vertices(optics)
    if world.bordered(optics.positions, border, optics.normals[border], own):
        behind = np.zeros_like(behind)
    covered = world.covered(optics.positions, optics.normals)
    return Side(tuple(group), optics, _triangles(geometry, group), smooth, behind, covered, closed)


def _lens_side(scene: Scene, geometry: Geometry, near: int, far: int, edge: int) -> Side:
    optics = refractor(scene.meshes[near], scene.meshes[far])
    smooth, behind = np.ones(len(optics.faces), bool), np.zeros(len(optics.positions))
    covered = np.zeros(len(optics.positions))
    return Side((near,), optics, _triangles(geometry, (near,)), smooth, behind, covered, False, edge)


def _triangles(geometry: Geometry, meshes: Sequence[int]) -> np.ndarray:
    return np.concatenate([np.arange(*geometry.first_face[index : index + 2]) for index in meshes])
