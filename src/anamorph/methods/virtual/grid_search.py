"""The search of a scene's vertices on one reflector: of each, or of the corners of grids around the meshes.

Source: Estalella et al. 2005, section 5.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import wgpu

from anamorph.gpu.bindings import STORAGE, bind, layout_of
from anamorph.gpu.buffers import grown_buffer, storage_buffer
from anamorph.gpu.device import get_device, of_device
from anamorph.gpu.shaders import shader_module
from anamorph.methods.virtual.cube_search import HIDDEN, REFLECTED, WITHIN, search
from anamorph.methods.virtual.device_search import DeviceSearch, packed_points
from anamorph.methods.virtual.mesh_grid import Grid, joined, regular_grid
from anamorph.methods.virtual.octree import adapted_grid
from anamorph.methods.virtual.reflector_maps import FlatReflector, ReflectorMaps
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import Geometry

GRID_VERTEX = np.dtype([("corners", "u4", 8), ("place", "f4", 3), ("padding", "u4")])
"""`GridVertex` of interpolated.wgsl."""

WORKGROUP = 64


@dataclass(frozen=True)
class GridKind:
    """Which vertices are searched for.

    Parameters
    ----------
    kind : str
        "none": all of them. "regular": the corners of regular grids. "adaptive": those of grids that adapt themselves.
    share : float
        The cells of a regular grid, as a share of its mesh's vertices.
    iterations : int
        Steps of each search.
    again : bool
        Whether each search starts from what the last one found.
    """

    kind: str
    share: float
    iterations: int
    again: bool = False


@of_device
def _layout() -> wgpu.GPUBindGroupLayout:
    return layout_of(STORAGE, STORAGE, {"buffer": {"type": "storage"}}, stages=wgpu.ShaderStage.COMPUTE)


@of_device
def _pipeline() -> wgpu.GPUComputePipeline:
    stage = {"module": shader_module("methods/virtual/interpolated.wgsl"), "entry_point": "interpolate_vertices"}
    layout = get_device().create_pipeline_layout(bind_group_layouts=[_layout()])
    return get_device().create_compute_pipeline(layout=layout, compute=stage)


class GridSearch:
    """Finds the virtual vertices of a scene behind one reflector.

    Parameters
    ----------
    maps : ReflectorMaps or FlatReflector
    own : tuple of int
        The numbers of the reflector's meshes, whose vertices are not looked for where there are grids.
    geometry : Geometry
    kind : GridKind
        A plane takes all vertices.

    Attributes
    ----------
    searches : int
        How many points were searched for last, but for vertices in cells across the horizon.
    """

    def __init__(
        self, maps: ReflectorMaps | FlatReflector, own: tuple[int, ...], geometry: Geometry, kind: GridKind
    ) -> None:
        self._maps, self._kind = maps, kind
        self._meshes = [slice(*ends) for ends in zip(geometry.first_vertex, geometry.first_vertex[1:], strict=False)]
        self._own = own
        self._eye: tuple[float, ...] | None = None
        count = len(geometry.positions)
        self._plain = kind.kind == "none" or isinstance(maps, FlatReflector)
        self._points = storage_buffer(packed_points(geometry.positions))
        written = storage_buffer(np.zeros(max(count, 1), REFLECTED), wgpu.BufferUsage.COPY_SRC)
        # Of all vertices, or of those that no grid tells of.
        self._vertices = DeviceSearch(maps, self._points, count, None if self._plain else written, kind.again)
        self._corners: DeviceSearch | None = None
        self._held: list[wgpu.GPUBuffer | None] = [None, None, None]
        self.searches = count
        self.moved(geometry)

    @property
    def reflected(self) -> wgpu.GPUBuffer:
        """What is known of all vertices, (V,) of REFLECTED."""
        return self._vertices.reflected

    def moved(self, geometry: Geometry) -> None:
        """Follow the scene's vertices."""
        self._positions, self._eye = np.asarray(geometry.positions, float), None
        get_device().queue.write_buffer(self._points, 0, packed_points(geometry.positions))
        if not self._plain and self._kind.kind == "regular":
            self._regular()

    def record(self, encoder: wgpu.GPUCommandEncoder, camera: Camera, size: tuple[int, int]) -> None:
        """Record the search for a camera's eye, and what is interpolated."""
        eye = np.asarray(camera.position, float)
        if not self._plain:
            if self._kind.kind == "adaptive" and self._eye != tuple(eye):
                self._adapt(camera, size)
            self._eye = tuple(eye)
            if self._corners is not None:
                self._corners.record(encoder, eye, self._kind.iterations)
            compute_pass = encoder.begin_compute_pass()
            compute_pass.set_pipeline(_pipeline())
            compute_pass.set_bind_group(0, self._group)
            compute_pass.dispatch_workgroups(-(-len(self._positions) // WORKGROUP))
            compute_pass.end()
        self._vertices.record(encoder, eye, self._kind.iterations)

    def _regular(self) -> None:
        assert isinstance(self._maps, ReflectorMaps)
        grids = []
        for number, mesh in enumerate(self._meshes):
            vertices = self._positions[mesh]
            if number in self._own or not len(vertices):
                grids.append(_nowhere(len(vertices)))
                continue
            grid = regular_grid(vertices, self._kind.share)
            grids.append(grid.without(within(self._maps, grid.points), vertices))
        grid = joined(grids)
        points, count = storage_buffer(packed_points(grid.points)), len(grid.points)
        self._corners = DeviceSearch(self._maps, points, count, again=self._kind.again)
        self.searches = len(grid.points)
        self._take(grid, self._corners.reflected)

    def _adapt(self, camera: Camera, size: tuple[int, int]) -> None:
        assert isinstance(self._maps, ReflectorMaps)
        maps, eye = self._maps, np.asarray(camera.position, float)

        def found(points: np.ndarray) -> np.ndarray:
            return search(maps, eye, points, self._kind.iterations)

        def images(rows: np.ndarray) -> np.ndarray:
            x, y, w = camera.image(rows[:, 6:9], size).T
            seen = (rows[:, 11] < 0.5 * (HIDDEN + WITHIN)) & (w > 0.0)
            return np.where(seen, np.stack([x, y]) / np.where(seen, w, 1.0), np.nan).T

        grids, rows = [], []
        self.searches = 0
        for number, mesh in enumerate(self._meshes):
            vertices = self._positions[mesh]
            if number in self._own or not len(vertices):
                grids.append(_nowhere(len(vertices)))
                rows.append(np.zeros((1, 12)))
                continue
            adapted = adapted_grid(vertices, found, images)
            grids.append(adapted.grid)
            rows.append(adapted.found)
            self.searches += adapted.searches
        known = np.concatenate(rows)
        records = np.zeros(len(known), REFLECTED)
        records["place"], records["behind"], records["error"] = known[:, :3], known[:, 6:9], known[:, 10]
        records["length"] = known[:, 9] * np.choose(known[:, 11].astype(int), [1.0, -1.0, 0.0])
        self._held[2] = grown_buffer(self._held[2], records.nbytes)
        get_device().queue.write_buffer(self._held[2], 0, records)
        self._take(joined(grids), self._held[2])

    def _take(self, grid: Grid, known: wgpu.GPUBuffer) -> None:
        """Interpolate between these points from now on."""
        vertices = np.zeros(len(grid.corners), GRID_VERTEX)
        vertices["corners"], vertices["place"] = grid.corners, grid.places
        before = self._held[:2]
        self._held[:2] = known, grown_buffer(self._held[1], vertices.nbytes)
        if before != self._held[:2]:
            self._group = bind(_layout(), [*self._held[:2], self.reflected])
        get_device().queue.write_buffer(self._held[1], 0, vertices)


def within(maps: ReflectorMaps, points: np.ndarray) -> np.ndarray:
    """Which of the points (N, 3) are inside of a reflector, whatever the eye."""
    away = np.array([1e3 * np.abs(maps.positions).max(), 0.0, 0.0])
    return search(maps, maps.center + away, points, 0)[:, 11] == WITHIN


def _nowhere(count: int) -> Grid:
    """The grid of vertices that are not looked for."""
    return Grid(np.zeros((1, 3)), np.zeros((count, 8), np.int64), np.zeros((count, 3)))
