"""One level of the recursion on the device: its maps, and the triangles that show them.

Source: Kakimoto et al. 2007, section 4.4, which keeps surfaces and maps in a stack. Here each level has one atlas of
maps, in which the mirrors of the next level are drawn with that level's maps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import wgpu

from anamorph.gpu.bindings import SAMPLER, STORAGE, bind, layout_of, texture
from anamorph.gpu.buffers import SceneBuffers, grown_buffer
from anamorph.gpu.device import get_device
from anamorph.gpu.targets import map_sampler
from anamorph.methods.pervertex.atlas import Atlas, MapView
from anamorph.methods.pervertex.warp import MapPlan
from anamorph.optics.ray_meshes import BodyRays
from anamorph.projection import UNIFORM_BYTES
from anamorph.raymesh import RayStatus

SMOOTH, THREE_COLORS, ENDS = 1, 4, 8
"""Flags of a triangle, as the shaders read them."""

NOWHERE = (0.5, 0.5, 1.0, 0.0)
"""The lookup of a vertex that no map shows."""

MOST_VIEWS = 6
"""Maps of one patch: the faces of a cube map."""

CLIP_WORDS = 32
"""Of a `Projection`, those of its two matrices, which come first."""

STRIDE = -(-MOST_VIEWS * UNIFORM_BYTES // 256) * 256
"""Bytes from one patch's maps to the next: uniforms begin at multiples of 256."""


@dataclass(frozen=True)
class WarpDraw:
    """The triangles of one patch, and its number among the level's patches.

    Parameters
    ----------
    number, first, count : int
    refracts : bool
        Whether it is a lens.
    sides : int
        How many maps show it: two where its rays converge.
    cube : bool
        Whether a cube map shows it.
    """

    number: int
    first: int
    count: int
    refracts: bool
    sides: int
    cube: bool


def level_layout() -> wgpu.GPUBindGroupLayout:
    """The layout of group 2: what warp.wgsl declares."""
    maps = {"buffer": {"type": "uniform", "has_dynamic_offset": True}}
    return layout_of(
        maps, texture(), SAMPLER, texture(filterable=False), texture(filterable=False),
        STORAGE, STORAGE, STORAGE, STORAGE,
        stages=wgpu.ShaderStage.VERTEX | wgpu.ShaderStage.FRAGMENT,
    )  # fmt: skip


class Level:
    """The maps of one level, and the triangles that show them.

    Attributes
    ----------
    atlas : Atlas
    views : list of MapView
    maps, buffers : buffers
        The projections of the maps; and triangles, with their vertices' data.
    lookers : dict of int to WarpDraw
        The patch that looks up each map by its places; the faces of cube maps are looked up by directions.
    """

    def __init__(self, scene: SceneBuffers, layout: wgpu.GPUBindGroupLayout, antialias: int, ends: bool) -> None:
        self.atlas = Atlas(antialias, ends)
        self.views: list[MapView] = []
        self.lookers: dict[int, WarpDraw] = {}
        self._scene, self._layout = scene, layout
        self._patches: list[tuple[range, tuple[int, ...]]] = []
        self._triangles: list[np.ndarray] = []
        self._data: list[np.ndarray] = []
        self.maps: wgpu.GPUBuffer | None = None
        self.buffers: list[wgpu.GPUBuffer | None] = [None, None]
        self.clear()

    def clear(self) -> None:
        """Forget the last frame's maps and triangles."""
        for contents in (self.views, self.lookers, self._patches, self._triangles, self._data):
            contents.clear()
        self._triangle_count = self._data_count = 0

    def add(
        self, body_rays: BodyRays, faces: np.ndarray, plan: MapPlan | None, views: range, bounces: int | None = None
    ) -> WarpDraw:
        """Add a patch: the `faces` of a body, which show the maps of the numbers `views`; or, without a plan, none.

        With `bounces` it is a lens that ends the paths, because they may meet that many interfaces and no more.
        """
        if plan is None:
            lookups = np.broadcast_to(NOWHERE, (1 + len(body_rays.others), len(faces), 3, 4))
        else:
            lookups = plan.lookups[:, np.searchsorted(plan.vertices, body_rays.rays.faces[faces])]
        data = np.moveaxis(lookups, 0, 2)
        if body_rays.side.refracts:
            data = np.concatenate([data, corner_rays(body_rays, faces)], axis=2)
        data = data.reshape(len(faces), -1, 4)
        if body_rays.side.refracts:
            edge = body_rays.side.lens_edge()
            if bounces == 0:
                # The path does not even enter, and so meets no edge from within.
                edge[1, 3] = np.inf
            data = np.concatenate([np.broadcast_to(edge, (len(faces), 2, 4)), data], axis=1)
        flags = np.where(body_rays.side.smooth[faces], SMOOTH, 0) | (THREE_COLORS if len(lookups) > 1 else 0)
        flags |= 0 if bounces is None else ENDS
        first = self._data_count + data.shape[1] * np.arange(len(faces))
        triangles = np.stack([body_rays.side.triangles[faces], flags, first, np.zeros_like(first)], axis=1)
        cube = () if plan is None else plan.cube
        sides = 1 if cube else max(len(views), 1)
        draw = WarpDraw(
            len(self._patches), self._triangle_count, len(faces), body_rays.side.refracts, sides, bool(cube)
        )
        if plan is not None and not cube:
            self.lookers |= dict.fromkeys(views, draw)
        self._patches.append((views, cube))
        self._triangles.append(triangles.astype(np.uint32))
        self._data.append(data.astype(np.float32).reshape(-1, 4))
        self._triangle_count += len(faces)
        self._data_count += len(self._data[-1])
        return draw

    def place(self) -> None:
        """Lay out the maps, and hand all over to the device, where there is anything."""
        if not self._patches:
            return
        made = self.atlas.place(self.views)
        self.views = self.atlas.rectangles.maps
        contents = [np.concatenate(self._triangles), np.concatenate(self._data)]
        buffers = [grown_buffer(old, data.nbytes) for old, data in zip(self.buffers, contents, strict=True)]
        maps = self._patch_maps()
        fits = self.maps is not None and self.maps.size >= maps.nbytes
        if not fits:
            usage = wgpu.BufferUsage.UNIFORM | wgpu.BufferUsage.COPY_DST
            self.maps = get_device().create_buffer(size=2 * maps.nbytes, usage=usage)
        if made or not fits or buffers != self.buffers:
            self.buffers = list(buffers)
            self._bind()
        for buffer, data in zip([self.maps, *buffers], [maps, *contents], strict=True):
            get_device().queue.write_buffer(buffer, 0, data)

    def select(self, render_pass: wgpu.GPURenderPassEncoder, number: int) -> None:
        """Bind group 2 for one patch."""
        render_pass.set_bind_group(2, self._group, [STRIDE * number], 0, 1)

    def _patch_maps(self) -> np.ndarray:
        """The `PatchMaps` structures, (patches, STRIDE / 4) float32."""
        maps = np.zeros((len(self._patches), STRIDE // 4), np.float32)
        for row, (views, faces) in zip(maps, self._patches, strict=True):
            slots = row[: MOST_VIEWS * UNIFORM_BYTES // 4].reshape(MOST_VIEWS, -1)
            if not views:
                continue
            words = np.stack([self.atlas.rectangles.projections[view] for view in views])
            if faces:
                # All faces tell the viewpoint; nothing has a place in those that are not drawn.
                slots[:] = words[0]
                slots[:, :CLIP_WORDS] = 0.0
            slots[list(faces or range(len(views)))] = words
        return maps

    def _bind(self) -> None:
        resources = [
            {"buffer": self.maps, "offset": 0, "size": MOST_VIEWS * UNIFORM_BYTES},
            self.atlas.color.create_view(),
            map_sampler(),
            self.atlas.depth.create_view(),
            self.atlas.end.create_view(),
            *self.buffers,
            self._scene.vertices,
            self._scene.indices,
        ]
        self._group = bind(self._layout, resources)


def corner_rays(body_rays: BodyRays, faces: np.ndarray) -> np.ndarray:
    """A lens's rays of green light at the corners of `faces`, (F, 3, 2, 4).

    First the origin and the share of the light that goes this way, then the direction and 1 where reflection in the
    glass is total.
    """
    rays = body_rays.rays
    assert rays.transmittance is not None
    total = rays.status == RayStatus.TOTAL_REFLECTION
    rows = [np.column_stack([rays.origins, rays.transmittance]), np.column_stack([rays.directions, total])]
    return np.stack(rows, axis=1)[rays.faces[faces]]
