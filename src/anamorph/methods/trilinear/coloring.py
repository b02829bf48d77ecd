"""Colouring what the rays of one image see: surfaces, the sky, and with several samples a pixel the edges between.

Each of these is a pass, and leaves what is not its own by its depth, before its shader runs: software would run all
sides of a branch for every pixel.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import wgpu

from anamorph.gpu.buffers import SceneBuffers
from anamorph.gpu.drawing import ProjectionUniform, bind_scene, make_pipeline
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import COLOR_FORMAT, DEPTH_FORMAT, SEEN_FORMATS, Target, begin_pass, make_target, make_texture
from anamorph.methods.trilinear.visibility import Visibility, bind_views, data_layout, views_layout


class Coloring:
    """Colours one `Visibility`.

    Parameters
    ----------
    buffers : SceneBuffers
    visibility : Visibility
    colors : Target
        Where to; its depth is not used.
    write_mask : int
        The colours that are written.
    before : Coloring, optional
        Of the rays that are sent on.
    goes_on : bool
        Whether rays are sent on from specular fronts.
    """

    def __init__(
        self,
        buffers: SceneBuffers,
        visibility: Visibility,
        colors: Target,
        write_mask: int = wgpu.ColorWrite.ALL,
        before: Coloring | None = None,
        goes_on: bool = False,
    ) -> None:
        self._buffers, self._visibility = buffers, visibility
        kind, size = visibility.kind, colors.size
        depth = visibility.views.owners.depth
        self._colors = replace(colors, depth=depth)
        self._throughput = make_target(size, (COLOR_FORMAT,), depth=depth) if goes_on else None
        given = None if before is None or before._throughput is None else before._throughput.textures[0].create_view()
        self._group = bind_views(visibility.views, visibility.fine, given)
        module = shader_module("methods/trilinear/edges.wgsl")
        constants = {
            "MEETS_SPECULAR": int(kind.meets_specular),
            "GLASS": int(kind.glass),
            "FOLLOWS": int(before is not None),
            "STRAIGHT": int(kind.straight),
        }
        vertex = "bare_ray_vertex" if kind.bare else "surface_ray_vertex"
        layouts = data_layout(), views_layout()

        def pipeline(fragment: str, formats: tuple[str, ...], level: bool, **settings: Any) -> wgpu.GPURenderPipeline:
            settings = {"vertex": vertex, "cull": "none" if kind.bare else "back", **settings}
            return make_pipeline(
                module, fragment=fragment, formats=formats, buffers=(), groups=layouts,
                constants={**constants, "LEVEL": int(level)}, **settings,
            )  # fmt: skip

        def shaded(fragment: str, depth: str, mask: int = write_mask) -> wgpu.GPURenderPipeline:
            settings = {"depth_compare": depth, "depth_write": False, "write_mask": mask}
            return pipeline(fragment, (COLOR_FORMAT,), True, **settings)

        self._shaded = shaded("surface_color", "less"), shaded("sky_seen_color", "equal")
        self._thrown = shaded("throughput_color", "less", wgpu.ColorWrite.ALL) if goes_on else None
        self._seen = pipeline("end_seen", SEEN_FORMATS, False)
        if before is not None:
            # What these rays see stands where the first specular surface is.
            self._seen = pipeline("end_seen", SEEN_FORMATS, True, depth_compare="always", depth_write=False)
        self._edges: Target | None = None
        if visibility.fine is not None:
            self._edges = replace(colors, depth=make_texture(size, DEPTH_FORMAT).create_view())
            self._mixed = shaded("edge_color_mixed", "less")
            marks = {"vertex": "sky_vertex", "cull": "none", "write_mask": 0}
            self._marked = pipeline("edge_mark", (COLOR_FORMAT,), True, **marks)

    def draw(self, encoder: wgpu.GPUCommandEncoder, projection: ProjectionUniform, clear: bool) -> None:
        """Colour the image, over what is there or anew."""
        if self._edges is not None:
            self._pass(encoder, projection, self._edges, [self._marked], 3, keep_color=True)
        self._pass(encoder, projection, self._colors, list(self._shaded), clear=clear, keep_depth=True)
        if self._edges is not None:
            self._pass(encoder, projection, self._edges, [self._mixed], clear=False)
        if self._throughput is not None and self._thrown is not None:
            self._pass(encoder, projection, self._throughput, [self._thrown], keep_depth=True)

    def draw_seen(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """The seen buffers."""
        self._draw(render_pass, self._seen, 3 * self._visibility.count)

    def _pass(
        self,
        encoder: wgpu.GPUCommandEncoder,
        projection: ProjectionUniform,
        target: Target,
        pipelines: list[wgpu.GPURenderPipeline],
        corners: int | None = None,
        clear: bool = True,
        keep_depth: bool = False,
        keep_color: bool = False,
    ) -> None:
        render_pass = begin_pass(encoder, target, clear, keep_depth, keep_color)
        bind_scene(render_pass, self._buffers, projection)
        for pipeline in pipelines:
            self._draw(render_pass, pipeline, 3 * self._visibility.count if corners is None else corners)
        render_pass.end()

    def _draw(self, render_pass: wgpu.GPURenderPassEncoder, pipeline: wgpu.GPURenderPipeline, corners: int) -> None:
        render_pass.set_pipeline(pipeline)
        self._visibility.bind(render_pass)
        render_pass.set_bind_group(3, self._group)
        render_pass.draw(corners)
