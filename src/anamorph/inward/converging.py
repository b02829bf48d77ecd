"""The point in which the rays of a ray mesh converge.

Source: Vallance and Calder, "Inward looking projections" (2003), sections 4 and 4.4.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.optics.viewpoint import virtual_viewpoint
from anamorph.raymesh import RayMesh, RayStatus

NEARNESS = 1e-6
"""How far rays may pass the point, as a share of the longest way to it."""


@dataclass(frozen=True, eq=False)
class Converging:
    """A ray mesh all of whose rays run to one point, the interpolated ones as well.

    Parameters
    ----------
    point : (3,) float64
        Metres.
    places : (F, 3, 3) float64
        Of the corners of each face in the image, homogeneous.
    arrows : (F, 3, 3) float64
        From where their rays leave to the point, metres.
    """

    point: np.ndarray
    places: np.ndarray
    arrows: np.ndarray

    @property
    def reach(self) -> float:
        """How far from the point the farthest ray leaves, metres."""
        return float(np.linalg.norm(self.arrows, axis=2).max())


def converging(rays: RayMesh) -> Converging:
    """Find the point in which rays converge.

    Raises
    ------
    AnamorphError
        Where they run apart, or past each other; where they are interpolated so that they do between corners; or where
        some of the image is behind the eye.
    """
    if (rays.image[rays.faces, 2] <= 0.0).any():
        raise AnamorphError("inward: some of the image is behind the eye (w <= 0); leave these faces out")
    used = np.unique(rays.faces)
    point = _point(rays.origins[used], rays.unit_directions()[used])
    arrows = point - rays.origins
    reach = np.linalg.norm(arrows[used], axis=1).max()
    past = np.linalg.norm(np.cross(rays.unit_directions()[used], arrows[used]), axis=1)
    if past.max() > NEARNESS * reach:
        raise AnamorphError(
            f"inward: rays pass {past.max():.3g} metres from each other's point of convergence; "
            "give trilinear or raytrace, which need none"
        )
    squares = np.einsum("vi,vi->v", rays.directions, rays.directions)
    ways = (np.einsum("vi,vi->v", arrows, rays.directions) / squares)[rays.faces]
    if ways.min() <= 0.0:
        raise AnamorphError("inward: rays run apart, and converge nowhere before them; give trilinear or raytrace")
    if (np.ptp(ways, axis=1) > NEARNESS * ways.max(axis=1)).any():
        raise AnamorphError(
            "inward: between corners interpolated rays miss the point of convergence; "
            "make directions as long as the way to it"
        )
    return Converging(point, rays.image[rays.faces], arrows[rays.faces])


def toward_one_point(rays: RayMesh) -> RayMesh:
    """The same rays bent a little, so that all run to the point that they come nearest to.

    Of a spherical concave mirror the paper says that its rays do that. They do for an eye at the sphere's center, to
    which they come back; else only those near the axis, and the others miss it by the spherical aberration.

    Parameters
    ----------
    rays : RayMesh
        A mirror's, as `optics.reflection.reflected_rays` makes it. Faces with a corner that shows its back are left
        out.
    """
    facing = (rays.status == RayStatus.OK)[rays.faces].all(axis=1)
    if not facing.any():
        raise AnamorphError("inward: the mirror shows no whole face to the eye; move one of both")
    used = np.unique(rays.faces[facing])
    point = _point(rays.origins[used], rays.unit_directions()[used])
    directions = rays.directions.copy()
    directions[used] = point - rays.origins[used]
    return replace(rays, directions=directions, faces=rays.faces[facing])


def _point(origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
    viewpoint = virtual_viewpoint(origins, directions)
    if viewpoint[3] == 0.0:
        raise AnamorphError("inward: rays are parallel, and converge nowhere; give trilinear or raytrace")
    return viewpoint[:3] / viewpoint[3]
