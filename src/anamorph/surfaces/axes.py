"""A surface's own axes: rows right, up and outward; and vectors in them. Partly compiled."""

from __future__ import annotations

import numpy as np

from anamorph.base.compiled import compiled
from anamorph.base.errors import AnamorphError
from anamorph.base.vectors import Vector


def check_axes(name: str, axes: np.ndarray) -> None:
    """Refuse axes (3, 3) that are not perpendicular, of length one and right-handed."""
    axes = np.asarray(axes, float)
    if not (axes.shape == (3, 3) and np.allclose(axes @ axes.T, np.eye(3), atol=1e-9) and np.linalg.det(axes) > 0):
        raise AnamorphError(f"{name}: axes must be three perpendicular unit rows, right x up = outward")


@compiled
def into_axes(axes: np.ndarray, vector: Vector) -> Vector:
    """A world vector in the coordinates of axes, which are nine numbers."""
    return (
        axes[0] * vector[0] + axes[1] * vector[1] + axes[2] * vector[2],
        axes[3] * vector[0] + axes[4] * vector[1] + axes[5] * vector[2],
        axes[6] * vector[0] + axes[7] * vector[1] + axes[8] * vector[2],
    )


@compiled
def out_of_axes(axes: np.ndarray, vector: Vector) -> Vector:
    """A vector in the coordinates of axes, which are nine numbers, as a world vector."""
    return (
        axes[0] * vector[0] + axes[3] * vector[1] + axes[6] * vector[2],
        axes[1] * vector[0] + axes[4] * vector[1] + axes[7] * vector[2],
        axes[2] * vector[0] + axes[5] * vector[1] + axes[8] * vector[2],
    )
