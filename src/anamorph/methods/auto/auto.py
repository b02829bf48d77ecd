"""Half a pixel, the cheapest way: each frame is searched in maps of surfaces or traced, by what that costs.

What is doubtful in a map is traced in any case. A ray mesh as the camera is traced.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
import wgpu

from anamorph.frame import View
from anamorph.gpu.targets import Target
from anamorph.methods.auto.costs import Costs, Expected, costs_here
from anamorph.methods.options import check_options, option
from anamorph.methods.pervertex import Options as SearchOptions
from anamorph.methods.pervertex import SurfaceDrawing, is_bent_in
from anamorph.methods.protocol import Method
from anamorph.methods.raytrace import Options as TraceOptions
from anamorph.methods.raytrace import TracedDrawing
from anamorph.methods.session import Session
from anamorph.methods.specular_drawing import SpecularDrawing
from anamorph.methods.stage import Stage
from anamorph.optics.ray_meshes import Side, bodies_of, rays_of
from anamorph.optics.viewpoint import virtual_viewpoint
from anamorph.raymesh import RayMesh, RayStatus
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import Geometry
from anamorph.scene.model import Glass

BENT_IN_PATCHES = 6
"""Into which a body that may see itself is divided, about."""


@dataclass(frozen=True)
class Options:
    """Options of `auto`.

    Parameters
    ----------
    tolerance : float
        Pixels: what may be further off than this is traced.
    antialias : int
        Samples a pixel: 1 or 4.
    """

    tolerance: float = option(0.5, low=1e-3, unit="pixels")
    antialias: int = option(1, choices=(1, 4))


class AutoDrawing(SpecularDrawing):
    """Has each frame drawn by one of two others, which are made when they are first needed."""

    def __init__(self, stage: Stage, options: Options, costs: Costs | None) -> None:
        super().__init__(stage)
        self._options, self._costs = options, costs
        scene = stage.view.scene
        # Glass that no lens is made of can be traced, and not searched.
        lenses_only = all(not isinstance(mesh.material, Glass) or mesh.surface is not None for mesh in scene.meshes)
        self._bodies = bodies_of(scene, stage.geometry) if stage.has_pinhole and lenses_only else ()
        self._bent_in = {body: any(map(is_bent_in, body.sides)) for body in self._bodies}
        self._drawing: SpecularDrawing = self._tracing if not self._bodies else self._searching

    @cached_property
    def _searching(self) -> SurfaceDrawing:
        options = self._options
        return SurfaceDrawing(self.stage, SearchOptions(tolerance=options.tolerance, antialias=options.antialias))

    @cached_property
    def _tracing(self) -> TracedDrawing:
        return TracedDrawing(self.stage, TraceOptions(antialias=self._options.antialias))

    @property
    def _made(self) -> list[SpecularDrawing]:
        return [drawing for name, drawing in vars(self).items() if name in ("_searching", "_tracing")]

    def expected(self, camera: Camera) -> list[Expected]:
        """What the bodies would take, as `camera` sees them."""
        meshes, size = self.stage.view.scene.meshes, self.stage.view.size

        def area(side: Side) -> float:
            parts = (meshes[number] for number in side.meshes)
            return sum(_area(part.positions, part.faces, camera, size) for part in parts)

        return [
            Expected(
                # Of a lens the eye sees one face.
                pixels=max(map(area, body.sides)),
                lines=3 if body.sides[0].disperses else 1,
                interfaces=len(body.sides),
                maps=2 if _converge(rays_of(body, camera.eye(size), dispersion=False).rays) else 1,
                patches=BENT_IN_PATCHES if self._bent_in[body] else 1,
                triangles=len(self.stage.geometry.faces),
                bent_in=self._bent_in[body],
            )
            for body in self._bodies
        ]

    def prepare(
        self, encoder: wgpu.GPUCommandEncoder, camera: Any, shift: tuple[float, float]
    ) -> Generator[None, None, wgpu.GPUCommandEncoder] | None:
        """Choose, and have the chosen one prepare."""
        searches = bool(self._bodies) and (self._costs is None or self._costs.searching_pays(self.expected(camera)))
        self._drawing = self._searching if searches else self._tracing
        return self._drawing.prepare(encoder, camera, shift)

    def find(
        self, encoder: wgpu.GPUCommandEncoder, target: Target, camera: Any, shift: tuple[float, float]
    ) -> Generator[None, None, wgpu.GPUCommandEncoder] | None:
        """What the chosen one finds."""
        return self._drawing.find(encoder, target, camera, shift)

    def draw_color(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """What the chosen one draws."""
        self._drawing.draw_color(render_pass)

    def draw_seen(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """The chosen one's seen buffers."""
        self._drawing.draw_seen(render_pass)

    @property
    def replaced(self) -> tuple[int, ...]:
        """What the chosen one draws itself."""
        return self._drawing.replaced

    def deformed(self, geometry: Geometry) -> None:
        """Tell those that there are."""
        for drawing in self._made:
            drawing.deformed(geometry)

    def rays(self) -> tuple[np.ndarray, np.ndarray] | None:
        """The chosen one's rays."""
        return self._drawing.rays()

    def figures(self) -> dict[str, float]:
        """The chosen one's figures."""
        return self._drawing.figures()

    def diagnostics(self) -> Mapping[str, Any]:
        """The chosen one, and what it holds."""
        return {"chosen": self._drawing, **self._drawing.diagnostics()}


def _converge(rays: RayMesh) -> bool:
    """Whether rays that face the eye come nearest to each other before them, and not behind."""
    facing = rays.status == RayStatus.OK
    if not facing.any():
        return False
    origins, directions = rays.origins[facing], rays.unit_directions()[facing]
    viewpoint = virtual_viewpoint(origins, directions)
    return bool((viewpoint[:3] - viewpoint[3] * origins.mean(axis=0)) @ directions.mean(axis=0) > 0.0)


def _area(positions: np.ndarray, faces: np.ndarray, camera: Camera, size: tuple[int, int]) -> float:
    """How many pixels the fronts of triangles cover, at most all of the image."""
    whole = float(size[0] * size[1])
    image = camera.image(positions, size)
    if image[:, 2].min() <= 0.0:
        return whole
    x, y = np.clip(image[:, :2] / image[:, 2:], 0.0, size)[faces].T
    # Rows count downward, so that fronts are negative.
    doubled = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0])
    return min(float(-0.5 * doubled[doubled < 0.0].sum()), whole)


def open_session(view: View, options: Options) -> Session:
    """Start drawing `view` within half a pixel of the reference."""
    check_options("auto", options)
    stage = Stage(view)
    middles = partial(open_session, view, replace(options, antialias=1))
    return Session(stage, AutoDrawing(stage, options, costs_here()), options.antialias, middles)


METHOD = Method(
    name="auto",
    summary="within half a pixel of the reference: searches maps of surfaces or traces, whichever is cheaper",
    source="pervertex and raytrace",
    options=Options,
    open=open_session,
    refracts=True,
    ray_meshes=True,
)
