"""The visibility buffer: what each pixel of a specular surface sees, found by a method and coloured by one pass.

Source: Burns and Hunt, "The visibility buffer: a cache-friendly approach to deferred shading" (2013).
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import wgpu

from anamorph.gpu.bindings import STORAGE, bind, layout_of, numbers
from anamorph.gpu.buffers import SceneBuffers
from anamorph.gpu.device import get_device, of_device
from anamorph.gpu.drawing import draw_mesh, make_pipeline
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import COLOR_FORMAT, SEEN_FORMATS, Target, begin_pass, make_texture, read_texture

TEXEL_FORMAT = "rgba32uint"
"""Of both textures."""

PLACES = 0xFFFFFF
"""Of a direction, along a side of the octahedron."""

Rectangle = tuple[int, int, int, int]
"""Part of an image, (x0, y0, x1, y1) in pixels, its ends left out."""

LINE_MASKS = wgpu.ColorWrite.ALL, wgpu.ColorWrite.RED, wgpu.ColorWrite.BLUE
"""What is drawn of the light of each line: green's everywhere, then red and blue over it."""


@of_device
def visibility_layout() -> wgpu.GPUBindGroupLayout:
    """The layout of group 2: the textures, and the scene's triangles."""
    return layout_of(numbers(), numbers(), STORAGE, STORAGE)


class VisibilityBuffer:
    """What each pixel sees, as two texels of 16 bytes: `PathEnd` in visibility.wgsl.

    Parameters
    ----------
    scene : SceneBuffers
    size : (width, height)
        Of the image.
    lines : int
        1, or 3 where glass sends red and blue light its own way.
    antialias : int
        Samples a pixel: 1 or 4.
    alone : bool
        Whether nothing else is drawn into the image.

    Attributes
    ----------
    side : int
        Samples along each side of a pixel.
    size : (width, height)
        Of the textures: samples.
    textures : list of (texture, texture)
        Of green light, or all of it; then of red and of blue light, empty where it goes with green's.
    rectangle : (x0, y0, x1, y1) or None
        Where something may have been found; the rest of the textures means nothing.
    """

    def __init__(
        self, scene: SceneBuffers, size: tuple[int, int], lines: int = 1, antialias: int = 1, alone: bool = False
    ) -> None:
        self._scene, self._size, self.side = scene, size, {1: 1, 4: 2}[antialias]
        self.size = self.side * size[0], self.side * size[1]
        self.rectangle: Rectangle | None = None
        self.textures = [
            (make_texture(self.size, TEXEL_FORMAT), make_texture(self.size, TEXEL_FORMAT)) for _ in range(lines)
        ]
        self._groups = [
            bind(visibility_layout(), [*(each.create_view() for each in pair), scene.vertices, scene.indices])
            for pair in self.textures
        ]
        self._colored, self._alone = 0, alone
        # Found samples do not lie where the image's do. Where other meshes are in a pixel, too, what was found gets all
        # of its samples first, and the depth of specular meshes keeps those that see them.
        self._shares_pixels = self.side > 1 and not alone

    def write(self, rectangle: Rectangle, texels: np.ndarray, line: int = 0) -> None:
        """Take over a rectangle of samples: `texels` (2, rows, columns, 4) uint32. A pixel around it becomes empty."""
        x0, y0, x1, y1 = rectangle
        left, top = max(x0 - self.side, 0), max(y0 - self.side, 0)
        right, bottom = min(x1 + self.side, self.size[0]), min(y1 + self.side, self.size[1])
        # What an earlier frame has left there must not give these pixels their footprints.
        around = (left, top, right, y0), (left, y1, right, bottom), (left, y0, x0, y1), (x1, y0, right, y1)
        for texture, rows in zip(self.textures[line], texels, strict=True):
            _write(texture, rectangle, rows)
            for part in around:
                _write(texture, part, np.zeros((part[3] - part[1], part[2] - part[0], 4), np.uint32))

    def begin(
        self, encoder: wgpu.GPUCommandEncoder, depth: wgpu.GPUTextureView, line: int = 0, keep: bool = False
    ) -> wgpu.GPURenderPassEncoder:
        """Begin a pass that fills a line's textures, empty before or kept, with the depth that is there already."""
        views = tuple(texture.create_view() for texture in self.textures[line])
        target = Target(self.size, self.textures[line], views, (None, None), depth, 1)
        return begin_pass(encoder, target, keep_depth=True, keep_color=keep)

    def show(self, rectangle: Rectangle | None, lines: int = 1) -> None:
        """Draw this rectangle from now on, by the light of so many lines; nothing if it is None."""
        self.rectangle, self._colored = rectangle, lines

    def draw_color(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """Colour what has been found; shading and projection are bound."""
        for line in range(self._colored):
            self._draw(render_pass, self._colors[line], line)
        if self.rectangle is not None and self._shares_pixels:
            render_pass.set_bind_group(2, self._groups[0])
            for number in self._scene.specular:
                render_pass.set_pipeline(self._depths[number in self._scene.mirrors])
                draw_mesh(render_pass, self._scene, number)

    def draw_seen(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """Fill the seen buffers, by green light."""
        self._draw(render_pass, self._seen, 0)

    def _draw(self, render_pass: wgpu.GPURenderPassEncoder, pipeline: wgpu.GPURenderPipeline, line: int) -> None:
        if self.rectangle is None:
            return
        x0, y0, x1, y1 = self.rectangle
        render_pass.set_pipeline(pipeline)
        render_pass.set_bind_group(2, self._groups[line])
        render_pass.set_scissor_rect(x0, y0, x1 - x0, y1 - y0)
        render_pass.draw(3)
        render_pass.set_scissor_rect(0, 0, *self._size)

    @cached_property
    def _colors(self) -> list[wgpu.GPURenderPipeline]:
        constants = {"SKY_IMAGE": int(self._scene.sky_image), "SIDE": self.side}
        fragment, settings = "found_color", dict[str, Any]()
        if self.side > 1:
            fragment, constants["ALONE"] = "found_color_of_samples", int(self._alone)
            settings = {"samples": self.side * self.side, "depth_write": not self._shares_pixels}
        return [
            self._pipeline(
                fragment, (COLOR_FORMAT,), write_mask=mask, constants=constants | {"FIRST": int(line == 0)}, **settings
            )
            for line, mask in enumerate(LINE_MASKS[: len(self.textures)])
        ]

    @cached_property
    def _depths(self) -> tuple[wgpu.GPURenderPipeline, wgpu.GPURenderPipeline]:
        """Draw the depth of glass, which is seen from both sides, and of mirrors."""
        glass, mirrors = (
            make_pipeline(
                shader_module("gpu/visibility.wgsl"), "depth_vertex", "no_color", (COLOR_FORMAT,),
                groups=(visibility_layout(),), samples=self.side * self.side, cull=cull, write_mask=0,
                constants={"SIDE": self.side},
            )
            for cull in ("none", "back")
        )  # fmt: skip
        return glass, mirrors

    @cached_property
    def _seen(self) -> wgpu.GPURenderPipeline:
        return self._pipeline("found_seen", SEEN_FORMATS)

    def _pipeline(self, fragment: str, formats: tuple[str, ...], **settings: Any) -> wgpu.GPURenderPipeline:
        return make_pipeline(
            shader_module("gpu/visibility.wgsl"),
            "found_vertex",
            fragment,
            formats,
            buffers=(),
            groups=(visibility_layout(),),
            depth_compare="always",
            **settings,
        )

    def rays(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The last rays in the rectangle.

        Returns
        -------
        found : (rows, columns) bool
            Whether anything was found for a pixel.
        origins, directions : (rows, columns, 3) float32
            Metres, and unit; directions are zero where no light arrives.
        """
        assert self.rectangle is not None
        x0, y0, x1, y1 = self.rectangle
        first, second = (read_texture(texture)[y0:y1, x0:x1] for texture in self.textures[0])
        origins = np.ascontiguousarray(first[..., :3]).view(np.float32)
        place = (second[..., :2] & PLACES) / (0.5 * PLACES) - 1.0
        height = 1.0 - np.abs(place).sum(axis=-1)
        signs = np.where(place >= 0.0, 1.0, -1.0)
        folded = np.where(height[..., None] < 0.0, (1.0 - np.abs(place[..., ::-1])) * signs, place)
        directions = np.concatenate([folded, height[..., None]], axis=-1)
        directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
        directions[(second[..., 3] == 0) & ((second[..., :2] >> 24) == 0).all(axis=-1)] = 0.0
        return (first[..., 3] > 0) | (second[..., 2] > 0), origins, directions.astype(np.float32)


def _write(texture: wgpu.GPUTexture, rectangle: Rectangle, texels: np.ndarray) -> None:
    """Replace the texels of a rectangle, which may be empty."""
    x0, y0, x1, y1 = rectangle
    if x0 < x1 and y0 < y1:
        get_device().queue.write_texture(
            {"texture": texture, "origin": (x0, y0, 0)},
            np.ascontiguousarray(texels),
            {"bytes_per_row": 16 * (x1 - x0), "rows_per_image": y1 - y0},
            (x1 - x0, y1 - y0, 1),
        )
