"""An atlas: many maps of the scene in one texture, each in a rectangle of its own, drawn in one pass."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import partial

import numpy as np
import wgpu

from anamorph.gpu.buffers import SceneBuffers
from anamorph.gpu.device import get_device, maximum_size
from anamorph.gpu.drawing import ProjectionUniform, draw_depth, draw_scene, scene_pipelines
from anamorph.gpu.targets import COLOR_FORMAT, MAP_FORMATS, begin_depth_pass, begin_pass, make_target, make_texture
from anamorph.projection import Projection

SPARE = 1.15
"""How much wider and higher than needed the textures are made: a moving eye does not bring new ones every frame."""

LARGEST = 8192
"""Texels along a side of the textures, whatever the device could do."""

MOST_TEXELS = 1 << 24
"""Of all maps of an atlas, at one sample each: with colours, depths and points they take up to 44 bytes."""

SHRINKING = 0.9
"""By which factor, again and again, maps are made smaller that are too large together."""


Bound = Callable[[int, wgpu.GPURenderPassEncoder], None]
"""Given a map's number and its pass of depth: leaves the nearest depth wherever nothing of the map is to be drawn."""


class MapKind(Enum):
    """What of its maps an atlas draws: colours, depths, or where each texel's path ends."""

    COLOR = "color"
    DEPTH = "depth"
    END = "end"


@dataclass(frozen=True, eq=False)
class MapView:
    """One map: what it sees, and of what size.

    Parameters
    ----------
    projection : Projection
    size : (width, height)
        Texels.
    visible : (meshes,) bool
        The meshes that it may see.
    replaced : tuple of int
        Mirrors whose fronts `extra` draws.
    sky : bool
        Whether it sees the sky; else it is empty where it sees nothing.
    extra : callable, optional
        Draws into the map what else there is, given what is drawn and the pass.
    """

    projection: Projection
    size: tuple[int, int]
    visible: np.ndarray
    replaced: tuple[int, ...] = ()
    sky: bool = True
    extra: Callable[[MapKind, wgpu.GPURenderPassEncoder], None] | None = None


def arrange(
    sizes: Sequence[tuple[int, int]], widest: int, alignment: int = 1
) -> tuple[list[tuple[int, int]], tuple[int, int]]:
    """Corners of rectangles of `sizes` on shelves no wider than `widest`, and the room that they all take."""
    area = sum(width * height for width, height in sizes)
    longest = max((width for width, _ in sizes), default=0)
    limit = min(max(longest, int(1.1 * np.sqrt(area))), widest)
    corners = [(0, 0)] * len(sizes)
    x = y = shelf = right = 0
    for number in sorted(range(len(sizes)), key=lambda i: -sizes[i][1]):
        width, height = (-(-side // alignment) * alignment for side in sizes[number])
        if x > 0 and x + width > limit:
            x, y, shelf = 0, y + shelf, 0
        corners[number] = (x, y)
        x, shelf = x + width, max(shelf, height)
        right = max(right, x)
    return corners, (right, y + shelf)


def shrunk(sizes: Sequence[tuple[int, int]], widest: int, most: int, alignment: int = 1) -> list[tuple[int, int]]:
    """`sizes` as they are, or all smaller by one factor, so that they fit together on a square of `widest`.

    All of them have at most `most` texels, as far as maps of a texel allow.
    """
    fitting, scale = list(sizes), 1.0
    while (
        max(arrange(fitting, widest, alignment)[1]) > widest or sum(width * height for width, height in fitting) > most
    ):
        if all(size == (1, 1) for size in fitting):
            break
        scale *= SHRINKING
        fitting = [(max(int(scale * width), 1), max(int(scale * height), 1)) for width, height in sizes]
    return fitting


class Atlas:
    """The textures of one set of maps, which is laid out anew for each frame.

    Attributes
    ----------
    views : list of MapView
        The maps, smaller than they were asked for where the atlas cannot hold them all.
    corners : list of (x, y)
        Where each map begins.
    color, depth, end : textures
        Colours; depths with their slopes and the object seen; the point and the object at the end of each path. They
        are other ones after `place` has returned True.
    projections : list of float32 arrays
        Each map's `Projection` structure for shaders.
    """

    def __init__(self, antialias: int = 1, ends: bool = False) -> None:
        self._antialias, self._has_ends = antialias, ends
        self._size = (0, 0)
        self._uniforms: list[ProjectionUniform] = []
        self.views: list[MapView] = []
        self.corners: list[tuple[int, int]] = []
        self.projections: list[np.ndarray] = []

    def place(self, views: Sequence[MapView]) -> bool:
        """Give each of the maps its rectangle; whether the textures had to be made anew."""
        widest = min(maximum_size(), LARGEST)
        sizes = shrunk([view.size for view in views], widest, MOST_TEXELS // self._antialias)
        self.corners, needed = arrange(sizes, widest)
        self.views = [replace(view, size=size) for view, size in zip(views, sizes, strict=True)]
        if len(self._uniforms) < len(views):
            self._uniforms += [ProjectionUniform() for _ in range(2 * len(views) - len(self._uniforms))]
        self.projections = []
        for view, corner, uniform in zip(self.views, self.corners, self._uniforms, strict=False):
            self.projections.append(view.projection.uniform(view.size, corner))
            get_device().queue.write_buffer(uniform.buffer, 0, self.projections[-1])
        # Without a map there is a texture still, because shaders bind one.
        too_small = any(have < max(want, 1) for have, want in zip(self._size, needed, strict=True))
        if not too_small and self._size[0] * self._size[1] < 4 * max(needed[0] * needed[1], 256 * 256):
            return False
        self._make([min(int(SPARE * side) + 1, widest) for side in needed])
        return True

    def _make(self, size: Sequence[int]) -> None:
        self._size = width, height = size[0], size[1]
        square = (width, height)
        self.color = make_texture(square, COLOR_FORMAT)
        self.depth = make_texture(square, MAP_FORMATS[0])
        self.end = make_texture(square if self._has_ends else (1, 1), MAP_FORMATS[0])
        depths = make_target(square, MAP_FORMATS, textures=(self.depth,))
        self._targets = {
            MapKind.COLOR: make_target(square, (COLOR_FORMAT,), self._antialias, (self.color,)),
            MapKind.DEPTH: depths,
            MapKind.END: make_target(square, MAP_FORMATS, textures=(self.end,), depth=depths.depth),
        }

    def draw(
        self, encoder: wgpu.GPUCommandEncoder, buffers: SceneBuffers, kind: MapKind, bound: Bound | None = None
    ) -> None:
        """Draw the maps: what of them, `kind` says, and where, `bound` may."""
        if kind == MapKind.END and not self._has_ends:
            return
        samples = self._antialias if kind == MapKind.COLOR else 1
        target, pipelines = self._targets[kind], scene_pipelines(kind.value, samples, sky_image=buffers.sky_image)
        depth_pass = begin_depth_pass(encoder, target)
        for number, (view, uniform) in enumerate(self._within(depth_pass)):
            extra = None if bound is None else partial(bound, number)
            draw_depth(depth_pass, pipelines, buffers, uniform, view.visible, extra)
        depth_pass.end()
        render_pass = begin_pass(encoder, target, keep_depth=True)
        for view, uniform in self._within(render_pass):
            draw_scene(
                render_pass,
                pipelines,
                buffers,
                uniform,
                replaced=() if view.extra is None else view.replaced,
                visible=view.visible,
                sky=view.sky,
                extra=None if view.extra is None else partial(view.extra, kind),
            )
        render_pass.end()

    def _within(self, render_pass: wgpu.GPURenderPassEncoder) -> Iterator[tuple[MapView, ProjectionUniform]]:
        """Each map with its projection, while the pass draws into its rectangle."""
        for view, corner, uniform in zip(self.views, self.corners, self._uniforms, strict=False):
            render_pass.set_viewport(*corner, *view.size, 0.0, 1.0)
            render_pass.set_scissor_rect(*corner, *view.size)
            yield view, uniform
