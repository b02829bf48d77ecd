"""Detail and context in one image: the middle magnified, the rim as it was.

Source: Vallance, "Trilinear projection", section 6.1, after the distortion-oriented displays of maps.
"""

from __future__ import annotations

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.cameras.grid import Size, checked_count, checked_number, from_grid, grid_points
from anamorph.cameras.linear import lines_of_sight, target_distance
from anamorph.raymesh import RayMesh
from anamorph.scene.camera import Camera


def detail_and_context(
    camera: Camera,
    size: Size,
    magnification: float = 1.6,
    detail: float = 1 / 3,
    rows: int = 3,
    columns: int = 3,
    surface: float = 0.5,
) -> RayMesh:
    """What `camera` sees, with the middle of the image magnified.

    Rays leave a plane between the eye and what it looks at. At the rim they go on from the eye, as in a perspective
    image. The nearer to the middle, the less they spread: until they meet what is looked at in a part of the image
    that is `magnification` times smaller. With `surface` 0.5 the middle's rays spread less than the eye's up to a
    magnification of 2, where they are parallel (an orthographic image); beyond they come together (an inverse
    perspective one: what is farther away is larger).

    Parameters
    ----------
    camera : Camera
        Its target is what the magnification holds for.
    size : (width, height)
        Pixels.
    magnification : float
        In the middle, at the target's distance, 1 or more.
    detail : float
        The share of the image's width and height, 0 to 1, that is evenly magnified: with 3 x 3 quads the middle one.
    rows, columns : int
        Quads. From the detail to the rim the rays change by a smooth step where there are more than 3; odd numbers keep
        the middle in one quad.
    surface : float
        Where the rays leave, as a share of the way from the eye to the target, 0 to 1. What is nearer is not seen.

    Returns
    -------
    RayMesh
        2 rows columns triangles. The directions' lengths bring a ray from the surface to the target's plane.
    """
    if not (np.isfinite(magnification) and magnification >= 1.0):
        raise AnamorphError(f"camera: magnification is {magnification}; give 1 or more")
    checked_number("detail", detail, 0.0, 1.0)
    checked_number("surface", surface, 0.0, 1.0)
    quads = checked_count("columns", columns, 3), checked_count("rows", rows, 3)
    pixels = grid_points(size, quads)
    sight = lines_of_sight(camera, pixels, size) * target_distance(camera)
    forward = camera.axes()[2] * target_distance(camera)
    out = np.abs(2.0 * pixels / np.asarray(size, float) - 1.0).max(axis=-1)
    inward = np.clip((1.0 - out) / (1.0 - detail), 0.0, 1.0)
    share = (inward * inward * (3.0 - 2.0 * inward))[..., None]
    met = forward + (sight - forward) * (1.0 - share * (1.0 - 1.0 / magnification))
    return from_grid(camera.position + surface * sight, met - surface * sight, size)
