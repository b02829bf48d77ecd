"""What a method doubts is traced: the pixels are listed on the device, and their paths put in their places."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np
import wgpu

from anamorph.gpu.bindings import STORAGE, bind, layout_of, numbers
from anamorph.gpu.buffers import grown_buffer, storage_buffer
from anamorph.gpu.device import get_device, of_device
from anamorph.gpu.drawing import ProjectionUniform, bind_scene, make_pipeline
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.visibility import TEXEL_FORMAT, VisibilityBuffer
from anamorph.methods.stage import Stage
from anamorph.methods.tracing.launch import EyeRays
from anamorph.methods.tracing.packing import packed
from anamorph.methods.tracing.paths import PathTracer
from anamorph.rays.caster import Caster
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import Geometry

WORKGROUP = 64
"""Pixels of a row that the device lists at once."""


@of_device
def _listing_layout() -> wgpu.GPUBindGroupLayout:
    written, given = {"buffer": {"type": "storage"}}, {"buffer": {"type": "uniform"}}
    return layout_of(*3 * [numbers()], written, written, given, stages=wgpu.ShaderStage.COMPUTE)


@of_device
def _replacing_layout() -> wgpu.GPUBindGroupLayout:
    return layout_of(STORAGE, STORAGE, stages=wgpu.ShaderStage.VERTEX)


class DoubtTracer:
    """Traces the doubtful pixels of a visibility buffer.

    Parameters
    ----------
    stage : Stage
    visibility : VisibilityBuffer
    caster : Caster
        Over the stage's scene.
    bounces : int
        How many specular interfaces a path may meet.

    Attributes
    ----------
    traced : int
        How many pixels were traced last.
    """

    def __init__(self, stage: Stage, visibility: VisibilityBuffer, caster: Caster, bounces: int) -> None:
        self._stage, self._visibility = stage, visibility
        self._tracer = PathTracer(stage.view.scene, stage.geometry, caster, bounces)
        width, height = visibility.size
        usage = wgpu.BufferUsage.COPY_SRC
        self._count = storage_buffer(np.zeros(1, np.uint32), usage)
        self._numbers = storage_buffer(np.zeros(width * height, np.uint32), usage)
        given = wgpu.BufferUsage.UNIFORM | wgpu.BufferUsage.COPY_DST
        self._rectangle = get_device().create_buffer(size=16, usage=given)
        own = len(visibility.textures)
        lines = [visibility.textures[min(line, own - 1)][1].create_view() for line in range(3)]
        self._listed = bind(_listing_layout(), [*lines, self._count, self._numbers, self._rectangle])
        module, layouts = shader_module("methods/tracing/doubtful.wgsl"), [_listing_layout()]
        self._list = get_device().create_compute_pipeline(
            layout=get_device().create_pipeline_layout(bind_group_layouts=layouts),
            compute={"module": module, "entry_point": "list_doubtful", "constants": {"LINES": own}},
        )
        self._replace = make_pipeline(
            shader_module("methods/tracing/replaced.wgsl"),
            "traced_vertex",
            "traced_end",
            (TEXEL_FORMAT, TEXEL_FORMAT),
            buffers=(),
            groups=(_replacing_layout(),),
            topology="point-list",
            depth_compare="always",
            depth_write=False,
        )
        self._held: list[wgpu.GPUBuffer | None] = (1 + len(visibility.textures)) * [None]
        self._points: list[wgpu.GPUBindGroup] = []
        self.traced = 0

    def moved(self, geometry: Geometry) -> None:
        """Follow the scene's vertices; the caster has followed already."""
        self._tracer.moved(geometry)

    def tracing(
        self,
        encoder: wgpu.GPUCommandEncoder,
        depth: wgpu.GPUTextureView,
        projection: ProjectionUniform,
        camera: Camera,
        shift: tuple[float, float],
    ) -> Generator[None, None, wgpu.GPUCommandEncoder]:
        """Trace what the passes of `encoder` leave doubtful, in steps; returns the encoder to go on with."""
        (width, height), side = self._visibility.size, self._visibility.side
        corners = side * np.array(self._visibility.rectangle or (0, 0, 0, 0), np.uint32)
        queue = get_device().queue
        queue.write_buffer(self._count, 0, np.zeros(1, np.uint32))
        queue.write_buffer(self._rectangle, 0, corners)
        columns, rows = (corners[2:] - corners[:2]).tolist()
        listing = encoder.begin_compute_pass()
        listing.set_pipeline(self._list)
        listing.set_bind_group(0, self._listed)
        listing.dispatch_workgroups(-(-columns // WORKGROUP), rows)
        listing.end()
        encoder = self._stage.recorder.part(encoder)
        yield
        self.traced = int(np.frombuffer(queue.read_buffer(self._count), np.uint32)[0])
        if not self.traced:
            return encoder
        # The device lists them in any order; the image must not depend on it.
        listed = np.sort(np.frombuffer(queue.read_buffer(self._numbers, 0, 4 * self.traced), np.uint32))
        pixels = np.stack([listed % width, listed // width], axis=1)
        rays = EyeRays(camera, (width, height), pixels, (1, 1), (side * shift[0], side * shift[1]))
        records = yield from self._tracer.tracing(rays)
        lines = [packed(records)]
        if len(self._visibility.textures) > 1:
            # Light that is not dispersed is drawn with green's: its red and blue are empty.
            for line in (yield from self._tracer.tracing_colors(rays, records)):
                lines.append(np.zeros_like(lines[0]))
                lines[-1][:, records.view(np.uint32)[:, 14] > 0] = packed(line)
        contents = [pixels, *(np.ascontiguousarray(line.swapaxes(0, 1)) for line in lines)]
        held = [grown_buffer(old, data.nbytes) for old, data in zip(self._held, contents, strict=True)]
        if held != self._held:
            self._held = list(held)
            self._points = [bind(_replacing_layout(), [held[0], own]) for own in held[1:]]
        for buffer, data in zip(held, contents, strict=True):
            queue.write_buffer(buffer, 0, data)
        for number, points in enumerate(self._points):
            render_pass = self._visibility.begin(encoder, depth, number, keep=True)
            bind_scene(render_pass, self._stage.buffers, projection)
            render_pass.set_pipeline(self._replace)
            render_pass.set_bind_group(2, points)
            render_pass.draw(self.traced)
            render_pass.end()
        return encoder
