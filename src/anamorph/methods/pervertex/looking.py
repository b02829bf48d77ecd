"""A frame's search: which triangles of each body look into which maps of surfaces, and what no map shows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from anamorph.gpu.device import maximum_size
from anamorph.methods.pervertex.division import divide, part_where_hidden, seen_faces
from anamorph.methods.pervertex.mounting import size_of
from anamorph.methods.pervertex.options import Options
from anamorph.methods.pervertex.rectangles import SceneMap
from anamorph.methods.pervertex.surface_plan import SurfacePlan, plan_surfaces
from anamorph.methods.pervertex.surroundings import Surroundings
from anamorph.optics.ray_meshes import Body, BodyRays, Side
from anamorph.scene.geometry import Geometry

LOOKING = np.dtype(
    [("face", "u4"), ("flags", "u4"), ("first_unseen", "u4"), ("unseen_count", "u4")]
    + [(name, "f4") for name in ("reach", "gap_start", "gap_end", "farthest")]
)
"""A triangle of a body, as search.wgsl reads it."""

MEETS_ITSELF, WITHOUT_MAP = 2, 4
"""Flags of a triangle: its rays may meet their own body, which its maps leave out; and no map shows what they meet."""

SPECULAR = np.uint32(0x80000000)
"""A bit of a triangle's number on the device: the path goes on from it."""

MOST_COMPARED = 400
"""Vertices of a body that are looked from, to tell whether it may see itself."""

LEAST, MOST = 16, 4096
"""Texels along a side of a map."""

LOOKED_FROM = np.array([[6, 0, 0], [0, 6, 0], [0, 0, 6], [3, 3, 0], [0, 3, 3], [3, 0, 3], [2, 2, 2]]) / 6.0
"""Of a triangle, by weights of its corners: where rays leave it that tell whether it sees its own body."""


@dataclass(frozen=True)
class PatchKind:
    """What a pipeline is made for.

    Parameters
    ----------
    sides : int
        How many maps show the patch: two where its rays converge.
    surface, far_surface : int
        Kinds of exact surfaces: that of the triangles, and of a lens that of its other face.
    refracts, disperses : bool
        Whether it is a lens, and one that sends red and blue light its own way.
    """

    sides: int
    surface: int
    far_surface: int
    refracts: bool
    disperses: bool


@dataclass(frozen=True)
class PatchDraw:
    """Triangles of one patch and one mesh.

    Parameters
    ----------
    number, first, count : int
        The patch's number, and its triangles among all of the frame.
    kind : PatchKind
    """

    number: int
    first: int
    count: int
    kind: PatchKind


@dataclass(eq=False)
class Search:
    """What a frame looks at, as it grows.

    Attributes
    ----------
    views : list of SceneMap
    patches : list of range
        The maps of each patch, by their numbers; none where it has no map.
    draws : list of PatchDraw
    looking : list of (F,) arrays of LOOKING
    unseen : list of (N,) uint32
    """

    views: list[SceneMap] = field(default_factory=list)
    patches: list[range] = field(default_factory=list)
    draws: list[PatchDraw] = field(default_factory=list)
    looking: list[np.ndarray] = field(default_factory=list)
    unseen: list[np.ndarray] = field(default_factory=list)
    triangles: int = 0
    listed: int = 0


class Searcher:
    """Plans the search of frames.

    Parameters
    ----------
    geometry : Geometry
    specular : (meshes,) bool
        Which meshes are mirrors or glass.
    kinds : (meshes, 2) int
        From `exact_sides`.
    options : Options
    """

    def __init__(
        self,
        geometry: Geometry,
        specular: np.ndarray,
        kinds: np.ndarray,
        options: Options,
    ) -> None:
        self._geometry, self._specular, self._kinds, self._options = geometry, specular, kinds, options
        self._bent_in: dict[Side, bool] = {}
        self.moved(geometry)

    def moved(self, geometry: Geometry) -> None:
        """Follow the scene's vertices."""
        self._corners = geometry.positions[geometry.faces]

    def search(self, seen: list[BodyRays], size: tuple[int, int], surroundings: Surroundings) -> Search:
        """Plan the maps of what an image of `size` (width, height) shows of bodies."""
        search = Search()
        for body_rays in seen:
            patches = self._patches(body_rays, size, surroundings)
            own = np.isin(self._geometry.face_object, np.array(body_rays.body.meshes) + 1)
            meets = self._meets_itself(body_rays, surroundings)
            for faces in patches:
                plan = plan_surfaces(body_rays, faces, size, surroundings, self._options, self._corners, own)
                self._add(search, body_rays, faces, plan, meets[faces], surroundings)
        return search

    def _add(
        self,
        search: Search,
        body_rays: BodyRays,
        faces: np.ndarray,
        plan: SurfacePlan | None,
        meets: np.ndarray,
        surroundings: Surroundings,
    ) -> None:
        side = body_rays.side
        records = np.zeros(len(faces), LOOKING)
        records["face"] = side.triangles[faces]
        records["flags"] = np.where(meets, MEETS_ITSELF, 0)
        first = len(search.views)
        if plan is None:
            records["flags"] |= WITHOUT_MAP
        else:
            records["first_unseen"] = search.listed + plan.first[:-1]
            records["unseen_count"] = np.diff(plan.first)
            records["reach"], records["gap_start"], records["gap_end"] = plan.ranges.T
            records["farthest"] = plan.farthest
            search.views.extend(self._views(body_rays.body, plan, surroundings))
            search.unseen.append(self._marked(plan.unseen))
            search.listed += len(plan.unseen)
        sides = 1 if plan is None else len(plan.projections)
        for kind, count in self._kinds_of(side, faces, sides):
            search.draws.append(PatchDraw(len(search.patches), search.triangles, count, kind))
            search.triangles += count
        search.patches.append(range(first, len(search.views)))
        search.looking.append(records)

    def _patches(self, body_rays: BodyRays, size: tuple[int, int], surroundings: Surroundings) -> list[np.ndarray]:
        rays = body_rays.rays
        patches = divide(rays, seen_faces(rays, size), np.radians(self._options.field))
        if surroundings.mountings[body_rays.side].closed:
            own = body_rays.side.objects
            return [part for patch in patches for part in part_where_hidden(rays, patch, surroundings, own)]
        return patches

    def _views(self, body: Body, plan: SurfacePlan, surroundings: Surroundings) -> Iterator[SceneMap]:
        largest = min(MOST, maximum_size())
        width, height = (int(np.clip(self._options.resolution * side, LEAST, largest)) for side in plan.texels)
        for projection in plan.projections:
            visible = surroundings.visible(projection.clip)
            visible[list(body.meshes)] = False
            yield SceneMap(projection, (width, height), visible)

    def _kinds_of(self, side: Side, faces: np.ndarray, sides: int) -> Iterator[tuple[PatchKind, int]]:
        """Runs of a patch's triangles that one pipeline draws, and their lengths."""
        objects = self._geometry.face_object[side.triangles[faces]].astype(int)
        starts = np.flatnonzero(np.diff(objects, prepend=-1))
        for start, stop in zip(starts, [*starts[1:], len(objects)], strict=True):
            near, far = (int(kind) for kind in self._kinds[objects[start] - 1])
            yield PatchKind(sides, near, far, side.refracts, side.disperses), int(stop - start)

    def _marked(self, triangles: np.ndarray) -> np.ndarray:
        """Numbers of triangles, from 1, with the bit `SPECULAR` where they are specular surfaces."""
        owners = self._geometry.face_object[triangles - 1].astype(int) - 1
        return triangles.astype(np.uint32) | np.where(self._specular[owners], SPECULAR, np.uint32(0))

    def _is_bent_in(self, side: Side) -> bool:
        if side not in self._bent_in:
            self._bent_in[side] = is_bent_in(side)
        return self._bent_in[side]

    def _meets_itself(self, body_rays: BodyRays, surroundings: Surroundings) -> np.ndarray:
        """The triangles, (F,) bool, whose rays may meet their own body again, which is left out of its maps."""
        rays, side = body_rays.rays, body_rays.side
        if not self._is_bent_in(side):
            return np.zeros(len(rays.faces), bool)
        # Each triangle is looked at by the rays of its corners, of the middles of its sides, and of its own middle.
        origins, directions = (
            (LOOKED_FROM @ each[rays.faces]).reshape(-1, 3) for each in (rays.origins, rays.unit_directions())
        )
        start = np.full(len(origins), 1e-4 * size_of(rays.origins))
        _, met = surroundings.cast_past(origins, directions, start, side.objects)
        meets = met.reshape(len(rays.faces), -1).any(axis=1)
        # And those beside them, because rays between these may meet it, too.
        beside = np.zeros(len(rays.origins), bool)
        beside[rays.faces[meets]] = True
        return beside[rays.faces].any(axis=1)


def is_bent_in(side: Side) -> bool:
    """Whether some of a mirror may be seen from another part of it."""
    optics = side.optics
    if side.refracts:
        return False
    chosen = np.linspace(0, len(optics.positions) - 1, min(len(optics.positions), MOST_COMPARED)).astype(int)
    heights = optics.positions @ optics.normals[chosen].T
    own = np.einsum("ni,ni->n", optics.positions[chosen], optics.normals[chosen])
    return bool((heights - own).max() > 1e-4 * size_of(optics.positions))
