"""Virtual objects: every triangle of the scene looks for where the eye sees it in mirrors and lenses.

Source: Estalella, Martin, Drettakis, Tost, Devillers and Cazals, "Accurate interactive specular reflections on curved
objects" (2005).
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, replace
from functools import partial

import wgpu

from anamorph.frame import View
from anamorph.gpu.bindings import STORAGE, bind, layout_of
from anamorph.gpu.device import of_device
from anamorph.gpu.drawing import bind_scene, make_pipeline
from anamorph.gpu.own_ray import SPECTRUM, bind_exact, exact_layout
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import Target, begin_pass, make_texture
from anamorph.gpu.visibility import TEXEL_FORMAT
from anamorph.methods.finding import FindingDrawing
from anamorph.methods.options import check_options, option
from anamorph.methods.protocol import Method
from anamorph.methods.session import Session
from anamorph.methods.stage import Stage
from anamorph.methods.tracing.doubt import DoubtTracer
from anamorph.methods.tracing.paths import specular_rectangle
from anamorph.methods.virtual.tile_lists import TileLists
from anamorph.optics.exact_sides import exact_sides
from anamorph.optics.ray_meshes import bodies_of
from anamorph.rays.caster import Caster
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import Geometry


@dataclass(frozen=True)
class Options:
    """Options of `virtual`.

    Parameters
    ----------
    bounces : int
        How many specular interfaces a path may meet: a mirror is one, a lens is two. From the second mirror or lens on
        it is traced.
    antialias : int
        Samples a pixel: 1 or 4.
    """

    bounces: int = option(8, low=1, high=255)
    antialias: int = option(1, choices=(1, 4))


@of_device
def _body_layout() -> wgpu.GPUBindGroupLayout:
    return layout_of(STORAGE, STORAGE, stages=wgpu.ShaderStage.VERTEX)


class VirtualDrawing(FindingDrawing):
    """Finds for each triangle of the scene where mirrors and lenses show it."""

    def __init__(self, stage: Stage, options: Options) -> None:
        scene, geometry = stage.view.scene, stage.geometry
        bodies = bodies_of(scene, geometry)
        self._meshes = tuple(mesh for body in bodies for mesh in body.meshes)
        self._refracts = {mesh for body in bodies for side in body.sides if side.refracts for mesh in side.meshes}
        self._disperses = {mesh for body in bodies for side in body.sides if side.disperses for mesh in side.meshes}
        super().__init__(stage, 3 if self._disperses else 1, options.antialias)
        sides = exact_sides(scene, geometry, bodies)
        self._kinds, self._exact, self._bounces = sides.kinds, bind_exact(sides), options.bounces
        self._body = bind(_body_layout(), [stage.buffers.vertices, stage.buffers.indices])
        size = self.visibility.size
        self._leaving = make_texture(size, TEXEL_FORMAT), make_texture(size, TEXEL_FORMAT)
        self._lists = TileLists(stage, self._leaving)
        self._caster = Caster(geometry)
        self._doubt = DoubtTracer(stage, self.visibility, self._caster, options.bounces)

    @property
    def replaced(self) -> tuple[int, ...]:
        """All mirrors and lenses."""
        return self._meshes

    def deformed(self, geometry: Geometry) -> None:
        """Have the next frame look for the moved triangles."""
        self._caster.moved(geometry.positions)
        self._doubt.moved(geometry)
        self._lists.moved(geometry)

    def prepare(self, encoder: wgpu.GPUCommandEncoder, camera: Camera, shift: tuple[float, float]) -> None:
        """Set the projection."""
        self.look(camera, shift)
        rectangle = specular_rectangle(self.stage.view.scene, camera, self.stage.view.size)
        self.visibility.show(rectangle, len(self.visibility.textures))

    def find(
        self, encoder: wgpu.GPUCommandEncoder, target: Target, camera: Camera, shift: tuple[float, float]
    ) -> Generator[None, None, wgpu.GPUCommandEncoder] | None:
        """Find what each sample sees, in steps; what cannot be found so is traced."""
        if self.visibility.rectangle is None:
            return None
        return self._finding(encoder, target, camera, shift)

    def _finding(
        self, encoder: wgpu.GPUCommandEncoder, target: Target, camera: Camera, shift: tuple[float, float]
    ) -> Generator[None, None, wgpu.GPUCommandEncoder]:
        depth = self.depth_of(encoder, target)
        for line in range(len(self.visibility.textures)):
            self._leave(encoder, depth, line)
            encoder = yield from self._lists.finding(encoder, self.visibility, depth, self.projection, line)
        return (yield from self._doubt.tracing(encoder, depth, self.projection, camera, shift))

    def _leave(self, encoder: wgpu.GPUCommandEncoder, depth: wgpu.GPUTextureView, line: int) -> None:
        """Draw the rays of one line of light as they leave the bodies."""
        views = tuple(texture.create_view() for texture in self._leaving)
        target = Target(self.visibility.size, self._leaving, views, (None, None), depth, 1)
        render_pass = begin_pass(encoder, target, keep_depth=True)
        bind_scene(render_pass, self.stage.buffers, self.projection)
        render_pass.set_bind_group(2, self._body)
        render_pass.set_bind_group(3, self._exact)
        first_face = self.stage.buffers.first_face
        for mesh in self._meshes:
            if line and mesh not in self._disperses:
                continue
            render_pass.set_pipeline(self._pipeline(mesh, line))
            begin, end = int(first_face[mesh]), int(first_face[mesh + 1])
            render_pass.draw(3 * (end - begin), 1, 3 * begin)
        render_pass.end()

    def _pipeline(self, mesh: int, line: int) -> wgpu.GPURenderPipeline:
        near, far = (int(kind) for kind in self._kinds[mesh])
        lens = mesh in self._refracts
        return make_pipeline(
            shader_module("methods/virtual/leaving.wgsl"),
            "body_vertex",
            "refractor_left" if lens else "reflector_left",
            (TEXEL_FORMAT, TEXEL_FORMAT),
            buffers=(),
            groups=(_body_layout(), exact_layout()),
            cull="back",
            depth_compare="greater-equal",
            constants={
                "LENS": int(lens),
                "SURFACE": near,
                "FAR_SURFACE": far,
                "LINE": SPECTRUM[line],
                "MOST_BOUNCES": self._bounces,
            },
        )

    def figures(self) -> dict[str, float]:
        """How many pairs of a tile and a triangle were tested, and how many samples were traced."""
        return {**self._lists.figures(), "traced": float(self._doubt.traced)}


def open_session(view: View, options: Options) -> Session:
    """Start drawing `view` by virtual objects."""
    check_options("virtual", options)
    stage = Stage(view)
    middles = partial(open_session, view, replace(options, antialias=1))
    return Session(stage, VirtualDrawing(stage, options), options.antialias, middles)


METHOD = Method(
    name="virtual",
    summary="every triangle of the scene looks for where mirrors and lenses show it",
    source="Estalella et al. 2005",
    options=Options,
    open=open_session,
    refracts=True,
)
