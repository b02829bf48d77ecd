"""The rays of one line of light as they leave mirrors and lenses, and what bounds them tile by tile.

They stay as they are until the eye moves, whatever moves in the scene: mirrors and lenses do not.
"""

from __future__ import annotations

from collections.abc import Generator

import numpy as np
import wgpu

from anamorph.gpu.bindings import STORAGE, UNIFORM, bind, layout_of, numbers
from anamorph.gpu.buffers import SceneBuffers, storage_buffer
from anamorph.gpu.device import get_device, of_device
from anamorph.gpu.drawing import ProjectionUniform, bind_scene, make_pipeline
from anamorph.gpu.own_ray import SPECTRUM, exact_layout
from anamorph.gpu.recording import Recorder
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import begin_pass, make_target
from anamorph.gpu.visibility import TEXEL_FORMAT, Rectangle
from anamorph.methods.virtual.tile_tree import TILE_RAYS, TileTree, tile_tree

SIDE = 8
"""Samples along each side of a tile."""

WORKGROUP = 8


@of_device
def _body_layout() -> wgpu.GPUBindGroupLayout:
    return layout_of(STORAGE, STORAGE, stages=wgpu.ShaderStage.VERTEX)


@of_device
def _bounding_layout() -> wgpu.GPUBindGroupLayout:
    written = {"buffer": {"type": "storage"}}
    return layout_of(numbers(), numbers(), UNIFORM, written, stages=wgpu.ShaderStage.COMPUTE)


@of_device
def _bounding_pipeline() -> wgpu.GPUComputePipeline:
    stage = {
        "module": shader_module("methods/virtual/tiles.wgsl"),
        "entry_point": "bound_rays",
        "constants": {"SIDE": SIDE},
    }
    layout = get_device().create_pipeline_layout(bind_group_layouts=[_bounding_layout()])
    return get_device().create_compute_pipeline(layout=layout, compute=stage)


class LeavingRays:
    """Path ends of samples whose rays have met nothing yet.

    Parameters
    ----------
    scene : SceneBuffers
    exact : bind group
        From `bind_exact`.
    size : (width, height)
        Samples.
    line : int
        Of the visibility buffer.

    Attributes
    ----------
    views : list of texture views
        First and second texels, and the depth of the mirrors and lenses that samples are on.
    extent : buffer
        A uniform: where the first tile begins, and how many there are along both sides.
    tree : TileTree or None
        None before the first frame.
    """

    def __init__(self, scene: SceneBuffers, exact: wgpu.GPUBindGroup, size: tuple[int, int], line: int) -> None:
        self._scene, self._exact, self._line = scene, exact, line
        self._target = make_target(size, (TEXEL_FORMAT, TEXEL_FORMAT))
        self._body = bind(_body_layout(), [scene.vertices, scene.indices])
        self.views = [*self._target.attachments, self._target.depth]
        self.extent = get_device().create_buffer(size=16, usage=wgpu.BufferUsage.UNIFORM | wgpu.BufferUsage.COPY_DST)
        most = -(-size[0] // SIDE) * -(-size[1] // SIDE)
        self._tiles = storage_buffer(np.zeros(most, TILE_RAYS), wgpu.BufferUsage.COPY_SRC)
        self._bounding = bind(_bounding_layout(), [*self.views[:2], self.extent, self._tiles])
        self.tree: TileTree | None = None

    def leave(
        self, encoder: wgpu.GPUCommandEncoder, projection: ProjectionUniform, meshes: dict[int, dict[str, float]]
    ) -> None:
        """Record the rays of meshes, by the constants of leaving_rays.wgsl for each that sends them its own way."""
        render_pass = begin_pass(encoder, self._target)
        bind_scene(render_pass, self._scene, projection)
        render_pass.set_bind_group(2, self._body)
        render_pass.set_bind_group(3, self._exact)
        for mesh, constants in meshes.items():
            render_pass.set_pipeline(_leaving_pipeline(constants | {"LINE": SPECTRUM[self._line]}))
            first, last = int(self._scene.first_face[mesh]), int(self._scene.first_face[mesh + 1])
            render_pass.draw(3 * (last - first), 1, 3 * first)
        render_pass.end()

    def bounding(
        self, encoder: wgpu.GPUCommandEncoder, recorder: Recorder, rectangle: Rectangle
    ) -> Generator[None, None, wgpu.GPUCommandEncoder]:
        """Bound the rays in a rectangle of samples, tile by tile; in steps, with the encoder to go on with."""
        x0, y0, x1, y1 = rectangle
        columns, rows = -(-(x1 - x0) // SIDE), -(-(y1 - y0) // SIDE)
        get_device().queue.write_buffer(self.extent, 0, np.array([x0, y0, columns, rows], np.uint32))
        compute_pass = encoder.begin_compute_pass()
        compute_pass.set_pipeline(_bounding_pipeline())
        compute_pass.set_bind_group(0, self._bounding)
        compute_pass.dispatch_workgroups(-(-columns // WORKGROUP), -(-rows // WORKGROUP))
        compute_pass.end()
        encoder = recorder.part(encoder)
        yield
        tiles = get_device().queue.read_buffer(self._tiles, 0, columns * rows * TILE_RAYS.itemsize)
        self.tree = tile_tree(np.frombuffer(tiles, TILE_RAYS).reshape(rows, columns))
        return encoder


def _leaving_pipeline(constants: dict[str, float]) -> wgpu.GPURenderPipeline:
    return make_pipeline(
        shader_module("methods/virtual/leaving_rays.wgsl"),
        "body_vertex",
        "refractor_left" if constants["LENS"] else "reflector_left",
        (TEXEL_FORMAT, TEXEL_FORMAT),
        buffers=(),
        groups=(_body_layout(), exact_layout()),
        cull="back",
        depth_compare="greater-equal",
        constants=constants,
    )
