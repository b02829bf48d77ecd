"""How the pixels of a frame got their value, as shares."""

from __future__ import annotations

import numpy as np

from anamorph.frame import Frame, Status
from anamorph.scene.model import Scene

STATUS_NAMES = tuple(status.name.lower().replace("_", " ") for status in Status)


def status_shares(frame: Frame, counted: np.ndarray) -> dict[str, float]:
    """How the counted pixels (H, W) of a frame got their value: percent by status, the largest first."""
    if frame.status is None or not counted.any():
        return {}
    counts = np.bincount(frame.status[counted], minlength=len(Status))
    shares = {name: 100.0 * counts[status] / counted.sum() for name, status in zip(STATUS_NAMES, Status, strict=True)}
    return {name: float(share) for name, share in sorted(shares.items(), key=lambda item: -item[1]) if share > 0.0}


def gaps(frame: Frame, scene: Scene) -> tuple[float, float]:
    """The shares, from 0 to 1, of the pixels of mirrors and lenses that got no answer; needs the seen buffers.

    Returns
    -------
    lost : float
        Those for which the method has nothing to show.
    ended : float
        Those whose path ends at one more mirror or lens.
    """
    if frame.specular is None or frame.status is None or frame.object_id is None or not (frame.specular > 0).any():
        return 0.0, 0.0
    specular = np.array([False, *(mesh.specular for mesh in scene.meshes)])
    counted = frame.specular > 0
    outside = frame.status[counted] == Status.OUTSIDE
    ends = outside & specular[frame.object_id[counted]]
    return float((outside & ~ends).mean()), float(ends.mean())
