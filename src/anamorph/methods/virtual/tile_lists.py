"""What each sample's ray meets, tile by tile: which triangles a tile may see, and a pass that asks each of them."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np
import wgpu

from anamorph.gpu.bindings import STORAGE, UNIFORM, bind, layout_of, numbers
from anamorph.gpu.buffers import grown_buffer, storage_buffer
from anamorph.gpu.device import get_device, of_device
from anamorph.gpu.drawing import ProjectionUniform, bind_scene, make_pipeline
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.visibility import TEXEL_FORMAT, VisibilityBuffer
from anamorph.methods.stage import Stage
from anamorph.methods.virtual.listing import Lists, listing
from anamorph.methods.virtual.tile_tree import TILE_RAYS, tile_tree
from anamorph.methods.virtual.triangle_records import surfaces_of, triangles_of
from anamorph.methods.virtual.triangle_tree import triangle_tree
from anamorph.scene.geometry import Geometry

SIDE = 8
"""Samples along each side of a tile."""

WORKGROUP = 8

MOST = 64
"""Triangles that a tile's samples ask, at most: to trace them takes as long."""

TRACED = 0xFFFFFFFF
"""In place of a count: rays are traced there."""


@of_device
def _bounding_layout() -> wgpu.GPUBindGroupLayout:
    written = {"buffer": {"type": "storage"}}
    return layout_of(numbers(), numbers(), UNIFORM, written, stages=wgpu.ShaderStage.COMPUTE)


@of_device
def _meeting_layout() -> wgpu.GPUBindGroupLayout:
    return layout_of(numbers(), numbers(), UNIFORM, *4 * [STORAGE])


def _corners(geometry: Geometry) -> np.ndarray:
    return np.asarray(geometry.positions, float)[geometry.faces]


class TileLists:
    """Finds what rays meet that leave mirrors and lenses.

    Parameters
    ----------
    stage : Stage
    leaving : (texture, texture)
        Path ends of samples whose rays have met nothing yet.
    """

    def __init__(self, stage: Stage, leaving: tuple[wgpu.GPUTexture, wgpu.GPUTexture]) -> None:
        self._stage = stage
        width, height = leaving[0].size[:2]
        self._views = [texture.create_view() for texture in leaving]
        given = wgpu.BufferUsage.UNIFORM | wgpu.BufferUsage.COPY_DST
        self._extent = get_device().create_buffer(size=16, usage=given)
        # A rectangle may begin anywhere.
        most = (-(-width // SIDE) + 1) * (-(-height // SIDE) + 1)
        self._tiles = storage_buffer(np.zeros(most, TILE_RAYS), wgpu.BufferUsage.COPY_SRC)
        self._bounding = bind(_bounding_layout(), [*self._views, self._extent, self._tiles])
        layout = get_device().create_pipeline_layout(bind_group_layouts=[_bounding_layout()])
        module = shader_module("methods/virtual/tiles.wgsl")
        self._bound = get_device().create_compute_pipeline(
            layout=layout, compute={"module": module, "entry_point": "bound_rays", "constants": {"SIDE": SIDE}}
        )
        self._meet = make_pipeline(
            shader_module("methods/virtual/met.wgsl"), "met_vertex", "met_end", (TEXEL_FORMAT, TEXEL_FORMAT),
            buffers=(), groups=(_meeting_layout(),), depth_compare="always", depth_write=False,
            constants={"SIDE": SIDE},
        )  # fmt: skip
        scene = stage.view.scene
        self._surfaces = storage_buffer(surfaces_of(scene))
        self._triangles = storage_buffer(triangles_of(stage.geometry, scene))
        self._tree = triangle_tree(_corners(stage.geometry))
        self._held: list[wgpu.GPUBuffer | None] = [None, None]
        self._group: wgpu.GPUBindGroup | None = None
        self._asked = 0

    def moved(self, geometry: Geometry) -> None:
        """Follow the scene's vertices."""
        self._tree = self._tree.moved(_corners(geometry))
        get_device().queue.write_buffer(self._triangles, 0, triangles_of(geometry, self._stage.view.scene))

    def finding(
        self,
        encoder: wgpu.GPUCommandEncoder,
        visibility: VisibilityBuffer,
        depth: wgpu.GPUTextureView,
        projection: ProjectionUniform,
        line: int,
    ) -> Generator[None, None, wgpu.GPUCommandEncoder]:
        """Fill a line of the visibility buffer, in steps; returns the encoder to go on with."""
        assert visibility.rectangle is not None
        x0, y0, x1, y1 = (visibility.side * end for end in visibility.rectangle)
        columns, rows = -(-(x1 - x0) // SIDE), -(-(y1 - y0) // SIDE)
        get_device().queue.write_buffer(self._extent, 0, np.array([x0, y0, columns, rows], np.uint32))
        compute_pass = encoder.begin_compute_pass()
        compute_pass.set_pipeline(self._bound)
        compute_pass.set_bind_group(0, self._bounding)
        compute_pass.dispatch_workgroups(-(-columns // WORKGROUP), -(-rows // WORKGROUP))
        compute_pass.end()
        encoder = self._stage.recorder.part(encoder)
        yield
        data = get_device().queue.read_buffer(self._tiles, 0, columns * rows * TILE_RAYS.itemsize)
        tree = tile_tree(np.frombuffer(data, TILE_RAYS).reshape(rows, columns))
        self._hand_over((yield from listing(tree, self._tree, MOST)))
        render_pass = visibility.begin(encoder, depth, line)
        bind_scene(render_pass, self._stage.buffers, projection)
        render_pass.set_pipeline(self._meet)
        render_pass.set_bind_group(2, self._group)
        render_pass.set_scissor_rect(x0, y0, x1 - x0, y1 - y0)
        render_pass.draw(3)
        render_pass.end()
        return encoder

    def _hand_over(self, found: Lists) -> None:
        counts = np.diff(found.begins)
        self._asked = int(counts[~found.full].sum())
        lists = np.stack([found.begins[:-1], np.where(found.full, TRACED, counts)], axis=1).astype(np.uint32)
        contents = [lists, np.concatenate([found.triangles, np.zeros(1, np.uint32)])]
        held = [grown_buffer(old, data.nbytes) for old, data in zip(self._held, contents, strict=True)]
        if held != self._held:
            self._held = list(held)
            self._group = bind(_meeting_layout(), [*self._views, self._extent, self._triangles, self._surfaces, *held])
        for buffer, data in zip(held, contents, strict=True):
            get_device().queue.write_buffer(buffer, 0, data)

    def figures(self) -> dict[str, float]:
        """How many triangles tiles have asked for the last line of light."""
        return {"asked": float(self._asked)}
