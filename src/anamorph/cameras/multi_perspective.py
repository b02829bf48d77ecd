"""Two views in one image, and what leads from one to the other.

Source: Vallance, "Trilinear projection", section 6.2.
"""

from __future__ import annotations

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.cameras.grid import Size, checked_count, checked_number, checked_size, from_grid
from anamorph.cameras.linear import lines_of_sight, target_distance
from anamorph.raymesh import RayMesh
from anamorph.scene.camera import Camera

OPPOSITE = -0.99
"""Rays between two that point apart by nearly 180 degrees have no direction."""


def multi_perspective(
    left: Camera,
    right: Camera,
    size: Size,
    parallel: tuple[bool, bool] = (True, False),
    transition: float = 1 / 3,
    columns: int = 1,
    surface: float = 0.5,
) -> RayMesh:
    """The view of one camera on the left, that of another on the right, and between them rays that turn from one to
    the other.

    The rays are continuous, and so is the image of a thing that all of them see; a thing may be seen more than once.
    What lies beyond where the rays of the transition cross is seen reversed in it: to walk around a thing from its left
    side to its front, let the inner borders of both views meet on it, so that the rays cross within.

    Parameters
    ----------
    left, right : Camera
        Each shows its target in the middle of its own part. They may not look in opposite directions.
    size : (width, height)
        Of the whole image, pixels; the two parts share what the transition leaves.
    parallel : (bool, bool)
        Whether the rays of the left and of the right part are parallel, an orthographic view that shows as much of the
        target's plane as the camera does.
    transition : float
        The share of the image's width, between 0 and 1, in which the rays turn.
    columns : int
        Quads across the transition. One turns the rays evenly; with more they turn by a smooth step, slowly near either
        part.
    surface : float
        Where the rays leave, as a share of the way from each eye to its target, 0 to 1. What is nearer is not seen.

    Returns
    -------
    RayMesh
        2 (columns + 2) triangles.
    """
    width, height = checked_size(size)
    checked_number("transition", transition, 0.0, 1.0)
    checked_number("surface", surface, 0.0, 1.0)
    steps = np.linspace(0.0, 1.0, checked_count("columns", columns) + 1)
    part = (1.0 - transition) / 2.0 * width
    first = _part(left, part, height, parallel[0], surface)
    last = _part(right, part, height, parallel[1], surface)
    inner, outer = first[:, :, 1:], last[:, :, :1]
    lengths = np.linalg.norm(inner[1], axis=-1) * np.linalg.norm(outer[1], axis=-1)
    if (np.sum(inner[1] * outer[1], axis=-1) / lengths < OPPOSITE).any():
        raise AnamorphError("camera: left and right look in opposite directions; turn one, or put a third view between")
    turned = steps if columns == 1 else steps * steps * (3.0 - 2.0 * steps)
    between = inner + (outer - inner) * turned[:, None]
    rays = np.concatenate([first[:, :, :1], between, last[:, :, 1:]], axis=2)
    places = np.concatenate([[0.0], part + transition * width * steps, [width]])
    return from_grid(rays[0], rays[1], (width, height), columns=places)


def _part(camera: Camera, width: float, height: int, parallel: bool, surface: float) -> np.ndarray:
    """Origins and directions, (2, rows, columns, 3), at the corners of a part of the image, from its top left."""
    corners = np.stack(np.meshgrid([0.0, width], [0.0, float(height)]), axis=-1)
    # The part's own width need not be whole: its corners are a square image's, stretched about the middle.
    corners[..., 0] += (height - width) / 2.0
    distance = target_distance(camera)
    sight = lines_of_sight(camera, corners, (height, height)) * distance
    forward = camera.axes()[2] * distance
    if parallel:
        directions = np.broadcast_to((1.0 - surface) * forward, sight.shape)
        return np.stack([camera.position + sight - directions, directions])
    return np.stack([camera.position + surface * sight, (1.0 - surface) * sight])
