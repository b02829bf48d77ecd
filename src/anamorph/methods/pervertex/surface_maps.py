"""Maps of surfaces on the device: which triangle each texel sees, how near, and a pyramid of what is nearest."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import wgpu

from anamorph.gpu.bindings import STORAGE, bind, depths, layout_of, numbers, texture
from anamorph.gpu.buffers import SceneBuffers, grown_buffer
from anamorph.gpu.device import get_device, of_device
from anamorph.gpu.drawing import bind_scene, make_pipeline, runs
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import DEPTH_FORMAT, begin_depth_pass, begin_pass, make_target, make_texture
from anamorph.methods.pervertex.rectangles import MOST_TEXELS, Rectangles, SceneMap, widest_side
from anamorph.methods.pervertex.silhouettes import WORDS, edges_of, silhouettes
from anamorph.scene.geometry import Geometry

SURFACE_FORMAT = "rgba32uint"
NEAREST_FORMAT = "r32float"
LEVELS = 5
"""Of the pyramid: cells of 2 to 32 texels."""

ALIGNMENT = 1 << LEVELS
"""Maps begin at its multiples, as the largest cells do."""

SPARE = 1.4
"""How much wider and higher than needed the textures are made: a moving eye does not bring new ones every frame."""


@of_device
def _map_layout() -> wgpu.GPUBindGroupLayout:
    return layout_of(STORAGE, STORAGE, stages=wgpu.ShaderStage.VERTEX)


@of_device
def _pyramid_layout() -> wgpu.GPUBindGroupLayout:
    return layout_of(numbers(), texture(filterable=False), depths())


@of_device
def _silhouette_layout() -> wgpu.GPUBindGroupLayout:
    return layout_of(STORAGE, numbers(), stages=wgpu.ShaderStage.VERTEX | wgpu.ShaderStage.FRAGMENT)


@of_device
def _pyramid_pipelines() -> tuple[wgpu.GPURenderPipeline, wgpu.GPURenderPipeline]:
    module = shader_module("methods/pervertex/nearest.wgsl")
    layout = get_device().create_pipeline_layout(bind_group_layouts=[_pyramid_layout()])
    first, others = (
        get_device().create_render_pipeline(
            layout=layout,
            vertex={"module": module, "entry_point": "covering_vertex"},
            fragment={"module": module, "entry_point": fragment, "targets": [{"format": NEAREST_FORMAT}]},
            primitive={"topology": "triangle-list"},
        )
        for fragment in ("nearest_surface", "nearest_of_four")
    )
    return first, others


class SurfaceMaps:
    """All maps of a frame in one texture.

    Attributes
    ----------
    surfaces, silhouettes, nearest : textures
        They are other ones after `place` has returned True.
    rectangles : Rectangles
        Where each map is.
    """

    def __init__(self, scene: SceneBuffers, geometry: Geometry) -> None:
        self._scene, self._edges, self._positions = scene, edges_of(geometry), geometry.positions
        self._size = (0, 0)
        self._records: wgpu.GPUBuffer | None = None
        self._group = bind(_map_layout(), [scene.vertices, scene.indices])
        self._pipeline = make_pipeline(
            shader_module("methods/pervertex/surface_map.wgsl"),
            "map_vertex",
            "map_surface",
            (SURFACE_FORMAT,),
            buffers=(),
            groups=(_map_layout(),),
        )
        self._silhouette_pipeline = make_pipeline(
            shader_module("methods/pervertex/silhouettes.wgsl"),
            "silhouette_vertex",
            "silhouette",
            (),
            buffers=(),
            groups=(_silhouette_layout(),),
        )
        self.rectangles: Rectangles[SceneMap] = Rectangles(MOST_TEXELS, ALIGNMENT)
        self._used = (1, 1)

    def place(self, maps: Sequence[SceneMap]) -> bool:
        """Give each of the maps its rectangle, and tell whether the textures are new ones."""
        needed = self.rectangles.place(maps)
        self._used = max(needed[0], 1), max(needed[1], 1)
        if all(have >= want for have, want in zip(self._size, self._used, strict=True)):
            return False
        self._make((_side(self._used[0]), _side(self._used[1])))
        return True

    def _make(self, size: tuple[int, int]) -> None:
        self._size = size
        self._target = make_target(size, (SURFACE_FORMAT,))
        self.surfaces = self._target.textures[0]
        self.silhouettes = make_texture(size, DEPTH_FORMAT)
        self._missed = make_target(size, (), depth=self.silhouettes.create_view())
        self._records = None
        half = size[0] // 2, size[1] // 2
        self.nearest = make_texture(half, NEAREST_FORMAT, levels=LEVELS)
        levels = [
            self.nearest.create_view(dimension="2d", base_mip_level=level, mip_level_count=1) for level in range(LEVELS)
        ]
        self._levels = [
            (
                levels[level],
                bind(
                    _pyramid_layout(),
                    [self.surfaces.create_view(), levels[level - 1 if level else 1], self._missed.depth],
                ),
            )
            for level in range(LEVELS)
        ]

    def moved(self, geometry: Geometry) -> None:
        """Follow the scene's vertices."""
        self._edges, self._positions = self._edges.moved(geometry), geometry.positions

    def _draw_silhouettes(self, encoder: wgpu.GPUCommandEncoder) -> None:
        found = silhouettes(self._edges, self._positions, self.rectangles.maps)
        records = np.concatenate([*found, np.zeros((1, WORDS), np.float32)])
        buffer = grown_buffer(self._records, records.nbytes)
        if buffer is not self._records:
            self._records = buffer
            self._group_of_silhouettes = bind(_silhouette_layout(), [buffer, self.surfaces.create_view()])
        get_device().queue.write_buffer(buffer, 0, records)
        depth_pass = begin_depth_pass(encoder, self._missed)
        depth_pass.set_pipeline(self._silhouette_pipeline)
        depth_pass.set_bind_group(2, self._group_of_silhouettes)
        first = 0
        for (_, uniform), own in zip(self.rectangles.within(depth_pass), found, strict=True):
            bind_scene(depth_pass, self._scene, uniform)
            depth_pass.draw(6 * len(own), 1, 6 * first)
            first += len(own)
        depth_pass.end()

    def draw(self, encoder: wgpu.GPUCommandEncoder) -> None:
        """Draw the maps, and then the pyramid."""
        render_pass = begin_pass(encoder, self._target)
        render_pass.set_pipeline(self._pipeline)
        render_pass.set_bind_group(2, self._group)
        for each, uniform in self.rectangles.within(render_pass):
            bind_scene(render_pass, self._scene, uniform)
            for first, last in runs(each.visible):
                start, end = int(self._scene.first_face[first]), int(self._scene.first_face[last])
                render_pass.draw(3 * (end - start), 1, 3 * start)
        render_pass.end()
        self._draw_silhouettes(encoder)
        for level, (view, group) in enumerate(self._levels):
            attachment = {"view": view, "load_op": "clear", "store_op": "store"}
            level_pass = encoder.begin_render_pass(color_attachments=[attachment])
            level_pass.set_pipeline(_pyramid_pipelines()[min(level, 1)])
            level_pass.set_bind_group(0, group)
            used, sides = (
                [-(-side >> (level + 1)) for side in self._used],
                [side >> (level + 1) for side in self._size],
            )
            level_pass.set_scissor_rect(0, 0, min(used[0], sides[0]), min(used[1], sides[1]))
            level_pass.draw(3)
            level_pass.end()


def _side(needed: int) -> int:
    """The side of a texture with so many texels: an odd number of alignments, three at least.

    No level of the pyramid then has a power of two texels a side: software Vulkan would compile shaders again.
    """
    widest = widest_side()
    wanted = min(int(SPARE * needed), widest) // ALIGNMENT
    return min((wanted | 1) * ALIGNMENT if wanted >= 3 else 3 * ALIGNMENT, widest)
