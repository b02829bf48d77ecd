"""The samples of an image: whose they are, and what is nearest of what their rays see."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Sights(NamedTuple):
    """The samples of an image, (height, width) each, and what their rays see."""

    owner: np.ndarray
    """int32: the ray triangle, by its number in `Beams`, or less than 0."""
    way: np.ndarray
    """float64: the t from the near distance on to what is seen; infinite at first."""
    seen: np.ndarray
    """uint32: the word of what is seen; 0, which is the sky, at first."""

    @classmethod
    def reserved(cls, size: tuple[int, int]) -> Sights:
        """Arrays for an image of `size`, in which no sample has an owner."""
        shape = size[1], size[0]
        return cls(np.full(shape, -1, np.int32), np.full(shape, np.inf), np.zeros(shape, np.uint32))

    def clear(self) -> None:
        """Forget what was seen, and by whom."""
        self.owner[:], self.way[:], self.seen[:] = -1, np.inf, 0
