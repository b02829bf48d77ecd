"""The reference: a ray for every pixel that looks at a specular surface, bent as often as it meets one.

Directly seen pixels are drawn as in every other method; inside the rectangle that bounds the specular surfaces each
pixel is traced by paths.py on the CPU. Where the camera is a ray mesh, all pixels are. It is at once the truth that
the other methods are held against, and the competitor that they must be faster than.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import wgpu

from anamorph.base.errors import AnamorphError
from anamorph.frame import View
from anamorph.methods.options import check_options, option
from anamorph.methods.protocol import Method
from anamorph.methods.raytrace.pixel_rays import pixel_rays
from anamorph.methods.session import Session
from anamorph.methods.specular_drawing import SpecularDrawing
from anamorph.methods.stage import Stage
from anamorph.methods.tracing.bounces import WORDS
from anamorph.methods.tracing.launch import FirstRays, GivenRays, Rectangle, eye_rays
from anamorph.methods.tracing.paths import PathTracer, specular_rectangle
from anamorph.methods.tracing.tiles import Tiles, tiles_at_once
from anamorph.raymesh import RayMesh
from anamorph.rays.caster import Caster
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import Geometry


@dataclass(frozen=True)
class Options:
    """Options of `raytrace`.

    Parameters
    ----------
    truth : str
        "surface": rays bend at the exact surface, or for a plain mesh at its interpolated normal. "raymesh": the
        vertex rays of a mirror's or a lens's ray mesh are interpolated; not with a ray mesh as the camera.
    bounces : int
        How many specular interfaces a path may meet: a mirror is one, a lens is two.
    dispersion : bool
        Whether red and blue light goes its own way through glass that has an Abbe number. Seen buffers are green's.
    tree : str
        How Embree's tree follows a scene that deforms: "refit", or "rebuild" where what were neighbours part for good.
    """

    truth: str = option("surface", choices=("surface", "raymesh"))
    bounces: int = option(8, low=1, high=255)
    dispersion: bool = True
    tree: str = option("refit", choices=("refit", "rebuild"))


class TracedDrawing(SpecularDrawing):
    """Replaces every pixel around the specular surfaces by a traced one."""

    def __init__(self, stage: Stage, options: Options) -> None:
        super().__init__(stage)
        self._dispersion = options.dispersion
        self._caster = Caster(stage.geometry)
        self._rebuilds = options.tree == "rebuild"
        self._tracer = PathTracer(stage.view.scene, stage.geometry, self._caster, options.bounces, options.truth)
        self._bands: list[Tiles] = []
        self._used = 0
        self._looked: tuple[Camera | RayMesh, tuple[float, float]] | None = None
        self._first: np.ndarray | None = None
        self._reused: np.ndarray | None = None
        self._records: tuple[Rectangle, np.ndarray] | None = None

    def deformed(self, geometry: Geometry) -> None:
        """Refit or rebuild the tree."""
        self._caster.moved(geometry.positions, self._rebuilds)
        self._tracer.moved(geometry)

    def prepare(
        self, encoder: wgpu.GPUCommandEncoder, camera: Camera | RayMesh, shift: tuple[float, float]
    ) -> Generator[None, None, wgpu.GPUCommandEncoder]:
        """Trace the pixels around the specular surfaces, or all of a ray mesh's, and upload where their paths end."""
        looked, self._looked = self._looked, (camera, shift)
        self._used, self._records = 0, None
        size = self.stage.view.size
        rectangle: Rectangle | None
        if isinstance(camera, RayMesh):
            rectangle = 0, 0, *size
            if self._first is None or looked is None or looked[0] is not camera or looked[1] != shift:
                self._first = pixel_rays(camera, size, shift, self._first)
            first: FirstRays = GivenRays(*self._first)
        else:
            rectangle = specular_rectangle(self.stage.view.scene, camera, size)
            if rectangle is None:
                return encoder
            first = eye_rays(camera, size, rectangle, shift)
        records = yield from self._tracer.tracing(first, self._reused)
        yield from self._write(rectangle, first, records)
        return encoder

    def _write(self, rectangle: Rectangle, first: FirstRays, records: np.ndarray) -> Generator[None, None, None]:
        """Upload the records of a rectangle, in bands of as many rows as a buffer holds."""
        self._records, self._reused = (rectangle, records), records
        x0, y0, x1, y1 = rectangle
        width = x1 - x0
        rows = tiles_at_once(width)
        for top in range(y0, y1, rows):
            bottom = min(top + rows, y1)
            if self._used == len(self._bands):
                self._bands.append(Tiles(self.stage.buffers))
            own = slice((top - y0) * width, (bottom - y0) * width)
            corner, tile, part = np.array([[x0, top]]), (width, bottom - top), records[own]
            colors = (yield from self._tracer.tracing_colors(first, part, own.start)) if self._dispersion else None
            self._bands[self._used].write(corner, tile, part, colors)
            self._used += 1

    def draw_color(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """The traced pixels."""
        for band in self._bands[: self._used]:
            band.draw_color(render_pass)

    def draw_seen(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """The traced pixels' seen buffers."""
        for band in self._bands[: self._used]:
            band.draw_seen(render_pass)

    def rays(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Origins and directions of each pixel's last ray: the eye's own outside the traced rectangle."""
        if self._looked is None:
            return None
        camera, shift = self._looked
        width, height = self.stage.view.size
        origin, direction = np.zeros((2, height, width, 3), np.float32)
        if isinstance(camera, Camera):
            direction[:] = camera.pixel_directions((width, height), shift)
            origin[:] = camera.position
        if self._records is not None:
            (x0, y0, x1, y1), records = self._records
            traced = records.reshape(y1 - y0, x1 - x0, WORDS)
            origin[y0:y1, x0:x1] = traced[..., 0:3]
            direction[y0:y1, x0:x1] = traced[..., 4:7]
        return origin, direction

    def diagnostics(self) -> Mapping[str, Any]:
        """The bands of traced rows, on the device, of the last frame."""
        return {"bands": self._bands[: self._used]}


def open_session(view: View, options: Options) -> Session:
    """Start ray tracing `view`."""
    check_options("raytrace", options)
    if options.truth == "raymesh" and isinstance(view.camera, RayMesh):
        raise AnamorphError("raytrace: truth=raymesh is for mirrors and lenses that a pinhole sees; give truth=surface")
    stage = Stage(view)
    return Session(stage, TracedDrawing(stage, options))


METHOD = Method(
    name="raytrace",
    summary="a ray for every pixel, bent at every specular surface: the reference, and the competitor",
    source="Whitted 1980; Embree",
    options=Options,
    open=open_session,
    refracts=True,
    ray_meshes=True,
)
