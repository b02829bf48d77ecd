"""The canvas from its halves: images and false-colour images side by side, with sRGB for the screen."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
import wgpu

from anamorph.gpu.bindings import SAMPLER, bind, layout_of, texture
from anamorph.gpu.device import get_device, of_device
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import COLOR_FORMAT, PIXEL_FORMAT, make_texture


@dataclass(frozen=True, eq=False)
class Shown:
    """What one half of the canvas shows: its image, or in its place a false-colour image, or nothing."""

    image: wgpu.GPUTexture | None = None
    false_color: wgpu.GPUTexture | None = None


def _layout() -> wgpu.GPUBindGroupLayout:
    return layout_of(texture(), SAMPLER)


@contextmanager
def color_pass(target: wgpu.GPUTexture, load: str = "clear") -> Iterator[wgpu.GPURenderPassEncoder]:
    """A pass into one texture, which begins black or with what is there, and is submitted when the block ends."""
    device = get_device()
    encoder = device.create_command_encoder()
    view, black = target.create_view(), (0.0, 0.0, 0.0, 1.0)
    attachment = {"view": view, "clear_value": black, "load_op": load, "store_op": "store"}
    render_pass = encoder.begin_render_pass(color_attachments=[attachment])
    yield render_pass
    render_pass.end()
    device.queue.submit([encoder.finish()])


@of_device
def _sampler() -> wgpu.GPUSampler:
    return get_device().create_sampler(mag_filter="linear", min_filter="linear")


def _pipeline(fragment: str, target: dict[str, Any]) -> wgpu.GPURenderPipeline:
    device, module = get_device(), shader_module("viewer/compose.wgsl")
    return device.create_render_pipeline(
        layout=device.create_pipeline_layout(bind_group_layouts=[_layout()]),
        vertex={"module": module, "entry_point": "canvas_vertex", "buffers": []},
        fragment={"module": module, "entry_point": fragment, "targets": [target]},
        primitive={"topology": "triangle-list"},
    )


def _bound(shown: wgpu.GPUTexture) -> wgpu.GPUBindGroup:
    return bind(_layout(), [shown.create_view(), _sampler()])


class Composer:
    """Draws the halves side by side, onto canvases of one `form`: a texture format without sRGB."""

    def __init__(self, form: str) -> None:
        fragments = ("sharp_image", "blended_image", "false_color")
        self._pipelines = {name: _pipeline(name, {"format": form}) for name in fragments}

    def draw(
        self,
        render_pass: wgpu.GPURenderPassEncoder,
        halves: tuple[Shown, ...],
        area: tuple[int, int, int, int],
        divider: float,
    ) -> None:
        """Fill an area with one half, or with two that meet at a share of its width.

        Parameters
        ----------
        render_pass
        halves : tuple of Shown
        area : (left, top, width, height)
            In pixels of the canvas, at which the pass stays cut off.
        divider : float
        """
        left, top, width, height = area
        if width < 1 or height < 1:
            return
        render_pass.set_viewport(left, top, width, height, 0.0, 1.0)
        middle = round(width * divider) if len(halves) > 1 else width
        for half, (start, stop) in zip(halves, ((0, middle), (middle, width)), strict=False):
            shown = half.false_color or half.image
            if shown is None or stop <= start:
                continue
            sharp = shown.size[:2] == (width, height)
            name = "false_color" if half.false_color else "sharp_image" if sharp else "blended_image"
            render_pass.set_scissor_rect(left + start, top, stop - start, height)
            render_pass.set_pipeline(self._pipelines[name])
            render_pass.set_bind_group(0, _bound(shown))
            render_pass.draw(3)
        render_pass.set_scissor_rect(left, top, width, height)


class Average:
    """The mean of images of one `size` (width, height), on the device."""

    def __init__(self, size: tuple[int, int]) -> None:
        self.texture = make_texture(size, COLOR_FORMAT)
        self.count = 0

    def restart(self) -> None:
        """Forget all images."""
        self.count = 0

    def add(self, image: wgpu.GPUTexture) -> None:
        """Take one more."""
        self.count += 1
        with color_pass(self.texture, "clear" if self.count == 1 else "load") as render_pass:
            render_pass.set_pipeline(_averaging())
            render_pass.set_bind_group(0, _bound(image))
            render_pass.set_blend_constant((1.0 / self.count,) * 4)
            render_pass.draw(3)


@of_device
def _averaging() -> wgpu.GPURenderPipeline:
    mixed = {"operation": "add", "src_factor": "constant", "dst_factor": "one-minus-constant"}
    return _pipeline("copied", {"format": COLOR_FORMAT, "blend": {"color": mixed, "alpha": mixed}})


class FalseColorTexture:
    """A false-colour image, (H, W, 4) uint8 sRGB, on the device."""

    def __init__(self) -> None:
        self.texture: wgpu.GPUTexture | None = None

    def write(self, colors: np.ndarray) -> wgpu.GPUTexture:
        """Replace them; the texture is a new one where the size is."""
        height, width = colors.shape[:2]
        device = get_device()
        if self.texture is None or self.texture.size[:2] != (width, height):
            usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST
            self.texture = device.create_texture(size=(width, height, 1), format=PIXEL_FORMAT, usage=usage)
        device.queue.write_texture(
            {"texture": self.texture, "mip_level": 0, "origin": (0, 0, 0)},
            np.ascontiguousarray(colors),
            {"bytes_per_row": 4 * width, "rows_per_image": height},
            (width, height, 1),
        )
        return self.texture
