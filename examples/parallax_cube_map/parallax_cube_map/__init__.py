"""A cube map from the mirrors' centre that is corrected for the box around the scene.

Source: Lagarde and Zanuttini, "Local image-based lighting with parallax-corrected cubemaps" (SIGGRAPH 2012 talks).
Where the scene is its box, what is found is exact; what stands within the box is shown as if it were painted on it.
Deviation: one box and one cube map for all mirrors, and the box is that of the scene's own meshes.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import wgpu

from anamorph.base.errors import AnamorphError
from anamorph.frame import View
from anamorph.gpu.bindings import UNIFORM, bind, layout_of
from anamorph.gpu.device import get_device
from anamorph.gpu.drawing import draw_mesh, make_pipeline
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import COLOR_FORMAT, SEEN_FORMATS
from anamorph.methods.environment import CubeMap, cube_layout
from anamorph.methods.options import check_options, option
from anamorph.methods.protocol import Method
from anamorph.methods.session import Session
from anamorph.methods.specular_drawing import SpecularDrawing
from anamorph.methods.stage import Stage
from anamorph.scene.camera import Camera

SHADER = Path(__file__).with_name("parallax.wgsl")


@dataclass(frozen=True)
class Options:
    """Options of `parallax`.

    Parameters
    ----------
    face : int
        Texels along an edge of the cube map.
    """

    face: int = option(1024, low=16, high=4096, unit="texels")


class ParallaxDrawing(SpecularDrawing):
    """Draws every mirror of a scene by one cube map."""

    def __init__(self, stage: Stage, options: Options) -> None:
        super().__init__(stage)
        meshes = stage.view.scene.meshes
        mirrors = np.concatenate([mesh.positions for mesh in meshes if mesh.specular] or [np.zeros((1, 3))])
        around = np.concatenate([mesh.positions for mesh in meshes if not mesh.specular] or [mirrors])
        center = (mirrors.min(axis=0) + mirrors.max(axis=0)) / 2.0
        self._map = CubeMap(center, options.face, near=1e-3 * float(np.ptp(around, axis=0).max()))
        box = np.zeros((3, 4), np.float32)
        box[:, :3] = around.min(axis=0), around.max(axis=0), center
        layout = layout_of(UNIFORM)
        self._box = bind(layout, [get_device().create_buffer_with_data(data=box, usage=wgpu.BufferUsage.UNIFORM)])
        module, groups = shader_module(SHADER), (cube_layout(), layout)
        self._color, self._seen = (
            make_pipeline(module, "scene_vertex", fragment, formats, groups=groups, cull="back")
            for fragment, formats in (("parallax_color", (COLOR_FORMAT,)), ("parallax_seen", SEEN_FORMATS))
        )

    def prepare(self, encoder: wgpu.GPUCommandEncoder, camera: Camera, shift: tuple[float, float]) -> None:
        """Draw the cube map."""
        self._map.draw_color(encoder, self.stage.buffers, self.replaced)

    def prepare_seen(self, encoder: wgpu.GPUCommandEncoder) -> None:
        """Draw what the cube map sees."""
        self._map.draw_depth(encoder, self.stage.buffers, self.replaced)

    def draw_color(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """The mirrors, with the cube map."""
        self._draw(render_pass, self._color, self._map.group)

    def draw_seen(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """The mirrors' seen buffers."""
        self._draw(render_pass, self._seen, self._map.seen_group)

    def _draw(
        self, render_pass: wgpu.GPURenderPassEncoder, pipeline: wgpu.GPURenderPipeline, group: wgpu.GPUBindGroup
    ) -> None:
        render_pass.set_pipeline(pipeline)
        render_pass.set_bind_group(2, group)
        render_pass.set_bind_group(3, self._box)
        for mesh in self.replaced:
            draw_mesh(render_pass, self.stage.buffers, mesh)


def open_session(view: View, options: Options) -> Session:
    """Start drawing `view` by a corrected cube map."""
    check_options("parallax", options)
    if view.scene.refracts:
        raise AnamorphError("parallax: draws mirrors alone, and the scene has glass; use pervertex or raytrace")
    stage = Stage(view)
    return Session(stage, ParallaxDrawing(stage, options))


METHOD = Method(
    name="parallax",
    summary="a cube map from the mirrors' centre, corrected for the box around the scene",
    source="Lagarde and Zanuttini 2012",
    options=Options,
    open=open_session,
)
