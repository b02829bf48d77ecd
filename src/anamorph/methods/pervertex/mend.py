"""Mending an image: the tiles in which a method doubts a pixel are traced."""

from __future__ import annotations

import numpy as np
import wgpu

from anamorph.base.steps import drain
from anamorph.gpu.device import get_device
from anamorph.gpu.drawing import ProjectionUniform, bind_scene, submit
from anamorph.gpu.targets import Target, begin_pass
from anamorph.methods.stage import Stage
from anamorph.methods.tracing.launch import EyeRays
from anamorph.methods.tracing.paths import PathTracer
from anamorph.methods.tracing.tiles import Tiles, tiles_at_once
from anamorph.rays.caster import Caster
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import Geometry

TILE = (4, 4)
"""Columns and rows of a traced tile: pixels beside each other share their footprints."""


def doubtful_tiles(errors: np.ndarray, tolerance: float) -> np.ndarray:
    """Corners (T, 2), column and row, of the tiles in which some of `errors` (H, W) exceeds `tolerance`."""
    columns, rows = TILE
    height, width = errors.shape
    padded = np.pad(errors > tolerance, ((0, -height % rows), (0, -width % columns)))
    doubtful = padded.reshape(padded.shape[0] // rows, rows, -1, columns).any(axis=(1, 3))
    row, column = np.nonzero(doubtful)
    return np.stack([column * columns, row * rows], axis=1)


class Mender:
    """Traces the doubtful tiles of a stage's image and draws them over it."""

    def __init__(self, stage: Stage, caster: Caster) -> None:
        self._stage = stage
        self._tracer = PathTracer(stage.view.scene, stage.geometry, caster)
        self._batches: list[Tiles] = []
        self._used = 0

    def moved(self, geometry: Geometry) -> None:
        """Follow the scene's vertices; the caster has followed already."""
        self._tracer.moved(geometry)

    def trace(self, corners: np.ndarray, camera: Camera, shift: tuple[float, float]) -> None:
        """Trace the tiles at `corners`, and upload where their paths end."""
        self._used = 0
        at_once = tiles_at_once(TILE[0] * TILE[1])
        for first in range(0, len(corners), at_once):
            if self._used == len(self._batches):
                self._batches.append(Tiles(self._stage.buffers))
            part = corners[first : first + at_once]
            rays = EyeRays(camera, self._stage.view.size, part, TILE, shift)
            records = drain(self._tracer.tracing(rays))
            colors = drain(self._tracer.tracing_colors(rays, records))
            self._batches[self._used].write(part, TILE, records, colors)
            self._used += 1

    def draw_over(self, target: Target, projection: ProjectionUniform) -> None:
        """Draw the traced tiles over the image in `target`."""
        encoder = get_device().create_command_encoder()
        render_pass = begin_pass(encoder, target, clear=False)
        bind_scene(render_pass, self._stage.buffers, projection)
        for batch in self._batches[: self._used]:
            batch.draw_color(render_pass)
        render_pass.end()
        submit(encoder)

    def draw_seen(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """The traced tiles' part of the seen buffers."""
        for batch in self._batches[: self._used]:
            batch.draw_seen(render_pass)
