"""A camera that is a surface: a ray leaves each of its points along the normal.

Source: Vallance and Calder, "Multi-perspective images for visualisation" (2001), appendix F of Vallance, "Trilinear
projection": section 4, Figures 9 to 11; the torus of its Figure 6 is that of Löffelmann and Gröller, "Ray tracing with
extended cameras" (1996).
"""

from __future__ import annotations

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.cameras.grid import Size, checked_count, from_grid
from anamorph.raymesh import RayMesh
from anamorph.surfaces.base import Surface
from anamorph.surfaces.patch import Patch

Window = tuple[tuple[float, float], tuple[float, float]]
"""The first and the last u, and the first and the last v, of a part of a surface."""


def from_surface(
    surface: Surface,
    size: Size,
    inward: bool = False,
    window: Window | None = None,
    rows: int = 16,
    columns: int = 16,
) -> RayMesh:
    """What a surface sees along its normals: all that its rays meet as they leave it.

    The image is never mirrored: the last v is at its top, and u runs to the right or to the left as that wants it.

    Parameters
    ----------
    surface : Surface
        Any exact surface. The outside of a patch is that of d/du x d/dv.
    size : (width, height)
        Pixels.
    inward : bool
        Whether rays leave against the normals.
    window : ((first u, last u), (first v, last v)), optional
        The part that fills the image; all of a patch where not given. Other surfaces have no ends of their own.
    rows, columns : int
        Quads along v and along u, between whose corners rays are interpolated: how near they are to the normals grows
        with the square of these numbers.

    Returns
    -------
    RayMesh
        2 rows columns triangles; directions of unit length at the vertices.
    """
    (first_u, last_u), (first_v, last_v) = _checked_window(surface, window)
    u = np.linspace(first_u, last_u, checked_count("columns", columns) + 1)
    v = np.linspace(last_v, first_v, checked_count("rows", rows) + 1)
    parameters = np.stack(np.meshgrid(u, v), axis=-1)
    origins, normals = (
        each(parameters.reshape(-1, 2)).reshape(len(v), len(u), 3) for each in (surface.position, surface.normal)
    )
    side = -1.0 if inward else 1.0
    if _facing(origins, normals) != side:
        origins, normals = origins[:, ::-1], normals[:, ::-1]
    return from_grid(origins, side * normals, size)


def _facing(origins: np.ndarray, normals: np.ndarray) -> float:
    """1 where rays along the normals of a grid of points, (R, C, 3) each, make an image as it is, -1 a mirrored one."""
    right, down = np.diff(origins, axis=1)[:-1], np.diff(origins, axis=0)[:, :-1]
    return 1.0 if (np.cross(right, down) * normals[:-1, :-1]).sum() >= 0.0 else -1.0


def _checked_window(surface: Surface, window: Window | None) -> Window:
    if window is None:
        if not isinstance(surface, Patch):
            raise AnamorphError(
                "camera: window is not given, and the surface has no ends of its own; "
                "give ((first u, last u), (first v, last v))"
            )
        (u0, v0), (u1, v1) = surface.domain
        return (u0, u1), (v0, v1)
    try:
        ends = np.asarray(window, float)
    except (TypeError, ValueError):
        ends = np.empty(0)
    if ends.shape != (2, 2) or not np.isfinite(ends).all() or (ends[:, 0] == ends[:, 1]).any():
        raise AnamorphError(
            f"camera: window is {window}; give ((first u, last u), (first v, last v)), finite, no two alike"
        )
    return (ends[0, 0], ends[0, 1]), (ends[1, 0], ends[1, 1])
