"""The ends of the samples' paths, written into the visibility buffer from what a `Visibility` holds.

With straight edges, a sample's ray does not meet the scene triangle where it is shown: what lies between projected
corners is interpolated. The ray is then the one from the sample's own origin to the interpolated point, so that it is
that point which gets its colour.
"""

from __future__ import annotations

from typing import Any

import wgpu

from anamorph.gpu.drawing import ProjectionUniform, make_pipeline
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import COLOR_FORMAT, begin_pass, make_target
from anamorph.gpu.visibility import TEXEL_FORMAT, VisibilityBuffer
from anamorph.methods.trilinear.visibility import Visibility, bind_views, data_layout, views_layout


class PathEnds:
    """The path ends of one `Visibility`.

    Parameters
    ----------
    visibility : Visibility
    depths : texture
        Of the mirrors and lenses that samples are on.
    before : PathEnds, optional
        Of the rays that are sent on; these take their place.
    goes_on : bool
        Whether rays are sent on from specular fronts.
    """

    def __init__(
        self,
        visibility: Visibility,
        depths: wgpu.GPUTexture,
        before: PathEnds | None = None,
        goes_on: bool = False,
    ) -> None:
        self._visibility, self._follows = visibility, before is not None
        kind = visibility.kind
        self._throughput = make_target(visibility.size, (COLOR_FORMAT,), depth=visibility.depth) if goes_on else None
        given = None if before is None or before._throughput is None else before._throughput.textures[0]
        self._group = bind_views([visibility.owners, visibility.seen, visibility.weights, given, depths])
        constants: dict[str, float] = {
            "GLASS": int(kind.glass),
            "FOLLOWS": int(self._follows),
            "STRAIGHT": int(kind.straight),
            "HIDDEN": int(kind.hidden),
        }

        def pipelines(fragment: str, *formats: str, **settings: Any) -> list[wgpu.GPURenderPipeline]:
            return [
                make_pipeline(
                    shader_module("methods/trilinear/path_ends.wgsl"), "sample_vertex", fragment, formats,
                    buffers=(), groups=(data_layout(), views_layout()), depth_write=False,
                    constants=constants | {"IN_GLASS": in_glass}, **settings,
                )
                for in_glass in range(1 + kind.glass)
            ]  # fmt: skip

        nearest = "greater-equal" if kind.hidden else "always"
        self._ended = pipelines("path_ended", TEXEL_FORMAT, TEXEL_FORMAT, depth_compare=nearest)
        self._thrown = pipelines("throughput_there", COLOR_FORMAT, depth_compare="always")[:1] if goes_on else []

    def draw(
        self,
        encoder: wgpu.GPUCommandEncoder,
        projection: ProjectionUniform,
        found: VisibilityBuffer,
        depth: wgpu.GPUTextureView | None,
        line: int,
    ) -> None:
        """Write a line of the buffer; where there is a `depth`, only what is not behind it."""
        depth = self._visibility.depth if depth is None else depth
        render_pass = found.begin(encoder, depth, line, keep=self._follows)
        self._draw(render_pass, projection, found, self._ended)
        if self._throughput is not None:
            render_pass = begin_pass(encoder, self._throughput, keep_depth=True)
            self._draw(render_pass, projection, found, self._thrown)

    def _draw(
        self,
        render_pass: wgpu.GPURenderPassEncoder,
        projection: ProjectionUniform,
        found: VisibilityBuffer,
        pipelines: list[wgpu.GPURenderPipeline],
    ) -> None:
        assert found.rectangle is not None
        x0, y0, x1, y1 = (found.side * end for end in found.rectangle)
        self._visibility.bind(render_pass, projection, self._group)
        render_pass.set_scissor_rect(x0, y0, x1 - x0, y1 - y0)
        for pipeline in pipelines:
            render_pass.set_pipeline(pipeline)
            render_pass.draw(3)
        render_pass.end()
