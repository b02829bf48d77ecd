"""The ray mesh: triangles in the picture, each vertex of which carries a ray into the scene."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np


class RayStatus(IntEnum):
    """How a vertex got its ray, or why it has none that is seen.

    BACK_FACING: the eye sees the other side. TOTAL_REFLECTION: no light leaves the lens on this way. LEFT_BY_EDGE: the
    ray leaves the lens by its edge, and not by the other face.
    """

    OK = 0
    BACK_FACING = 1
    TOTAL_REFLECTION = 2
    LEFT_BY_EDGE = 3


@dataclass(frozen=True, eq=False)
class RayMesh:
    """What a specular surface does to the eye's rays, or a nonlinear camera made by hand.

    Parameters
    ----------
    picture : (V, 3) float64
        Homogeneous picture coordinates (x w, y w, w): x, y in pixels from the top left. Weights linear in these
        are linear on the surface in the world. A camera made by hand has w = 1.
    origins : (V, 3) float64
        Where each ray leaves, metres. Inside a triangle it is interpolated.
    directions : (V, 3) float64
        Of any length but 0. Inside a triangle they are interpolated as they are. Mirrors give them the length of
        the eye's distance, with which that is exact on a flat mirror.
    faces : (F, 3) int32
    status : (V,) uint8
        A `RayStatus` each.
    share : (V,) float64, optional
        What share of the light goes this way, where interfaces divide it.
    """

    picture: np.ndarray
    origins: np.ndarray
    directions: np.ndarray
    faces: np.ndarray
    status: np.ndarray
    share: np.ndarray | None = None

    def places(self) -> np.ndarray:
        """Where the vertices are in the picture, (V, 2) pixels; it means nothing for those behind the eye."""
        return self.picture[:, :2] / np.where(self.picture[:, 2:] > 0.0, self.picture[:, 2:], 1.0)

    def unit_directions(self) -> np.ndarray:
        """The directions normalised, (V, 3)."""
        return self.directions / np.linalg.norm(self.directions, axis=1, keepdims=True)
