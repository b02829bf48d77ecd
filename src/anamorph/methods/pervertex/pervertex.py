"""Per-vertex reflection and refraction: maps from the best virtual viewpoints, warped so that every vertex is exact.

Source: Kakimoto, Tatsukawa, Chun, Nishita, "Real-time reflection and refraction on a per-vertex basis" (2007),
sections 3 and 4. Steps 1 to 3 of a frame, which need no device, are in warp.py, for the patches that division.py makes
(4.1); drawing the maps (step 2) and the bodies with them (step 4), again and again for mirrors in mirrors (4.4), is
here. Deviation: maps are as fine as the image that they fill.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np
import wgpu

from anamorph.base.errors import AnamorphError
from anamorph.frame import View
from anamorph.gpu.drawing import OUTPUTS, make_pipeline
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import COLOR_FORMAT
from anamorph.methods.options import check_options
from anamorph.methods.pervertex.atlas import MapKind
from anamorph.methods.pervertex.finding import SurfaceDrawing
from anamorph.methods.pervertex.frame_maps import FrameMaps, SeenBodies, interfaces
from anamorph.methods.pervertex.level import Level, level_layout
from anamorph.methods.pervertex.options import Options
from anamorph.methods.pervertex.surroundings import Surroundings, surroundings_of
from anamorph.methods.pervertex.vertex_marks import VertexMarks
from anamorph.methods.protocol import Method
from anamorph.methods.session import Session
from anamorph.methods.specular_drawing import SpecularDrawing
from anamorph.methods.stage import Stage
from anamorph.optics.ray_meshes import bodies_of
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import Geometry

TARGETS = {**OUTPUTS, "inconsistency": (COLOR_FORMAT,)}
"""What the shaders' fragment functions are called after, and the targets that they write."""

PICTURED = ("color", "inconsistency")
"""What is drawn into the image itself."""


class PerVertexDrawing(SpecularDrawing):
    """Draws every mirror and lens of a scene by the paper's warp of colours."""

    def __init__(self, stage: Stage, options: Options) -> None:
        super().__init__(stage)
        self._options = options
        bodies = bodies_of(stage.view.scene, stage.geometry)
        self._surroundings = surroundings = surroundings_of(stage.geometry, bodies)
        lenses = any(interfaces(body) > 1 for body in bodies)
        levels = options.bounces + lenses if len(bodies) > 1 else 1
        layout = level_layout()
        self._levels = [
            Level(stage.buffers, layout, options.antialias, ends=number + 1 < levels) for number in range(levels)
        ]
        self._seen: SeenBodies | None = None
        self._camera: Camera | None = None
        self._marks = VertexMarks(bodies, options.overlay, options.antialias) if options.overlay != "none" else None
        module = shader_module("methods/pervertex/inconsistency.wgsl", "methods/pervertex/looked_up.wgsl")

        @cache
        def pipeline(refracts: bool, sides: int, cube: bool, output: str) -> wgpu.GPURenderPipeline:
            kind = "refractor" if refracts else "reflector"
            return make_pipeline(
                module,
                f"{kind}_vertex",
                f"{kind}_{output}",
                TARGETS[output],
                buffers=(),
                groups=(layout,),
                samples=options.antialias if output in PICTURED else 1,
                cull="back",
                constants={"SKY_IMAGE": int(stage.buffers.sky_image), "SIDES": sides, "CUBE": int(cube)},
            )

        def depth_pipeline(vertex: str, **settings: Any) -> wgpu.GPURenderPipeline:
            settings = {"buffers": (), "groups": (layout,), "depth_compare": "always", **settings}
            return make_pipeline(module, vertex, None, (), **settings)

        self._nowhere = depth_pipeline("nowhere_vertex")
        self._looked_up = [depth_pipeline("looked_up_vertex", constants={"REFRACTS": number}) for number in (0, 1)]
        self._pipeline = pipeline
        self._maps = FrameMaps(
            surroundings,
            bodies,
            self._levels,
            options,
            # Not a method of this drawing: it would keep itself, and all that it has on the device, alive.
            partial(_draw_in_map, pipeline),
        )

    @property
    def replaced(self) -> tuple[int, ...]:
        """The mirrors that show their front: the others are drawn with the scene."""
        return () if self._seen is None else self._seen.replaced

    def deformed(self, geometry: Geometry) -> None:
        """Have the next maps and rays see the moved scene."""
        self._surroundings.caster.moved(geometry.positions)
        self._surroundings = self._surroundings.moved(geometry)
        self._maps.moved(self._surroundings)
        self._camera = None

    @property
    def surroundings(self) -> Surroundings:
        """What the rays may hit."""
        return self._surroundings

    def plan(self, camera: Camera) -> SeenBodies | None:
        """Plan all maps (steps 1 to 3) for a frame from `camera`; None where no mirror or lens is seen."""
        balls = self._draw_balls if self._marks is not None else None
        eye = camera.eye(self.stage.view.size)
        self._seen = self._maps.plan(eye, np.asarray(camera.position, float), balls)
        return self._seen

    def prepare(self, encoder: wgpu.GPUCommandEncoder, camera: Camera, shift: tuple[float, float]) -> None:
        """Steps 1 to 3: plan all maps, and draw them; where nothing has moved, the last ones serve."""
        if camera == self._camera:
            return
        self._camera = camera
        self.plan(camera)
        if self._marks is not None:
            self._marks.place(self._seen, camera, self.stage.view.size, self._surroundings)
        marks = self._options.overlay == "inconsistency"
        kinds = (MapKind.COLOR, MapKind.DEPTH) if marks else (MapKind.COLOR,)
        # Samples at a triangle's border look up beside it.
        whole = marks or self._options.antialias > 1
        self._maps.draw_maps(encoder, self.stage.buffers, kinds, None if whole else self.leave_out)

    def leave_out(self, level: Level, number: int, depth_pass: wgpu.GPURenderPassEncoder) -> None:
        """Leave out what no fragment looks up."""
        draw = level.lookers.get(number)
        if draw is None:
            return
        level.select(depth_pass, draw.number)
        depth_pass.set_pipeline(self._nowhere)
        depth_pass.draw(3)
        depth_pass.set_pipeline(self._looked_up[draw.refracts])
        depth_pass.draw(6 * draw.count, 1, 6 * draw.first)

    def prepare_seen(self, encoder: wgpu.GPUCommandEncoder) -> None:
        """Draw what the maps see, for the seen buffers."""
        kinds = [MapKind.DEPTH] if len(self._levels) == 1 else [MapKind.DEPTH, MapKind.END]
        self._maps.draw_maps(encoder, self.stage.buffers, kinds)

    def draw_color(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """Step 4: the mirrors and lenses, with their maps."""
        self._draw("inconsistency" if self._options.overlay == "inconsistency" else "color", render_pass)
        if self._marks is not None:
            self._marks.draw(self._seen, render_pass)

    def draw_seen(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """The mirrors' and lenses' seen buffers."""
        self._draw("seen", render_pass)

    def _draw(self, output: str, render_pass: wgpu.GPURenderPassEncoder) -> None:
        if self._seen is not None:
            _draw(self._pipeline, self._seen, output, render_pass)

    def _draw_balls(self, kind: MapKind, render_pass: wgpu.GPURenderPassEncoder) -> None:
        if kind == MapKind.COLOR and self._marks is not None:
            self._marks.draw_in_map(self._seen, render_pass)

    def figures(self) -> dict[str, float]:
        """How many maps the last frame took, their texels, and the share of these that is looked up."""
        return self._maps.figures()

    def diagnostics(self) -> Mapping[str, Any]:
        """The levels of maps, and the plan of the last frame."""
        return {"levels": self._levels, "seen": self._seen}


Pipelines = Callable[[bool, int, bool, str], wgpu.GPURenderPipeline]
"""Of a patch: whether it is a lens, its sides, whether its map is a cube, and the output."""


def _draw(pipeline: Pipelines, seen: SeenBodies, output: str, render_pass: wgpu.GPURenderPassEncoder) -> None:
    drawn = None
    for draw in sorted(seen.draws, key=lambda draw: (draw.refracts, draw.sides, draw.cube)):
        chosen = pipeline(draw.refracts, draw.sides, draw.cube, output)
        if chosen is not drawn:
            render_pass.set_pipeline(chosen)
            drawn = chosen
        seen.level.select(render_pass, draw.number)
        render_pass.draw(3 * draw.count, 1, 3 * draw.first)


def _draw_in_map(pipeline: Pipelines, seen: SeenBodies, kind: MapKind, render_pass: wgpu.GPURenderPassEncoder) -> None:
    _draw(pipeline, seen, kind.value, render_pass)


def open_session(view: View, options: Options) -> Session:
    """Start drawing `view` by per-vertex reflection."""
    check_options("pervertex", options)
    if options.map == "image" and options.tolerance > 0.0:
        raise AnamorphError("pervertex: tolerance is for maps of surfaces; leave it out, or give map=surfaces")
    if options.map == "surfaces":
        for name in ("overlay", "projective"):
            value = getattr(options, name)
            if value != getattr(Options, name):
                raise AnamorphError(
                    f"pervertex: {name}={value} is for maps of colours; leave it out, or give map=image"
                )
        middles = partial(open_session, view, replace(options, antialias=1))
        stage = Stage(view)
        return Session(stage, SurfaceDrawing(stage, options), options.antialias, middles)
    stage = Stage(view)
    return Session(stage, PerVertexDrawing(stage, options), options.antialias)


METHOD = Method(
    name="pervertex",
    summary="maps from the best virtual viewpoints, in which each pixel's own ray finds what it meets",
    source="Kakimoto et al. 2007, sections 3 and 4",
    options=Options,
    open=open_session,
    refracts=True,
)
