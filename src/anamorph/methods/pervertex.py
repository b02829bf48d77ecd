"""Per-vertex reflection: one pinhole image from the best virtual viewpoint, warped so that every vertex is exact.

Source: Kakimoto, Tatsukawa, Chun, Nishita, "Real-time reflection and refraction on a per-vertex basis" (2007),
sections 3.1 to 3.4; the steps keep that paper's numbers.

Deviations. The texture coordinates are projective, (s q, t q, q), which makes a flat mirror exact where plain (s, t)
bends its picture (`projective=false` is the paper's way). The near clipping plane lies along the mirror and not across
the view, and vertex rays start at it, so that the map and the rays see the same scene. The view volume holds only the
places where hit points project. The map is as fine as the picture that it fills.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import wgpu

from anamorph.errors import AnamorphError
from anamorph.frame import View
from anamorph.gpu.buffers import bind_group, storage_buffer
from anamorph.gpu.device import get_device, maximum_size
from anamorph.gpu.drawing import make_pipeline, shader_module
from anamorph.gpu.maps import Map, make_map, map_sampler
from anamorph.gpu.overlay import Overlay
from anamorph.gpu.reflectors import REFLECTOR_BUFFERS, draw_reflector
from anamorph.gpu.targets import COLOR_FORMAT, SEEN_FORMATS
from anamorph.methods.protocol import Method, Session
from anamorph.methods.session import DrawingSession, Stage
from anamorph.optics.reflection import Reflector, reflected_rays, reflector
from anamorph.optics.viewpoint import virtual_viewpoint
from anamorph.projection import MapFrame, Projection, map_frame, map_projection
from anamorph.raymesh import RayMesh, RayStatus
from anamorph.rays import Caster
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import Geometry

WIDEST = 4.0
"""Tangent of the half angle that a map may cover; vertices beyond it have no place in the map."""

FARTHEST = 1e4
"""How far away the sky is, in diagonals of the scene."""

MAXIMUM_MAP = 4096

MAXIMUM_LAYERS = 8
"""How many surfaces of a mirror's rim a ray may pass through."""

BALL_PIXELS = 18.0
"""Radius of the overlay's balls where nothing magnifies or reduces them."""


@dataclass(frozen=True)
class Options:
    """Options of `pervertex`.

    Parameters
    ----------
    antialias : int
        Samples a pixel of the picture and of the map: 1 or 4.
    mipmaps : bool
        Whether the map has mipmaps.
    resolution : float
        Texels of the map for each pixel that it fills, along one axis.
    projective : bool
        Whether texture coordinates are projective; false is the paper's plain (s, t).
    overlay : bool
        Whether to draw the mirror's wireframe and a ball at each vertex ray's hit, as the paper's Figure 1.
    """

    antialias: int = 1
    mipmaps: bool = False
    resolution: float = 1.0
    projective: bool = True
    overlay: bool = False


@dataclass(frozen=True, eq=False)
class MapPlan:
    """One reflector's map for one frame: steps 1 to 3 of the paper.

    Parameters
    ----------
    projection : Projection
        The map's view volume (3.3).
    lookups : (V, 4) float64
        (s q, t q, q, valid) of each vertex (3.4); valid is 0 where the map has no place for it.
    texels : (width, height) float
        The map's size at one texel for each pixel that it fills.
    hits : (V, 3) float64
        Where the vertex rays meet the scene (step 3.1).
    distances : (V,) float64
        How far that is from the vertex; infinite for the sky.
    """

    projection: Projection
    lookups: np.ndarray
    texels: tuple[float, float]
    hits: np.ndarray
    distances: np.ndarray


@dataclass(frozen=True, eq=False)
class World:
    """What vertex rays may hit.

    Parameters
    ----------
    caster : Caster
    face_object : (F,) uint32
        The object of each triangle that it casts at.
    corners : (8, 3) float64
        Corners of a box around the scene.
    """

    caster: Caster
    face_object: np.ndarray
    corners: np.ndarray


def world_of(geometry: Geometry) -> World:
    """The world of a scene's geometry."""
    low, high = geometry.positions.min(axis=0), geometry.positions.max(axis=0)
    corners = np.stack(np.meshgrid(*np.stack([low, high], axis=1)), axis=-1).reshape(-1, 3).astype(float)
    return World(Caster(geometry), geometry.face_object, corners)


def plan_map(
    mirror: Reflector, rays: RayMesh, eye: np.ndarray, world: World, projective: bool = True
) -> MapPlan | None:
    """Find a mirror's virtual viewpoint, view volume and texture coordinates; None where its back is all one sees.

    Parameters
    ----------
    mirror : Reflector
    rays : RayMesh
        Its reflected rays (step 1).
    eye : (3,) float64
    world : World
        What the rays may hit.
    projective : bool
    """
    facing = rays.status == RayStatus.OK
    if not facing.any():
        return None
    directions = rays.unit_directions()
    frame = _map_frame(rays.origins[facing], directions[facing])
    near_plane = _near_plane(mirror, rays.origins[facing], directions[facing], mirror.normals[facing], eye, world)
    distances = _hit_distances(rays.origins, directions, near_plane, world.caster)
    sky = FARTHEST * float(np.linalg.norm(np.ptp(world.corners, axis=0)))
    hits = rays.origins + np.minimum(distances, sky)[:, None] * directions

    # Step 3.2 and 3.3: where the lines from the viewpoint to the hits cross the projection plane.
    projected = frame.project(hits)
    ahead = projected[:, 2] > 0.0
    places = projected[:, :2] / np.where(ahead, projected[:, 2], 1.0)[:, None]
    inside = ahead & (np.abs(frame.convergence * places - frame.slope).max(axis=1) < WIDEST)
    if not (inside & facing).any():
        return None
    bounds = _bounds(places[inside & facing])
    valid = inside & (places >= bounds[0]).all(axis=1) & (places <= bounds[1]).all(axis=1)

    # Step 3.4. The row of the map counts downward.
    texcoords = (places - bounds[0]) / np.ptp(bounds, axis=0)
    texcoords[:, 1] = 1.0 - texcoords[:, 1]
    # q is the depth of a ray as long as the eye's distance. On a flat mirror that is the vertex's own depth in the
    # virtual camera; on a curved one it follows the rays between vertices about three times closer than that depth.
    weight = rays.directions @ frame.axes[2]
    if not projective or weight.min() <= 0.0:
        weight = np.ones(len(weight))
    lookups = np.column_stack([texcoords * weight[:, None], weight, valid])
    lookups[~valid, :2], lookups[~valid, 2] = 0.5, 1.0
    return MapPlan(
        projection=map_projection(frame, bounds, near_plane, world.corners),
        lookups=lookups,
        texels=_texels(rays, texcoords, valid & facing, np.ptp(bounds, axis=0)),
        hits=hits,
        distances=distances,
    )


def _map_frame(origins: np.ndarray, directions: np.ndarray) -> MapFrame:
    """Step 2: the virtual viewpoint (3.2), and an image plane across the mean direction, before the mirror (3.3)."""
    forward = directions.mean(axis=0)
    forward /= np.linalg.norm(forward)
    up = np.array([0.0, 1.0, 0.0]) if abs(forward[1]) < 0.99 else np.array([0.0, 0.0, 1.0])
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(right, forward), forward])
    middle = origins.mean(axis=0)
    radius = float(np.linalg.norm(origins - middle, axis=1).max()) or 1.0
    viewpoint = virtual_viewpoint(origins, directions)
    if forward @ (viewpoint[3] * middle - viewpoint[:3]) <= 0.0:
        # Converging rays, of a concave mirror, meet before it: see the scene from the mirror itself instead.
        viewpoint = np.append(middle, 1.0)
    return map_frame(viewpoint, middle + radius * forward, axes)


def _near_plane(
    mirror: Reflector, origins: np.ndarray, directions: np.ndarray, normals: np.ndarray, eye: np.ndarray, world: World
) -> np.ndarray:
    """The plane along the mirror just before its foremost vertex, and before what frames it, (4,).

    A rim over the mirror's border hides vertices from the eye. It must not hide the scene from them as well: no one
    sees where their rays meet the rim, but all that is interpolated towards it would be wrong.
    """
    normal = normals.mean(axis=0)
    normal /= np.linalg.norm(normal)
    diagonal = float(np.linalg.norm(np.ptp(mirror.positions, axis=0)))
    top = float((origins @ normal).max())

    caster = world.caster
    sight = caster.cast(np.broadcast_to(eye, origins.shape), origins - eye)
    hidden = (sight.triangle >= 0) & (sight.distance < 1.0 - 1e-4)
    hider = world.face_object[sight.triangle]
    start = np.full(len(origins), caster.near)
    for _ in range(MAXIMUM_LAYERS):
        hits = caster.cast(origins, directions, start)
        framed = hidden & (hits.distance < diagonal) & (world.face_object[hits.triangle] == hider)
        if not framed.any():
            break
        start = np.where(framed, hits.distance + caster.near, start)
        top = max(top, float(((origins + start[:, None] * directions) @ normal)[framed].max()))
    return np.append(normal, -(top + 1e-4 * diagonal))


def _hit_distances(
    origins: np.ndarray, directions: np.ndarray, near_plane: np.ndarray, caster: Caster
) -> np.ndarray:
    """Step 3.1: how far each ray goes to the scene beyond the near plane; infinite where it sees the sky."""
    rise = directions @ near_plane[:3]
    behind = -(origins @ near_plane[:3] + near_plane[3])
    # A ray along the plane never crosses it: start it at the mirror.
    start = np.where(rise > 1e-3, behind / np.maximum(rise, 1e-3), 0.0)
    return caster.cast(origins, directions, np.maximum(start, caster.near)).distance


def _bounds(places: np.ndarray) -> np.ndarray:
    """The rectangle around places in the image plane, (2, 2), a little larger, and never empty."""
    low, high = places.min(axis=0), places.max(axis=0)
    margin = 0.01 * np.maximum(high - low, 1e-3 * (high - low).max() or 1e-6)
    return np.stack([low - margin, high + margin])


def _texels(rays: RayMesh, texcoords: np.ndarray, valid: np.ndarray, extent: np.ndarray) -> tuple[float, float]:
    """The map's size at which nine tenths of the mirror's picture have a texel for each pixel."""
    faces = rays.faces[(valid & (rays.picture[:, 2] > 0.0))[rays.faces].all(axis=1)]
    if not len(faces):
        return (64.0, 64.0)
    pixels = _areas((rays.picture[:, :2] / rays.picture[:, 2:])[faces])
    density = pixels / np.maximum(_areas(texcoords[faces]), 1e-12)
    order = np.argsort(density)
    covered = np.cumsum(pixels[order])
    texels = density[order][np.searchsorted(covered, 0.9 * covered[-1])]
    aspect = np.clip(extent[0] / extent[1], 0.1, 10.0)
    return float(np.sqrt(texels * aspect)), float(np.sqrt(texels / aspect))


def _areas(corners: np.ndarray) -> np.ndarray:
    """Areas of plane triangles (F, 3, 2)."""
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2.0


def _ball_radii(plan: MapPlan, rays: RayMesh, camera: Camera, size: tuple[int, int]) -> np.ndarray:
    """Radii that make each hit's ball a few pixels large on the way to the eye; 0 in the sky."""
    pixel = 2.0 * np.tan(np.radians(camera.field_of_view) / 2.0) / size[1]
    way = np.linalg.norm(rays.origins - camera.position, axis=1) + plan.distances
    return np.where(np.isfinite(way), BALL_PIXELS * pixel * way, 0.0)


class _WarpedReflector:
    """One mirror: its map on the device, and the lookups of its vertices."""

    def __init__(self, stage: Stage, index: int, options: Options, layout: wgpu.GPUBindGroupLayout) -> None:
        mesh = stage.view.scene.meshes[index]
        self.index = index
        self.mirror = reflector(mesh)
        self.lookups = storage_buffer(np.zeros((len(mesh.positions), 4), np.float32), wgpu.BufferUsage.VERTEX)
        self.map: Map | None = None
        self.plan: MapPlan | None = None
        self.overlay = Overlay(self.mirror.positions, self.mirror.faces, options.antialias) if options.overlay else None
        self._options, self._layout = options, layout

    def update(self, plan: MapPlan) -> Map:
        """Take over a new plan; a map that has become too coarse or too fine is made anew."""
        self.plan = plan
        largest = min(MAXIMUM_MAP, maximum_size())
        wanted = [int(np.clip(self._options.resolution * texels, 16.0, largest)) for texels in plan.texels]
        if self.map is None or any(w > 1.3 * s or w < 0.5 * s for w, s in zip(wanted, self.map.size, strict=True)):
            self.map = make_map((wanted[0], wanted[1]), self._options.antialias, self._options.mipmaps)
            resources = [
                {"buffer": self.map.projection.buffer},
                self.map.color.textures[0].create_view(),
                map_sampler(),
                self.map.depth.textures[0].create_view(),
            ]
            self.group = bind_group(self._layout, resources)
        self.map.write(plan.projection)
        get_device().queue.write_buffer(self.lookups, 0, plan.lookups.astype(np.float32))
        return self.map


class PerVertexDrawing:
    """Draws every mirror of a scene by per-vertex reflection. See `SpecularDrawing`."""

    def __init__(self, stage: Stage, options: Options) -> None:
        self._stage, self._options = stage, options
        layout = _layout()
        self._reflectors = [_WarpedReflector(stage, index, options, layout) for index in stage.buffers.specular]
        self._world = world_of(stage.geometry)
        module = shader_module("gpu/map.wgsl", "methods/pervertex.wgsl")

        def pipeline(fragment: str, formats: tuple[str, ...], samples: int = 1) -> wgpu.GPURenderPipeline:
            return make_pipeline(
                module, "reflector_vertex", fragment, formats,
                buffers=REFLECTOR_BUFFERS, groups=(layout,), samples=samples, cull="back",
            )  # fmt: skip

        self._color = pipeline("reflector_color", (COLOR_FORMAT,), options.antialias)
        self._seen = pipeline("reflector_seen", SEEN_FORMATS)

    @property
    def replaced(self) -> tuple[int, ...]:
        """The mirrors that show their front: the others are drawn with the scene."""
        return tuple(item.index for item in self._reflectors if item.plan is not None)

    def prepare(self, encoder: wgpu.GPUCommandEncoder, camera: Camera, shift: tuple[float, float]) -> None:
        """Steps 1 to 3: plan and draw each mirror's map."""
        for item in self._reflectors:
            rays = reflected_rays(item.mirror, camera, self._stage.view.size)
            plan = plan_map(item.mirror, rays, np.asarray(camera.position), self._world, self._options.projective)
            item.plan = None
            if plan is None:
                continue
            if item.overlay is not None:
                item.overlay.place(plan.hits, _ball_radii(plan, rays, camera, self._stage.view.size))
            balls = None if item.overlay is None else item.overlay.draw_balls
            item.update(plan).draw_color(encoder, self._stage.buffers, (item.index,), balls)

    def prepare_seen(self, encoder: wgpu.GPUCommandEncoder) -> None:
        """Draw what the maps see, for the seen buffers."""
        for item in self._reflectors:
            if item.plan is not None and item.map is not None:
                item.map.draw_depth(encoder, self._stage.buffers, (item.index,))

    def draw_color(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """Step 4: the mirrors, with their maps."""
        self._draw(render_pass, self._color)
        for item in self._reflectors:
            if item.plan is not None and item.overlay is not None:
                item.overlay.draw_balls(render_pass)
                item.overlay.draw_wires(render_pass)

    def draw_seen(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """The mirrors' seen buffers."""
        self._draw(render_pass, self._seen)

    def _draw(self, render_pass: wgpu.GPURenderPassEncoder, pipeline: wgpu.GPURenderPipeline) -> None:
        render_pass.set_pipeline(pipeline)
        for item in self._reflectors:
            if item.plan is not None:
                render_pass.set_bind_group(2, item.group)
                draw_reflector(render_pass, self._stage.buffers, item.index, item.lookups)

    def rays(self) -> None:
        """There is no ray for a pixel between vertices."""
        return None


def _layout() -> wgpu.GPUBindGroupLayout:
    stage = wgpu.ShaderStage.FRAGMENT
    return get_device().create_bind_group_layout(
        entries=[
            {"binding": 0, "visibility": stage, "buffer": {"type": "uniform"}},
            {"binding": 1, "visibility": stage, "texture": {}},
            {"binding": 2, "visibility": stage, "sampler": {}},
            {"binding": 3, "visibility": stage, "texture": {"sample_type": "unfilterable-float"}},
        ]
    )


def open_session(view: View, options: Options) -> Session:
    """Start drawing `view` by per-vertex reflection."""
    if options.antialias not in (1, 4):
        raise AnamorphError(f"pervertex: antialias is {options.antialias}; give 1 or 4")
    if not 0.01 <= options.resolution <= 16.0:
        raise AnamorphError(f"pervertex: resolution is {options.resolution:g}; give a number from 0.01 to 16")
    stage = Stage(view)
    return DrawingSession(stage, PerVertexDrawing(stage, options), options.antialias)


METHOD = Method(
    name="pervertex",
    summary="one image from the best virtual viewpoint, warped so that every vertex is exact",
    source="Kakimoto et al. 2007, sections 3.1-3.4",
    options=Options,
    open=open_session,
)
