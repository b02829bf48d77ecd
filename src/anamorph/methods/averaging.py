"""Images without steps at edges: the mean of several, each with its samples moved by part of a pixel."""

from __future__ import annotations

from collections.abc import Generator
from functools import partial
from itertools import product

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.base.steps import mapped
from anamorph.methods.session import Session
from anamorph.raymesh import RayMesh
from anamorph.scene.camera import Camera

MAXIMUM_SAMPLES = 32


def averaging(session: Session, camera: Camera | RayMesh, samples: int) -> Generator[tuple[int, int], None, np.ndarray]:
    """Draw samples x samples shifted images and return their mean, linear (H, W, 3) float32.

    Yields the images that are drawn, and their number.
    """
    if not isinstance(samples, int | np.integer) or not 1 <= samples <= MAXIMUM_SAMPLES:
        raise AnamorphError(f"samples is {samples}; give a whole number from 1 to {MAXIMUM_SAMPLES} a side")
    steps = (np.arange(samples) + 0.5) / samples - 0.5
    total: np.ndarray | float = 0.0
    for done, (y, x) in enumerate(product(steps, steps), start=1):
        yield from mapped(session.drawing(camera, (float(x), float(y))), partial(_as_step, done - 1, samples**2))
        total = total + session.color().astype(float)
        yield done, samples**2
    return np.asarray(total / samples**2, np.float32)


def _as_step(done: int, total: int, step: None) -> tuple[int, int]:
    """In the midst of an image."""
    return done, total
