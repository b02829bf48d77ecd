"""Rectangles of one texture, one for each map: every frame lays out its own."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

import numpy as np
import wgpu

from anamorph.gpu.device import get_device, maximum_size
from anamorph.gpu.drawing import ProjectionUniform
from anamorph.projection import Projection

LARGEST = 8192
"""Texels along a side of the textures, whatever the device could do."""

MOST_TEXELS = 1 << 24
"""Of all maps of a texture, at one sample each: with colours, depths and points they take up to 44 bytes."""

SHRINKING = 0.9
"""By which factor, again and again, maps are made smaller that are too large together."""


@dataclass(frozen=True, eq=False)
class SceneMap:
    """One map: what it sees, and of what size.

    Parameters
    ----------
    projection : Projection
    size : (width, height)
        Texels.
    visible : (meshes,) bool
        The meshes that it may see.
    """

    projection: Projection
    size: tuple[int, int]
    visible: np.ndarray


Map = TypeVar("Map", bound=SceneMap)


def widest_side() -> int:
    """Texels along a side of a texture of maps, at most."""
    return min(maximum_size(), LARGEST)


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


class Rectangles(Generic[Map]):
    """Where the maps of a frame are in their texture.

    Parameters
    ----------
    most : int
        Texels of all maps.
    alignment : int
        Rectangles begin at its multiples.

    Attributes
    ----------
    maps : list of SceneMap
        The maps, smaller than they were asked for where the texture cannot hold them all.
    corners : list of (x, y)
        Where each map begins.
    projections : list of float32 arrays
        Each map's `Projection` structure for shaders.
    """

    def __init__(self, most: int, alignment: int = 1) -> None:
        self._most, self._alignment = most, alignment
        self._uniforms: list[ProjectionUniform] = []
        self.maps: list[Map] = []
        self.corners: list[tuple[int, int]] = []
        self.projections: list[np.ndarray] = []

    @property
    def texels(self) -> int:
        """Of all maps."""
        return sum(width * height for width, height in (each.size for each in self.maps))

    def place(self, maps: Sequence[Map]) -> tuple[int, int]:
        """Give each of the maps its rectangle; the (width, height) that they take together."""
        sizes = shrunk([each.size for each in maps], widest_side(), self._most, self._alignment)
        self.corners, needed = arrange(sizes, widest_side(), self._alignment)
        self.maps = [replace(each, size=size) for each, size in zip(maps, sizes, strict=True)]
        if len(self._uniforms) < len(maps):
            self._uniforms += [ProjectionUniform() for _ in range(2 * len(maps) - len(self._uniforms))]
        self.projections = []
        for each, corner, uniform in zip(self.maps, self.corners, self._uniforms, strict=False):
            self.projections.append(each.projection.uniform(each.size, corner))
            get_device().queue.write_buffer(uniform.buffer, 0, self.projections[-1])
        return needed

    def within(self, render_pass: wgpu.GPURenderPassEncoder) -> Iterator[tuple[Map, ProjectionUniform]]:
        """Each map with its projection, while the pass draws into its rectangle."""
        for each, corner, uniform in zip(self.maps, self.corners, self._uniforms, strict=False):
            render_pass.set_viewport(*corner, *each.size, 0.0, 1.0)
            render_pass.set_scissor_rect(*corner, *each.size)
            yield each, uniform
