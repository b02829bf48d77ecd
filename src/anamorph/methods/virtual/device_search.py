"""The paper's search on the device."""

from __future__ import annotations

import numpy as np
import wgpu

from anamorph.gpu.bindings import STORAGE, UNIFORM, bind, layout_of
from anamorph.gpu.buffers import storage_buffer
from anamorph.gpu.device import get_device, of_device
from anamorph.gpu.shaders import shader_module
from anamorph.methods.virtual.cube_search import REFLECTED
from anamorph.methods.virtual.reflector_maps import FlatReflector, ReflectorMaps

SEARCH = np.dtype(
    [
        ("eye", "f4", 3), ("side", "f4"), ("center", "f4", 3), ("size", "i4"),
        ("iterations", "u4"), ("count", "u4"), ("rest", "u4"), ("reach", "f4"),
        ("again", "u4"), ("padding", "u4", 3),
    ]
)  # fmt: skip
"""`Search` of cube_search.wgsl."""

MAP_TEXEL = np.dtype([("position", "f4", 3), ("padding_0", "f4"), ("normal", "f4", 3), ("padding_1", "f4")])
"""`MapTexel` of cube_search.wgsl."""

WORKGROUP = 64


@of_device
def _layout() -> wgpu.GPUBindGroupLayout:
    written = {"buffer": {"type": "storage"}}
    return layout_of(UNIFORM, STORAGE, STORAGE, written, stages=wgpu.ShaderStage.COMPUTE)


@of_device
def _pipeline() -> wgpu.GPUComputePipeline:
    stage = {"module": shader_module("methods/virtual/cube_search.wgsl"), "entry_point": "search_points"}
    layout = get_device().create_pipeline_layout(bind_group_layouts=[_layout()])
    return get_device().create_compute_pipeline(layout=layout, compute=stage)


def packed_points(points: np.ndarray) -> np.ndarray:
    """Points (N, 3) as the shader reads them."""
    return np.column_stack([points, np.ones(len(points))]).astype(np.float32)


class DeviceSearch:
    """Searches for where one reflector shows points.

    Parameters
    ----------
    maps : ReflectorMaps or FlatReflector
    points : buffer
        From `packed_points`.
    count : int
        How many there are.
    reflected : buffer, optional
        Where what is found goes, if it is not the search's own. Only those points are then searched for whose length
        there is not known.
    again : bool
        Whether each search starts from what the last one found.

    Attributes
    ----------
    reflected : buffer
        What was found, (count,) of REFLECTED.
    """

    def __init__(
        self,
        maps: ReflectorMaps | FlatReflector,
        points: wgpu.GPUBuffer,
        count: int,
        reflected: wgpu.GPUBuffer | None = None,
        again: bool = False,
    ) -> None:
        self._maps, self._count, self._rest, self._again = maps, count, int(reflected is not None), int(again)
        if isinstance(maps, FlatReflector):
            texels = np.zeros(1, MAP_TEXEL)
            texels["normal"] = maps.normal
            self._side, self._size, self._reach = 0.0, 0, 0.0
        else:
            texels = np.zeros(maps.positions.shape[:3], MAP_TEXEL)
            texels["position"], texels["normal"] = maps.positions, maps.normals
            self._side, self._size, self._reach = 1.0 if maps.outside else -1.0, maps.size, maps.reach
        given = wgpu.BufferUsage.UNIFORM | wgpu.BufferUsage.COPY_DST
        self._uniform = get_device().create_buffer(size=SEARCH.itemsize, usage=given)
        if reflected is None:
            reflected = storage_buffer(np.zeros(max(count, 1), REFLECTED), wgpu.BufferUsage.COPY_SRC)
        self.reflected = reflected
        self._group = bind(_layout(), [self._uniform, storage_buffer(texels), points, self.reflected])

    def record(self, encoder: wgpu.GPUCommandEncoder, eye: np.ndarray, iterations: int) -> None:
        """Record the search for an eye at (3,), with so many steps for each point."""
        search = np.zeros(1, SEARCH)
        search["eye"], search["center"] = eye - self._maps.center, self._maps.center
        search["side"], search["size"], search["reach"] = self._side, self._size, self._reach
        search["iterations"], search["count"], search["rest"] = iterations, self._count, self._rest
        search["again"] = self._again
        get_device().queue.write_buffer(self._uniform, 0, search)
        compute_pass = encoder.begin_compute_pass()
        compute_pass.set_pipeline(_pipeline())
        compute_pass.set_bind_group(0, self._group)
        compute_pass.dispatch_workgroups(-(-self._count // WORKGROUP))
        compute_pass.end()

    def found(self) -> np.ndarray:
        """Read what was found, (count,) of REFLECTED."""
        return np.frombuffer(get_device().queue.read_buffer(self.reflected), REFLECTED)[: self._count]
