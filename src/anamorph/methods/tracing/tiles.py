"""Traced pixels on the device: tiles of the image, each pixel coloured from where its path ends."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import wgpu

from anamorph.gpu.bindings import STORAGE, UNIFORM, bind, layout_of
from anamorph.gpu.buffers import SceneBuffers, grown_buffer
from anamorph.gpu.device import get_device
from anamorph.gpu.drawing import make_pipeline
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import COLOR_FORMAT, SEEN_FORMATS
from anamorph.methods.tracing.bounces import WORDS

RECORD_BYTES = 4 * WORDS


class Tiles:
    """Tiles of one size, whose paths' ends `PathTracer.tracing` has found."""

    def __init__(self, buffers: SceneBuffers) -> None:
        self._scene = buffers
        self._layout = layout_of(UNIFORM, *5 * [STORAGE], stages=wgpu.ShaderStage.VERTEX | wgpu.ShaderStage.FRAGMENT)
        self._module = shader_module("methods/tracing/tiles.wgsl")
        self._color = self._pipeline("traced_color", (COLOR_FORMAT,))
        self._seen = self._pipeline("traced_seen", SEEN_FORMATS)
        usage = wgpu.BufferUsage.UNIFORM | wgpu.BufferUsage.COPY_DST
        self._size = get_device().create_buffer(size=8, usage=usage)
        self._grown: list[wgpu.GPUBuffer | None] = 4 * [None]
        self._groups: list[wgpu.GPUBindGroup] = []
        self._count, self._disperses = 0, False

    def write(
        self, corners: np.ndarray, size: tuple[int, int], records: np.ndarray, colors: np.ndarray | None = None
    ) -> None:
        """Take over the paths of tiles at `corners` (T, 2), of `size` (columns, rows).

        With `colors` from `PathTracer.tracing_colors` red and blue are drawn where their own paths lead, else all
        colours where green's leads.
        """
        queue = get_device().queue
        self._count = len(corners)
        red_and_blue = (None, None) if colors is None or not colors.size else colors
        self._disperses = red_and_blue is colors
        if not self._count:
            return
        contents = [np.ascontiguousarray(corners, np.uint32), records, *red_and_blue]
        grown = [
            buffer if content is None else grown_buffer(buffer, content.nbytes)
            for buffer, content in zip(self._grown, contents, strict=True)
        ]
        if grown != self._grown:
            self._grown = grown
            places, paths, red, blue = grown
            self._groups = [
                bind(self._layout, [self._size, places, paths, line, self._scene.vertices, self._scene.indices])
                for line in (paths, red or paths, blue or paths)
            ]
        queue.write_buffer(self._size, 0, np.array(size, np.uint32))
        for buffer, content in zip(grown, contents, strict=True):
            if content is not None:
                queue.write_buffer(buffer, 0, content)

    def draw_color(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """Colour the tiles' pixels; the shading and projection groups are bound."""
        self._draw(render_pass, self._color, 0)
        if self._disperses:
            for line, pipeline in enumerate(self._lines, start=1):
                self._draw(render_pass, pipeline, line)

    def draw_seen(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """Fill the tiles' part of the seen buffers, by the d line."""
        self._draw(render_pass, self._seen, 0)

    def _draw(self, render_pass: wgpu.GPURenderPassEncoder, pipeline: wgpu.GPURenderPipeline, line: int) -> None:
        if self._count:
            render_pass.set_pipeline(pipeline)
            render_pass.set_bind_group(2, self._groups[line])
            render_pass.draw(6, self._count)

    @cached_property
    def _lines(self) -> tuple[wgpu.GPURenderPipeline, wgpu.GPURenderPipeline]:
        """What draws red and blue alone, made where some glass disperses."""
        masks = wgpu.ColorWrite.RED, wgpu.ColorWrite.BLUE
        red, blue = (
            self._pipeline("traced_color", (COLOR_FORMAT,), write_mask=mask, constants={"ONE_LINE": 1})
            for mask in masks
        )
        return red, blue

    def _pipeline(self, fragment: str, formats: tuple[str, ...], **settings: Any) -> wgpu.GPURenderPipeline:
        return make_pipeline(
            self._module,
            "tile_vertex",
            fragment,
            formats,
            buffers=(),
            groups=(self._layout,),
            depth_compare="always",
            **settings,
        )


def tiles_at_once(pixels: int) -> int:
    """How many tiles of `pixels` each fit into one storage buffer."""
    return max(get_device().limits["max-storage-buffer-binding-size"] // (RECORD_BYTES * pixels), 1)
