"""Mipmaps: each level drawn from the one before it."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

import wgpu

from anamorph.gpu.bindings import bind
from anamorph.gpu.device import get_device, of_device
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import COLOR_FORMAT

Halving = tuple[wgpu.GPUBindGroup, wgpu.GPUTextureView]
"""The finer level, bound, and the coarser one."""


def halvings(texture: wgpu.GPUTexture, levels: int) -> list[Halving]:
    """The steps that fill all `levels` of a texture."""
    views = [texture.create_view(base_mip_level=level, mip_level_count=1) for level in range(levels)]
    return [(bind(_pipeline().get_bind_group_layout(2), [finer]), coarser) for finer, coarser in pairwise(views)]


def halve(encoder: wgpu.GPUCommandEncoder, steps: Iterable[Halving]) -> None:
    """Fill each coarser level from the finer one."""
    for finer, coarser in steps:
        attachment = {"view": coarser, "clear_value": (0, 0, 0, 0), "load_op": "clear", "store_op": "store"}
        render_pass = encoder.begin_render_pass(color_attachments=[attachment])
        render_pass.set_pipeline(_pipeline())
        render_pass.set_bind_group(2, finer)
        render_pass.draw(3)
        render_pass.end()


@of_device
def _pipeline() -> wgpu.GPURenderPipeline:
    module = shader_module("methods/pervertex/halve.wgsl")
    return get_device().create_render_pipeline(
        layout="auto",
        vertex={"module": module, "entry_point": "halving_vertex", "buffers": []},
        fragment={"module": module, "entry_point": "halve", "targets": [{"format": COLOR_FORMAT}]},
        primitive={"topology": "triangle-list"},
    )
