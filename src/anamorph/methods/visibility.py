"""Which scene triangle each pixel's ray meets, on the device: what `trilinear.plan` has planned, asked for per pixel.

Two passes, without a ray being cast: the ray triangles, each pixel getting the one whose part of the picture it is in;
and the pieces of all pairs, of which each pixel keeps the nearest that holds it.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import wgpu

from anamorph.gpu.bindings import STORAGE, bind, layout_of
from anamorph.gpu.buffers import SceneBuffers, roomy_buffer
from anamorph.gpu.device import get_device
from anamorph.gpu.drawing import ProjectionUniform, bind_scene, make_pipeline, shader_module
from anamorph.gpu.targets import begin_pass, make_target
from anamorph.trilinear.beams import Beams
from anamorph.trilinear.plan import Plan

NUMBER_FORMAT = "r32uint"

PAIR = np.dtype(
    [
        ("terms", "f4", 24),
        ("center", "f4", 2),
        ("ray_triangle", "u4"),
        ("seen", "u4"),
    ]
)
"""A pair, as visibility.wgsl reads it."""

PIECE = np.dtype([("place", "f4", 6), ("pair", "u4")])

RAY_TRIANGLE = np.dtype(
    [
        ("corner_0", "f4", 3), ("center_x", "f4"),
        ("corner_1", "f4", 3), ("center_y", "f4"),
        ("corner_2", "f4", 3), ("valid", "u4"),
        ("direction_x", "f4", 3), ("face", "u4"),
        ("direction_y", "f4", 3), ("object", "u4"),
        ("direction_one", "f4", 3), ("scale_x", "f4"),
        ("origin_x", "f4", 3), ("scale_y", "f4"),
        ("origin_y", "f4", 3), ("scale_one", "f4"),
        ("origin_one", "f4", 3), ("padding_0", "u4"),
        ("anchor", "f4", 3), ("padding_1", "u4"),
        ("incident_x", "f4", 3), ("padding_2", "u4"),
        ("incident_y", "f4", 3), ("padding_3", "u4"),
        ("incident_one", "f4", 3), ("padding_4", "u4"),
    ]
)  # fmt: skip

SPECULAR = np.uint32(0x80000000)
"""What marks the front of a specular surface among the triangles seen."""


def number_texture() -> dict[str, Any]:
    """A texture of whole numbers, in a layout."""
    return {"texture": {"view_dimension": "2d", "sample_type": "uint"}}


@cache
def data_layout() -> wgpu.GPUBindGroupLayout:
    """The layout of group 2: the scene, the ray triangles, the pairs and the pieces."""
    return layout_of(*5 * [STORAGE], stages=wgpu.ShaderStage.VERTEX | wgpu.ShaderStage.FRAGMENT)


@cache
def owners_layout() -> wgpu.GPUBindGroupLayout:
    """The layout of group 3 while pairs are drawn: the pixels' ray triangles."""
    return layout_of(number_texture())


class Visibility:
    """What the rays of one picture meet.

    Parameters
    ----------
    buffers : SceneBuffers
    size : (width, height)
        Of the picture.
    bare : bool
        Whether the ray triangles are drawn where their own picture says, or where the surface is that they are on.
    """

    def __init__(self, buffers: SceneBuffers, size: tuple[int, int], bare: bool) -> None:
        self._buffers = buffers
        self._owners = make_target(size, (NUMBER_FORMAT,))
        self._seen = make_target(size, (NUMBER_FORMAT,), depth=self._owners.depth)
        owners, seen = self._owners.textures[0].create_view(), self._seen.textures[0].create_view()
        self._owners_group = bind(owners_layout(), [owners])
        self.views = owners, seen
        self.depth = self._owners.depth
        self._rooms: list[wgpu.GPUBuffer | None] = [None, None, None]
        self._data: wgpu.GPUBindGroup | None = None
        self._pieces, self._count = 0, 0
        module = shader_module("gpu/vertices.wgsl", "methods/visibility.wgsl")
        self._owner = make_pipeline(
            module,
            "bare_owner_vertex" if bare else "surface_owner_vertex",
            "owner",
            (NUMBER_FORMAT,),
            buffers=(),
            groups=(data_layout(),),
            cull="none" if bare else "back",
        )
        self._visible = make_pipeline(
            module, "piece_vertex", "visible", (NUMBER_FORMAT,), buffers=(), groups=(data_layout(), owners_layout())
        )

    def write(self, triangles: np.ndarray, beams: Beams, plan: Plan, fronts: np.ndarray) -> None:
        """Take over a plan.

        Parameters
        ----------
        triangles : (K,) of `RAY_TRIANGLE`
            All ray triangles; what the beams know of them is filled in here.
        beams : Beams
        plan : Plan
        fronts : (F,) bool
            The scene triangles whose front is specular.
        """
        self._count, self._pieces = len(triangles), len(plan.owner)
        queue = get_device().queue
        shown = beams.number
        triangles["center_x"][shown], triangles["center_y"][shown] = beams.center.T
        triangles["anchor"][shown] = beams.anchor
        for axis, name in enumerate(("x", "y", "one")):
            triangles[f"direction_{name}"][shown] = beams.direction[:, :, axis]
            triangles[f"origin_{name}"][shown] = beams.origin[:, :, axis]
            triangles[f"scale_{name}"][shown] = beams.scale[:, axis]
        ray_triangle, face, side = plan.pair.T
        pairs = np.zeros(max(len(plan.pair), 1), PAIR)
        some = pairs[: len(plan.pair)]
        some["terms"], some["center"] = plan.terms, beams.center[ray_triangle]
        some["ray_triangle"] = beams.number[ray_triangle] + 1
        some["seen"] = face + 1 + np.where(fronts[face] & (side == 1), SPECULAR, np.uint32(0))
        pieces = np.zeros(max(len(plan.owner), 1), PIECE)
        pieces[: self._pieces]["place"] = plan.place.reshape(-1, 6)
        pieces[: self._pieces]["pair"] = plan.owner
        contents = [triangles, pairs, pieces]
        rooms = [roomy_buffer(room, content.nbytes) for room, content in zip(self._rooms, contents, strict=True)]
        if rooms != self._rooms:
            self._rooms = list(rooms)
            self._data = bind(data_layout(), [self._buffers.vertices, self._buffers.indices, *rooms])
        for room, content in zip(rooms, contents, strict=True):
            queue.write_buffer(room, 0, content)

    def draw(self, encoder: wgpu.GPUCommandEncoder, projection: ProjectionUniform) -> None:
        """Find every pixel's ray triangle, and what it sees."""
        for target, pipeline, count, group in (
            (self._owners, self._owner, self._count, None),
            (self._seen, self._visible, self._pieces, self._owners_group),
        ):
            render_pass = begin_pass(encoder, target)
            bind_scene(render_pass, self._buffers, projection)
            render_pass.set_bind_group(2, self._data)
            if group is not None:
                render_pass.set_bind_group(3, group)
            render_pass.set_pipeline(pipeline)
            render_pass.draw(3 * count)
            render_pass.end()

    def bind(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """Bind group 2."""
        render_pass.set_bind_group(2, self._data)

    @property
    def count(self) -> int:
        """How many ray triangles there are."""
        return self._count
