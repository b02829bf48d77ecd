"""Per-vertex reflection: one pinhole image from the best virtual viewpoint, warped so that every vertex is exact.

Source: Kakimoto, Tatsukawa, Chun, Nishita, "Real-time reflection and refraction on a per-vertex basis" (2007),
sections 3.1 to 3.4. Steps 1 to 3 of a frame, which need no device, are in warp.py; drawing the map (step 2) and the
mirror with it (step 4) are here. Deviation: the map is as fine as the picture that it fills.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import wgpu

from anamorph.errors import AnamorphError
from anamorph.frame import View
from anamorph.gpu.bindings import SAMPLER, STORAGE, UNIFORM, bind, layout_of, texture
from anamorph.gpu.buffers import storage_buffer
from anamorph.gpu.device import get_device, maximum_size
from anamorph.gpu.drawing import bind_scene, make_pipeline, shader_module, submit
from anamorph.gpu.maps import Map, make_map, map_sampler
from anamorph.gpu.overlay import Overlay
from anamorph.gpu.targets import COLOR_FORMAT, SEEN_FORMATS, Target, begin_pass, make_texture, read_texture
from anamorph.methods.mend import Mender, doubtful_tiles
from anamorph.methods.protocol import Method, Session
from anamorph.methods.session import DrawingSession, Stage
from anamorph.methods.warp import MapPlan, plan_map, world_of
from anamorph.optics.reflection import reflected_rays, reflector
from anamorph.raymesh import RayMesh
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import Geometry

MAXIMUM_MAP = 4096

MAXIMUM_REFINEMENTS = 16
REFINEMENTS_BEFORE_TRACING = 3

ERROR_FORMAT = "r32float"

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
    refine : int
        Steps that each fragment takes through the map towards what its own ray meets; 0 is the paper.
    tolerance : float
        Pixels: where what a fragment shows may be further than this from what it should, its tile of the picture is
        traced. 0 traces nothing. At least three refinements go before.
    overlay : bool
        Whether to draw the mirror's wireframe and a ball at each vertex ray's hit, as the paper's Figure 1.
    """

    antialias: int = 1
    mipmaps: bool = False
    resolution: float = 1.0
    projective: bool = True
    refine: int = 0
    tolerance: float = 0.0
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
        self.lookups = storage_buffer(np.zeros((len(mesh.positions), 4), np.float32))
        description = [stage.buffers.first_vertex[index], mesh.surface is not None]
        self._mesh = [
            get_device().create_buffer_with_data(data=np.array(description, np.uint32), usage=wgpu.BufferUsage.UNIFORM),
            stage.buffers.vertices,
            stage.buffers.indices,
            self.lookups,
        ]
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
                self.map.depth().textures[0].create_view(),
                *self._mesh,
            ]
            self.group = bind(self._layout, resources)
        self.map.write(plan.projection)
        get_device().queue.write_buffer(self.lookups, 0, plan.lookups.astype(np.float32))
        return self.map


class PerVertexDrawing:
    """Draws every mirror of a scene by per-vertex reflection. See `SpecularDrawing`."""

    def __init__(self, stage: Stage, options: Options) -> None:
        self._stage, self._options = stage, options
        layout = layout_of(
            UNIFORM, texture(), SAMPLER, texture(filterable=False), UNIFORM, STORAGE, STORAGE, STORAGE,
            stages=wgpu.ShaderStage.VERTEX | wgpu.ShaderStage.FRAGMENT,
        )  # fmt: skip
        self._reflectors = [_WarpedReflector(stage, index, options, layout) for index in stage.buffers.specular]
        self._world = world_of(stage.geometry)
        module = shader_module("gpu/vertices.wgsl", "gpu/map.wgsl", "methods/pervertex.wgsl")

        def pipeline(
            fragment: str, formats: tuple[str, ...], samples: int = 1, depth_compare: str = "greater"
        ) -> wgpu.GPURenderPipeline:
            return make_pipeline(
                module,
                "reflector_vertex",
                fragment,
                formats,
                buffers=(),
                groups=(layout,),
                samples=samples,
                cull="back",
                depth_compare=depth_compare,
                constants={"REFINEMENTS": options.refine},
            )

        self._mender: Mender | None = None
        if options.tolerance > 0.0:
            self._mender = Mender(stage, self._world.caster)
            self._errors = make_texture(stage.view.size, ERROR_FORMAT)
            self._errors_view = self._errors.create_view()
            self._error = pipeline("reflector_error", (ERROR_FORMAT,), depth_compare="equal")
        self._color = pipeline("reflector_color", (COLOR_FORMAT,), options.antialias)
        self._seen = pipeline("reflector_seen", SEEN_FORMATS)

    @property
    def replaced(self) -> tuple[int, ...]:
        """The mirrors that show their front: the others are drawn with the scene."""
        return tuple(item.index for item in self._reflectors if item.plan is not None)

    def deformed(self, geometry: Geometry) -> None:
        """Have the vertex rays meet what has moved."""
        self._world.caster.moved(geometry.positions)

    def prepare(self, encoder: wgpu.GPUCommandEncoder, camera: Camera, shift: tuple[float, float]) -> None:
        """Steps 1 to 3: plan and draw each mirror's map."""
        for item in self._reflectors:
            rays = reflected_rays(item.mirror, camera, self._stage.view.size)
            plan = plan_map(
                item.mirror,
                rays,
                np.asarray(camera.position),
                self._world,
                self._options.projective,
                strict=self._mender is not None,
            )
            item.plan = None
            if plan is None:
                continue
            if item.overlay is not None:
                item.overlay.place(plan.hits, _ball_radii(plan, rays, camera, self._stage.view.size))
            balls = None if item.overlay is None else item.overlay.draw_balls
            target = item.update(plan)
            looks = self._options.refine > 0 or self._mender is not None
            draw = target.draw_color_and_depth if looks else target.draw_color
            draw(encoder, self._stage.buffers, (item.index,), balls)

    def complete(self, target: Target, camera: Camera, shift: tuple[float, float]) -> None:
        """Have those tiles traced in which some fragment may be wrong by more than the tolerance."""
        if self._mender is None:
            return
        encoder = get_device().create_command_encoder()
        errors = replace(target, textures=(self._errors,), attachments=(self._errors_view,))
        render_pass = begin_pass(encoder, errors, keep_depth=True)
        bind_scene(render_pass, self._stage.buffers, self._stage.projection)
        self._draw(render_pass, self._error)
        render_pass.end()
        submit(encoder)
        self._mender.trace(doubtful_tiles(read_texture(self._errors), self._options.tolerance), camera, shift)
        self._mender.draw_over(target, self._stage.projection)

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
        if self._mender is not None:
            self._mender.draw_seen(render_pass)

    def _draw(self, render_pass: wgpu.GPURenderPassEncoder, pipeline: wgpu.GPURenderPipeline) -> None:
        render_pass.set_pipeline(pipeline)
        for item in self._reflectors:
            if item.plan is not None:
                render_pass.set_bind_group(2, item.group)
                first, last = (int(face) for face in self._stage.buffers.first_face[item.index : item.index + 2])
                render_pass.draw(3 * (last - first), 1, 3 * first)

    def rays(self) -> None:
        """There is no ray for a pixel between vertices."""
        return None


def open_session(view: View, options: Options) -> Session:
    """Start drawing `view` by per-vertex reflection."""
    if options.antialias not in (1, 4):
        raise AnamorphError(f"pervertex: antialias is {options.antialias}; give 1 or 4")
    if not 0.01 <= options.resolution <= 16.0:
        raise AnamorphError(f"pervertex: resolution is {options.resolution:g}; give a number from 0.01 to 16")
    if not 0 <= options.refine <= MAXIMUM_REFINEMENTS:
        raise AnamorphError(f"pervertex: refine is {options.refine}; give a number from 0 to {MAXIMUM_REFINEMENTS}")
    if not 0.0 <= options.tolerance < float("inf"):
        raise AnamorphError(f"pervertex: tolerance is {options.tolerance:g}; give a number of pixels from 0")
    if options.tolerance > 0.0:
        if options.antialias > 1:
            raise AnamorphError("pervertex: tolerance needs antialias=1; give more samples for a smooth picture")
        options = replace(options, refine=max(options.refine, REFINEMENTS_BEFORE_TRACING))
    stage = Stage(view)
    return DrawingSession(stage, PerVertexDrawing(stage, options), options.antialias)


METHOD = Method(
    name="pervertex",
    summary="one image from the best virtual viewpoint, warped so that every vertex is exact",
    source="Kakimoto et al. 2007, sections 3.1-3.4",
    options=Options,
    open=open_session,
)
