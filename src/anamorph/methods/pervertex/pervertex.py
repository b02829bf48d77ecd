"""Per-vertex reflection and refraction: maps from the best virtual viewpoints, warped so that every vertex is exact.

Source: Kakimoto, Tatsukawa, Chun, Nishita, "Real-time reflection and refraction on a per-vertex basis" (2007),
sections 3 and 4. Steps 1 to 3 of a frame, which need no device, are in warp.py, for the patches that division.py makes
(4.1); drawing the maps (step 2) and the bodies with them (step 4), again and again for mirrors in mirrors (4.4), is
here. Deviation: maps are as fine as the image that they fill.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np
import wgpu

from anamorph.base.errors import AnamorphError
from anamorph.frame import View
from anamorph.gpu.device import get_device
from anamorph.gpu.drawing import OUTPUTS, bind_scene, make_pipeline, submit
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import COLOR_FORMAT, Target, begin_pass, make_texture, read_texture
from anamorph.methods.options import check_options
from anamorph.methods.pervertex.atlas import MapKind
from anamorph.methods.pervertex.frame_maps import FrameMaps, SeenBodies, interfaces
from anamorph.methods.pervertex.level import Level, level_layout
from anamorph.methods.pervertex.mend import Mender, doubtful_tiles
from anamorph.methods.pervertex.options import Options
from anamorph.methods.pervertex.surroundings import Surroundings, surroundings_of
from anamorph.methods.pervertex.vertex_marks import VertexMarks
from anamorph.methods.protocol import Method
from anamorph.methods.session import Session
from anamorph.methods.specular_drawing import SpecularDrawing
from anamorph.methods.stage import Stage
from anamorph.optics.ray_meshes import bodies_of
from anamorph.optics.tessellation import refined_scene
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import Geometry

REFINEMENTS_BEFORE_TRACING = 3

RAY_SHARE = 0.1
"""The share of the tolerance that a fragment's own ray may take up."""

ERROR_FORMAT = "r32float"


TARGETS = {**OUTPUTS, "error": (ERROR_FORMAT,), "inconsistency": (COLOR_FORMAT,)}
"""What the shaders' fragment functions are called after, and the targets that they write."""

PICTURED = ("color", "inconsistency")
"""What is drawn into the image itself."""


class PerVertexDrawing(SpecularDrawing):
    """Draws every mirror and lens of a scene by per-vertex reflection and refraction."""

    def __init__(self, stage: Stage, options: Options) -> None:
        super().__init__(stage)
        self._options = options
        bodies = bodies_of(stage.view.scene, stage.geometry)
        self._surroundings = surroundings = surroundings_of(stage.geometry, bodies)
        lenses = any(interfaces(body) > 1 for body in bodies)
        levels = options.bounces + lenses if len(bodies) > 1 else 1
        layout = level_layout()
        self._levels = [
            Level(stage.buffers, layout, options.antialias, options.mipmaps, ends=number + 1 < levels)
            for number in range(levels)
        ]
        self._mender: Mender | None = None
        if options.tolerance > 0.0:
            self._mender = Mender(stage, surroundings.caster)
            self._errors = make_texture(stage.view.size, ERROR_FORMAT)
            self._errors_view = self._errors.create_view()
        self._seen: SeenBodies | None = None
        self._camera: Camera | None = None
        self._marks = VertexMarks(bodies, options.overlay, options.antialias) if options.overlay != "none" else None
        module = shader_module("methods/pervertex/doubt.wgsl", "methods/pervertex/looked_up.wgsl")
        constants: dict[str, float] = {
            "REFINEMENTS": options.refine,
            "MIPMAPS": int(options.mipmaps),
            "SKY_IMAGE": int(stage.buffers.sky_image),
        }

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
                depth_compare="equal" if output == "error" else "greater",
                constants={**constants, "SIDES": sides, "CUBE": int(cube), "FOLDS": int(output == "error")},
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
        """Have the next maps and rays see the moved scene; without vertex rays nothing is cast, and no tree follows."""
        caster = self._surroundings.caster
        if self._options.casts:
            caster.moved(geometry.positions)
        if self._mender is not None:
            self._mender.moved(geometry)
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
        looks = self._options.refine > 0 or self._mender is not None or self._options.overlay == "inconsistency"
        kinds: Sequence[MapKind] = (MapKind.COLOR,)
        # Steps lead anywhere in a map, mipmaps blend far texels, and samples at a triangle's border look up beside it.
        whole = looks or self._options.mipmaps or self._options.antialias > 1
        if looks:
            # The balls have colour, and no depth that could be taken for the scene's.
            at_once = self._options.antialias == 1 and self._marks is None
            kinds = (MapKind.BOTH,) if at_once else (MapKind.COLOR, MapKind.DEPTH)
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

    def complete(self, target: Target, camera: Camera, shift: tuple[float, float]) -> None:
        """Have those tiles traced in which some fragment may be wrong by more than the tolerance."""
        if self._mender is None:
            return
        encoder = get_device().create_command_encoder()
        errors = replace(target, textures=(self._errors,), attachments=(self._errors_view,))
        render_pass = begin_pass(encoder, errors, keep_depth=True)
        bind_scene(render_pass, self.stage.buffers, self.stage.projection)
        self._draw("error", render_pass)
        render_pass.end()
        submit(encoder)
        self._mender.trace(doubtful_tiles(read_texture(self._errors), self._options.tolerance), camera, shift)
        self._mender.draw_over(target, self.stage.projection)

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
        if self._mender is not None:
            self._mender.draw_seen(render_pass)

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
        """The levels of maps, the plan of the last frame, and with a tolerance the errors of its pixels."""
        errors = None if self._mender is None else self._errors
        return {"levels": self._levels, "seen": self._seen, "errors": errors}


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
    if not options.casts and options.overlay != "none":
        raise AnamorphError("pervertex: an overlay needs the vertex rays; give start=vertices")
    if not options.casts and options.tolerance > 0.0:
        raise AnamorphError("pervertex: a tolerance needs the vertex rays; give start=vertices")
    if options.tolerance > 0.0:
        if options.antialias > 1:
            raise AnamorphError("pervertex: tolerance needs antialias=1; give more samples for a smooth image")
        options = replace(options, refine=max(options.refine, REFINEMENTS_BEFORE_TRACING))
        view = replace(view, scene=refined_scene(view.scene, view.size, RAY_SHARE * options.tolerance))
    stage = Stage(view)
    return Session(stage, PerVertexDrawing(stage, options), options.antialias)


METHOD = Method(
    name="pervertex",
    summary="one image from the best virtual viewpoint, warped so that every vertex is exact",
    source="Kakimoto et al. 2007, sections 3 and 4",
    options=Options,
    open=open_session,
    refracts=True,
)
