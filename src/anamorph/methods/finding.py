"""What most methods are: they find what each pixel of a specular surface sees, and the visibility buffer shows it."""

from __future__ import annotations

import numpy as np
import wgpu

from anamorph.gpu.drawing import ProjectionUniform, draw_depth, scene_pipelines
from anamorph.gpu.targets import Target, begin_depth_pass, make_target
from anamorph.gpu.visibility import VisibilityBuffer
from anamorph.methods.specular_drawing import SpecularDrawing
from anamorph.methods.stage import Stage
from anamorph.projection import camera_projection
from anamorph.raymesh import RayMesh
from anamorph.scene.camera import Camera


class FindingDrawing(SpecularDrawing):
    """Draws what `prepare` has put into the visibility buffer.

    Attributes
    ----------
    visibility : VisibilityBuffer
    projection : ProjectionUniform
        The eye's, for an image whose pixels are samples.
    looked : tuple of Camera or RayMesh, and (right, down), or None
        What `prepare` was asked for last.
    """

    def __init__(self, stage: Stage, lines: int = 1, antialias: int = 1) -> None:
        super().__init__(stage)
        self.visibility = VisibilityBuffer(stage.buffers, stage.view.size, lines, antialias, not stage.has_pinhole)
        self._fine: Target | None = None
        self.projection = stage.projection
        if antialias > 1:
            self._fine = make_target(self.visibility.size, ())
            self.projection = ProjectionUniform()
        self.looked: tuple[Camera | RayMesh, tuple[float, float]] | None = None

    def look(self, camera: Camera, shift: tuple[float, float]) -> None:
        """Remember what is looked at, and from where."""
        self.looked = camera, shift
        if self._fine is not None:
            size = self.visibility.size
            self.projection.write(camera_projection(camera, self.stage.view.size, shift), size)

    def depth_of(self, encoder: wgpu.GPUCommandEncoder, target: Target) -> wgpu.GPUTextureView:
        """The depth of the diffuse meshes at every sample: that of `target`, or drawn here where it has fewer."""
        if self._fine is None:
            return target.depth
        depth_pass = begin_depth_pass(encoder, self._fine)
        draw_depth(depth_pass, scene_pipelines("color"), self.stage.buffers, self.projection)
        depth_pass.end()
        return self._fine.depth

    def draw_color(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """What was found, shaded."""
        self.visibility.draw_color(render_pass)

    def draw_seen(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """What was found."""
        self.visibility.draw_seen(render_pass)

    def rays(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Origins and directions of each pixel's last ray: the eye's own where nothing specular was looked at."""
        if self.looked is None:
            return None
        camera, shift = self.looked
        width, height = self.stage.view.size
        origin, direction = np.zeros((2, height, width, 3), np.float32)
        if isinstance(camera, Camera):
            direction[:] = camera.pixel_directions((width, height), shift)
            origin[:] = camera.position
        if self.visibility.rectangle is not None:
            x0, y0, x1, y1 = self.visibility.rectangle
            found, origins, directions = self.visibility.rays()
            origin[y0:y1, x0:x1][found] = origins[found]
            direction[y0:y1, x0:x1][found] = directions[found]
        return origin, direction
