"""Cube maps: pictures of the scene through six projections around a point, looked up by direction."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
import wgpu

from anamorph.gpu.buffers import SceneBuffers
from anamorph.gpu.drawing import (
    ProjectionUniform,
    ScenePipelines,
    color_pipelines,
    draw_depth,
    draw_scene,
    map_pipelines,
    projection_uniform,
)
from anamorph.gpu.targets import (
    COLOR_FORMAT,
    DEPTH_FORMAT,
    MAP_FORMATS,
    Target,
    begin_depth_pass,
    begin_pass,
    make_target,
    make_texture,
)


@dataclass(frozen=True, eq=False)
class CubeFace:
    """One face of a cube map.

    Parameters
    ----------
    projection : ProjectionUniform
    color : Target
    depth : callable
        Gives the target of depth, which may be made at the first call: only seen buffers need it.
    """

    projection: ProjectionUniform
    color: Target
    depth: Callable[[], Target]

    def draw_color(self, encoder: wgpu.GPUCommandEncoder, buffers: SceneBuffers, absent: Sequence[int]) -> None:
        """Draw the scene's colours, all meshes but the absent ones."""
        self._draw(encoder, self.color, color_pipelines(mirrored=True, sky_image=buffers.sky_image), buffers, absent)

    def draw_depth(self, encoder: wgpu.GPUCommandEncoder, buffers: SceneBuffers, absent: Sequence[int]) -> None:
        """Draw the scene's depth and object numbers."""
        self._draw(encoder, self.depth(), map_pipelines(mirrored=True), buffers, absent)

    def _draw(
        self,
        encoder: wgpu.GPUCommandEncoder,
        target: Target,
        pipelines: ScenePipelines,
        buffers: SceneBuffers,
        absent: Sequence[int],
    ) -> None:
        visible = np.ones(len(buffers.bends), bool)
        visible[list(absent)] = False
        depth_pass = begin_depth_pass(encoder, target)
        draw_depth(depth_pass, pipelines, buffers, self.projection, visible)
        depth_pass.end()
        render_pass = begin_pass(encoder, target, keep_depth=True)
        draw_scene(render_pass, pipelines, buffers, self.projection, visible=visible)
        render_pass.end()


def make_cube(size: int) -> tuple[CubeFace, ...]:
    """Six faces that share the layers of two textures, in the order +x, -x, +y, -y, +z, -z.

    They are drawn one after the other, so that one depth buffer serves them all.
    """
    square = (size, size)
    color = (make_texture(square, COLOR_FORMAT, layers=6),)
    buffer = make_texture(square, DEPTH_FORMAT).create_view()

    @cache
    def depths() -> list[Target]:
        depth = (make_texture(square, MAP_FORMATS[0], layers=6),)
        return [make_target(square, MAP_FORMATS, textures=depth, layer=layer, depth=buffer) for layer in range(6)]

    def depth_of(layer: int) -> Callable[[], Target]:
        return lambda: depths()[layer]

    return tuple(
        CubeFace(
            projection=projection_uniform(),
            color=make_target(square, (COLOR_FORMAT,), textures=color, layer=layer, depth=buffer),
            depth=depth_of(layer),
        )
        for layer in range(6)
    )
