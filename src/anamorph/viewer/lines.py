"""Draws marks over an image: thick lines and dots with clean edges, and a dark rim that sets them off from it."""

from __future__ import annotations

import numpy as np
import wgpu

from anamorph.gpu.bindings import STORAGE, UNIFORM, bind, layout_of
from anamorph.gpu.buffers import grown_buffer
from anamorph.gpu.device import get_device
from anamorph.gpu.shaders import shader_module
from anamorph.viewer.marks import Marks, joined_strokes

CANVAS_BYTES = 4 * (16 + 4)
STROKE_FLOATS = 12

HALO = 1.0
"""How far the dark rim reaches beyond a line, in logical pixels."""

BLEND = {"operation": "add", "src_factor": "one", "dst_factor": "one-minus-src-alpha"}


class LineRenderer:
    """Draws marks into targets of one format, through everything that stands before them.

    Parameters
    ----------
    form : str
        The colour target's format; where it is of whole numbers without "-srgb", sRGB values are written.
    halo : bool
        Whether lines and dots have a dark rim.
    """

    def __init__(self, form: str, halo: bool = True) -> None:
        device = get_device()
        stages = wgpu.ShaderStage.VERTEX | wgpu.ShaderStage.FRAGMENT
        self._layout = layout_of(UNIFORM, STORAGE, stages=stages)
        module = shader_module("viewer/lines.wgsl")
        constants = {"HALO": HALO if halo else 0.0, "ENCODE": float(form.endswith("unorm"))}
        self._pipeline = device.create_render_pipeline(
            layout=device.create_pipeline_layout(bind_group_layouts=[self._layout]),
            vertex={"module": module, "entry_point": "stroke_vertex", "constants": constants},
            fragment={
                "module": module,
                "entry_point": "stroke_color",
                "constants": constants,
                "targets": [{"format": form, "blend": {"color": BLEND, "alpha": BLEND}}],
            },
            primitive={"topology": "triangle-strip"},
        )
        usage = wgpu.BufferUsage.UNIFORM | wgpu.BufferUsage.COPY_DST
        self._canvas = device.create_buffer(size=CANVAS_BYTES, usage=usage)
        self._strokes: wgpu.GPUBuffer | None = None
        self._group: wgpu.GPUBindGroup | None = None
        self._count = 0

    def upload(self, marks: Marks) -> None:
        """Replace what is drawn; needed only when it has changed."""
        drawn = joined_strokes([marks.segments, marks.dots])
        self._count = len(drawn.ends)
        if not self._count:
            return
        strokes = np.zeros((self._count, STROKE_FLOATS), np.float32)
        strokes[:, 0:3], strokes[:, 4:7] = drawn.ends[:, 0], drawn.ends[:, 1]
        strokes[:, 3], strokes[:, 8:12] = 0.5 * drawn.widths, drawn.colors
        buffer = grown_buffer(self._strokes, strokes.nbytes)
        if buffer is not self._strokes:
            self._strokes, self._group = buffer, bind(self._layout, [self._canvas, buffer])
        get_device().queue.write_buffer(buffer, 0, strokes)

    def draw(
        self, render_pass: wgpu.GPURenderPassEncoder, clip: np.ndarray, size: tuple[int, int], ratio: float = 1.0
    ) -> None:
        """Draw what was uploaded last, once for each submission.

        Parameters
        ----------
        render_pass
            Into one colour target, without depth.
        clip : (4, 4) float64
            World to clip space, as `camera_projection` has it.
        size : (width, height)
            Of the target, pixels.
        ratio : float
            Pixels of the target for each logical one, in which widths are given.
        """
        if not self._count:
            return
        canvas = np.concatenate([np.asarray(clip).T.ravel(), size, [ratio, 0.0]]).astype(np.float32)
        get_device().queue.write_buffer(self._canvas, 0, canvas)
        render_pass.set_pipeline(self._pipeline)
        render_pass.set_bind_group(0, self._group)
        render_pass.draw(4, self._count)
