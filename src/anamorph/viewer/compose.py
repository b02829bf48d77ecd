"""The canvas from its halves: pictures and layers side by side, with sRGB for the screen."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib import resources

import numpy as np
import wgpu

from anamorph.gpu.bindings import SAMPLER, UNIFORM, bind, layout_of, texture
from anamorph.gpu.device import get_device
from anamorph.gpu.targets import COLOR_FORMAT, make_texture

LAYER_FORMAT = "rgba8unorm"


@dataclass(frozen=True, eq=False)
class Shown:
    """What one half of the canvas shows: its picture, or in its place a layer of the colours of figures, or nothing."""

    picture: wgpu.GPUTexture | None = None
    layer: wgpu.GPUTexture | None = None


@cache
def _module() -> wgpu.GPUShaderModule:
    code = (resources.files("anamorph") / "viewer/compose.wgsl").read_text("utf-8")
    return get_device().create_shader_module(code=code)


@cache
def _layout() -> wgpu.GPUBindGroupLayout:
    return layout_of(UNIFORM, texture(), texture(), texture(), texture(), SAMPLER)


def _pipeline(fragment: str, target: dict, layout: wgpu.GPUBindGroupLayout | str) -> wgpu.GPURenderPipeline:
    device = get_device()
    return device.create_render_pipeline(
        layout=layout if isinstance(layout, str) else device.create_pipeline_layout(bind_group_layouts=[layout]),
        vertex={"module": _module(), "entry_point": "canvas_vertex", "buffers": []},
        fragment={"module": _module(), "entry_point": fragment, "targets": [target]},
        primitive={"topology": "triangle-list"},
    )


class Composer:
    """Draws the halves onto canvases of one `form`, a texture format without sRGB."""

    def __init__(self, form: str) -> None:
        device = get_device()
        self._pipeline = _pipeline("canvas_color", {"format": form}, _layout())
        usage = wgpu.BufferUsage.UNIFORM | wgpu.BufferUsage.COPY_DST
        self._placement = device.create_buffer(size=16, usage=usage)
        self._sampler = device.create_sampler(mag_filter="linear", min_filter="linear")
        self._nothing = make_texture((1, 1), COLOR_FORMAT)
        self._bound: tuple[tuple[wgpu.GPUTexture | None, ...], wgpu.GPUBindGroup] | None = None

    def place(self, halves: tuple[Shown, ...], divider: float) -> None:
        """Set what stands where; with one half it fills the canvas, without any the canvas is black."""
        first = halves[0] if halves else Shown()
        second = halves[1] if len(halves) > 1 else first
        numbers = np.zeros(4, np.uint32)
        numbers[:1].view(np.float32)[0] = divider if len(halves) > 1 else 2.0
        numbers[1:3] = first.layer is not None, second.layer is not None
        get_device().queue.write_buffer(self._placement, 0, numbers)
        textures = (first.picture, first.layer, second.picture, second.layer)
        if self._bound is None or any(old is not new for old, new in zip(self._bound[0], textures, strict=True)):
            views = [(each or self._nothing).create_view() for each in textures]
            self._bound = textures, bind(_layout(), [self._placement, *views, self._sampler])

    def draw(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """Fill the canvas."""
        if self._bound is not None:
            render_pass.set_pipeline(self._pipeline)
            render_pass.set_bind_group(0, self._bound[1])
            render_pass.draw(3)


class Average:
    """The mean of pictures of one `size` (width, height), on the device."""

    def __init__(self, size: tuple[int, int]) -> None:
        self.texture = make_texture(size, COLOR_FORMAT)
        self.count = 0
        self._view = self.texture.create_view()
        self._sources: tuple[wgpu.GPUTexture, wgpu.GPUBindGroup] | None = None

    def restart(self) -> None:
        """Forget all pictures."""
        self.count = 0

    def add(self, picture: wgpu.GPUTexture) -> None:
        """Take one more."""
        self.count += 1
        device, pipeline = get_device(), _averaging()
        if self._sources is None or self._sources[0] is not picture:
            group = device.create_bind_group(
                layout=pipeline.get_bind_group_layout(0),
                entries=[{"binding": 1, "resource": picture.create_view()}],
            )
            self._sources = picture, group
        encoder = device.create_command_encoder()
        attachment = {
            "view": self._view,
            "clear_value": (0, 0, 0, 0),
            "load_op": "clear" if self.count == 1 else "load",
            "store_op": "store",
        }
        render_pass = encoder.begin_render_pass(color_attachments=[attachment])
        render_pass.set_pipeline(pipeline)
        render_pass.set_bind_group(0, self._sources[1])
        render_pass.set_blend_constant((1.0 / self.count,) * 4)
        render_pass.draw(3)
        render_pass.end()
        device.queue.submit([encoder.finish()])


@cache
def _averaging() -> wgpu.GPURenderPipeline:
    mixed = {"operation": "add", "src_factor": "constant", "dst_factor": "one-minus-constant"}
    return _pipeline("copied", {"format": COLOR_FORMAT, "blend": {"color": mixed, "alpha": mixed}}, "auto")


class LayerTexture:
    """Figures as colours, (H, W, 4) uint8 sRGB, on the device."""

    def __init__(self) -> None:
        self.texture: wgpu.GPUTexture | None = None

    def write(self, colors: np.ndarray) -> wgpu.GPUTexture:
        """Replace them; the texture is a new one where the size is."""
        height, width = colors.shape[:2]
        device = get_device()
        if self.texture is None or self.texture.size[:2] != (width, height):
            usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST
            self.texture = device.create_texture(size=(width, height, 1), format=LAYER_FORMAT, usage=usage)
        device.queue.write_texture(
            {"texture": self.texture, "mip_level": 0, "origin": (0, 0, 0)},
            np.ascontiguousarray(colors),
            {"bytes_per_row": 4 * width, "rows_per_image": height},
            (width, height, 1),
        )
        return self.texture
