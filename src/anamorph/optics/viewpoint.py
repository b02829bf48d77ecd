"""The virtual viewpoint: the point nearest to all the lines of a ray mesh.

Source: Kakimoto et al. 2007, section 3.2. Deviation: the viewpoint is homogeneous, so that near-parallel rays lead to
the point at infinity without a jump.
"""

from __future__ import annotations

import numpy as np

PARALLEL = 1e-9
"""Below this mean squared sine of the angles between the rays, nothing in them tells how far the viewpoint is."""


def virtual_viewpoint(origins: np.ndarray, directions: np.ndarray, weights: np.ndarray | None = None) -> np.ndarray:
    """The homogeneous least-squares point (x, y, z, w) of lines, (4,) float64; w is 0 for parallel lines.

    It solves mean(I - d d^T) x = mean((I - d d^T) o).
    Scaled so that the first three components are finite, and that w > 0 for a point behind the rays' origins.

    Parameters
    ----------
    origins, directions : (N, 3) float64
        Points on the lines, and unit vectors along them.
    weights : (N,) float64, optional
        How much each line counts, in sum 1; all the same by default.
    """
    center = origins.mean(axis=0)
    around = origins - center
    shares = np.full(len(origins), 1.0 / len(origins)) if weights is None else weights
    matrix = np.eye(3) - (shares[:, None] * directions).T @ directions
    right_side = shares @ (around - np.einsum("ni,ni->n", directions, around)[:, None] * directions)
    values, vectors = np.linalg.eigh(matrix)
    # The eigenvector of the least eigenvalue runs along the rays: the one direction that may be undetermined.
    along = vectors[:, 0] * np.sign(vectors[:, 0] @ directions.sum(axis=0) or 1.0)
    across = vectors[:, 1:]
    sideways = across @ ((across.T @ right_side) / values[1:])
    # Solving values[0] * distance = -(along . right_side) for the distance behind the centre, as a ratio.
    pull, spread = -float(along @ right_side), float(values[0])
    if spread < PARALLEL * values[2]:
        if abs(pull) <= PARALLEL * np.linalg.norm(np.ptp(origins, axis=0)):
            return np.append(-along, 0.0)
        # The eigenvalue as the mean of squares that it is: of near-parallel rays it is all rounding.
        spread = float(shares @ np.sum((directions @ across) ** 2, axis=1))
    scale = max(abs(pull), spread)
    weight, distance = spread / scale, pull / scale
    return np.append(weight * (center + sideways) - distance * along, weight)
