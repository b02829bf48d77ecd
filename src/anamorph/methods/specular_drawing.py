"""What a method draws of a frame: the specular meshes of a scene, or all that a ray mesh sees of it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Generator, Mapping
from typing import Any

import numpy as np
import wgpu

from anamorph.gpu.targets import Target
from anamorph.methods.stage import Stage
from anamorph.scene.geometry import Geometry


class SpecularDrawing(ABC):
    """How one method draws the specular meshes; the session draws the rest.

    Three functions make a method: `prepare`, `draw_color` and `draw_seen`. What else is here has a default. A `camera`
    is a pinhole or a ray mesh as the stage's is: methods that take no ray meshes never see one.
    """

    def __init__(self, stage: Stage) -> None:
        self.stage = stage

    def prepare(
        self, encoder: wgpu.GPUCommandEncoder, camera: Any, shift: tuple[float, float]
    ) -> Generator[None, None, wgpu.GPUCommandEncoder] | None:
        """Record whatever must be drawn or uploaded before the image: maps, texture coordinates, hits.

        Where that may take long it is a generator, which yields every few milliseconds and returns the encoder to go
        on with: see `Recorder.part`. It may be closed at any step; the next frame then begins anew.
        """
        return None

    def find(
        self, encoder: wgpu.GPUCommandEncoder, target: Target, camera: Any, shift: tuple[float, float]
    ) -> Generator[None, None, wgpu.GPUCommandEncoder] | None:
        """Record what needs the depth of the diffuse meshes, which `target` has by now; in steps, as `prepare`."""
        return None

    @abstractmethod
    def draw_color(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """Draw into the image before the scene, which is hidden behind it; shading and projection are bound."""

    @abstractmethod
    def draw_seen(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """Draw into the seen buffers."""

    @property
    def replaced(self) -> tuple[int, ...]:
        """Indices of the meshes that this drawing draws itself, known once the frame is prepared."""
        return self.stage.buffers.specular

    def deformed(self, geometry: Geometry) -> None:
        """Take notice that vertices have moved: they are where `geometry` says, and so on the device."""
        return

    def prepare_seen(self, encoder: wgpu.GPUCommandEncoder) -> None:
        """Record what the seen buffers need beyond `prepare`."""
        return

    def rays(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Origins and directions, (H, W, 3), of each pixel's last ray, where the method has them."""
        return None

    def figures(self) -> dict[str, float]:
        """What the method tells of how it drew the last frame, by name; names of shares end in "_percent"."""
        return {}

    def diagnostics(self) -> Mapping[str, Any]:
        """What the drawing holds, by name, for tests and for whoever looks for a fault."""
        return {}
