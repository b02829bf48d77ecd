"""What is recorded for a frame and handed to the device: at once, or in parts where it is much."""

from __future__ import annotations

import wgpu

from anamorph.gpu.device import get_device
from anamorph.gpu.drawing import submit, wait
from anamorph.gpu.timing import device_timer


class Recorder:
    """Makes the encoders of a session, and times what the device does for a frame."""

    def __init__(self) -> None:
        self._timer = device_timer()
        self._before = 0.0

    def begin(self) -> wgpu.GPUCommandEncoder:
        """Begin a frame."""
        self._before = 0.0
        return self._encoder()

    def part(self, encoder: wgpu.GPUCommandEncoder) -> wgpu.GPUCommandEncoder:
        """Have the device do what a frame has recorded so far, and go on with another encoder when that is done."""
        self.submit(encoder)
        self._before = self.wait() or 0.0
        return self._encoder()

    def submit(self, encoder: wgpu.GPUCommandEncoder) -> None:
        """Hand over what a frame has recorded last."""
        if self._timer is not None:
            self._timer.end(encoder)
        submit(encoder)

    def wait(self) -> float | None:
        """Return when the device has done all that was handed over: with its milliseconds for the frame, or None."""
        if self._timer is None:
            wait()
            return None
        milliseconds = self._timer.wait()
        return None if milliseconds is None else self._before + milliseconds

    def _encoder(self) -> wgpu.GPUCommandEncoder:
        encoder = get_device().create_command_encoder()
        if self._timer is not None:
            self._timer.begin(encoder)
        return encoder
