"""Cube maps: pictures of the scene through six projections around a point, looked up by direction."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
import wgpu

from anamorph.gpu.bindings import SAMPLER, STORAGE, bind, layout_of, texture
from anamorph.gpu.buffers import SceneBuffers, storage_buffer
from anamorph.gpu.device import of_device
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
    map_sampler,
)
from anamorph.projection import UNIFORM_BYTES, Projection, pinhole_projection

FACES = (
    ((0, 0, -1), (0, 1, 0), (1, 0, 0)),
    ((0, 0, 1), (0, 1, 0), (-1, 0, 0)),
    ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
    ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    ((-1, 0, 0), (0, 1, 0), (0, 0, -1)),
)
"""Right, up and forward of each face of a cube map, as WebGPU orders and orients them."""


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


def cube_projections(center: np.ndarray, near: float) -> list[Projection]:
    """The six views of a cube map around `center`."""
    axes = np.array(FACES, float)
    return [pinhole_projection(center, forward, right, up, near) for right, up, forward in axes]


@of_device
def cube_layout() -> wgpu.GPUBindGroupLayout:
    """The layout of group 2: what cube.wgsl declares."""
    return layout_of(STORAGE, texture("cube"), SAMPLER, texture("2d-array", filterable=False))


@of_device
def _stand_in() -> wgpu.GPUTexture:
    return make_texture((1, 1), MAP_FORMATS[0])


class CubeMap:
    """What is seen from a point, looked up by direction.

    Parameters
    ----------
    center : (3,) array
    size : int
        Texels along an edge.
    near : float
        What is nearer to the centre is not seen, metres.

    Attributes
    ----------
    faces : tuple of CubeFace
    group : bind group
        Group 2, for colours. These need no depths, which take twice their memory.
    """

    def __init__(self, center: np.ndarray, size: int, near: float) -> None:
        self.faces = make_cube(size)
        projections = cube_projections(center, near)
        for face, projection in zip(self.faces, projections, strict=True):
            face.projection.write(projection, (size, size))
        uniforms = np.concatenate([projection.uniform((size, size)) for projection in projections])
        assert uniforms.nbytes == 6 * UNIFORM_BYTES
        colors = self.faces[0].color.textures[0].create_view(dimension="cube")
        self._resources = [storage_buffer(uniforms), colors, map_sampler()]
        self.group = bind(cube_layout(), [*self._resources, _stand_in().create_view(dimension="2d-array")])

    @cached_property
    def seen_group(self) -> wgpu.GPUBindGroup:
        """Group 2 with depths, which are made now."""
        depth = self.faces[0].depth().textures[0].create_view(dimension="2d-array")
        return bind(cube_layout(), [*self._resources, depth])

    def draw_color(
        self,
        encoder: wgpu.GPUCommandEncoder,
        buffers: SceneBuffers,
        absent: Sequence[int],
        faces: Sequence[int] = range(6),
    ) -> None:
        """Draw the colours of all meshes but the absent ones, on some faces."""
        for face in faces:
            self.faces[face].draw_color(encoder, buffers, absent)

    def draw_depth(self, encoder: wgpu.GPUCommandEncoder, buffers: SceneBuffers, absent: Sequence[int]) -> None:
        """Draw depths and object numbers likewise, for the seen buffers."""
        for face in self.faces:
            face.draw_depth(encoder, buffers, absent)
