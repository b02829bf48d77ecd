"""What stands before a mirror or a lens hides it: samples whose depth the diffuse meshes surpass are emptied."""

from __future__ import annotations

import numpy as np
import wgpu

from anamorph.gpu.bindings import STORAGE, bind, layout_of
from anamorph.gpu.buffers import SceneBuffers, storage_buffer
from anamorph.gpu.device import get_device, of_device
from anamorph.gpu.drawing import ProjectionUniform, bind_scene, make_pipeline
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.visibility import TEXEL_FORMAT, Rectangle, VisibilityBuffer


@of_device
def _depths_layout() -> wgpu.GPUBindGroupLayout:
    return layout_of(STORAGE)


class Hiding:
    """Empties hidden samples of a visibility buffer."""

    def __init__(self, visibility: VisibilityBuffer) -> None:
        width, height = visibility.size
        self._visibility = visibility
        self._depths = storage_buffer(np.zeros((height, width), np.float32))
        self._group = bind(_depths_layout(), [self._depths])
        self._pipeline = make_pipeline(
            shader_module("methods/threeray/hidden.wgsl"), "hidden_vertex", "hidden_end", (TEXEL_FORMAT, TEXEL_FORMAT),
            buffers=(), groups=(_depths_layout(),), depth_compare="less", depth_write=False,
        )  # fmt: skip

    def draw(
        self,
        encoder: wgpu.GPUCommandEncoder,
        nearest: wgpu.GPUTextureView,
        depth: np.ndarray,
        rectangle: Rectangle,
        projection: ProjectionUniform,
        scene: SceneBuffers,
    ) -> None:
        """Empty the samples of a rectangle whose `depth` (height, width), reversed, is less than the `nearest`."""
        x0, y0, x1, y1 = rectangle
        rows = np.ascontiguousarray(depth[y0:y1], np.float32)
        get_device().queue.write_buffer(self._depths, 4 * y0 * depth.shape[1], rows)
        for line in range(len(self._visibility.textures)):
            render_pass = self._visibility.begin(encoder, nearest, line, keep=True)
            bind_scene(render_pass, scene, projection)
            render_pass.set_pipeline(self._pipeline)
            render_pass.set_bind_group(2, self._group)
            render_pass.set_scissor_rect(x0, y0, x1 - x0, y1 - y0)
            render_pass.draw(3)
            render_pass.end()
