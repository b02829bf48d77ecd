"""An atlas: many maps of the scene in one texture, each in a rectangle of its own, drawn in one pass."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import partial

import wgpu

from anamorph.gpu.buffers import SceneBuffers
from anamorph.gpu.drawing import draw_depth, draw_scene, scene_pipelines
from anamorph.gpu.targets import COLOR_FORMAT, MAP_FORMATS, begin_depth_pass, begin_pass, make_target, make_texture
from anamorph.methods.pervertex.rectangles import MOST_TEXELS, Rectangles, SceneMap, widest_side

SPARE = 1.15
"""How much wider and higher than needed the textures are made: a moving eye does not bring new ones every frame."""

Bound = Callable[[int, wgpu.GPURenderPassEncoder], None]
"""Given a map's number and its pass of depth: leaves the nearest depth wherever nothing of the map is to be drawn."""


class MapKind(Enum):
    """What of its maps an atlas draws: colours, depths, or where each texel's path ends."""

    COLOR = "color"
    DEPTH = "depth"
    END = "end"


@dataclass(frozen=True, eq=False)
class MapView(SceneMap):
    """A map with colours.

    Parameters
    ----------
    projection, size, visible
        As of a `SceneMap`.
    replaced : tuple of int
        Mirrors whose fronts `extra` draws.
    sky : bool
        Whether it sees the sky; else it is empty where it sees nothing.
    extra : callable, optional
        Draws into the map what else there is, given what is drawn and the pass.
    """

    replaced: tuple[int, ...] = ()
    sky: bool = True
    extra: Callable[[MapKind, wgpu.GPURenderPassEncoder], None] | None = None


class Atlas:
    """The textures of one set of maps, laid out for each frame.

    Attributes
    ----------
    rectangles : Rectangles
        Where each map is.
    color, depth, end : textures
        Colours; depths with their slopes and the object seen; the point and the object at the end of each path. They
        are other ones after `place` has returned True.
    """

    def __init__(self, antialias: int = 1, ends: bool = False) -> None:
        self._antialias, self._has_ends = antialias, ends
        self._size = (0, 0)
        self.rectangles: Rectangles[MapView] = Rectangles(MOST_TEXELS // antialias)

    def place(self, views: Sequence[MapView]) -> bool:
        """Give each of the maps its rectangle, and tell whether the textures are new ones."""
        needed = self.rectangles.place(views)
        # Without a map there is a texture still, because shaders bind one.
        too_small = any(have < max(want, 1) for have, want in zip(self._size, needed, strict=True))
        if not too_small and self._size[0] * self._size[1] < 4 * max(needed[0] * needed[1], 256 * 256):
            return False
        self._make([min(int(SPARE * side) + 1, widest_side()) for side in needed])
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
        for number, (view, uniform) in enumerate(self.rectangles.within(depth_pass)):
            extra = None if bound is None else partial(bound, number)
            draw_depth(depth_pass, pipelines, buffers, uniform, view.visible, extra)
        depth_pass.end()
        render_pass = begin_pass(encoder, target, keep_depth=True)
        for view, uniform in self.rectangles.within(render_pass):
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
