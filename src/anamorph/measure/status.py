"""How the pixels of a frame got their value, as shares."""

from __future__ import annotations

import numpy as np

from anamorph.frame import Frame, Status

STATUS_NAMES = tuple(status.name.lower().replace("_", " ") for status in Status)


def status_shares(frame: Frame, counted: np.ndarray) -> dict[str, float]:
    """How the counted pixels (H, W) of a frame got their value: percent by status, the largest first."""
    if frame.status is None or not counted.any():
        return {}
    counts = np.bincount(frame.status[counted], minlength=len(Status))
    shares = {name: 100.0 * counts[status] / counted.sum() for name, status in zip(STATUS_NAMES, Status, strict=True)}
    return {name: float(share) for name, share in sorted(shares.items(), key=lambda item: -item[1]) if share > 0.0}
