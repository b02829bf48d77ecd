"""The session that all methods share: the scene drawn from the eye, and the method's own drawing of specular meshes."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from time import perf_counter
from typing import Any, Protocol

import numpy as np
import wgpu

from anamorph.base.errors import AnamorphError
from anamorph.base.steps import drain, timed
from anamorph.frame import Frame, Status, View
from anamorph.gpu.buffers import SceneBuffers, pack_vertices, upload_scene, upload_vertices
from anamorph.gpu.device import get_device, maximum_size
from anamorph.gpu.drawing import (
    ProjectionUniform,
    ScenePipelines,
    bind_scene,
    color_pipelines,
    draw_depth,
    draw_scene,
    projection_uniform,
    seen_pipelines,
    submit,
)
from anamorph.gpu.recording import Recorder
from anamorph.gpu.targets import (
    COLOR_FORMAT,
    SEEN_FORMATS,
    Target,
    begin_depth_pass,
    begin_pass,
    make_target,
    read_texture,
)
from anamorph.projection import camera_projection
from anamorph.raymesh import RayMesh
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import Geometry, flatten


class SpecularDrawing(Protocol):
    """How one method draws the specular meshes of a scene, or all that a ray mesh sees of it.

    A `camera` is a pinhole or a ray mesh as the stage's is: methods that take no ray meshes never see one.
    """

    @property
    def replaced(self) -> tuple[int, ...]:
        """Indices of the meshes that this drawing draws itself, known once the frame is prepared."""
        ...

    def deformed(self, geometry: Geometry) -> None:
        """Take notice that vertices have moved: they are where `geometry` says, and so on the device."""
        ...

    def prepare(
        self, encoder: wgpu.GPUCommandEncoder, camera: Any, shift: tuple[float, float]
    ) -> Generator[None, None, wgpu.GPUCommandEncoder] | None:
        """Record whatever must be drawn or uploaded before the picture: maps, texture coordinates, hits.

        Where that may take long it is a generator, which yields every few milliseconds and returns the encoder to go
        on with: see `Recorder.part`. It may be closed at any step; the next frame then begins anew.
        """
        ...

    def draw_color(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """Draw into the picture before the scene, which is hidden behind it; shading and projection are bound."""
        ...

    def complete(self, target: Target, camera: Any, shift: tuple[float, float]) -> None:
        """Mend the picture in `target` where the method itself knows that it must; most methods know nothing."""
        ...

    def prepare_seen(self, encoder: wgpu.GPUCommandEncoder) -> None:
        """Record what the seen buffers need beyond `prepare`."""
        ...

    def draw_seen(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """Draw into the seen buffers."""
        ...

    def rays(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Origins and directions, (H, W, 3), of each pixel's last ray, where the method has them."""
        ...

    def figures(self) -> dict[str, float]:
        """What the method tells of how it drew the last frame, by name; names of shares end in "_percent"."""
        ...


class Stage:
    """What a method draws on: the scene on the device and the eye's projection.

    Attributes
    ----------
    recorder : Recorder
    pinhole : bool
        Whether the camera is one. If it is a ray mesh, only the picture's size in the projection means something, and
        the session leaves all drawing to the method.
    """

    def __init__(self, view: View) -> None:
        sides = view.size if isinstance(view.size, Sequence | np.ndarray) else ()
        if len(sides) != 2 or not all(isinstance(side, int | np.integer) for side in sides):
            raise AnamorphError(f"size is {view.size}; give two whole numbers of pixels, like (1024, 768)")
        if min(view.size) < 1 or max(view.size) > maximum_size():
            width, height = view.size
            raise AnamorphError(f"size {width}x{height}: give a width and height from 1 to {maximum_size()}")
        self.view = view
        self.recorder = Recorder()
        self.pinhole = not isinstance(view.camera, RayMesh)
        self.geometry: Geometry = flatten(view.scene)
        self.buffers: SceneBuffers = upload_scene(view.scene, self.geometry)
        self.projection: ProjectionUniform = projection_uniform()

    def look(self, camera: Camera | RayMesh, shift: tuple[float, float]) -> None:
        """Set the projection."""
        if isinstance(camera, RayMesh) is self.pinhole:
            raise AnamorphError("camera: is of another kind than the session was opened with; open one for it")
        eye = self.view.scene.camera if isinstance(camera, RayMesh) else camera
        self.projection.write(camera_projection(eye, self.view.size, shift), self.view.size)

    @cached_property
    def _vertices(self) -> np.ndarray:
        return pack_vertices(self.geometry)

    def deform(self, positions: np.ndarray, normals: np.ndarray) -> None:
        """Move the vertices, here and on the device. See `Session.deform`."""
        self.geometry = replace(
            self.geometry,
            positions=self._checked("positions", positions, self.geometry.positions),
            normals=self._checked("normals", normals, self.geometry.normals),
        )
        self._vertices["position"], self._vertices["normal"] = self.geometry.positions, self.geometry.normals
        upload_vertices(self.buffers, self._vertices)

    def _checked(self, name: str, given: np.ndarray, before: np.ndarray) -> np.ndarray:
        values = np.array(given, np.float32, order="C")
        if values.shape != before.shape:
            raise AnamorphError(f"deform: {name} have the shape {values.shape}; give {before.shape}")
        if not np.isfinite(values).all():
            raise AnamorphError(f"deform: {name} are not all finite; give numbers")
        for index in self.buffers.specular:
            own = slice(*self.geometry.first_vertex[index : index + 2])
            if not np.array_equal(values[own], before[own]):
                mesh = self.view.scene.meshes[index].name
                raise AnamorphError(f"deform: {name} of {mesh!r} differ, which is specular; leave its vertices alone")
        return values


class DrawingSession:
    """Draws the scene and, through a `SpecularDrawing`, its specular meshes. See `Session`."""

    def __init__(self, stage: Stage, drawing: SpecularDrawing, antialias: int = 1) -> None:
        self._stage = stage
        self._drawing = drawing
        self._target = make_target(stage.view.size, (COLOR_FORMAT,), antialias)
        self._pipelines = color_pipelines(antialias, sky_image=stage.buffers.sky_image)
        self._phases: dict[str, float] = {}

    @property
    def texture(self) -> wgpu.GPUTexture:
        """Where frames are drawn."""
        return self._target.textures[0]

    def draw(self, camera: Camera | RayMesh, shift: tuple[float, float] = (0.0, 0.0)) -> None:
        """Submit one frame."""
        drain(self.drawing(camera, shift))

    def drawing(self, camera: Camera | RayMesh, shift: tuple[float, float] = (0.0, 0.0)) -> Generator[None, None, None]:
        """Submit one frame in steps. See `Stepwise`."""
        stage, began = self._stage, perf_counter()
        stage.look(camera, shift)
        encoder = stage.recorder.begin()
        steps = self._drawing.prepare(encoder, camera, shift)
        preparing = perf_counter() - began
        if steps is not None:
            encoder, seconds = yield from timed(steps)
            preparing += seconds
        prepared = perf_counter()
        self._draw(encoder, self._target, self._pipelines, self._drawing.draw_color)
        stage.recorder.submit(encoder)
        recorded = perf_counter()
        self._drawing.complete(self._target, camera, shift)
        spent = {"prepare": preparing, "record": recorded - prepared, "mend": perf_counter() - recorded}
        self._phases |= {phase: 1000.0 * seconds for phase, seconds in spent.items()}

    def phases(self) -> Mapping[str, float]:
        """Where a frame's time goes."""
        return dict(self._phases)

    def _draw(
        self,
        encoder: wgpu.GPUCommandEncoder,
        target: Target,
        pipelines: ScenePipelines,
        draw_specular: Callable[[wgpu.GPURenderPassEncoder], None],
    ) -> None:
        buffers, projection, pinhole = self._stage.buffers, self._stage.projection, self._stage.pinhole
        depth_pass = begin_depth_pass(encoder, target)
        if pinhole:
            draw_depth(depth_pass, pipelines, buffers, projection)
        depth_pass.end()
        render_pass = begin_pass(encoder, target, keep_depth=True)
        # What stands behind a mirror need not be shaded: the mirror comes first.
        bind_scene(render_pass, buffers, projection)
        draw_specular(render_pass)
        if pinhole:
            draw_scene(render_pass, pipelines, buffers, projection, self._drawing.replaced)
        render_pass.end()

    def deform(self, positions: np.ndarray, normals: np.ndarray) -> None:
        """Move the scene's vertices."""
        self._stage.deform(positions, normals)
        self._drawing.deformed(self._stage.geometry)

    def wait(self) -> None:
        """Return when every submitted frame is finished."""
        milliseconds = self._stage.recorder.wait()
        if milliseconds is not None:
            self._phases["device"] = milliseconds

    def frame(self, seen: bool = False) -> Frame:
        """Read the last frame back."""
        color = read_texture(self._target.textures[0])[..., :3].astype(np.float32)
        if not seen:
            return Frame(color, ray_mesh=not self._stage.pinhole)
        stage = self._stage
        target = make_target(stage.view.size, SEEN_FORMATS)
        encoder = get_device().create_command_encoder()
        self._drawing.prepare_seen(encoder)
        self._draw(encoder, target, seen_pipelines(), self._drawing.draw_seen)
        submit(encoder)
        point, flags, deviation = (read_texture(texture) for texture in target.textures)
        # What nothing has drawn: even the sky leaves its status.
        blank = (flags == 0) & (point[..., 3] == 0.0)
        origin, direction = self._drawing.rays() or (None, None)
        return Frame(
            color=color,
            position=np.ascontiguousarray(point[..., :3]),
            object_id=point[..., 3].astype(np.uint32),
            specular=flags & 0xFFFF,
            status=np.where(blank, Status.OUTSIDE, flags >> 16).astype(np.uint8),
            deviation=deviation,
            ray_origin=origin,
            ray_direction=direction,
            ray_mesh=not stage.pinhole,
            figures=self._drawing.figures(),
        )
