"""The one WebGPU device of the process."""

from __future__ import annotations

import os
import tempfile
from functools import cache

from anamorph.errors import AnamorphError

# Mesa complains on stderr when this is unset, and a user can do nothing about it.
os.environ.setdefault("XDG_RUNTIME_DIR", tempfile.gettempdir())

import wgpu

# A larger scene, texture or picture than WebGPU's guaranteed minimum is welcome wherever the adapter can hold it.
_LIMITS = (
    "max-texture-dimension-2d",
    "max-texture-array-layers",
    "max-buffer-size",
    "max-storage-buffer-binding-size",
)
_FEATURES = ("timestamp-query",)
"""What is asked for wherever the adapter has it; nothing depends on it."""


@cache
def get_adapter() -> wgpu.GPUAdapter:
    """The best adapter there is.

    Raises
    ------
    AnamorphError
        When there is none.
    """
    remedy = "no Vulkan, Metal or DirectX 12 adapter: install a GPU driver, or mesa-vulkan-drivers for software Vulkan"
    try:
        adapter = wgpu.gpu.request_adapter_sync(power_preference="high-performance")
    except RuntimeError as error:
        raise AnamorphError(remedy) from error
    if adapter is None or adapter.info["backend_type"] == "OpenGL":
        raise AnamorphError(remedy)
    return adapter


@cache
def get_device() -> wgpu.GPUDevice:
    """The process's device, made at the first call."""
    adapter = get_adapter()
    limits = {name: adapter.limits[name] for name in _LIMITS}
    try:
        features = [name for name in _FEATURES if name in adapter.features]
        return adapter.request_device_sync(required_limits=limits, required_features=features)
    except RuntimeError as error:
        raise AnamorphError(f"adapter {adapter_name()}: it gives no device ({str(error).splitlines()[0]})") from error


def adapter_name() -> str:
    """The adapter, its kind and its interface, for reports."""
    info = get_adapter().info
    return f"{info['device']} ({info['adapter_type']}, {info['backend_type']})"


def maximum_size() -> int:
    """The largest width or height of a picture, in pixels."""
    return get_device().limits["max-texture-dimension-2d"]
