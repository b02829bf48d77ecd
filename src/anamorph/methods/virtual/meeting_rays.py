"""What rays meet that leave mirrors and lenses: what stands still, which is kept, and what has moved."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np
import wgpu

from anamorph.gpu.bindings import STORAGE, UNIFORM, bind, depths, layout_of, numbers
from anamorph.gpu.buffers import grown_buffer
from anamorph.gpu.device import get_device, of_device
from anamorph.gpu.drawing import ProjectionUniform, bind_scene, make_pipeline
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import begin_pass, make_target
from anamorph.gpu.visibility import TEXEL_FORMAT, Rectangle, VisibilityBuffer
from anamorph.methods.stage import Stage
from anamorph.methods.virtual.leaving_rays import SIDE, LeavingRays
from anamorph.methods.virtual.listing import Lists, listing
from anamorph.methods.virtual.triangle_tree import TriangleTree

MOST = 64
"""Triangles that a tile's samples ask, at most: to trace them takes as long."""

TRACED = 0xFFFFFFFF
"""In place of a count: rays are traced there."""

MET_FORMAT = "rg32uint"
"""Of what is kept: a triangle, from 1, or `TRACED`; and the bits of its distance."""


@of_device
def _layout() -> wgpu.GPUBindGroupLayout:
    return layout_of(numbers(), numbers(), depths(), UNIFORM, *4 * [STORAGE], numbers())


class MeetingRays:
    """What the rays of one line of light meet.

    Parameters
    ----------
    stage : Stage
    leaving : LeavingRays
    triangles, surfaces : buffers
        The scene's triangles, and the surface numbers of its objects: see triangle_records.py.
    size : (width, height)
        Samples.
    """

    def __init__(
        self,
        stage: Stage,
        leaving: LeavingRays,
        triangles: wgpu.GPUBuffer,
        surfaces: wgpu.GPUBuffer,
        size: tuple[int, int],
    ) -> None:
        self._stage, self._leaving = stage, leaving
        self._scene = [triangles, surfaces]
        self._kept, self._none = make_target(size, (MET_FORMAT,)), make_target((1, 1), (MET_FORMAT,))
        # Lists of what stands still, and of what moves.
        self._held: dict[bool, list[wgpu.GPUBuffer | None]] = {False: [None, None], True: [None, None]}
        self._groups: dict[bool, wgpu.GPUBindGroup] = {}
        self.asked = 0

        def pipeline(fragment: str, *formats: str) -> wgpu.GPURenderPipeline:
            return make_pipeline(
                shader_module("methods/virtual/met.wgsl"), "met_vertex", fragment, formats,
                buffers=(), groups=(_layout(),), depth_compare="greater-equal", constants={"SIDE": SIDE},
            )  # fmt: skip

        self._meet, self._end = pipeline("met_first", MET_FORMAT), pipeline("met_end", TEXEL_FORMAT, TEXEL_FORMAT)

    def keeping(
        self, encoder: wgpu.GPUCommandEncoder, projection: ProjectionUniform, still: TriangleTree, rectangle: Rectangle
    ) -> Generator[None, None, None]:
        """Have the rays meet what stands still, and keep that; in steps."""
        yield from self._list(still, moves=False)
        self._draw(begin_pass(encoder, self._kept), projection, rectangle, self._meet, moves=False)

    def ending(
        self,
        encoder: wgpu.GPUCommandEncoder,
        projection: ProjectionUniform,
        triangles: TriangleTree,
        visibility: VisibilityBuffer,
        depth: wgpu.GPUTextureView,
        line: int,
        moves: bool,
    ) -> Generator[None, None, None]:
        """Have the rays meet these triangles, and what is kept if these are what `moves`; in steps.

        A line of the visibility buffer is written, where mirrors and lenses are not behind `depth`.
        """
        assert visibility.rectangle is not None
        yield from self._list(triangles, moves)
        x0, y0, x1, y1 = (visibility.side * end for end in visibility.rectangle)
        self._draw(visibility.begin(encoder, depth, line), projection, (x0, y0, x1, y1), self._end, moves)

    def _list(self, triangles: TriangleTree, moves: bool) -> Generator[None, None, None]:
        assert self._leaving.tree is not None
        found: Lists = yield from listing(self._leaving.tree, triangles, MOST)
        counts = np.diff(found.begins)
        self.asked = int(counts[~found.full].sum())
        lists = np.stack([found.begins[:-1], np.where(found.full, TRACED, counts)], axis=1).astype(np.uint32)
        contents = [lists, np.concatenate([found.triangles, np.zeros(1, np.uint32)])]
        held = [grown_buffer(old, data.nbytes) for old, data in zip(self._held[moves], contents, strict=True)]
        if held != self._held[moves]:
            self._held[moves] = list(held)
            before = self._kept if moves else self._none
            resources = [*self._leaving.views, self._leaving.extent, *self._scene, *held, before.attachments[0]]
            self._groups[moves] = bind(_layout(), resources)
        for buffer, data in zip(held, contents, strict=True):
            get_device().queue.write_buffer(buffer, 0, data)

    def _draw(
        self,
        render_pass: wgpu.GPURenderPassEncoder,
        projection: ProjectionUniform,
        rectangle: Rectangle,
        pipeline: wgpu.GPURenderPipeline,
        moves: bool,
    ) -> None:
        x0, y0, x1, y1 = rectangle
        bind_scene(render_pass, self._stage.buffers, projection)
        render_pass.set_pipeline(pipeline)
        render_pass.set_bind_group(2, self._groups[moves])
        render_pass.set_scissor_rect(x0, y0, x1 - x0, y1 - y0)
        render_pass.draw(3)
        render_pass.end()
