"""B-splines over a row of knots."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline


def basis(knots: np.ndarray, degree: int, at: np.ndarray, order: int = 0) -> np.ndarray:
    """All B-splines over `knots` at parameters (N,), or their derivatives of `order`: (N, poles)."""
    count = len(knots) - degree - 1
    if order > degree:
        return np.zeros((len(at), count))
    return BSpline(knots, np.eye(count), degree)(at, nu=order)
