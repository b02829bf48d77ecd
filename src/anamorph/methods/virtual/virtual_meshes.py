"""Virtual objects as the paper draws them: one mesh for each reflector, of virtual vertices that its search has found.

Source: Estalella et al. 2005, sections 3, 4 and 6.1. Deviation: a virtual object tells which triangle each sample sees,
and where, and is coloured with all else.
"""

from __future__ import annotations

import numpy as np
import wgpu

from anamorph.gpu.bindings import STORAGE, bind, depths, layout_of, numbers
from anamorph.gpu.buffers import storage_buffer
from anamorph.gpu.device import of_device
from anamorph.gpu.drawing import ProjectionUniform, bind_scene, make_pipeline
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import begin_pass, make_target
from anamorph.gpu.visibility import TEXEL_FORMAT, VisibilityBuffer
from anamorph.methods.stage import Stage
from anamorph.methods.virtual.grid_search import GridKind, GridSearch
from anamorph.methods.virtual.leaving_rays import LeavingRays
from anamorph.methods.virtual.reflector_maps import reflector_maps
from anamorph.optics.ray_meshes import Body
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import Geometry


@of_device
def _drawing_layout() -> wgpu.GPUBindGroupLayout:
    stages = wgpu.ShaderStage.VERTEX | wgpu.ShaderStage.FRAGMENT
    return layout_of(numbers(), numbers(), *4 * [STORAGE], stages=stages)


@of_device
def _showing_layout() -> wgpu.GPUBindGroupLayout:
    return layout_of(numbers(), numbers(), depths(), STORAGE, numbers(), numbers())


class VirtualMeshes:
    """Draws the virtual objects of all mirrors.

    Parameters
    ----------
    stage : Stage
    bodies : tuple of Body
        Of which the mirrors are searched.
    leaving : LeavingRays
    size : (width, height)
        Samples.
    face : int
        Texels along each side of a cube map's face.
    kind : GridKind
        Which vertices are searched for.

    Raises
    ------
    AnamorphError
        A mirror has no cube maps.
    """

    def __init__(
        self,
        stage: Stage,
        bodies: tuple[Body, ...],
        leaving: LeavingRays,
        size: tuple[int, int],
        face: int,
        kind: GridKind,
    ) -> None:
        self._stage, scene = stage, stage.view.scene
        body_of = np.zeros(len(scene.meshes) + 1, np.uint32)
        self._searches: list[GridSearch] = []
        for body in bodies:
            if not body.sides[0].refracts:
                maps = reflector_maps(tuple(scene.meshes[mesh] for mesh in body.meshes), face)
                self._searches.append(GridSearch(maps, body.meshes, stage.geometry, kind))
                body_of[np.array(body.meshes) + 1] = len(self._searches)
        numbered = storage_buffer(body_of)
        self._drawn = make_target(size, (TEXEL_FORMAT, TEXEL_FORMAT))
        self._groups = [
            bind(
                _drawing_layout(),
                [*leaving.views[:2], stage.buffers.vertices, stage.buffers.indices, search.reflected, numbered],
            )
            for search in self._searches
        ]
        self._shown = bind(_showing_layout(), [*leaving.views, numbered, *self._drawn.attachments])
        self._show = make_pipeline(
            shader_module("methods/virtual/shown_meshes.wgsl"), "shown_vertex", "shown_end",
            (TEXEL_FORMAT, TEXEL_FORMAT), buffers=(), groups=(_showing_layout(),), depth_compare="greater-equal",
        )  # fmt: skip

    def moved(self, geometry: Geometry) -> None:
        """Follow the scene's vertices."""
        for search in self._searches:
            search.moved(geometry)

    def draw(
        self,
        encoder: wgpu.GPUCommandEncoder,
        projection: ProjectionUniform,
        camera: Camera,
        visibility: VisibilityBuffer,
        depth: wgpu.GPUTextureView,
    ) -> None:
        """Record the search for a camera's eye, and the objects where mirrors and lenses are not behind `depth`."""
        for search in self._searches:
            search.record(encoder, camera, self._stage.view.size)
        render_pass = begin_pass(encoder, self._drawn)
        bind_scene(render_pass, self._stage.buffers, projection)
        for number, group in enumerate(self._groups, start=1):
            render_pass.set_pipeline(_drawing_pipeline(number))
            render_pass.set_bind_group(2, group)
            render_pass.draw(3 * len(self._stage.geometry.faces))
        render_pass.end()
        for line in range(len(visibility.textures)):
            render_pass = visibility.begin(encoder, depth, line)
            if line == 0 and visibility.rectangle is not None:
                x0, y0, x1, y1 = (visibility.side * end for end in visibility.rectangle)
                bind_scene(render_pass, self._stage.buffers, projection)
                render_pass.set_pipeline(self._show)
                render_pass.set_bind_group(2, self._shown)
                render_pass.set_scissor_rect(x0, y0, x1 - x0, y1 - y0)
                render_pass.draw(3)
            render_pass.end()

    @property
    def searches(self) -> int:
        """How many points were searched for last, on all reflectors."""
        return sum(search.searches for search in self._searches)


def _drawing_pipeline(body: int) -> wgpu.GPURenderPipeline:
    return make_pipeline(
        shader_module("methods/virtual/virtual_meshes.wgsl"), "virtual_vertex", "virtual_end",
        (TEXEL_FORMAT, TEXEL_FORMAT), buffers=(), groups=(_drawing_layout(),), constants={"BODY": body},
    )  # fmt: skip
