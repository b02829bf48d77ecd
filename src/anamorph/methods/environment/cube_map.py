"""Cube maps: images of the scene through six projections around a point, looked up by direction."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import wgpu

from anamorph.gpu.bindings import SAMPLER, STORAGE, bind, layout_of, texture
from anamorph.gpu.buffers import SceneBuffers, storage_buffer
from anamorph.gpu.device import of_device
from anamorph.gpu.drawing import ProjectionUniform, ScenePipelines, draw_depth, draw_scene, scene_pipelines
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


def cube_projections(center: np.ndarray, near: float) -> list[Projection]:
    """The six views of a cube map around `center`."""
    axes = np.array(FACES, float)
    return [pinhole_projection(center, forward, right, up, near) for right, up, forward in axes]


@of_device
def cube_layout() -> wgpu.GPUBindGroupLayout:
    """The layout of group 2: what cube.wgsl declares."""
    return layout_of(STORAGE, texture("cube"), SAMPLER, texture("2d-array", filterable=False))


@of_device
def stand_in() -> wgpu.GPUTexture:
    return make_texture((1, 1), MAP_FORMATS[0])


class CubeMap:
    """What is seen from a point, looked up by direction.

    Its faces are in the order +x, -x, +y, -y, +z, -z, and drawn one after the other, so that one depth buffer serves
    them all.

    Parameters
    ----------
    center : (3,) array
    size : int
        Texels along an edge.
    near : float
        What is nearer to the centre is not seen, metres.

    Attributes
    ----------
    colors : list of Target
    group : bind group
        Group 2, for colours. These need no depths, which take twice their memory.
    """

    def __init__(self, center: np.ndarray, size: int, near: float) -> None:
        square = (size, size)
        color, self._buffer = make_texture(square, COLOR_FORMAT, layers=6), make_texture(square, DEPTH_FORMAT)
        self.colors = self._targets(color)
        projections = cube_projections(center, near)
        self._projections = [ProjectionUniform() for _ in projections]
        for uniform, projection in zip(self._projections, projections, strict=True):
            uniform.write(projection, square)
        uniforms = np.concatenate([projection.uniform(square) for projection in projections])
        assert uniforms.nbytes == 6 * UNIFORM_BYTES
        self._resources = [storage_buffer(uniforms), color.create_view(dimension="cube"), map_sampler()]
        self.group = self._bound(stand_in())

    @cached_property
    def depths(self) -> list[Target]:
        """The faces' depths and object numbers, which are made now."""
        return self._targets(make_texture(self.colors[0].size, MAP_FORMATS[0], layers=6))

    @cached_property
    def seen_group(self) -> wgpu.GPUBindGroup:
        """Group 2 with depths."""
        return self._bound(self.depths[0].textures[0])

    def draw_color(
        self,
        encoder: wgpu.GPUCommandEncoder,
        buffers: SceneBuffers,
        absent: Sequence[int],
        faces: Sequence[int] = range(6),
    ) -> None:
        """Draw the colours of all meshes but the absent ones, on some faces."""
        pipelines = scene_pipelines("color", mirrored=True, sky_image=buffers.sky_image)
        for face in faces:
            self._draw(encoder, face, self.colors[face], pipelines, buffers, absent)

    def draw_depth(self, encoder: wgpu.GPUCommandEncoder, buffers: SceneBuffers, absent: Sequence[int]) -> None:
        """Draw depths and object numbers likewise, for the seen buffers."""
        for face, depth in enumerate(self.depths):
            self._draw(encoder, face, depth, scene_pipelines("depth", mirrored=True), buffers, absent)

    def _targets(self, texture: wgpu.GPUTexture) -> list[Target]:
        size, depth = texture.size[:2], self._buffer.create_view()
        return [make_target(size, (texture.format,), textures=(texture,), layer=face, depth=depth) for face in range(6)]

    def _bound(self, depth: wgpu.GPUTexture) -> wgpu.GPUBindGroup:
        return bind(cube_layout(), [*self._resources, depth.create_view(dimension="2d-array")])

    def _draw(
        self,
        encoder: wgpu.GPUCommandEncoder,
        face: int,
        target: Target,
        pipelines: ScenePipelines,
        buffers: SceneBuffers,
        absent: Sequence[int],
    ) -> None:
        projection, visible = self._projections[face], np.ones(len(buffers.specular_meshes), bool)
        visible[list(absent)] = False
        depth_pass = begin_depth_pass(encoder, target)
        draw_depth(depth_pass, pipelines, buffers, projection, visible)
        depth_pass.end()
        render_pass = begin_pass(encoder, target, keep_depth=True)
        draw_scene(render_pass, pipelines, buffers, projection, visible=visible)
        render_pass.end()
