"""All around an eye, on a cylinder."""

from __future__ import annotations

import numpy as np

from anamorph.cameras.grid import Size, checked_count, checked_number, from_grid
from anamorph.raymesh import RayMesh
from anamorph.scene.camera import Camera
from anamorph.scene.checks import check_camera


def panorama(camera: Camera, size: Size, angle: float = 360.0, columns: int = 36) -> RayMesh:
    """What `camera` sees as it turns about its own upright axis, on a cylinder about it.

    The cylinder has flat sides, one for each column: in a column the image is that of a pinhole, and a straight line
    bends only where columns meet.

    Parameters
    ----------
    camera : Camera
        The middle of the image and its upright angle.
    size : (width, height)
        Pixels.
    angle : float
        What the image shows across, degrees; 360 is all around, and more shows some things twice.
    columns : int
        Quads across; each must see less than 180 degrees.

    Returns
    -------
    RayMesh
        2 columns triangles.
    """
    count = checked_count("columns", columns)
    turn = np.radians(checked_number("angle", angle, 0.0, min(180.0 * count, 1e6), "degrees"))
    check_camera(camera, "camera")
    height = np.tan(np.radians(camera.field_of_view) / 2.0)
    right, up, forward = camera.axes()
    around = np.linspace(-turn / 2.0, turn / 2.0, count + 1)[:, None]
    level = np.sin(around) * right + np.cos(around) * forward
    directions = np.stack([level + height * up, level - height * up])
    return from_grid(np.broadcast_to(camera.position, directions.shape), directions, size)
