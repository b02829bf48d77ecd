"""A lens of one flat face: a plane that refracts as if its normals were those of a sphere.

Source: Vallance, "Trilinear projection", section 7.4, Figure 7.6. It is no body of glass, whose faces belong to a
scene, but a camera made by the law of refraction: the only one of this room that needs optics.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.cameras.grid import Size, checked_count, checked_number, from_grid, grid_points
from anamorph.cameras.linear import lines_of_sight, target_distance
from anamorph.optics.laws import refract
from anamorph.raymesh import RayMesh, RayStatus
from anamorph.scene.camera import Camera


def refracting_plane(
    camera: Camera,
    size: Size,
    quads: int = 5,
    index: float = 1.5,
    distance: float | None = None,
    focus: float | None = None,
) -> RayMesh:
    """What `camera` sees through a plane whose normals all pass through one point of its axis.

    Rays are refracted at the vertices, once, and interpolated between them: 1 to 5 quads are the thesis's Figures
    7.6 (b) to (f), and 100 are as good as its (a), in which every pixel's ray is refracted.

    Parameters
    ----------
    camera : Camera
    size : (width, height)
        Pixels.
    quads : int
        Across, and as many down.
    index : float
        The refractive index behind the plane over that before it; 1 bends nothing.
    distance : float, optional
        From the eye to the plane, which stands across the view, metres; half way to the target where not given.
    focus : float, optional
        From the plane to the point where the normals meet, metres: beyond the plane where positive, which brings rays
        together as a convex lens, and on the eye's side where negative; as far as the eye from the plane where not
        given. With (index - 1) times the distance rays near the axis come out parallel.

    Returns
    -------
    RayMesh
        2 quads^2 triangles. Vertices whose normals turn away from the eye are BACK_FACING, those that no light passes
        TOTAL_REFLECTION.
    """
    checked_number("index", index, 0.0, np.inf)
    count = checked_count("quads", quads)
    sight = lines_of_sight(camera, grid_points(size, (count, count)), size)
    away = 0.5 * target_distance(camera) if distance is None else distance
    checked_number("distance", away, 0.0, np.inf, "metres")
    bent = away if focus is None else focus
    if not np.isfinite(bent) or bent == 0.0:
        raise AnamorphError(f"camera: focus is {bent}; give metres from the plane to where its normals meet, not 0")
    offsets = (away * sight).reshape(-1, 3)
    normals = np.sign(bent) * (offsets - (away + bent) * camera.axes()[2])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    lengths = np.linalg.norm(offsets, axis=1, keepdims=True)
    directions, total = refract(offsets / lengths, normals, 1.0 / index)
    behind = np.sum(offsets * normals, axis=1) >= 0.0
    # As long as the eye's distance, with which an index of 1 gives the pinhole's image exactly.
    directions *= lengths
    mesh = from_grid(camera.position + away * sight, directions.reshape(sight.shape), size)
    status = np.where(total, RayStatus.TOTAL_REFLECTION, RayStatus.OK)
    return replace(mesh, status=np.where(behind, RayStatus.BACK_FACING, status).astype(np.uint8))
