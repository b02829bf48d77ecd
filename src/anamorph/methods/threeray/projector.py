"""Points projected by three-ray cameras, on the device: pairs of a camera and a point go in, projections come out.

Source: Mei, Popescu and Sacks 2007, section 5.1.
"""

from __future__ import annotations

import numpy as np
import wgpu

from anamorph.base.errors import AnamorphError
from anamorph.gpu.bindings import STORAGE, UNIFORM, bind, layout_of
from anamorph.gpu.buffers import SceneBuffers, grown_buffer, storage_buffer
from anamorph.gpu.device import get_device, of_device
from anamorph.gpu.shaders import shader_module
from anamorph.methods.threeray.cameras_seen import Cameras
from anamorph.methods.threeray.objects import Materials
from anamorph.methods.threeray.splat_records import POINT, PROJECTED, camera_records
from anamorph.raytriangle.on_device import packed_rays
from anamorph.raytriangle.scaled import scaled_rays

WORKGROUP = 64

BLOCK = 2**16
"""Projections that there is space for: the device makes a few million in a second."""

SEVERAL = 3
"""Projections that a point can have in one camera."""


@of_device
def _ray_layout() -> wgpu.GPUBindGroupLayout:
    return layout_of(UNIFORM, STORAGE, stages=wgpu.ShaderStage.COMPUTE)


@of_device
def _pair_layout() -> wgpu.GPUBindGroupLayout:
    written = {"buffer": {"type": "storage"}}
    return layout_of(*5 * [STORAGE], written, written, stages=wgpu.ShaderStage.COMPUTE)


@of_device
def _pipeline(roots: int) -> wgpu.GPUComputePipeline:
    layout = get_device().create_pipeline_layout(bind_group_layouts=[_ray_layout(), _pair_layout()])
    module = shader_module("methods/threeray/projected.wgsl")
    stage = {"module": module, "entry_point": "project_pairs", "constants": {"ROOTS": roots}}
    return get_device().create_compute_pipeline(layout=layout, compute=stage)


def most_points() -> int:
    """How many points the device takes."""
    return int(get_device().limits["max-storage-buffer-binding-size"]) // POINT.itemsize


class Projector:
    """Projects the points of a scene.

    Parameters
    ----------
    scene : SceneBuffers
    count : int
        How many points there are.
    middle : (3,) float64
        What the points are seen from, so that their differences are small.

    Attributes
    ----------
    buffers : list of buffer
        What draws projections binds: vertices, indices, cameras, points, pairs and projections.
    middle : (3,) float64

    Raises
    ------
    AnamorphError
        The device has no space for so many points.
    """

    def __init__(self, scene: SceneBuffers, count: int, middle: np.ndarray) -> None:
        most = most_points()
        if count > most:
            raise AnamorphError(
                f"threeray: splat draws at most {most} points on this device, and there are {count}; "
                "give a larger spacing"
            )
        self.middle = middle
        read = wgpu.BufferUsage.COPY_SRC
        self._scene = [scene.vertices, scene.indices]
        self._zeros = get_device().create_buffer(size=16, usage=wgpu.BufferUsage.UNIFORM)
        self._points = storage_buffer(np.zeros(max(count, 1), POINT))
        self._pairs = storage_buffer(np.zeros((BLOCK, 2), np.uint32))
        self._projected = storage_buffer(np.zeros(BLOCK, PROJECTED), read)
        self._counts = storage_buffer(np.zeros(3, np.uint32), read)
        self._held: list[wgpu.GPUBuffer | None] = [None, None]
        self._groups: list[wgpu.GPUBindGroup] = []
        self.buffers: list[wgpu.GPUBuffer] = []

    def place(self, points: np.ndarray) -> None:
        """Take over the points, (N,) of `POINT`."""
        if len(points):
            get_device().queue.write_buffer(self._points, 0, points)

    def look(self, cameras: Cameras, chosen: np.ndarray, materials: Materials) -> bool:
        """Take over the chosen cameras, and begin to count; whether the `buffers` are others than before."""
        queue = get_device().queue
        queue.write_buffer(self._counts, 0, np.zeros(3, np.uint32))
        rays = scaled_rays(cameras.origins[chosen], cameras.directions[chosen])
        contents = [packed_rays(rays, self.middle), camera_records(cameras, chosen, materials, rays.pace)]
        held = [grown_buffer(buffer, data.nbytes) for buffer, data in zip(self._held, contents, strict=True)]
        changed = held != self._held
        if changed:
            self._held = list(held)
            self.buffers = [*self._scene, held[1], self._points, self._pairs, self._projected]
            self._groups = [
                bind(_ray_layout(), [self._zeros, held[0]]),
                bind(_pair_layout(), [*self.buffers, self._counts]),
            ]
        for buffer, data in zip(held, contents, strict=True):
            queue.write_buffer(buffer, 0, data)
        return changed

    def record(self, encoder: wgpu.GPUCommandEncoder, pairs: np.ndarray, roots: int) -> None:
        """Record the projection of pairs (N, 2) uint32 with so many `roots` each, no more than `BLOCK` in all.

        What it has recorded must be handed over before this is called again.
        """
        queue = get_device().queue
        queue.write_buffer(self._pairs, 0, np.ascontiguousarray(pairs))
        queue.write_buffer(self._counts, 8, np.array([len(pairs)], np.uint32))
        compute_pass = encoder.begin_compute_pass()
        compute_pass.set_pipeline(_pipeline(roots))
        for number, group in enumerate(self._groups):
            compute_pass.set_bind_group(number, group)
        compute_pass.dispatch_workgroups(-(-len(pairs) // WORKGROUP))
        compute_pass.end()

    def counts(self) -> tuple[int, int]:
        """How many projections there were since `look`, and how many pairs had several."""
        valid, several, _ = np.frombuffer(get_device().queue.read_buffer(self._counts), np.uint32).tolist()
        return valid, several

    def projections(self, count: int) -> np.ndarray:
        """The first `count` projections that were made last, (count,) of `PROJECTED`."""
        data = get_device().queue.read_buffer(self._projected, 0, count * PROJECTED.itemsize)
        return np.frombuffer(data, PROJECTED)
