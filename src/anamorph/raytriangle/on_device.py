"""`project_points` on the graphics device, for many points and many ray triangles at once.

The device has float32 only. Scaled rays are made here in float64, points are taken as differences from a
middle near by, and both go to the device as sums of two floats. There (`points.wgsl`) roots are found in float32, and
polished, with their weights, in sums of two floats. What comes back are float64's roots, rounded to float32.

How near: in u and v, times 800 pixels, 1.6e-5 pixels at the median, 5e-5 at the 99th percentile and 8e-5 at most, over
a million roots inside random ray triangles, with coordinates about 1 or 1000, but for those at caustics. There, two
roots meet, and no float32 start tells them apart: of roots where the cubic's derivative is less than 1e-4 (over the
length of the ray's direction and the square of the parametric triangle's longest side: one in 15,000 of the random
ones), one in fifty or so is off by more than 1e-3 pixels. What two floats cannot hold is a parametric triangle smaller
than about 1e-6 of the distances between ray triangles and points. Near a caustic where the parametric triangle is small
both count: u and v are told to about 3e-14, over that derivative and over the triangle's share of those distances.
"""

from __future__ import annotations

import numpy as np
import wgpu

from anamorph.base.errors import AnamorphError
from anamorph.gpu.bindings import STORAGE, UNIFORM, bind, layout_of
from anamorph.gpu.buffers import storage_buffer
from anamorph.gpu.device import get_device, of_device
from anamorph.gpu.shaders import shader_module
from anamorph.raytriangle.points import Projections
from anamorph.raytriangle.scaled import ScaledRays, scaled_rays

WORKGROUP = 64

BLOCK = 2**20
"""Points times ray triangles in one dispatch: 48 MiB of results, and a quarter of the workgroups that one may have."""

SMALLEST, LARGEST = 1e-15, 1e15
"""Sizes and distances, in metres, of which products and quotients stay within the range of float32."""

RAY_TRIANGLE = np.dtype(
    [("vectors", "f4", (9, 2, 4)), ("size_and_shift", "f4", 4), ("extent", "f4"), ("blur", "f4"), ("flat", "f4"),
     ("padding", "f4")]
)  # fmt: skip
"""`RayTriangle` of points.wgsl."""

FOUND = np.dtype(
    {"names": ["t", "flags", "u", "v"], "formats": [("f4", 3), "u4", ("f4", 3), ("f4", 3)], "offsets": [0, 12, 16, 32],
     "itemsize": 48}
)  # fmt: skip
"""`Projections` of points.wgsl."""


def project_points_on_device(origins: np.ndarray, directions: np.ndarray, points: np.ndarray) -> Projections:
    """As `project_points`, on the graphics device: t, u and v hold float64's roots rounded to float32.

    Parameters
    ----------
    origins, directions : (3, 3) or (K, 3, 3) array
        A row for each of the three rays, of one ray triangle or of K.
    points : (N, 3) array
        The same for all ray triangles.

    Returns
    -------
    Projections
        (N, 3), or (K, N, 3) for K ray triangles, numbers of float32 in float64. Valid is, before rounding, a ray that
        passes by its point at up to 1e-7 of the distances, not 1e-9: a few more far outside the ray triangle.

    Raises
    ------
    AnamorphError
        If a number is not finite or out of float32's range, if all directions of a ray triangle are 0, or if there is
        no device.
    """
    points = np.asarray(points, float)
    if points.ndim != 2 or points.shape[1] != 3:
        raise AnamorphError(f"points: must be (N, 3) coordinates, not {points.shape}")
    if not np.isfinite(points).all():
        raise AnamorphError("points: coordinates must be finite numbers")
    rays = scaled_rays(origins, directions)
    if rays.center.ndim > 2:
        raise AnamorphError(f"ray triangle: origins must be (3, 3) or (K, 3, 3), not {(*rays.center.shape, 3)}")
    shape = (*rays.center.shape[:-1], len(points))
    middle = rays.center.reshape(-1, 3).mean(axis=0) if rays.center.size else np.zeros(3)
    triangles, around = packed_rays(rays, middle), points - middle
    if len(around) and np.abs(around).max() > LARGEST:
        raise AnamorphError(f"points: too far from the ray triangles for float32; keep them within {LARGEST:g} m")
    found = _found(triangles, two_floats(around))
    flags = found["flags"][..., None] >> np.arange(6, dtype=np.uint32) & 1 != 0
    t = found["t"] * np.reshape(rays.pace, (-1, 1, 1))
    return Projections(
        *(
            array.reshape(*shape, 3)
            for array in (t, found["u"].astype(float), found["v"].astype(float), flags[..., :3], flags[..., 3:])
        )
    )


def two_floats(values: np.ndarray) -> np.ndarray:
    """Numbers (..., 3) as sums of two floats, `Two` of two_floats.wgsl: (..., 2, 4)."""
    packed = np.zeros((*values.shape[:-1], 2, 4), np.float32)
    packed[..., 0, :3] = values
    packed[..., 1, :3] = values - packed[..., 0, :3]
    return packed


def packed_rays(rays: ScaledRays, middle: np.ndarray) -> np.ndarray:
    """The rays, whose points come as differences from `middle`: (K,) of `RAY_TRIANGLE`."""
    size, shift = np.ravel(rays.size), np.ravel(rays.shift)
    center = (rays.center - middle) + rays.remainder
    if not ((size >= SMALLEST).all() and (size <= LARGEST).all() and (np.abs(center) <= LARGEST).all()):
        raise AnamorphError(f"ray triangle: keep sizes and distances from {SMALLEST:g} to {LARGEST:g} m, for float32")
    packed = np.zeros(len(size), RAY_TRIANGLE)
    vectors = (center[..., None, :], rays.origins, rays.directions, rays.mean[..., None, :], rays.planes)
    packed["vectors"] = two_floats(np.concatenate(vectors, axis=-2).reshape(-1, 9, 3))
    for column, values in ((0, 1.0 / size), (2, shift)):
        packed["size_and_shift"][:, column] = values
        packed["size_and_shift"][:, column + 1] = values - packed["size_and_shift"][:, column]
    packed["extent"], packed["blur"] = np.ravel(rays.extent), np.ravel(rays.blur)
    packed["flat"] = np.ravel(rays.flat)
    return packed


@of_device
def _layout() -> wgpu.GPUBindGroupLayout:
    written = {"buffer": {"type": "storage"}}
    return layout_of(UNIFORM, STORAGE, STORAGE, written, stages=wgpu.ShaderStage.COMPUTE)


@of_device
def _pipeline() -> wgpu.GPUComputePipeline:
    module = shader_module("raytriangle/points.wgsl")
    layout = get_device().create_pipeline_layout(bind_group_layouts=[_layout()])
    return get_device().create_compute_pipeline(layout=layout, compute={"module": module, "entry_point": "project"})


def _found(triangles: np.ndarray, points: np.ndarray) -> np.ndarray:
    """The projections of all points (N, 2, 4) in all triangles (K,): (K, N) of `FOUND`."""
    found = np.zeros((len(triangles), len(points)), FOUND)
    if found.size == 0:
        return found
    columns = min(len(points), BLOCK)
    rows = BLOCK // columns
    usage = wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC
    buffer = get_device().create_buffer(size=min(BLOCK, found.size) * FOUND.itemsize, usage=usage)
    for column in range(0, len(points), columns):
        some = points[column : column + columns]
        some_buffer = storage_buffer(some)
        for row in range(0, len(triangles), rows):
            part = found[row : row + rows, column : column + columns]
            part[:] = _project(triangles[row : row + rows], some_buffer, len(some), buffer)
    return found


def _project(triangles: np.ndarray, points: wgpu.GPUBuffer, count: int, buffer: wgpu.GPUBuffer) -> np.ndarray:
    """One dispatch: (triangles, count) of `FOUND`, by way of `buffer`."""
    device = get_device()
    block = np.array([count, len(triangles), 0, 0], np.uint32)
    uniform = device.create_buffer_with_data(data=block, usage=wgpu.BufferUsage.UNIFORM)
    encoder = device.create_command_encoder()
    compute_pass = encoder.begin_compute_pass()
    compute_pass.set_pipeline(_pipeline())
    compute_pass.set_bind_group(0, bind(_layout(), [uniform, storage_buffer(triangles), points, buffer]))
    compute_pass.dispatch_workgroups(-(-count * len(triangles) // WORKGROUP))
    compute_pass.end()
    device.queue.submit([encoder.finish()])
    data = device.queue.read_buffer(buffer, 0, count * len(triangles) * FOUND.itemsize)
    return np.frombuffer(data, FOUND).reshape(len(triangles), count)
