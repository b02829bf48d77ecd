"""The session that all methods share: the scene drawn from the eye, and the method's own drawing of specular meshes."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from time import perf_counter
from typing import Any

import numpy as np
import wgpu

from anamorph.base.steps import drain, timed
from anamorph.frame import Frame, Status
from anamorph.gpu.device import get_device
from anamorph.gpu.drawing import ScenePipelines, bind_scene, draw_depth, draw_scene, scene_pipelines, submit
from anamorph.gpu.targets import (
    COLOR_FORMAT,
    SEEN_FORMATS,
    Target,
    begin_depth_pass,
    begin_pass,
    make_target,
    read_texture,
)
from anamorph.methods.specular_drawing import SpecularDrawing
from anamorph.methods.stage import Stage
from anamorph.raymesh import RayMesh
from anamorph.scene.camera import Camera


class Session:
    """One scene, size and set of options, ready to draw: everything that can be made once has been.

    Parameters
    ----------
    stage : Stage
    drawing : SpecularDrawing
        Draws the specular meshes.
    antialias : int
        Samples a pixel: 1 or 4.
    middles : callable, optional
        Opens the same with one sample a pixel, in its middle: the seen buffers of an antialiased image are from there.
    """

    def __init__(
        self,
        stage: Stage,
        drawing: SpecularDrawing,
        antialias: int = 1,
        middles: Callable[[], Session] | None = None,
    ) -> None:
        self._stage = stage
        self._drawing = drawing
        self._target = make_target(stage.view.size, (COLOR_FORMAT,), antialias)
        self._pipelines = scene_pipelines("color", antialias, sky_image=stage.buffers.sky_image)
        self._phases: dict[str, float] = {}
        self._open_middles = middles if antialias > 1 else None
        self._middles: Session | None = None
        self._looked: tuple[Camera | RayMesh, tuple[float, float]] | None = None
        self._deformed: tuple[np.ndarray, np.ndarray] | None = None

    @property
    def texture(self) -> wgpu.GPUTexture:
        """Where frames are drawn, on the device: linear, rgba16float, the last one in it."""
        return self._target.textures[0]

    def draw(self, camera: Camera | RayMesh, shift: tuple[float, float] = (0.0, 0.0)) -> None:
        """Submit one frame at once; see `drawing`."""
        drain(self.drawing(camera, shift))

    def drawing(self, camera: Camera | RayMesh, shift: tuple[float, float] = (0.0, 0.0)) -> Generator[None, None, None]:
        """Submit one frame in steps of a few milliseconds.

        Until it ends, the texture holds the frame before. It may be closed at any step, and the next frame is drawn as
        if it had never begun; nothing else may be asked of the session meanwhile.

        Parameters
        ----------
        camera : Camera or RayMesh
            Of the kind that the session was opened with.
        shift : (right, down)
            Moves the sample points, in pixels.
        """
        stage, began = self._stage, perf_counter()
        self._looked = camera, shift
        camera = stage.local(camera)
        stage.look(camera, shift)
        encoder = stage.recorder.begin()
        steps = self._drawing.prepare(encoder, camera, shift)
        preparing = perf_counter() - began
        if steps is not None:
            encoder, seconds = yield from timed(steps)
            preparing += seconds
        prepared = perf_counter()
        self._draw_depth(encoder, self._target, self._pipelines)
        looked = perf_counter()
        steps = self._drawing.find(encoder, self._target, camera, shift)
        finding = perf_counter() - looked
        if steps is not None:
            encoder, seconds = yield from timed(steps)
            finding += seconds
        found = perf_counter()
        self._draw(encoder, self._target, self._pipelines, self._drawing.draw_color)
        stage.recorder.submit(encoder)
        spent = {"prepare": preparing, "find": finding, "record": looked - prepared + perf_counter() - found}
        self._phases |= {phase: 1000.0 * seconds for phase, seconds in spent.items()}

    def phases(self) -> Mapping[str, float]:
        """Where a frame's time goes, milliseconds by phase; empty before the first frame.

        Of the last draw, on the processor: "prepare" (rays, and maps planned), "find" (what is looked for once the
        scene has its depth: what is doubtful is traced, and the device is waited for before) and "record" (passes
        recorded and submitted). Beside them "device": what the device needed for the last frame that was waited for,
        where it tells.
        """
        return dict(self._phases)

    def _draw_depth(self, encoder: wgpu.GPUCommandEncoder, target: Target, pipelines: ScenePipelines) -> None:
        depth_pass = begin_depth_pass(encoder, target)
        if self._stage.has_pinhole:
            draw_depth(depth_pass, pipelines, self._stage.buffers, self._stage.projection)
        depth_pass.end()

    def _draw(
        self,
        encoder: wgpu.GPUCommandEncoder,
        target: Target,
        pipelines: ScenePipelines,
        draw_specular: Callable[[wgpu.GPURenderPassEncoder], None],
    ) -> None:
        buffers, projection, pinhole = self._stage.buffers, self._stage.projection, self._stage.has_pinhole
        render_pass = begin_pass(encoder, target, keep_depth=True)
        # What stands behind a mirror need not be shaded: the mirror comes first.
        bind_scene(render_pass, buffers, projection)
        draw_specular(render_pass)
        if pinhole:
            draw_scene(render_pass, pipelines, buffers, projection, self._drawing.replaced)
        render_pass.end()

    def deform(self, positions: np.ndarray, normals: np.ndarray) -> None:
        """Move the scene's vertices, for every frame to come; `positions` and `normals` are (V, 3) float32.

        They are numbered as `scene.geometry.flatten` does, and the triangles between them stay. Specular meshes stay
        where they are, because their exact surfaces do.
        """
        self._stage.deform(positions, normals)
        self._drawing.deformed(self._stage.geometry)
        self._deformed = positions, normals
        if self._middles is not None:
            self._middles.deform(positions, normals)

    def wait(self) -> None:
        """Return when every submitted frame is finished on the device."""
        milliseconds = self._stage.recorder.wait()
        if milliseconds is not None:
            self._phases["device"] = milliseconds

    def diagnostics(self) -> Mapping[str, Any]:
        """What the session holds, by name, for tests and for whoever looks for a fault."""
        return {"buffers": self._stage.buffers, **self._drawing.diagnostics()}

    def color(self) -> np.ndarray:
        """Read the last frame's colour back, (H, W, 3) float32."""
        return read_texture(self.texture)[..., :3].astype(np.float32)

    def frame(self, seen: bool = False, color: np.ndarray | None = None) -> Frame:
        """Read the last frame back; its seen buffers, if asked for, are drawn in passes of their own.

        A `color` that has been read already, or is the mean of several frames, is taken and not read again.
        """
        color = self.color() if color is None else color
        if not seen:
            return Frame(color, ray_mesh=not self._stage.has_pinhole)
        if self._open_middles is not None and self._looked is not None:
            return self._middle_session().frame(seen=True, color=color)
        stage = self._stage
        target = make_target(stage.view.size, SEEN_FORMATS)
        encoder = get_device().create_command_encoder()
        self._drawing.prepare_seen(encoder)
        self._draw_depth(encoder, target, scene_pipelines("seen"))
        self._draw(encoder, target, scene_pipelines("seen"), self._drawing.draw_seen)
        submit(encoder)
        point, flags, deviation = (read_texture(texture) for texture in target.textures)
        # What nothing has drawn: even the sky leaves its status.
        blank = (flags == 0) & (point[..., 3] == 0.0)
        object_id, position = point[..., 3].astype(np.uint32), np.ascontiguousarray(point[..., :3])
        origin, direction = self._drawing.rays() or (None, None)
        if stage.origin.any():
            position = position + np.where(object_id[..., None] > 0, stage.origin, 0.0)
            origin = None if origin is None else origin + stage.origin
        return Frame(
            color=color,
            position=position,
            object_id=object_id,
            specular=flags & 0xFFFF,
            status=np.where(blank, Status.OUTSIDE, flags >> 16).astype(np.uint8),
            deviation=deviation,
            ray_origin=origin,
            ray_direction=direction,
            ray_mesh=not stage.has_pinhole,
            figures=self._drawing.figures(),
        )

    def _middle_session(self) -> Session:
        """The session with one sample a pixel, with the last frame drawn."""
        assert self._open_middles is not None and self._looked is not None
        if self._middles is None:
            self._middles = self._open_middles()
            if self._deformed is not None:
                self._middles.deform(*self._deformed)
        self._middles.draw(*self._looked)
        return self._middles
