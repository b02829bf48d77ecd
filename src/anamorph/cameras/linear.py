"""Linear cameras, each exact by two triangles: pinhole, orthographic, what leads from one to the other, pushbroom.

More of their kind are known (J. Yu and L. McMillan, "General linear cameras", 2004); `from_grid` makes any.
"""

from __future__ import annotations

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.cameras.grid import Size, checked_number, checked_size, from_grid, grid_points
from anamorph.raymesh import RayMesh
from anamorph.scene.camera import Camera
from anamorph.scene.checks import check_camera


def pinhole(camera: Camera, size: Size) -> RayMesh:
    """What `camera` sees in an image of `size` (width, height), as a ray mesh."""
    directions = lines_of_sight(camera, grid_points(size, (1, 1)), size)
    return from_grid(np.broadcast_to(camera.position, directions.shape), directions, size)


def orthographic(camera: Camera, size: Size, height: float | None = None) -> RayMesh:
    """Parallel rays along the view of `camera`, which leave the plane through its position.

    Parameters
    ----------
    camera : Camera
    size : (width, height)
        Pixels.
    height : float, optional
        Metres that the image shows from its bottom to its top; what `camera` shows of its target's plane where not
        given.
    """
    sight = lines_of_sight(camera, grid_points(size, (1, 1)), size)
    forward = camera.axes()[2]
    across = (sight - forward) * _scale(camera, height)
    return from_grid(camera.position + across, np.broadcast_to(forward, sight.shape), size)


def perspective(camera: Camera, size: Size, amount: float = 1.0) -> RayMesh:
    """What `camera` sees with more or less perspective, or with a reversed one; its target's plane stays as it is.

    At the depth z beyond the target, at whose distance d the image shows a height H, it shows H (1 + amount z / d). So
    0 is the orthographic image and 1 the camera's own, below 0 what is farther away is larger, and nothing jumps
    between them.

    Source: Vallance and Calder, "Multi-perspective images for visualisation" (2001), appendix F of Vallance,
    "Trilinear projection", section 4, Figures 12 to 14.

    Parameters
    ----------
    camera : Camera
    size : (width, height)
        Pixels.
    amount : float
        Of perspective. Rays leave the plane through the camera's position; with more than 1 the point before it
        from which they part. Below 0 they meet in a point, a target's distance over -amount beyond the target, behind
        which all is seen reversed.
    """
    if not np.isfinite(amount):
        raise AnamorphError(f"camera: amount is {amount}; give a number, 0 for no perspective")
    distance = target_distance(camera)
    sight = lines_of_sight(camera, grid_points(size, (1, 1)), size)
    forward = camera.axes()[2]
    directions = forward + amount * (sight - forward)
    reach = distance / max(1.0, amount)
    return from_grid(camera.position + distance * sight - reach * directions, directions, size)


def anti_perspective(camera: Camera, size: Size, distance: float | None = None) -> RayMesh:
    """Rays that leave a rectangle and converge in one point before it: nearer things look smaller.

    The rectangle stands across the view of `camera`, its middle at the camera's position, and the camera's field of
    view is the angle under which it is seen from the point of convergence. Beyond that point all is seen reversed.

    Source: Vallance and Calder, "Inward looking projections" (2003), appendix G of Vallance, "Trilinear projection",
    section 4, Figure 2.

    Parameters
    ----------
    camera : Camera
    size : (width, height)
        Pixels.
    distance : float, optional
        From the rectangle to the point of convergence, metres; the target's where not given.

    Returns
    -------
    RayMesh
        2 triangles; directions reach the point of convergence.
    """
    reach = target_distance(camera) if distance is None else checked_number("distance", distance, 0.0, np.inf, "metres")
    sight = reach * lines_of_sight(camera, grid_points(size, (1, 1)), size)
    forward = reach * camera.axes()[2]
    return from_grid(camera.position + sight - forward, 2.0 * forward - sight, size)


def pushbroom(camera: Camera, size: Size, height: float | None = None) -> RayMesh:
    """A line of pixels, upright as `camera` sees it, that an eye sees while it moves to the right.

    Upright the image is a perspective one, across it is orthographic: the scanner of a satellite, a street's long
    front.

    Parameters
    ----------
    camera : Camera
        The middle of the way, and the upright angle of the image.
    size : (width, height)
        Pixels.
    height : float, optional
        Metres that the image shows from its bottom to its top where its scale is the same both ways; what `camera`
        shows of its target's plane where not given. The way is `height` times width over height long.
    """
    sight = lines_of_sight(camera, grid_points(size, (1, 1)), size)
    right, up, forward = camera.axes()
    moved = (sight @ right)[..., None] * right * _scale(camera, height)
    return from_grid(camera.position + moved, (sight @ up)[..., None] * up + forward, size)


def lines_of_sight(camera: Camera, pixels: np.ndarray, size: Size) -> np.ndarray:
    """From the eye through image points (..., 2) to the plane a metre before it: (..., 3), linear in the image."""
    check_camera(camera, "camera")
    matrix = camera.eye(checked_size(size)).matrix[:, :3]
    homogeneous = np.concatenate([pixels, np.ones((*pixels.shape[:-1], 1))], axis=-1)
    return homogeneous @ np.linalg.inv(matrix).T


def target_distance(camera: Camera) -> float:
    """Metres from the eye to what it looks at."""
    return float(np.linalg.norm(np.subtract(camera.target, camera.position)))


def _scale(camera: Camera, height: float | None) -> float:
    """The distance at which `camera` shows `height` metres."""
    if height is None:
        return target_distance(camera)
    half = np.tan(np.radians(camera.field_of_view) / 2.0)
    return checked_number("height", height, 0.0, np.inf, "metres") / (2.0 * half)
