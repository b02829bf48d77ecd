"""Which scene triangle each sample's ray meets, on the device: what `plan` has planned, asked for per sample.

Two passes, without a ray being cast: the ray triangles, each sample getting the one whose part of the image it is in;
and the pieces of all pairs, of which each sample keeps the nearest that holds it.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import wgpu

from anamorph.gpu.bindings import STORAGE, bind, layout_of, numbers, texture
from anamorph.gpu.buffers import SceneBuffers, grown_buffer
from anamorph.gpu.device import get_device, of_device
from anamorph.gpu.drawing import ProjectionUniform, bind_scene, make_pipeline
from anamorph.gpu.recording import Recorder
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import COLOR_FORMAT, Target, begin_pass, make_target
from anamorph.methods.trilinear.ray_records import RAY_TRIANGLE

NUMBER_FORMAT = "r32uint"
WEIGHTS_FORMAT = "rg32float"

AT_ONCE = 3 * 2**13
"""Corners of pieces that the device is given at once."""


@of_device
def data_layout() -> wgpu.GPUBindGroupLayout:
    """The layout of group 2: the scene, the ray triangles, the pairs, the pieces and the lenses."""
    return layout_of(*6 * [STORAGE], stages=wgpu.ShaderStage.VERTEX | wgpu.ShaderStage.FRAGMENT)


@of_device
def views_layout() -> wgpu.GPUBindGroupLayout:
    """The layout of group 3: the samples' ray triangles, what these see, and with straight edges the weights there; for
    rays that go on, the throughput before them."""
    unfiltered = texture(filterable=False)
    return layout_of(numbers(), numbers(), unfiltered, unfiltered)


@of_device
def _unused(form: str) -> wgpu.GPUTextureView:
    """Stands in for a texture that nothing reads."""
    return make_target((1, 1), (form,)).textures[0].create_view()


@dataclass(frozen=True, eq=False)
class Views:
    """What each sample of an image sees.

    Parameters
    ----------
    owners, seen : Target
        The samples' ray triangles, and what they see; both with one depth, that of what is seen.
    """

    owners: Target
    seen: Target

    @property
    def textures(self) -> list[wgpu.GPUTexture]:
        """Of both."""
        return [*self.owners.textures, *self.seen.textures]


def bind_views(textures: Sequence[wgpu.GPUTexture], throughput: wgpu.GPUTexture | None = None) -> wgpu.GPUBindGroup:
    """Group 3: the first of its textures, in their order, and the last; what is not given is not read."""
    formats = NUMBER_FORMAT, NUMBER_FORMAT, WEIGHTS_FORMAT, COLOR_FORMAT
    views = [*(each.create_view() for each in textures), *map(_unused, formats[len(textures) :])]
    return bind(views_layout(), [*views[:3], views[3] if throughput is None else throughput.create_view()])


def make_views(size: tuple[int, int], straight: bool) -> Views:
    """Targets for an image of `size` (width, height), samples."""
    owners = make_target(size, (NUMBER_FORMAT,))
    seen = make_target(size, (NUMBER_FORMAT, WEIGHTS_FORMAT)[: 1 + straight], depth=owners.depth)
    return Views(owners, seen)


@dataclass(frozen=True)
class Kind:
    """What the passes over one image have to reckon with.

    Parameters
    ----------
    bare : bool
        Whether ray triangles are drawn where their own image says, or where the surface is that they are on.
    side : int
        Samples along each side of a pixel.
    straight : bool
        Whether scene triangles have straight edges, and what lies between their corners is interpolated.
    glass : bool
        Whether some ray triangles are on lenses.
    """

    bare: bool
    side: int
    straight: bool
    glass: bool


class Visibility:
    """What the rays of one image meet.

    Parameters
    ----------
    buffers : SceneBuffers
    lenses : buffer
        As `visibility.wgsl` reads them.
    size : (width, height)
        Of the image, samples.
    kind : Kind
    before : Visibility, optional
        Whose rays these send on.

    Attributes
    ----------
    views : Views
    count : int
        How many ray triangles there are.
    """

    def __init__(
        self,
        buffers: SceneBuffers,
        lenses: wgpu.GPUBuffer,
        size: tuple[int, int],
        kind: Kind,
        before: Visibility | None = None,
    ) -> None:
        self._buffers, self._lenses, self.kind = buffers, lenses, kind
        straight = kind.straight
        self.views = make_views(size, straight)
        self._owned = bind_views(self.views.owners.textures)
        self._source = bind_views([] if before is None else before.views.textures)
        self._held: list[wgpu.GPUBuffer | None] = [None, None, None]
        self._data: wgpu.GPUBindGroup | None = None
        self._corners, self.count = 0, 0
        module = shader_module(f"methods/trilinear/{'straight/straight' if straight else 'visibility'}.wgsl")

        def pipeline(vertex: str, fragment: str, target: Target, **settings: Any) -> wgpu.GPURenderPipeline:
            formats = tuple(each.format for each in target.textures)
            groups = data_layout(), views_layout()
            return make_pipeline(module, vertex, fragment, formats, buffers=(), groups=groups, **settings)

        drawn, cull, nearest = ("bare", "none", "greater") if kind.bare else ("surface", "back", "greater-equal")
        entry = "owner" if before is None else "following_owner"
        self._owner = pipeline(f"{drawn}_owner_vertex", entry, self.views.owners, cull=cull, depth_compare=nearest)
        pieces = ("straight_vertex", "straight_visible") if straight else ("piece_vertex", "visible")
        self._visible = pipeline(*pieces, self.views.seen, constants={"PIXEL": 1.0 / kind.side})

    @property
    def many(self) -> bool:
        """Whether there are so many pieces that the device is given them in parts."""
        return self._corners > AT_ONCE

    def write(self, triangles: np.ndarray, pairs: np.ndarray, pieces: np.ndarray) -> None:
        """Take over ray triangles (K,) of `RAY_TRIANGLE`, pairs of `PAIR`, and pieces as the shader reads them."""
        assert triangles.dtype == RAY_TRIANGLE
        self.count, self._corners = len(triangles), 3 * len(pieces)
        contents = [each if len(each) else np.zeros(1, each.dtype) for each in (triangles, pairs, pieces)]
        held = [grown_buffer(buffer, content.nbytes) for buffer, content in zip(self._held, contents, strict=True)]
        if held != self._held:
            self._held = list(held)
            self._data = bind(data_layout(), [self._buffers.vertices, self._buffers.indices, *held, self._lenses])
        for buffer, content in zip(held, contents, strict=True):
            get_device().queue.write_buffer(buffer, 0, content)

    def draw(
        self,
        encoder: wgpu.GPUCommandEncoder,
        recorder: Recorder,
        projection: ProjectionUniform,
        depth: wgpu.GPUTextureView | None = None,
    ) -> Generator[None, None, wgpu.GPUCommandEncoder]:
        """Find every sample's ray triangle, and what it sees.

        With a `depth`, ray triangles are only found where nothing nearer is in it, and leave their own.

        Many pieces are handed to the device in parts, each a step; returns the encoder to go on with.
        """
        owners = self.views.owners if depth is None else replace(self.views.owners, depth=depth)
        render_pass = begin_pass(encoder, owners, keep_depth=depth is not None)
        self._draw(render_pass, projection, self._owner, self._source, range(3 * self.count))
        for first in range(0, max(self._corners, 1), AT_ONCE):
            if first:
                encoder = recorder.part(encoder)
                yield
            some = range(first, min(first + AT_ONCE, self._corners))
            render_pass = begin_pass(encoder, self.views.seen, clear=first == 0)
            self._draw(render_pass, projection, self._visible, self._owned, some)
        return encoder

    def _draw(
        self,
        render_pass: wgpu.GPURenderPassEncoder,
        projection: ProjectionUniform,
        pipeline: wgpu.GPURenderPipeline,
        group: wgpu.GPUBindGroup,
        corners: range,
    ) -> None:
        bind_scene(render_pass, self._buffers, projection)
        self.bind(render_pass)
        render_pass.set_bind_group(3, group)
        render_pass.set_pipeline(pipeline)
        render_pass.draw(len(corners), 1, corners.start)
        render_pass.end()

    def bind(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """Bind group 2."""
        render_pass.set_bind_group(2, self._data)
