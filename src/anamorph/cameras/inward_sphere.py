"""A map of a thing: a sphere around it whose rays all look inward.

Source: Vallance, "Trilinear projection", section 6.3.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from anamorph.base.errors import AnamorphError
from anamorph.base.vectors import Vector
from anamorph.cameras.grid import Size, checked_count, from_grid
from anamorph.raymesh import RayMesh
from anamorph.surfaces.sphere import Sphere


def inward_sphere(
    center: Vector,
    radius: float,
    size: Size,
    rows: int = 10,
    columns: int = 10,
    pole: float = 5.0,
    axes: ArrayLike | None = None,
) -> RayMesh:
    """The outside of what lies within a sphere, unrolled as a map of the earth: longitude across, latitude upright.

    Every ray leaves the sphere and runs through its center, those between vertices as well: directions are as long as
    the radius, with which interpolated rays meet there, too. At a pole all vertices of a row would have one and the
    same ray, and half of that row's triangles would show nothing but a meridian each, which the thesis's Figure 6.9
    shows as zigzags. So the map ends `pole` degrees before either pole, where the rays of a row still differ; the cap
    beyond is not shown. With 0 it ends at the poles, as in the thesis.

    Parameters
    ----------
    center : three floats
        Metres.
    radius : float
        Metres. What is farther from the center is not seen, and what lies beyond the center only where nothing lies
        before it.
    size : (width, height)
        Pixels.
    rows, columns : int
        Quads of latitude, at least 2, and of longitude, at least 3.
    pole : float
        Degrees from the poles to the first and last row, from 0 to less than 90.
    axes : (3, 3) array, optional
        Rows: unit vectors to the right, up (to the north pole) and to the viewer, which is the middle of the image;
        the world's x, y and z where not given.

    Returns
    -------
    RayMesh
        2 rows columns triangles.
    """
    middle = np.asarray(center, float)
    if middle.shape != (3,) or not np.isfinite(middle).all():
        raise AnamorphError(f"camera: center is {center}; give three finite numbers")
    if not 0.0 <= pole < 90.0:
        raise AnamorphError(f"camera: pole is {pole}; give degrees from 0 to less than 90")
    sphere = Sphere(middle, radius) if axes is None else Sphere(middle, radius, np.asarray(axes, float))
    across, down = checked_count("columns", columns, 3) + 1, checked_count("rows", rows, 2) + 1
    top = np.radians(90.0 - pole)
    longitude, latitude = np.meshgrid(np.linspace(-np.pi, np.pi, across), np.linspace(top, -top, down))
    origins = sphere.position(np.stack([longitude, latitude], axis=-1).reshape(-1, 2)).reshape(down, across, 3)
    return from_grid(origins, middle - origins, size)
