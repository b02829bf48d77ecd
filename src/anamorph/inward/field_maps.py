"""Near and far field on the device: which triangle each texel sees first along rays that converge.

Source: Vallance and Calder, "Inward looking projections" (2003), sections 4.1 to 4.3. The near field takes the nearer
half of the depths, and within it what is farther from the point of convergence is nearer; the far field takes the rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import wgpu

from anamorph.gpu.bindings import STORAGE, UNIFORM, bind, layout_of
from anamorph.gpu.buffers import SceneBuffers
from anamorph.gpu.device import get_device, of_device
from anamorph.gpu.drawing import ProjectionUniform, bind_scene, make_pipeline
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import DEPTH_FORMAT, begin_pass, make_target, make_texture
from anamorph.inward.converging import Converging
from anamorph.inward.field_views import FieldView

FIELD_FORMAT = "r32uint"
CONVERGENCE = np.dtype([("point", "f4", 3), ("reach", "f4")])
"""As field_map.wgsl reads it."""


@of_device
def _field_layout() -> wgpu.GPUBindGroupLayout:
    stages = wgpu.ShaderStage.VERTEX | wgpu.ShaderStage.FRAGMENT
    return layout_of(STORAGE, STORAGE, UNIFORM, stages=stages)


class FieldMaps:
    """The views of one camera.

    Attributes
    ----------
    texture : texture
        Triangles, from 1, a layer for each view.
    """

    def __init__(self, scene: SceneBuffers, rays: Converging, views: Sequence[FieldView], far: bool) -> None:
        self._scene = scene
        size = views[0].size
        self.texture = make_texture(size, FIELD_FORMAT, layers=len(views))
        depth = make_texture(size, DEPTH_FORMAT).create_view()
        textures = (self.texture,)
        self._targets = [
            make_target(size, (FIELD_FORMAT,), textures=textures, layer=layer, depth=depth)
            for layer in range(len(views))
        ]
        self._fields: list[list[ProjectionUniform]] = []
        for view in views:
            uniforms = []
            for projection in view.projections(rays.point)[: 2 if far else 1]:
                uniforms.append(ProjectionUniform())
                uniforms[-1].write(projection, size)
            self._fields.append(uniforms)
        convergence = np.array((rays.point, rays.reach), CONVERGENCE)
        uniform = get_device().create_buffer_with_data(data=convergence, usage=wgpu.BufferUsage.UNIFORM)
        self._group = bind(_field_layout(), [scene.vertices, scene.indices, uniform])

    @cached_property
    def _pipelines(self) -> list[wgpu.GPURenderPipeline]:
        module = shader_module("inward/field_map.wgsl")
        return [
            make_pipeline(module, "field_vertex", field, (FIELD_FORMAT,), buffers=(), groups=(_field_layout(),))
            for field in ("near_field", "far_field")
        ]

    def draw(self, encoder: wgpu.GPUCommandEncoder) -> None:
        """Draw all views."""
        for target, uniforms in zip(self._targets, self._fields, strict=True):
            render_pass = begin_pass(encoder, target)
            for pipeline, uniform in zip(self._pipelines, uniforms, strict=False):
                bind_scene(render_pass, self._scene, uniform)
                render_pass.set_pipeline(pipeline)
                render_pass.set_bind_group(2, self._group)
                render_pass.draw(3 * int(self._scene.first_face[-1]))
            render_pass.end()
