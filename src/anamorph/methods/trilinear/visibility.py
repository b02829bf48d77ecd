"""What the samples of an image see, handed to the device; with straight edges it is found there.

Each sample has a ray triangle, and a word that says which scene triangle its ray meets first. Straight edges are drawn:
of the pieces of all pairs, each sample keeps the nearest that holds it.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass

import numpy as np
import wgpu

from anamorph.gpu.bindings import STORAGE, bind, layout_of, numbers, texture
from anamorph.gpu.buffers import SceneBuffers, grown_buffer
from anamorph.gpu.device import get_device, of_device
from anamorph.gpu.drawing import ProjectionUniform, bind_scene, make_pipeline
from anamorph.gpu.recording import Recorder
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import COLOR_FORMAT, begin_pass, make_target, make_texture
from anamorph.gpu.visibility import Rectangle

NUMBER_FORMAT = "r32uint"
WEIGHTS_FORMAT = "rg32float"
NEARNESS_FORMAT = "r32float"

AT_ONCE = 3 * 2**13
"""Corners of pieces that the device is given at once."""


@of_device
def data_layout() -> wgpu.GPUBindGroupLayout:
    """The layout of group 2: the scene, the ray triangles, the pieces with straight edges, and the lenses."""
    return layout_of(*5 * [STORAGE], stages=wgpu.ShaderStage.VERTEX | wgpu.ShaderStage.FRAGMENT)


@of_device
def views_layout() -> wgpu.GPUBindGroupLayout:
    """The layout of group 3: the samples' ray triangles, what these see, and with straight edges the weights there; for
    rays that go on, the throughput before them; and the depth of what the samples are on."""
    return layout_of(*2 * [numbers()], *3 * [texture(filterable=False)])


@of_device
def _unused(form: str) -> wgpu.GPUTextureView:
    """Stands in for a texture that nothing reads."""
    return make_texture((1, 1), form).create_view()


def bind_views(textures: Sequence[wgpu.GPUTexture | None]) -> wgpu.GPUBindGroup:
    """Group 3; what is not given is not read."""
    formats = NUMBER_FORMAT, NUMBER_FORMAT, WEIGHTS_FORMAT, COLOR_FORMAT, NEARNESS_FORMAT
    views = [
        _unused(form) if each is None else each.create_view() for each, form in zip(textures, formats, strict=True)
    ]
    return bind(views_layout(), views)


def put(held: wgpu.GPUTexture, rectangle: Rectangle, values: np.ndarray) -> None:
    """Replace a rectangle of a texture of numbers of four bytes."""
    x0, y0, x1, y1 = rectangle
    get_device().queue.write_texture(
        {"texture": held, "origin": (x0, y0, 0)},
        np.ascontiguousarray(values),
        {"bytes_per_row": 4 * (x1 - x0), "rows_per_image": y1 - y0},
        (x1 - x0, y1 - y0, 1),
    )


@dataclass(frozen=True)
class Kind:
    """What the passes over one image have to reckon with.

    Parameters
    ----------
    hidden : bool
        Whether something may stand before the mirrors and lenses: there are none for a ray mesh that is the camera.
    straight : bool
        Whether scene triangles have straight edges, and what lies between their corners is interpolated.
    glass : bool
        Whether some ray triangles are on lenses.
    """

    hidden: bool
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

    Attributes
    ----------
    owners, seen : texture
        Each sample's ray triangle, and the word of what it sees.
    weights : texture or None
        With straight edges, those of its second and third corner.
    """

    def __init__(self, buffers: SceneBuffers, lenses: wgpu.GPUBuffer, size: tuple[int, int], kind: Kind) -> None:
        self._buffers, self._lenses, self.size, self.kind = buffers, lenses, size, kind
        self.owners = make_texture(size, NUMBER_FORMAT)
        self._held: list[wgpu.GPUBuffer | None] = [None, None]
        self._data: wgpu.GPUBindGroup | None = None
        self._corners = 0
        formats = (NUMBER_FORMAT, WEIGHTS_FORMAT) if kind.straight else (NUMBER_FORMAT,)
        self._target = make_target(size, formats)
        self.seen, self.weights = self._target.textures[0], self._target.textures[1] if kind.straight else None
        if kind.straight:
            self._owned = bind_views([self.owners, *4 * [None]])
            self._pieces = make_pipeline(
                shader_module("methods/trilinear/straight/straight.wgsl"), "straight_vertex", "straight_visible",
                formats, buffers=(), groups=(data_layout(), views_layout()),
            )  # fmt: skip

    @property
    def depth(self) -> wgpu.GPUTextureView:
        """A depth that nothing is behind."""
        return self._target.depth

    def write(self, rectangle: Rectangle, owners: np.ndarray, triangles: np.ndarray, seen: np.ndarray | None) -> None:
        """Take over, of a rectangle, the samples' ray triangles and what these see; and the ray triangles, (K,) of
        `RAY_TRIANGLE`."""
        put(self.owners, rectangle, owners)
        if seen is not None:
            put(self.seen, rectangle, seen)
        self._hold(0, triangles)

    def write_straight(self, pieces: np.ndarray) -> None:
        """Take over pieces (T, 3) of `STRAIGHT_CORNER`."""
        self._corners = pieces.size
        self._hold(1, pieces)

    def _hold(self, place: int, content: np.ndarray) -> None:
        content = content if content.size else np.zeros(1, content.dtype)
        held = grown_buffer(self._held[place], content.nbytes)
        if held != self._held[place]:
            self._held[place], self._data = held, None
        get_device().queue.write_buffer(held, 0, content)

    def draw(
        self, encoder: wgpu.GPUCommandEncoder, recorder: Recorder, projection: ProjectionUniform
    ) -> Generator[None, None, wgpu.GPUCommandEncoder]:
        """Find what each sample sees, with straight edges.

        Many pieces are handed to the device in parts, each a step; returns the encoder to go on with.
        """
        for first in range(0, max(self._corners, 1), AT_ONCE):
            if first:
                encoder = recorder.part(encoder)
                yield
            render_pass = begin_pass(encoder, self._target, clear=first == 0)
            self.bind(render_pass, projection, self._owned)
            render_pass.set_pipeline(self._pieces)
            render_pass.draw(min(AT_ONCE, self._corners - first), 1, first)
            render_pass.end()
        return encoder

    def bind(
        self, render_pass: wgpu.GPURenderPassEncoder, projection: ProjectionUniform, views: wgpu.GPUBindGroup
    ) -> None:
        """Bind the scene, this, and views of it."""
        if self._data is None:
            held = [each or self._buffers.indices for each in self._held]
            self._data = bind(data_layout(), [self._buffers.vertices, self._buffers.indices, *held, self._lenses])
        bind_scene(render_pass, self._buffers, projection)
        render_pass.set_bind_group(2, self._data)
        render_pass.set_bind_group(3, views)
