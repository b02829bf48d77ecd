"""The ray mesh: triangles in the image, each vertex of which carries a ray into the scene."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np

from anamorph.base.errors import AnamorphError

LARGEST = 1e12
"""Beyond it float32, or a square, is soon at its end."""


class RayStatus(IntEnum):
    """How a vertex got its ray, or why it has none that is seen.

    BACK_FACING: the eye sees the other side. TOTAL_REFLECTION: no light leaves the lens on this way. LEFT_BY_EDGE: the
    ray leaves the lens by its edge, and not by the other face. FOLDED: the distortion of a real camera folds back here.
    OUTSIDE: beyond what a real camera sees. The device has a number of its own, 4, for rays that miss a surface.
    """

    OK = 0
    BACK_FACING = 1
    TOTAL_REFLECTION = 2
    LEFT_BY_EDGE = 3
    FOLDED = 5
    OUTSIDE = 6


@dataclass(frozen=True, eq=False)
class RayMesh:
    """What a specular surface does to the eye's rays, or a nonlinear camera made by hand.

    As a camera it shows what its rays meet from their origins on, and of what it holds `status` and `transmittance` are
    not read. Where its triangles lie over each other in the image, the first one is seen.

    Parameters
    ----------
    image : (V, 3) float64
        Homogeneous image coordinates (x w, y w, w): x, y in pixels from the top left. Weights linear in these
        are linear on the surface in the world. A camera made by hand has w = 1.
    origins : (V, 3) float64
        Where each ray leaves, metres. Inside a triangle it is interpolated.
    directions : (V, 3) float64
        Of any length but 0. Inside a triangle they are interpolated as they are. Mirrors give them the length of
        the eye's distance, with which that is exact on a flat mirror.
    faces : (F, 3) int32
    status : (V,) uint8
        A `RayStatus` each.
    transmittance : (V,) float64, optional
        What share of the light goes this way, where interfaces divide it.
    """

    image: np.ndarray
    origins: np.ndarray
    directions: np.ndarray
    faces: np.ndarray
    status: np.ndarray
    transmittance: np.ndarray | None = None

    def moved(self, by: np.ndarray) -> RayMesh:
        """The same rays elsewhere, moved along a vector (3,)."""
        return replace(self, origins=self.origins + by)

    def places(self) -> np.ndarray:
        """Where the vertices are in the image, (V, 2) pixels; it means nothing for those behind the eye."""
        return self.image[:, :2] / np.where(self.image[:, 2:] > 0.0, self.image[:, 2:], 1.0)

    def unit_directions(self) -> np.ndarray:
        """The directions normalised, (V, 3)."""
        return self.directions / np.linalg.norm(self.directions, axis=1, keepdims=True)

    def least_size(self) -> tuple[int, int]:
        """The least whole (width, height) that holds the image of all triangles, in pixels."""
        used = np.unique(self.faces)
        if self.image[used, 2].min() <= 0.0:
            raise AnamorphError("camera: its image has vertices behind the eye (w <= 0); give the image's size")
        # What rounding adds to a whole number is not worth a pixel.
        width, height = (int(side) for side in np.ceil(self.places()[used].max(axis=0) - 1e-6))
        if width < 1 or height < 1:
            raise AnamorphError("camera: its image ends left of or above (0, 0), the top left corner; move it")
        return width, height


def check_ray_mesh(rays: RayMesh, where: str) -> None:
    """Is a ray mesh fit to be a camera? Raises AnamorphError; w <= 0, which is behind the eye, is no error."""
    count = len(rays.image)
    for name, shape in (("image", (count, 3)), ("origins", (count, 3)), ("directions", (count, 3))):
        values = np.asarray(getattr(rays, name))
        if values.shape != shape or values.dtype.kind not in "iuf":
            raise AnamorphError(f"{where}: {name} are {values.shape} {values.dtype}; give {shape} float64")
        if not np.isfinite(values).all():
            raise AnamorphError(f"{where}: {name} have NaN or infinite numbers; mend the ray mesh")
        if np.abs(values).max(initial=0.0) > LARGEST:
            raise AnamorphError(f"{where}: {name} have numbers beyond {LARGEST:.0e}; mend the ray mesh")
    if np.shape(rays.status) != (count,):
        raise AnamorphError(f"{where}: status has shape {np.shape(rays.status)}; give {(count,)}")
    faces = np.asarray(rays.faces)
    if faces.ndim != 2 or faces.shape[1] != 3 or faces.dtype.kind not in "iu" or not len(faces):
        raise AnamorphError(f"{where}: faces are {faces.shape} {faces.dtype}; give (F, 3) int32, at least one")
    if faces.min() < 0 or faces.max() >= count:
        wrong = faces.max() if faces.max() >= count else faces.min()
        raise AnamorphError(f"{where}: a face names vertex {wrong}, but there are {count}; mend the faces")
    used = np.unique(faces)
    short = used[np.linalg.norm(rays.directions[used], axis=1) == 0.0]
    if len(short):
        raise AnamorphError(f"{where}: the direction of vertex {short[0]} has no length; give it one")
    if np.max(rays.image[used, 2]) <= 0.0:
        raise AnamorphError(f"{where}: all its image is behind the eye (w <= 0); give w = 1 to what is made by hand")
    first, second, third = np.moveaxis(np.asarray(rays.image, float)[faces], 1, 0)
    if not np.einsum("fi,fi->f", np.cross(first, second), third).any():
        raise AnamorphError(f"{where}: all its triangles are points or lines in the image; spread them")
