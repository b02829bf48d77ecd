"""Per-vertex reflection on maps of surfaces: each pixel's own ray finds in a map which triangle it meets.

Source: Kakimoto et al. 2007 for the virtual viewpoint and its map. Deviation: the map holds triangles and not colours,
and a pixel does not look up an interpolated place but follows its ray, bent at the exact surface.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping
from functools import cache
from typing import Any

import numpy as np
import wgpu

from anamorph.gpu.bindings import STORAGE, bind, depths, layout_of, numbers, texture
from anamorph.gpu.buffers import grown_buffer
from anamorph.gpu.device import get_device, of_device
from anamorph.gpu.drawing import bind_scene, make_pipeline
from anamorph.gpu.own_ray import SPECTRUM, bind_exact, exact_layout
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import Target
from anamorph.gpu.visibility import TEXEL_FORMAT
from anamorph.methods.finding import FindingDrawing
from anamorph.methods.pervertex.looking import PatchKind, Search, Searcher
from anamorph.methods.pervertex.options import Options
from anamorph.methods.pervertex.surface_maps import SurfaceMaps
from anamorph.methods.pervertex.surroundings import surroundings_of
from anamorph.methods.stage import Stage
from anamorph.methods.tracing.doubt import DoubtTracer
from anamorph.methods.tracing.paths import specular_rectangle
from anamorph.optics.exact_sides import exact_sides
from anamorph.optics.ray_meshes import bodies_of, rays_of
from anamorph.projection import UNIFORM_BYTES
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import Geometry

MOST_BOUNCES = 8
"""Of traced paths, as the reference has them."""

MOST_VIEWS = 2
"""Maps of one patch."""

STRIDE = -(-MOST_VIEWS * UNIFORM_BYTES // 256) * 256
"""Bytes from one patch's maps to the next: uniforms begin at multiples of 256."""


@of_device
def finding_layout() -> wgpu.GPUBindGroupLayout:
    """The layout of group 2: what search.wgsl declares."""
    maps = {"buffer": {"type": "uniform", "has_dynamic_offset": True}}
    return layout_of(
        maps, numbers(), texture(filterable=False), *4 * [STORAGE], depths(),
        stages=wgpu.ShaderStage.VERTEX | wgpu.ShaderStage.FRAGMENT,
    )  # fmt: skip


class SurfaceDrawing(FindingDrawing):
    """Finds what each pixel of a mirror or lens sees, in maps of surfaces."""

    def __init__(self, stage: Stage, options: Options) -> None:
        self._bodies = bodies_of(stage.view.scene, stage.geometry)
        disperses = any(side.disperses for body in self._bodies for side in body.sides)
        super().__init__(stage, 3 if disperses else 1, options.antialias)
        sides = exact_sides(stage.view.scene, stage.geometry, self._bodies)
        self._exact = bind_exact(sides)
        self._surroundings = surroundings_of(stage.geometry, self._bodies)
        self._searcher = Searcher(stage.geometry, stage.buffers.specular_meshes, sides.kinds, options)
        self._search = Search()
        self._maps = SurfaceMaps(stage.buffers, stage.geometry)
        self._doubt: DoubtTracer | None = None
        if options.tolerance > 0.0:
            self._doubt = DoubtTracer(stage, self.visibility, self._surroundings.caster, MOST_BOUNCES)
        self._held: list[wgpu.GPUBuffer | None] = [None, None]
        self._uniform: wgpu.GPUBuffer | None = None
        self._group: wgpu.GPUBindGroup | None = None
        module = shader_module("methods/pervertex/found.wgsl")

        @cache
        def pipeline(kind: PatchKind, line: int) -> wgpu.GPURenderPipeline:
            constants: dict[str, float] = {
                "TRACED": int(options.tolerance > 0.0),
                "LENS": int(kind.refracts),
                "SIDES": kind.sides,
                "SURFACE": kind.surface,
                "FAR_SURFACE": kind.far_surface,
                "LINE": SPECTRUM[line],
            }
            return make_pipeline(
                module,
                "body_vertex",
                "refractor_found" if kind.refracts else "reflector_found",
                (TEXEL_FORMAT, TEXEL_FORMAT),
                buffers=(),
                groups=(finding_layout(), exact_layout()),
                cull="back",
                depth_compare="greater-equal",
                constants=constants,
            )

        self._pipeline = pipeline

    def deformed(self, geometry: Geometry) -> None:
        """Have the next maps see the moved scene."""
        self._surroundings.caster.moved(geometry.positions)
        self._surroundings = self._surroundings.moved(geometry)
        self._searcher.moved(geometry)
        self._maps.moved(geometry)
        if self._doubt is not None:
            self._doubt.moved(geometry)
        self.looked = None

    @property
    def replaced(self) -> tuple[int, ...]:
        """All mirrors and lenses."""
        return tuple(mesh for body in self._bodies for mesh in body.meshes)

    def prepare(self, encoder: wgpu.GPUCommandEncoder, camera: Camera, shift: tuple[float, float]) -> None:
        """Plan the maps and draw them; where nothing has moved, the last ones serve."""
        moved = self.looked is None or self.looked[0] != camera
        self.look(camera, shift)
        size = self.stage.view.size
        lines = len(self.visibility.textures)
        self.visibility.show(specular_rectangle(self.stage.view.scene, camera, size), lines)
        if not moved:
            return
        eye = camera.eye(size)
        self._search = self._searcher.search([rays_of(body, eye) for body in self._bodies], size, self._surroundings)
        if self._search.draws:
            self._hand_over(self._search)
        if self._search.views:
            self._maps.draw(encoder)

    def _hand_over(self, search: Search) -> None:
        made = self._maps.place(search.views)
        contents = [np.concatenate(search.looking), np.concatenate([*search.unseen, np.zeros(1, np.uint32)])]
        held = [grown_buffer(old, data.nbytes) for old, data in zip(self._held, contents, strict=True)]
        maps = np.zeros((len(search.patches), STRIDE // 4), np.float32)
        for row, numbered in zip(maps, search.patches, strict=True):
            words = np.concatenate(
                [np.zeros(0, np.float32), *(self._maps.rectangles.projections[view] for view in numbered)]
            )
            row[: len(words)] = words
        fits = self._uniform is not None and self._uniform.size >= maps.nbytes
        if not fits:
            usage = wgpu.BufferUsage.UNIFORM | wgpu.BufferUsage.COPY_DST
            self._uniform = get_device().create_buffer(size=2 * maps.nbytes, usage=usage)
        if made or not fits or held != self._held:
            self._held = list(held)
            resources = [
                {"buffer": self._uniform, "offset": 0, "size": MOST_VIEWS * UNIFORM_BYTES},
                self._maps.surfaces.create_view(),
                self._maps.nearest.create_view(),
                self.stage.buffers.vertices,
                self.stage.buffers.indices,
                *held,
                self._maps.silhouettes.create_view(),
            ]
            self._group = bind(finding_layout(), resources)
        for buffer, data in zip([self._uniform, *held], [maps, *contents], strict=True):
            get_device().queue.write_buffer(buffer, 0, data)

    def find(
        self, encoder: wgpu.GPUCommandEncoder, target: Target, camera: Camera, shift: tuple[float, float]
    ) -> Generator[None, None, wgpu.GPUCommandEncoder] | None:
        """Find what each pixel sees; under a tolerance, what is doubtful is traced."""
        depth = self.depth_of(encoder, target)
        for line in range(len(self.visibility.textures)):
            render_pass = self.visibility.begin(encoder, depth, line)
            bind_scene(render_pass, self.stage.buffers, self.projection)
            render_pass.set_bind_group(3, self._exact)
            for draw in self._search.draws:
                if line and not draw.kind.disperses:
                    continue
                render_pass.set_pipeline(self._pipeline(draw.kind, line))
                render_pass.set_bind_group(2, self._group, [STRIDE * draw.number], 0, 1)
                render_pass.draw(3 * draw.count, 1, 3 * draw.first)
            render_pass.end()
        if self._doubt is None or not self._search.draws:
            return None
        return self._doubt.tracing(encoder, depth, self.projection, camera, shift)

    def figures(self) -> dict[str, float]:
        """How many maps the last frame took, their texels, and how many samples were traced."""
        traced = {} if self._doubt is None else {"traced": float(self._doubt.traced)}
        return {"maps": float(len(self._search.views)), "map_texels": float(self._maps.rectangles.texels), **traced}

    def diagnostics(self) -> Mapping[str, Any]:
        """The maps of surfaces, and what looks into them."""
        return {"maps": self._maps, "search": self._search}
