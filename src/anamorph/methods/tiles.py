"""Traced pixels on the device: tiles of the picture, each pixel coloured from where its path ends."""

from __future__ import annotations

import numpy as np
import wgpu

from anamorph.gpu.bindings import STORAGE, UNIFORM, bind, layout_of
from anamorph.gpu.buffers import SceneBuffers, roomy_buffer
from anamorph.gpu.device import get_device
from anamorph.gpu.drawing import make_pipeline, shader_module
from anamorph.gpu.targets import COLOR_FORMAT, SEEN_FORMATS
from anamorph.methods.bounces import WORDS

RECORD_BYTES = 4 * WORDS

class Tiles:
    """Tiles of one size, whose paths' ends `PathTracer.trace_tiles` has found."""

    def __init__(self, buffers: SceneBuffers) -> None:
        self._scene = buffers
        self._layout = layout_of(
            UNIFORM, STORAGE, STORAGE, STORAGE, STORAGE, stages=wgpu.ShaderStage.VERTEX | wgpu.ShaderStage.FRAGMENT
        )
        module = shader_module("gpu/vertices.wgsl", "methods/raytrace.wgsl")

        def pipeline(fragment: str, formats: tuple[str, ...]) -> wgpu.GPURenderPipeline:
            return make_pipeline(
                module,
                "tile_vertex",
                fragment,
                formats,
                buffers=(),
                groups=(self._layout,),
                depth_compare="always",
            )

        self._color = pipeline("traced_color", (COLOR_FORMAT,))
        self._seen = pipeline("traced_seen", SEEN_FORMATS)
        usage = wgpu.BufferUsage.UNIFORM | wgpu.BufferUsage.COPY_DST
        self._size = get_device().create_buffer(size=8, usage=usage)
        self._corners = self._paths = None
        self._count = 0

    def write(self, corners: np.ndarray, size: tuple[int, int], records: np.ndarray) -> None:
        """Take over the paths of tiles at `corners` (T, 2), of `size` (columns, rows)."""
        queue = get_device().queue
        self._count = len(corners)
        if not self._count:
            return
        grown = [roomy_buffer(self._corners, 8 * len(corners)), roomy_buffer(self._paths, records.nbytes)]
        if grown != [self._corners, self._paths]:
            self._corners, self._paths = grown
            self._group = bind(
                self._layout, [self._size, self._corners, self._paths, self._scene.vertices, self._scene.indices]
            )
        queue.write_buffer(self._size, 0, np.array(size, np.uint32))
        queue.write_buffer(self._corners, 0, np.ascontiguousarray(corners, np.uint32))
        queue.write_buffer(self._paths, 0, records)

    def draw_color(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """Colour the tiles' pixels; the shading and projection groups are bound."""
        self._draw(render_pass, self._color)

    def draw_seen(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """Fill the tiles' part of the seen buffers."""
        self._draw(render_pass, self._seen)

    def _draw(self, render_pass: wgpu.GPURenderPassEncoder, pipeline: wgpu.GPURenderPipeline) -> None:
        if self._count:
            render_pass.set_pipeline(pipeline)
            render_pass.set_bind_group(2, self._group)
            render_pass.draw(6, self._count)


def tiles_at_once(pixels: int) -> int:
    """How many tiles of `pixels` each fit into one storage buffer."""
    return max(get_device().limits["max-storage-buffer-binding-size"] // (RECORD_BYTES * pixels), 1)
