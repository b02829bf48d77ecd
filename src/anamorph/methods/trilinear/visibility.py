"""Which scene triangle each pixel's ray meets, on the device: what `plan` has planned, asked for per pixel.

Two passes, without a ray being cast: the ray triangles, each pixel getting the one whose part of the image it is in;
and the pieces of all pairs, of which each pixel keeps the nearest that holds it.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from typing import Any

import numpy as np
import wgpu

from anamorph.gpu.bindings import STORAGE, bind, layout_of, texture
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

FINENESS = 2
"""Samples of a pixel along each axis, where there is more than one."""


def _numbers() -> dict[str, Any]:
    return {"texture": {"view_dimension": "2d", "sample_type": "uint"}}


@of_device
def data_layout() -> wgpu.GPUBindGroupLayout:
    """The layout of group 2: the scene, the ray triangles, the pairs, the pieces and the lenses."""
    return layout_of(*6 * [STORAGE], stages=wgpu.ShaderStage.VERTEX | wgpu.ShaderStage.FRAGMENT)


@of_device
def views_layout() -> wgpu.GPUBindGroupLayout:
    """The layout of group 3: the pixels' ray triangles, what these see, and with straight edges the weights there; for
    rays that go on, the throughput before them; and the first two for several samples a pixel."""
    unfiltered = texture(filterable=False)
    return layout_of(_numbers(), _numbers(), unfiltered, unfiltered, _numbers(), _numbers())


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

    def textures(self) -> list[wgpu.GPUTextureView]:
        """Of both."""
        return [each.create_view() for each in (*self.owners.textures, *self.seen.textures)]


@of_device
def _unused(form: str) -> wgpu.GPUTextureView:
    """Stands in for a texture that nothing reads."""
    return make_target((1, 1), (form,)).textures[0].create_view()


def bind_views(
    views: Views | None,
    fine: Views | None = None,
    throughput: wgpu.GPUTextureView | None = None,
    owned: bool = False,
) -> wgpu.GPUBindGroup:
    """Group 3; with `owned` nothing but the pixels' ray triangles, for finding the rest."""
    number, weight = _unused(NUMBER_FORMAT), _unused(WEIGHTS_FORMAT)
    first, second = ([number, number, weight], [number, number])
    if views is not None:
        first = [*views.textures(), weight][:3] if not owned else [views.textures()[0], number, weight]
    if fine is not None:
        second = fine.textures()[:2]
    return bind(views_layout(), [*first, _unused(COLOR_FORMAT) if throughput is None else throughput, *second])


def make_views(size: tuple[int, int], straight: bool) -> Views:
    """Targets for an image of `size` (width, height)."""
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
    fine : bool
        Whether several samples of each pixel are looked at besides its middle.
    straight : bool
        Whether scene triangles have straight edges, and what lies between their corners is interpolated.
    glass : bool
        Whether some ray triangles are on lenses.
    meets_specular : bool
        Whether a specular front may be among what is seen.
    """

    bare: bool
    fine: bool
    straight: bool
    glass: bool
    meets_specular: bool


class Visibility:
    """What the rays of one image meet.

    Parameters
    ----------
    buffers : SceneBuffers
    lenses : buffer
        As `trilinear.wgsl` reads them.
    size : (width, height)
        Of the image.
    kind : Kind
    before : Visibility, optional
        Whose rays these send on.

    Attributes
    ----------
    views : Views
        By pixels' middles.
    fine : Views or None
        By samples.
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
        self.fine = make_views((FINENESS * size[0], FINENESS * size[1]), straight) if kind.fine else None
        self._owned = [bind_views(views, owned=True) for views in self._all()]
        self._source = bind_views(None if before is None else before.views)
        self._held: list[wgpu.GPUBuffer | None] = [None, None, None]
        self._data: wgpu.GPUBindGroup | None = None
        self._corners, self.count = 0, 0
        module = shader_module(f"methods/trilinear/{'straight/straight' if straight else 'visibility'}.wgsl")

        def pipeline(vertex: str, fragment: str, target: Target, **settings: Any) -> wgpu.GPURenderPipeline:
            formats = tuple(each.format for each in target.textures)
            groups = data_layout(), views_layout()
            return make_pipeline(module, vertex, fragment, formats, buffers=(), groups=groups, **settings)

        drawn, cull = ("bare", "none") if kind.bare else ("surface", "back")
        entry = "owner" if before is None else "following_owner"
        self._owner = pipeline(f"{drawn}_owner_vertex", entry, self.views.owners, cull=cull)
        pieces = ("straight_vertex", "straight_visible") if straight else ("piece_vertex", "visible")
        self._visible = [
            pipeline(*pieces, self.views.seen, constants={"PIXEL": pixel})
            for pixel in ((1.0, 1.0 / FINENESS) if kind.fine else (1.0,))
        ]

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
        self, encoder: wgpu.GPUCommandEncoder, recorder: Recorder, projection: ProjectionUniform
    ) -> Generator[None, None, wgpu.GPUCommandEncoder]:
        """Find every pixel's ray triangle, and what it sees; and every sample's, if there are several.

        Many pieces are handed to the device in parts, each a step; returns the encoder to go on with.
        """
        for views, visible, owned in zip(self._all(), self._visible, self._owned, strict=True):
            self._draw(encoder, projection, views.owners, self._owner, self._source, range(3 * self.count))
            for first in range(0, max(self._corners, 1), AT_ONCE):
                if first:
                    encoder = recorder.part(encoder)
                    yield
                some = range(first, min(first + AT_ONCE, self._corners))
                self._draw(encoder, projection, views.seen, visible, owned, some, keep=first > 0)
        return encoder

    def _all(self) -> list[Views]:
        return [views for views in (self.views, self.fine) if views is not None]

    def _draw(
        self,
        encoder: wgpu.GPUCommandEncoder,
        projection: ProjectionUniform,
        target: Target,
        pipeline: wgpu.GPURenderPipeline,
        group: wgpu.GPUBindGroup,
        corners: range,
        keep: bool = False,
    ) -> None:
        render_pass = begin_pass(encoder, target, clear=not keep)
        bind_scene(render_pass, self._buffers, projection)
        self.bind(render_pass)
        render_pass.set_bind_group(3, group)
        render_pass.set_pipeline(pipeline)
        render_pass.draw(len(corners), 1, corners.start)
        render_pass.end()

    def bind(self, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """Bind group 2."""
        render_pass.set_bind_group(2, self._data)
