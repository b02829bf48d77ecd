"""Mipmaps: each level drawn from the one before it."""

from __future__ import annotations

from dataclasses import dataclass

import wgpu

from anamorph.gpu.bindings import bind
from anamorph.gpu.device import get_device, of_device
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import COLOR_FORMAT


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


@of_device
def _halving_pipeline() -> wgpu.GPURenderPipeline:
    module = shader_module("methods/pervertex/halve.wgsl")
    return get_device().create_render_pipeline(
        layout="auto",
        vertex={"module": module, "entry_point": "halving_vertex", "buffers": []},
        fragment={"module": module, "entry_point": "halve", "targets": [{"format": COLOR_FORMAT}]},
        primitive={"topology": "triangle-list"},
    )


def _halving(texture: wgpu.GPUTexture, level: int) -> Halving:
    finer = texture.create_view(base_mip_level=level - 1, mip_level_count=1)
    return Halving(
        finer=bind(_halving_pipeline().get_bind_group_layout(2), [finer]),
        coarser=texture.create_view(base_mip_level=level, mip_level_count=1),
    )


def halvings(texture: wgpu.GPUTexture, levels: int) -> tuple[Halving, ...]:
    """The steps that fill all `levels` of a texture."""
    return tuple(_halving(texture, level) for level in range(1, levels))
