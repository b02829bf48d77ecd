"""Maps: pictures of the scene from somewhere else than the eye, read back by a later pass."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

import wgpu

from anamorph.gpu.bindings import bind
from anamorph.gpu.buffers import SceneBuffers
from anamorph.gpu.device import get_device
from anamorph.gpu.drawing import (
    ProjectionUniform,
    ScenePipelines,
    color_and_depth_pipelines,
    color_pipelines,
    draw_scene,
    map_pipelines,
    projection_uniform,
    shader_module,
)
from anamorph.gpu.targets import COLOR_FORMAT, DEPTH_FORMAT, MAP_FORMATS, Target, begin_pass, make_target, make_texture
from anamorph.projection import Projection


@dataclass(frozen=True, eq=False)
class Halving:
    """The step from one mipmap level to the next."""

    finer: wgpu.GPUBindGroup
    coarser: wgpu.GPUTextureView

    def draw(self, encoder: wgpu.GPUCommandEncoder) -> None:
        """Fill the coarser level from the finer one."""
        attachment = {
            "view": self.coarser,
            "clear_value": (0, 0, 0, 0),
            "load_op": "clear",
            "store_op": "store",
        }
        render_pass = encoder.begin_render_pass(color_attachments=[attachment])
        render_pass.set_pipeline(_halving_pipeline())
        render_pass.set_bind_group(2, self.finer)
        render_pass.draw(3)
        render_pass.end()


@cache
def _halving_pipeline() -> wgpu.GPURenderPipeline:
    module = shader_module("gpu/halve.wgsl")
    return get_device().create_render_pipeline(
        layout="auto",
        vertex={"module": module, "entry_point": "sky_vertex", "buffers": []},
        fragment={"module": module, "entry_point": "halve", "targets": [{"format": COLOR_FORMAT}]},
        primitive={"topology": "triangle-list"},
    )


def _halving(texture: wgpu.GPUTexture, level: int) -> Halving:
    finer = texture.create_view(base_mip_level=level - 1, mip_level_count=1)
    return Halving(
        finer=bind(_halving_pipeline().get_bind_group_layout(2), [finer]),
        coarser=texture.create_view(base_mip_level=level, mip_level_count=1),
    )


@dataclass(frozen=True, eq=False)
class Map:
    """A picture of the scene through a projection of its own: colour for frames, depth for their seen buffers.

    Parameters
    ----------
    size : (width, height)
    projection : ProjectionUniform
    color : Target
    depth : callable
        Gives the target of depth, which may be made at the first call: only seen buffers need it.
    both : Target, optional
        Their two textures in one target, where colour is not antialiased.
    mirrored : bool
        Whether its picture is left-handed.
    halvings : tuple of Halving
        The steps to its mipmaps.
    """

    size: tuple[int, int]
    projection: ProjectionUniform
    color: Target
    depth: Callable[[], Target]
    both: Target | None = None
    mirrored: bool = False
    halvings: tuple[Halving, ...] = ()

    def write(self, projection: Projection) -> None:
        """Set the projection for the next drawing."""
        self.projection.write(projection, self.size)

    def draw_color(
        self,
        encoder: wgpu.GPUCommandEncoder,
        buffers: SceneBuffers,
        absent: Sequence[int],
        extra: Callable[[wgpu.GPURenderPassEncoder], None] | None = None,
    ) -> None:
        """Draw the scene's colours, all meshes but the absent ones, then `extra`, and the mipmaps if it has any."""
        self._draw(encoder, self.color, color_pipelines(self.color.samples, self.mirrored), buffers, absent, extra)
        self._halve(encoder)

    def draw_color_and_depth(
        self,
        encoder: wgpu.GPUCommandEncoder,
        buffers: SceneBuffers,
        absent: Sequence[int],
        extra: Callable[[wgpu.GPURenderPassEncoder], None] | None = None,
    ) -> None:
        """Both, in one pass where neither antialiasing nor `extra` stands in the way."""
        if self.both is None or extra is not None:
            self.draw_color(encoder, buffers, absent, extra)
            self.draw_depth(encoder, buffers, absent)
            return
        self._draw(encoder, self.both, color_and_depth_pipelines(), buffers, absent)
        self._halve(encoder)

    def draw_depth(self, encoder: wgpu.GPUCommandEncoder, buffers: SceneBuffers, absent: Sequence[int]) -> None:
        """Draw the scene's depth and object numbers."""
        self._draw(encoder, self.depth(), map_pipelines(self.mirrored), buffers, absent)

    def _halve(self, encoder: wgpu.GPUCommandEncoder) -> None:
        for halving in self.halvings:
            halving.draw(encoder)

    def _draw(
        self,
        encoder: wgpu.GPUCommandEncoder,
        target: Target,
        pipelines: ScenePipelines,
        buffers: SceneBuffers,
        absent: Sequence[int],
        extra: Callable[[wgpu.GPURenderPassEncoder], None] | None = None,
    ) -> None:
        render_pass = begin_pass(encoder, target)
        draw_scene(render_pass, pipelines, buffers, self.projection, absent=absent)
        if extra is not None:
            extra(render_pass)
        render_pass.end()


def make_map(size: tuple[int, int], antialias: int = 1, mipmaps: bool = False) -> Map:
    """An empty map."""
    levels = max(size).bit_length() if mipmaps else 1
    texture = make_texture(size, COLOR_FORMAT, levels=levels)
    depth = make_target(size, MAP_FORMATS)
    return Map(
        size=size,
        projection=projection_uniform(),
        color=make_target(size, (COLOR_FORMAT,), antialias, (texture,)),
        depth=lambda: depth,
        both=make_target(size, (COLOR_FORMAT, *MAP_FORMATS), textures=(texture, *depth.textures))
        if antialias == 1
        else None,
        halvings=tuple(_halving(texture, level) for level in range(1, levels)),
    )


def make_cube(size: int) -> tuple[Map, ...]:
    """Six maps that share the layers of two textures, in the order +x, -x, +y, -y, +z, -z.

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
        Map(
            size=square,
            projection=projection_uniform(),
            color=make_target(square, (COLOR_FORMAT,), textures=color, layer=layer, depth=buffer),
            depth=depth_of(layer),
            mirrored=True,
        )
        for layer in range(6)
    )


def map_sampler() -> wgpu.GPUSampler:
    """Blends between texels and mip levels; ends at the map's border."""
    return get_device().create_sampler(mag_filter="linear", min_filter="linear", mipmap_filter="linear")
