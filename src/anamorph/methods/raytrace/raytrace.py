"""The reference: a ray for every pixel that looks at a specular surface, bent as often as it meets one.

Directly seen pixels are drawn as in every other method; inside the rectangle that bounds the specular surfaces each
pixel is traced by paths.py on the CPU. Where the camera is a ray mesh, all pixels are. It is at once the truth that
the other methods are held against, and the competitor that they must be faster than.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import wgpu

from anamorph.base.errors import AnamorphError
from anamorph.frame import View
from anamorph.gpu.visibility import Rectangle
from anamorph.methods.finding import FindingDrawing
from anamorph.methods.options import check_options, option
from anamorph.methods.protocol import Method
from anamorph.methods.raytrace.pixel_rays import pixel_rays
from anamorph.methods.session import Session
from anamorph.methods.stage import Stage
from anamorph.methods.tracing.launch import FirstRays, GivenRays, eye_rays
from anamorph.methods.tracing.packing import packed
from anamorph.methods.tracing.paths import PathTracer, specular_rectangle
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
    antialias : int
        Samples a pixel: 1 or 4.
    tree : str
        How Embree's tree follows a scene that deforms: "refit", or "rebuild" where what were neighbours part for good.
    """

    truth: str = option("surface", choices=("surface", "raymesh"))
    bounces: int = option(8, low=1, high=255)
    dispersion: bool = True
    antialias: int = option(1, choices=(1, 4))
    tree: str = option("refit", choices=("refit", "rebuild"))


class TracedDrawing(FindingDrawing):
    """Traces every pixel around the specular surfaces."""

    def __init__(self, stage: Stage, options: Options) -> None:
        self._caster = Caster(stage.geometry)
        self._rebuilds = options.tree == "rebuild"
        self._tracer = PathTracer(stage.view.scene, stage.geometry, self._caster, options.bounces, options.truth)
        self._dispersion = options.dispersion and self._tracer.disperses
        super().__init__(stage, 3 if self._dispersion else 1, options.antialias)
        self._first: np.ndarray | None = None
        self._records: np.ndarray | None = None

    def deformed(self, geometry: Geometry) -> None:
        """Refit or rebuild the tree."""
        self._caster.moved(geometry.positions, self._rebuilds)
        self._tracer.moved(geometry)

    def prepare(
        self, encoder: wgpu.GPUCommandEncoder, camera: Camera | RayMesh, shift: tuple[float, float]
    ) -> Generator[None, None, wgpu.GPUCommandEncoder]:
        """Trace the pixels around the specular surfaces, or all of a ray mesh's, and upload where their paths end."""
        looked, self.looked = self.looked, (camera, shift)
        self.visibility.show(None)
        side, size = self.visibility.side, self.visibility.size
        shift = side * shift[0], side * shift[1]
        rectangle: Rectangle | None
        if isinstance(camera, RayMesh):
            rectangle = 0, 0, *size
            if self._first is None or looked is None or looked[0] is not camera or looked[1] != shift:
                fine = replace(camera, image=camera.image * [side, side, 1.0])
                self._first = pixel_rays(fine, size, shift, self._first)
            first: FirstRays = GivenRays(*self._first)
        else:
            seen = specular_rectangle(self.stage.view.scene, camera, self.stage.view.size)
            if seen is None:
                return encoder
            rectangle = side * seen[0], side * seen[1], side * seen[2], side * seen[3]
            first = eye_rays(camera, size, rectangle, shift)
        self._records = records = yield from self._tracer.tracing(first, self._records)
        lines = [packed(records)]
        if self._dispersion:
            colors = yield from self._tracer.tracing_colors(first, records)
            for line in colors:
                texels = np.zeros_like(lines[0])
                texels[:, records.view(np.uint32)[:, 14] > 0] = packed(line)
                lines.append(texels)
        x0, y0, x1, y1 = rectangle
        for number, texels in enumerate(lines):
            self.visibility.write(rectangle, texels.reshape(2, y1 - y0, x1 - x0, 4), number)
        self.visibility.show((x0 // side, y0 // side, x1 // side, y1 // side), len(lines))
        return encoder


def open_session(view: View, options: Options) -> Session:
    """Start ray tracing `view`."""
    check_options("raytrace", options)
    if options.truth == "raymesh" and isinstance(view.camera, RayMesh):
        raise AnamorphError("raytrace: truth=raymesh is for mirrors and lenses that a pinhole sees; give truth=surface")
    stage = Stage(view)
    middles = partial(open_session, view, replace(options, antialias=1))
    return Session(stage, TracedDrawing(stage, options), options.antialias, middles)


METHOD = Method(
    name="raytrace",
    summary="a ray for every pixel, bent at every specular surface: the reference, and the competitor",
    source="Whitted 1980; Embree",
    options=Options,
    open=open_session,
    refracts=True,
    ray_meshes=True,
)
