"""The reference: a ray for every pixel that looks at a specular surface, bent as often as it meets one.

Directly seen pixels are drawn as in every other method; inside the rectangle that bounds the specular surfaces each
pixel is traced by paths.py on the CPU. It is at once the truth that the other methods are held against, and the
competitor that they must be faster than.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import wgpu

from anamorph.errors import AnamorphError
from anamorph.frame import View
from anamorph.gpu.bindings import STORAGE, UNIFORM, bind, layout_of
from anamorph.gpu.device import get_device
from anamorph.gpu.drawing import make_pipeline, shader_module
from anamorph.gpu.targets import COLOR_FORMAT, SEEN_FORMATS
from anamorph.methods.bounces import WORDS
from anamorph.methods.paths import PathTracer, Rectangle, specular_rectangle
from anamorph.methods.protocol import Method, Session
from anamorph.methods.session import DrawingSession, Stage
from anamorph.rays import Caster
from anamorph.scene.camera import Camera

RECORD_BYTES = 4 * WORDS


@dataclass(frozen=True)
class Options:
    """Options of `raytrace`.

    Parameters
    ----------
    truth : str
        "surface": rays bend at the exact surface, or for a plain mesh at its interpolated normal. "raymesh": the
        vertex rays of the ray mesh are interpolated.
    bounces : int
        How many specular surfaces a path may meet.
    """

    truth: str = "surface"
    bounces: int = 8


class _Band:
    """Whole rows of the traced rectangle, few enough for one storage buffer."""

    def __init__(self, capacity: int, layout: wgpu.GPUBindGroupLayout, stage: Stage) -> None:
        device = get_device()
        self.capacity = capacity
        self._rectangle = device.create_buffer(size=16, usage=wgpu.BufferUsage.UNIFORM | wgpu.BufferUsage.COPY_DST)
        self._paths = device.create_buffer(
            size=capacity * RECORD_BYTES, usage=wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_DST
        )
        self._group = bind(layout, [self._rectangle, self._paths, stage.buffers.vertices, stage.buffers.indices])
        self._place = (0, 0, 0, 0)

    def write(self, place: tuple[int, int, int, int], records: np.ndarray) -> None:
        """Take over the paths of the rectangle `place` (x, y, width, height)."""
        queue = get_device().queue
        queue.write_buffer(self._rectangle, 0, np.array(place, np.uint32))
        queue.write_buffer(self._paths, 0, records)
        self._place = place

    def draw(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """Colour the rectangle's pixels."""
        render_pass.set_bind_group(2, self._group)
        render_pass.set_scissor_rect(*self._place)
        render_pass.draw(3)


class TracedDrawing:
    """Replaces every pixel around the specular surfaces by a traced one. See `SpecularDrawing`."""

    def __init__(self, stage: Stage, options: Options) -> None:
        self._stage = stage
        self.replaced = stage.buffers.specular
        self._tracer = PathTracer(
            stage.view.scene, stage.geometry, Caster(stage.geometry), options.bounces, options.truth
        )
        self._layout = layout_of(UNIFORM, STORAGE, STORAGE, STORAGE)
        module = shader_module("methods/raytrace.wgsl")
        self._color = self._pipeline(module, "traced_color", (COLOR_FORMAT,))
        self._seen = self._pipeline(module, "traced_seen", SEEN_FORMATS)
        self._bands: list[_Band] = []
        self._used = 0
        self._eye: tuple[Camera, tuple[float, float]] | None = None
        self._records: tuple[Rectangle, np.ndarray] | None = None

    def _pipeline(
        self, module: wgpu.GPUShaderModule, fragment: str, formats: tuple[str, ...]
    ) -> wgpu.GPURenderPipeline:
        return make_pipeline(
            module,
            "sky_vertex",
            fragment,
            formats,
            buffers=(),
            groups=(self._layout,),
            depth_compare="always",
            depth_write=False,
        )

    def prepare(self, encoder: wgpu.GPUCommandEncoder, camera: Camera, shift: tuple[float, float]) -> None:
        """Trace the rectangle that bounds the specular surfaces, and upload where its paths end."""
        self._used, self._records, self._eye = 0, None, (camera, shift)
        rectangle = specular_rectangle(self._stage.view.scene, camera, self._stage.view.size)
        if rectangle is None:
            return
        x0, y0, x1, y1 = rectangle
        records = self._tracer.trace(camera, self._stage.view.size, rectangle, shift)
        self._records = (rectangle, records)
        width = x1 - x0
        limit = get_device().limits["max-storage-buffer-binding-size"] // RECORD_BYTES
        rows = max(limit // width, 1)
        for top in range(y0, y1, rows):
            bottom = min(top + rows, y1)
            count = (bottom - top) * width
            if self._used == len(self._bands):
                self._bands.append(_Band(count, self._layout, self._stage))
            elif self._bands[self._used].capacity < count:
                # A quarter more than is needed: a moving eye does not bring a new buffer every frame.
                self._bands[self._used] = _Band(min(count + count // 4, limit), self._layout, self._stage)
            start = (top - y0) * width
            self._bands[self._used].write((x0, top, width, bottom - top), records[start : start + count])
            self._used += 1

    def prepare_seen(self, encoder: wgpu.GPUCommandEncoder) -> None:
        """The paths carry all that the seen buffers need."""

    def draw_color(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """The traced pixels."""
        self._draw(render_pass, self._color)

    def draw_seen(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """The traced pixels' seen buffers."""
        self._draw(render_pass, self._seen)

    def _draw(self, render_pass: wgpu.GPURenderPassEncoder, pipeline: wgpu.GPURenderPipeline) -> None:
        render_pass.set_pipeline(pipeline)
        for band in self._bands[: self._used]:
            band.draw(render_pass)

    def rays(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Origins and directions of each pixel's last ray: the eye's own outside the traced rectangle."""
        if self._eye is None:
            return None
        camera, shift = self._eye
        width, height = self._stage.view.size
        x, y = np.meshgrid(np.arange(width) + 0.5 + shift[0], np.arange(height) + 0.5 + shift[1])
        direction = camera.directions(np.stack([x, y], axis=-1), (width, height)).astype(np.float32)
        origin = np.broadcast_to(np.asarray(camera.position, np.float32), direction.shape).copy()
        if self._records is not None:
            (x0, y0, x1, y1), records = self._records
            traced = records.reshape(y1 - y0, x1 - x0, WORDS)
            origin[y0:y1, x0:x1] = traced[..., 0:3]
            direction[y0:y1, x0:x1] = traced[..., 4:7]
        return origin, direction


def open_session(view: View, options: Options) -> Session:
    """Start ray tracing `view`."""
    if options.truth not in ("surface", "raymesh"):
        raise AnamorphError(f"raytrace: truth is {options.truth}; give surface or raymesh")
    if not 1 <= options.bounces <= 255:
        raise AnamorphError(f"raytrace: bounces is {options.bounces}; give a number from 1 to 255")
    stage = Stage(view)
    return DrawingSession(stage, TracedDrawing(stage, options))


METHOD = Method(
    name="raytrace",
    summary="a ray for every pixel, bent at every specular surface: the truth, and the competitor",
    source="Whitted 1980; Embree",
    options=Options,
    open=open_session,
)
