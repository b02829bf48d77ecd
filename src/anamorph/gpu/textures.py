"""The diffuse textures of a scene as one texture array with mipmaps, and the sky's image."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import wgpu
from PIL import Image

from anamorph.base.errors import AnamorphError
from anamorph.base.srgb import decode_srgb, encode_srgb
from anamorph.gpu.device import get_device, maximum_size, of_device_last
from anamorph.scene.model import LinearImage, Texture

MEMORY = 256 * 2**20
"""Bytes that the finest level of a scene's texture array may take."""

KEPT = 2
"""Scenes whose textures stay on the device: one in which only a mirror was turned is drawn without new ones."""


def mip_levels(pixels: np.ndarray) -> list[np.ndarray]:
    """Successive halvings of an image down to one pixel, averaged in linear light.

    `pixels` are (H, W, 4): sRGB uint8, or linear float16.
    """
    if pixels.dtype == np.float16:
        return [pixels, *(linear.astype(np.float16) for linear in _halvings(pixels.astype(np.float32)))]
    halvings = _halvings(decode_srgb(pixels / np.float32(255.0)))
    return [pixels, *(np.rint(encode_srgb(linear) * 255.0).astype(np.uint8) for linear in halvings)]


def _halvings(linear: np.ndarray) -> Iterator[np.ndarray]:
    while max(linear.shape[:2]) > 1:
        rows, columns = linear.shape[0] // 2, linear.shape[1] // 2
        if rows:
            linear = (linear[0 : 2 * rows : 2] + linear[1 : 2 * rows : 2]) / 2.0
        if columns:
            linear = (linear[:, 0 : 2 * columns : 2] + linear[:, 1 : 2 * columns : 2]) / 2.0
        yield linear


def _layer_size(textures: tuple[Texture, ...]) -> int:
    """The power of two that serves the largest texture, inside the device's limit and the memory set aside."""
    largest = max((max(texture.pixels.shape[:2]) for texture in textures), default=1)
    size = 1 << (int(largest) - 1).bit_length()
    while size > maximum_size() or 4 * size * size * (len(textures) + 1) > MEMORY:
        size //= 2
    return size


def upload(layers: list[np.ndarray]) -> wgpu.GPUTexture:
    """Images of one size, as `mip_levels` takes them, as the layers of a texture with mipmaps."""
    device = get_device()
    height, width = layers[0].shape[:2]
    texture = device.create_texture(
        size=(width, height, len(layers)),
        format="rgba16float" if layers[0].dtype == np.float16 else "rgba8unorm-srgb",
        usage=wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST,
        mip_level_count=max(width, height).bit_length(),
    )
    for layer, pixels in enumerate(layers):
        for level, image in enumerate(mip_levels(pixels)):
            rows, columns = image.shape[:2]
            device.queue.write_texture(
                {"texture": texture, "mip_level": level, "origin": (0, 0, layer)},
                np.ascontiguousarray(image),
                {"bytes_per_row": image.itemsize * 4 * columns, "rows_per_image": rows},
                (columns, rows, 1),
            )
    return texture


@of_device_last(KEPT)
def texture_array(textures: tuple[Texture, ...]) -> wgpu.GPUTexture:
    """Layer 0 white, then each texture, resampled to one common square size; texture coordinates stay as they are."""
    most = get_device().limits["max-texture-array-layers"] - 1
    if len(textures) > most:
        raise AnamorphError(f"scene: has {len(textures)} images, and the device takes {most}; let parts share images")
    size = _layer_size(textures)
    layers = [np.full((size, size, 4), 255, np.uint8)]
    for texture in textures:
        layers.append(_resized(texture.pixels, (size, size)))
    return upload(layers)


def _resized(pixels: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Pixels (H, W, 4) at another (width, height); all is opaque, and alpha takes no part in the blending."""
    if pixels.shape[1::-1] == size:
        return pixels
    opaque = Image.fromarray(np.ascontiguousarray(pixels[..., :3])).resize(size, Image.Resampling.LANCZOS)
    return np.asarray(opaque.convert("RGBA"))


@of_device_last(KEPT)
def sky_texture(image: Texture | LinearImage | None) -> wgpu.GPUTexture:
    """The sky's image, inside the device's limit, or one white pixel where there is none."""
    if image is None:
        return upload([np.full((1, 1, 4), 255, np.uint8)])
    height, width = (min(extent, maximum_size()) for extent in image.pixels.shape[:2])
    # A width of one texel tells the shader that there is no image.
    size = max(width, 2), height
    if isinstance(image, Texture):
        return upload([_resized(image.pixels, size)])
    return upload([_halves(image.pixels, size)])


def _halves(light: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Linear light (H, W, 3) float32 at another (width, height), as (H, W, 4) float16; no light is beyond its range."""
    channels = [Image.fromarray(np.ascontiguousarray(light[..., channel])) for channel in range(3)]
    # What sharpens would make the surroundings of a sun darker than black.
    resized = [np.asarray(channel.resize(size, Image.Resampling.BOX)) for channel in channels]
    opaque = np.ones((size[1], size[0], 4), np.float16)
    opaque[..., :3] = np.minimum(np.stack(resized, axis=-1), np.finfo(np.float16).max)
    return opaque


def texture_sampler(vertical: str = "repeat") -> wgpu.GPUSampler:
    """Repeats, and blends between texels and between mip levels."""
    return get_device().create_sampler(
        address_mode_u="repeat",
        address_mode_v=vertical,
        mag_filter="linear",
        min_filter="linear",
        mipmap_filter="linear",
    )
