"""The verification overlay: a ball for each vertex, and the wireframe of the ray mesh.

Where a method is exact at vertices, a ball at each vertex ray's hit shows behind a crossing of the wires. Source:
Kakimoto et al. 2007, Figure 1.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import wgpu

from anamorph.gpu.buffers import storage_buffer
from anamorph.gpu.device import get_device
from anamorph.gpu.drawing import make_pipeline
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import COLOR_FORMAT

BALL_VERTICES = 6 * 10 * 6

BALL_BYTES = 4 * 7


class Overlay:
    """Balls and wires for one mesh of vertices (V, 3) and faces (F, 3), drawn with `samples` a pixel."""

    def __init__(self, positions: np.ndarray, faces: np.ndarray, samples: int) -> None:
        edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
        ends = np.asarray(positions, np.float32)[np.unique(edges, axis=0)].reshape(-1, 3)
        self._count, self._wire_count = len(positions), len(ends)
        self._balls = storage_buffer(np.zeros((len(positions), 7), np.float32), wgpu.BufferUsage.VERTEX)
        self._ends = storage_buffer(ends, wgpu.BufferUsage.VERTEX)
        module = shader_module("methods/pervertex/overlay.wgsl")

        def pipeline(kind: str, buffer: dict[str, Any], topology: str) -> wgpu.GPURenderPipeline:
            names, formats = (f"{kind}_vertex", f"{kind}_color"), (COLOR_FORMAT,)
            return make_pipeline(module, *names, formats, buffers=(buffer,), samples=samples, topology=topology)

        balls = _buffer(BALL_BYTES, "instance", ("float32x4", 0), ("float32x3", 16))
        self._ball_pipeline = pipeline("ball", balls, "triangle-list")
        self._wire_pipeline = pipeline("wire", _buffer(12, "vertex", ("float32x3", 0)), "line-list")

    def place(self, centers: np.ndarray, radii: np.ndarray, colors: np.ndarray) -> None:
        """Put a ball at each of `centers` (V, 3), of `radii` (V,) metres and of `colors` (V, 3); radius 0 hides it."""
        get_device().queue.write_buffer(self._balls, 0, np.column_stack([centers, radii, colors]).astype(np.float32))

    def draw_balls(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """Draw the balls; the shading and projection groups are bound."""
        render_pass.set_pipeline(self._ball_pipeline)
        render_pass.set_vertex_buffer(0, self._balls)
        render_pass.draw(BALL_VERTICES, self._count)

    def draw_wires(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """Draw the wireframe; the shading and projection groups are bound."""
        render_pass.set_pipeline(self._wire_pipeline)
        render_pass.set_vertex_buffer(0, self._ends)
        render_pass.draw(self._wire_count)


def _buffer(stride: int, step: str, *attributes: tuple[str, int]) -> dict[str, Any]:
    """A vertex buffer's layout, from the form and the offset of each attribute."""
    return {
        "array_stride": stride,
        "step_mode": step,
        "attributes": [
            {"shader_location": location, "format": form, "offset": offset}
            for location, (form, offset) in enumerate(attributes)
        ],
    }
