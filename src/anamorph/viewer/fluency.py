"""How coarse the image is while things move: coarser before it stutters, finer as soon as there is time."""

from __future__ import annotations

from dataclasses import dataclass

RESOLUTIONS = (1.0, 0.75, 0.5, 0.35, 0.25)
"""Pixels of the image for each of the canvas, along one axis."""

SLOWEST = 50.0
"""Milliseconds that the methods may take for a frame: with what comes to it, fifteen images a second stay fluid."""

MOST_IMAGES = 60
"""A second, that a canvas is asked for at most."""

MARGIN = 0.75
"""The share of `SLOWEST` that a finer image must be expected to take before it is tried."""

PATIENCE = 2
"""Slow frames one after the other that make the image coarser: a single one has compiled something."""


@dataclass(frozen=True)
class Fluency:
    """The resolution of images that move, by its number in `RESOLUTIONS`, and how many frames in turn were slow."""

    number: int = 0
    slow: int = 0

    @property
    def resolution(self) -> float:
        """Pixels of the image for each of the canvas, along one axis."""
        return RESOLUTIONS[self.number]

    def after(self, milliseconds: float) -> Fluency:
        """What the next frame should be drawn at, when one at this resolution took so long."""
        if milliseconds > SLOWEST:
            if self.slow + 1 < PATIENCE:
                return Fluency(self.number, self.slow + 1)
            return Fluency(self._fast_enough(milliseconds))
        if self.number > 0 and self._expected(milliseconds, self.number - 1) < MARGIN * SLOWEST:
            return Fluency(self.number - 1)
        return Fluency(self.number)

    def _fast_enough(self, milliseconds: float) -> int:
        last = len(RESOLUTIONS) - 1
        coarser = range(min(self.number + 1, last), last)
        return next((number for number in coarser if self._expected(milliseconds, number) <= SLOWEST), last)

    def _expected(self, milliseconds: float, number: int) -> float:
        """What a frame would take at another resolution, if all its time went to pixels."""
        return milliseconds * (RESOLUTIONS[number] / self.resolution) ** 2


COARSEST = Fluency(len(RESOLUTIONS) - 1)


def scaled(size: tuple[int, int], resolution: float) -> tuple[int, int]:
    """The size (width, height) of an image at a resolution, in whole pixels."""
    width, height = size
    return max(round(width * resolution), 1), max(round(height * resolution), 1)
