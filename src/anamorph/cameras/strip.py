"""A strip camera: an eye on its way through the scene, and of each place on it one upright line of the image.

Sources: Rademacher and Bishop, "Multiple-center-of-projection images" (1998); Davidhazy, "Peripheral portraits and
other strip camera photographs" (2001); both in Vallance and Calder, "Multi-perspective images for visualisation"
(2001), appendix F of Vallance, "Trilinear projection", section 2.1.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.cameras.grid import Size, checked_count, from_grid
from anamorph.raymesh import RayMesh
from anamorph.scene.camera import Camera
from anamorph.scene.camera_path import camera_between
from anamorph.scene.checks import check_camera


def strip(views: Sequence[Camera], size: Size, columns: int = 32) -> RayMesh:
    """What an eye sees straight ahead, in an upright line, while it moves from view to view.

    Each line is the middle column of what a camera sees there. Between views the eye orbits about its target, as in a
    video that goes through them (`scene.camera_path`), and lines are as far apart in the image as the eye moves: a
    path along a street shows its front as a pushbroom does, one around a thing shows it from all sides. An eye that
    moves to its right shows the image as it is, and one that moves to its left shows it mirrored: then lines are placed
    from right to left.

    Parameters
    ----------
    views : sequence of Camera
        Two at least, such as those that a scene file keeps: `files.view_file.views_of`. Their fields of view are the
        upright angle of the image.
    size : (width, height)
        Pixels.
    columns : int
        Quads from each view to the next, between whose sides rays are interpolated.

    Returns
    -------
    RayMesh
        2 (number of views - 1) columns triangles.
    """
    count = checked_count("columns", columns)
    if len(views) < 2:
        raise AnamorphError(f"camera: a strip goes through {len(views)} views; give two at least")
    for number, view in enumerate(views, start=1):
        check_camera(view, f"camera: number {number} of views")
    shares = np.linspace(0.0, 1.0, count + 1)
    path = [views[0]]
    for one, other in pairwise(views):
        path += [camera_between(one, other, float(share)) for share in shares[1:]]
    eyes, axes = np.array([camera.position for camera in path]), np.array([camera.axes() for camera in path])
    steps = np.diff(eyes, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    still = np.flatnonzero(lengths <= 1e-9 * lengths.sum())
    if len(still):
        number = still[0] // count + 1
        raise AnamorphError(
            f"camera: the eye stands still between views {number} and {number + 1}; move or leave out one"
        )
    height = np.tan(np.radians([camera.field_of_view for camera in path]) / 2.0)[:, None] * axes[:, 1]
    origins, directions = np.stack([eyes, eyes]), np.stack([axes[:, 2] + height, axes[:, 2] - height])
    places = np.concatenate([[0.0], np.cumsum(lengths)]) * size[0] / lengths.sum()
    to_the_right = np.einsum("ni,ni->", steps, axes[:-1, 0] + axes[1:, 0]) >= 0.0
    if not to_the_right:
        origins, directions, places = origins[:, ::-1], directions[:, ::-1], size[0] - places[::-1]
    # Sums are rounded; the image ends at its border.
    places[[0, -1]] = 0.0, size[0]
    return from_grid(origins, directions, size, columns=places)
