"""Per-vertex reflection: one pinhole image from the best virtual viewpoint, warped so that every vertex is exact.

Source: Kakimoto, Tatsukawa, Chun, Nishita, "Real-time reflection and refraction on a per-vertex basis" (2007),
sections 3.1 to 3.4. Steps 1 to 3 of a frame, which need no device, are in warp.py; drawing the map (step 2) and the
mirror with it (step 4) are here. Deviation: the map is as fine as the picture that it fills.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import wgpu

from anamorph.errors import AnamorphError
from anamorph.frame import View
from anamorph.gpu.bindings import SAMPLER, UNIFORM, bind, layout_of, texture
from anamorph.gpu.buffers import storage_buffer
from anamorph.gpu.device import get_device, maximum_size
from anamorph.gpu.drawing import make_pipeline, shader_module
from anamorph.gpu.maps import Map, make_map, map_sampler
from anamorph.gpu.overlay import Overlay
from anamorph.gpu.reflectors import REFLECTOR_BUFFERS, draw_reflector
from anamorph.gpu.targets import COLOR_FORMAT, SEEN_FORMATS
from anamorph.methods.protocol import Method, Session
from anamorph.methods.session import DrawingSession, Stage
from anamorph.methods.warp import MapPlan, plan_map, world_of
from anamorph.optics.reflection import reflected_rays, reflector
from anamorph.raymesh import RayMesh
from anamorph.scene.camera import Camera

MAXIMUM_MAP = 4096

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
                self.map.projection.buffer,
                self.map.color.textures[0].create_view(),
                map_sampler(),
                self.map.depth.textures[0].create_view(),
            ]
            self.group = bind(self._layout, resources)
        self.map.write(plan.projection)
        get_device().queue.write_buffer(self.lookups, 0, plan.lookups.astype(np.float32))
        return self.map


class PerVertexDrawing:
    """Draws every mirror of a scene by per-vertex reflection. See `SpecularDrawing`."""

    def __init__(self, stage: Stage, options: Options) -> None:
        self._stage, self._options = stage, options
        layout = layout_of(UNIFORM, texture(), SAMPLER, texture(filterable=False))
        self._reflectors = [_WarpedReflector(stage, index, options, layout) for index in stage.buffers.specular]
        self._world = world_of(stage.geometry)
        module = shader_module("gpu/map.wgsl", "methods/pervertex.wgsl")
        self._color = make_pipeline(
            module,
            "reflector_vertex",
            "reflector_color",
            (COLOR_FORMAT,),
            buffers=REFLECTOR_BUFFERS,
            groups=(layout,),
            samples=options.antialias,
            cull="back",
        )
        self._seen = make_pipeline(
            module,
            "reflector_vertex",
            "reflector_seen",
            SEEN_FORMATS,
            buffers=REFLECTOR_BUFFERS,
            groups=(layout,),
            cull="back",
        )

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
