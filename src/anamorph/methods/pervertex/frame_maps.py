"""A frame's maps: the bodies as an eye sees them, patch by patch, and as their maps see each other.

Source: Kakimoto et al. 2007, sections 4.1 and 4.4. Deviation: what is seen in a map is seen from the map's viewpoint,
not along the rays that lead there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import wgpu

from anamorph.gpu.buffers import SceneBuffers
from anamorph.gpu.device import maximum_size
from anamorph.methods.pervertex.atlas import MapKind, MapView
from anamorph.methods.pervertex.division import seen_faces
from anamorph.methods.pervertex.level import Level, WarpDraw
from anamorph.methods.pervertex.options import Options
from anamorph.methods.pervertex.seen import Seen, seen_body
from anamorph.methods.pervertex.surroundings import Surroundings
from anamorph.methods.pervertex.warp import MapPlan
from anamorph.optics.ray_meshes import Body, BodyRays, rays_of
from anamorph.scene.camera import Eye

LEAST, MOST = 16, 4096
"""Texels along a side of a map."""

LEAST_SEEN = 12.0
"""A body that spans fewer texels in a map is not worth maps of its own there."""

INNER_FIELD = 140.0
"""Degrees: patches of what is seen in a map are wide, and so are few."""

MOST_INNER = 48
"""How many maps there may be of what is seen in other maps, on each level."""

Extra = Callable[[MapKind, wgpu.GPURenderPassEncoder], None]


@dataclass(frozen=True, eq=False)
class SeenBodies:
    """The bodies as one eye sees them.

    Parameters
    ----------
    level : Level
        Whose maps show them.
    draws : tuple of WarpDraw
    seen : tuple of Seen
    """

    level: Level
    draws: tuple[WarpDraw, ...]
    seen: tuple[Seen, ...]

    @property
    def replaced(self) -> tuple[int, ...]:
        """The meshes that are drawn with it."""
        return tuple(mesh for each in self.seen for mesh in each.body_rays.body.meshes)


class FrameMaps:
    """The maps of all levels of one frame.

    Parameters
    ----------
    surroundings : Surroundings
    bodies : tuple of Body
    levels : sequence of Level
        As many as there are maps in maps at most.
    options : Options
    draw : callable
        Draws the bodies that a map shows into its pass.
    """

    def __init__(
        self,
        surroundings: Surroundings,
        bodies: tuple[Body, ...],
        levels: Sequence[Level],
        options: Options,
        draw: Callable[[SeenBodies, MapKind, wgpu.GPURenderPassEncoder], None],
    ) -> None:
        self._surroundings, self._bodies = surroundings, bodies
        self._levels, self._options, self._draw = levels, options, draw
        self._eye: tuple[float, ...] = ()
        self._rays: list[BodyRays] = []
        self._planned_texels = self._used_texels = 0.0

    def moved(self, surroundings: Surroundings) -> None:
        """Take over the surroundings after meshes have moved."""
        self._surroundings = surroundings

    def plan(self, eye: Eye, position: np.ndarray, extra: Extra | None = None) -> SeenBodies | None:
        """Plan all that an eye at `position` sees; `extra` draws into the maps of the first bounce.

        As long as the eye stays, what the bodies do to its rays is not found again.
        """
        self._planned_texels = self._used_texels = 0.0
        for level in self._levels:
            level.clear()
        key = (*eye.point, *eye.matrix.ravel())
        if key != self._eye:
            self._eye, self._rays = key, [rays_of(body, eye) for body in self._bodies]
        seen = self._seen_by(eye, self._levels, self._options.bounces, self._rays, position, extra)
        for level in self._levels:
            level.place()
        return seen

    def figures(self) -> dict[str, float]:
        """How many maps the last plan has, of all levels, their texels, and the share of these that is looked up."""
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
        levels: Sequence[Level],
        bounces: int,
        rays: Sequence[BodyRays],
        position: np.ndarray | None = None,
        extra: Extra | None = None,
    ) -> SeenBodies | None:
        """Plan what an eye sees by the maps of the first of `levels`, in which the others are seen.

        Its paths may meet `bounces` more interfaces; a body that has more ends them.
        """
        level, draws, found = levels[0], [], []
        options, most = self._options, np.inf
        if level is not self._levels[0]:
            options, most = replace(options, field=max(options.field, INNER_FIELD)), MOST_INNER
        for body_rays in rays:
            after = bounces - interfaces(body_rays.body)
            if after < 0:
                faces = seen_faces(body_rays.rays, eye.size)
                draws += [level.add(body_rays, faces, None, range(0), bounces)] if len(faces) else []
                continue
            left = most - len(level.views)
            seen = seen_body(body_rays, eye.size, position, self._surroundings, options, left)
            if not seen.plans:
                continue
            for faces, plan in zip(seen.patches, seen.plans, strict=True):
                numbers = range(len(plan.projections))
                views = [self._view(body_rays.body, plan, number, levels[1:], after, extra) for number in numbers]
                first = len(level.views)
                level.views.extend(views)
                texels = sum(view.size[0] * view.size[1] for view in views)
                self._planned_texels += texels
                self._used_texels += min(plan.used, 1.0) * texels
                draws.append(level.add(body_rays, faces, plan, range(first, first + len(views))))
            draws += [level.add(body_rays, faces, None, range(1)) for faces in seen.lost]
            found.append(seen)
        return SeenBodies(level, tuple(draws), tuple(found)) if draws else None

    def _size(self, texels: tuple[float, float]) -> tuple[int, int]:
        largest = min(MOST, maximum_size())
        width, height = (int(np.clip(self._options.resolution * side, LEAST, largest)) for side in texels)
        return width, height

    def _view(
        self, body: Body, plan: MapPlan, number: int, inside: Sequence[Level], bounces: int, extra: Extra | None
    ) -> MapView:
        """One map of a plan, with what other bodies show in it by the maps of the levels `inside`.

        Where paths may meet no more `bounces`, the scene's own drawing ends them at mirrors. It leaves out lenses,
        which are drawn to end them as well.
        """
        projection, size = plan.projections[number], self._size(plan.texels[number])
        visible = self._surroundings.visible(projection.clip)
        visible[list(body.meshes)] = False
        inner = None
        shown = [other for other in self._bodies if other is not body and (bounces > 0 or interfaces(other) > 1)]
        if shown:
            eye = plan.eye(number, size)
            others = [
                other for other in shown if visible[list(other.meshes)].any() and _extent(other, eye) >= LEAST_SEEN
            ]
            inner = self._seen_by(eye, inside, bounces, [rays_of(other, eye) for other in others])
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


def interfaces(body: Body) -> int:
    """How many specular interfaces light meets at a body: one at a mirror, and the two sides of a lens."""
    return len(body.sides)


def _each(extras: Sequence[Extra], kind: MapKind, render_pass: wgpu.GPURenderPassEncoder) -> None:
    for extra in extras:
        extra(kind, render_pass)


def _extent(body: Body, eye: Eye) -> float:
    """How many texels a body spans at most, in a map."""
    places = eye.image(np.concatenate([side.optics.positions for side in body.sides]))
    if places[:, 2].min() <= 0.0:
        return float(max(eye.size))
    within = np.clip(places[:, :2] / places[:, 2:], 0.0, eye.size)
    return float(np.ptp(within, axis=0).max())
