"""The one WebGPU device of the process."""

from __future__ import annotations

import os
import tempfile
import threading
from collections.abc import Callable, Hashable
from functools import lru_cache, wraps
from typing import Any, ParamSpec, TypeVar

from anamorph.base.errors import AnamorphError

# Mesa complains on stderr when this is unset, and a user can do nothing about it.
os.environ.setdefault("XDG_RUNTIME_DIR", tempfile.gettempdir())

import wgpu

# A larger scene, texture or image than WebGPU's guaranteed minimum is welcome wherever the adapter can hold it.
_LIMITS = ("max-texture-dimension-2d", "max-texture-array-layers", "max-buffer-size", "max-storage-buffer-binding-size")
_FEATURES = ("timestamp-query",)
"""What is asked for wherever the adapter has it; nothing depends on it."""


_Given = ParamSpec("_Given")
_Made = TypeVar("_Made")
_forgetful: list[Any] = []


class _Process:
    """What a forked process learns of the one that it comes from.

    Attributes
    ----------
    making : RLock
        Held by the one thread that makes something on the device: two that make the same would each get their own, and
        mix what lives on two devices.
    has_device : bool
        Whether an adapter was asked for.
    inherited : bool
        Whether that was in a process from which this one was forked. The threads of the driver are not copied, so that
        whoever waits for the device would wait forever.
    """

    making = threading.RLock()
    has_device = False
    inherited = False


def _forked() -> None:
    _Process.making = threading.RLock()
    _Process.inherited = _Process.inherited or _Process.has_device


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forked)


def of_device(make: Callable[_Given, _Made]) -> Callable[_Given, _Made]:
    """Make once what lives on the device, as `functools.cache` does, until the device is forgotten."""
    return of_device_last(None)(make)


def of_device_last(count: int | None) -> Callable[[Callable[_Given, _Made]], Callable[_Given, _Made]]:
    """Like `of_device`, for what is large: only the `count` that were asked for last are kept."""

    def remembering(make: Callable[_Given, _Made]) -> Callable[_Given, _Made]:
        remembered = lru_cache(count)(make)
        _forgetful.append(remembered)

        @wraps(make)
        def one_at_a_time(*given: _Given.args, **named: _Given.kwargs) -> _Made:
            if _Process.inherited:
                raise AnamorphError(
                    "this process was forked from one that had drawn, and cannot use its device; start processes by "
                    "multiprocessing.get_context('spawn')"
                )
            with _Process.making:
                return remembered(*given, **named)  # type: ignore[arg-type]

        return one_at_a_time

    return remembering


@of_device
def _made() -> dict[Hashable, Any]:
    return {}


def once(key: Hashable, make: Callable[[], Any]) -> Any:
    """What `make` makes on the device, or has made before under the same key, which must say all about it."""
    with _Process.making:
        made = _made()
        if key not in made:
            made[key] = make()
        return made[key]


@of_device
def get_adapter() -> wgpu.GPUAdapter:
    """The best adapter there is.

    Raises
    ------
    AnamorphError
        When there is none.
    """
    _Process.has_device = True
    remedy = "no Vulkan, Metal or DirectX 12 adapter: install a GPU driver, or mesa-vulkan-drivers for software Vulkan"
    try:
        adapter = wgpu.gpu.request_adapter_sync(power_preference="high-performance")
    except RuntimeError as error:
        raise AnamorphError(remedy) from error
    if adapter is None or adapter.info["backend_type"] == "OpenGL":
        raise AnamorphError(remedy)
    return adapter


@of_device
def get_device() -> wgpu.GPUDevice:
    """The process's device, made at the first call, and anew at the first after it was forgotten."""
    adapter = get_adapter()
    limits = {name: adapter.limits[name] for name in _LIMITS}
    try:
        features = [name for name in _FEATURES if name in adapter.features]
        return adapter.request_device_sync(required_limits=limits, required_features=features)
    except RuntimeError as error:
        raise AnamorphError(f"adapter {adapter_name()}: it gives no device ({str(error).splitlines()[0]})") from error


@of_device
def _probe() -> wgpu.GPUBuffer:
    return get_device().create_buffer(size=4, usage=wgpu.BufferUsage.COPY_DST)


def device_lost() -> str | None:
    """Why the device is lost, in one line; None while it works.

    wgpu 0.32 tells nobody of a loss, but most calls after it raise `wgpu.GPUError`: this makes one. Ask before a
    window's next texture is taken (`get_current_texture`): on a lost device that call ends the process.
    """
    try:
        get_device().queue.write_buffer(_probe(), 0, bytes(4))
    except wgpu.GPUError as error:
        lines = [line.strip() for line in str(error).splitlines()]
        return next((line for line in lines if "lost" in line.lower()), None)
    return None


def forget_device() -> None:
    """Drop the device and all that was remembered of it: the next call of `get_device` makes another.

    Sessions, buffers and textures that others hold stay with the old device; open them again.
    """
    for remembered in _forgetful:
        remembered.cache_clear()


def forget_lost_device() -> None:
    """Drop the device where it is lost, see `forget_device`, and else nothing."""
    if device_lost() is not None:
        forget_device()


def adapter_name() -> str:
    """The adapter, its kind and its interface, for reports."""
    info = get_adapter().info
    return f"{info['device']} ({info['adapter_type']}, {info['backend_type']})"


def maximum_size() -> int:
    """The largest width or height of an image, in pixels."""
    return get_device().limits["max-texture-dimension-2d"]
