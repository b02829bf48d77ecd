"""How long the device works on what an encoder has recorded, by timestamps that it writes itself."""

from __future__ import annotations

import numpy as np
import wgpu

from anamorph.gpu.device import get_device

FEATURE = "timestamp-query"
"""What a device must offer."""


class DeviceTimer:
    """Times what is recorded between `begin` and `end`: the last time that this was submitted.

    Timestamps belong to passes in WebGPU; empty ones before and after hold them, so that whoever draws between needs
    to know of nothing. Software Vulkan (Mesa's llvmpipe) writes them in order with render passes, but not with compute
    passes.
    """

    def __init__(self, nanoseconds: float) -> None:
        self._nanoseconds = nanoseconds
        self._queries = get_device().create_query_set(type="timestamp", count=2)
        usage = wgpu.BufferUsage.QUERY_RESOLVE | wgpu.BufferUsage.COPY_SRC
        self._buffer = get_device().create_buffer(size=16, usage=usage)

    def begin(self, encoder: wgpu.GPUCommandEncoder) -> None:
        """Record the beginning."""
        writes = {"query_set": self._queries, "end_of_pass_write_index": 0}
        encoder.begin_compute_pass(timestamp_writes=writes).end()

    def end(self, encoder: wgpu.GPUCommandEncoder) -> None:
        """Record the end."""
        writes = {"query_set": self._queries, "beginning_of_pass_write_index": 1}
        encoder.begin_compute_pass(timestamp_writes=writes).end()
        encoder.resolve_query_set(self._queries, 0, 2, self._buffer, 0)

    def wait(self) -> float | None:
        """Return when the device has finished all that was submitted, with the milliseconds; None if it tells none.

        Timestamps are read here only, because a read that waits on its own thread keeps others from submitting.
        """
        began, ended = np.frombuffer(get_device().queue.read_buffer(self._buffer), np.uint64).tolist()
        return (ended - began) * self._nanoseconds * 1e-6 if 0 < began <= ended else None


def device_timer() -> DeviceTimer | None:
    """A timer, where the device has one whose unit is known."""
    if FEATURE not in get_device().features:
        return None
    try:
        # wgpu gives timestamps in the device's own unit, and has no method for what that is.
        from wgpu.backends.wgpu_native import lib

        nanoseconds = float(lib.wgpuQueueGetTimestampPeriod(get_device().queue._internal))
    except (ImportError, AttributeError):
        return None
    return DeviceTimer(nanoseconds) if nanoseconds > 0.0 else None
