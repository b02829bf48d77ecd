"""What is drawn into space over the image: wireframe, hits, virtual viewpoints, view volumes, the eye, a path.

They are those of per-vertex reflection, planned for the eye that looks. Source: Kakimoto et al. 2007, Figures 1, 3
and 4.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.methods.pervertex import MapPlan, Options, Seen, Surroundings, seen_bodies, surroundings_of
from anamorph.optics.ray_meshes import Body, bodies_of
from anamorph.projection import Projection
from anamorph.raymesh import RayStatus
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import Geometry, flatten
from anamorph.scene.model import Scene
from anamorph.viewer.facts import Inspection, Reflections
from anamorph.viewer.marks import NO_MARKS, Marks, between, dot_marks, joined, line_marks
from anamorph.viewer.state import Drawing, State
from anamorph.viewer.wireframe import Wireframe, wireframe_of

MOST_HITS, MOST_RAYS = 400, 100
"""Of one body that are drawn: more cannot be told apart."""

LONG_WIRE = 16.0
"""Pixels: shorter edges are fainter, so that a fine mesh does not hide the image."""

FARTHEST = 10.0
"""How far away a virtual viewpoint is shown, in diagonals of the scene: beyond, rays are parallel to the eye."""

PAST = 1.1
"""How far lines are drawn past the viewpoint, and a view volume past the farthest hit, for 1 up to there."""

EYE_DEPTH = 0.3
"""Of the eye's image, for 1 at the nearest mirror or lens."""

WIRE = (0.85, 0.9, 0.95, 0.8)
LEAST_ALPHA, HIDDEN_ALPHA = 0.15, 0.3
"""Of edges, relative to the front's long ones: the shortest, and those seen from behind."""

WITHIN_ALPHA = 0.5
"""Of rays as their own eye sees them: they run through its image."""

HIT, RAY, SKY_RAY = (0.9, 0.03, 0.02, 1.0), (1.0, 0.3, 0.15, 0.75), (0.3, 0.55, 1.0, 0.4)
EYE, EYE_RAY = (1.0, 1.0, 1.0, 1.0), (0.1, 0.25, 1.0, 0.6)
VIEWPOINT, LINE = (0.9, 0.02, 0.02, 1.0), (1.0, 0.75, 0.05, 0.6)
VOLUME, APEX = (0.05, 0.8, 0.35, 0.9), (0.05, 0.8, 0.35, 0.35)
LEG_COLORS = ((0.05, 0.35, 1.0, 1.0), (1.0, 0.55, 0.0, 1.0), (0.9, 0.05, 0.35, 1.0))
"""Of a path's legs: from the eye, between surfaces, and to its end."""


HIDDEN_LEG = (0.55, 0.55, 0.55, 0.8)
DASHES = 24
"""Of a leg of a path in which something stands."""


@dataclass(frozen=True, eq=False)
class PreparedScene:
    """A scene, and what is prepared of it once for all frames, when it is first needed."""

    scene: Scene

    @cached_property
    def geometry(self) -> Geometry:
        """All meshes as one."""
        return flatten(self.scene)

    @cached_property
    def bodies(self) -> tuple[Body, ...]:
        """Mirrors and lenses; none where the scene has glass that no ray mesh is made of."""
        try:
            return bodies_of(self.scene, self.geometry)
        except AnamorphError:
            return ()

    @cached_property
    def surroundings(self) -> Surroundings:
        """What rays may hit."""
        return surroundings_of(self.geometry, self.bodies)

    @cached_property
    def wireframe(self) -> Wireframe:
        """The edges of mirrors and lenses."""
        return wireframe_of(self.scene)


def space_marks(
    space: PreparedScene,
    state: State,
    looking: Camera,
    size: tuple[int, int],
    inspection: Inspection | None = None,
    reflections: Reflections | None = None,
) -> Marks:
    """All that `state` asks to be drawn into space.

    It changes only with what is given here: while all of that stays, so do the marks.

    Parameters
    ----------
    space : Space
    state : State
    looking : Camera
        The eye whose rays are shown, as `looking_eye` says.
    size : (width, height)
        Of its image, in pixels.
    inspection : Inspection, optional
        Of the pixel whose path is shown.
    reflections : Reflections, optional
        Of the point whose reflection points are shown.
    """
    shown = state.observer or looking
    seen: list[Seen] = []
    if state.drawings & {Drawing.HITS, Drawing.VIEWPOINT, Drawing.VOLUME}:
        seen = seen_bodies(space.bodies, space.surroundings, looking, size, _map_options(state))
    parts = []
    if Drawing.VOLUME in state.drawings:
        parts += [volume_marks(each, space.surroundings.diagonal) for each in seen]
    if Drawing.VIEWPOINT in state.drawings:
        parts += [viewpoint_marks(each, space.surroundings.diagonal) for each in seen]
    if Drawing.WIREFRAME in state.drawings:
        parts.append(wireframe_marks(space.wireframe, shown, size))
    if Drawing.HITS in state.drawings:
        eye = looking if state.observer else None
        parts += [hit_marks(each, space.surroundings.diagonal, eye) for each in seen]
    if state.observer is not None:
        parts.append(eye_marks(looking, size, _eye_depth(space, looking)))
    if inspection is not None:
        parts.append(path_marks(inspection))
    if reflections is not None:
        parts.append(reflection_marks(reflections))
    return joined(parts)


def wireframe_marks(wireframe: Wireframe, shown: Camera, size: tuple[int, int]) -> Marks:
    """The edges of mirrors and lenses, fainter where they are short or seen from behind in an image of `size`."""
    eye = np.asarray(shown.position, np.float32)
    distance = np.linalg.norm(wireframe.ends[:, 0] - eye, axis=1)
    pixel = 2.0 * np.tan(np.radians(shown.field_of_view) / 2.0) / size[1]
    long = wireframe.lengths >= LONG_WIRE * pixel * distance
    alpha = np.ones(len(long))
    alpha[~long] = np.maximum(wireframe.lengths[~long] / (LONG_WIRE * pixel * distance[~long]), LEAST_ALPHA)
    alpha[~wireframe.facing(eye)] *= HIDDEN_ALPHA
    return line_marks(wireframe.ends, np.column_stack([np.tile(WIRE[:3], (len(alpha), 1)), WIRE[3] * alpha]), 1.2)


def hit_marks(seen: Seen, diagonal: float, eye: Camera | None = None) -> Marks:
    """A ball where each vertex ray hits, and the way there: Figure 1; from the `eye` on, if another one looks."""
    rays, vertices, drawn = seen.body_rays.rays, seen.body_rays.side.optics.positions, _drawn_rays(seen)
    sky = ~np.isfinite(seen.distances)
    reach = seen.distances[~sky].max(initial=0.0) or diagonal
    ends = np.where(sky[:, None], rays.origins + reach * rays.unit_directions(), seen.hits)[drawn]
    color = np.where(sky[drawn, None], SKY_RAY, RAY)
    if eye is None:
        color[:, 3] *= WITHIN_ALPHA
    parts = [line_marks(between(rays.origins[drawn], ends), color)]
    if seen.body_rays.side.refracts:
        parts.append(line_marks(between(vertices[drawn], rays.origins[drawn]), color))
    if eye is not None:
        parts.append(line_marks(between(eye.position, vertices[drawn]), EYE_RAY))
    balls = _drawn(seen)
    return joined([*parts, dot_marks(seen.hits[balls[~sky[balls]]], HIT, radius=3.0)])


def viewpoint_marks(seen: Seen, diagonal: float) -> Marks:
    """Each map's virtual viewpoint, and the rays drawn on through where they pass it: Figure 3."""
    rays, units, drawn, parts = seen.body_rays.rays, seen.body_rays.rays.unit_directions(), _drawn_rays(seen), []
    for plan in seen.plans:
        vertices = np.intersect1d(plan.vertices, drawn)
        origins, directions = rays.origins[vertices], units[vertices]
        point = viewpoint_of(plan, diagonal)
        lengths = np.full(len(vertices), -diagonal)
        if point is not None:
            lengths = PAST * np.einsum("ni,ni->n", point - origins, directions)
        parts.append(line_marks(between(origins, origins + lengths[:, None] * directions), LINE))
        if point is not None:
            parts.append(dot_marks(point, VIEWPOINT, radius=6.0))
    return joined(parts)


def viewpoint_of(plan: MapPlan, diagonal: float) -> np.ndarray | None:
    """A map's virtual viewpoint, (3,); None where it is at infinity, or so far away that it might as well be."""
    ahead, weight, middle = plan.viewpoint[:3], plan.viewpoint[3], plan.projections[0].eye
    if np.linalg.norm(ahead - weight * middle) >= FARTHEST * diagonal * abs(weight):
        return None
    return ahead / weight


def volume_marks(seen: Seen, diagonal: float) -> Marks:
    """The view volumes of a body's maps, with lines from the viewpoint to where each begins: Figure 4."""
    parts = []
    for plan in seen.plans:
        point = viewpoint_of(plan, diagonal)
        for projection in plan.projections:
            near, far = frustum(projection, plan, diagonal)
            ring = np.roll(np.arange(4), -1)
            sides = np.concatenate([between(near, near[ring]), between(far, far[ring]), between(near, far)])
            if point is not None:
                parts.append(line_marks(between(point, near), APEX))
            parts.append(line_marks(sides, VOLUME, width=1.6))
    return joined(parts)


def frustum(projection: Projection, plan: MapPlan, diagonal: float) -> tuple[np.ndarray, np.ndarray]:
    """The corners, (4, 3) each, of a view volume's beginning and of its end, cut off behind the farthest hit.

    Parameters
    ----------
    projection : Projection
        One of the plan's.
    plan : MapPlan
    diagonal : float
        How far it goes at the least where nothing is hit, metres.
    """
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    back = np.linalg.inv(projection.clip)
    begins = np.column_stack([corners, np.ones((4, 2))]) @ back.T
    ends = np.column_stack([corners, np.zeros(4), np.ones(4)]) @ back.T
    near = begins[:, :3] / begins[:, 3:]
    directions = projection.base + corners @ np.stack([projection.right, projection.up])
    # Of a parallel projection w is the same everywhere.
    forward = projection.clip[3, :3]
    forward = forward if np.linalg.norm(forward) > 1e-9 * np.linalg.norm(projection.clip[0, :3]) else projection.base
    forward = forward * np.sign(forward @ projection.base) / np.linalg.norm(forward)
    heights = near @ forward
    met = np.isfinite(plan.distances)
    reach = PAST * (plan.hits[met] @ forward - heights.min()).max(initial=0.0) if met.any() else diagonal
    end = heights.min() + max(reach, PAST * np.ptp(heights), 1e-3 * diagonal)
    # The far end of the depth range is at infinity, or before the crossing of lines that converge.
    finite = ends[:, 3] > 1e-9 * np.linalg.norm(ends[:, :3], axis=1)
    last = ends[finite, :3] / ends[finite, 3:] @ forward
    end = min(end, last[last > heights.max()].min(initial=np.inf))
    far = near + ((end - heights) / (directions @ forward))[:, None] * directions
    return near, far


def eye_marks(camera: Camera, size: tuple[int, int], depth: float) -> Marks:
    """The eye, and its image at `depth` metres before it."""
    width, height = size
    corners = np.array([[0, 0], [width, 0], [width, height], [0, height]], float)
    directions = camera.directions(corners, size)
    eye = np.asarray(camera.position, float)
    image = eye + depth * directions / (directions @ camera.axes()[2])[:, None]
    edges = np.concatenate([between(eye, image), between(image, np.roll(image, -1, axis=0))])
    return joined([line_marks(edges, EYE, 1.4), dot_marks(eye, EYE, 5.0)])


def path_marks(inspection: Inspection) -> Marks:
    """A pixel's true path, its stops as dots, in the colours of its legs."""
    points = np.array([stop.point for stop in inspection.path], float).reshape(-1, 3)
    legs = len(points) - 1
    if legs < 1:
        return NO_MARKS
    colors = np.array([LEG_COLORS[0], *[LEG_COLORS[1]] * (legs - 1), LEG_COLORS[2]])
    # What is seen directly has but one leg.
    return joined(
        [
            line_marks(between(points[:-1], points[1:]), colors[:legs], width=2.5),
            dot_marks(points, colors[: legs + 1], radius=4.5),
        ]
    )


def reflection_marks(reflections: Reflections) -> Marks:
    """The paths over all reflection points of a point, dashed and without colours where something hides it there."""
    parts = []
    for each in reflections.found:
        legs = between([reflections.eye, *each.path], [*each.path, reflections.point])
        if each.hidden:
            parts += [line_marks(_dashed(legs), HIDDEN_LEG, 1.6), dot_marks(np.array(each.path), HIDDEN_LEG, 4.0)]
        else:
            colors = np.array([LEG_COLORS[0], *[LEG_COLORS[1]] * (len(legs) - 2), LEG_COLORS[2]])
            parts += [line_marks(legs, colors, 2.5), dot_marks(np.array(each.path), LEG_COLORS[1], 5.5)]
    return joined([*parts, dot_marks(reflections.point, LEG_COLORS[2], 5.5)])


def _dashed(lines: np.ndarray) -> np.ndarray:
    """Lines, (N, 2, 3), cut into dashes with gaps between them."""
    shares = np.arange(DASHES) / DASHES
    ends = np.stack([shares, shares + 0.5 / DASHES], axis=-1)[None, ..., None]
    return (lines[:, None, :1] + ends * (lines[:, None, 1:] - lines[:, None, :1])).reshape(-1, 2, 3)


def _drawn(seen: Seen) -> np.ndarray:
    """The vertices whose hits are drawn, (N,): of those that have a map and face the eye."""
    vertices = np.unique(np.concatenate([plan.vertices for plan in seen.plans]))
    return _thinned(vertices[seen.body_rays.rays.status[vertices] == RayStatus.OK], MOST_HITS)


def _drawn_rays(seen: Seen) -> np.ndarray:
    """The vertices whose rays are drawn, (N,): of those whose hits are."""
    return _thinned(_drawn(seen), MOST_RAYS)


def _thinned(values: np.ndarray, most: int) -> np.ndarray:
    return values[:: max(1, -(-len(values) // most))]


def _eye_depth(space: PreparedScene, camera: Camera) -> float:
    """How far before the eye its image is drawn, metres."""
    specular = [mesh.positions.mean(axis=0) for mesh in space.scene.meshes if mesh.specular and len(mesh.positions)]
    away = np.linalg.norm(np.array(specular or [camera.target], float) - camera.position, axis=1)
    return EYE_DEPTH * float(away.min())


def _map_options(state: State) -> Options:
    """Of the maps that the image shows, or would by per-vertex reflection."""
    chosen: Sequence[object] = [half.method.options for half in state.halves]
    return next((each for each in chosen if isinstance(each, Options)), Options())
