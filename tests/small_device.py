"""A device that holds little."""

from __future__ import annotations

from anamorph.gpu.device import get_device


class SmallDevice:
    """The device, but for a limit of rows that one storage buffer may hold."""

    def __init__(self, limit):
        self._device, self.limits = get_device(), {**get_device().limits, "max-storage-buffer-binding-size": limit}

    def __getattr__(self, name):
        return getattr(self._device, name)
