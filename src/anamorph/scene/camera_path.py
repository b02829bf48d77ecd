"""The way of a camera from one view to another."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from anamorph.base.vectors import tuple_of
from anamorph.scene.camera import Camera


def camera_between(one: Camera, other: Camera, share: float) -> Camera:
    """The camera at a `share` of the way, 0 to 1, from one view to another.

    It orbits about its target, about the upward direction, so that a horizon that is level stays so; its distance grows
    or shrinks evenly, so that it passes through nothing that it looks at.
    """
    if share in (0.0, 1.0) or one == other:
        return other if share == 1.0 else one
    right, _, ahead = one.axes()
    up, other_up = (np.divide(camera.up, np.linalg.norm(camera.up)) for camera in (one, other))
    tilt = _tilt(up, other_up, right)
    # Backward, from the targets to the eyes: about the first view's upward direction, and up from its horizontal.
    horizontal = np.cross(right, up)
    away = Rotation.from_rotvec(-tilt).apply(-other.axes()[2])
    around = share * np.arctan2(away @ right, away @ horizontal)
    rises = [np.arctan2(back @ up, np.linalg.norm(np.cross(back, up))) for back in (-ahead, away)]
    rise = (1.0 - share) * rises[0] + share * rises[1]
    back = np.cos(rise) * (np.cos(around) * horizontal + np.sin(around) * right) + np.sin(rise) * up
    back, up = Rotation.from_rotvec(share * tilt).apply([back, up])
    target = (1.0 - share) * np.array(one.target) + share * np.array(other.target)
    first, last = (np.linalg.norm(np.subtract(each.target, each.position)) for each in (one, other))
    eye = target + first ** (1.0 - share) * last**share * back
    field = one.field_of_view ** (1.0 - share) * other.field_of_view**share
    return Camera(tuple_of(eye), tuple_of(target), tuple_of(up), float(field))


def _tilt(up: np.ndarray, other: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The shortest rotation vector from an upward direction to another, about `right` where they are opposite."""
    across = np.cross(up, other)
    sine = np.linalg.norm(across)
    axis = across / sine if sine > 1e-12 else right
    return float(np.arctan2(sine, up @ other)) * axis
