"""Textures that passes draw into, and reading them back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import wgpu

from anamorph.gpu.device import get_device

COLOR_FORMAT = "rgba16float"
PIXEL_FORMAT = "rgba8unorm"
DEPTH_FORMAT = "depth32float"
SEEN_FORMATS = ("rgba32float", "r32uint", "r32float")
MAP_FORMATS = ("rgba32float",)

_USAGE = (
    wgpu.TextureUsage.RENDER_ATTACHMENT
    | wgpu.TextureUsage.TEXTURE_BINDING
    | wgpu.TextureUsage.COPY_SRC
    | wgpu.TextureUsage.COPY_DST
)


@dataclass(frozen=True, eq=False)
class Target:
    """An image being drawn: its textures, of which depth, and with antialiasing also colour, is multisampled.

    Parameters
    ----------
    size : (width, height)
    textures : tuple of textures
        What a pass leaves behind, one for each of its fragment outputs.
    attachments : tuple of texture views
        What a pass draws into: the textures themselves, or their multisampled counterparts.
    resolved : tuple of texture views or None
        Where the samples of each attachment are averaged to, with more than one of them.
    depth : texture view
    samples : int
        Samples a pixel: 1 or 4.
    """

    size: tuple[int, int]
    textures: tuple[wgpu.GPUTexture, ...]
    attachments: tuple[wgpu.GPUTextureView, ...]
    resolved: tuple[wgpu.GPUTextureView | None, ...]
    depth: wgpu.GPUTextureView
    samples: int


def make_texture(
    size: tuple[int, int], form: str, samples: int = 1, layers: int = 1, levels: int = 1
) -> wgpu.GPUTexture:
    """A texture that can be drawn into, bound, and (with one sample) copied from."""
    usage = _USAGE if samples == 1 else wgpu.TextureUsage.RENDER_ATTACHMENT
    return get_device().create_texture(
        size=(*size, layers), format=form, usage=usage, sample_count=samples, mip_level_count=levels
    )


def make_target(
    size: tuple[int, int],
    formats: tuple[str, ...],
    samples: int = 1,
    textures: tuple[wgpu.GPUTexture, ...] | None = None,
    layer: int = 0,
    depth: wgpu.GPUTextureView | None = None,
) -> Target:
    """A target of `size` with its own textures, or with one layer of the given ones, and with its own depth or not."""
    own = tuple(make_texture(size, form) for form in formats) if textures is None else textures
    views = tuple(_layer_view(texture, layer) for texture in own)
    if samples == 1:
        attachments, resolved = views, (None,) * len(views)
    else:
        attachments, resolved = tuple(make_texture(size, form, samples).create_view() for form in formats), views
    depth = make_texture(size, DEPTH_FORMAT, samples).create_view() if depth is None else depth
    return Target(size, own, attachments, resolved, depth, samples)


def _layer_view(texture: wgpu.GPUTexture, layer: int) -> wgpu.GPUTextureView:
    return texture.create_view(dimension="2d", base_array_layer=layer, array_layer_count=1, mip_level_count=1)


def begin_pass(
    encoder: wgpu.GPUCommandEncoder,
    target: Target,
    clear: bool = True,
    keep_depth: bool = False,
    keep_color: bool = False,
) -> wgpu.GPURenderPassEncoder:
    """Begin drawing into `target`, cleared to nothing or kept; its depth or its colours may be kept in any case."""
    load = "clear" if clear and not keep_color else "load"
    depth_load = "clear" if clear and not keep_depth else "load"
    colors = [
        {"view": view, "resolve_target": resolved, "clear_value": (0, 0, 0, 0), "load_op": load, "store_op": "store"}
        for view, resolved in zip(target.attachments, target.resolved, strict=True)
    ]
    return encoder.begin_render_pass(color_attachments=colors, depth_stencil_attachment=_depth(target, depth_load))


def begin_depth_pass(encoder: wgpu.GPUCommandEncoder, target: Target) -> wgpu.GPURenderPassEncoder:
    """Begin drawing the depth of `target` alone, cleared: what touches no colours is twice as fast in software."""
    return encoder.begin_render_pass(color_attachments=[], depth_stencil_attachment=_depth(target, "clear"))


def _depth(target: Target, load: str) -> dict[str, Any]:
    return {"view": target.depth, "depth_clear_value": 0.0, "depth_load_op": load, "depth_store_op": "store"}


def map_sampler() -> wgpu.GPUSampler:
    """Blends between texels and mip levels of a map; ends at the texture's border."""
    return get_device().create_sampler(mag_filter="linear", min_filter="linear", mipmap_filter="linear")


def read_texture(texture: wgpu.GPUTexture) -> np.ndarray:
    """The texture's finest level as (H, W) or (H, W, channels)."""
    kinds = {
        "rgba16float": (np.float16, 4),
        "rgba8unorm": (np.uint8, 4),
        "rgba32float": (np.float32, 4),
        "rgba32uint": (np.uint32, 4),
        "rg32uint": (np.uint32, 2),
        "r32uint": (np.uint32, 1),
        "r32float": (np.float32, 1),
    }
    dtype, channels = kinds[texture.format]
    width, height, _ = texture.size
    bytes_per_row = width * channels * np.dtype(dtype).itemsize
    data = get_device().queue.read_texture(
        {"texture": texture, "mip_level": 0, "origin": (0, 0, 0)},
        {"bytes_per_row": bytes_per_row, "rows_per_image": height},
        (width, height, 1),
    )
    shape = (height, width) if channels == 1 else (height, width, channels)
    return np.frombuffer(data, dtype).reshape(shape)
