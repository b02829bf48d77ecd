"""A frame's maps: the bodies as an eye sees them, patch by patch, and as their maps see each other.

Source: Kakimoto et al. 2007, sections 4.1 and 4.4. Deviation: what is seen in a map is seen from the map's viewpoint,
not along the rays that lead there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import wgpu

from anamorph.gpu.buffers import SceneBuffers
from anamorph.gpu.device import maximum_size
from anamorph.methods.pervertex.atlas import MapKind, MapView
from anamorph.methods.pervertex.bodies import Body, Sight, see
from anamorph.methods.pervertex.cube_plan import plan_cube
from anamorph.methods.pervertex.division import divide, part_where_hidden, seen_faces
from anamorph.methods.pervertex.level import Level, PatchDraw
from anamorph.methods.pervertex.warp import MapPlan, PlanOptions, plan_map
from anamorph.methods.pervertex.world import World
from anamorph.scene.camera import Eye

LEAST, MOST = 16, 4096
"""Texels along a side of a map."""

LEAST_SEEN = 12.0
"""A body that spans fewer texels in a map is not worth maps of its own there."""

INNER_FIELD = 140.0
"""Degrees: patches of what is seen in a map are wide, and so are few."""

MOST_INNER = 48
"""How many maps there may be of what is seen in other maps, at each depth."""

Extra = Callable[[MapKind, wgpu.GPURenderPassEncoder], None]


@dataclass(frozen=True, eq=False)
class Seen:
    """One body in a picture.

    Parameters
    ----------
    body : Body
    sight : Sight
    hits : (V, 3) float64
        Where its vertex rays meet the scene.
    distances : (V,) float64
        How far that is; infinite for the sky, and where no map shows the vertex.
    plans : tuple of MapPlan
        Of its patches.
    patches : tuple of int arrays
        The faces of each, by their numbers in the ray mesh.
    """

    body: Body
    sight: Sight
    hits: np.ndarray
    distances: np.ndarray
    plans: tuple[MapPlan, ...]
    patches: tuple[np.ndarray, ...]


@dataclass(frozen=True, eq=False)
class Picture:
    """The bodies as one eye sees them.

    Parameters
    ----------
    level : Level
        Whose maps show them.
    draws : tuple of PatchDraw
    seen : tuple of Seen
    """

    level: Level
    draws: tuple[PatchDraw, ...]
    seen: tuple[Seen, ...]

    @property
    def replaced(self) -> tuple[int, ...]:
        """The meshes that are drawn with it."""
        return tuple(mesh for each in self.seen for mesh in each.body.meshes)


@dataclass(frozen=True)
class PictureOptions:
    """What of the pictures one may choose: see `pervertex.Options`."""

    plan: PlanOptions
    field: float
    wide: str
    resolution: float


def plan_patches(
    sight: Sight,
    faces: np.ndarray,
    hider: np.ndarray,
    world: World,
    options: PictureOptions,
    spared: Callable[[], bool] = lambda: False,
) -> Iterator[tuple[np.ndarray, MapPlan | None]]:
    """Divide a body into patches, and plan the map of each.

    Parameters
    ----------
    sight : Sight
    faces : (F,) int
        The faces of the ray mesh that are seen.
    hider : (V,) int
        The object that hides each vertex of the ray mesh from the eye, or 0.
    world : World
    options : PictureOptions
    spared : callable
        Asked before each patch: whether it is not to have a map.

    Yields
    ------
    faces, plan : int array, MapPlan or None
        Of each patch; None where no map can show it, and where it is spared.
    """
    patches = divide(sight.rays, faces, np.radians(options.field))
    if options.wide == "cube" and len(patches) > 1:
        plan = plan_cube(sight, faces, hider, world, options.plan)
        if plan is not None:
            yield faces, plan
            return
    if sight.side.closed and options.plan.cast:
        own = tuple(mesh + 1 for mesh in sight.side.meshes)
        patches = [part for patch in patches for part in part_where_hidden(sight.rays, patch, world, own)]
    for patch in patches:
        yield patch, None if spared() else plan_map(sight, patch, hider, world, options.plan)


class Pictures:
    """The pictures of all depths of one frame.

    Parameters
    ----------
    world : World
    bodies : tuple of Body
    levels : sequence of Level
        One for each bounce.
    options : PictureOptions
    draw : callable
        Draws a picture into a pass.
    """

    def __init__(
        self,
        world: World,
        bodies: tuple[Body, ...],
        levels: Sequence[Level],
        options: PictureOptions,
        draw: Callable[[Picture, MapKind, wgpu.GPURenderPassEncoder], None],
    ) -> None:
        self._world, self._bodies, self._levels, self._options, self._draw = world, bodies, levels, options, draw
        self._eye: tuple[float, ...] = ()
        self._sights: list[Sight] = []
        self._planned_texels = self._used_texels = 0.0

    def moved(self, world: World) -> None:
        """Take over a world whose meshes have moved."""
        self._world = world

    def plan(self, eye: Eye, position: np.ndarray, extra: Extra | None = None) -> Picture | None:
        """Plan all that an eye at `position` sees; `extra` draws into the maps of the first bounce.

        As long as the eye stays, what the bodies do to its rays is not found again.
        """
        self._planned_texels = self._used_texels = 0.0
        for level in self._levels:
            level.clear()
        key = (*eye.point, *eye.matrix.ravel())
        if key != self._eye:
            self._eye, self._sights = key, [see(body, eye) for body in self._bodies]
        casts = self._options.plan.cast
        points = [sight.side.optics.positions for sight in self._sights]
        hiders = [self._world.hiders(position, each) if casts else np.zeros(len(each), int) for each in points]
        picture = self._seen_by(eye, 0, self._bodies, self._sights, hiders, extra)
        for level in self._levels:
            if level.views:
                level.place()
        return picture

    def figures(self) -> dict[str, float]:
        """How many maps the last plan has, of all depths, their texels, and the share of these that is looked up."""
        views = [view for level in self._levels for view in level.views]
        texels = sum(view.size[0] * view.size[1] for view in views)
        # An atlas that is full makes all its maps smaller, and the share stays.
        used = {"maps_used_percent": 100.0 * self._used_texels / self._planned_texels} if views else {}
        return {"maps": float(len(views)), "map_texels": float(texels), **used}

    def draw_maps(
        self,
        encoder: wgpu.GPUCommandEncoder,
        buffers: SceneBuffers,
        kinds: Sequence[MapKind],
        bound: Callable[[Level, int, wgpu.GPURenderPassEncoder], None] | None = None,
    ) -> None:
        """Draw all maps, those of the last bounce first; `bound` may leave out what of a level's map is not needed."""
        for level in reversed(self._levels):
            for kind in kinds if level.views else ():
                level.atlas.draw(encoder, buffers, kind, None if bound is None else partial(bound, level))

    def _seen_by(
        self,
        eye: Eye,
        depth: int,
        bodies: Sequence[Body],
        sights: Sequence[Sight],
        hiders: Sequence[np.ndarray],
        extra: Extra | None = None,
    ) -> Picture | None:
        level, draws, seen = self._levels[depth], [], []
        for body, sight, hider in zip(bodies, sights, hiders, strict=True):
            hits = np.zeros((len(hider), 3))
            distances = np.full(len(hider), np.inf)
            plans: list[MapPlan] = []
            patches: list[np.ndarray] = []
            lost: list[np.ndarray] = []
            for faces, plan in self._plans(sight, seen_faces(sight.rays, eye.size), hider, depth):
                if plan is None:
                    lost.append(faces)
                    continue
                views = [self._view(body, plan, number, depth, extra) for number in range(len(plan.projections))]
                first = len(level.views)
                level.views.extend(views)
                texels = sum(view.size[0] * view.size[1] for view in views)
                self._planned_texels += texels
                self._used_texels += min(plan.used, 1.0) * texels
                draws.append(level.add(sight, faces, plan, range(first, first + len(views))))
                hits[plan.vertices], distances[plan.vertices] = plan.hits, plan.distances
                plans.append(plan)
                patches.append(faces)
            if plans:
                draws += [level.add(sight, faces, None, range(1)) for faces in lost]
                seen.append(Seen(body, sight, hits, distances, tuple(plans), tuple(patches)))
        return Picture(level, tuple(draws), tuple(seen)) if draws else None

    def _plans(
        self, sight: Sight, faces: np.ndarray, hider: np.ndarray, depth: int
    ) -> Iterator[tuple[np.ndarray, MapPlan | None]]:
        """The faces of each patch, and its plan: none for patches that no map can show, or none is worth it."""
        options = replace(self._options, field=max(self._options.field, INNER_FIELD)) if depth else self._options

        def spared() -> bool:
            return depth > 0 and len(self._levels[depth].views) >= MOST_INNER

        return plan_patches(sight, faces, hider, self._world, options, spared)

    def _size(self, texels: tuple[float, float]) -> tuple[int, int]:
        largest = min(MOST, maximum_size())
        width, height = (int(np.clip(self._options.resolution * side, LEAST, largest)) for side in texels)
        return width, height

    def _view(self, body: Body, plan: MapPlan, number: int, depth: int, extra: Extra | None) -> MapView:
        """One map of a plan, with what other bodies show in it."""
        projection, size = plan.projections[number], self._size(plan.texels[number])
        visible = self._world.visible(projection.clip)
        visible[list(body.meshes)] = False
        inner = None
        if depth + 1 < len(self._levels):
            eye = plan.eye(number, size)
            others = [
                other
                for other in self._bodies
                if other is not body and visible[list(other.meshes)].any() and _extent(other, eye) >= LEAST_SEEN
            ]
            sights = [see(other, eye) for other in others]
            unhidden = [np.zeros(len(sight.rays.status), int) for sight in sights]
            inner = self._seen_by(eye, depth + 1, others, sights, unhidden)
        extras: list[Extra] = [] if inner is None else [partial(self._draw, inner)]
        extras += [] if extra is None else [extra]
        return MapView(
            projection,
            size,
            visible,
            replaced=() if inner is None else inner.replaced,
            sky=not plan.reversed(number),
            extra=partial(_each, extras) if extras else None,
        )


def _each(extras: Sequence[Extra], kind: MapKind, render_pass: wgpu.GPURenderPassEncoder) -> None:
    for extra in extras:
        extra(kind, render_pass)


def _extent(body: Body, eye: Eye) -> float:
    """How many texels a body spans at most, in a map."""
    places = eye.picture(np.concatenate([side.optics.positions for side in body.sides]))
    if places[:, 2].min() <= 0.0:
        return float(max(eye.size))
    within = np.clip(places[:, :2] / places[:, 2:], 0.0, eye.size)
    return float(np.ptp(within, axis=0).max())
