"""Where a ray meets a patch: Newton's iteration in its two parameters. Compiled.

It is part of the machine code of each surface: what takes a function as an argument cannot be kept on disk alone.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from anamorph.base.compiled import inlined
from anamorph.base.vectors import Vector, along, cross, dot, unit


@inlined
def meet_patch(
    point_and_tangents: Callable,
    numbers: np.ndarray,
    extent: float,
    turn: float,
    origin: Vector,
    direction: Vector,
    u: float,
    v: float,
) -> tuple[bool, float, Vector]:
    """Refine a hit on a mesh to one on its patch: both components of S(u, v) - origin across the ray become zero.

    The steps are halved where they lead away.

    Parameters
    ----------
    point_and_tangents : compiled function
        From `numbers` and parameters from 0 to 1 over the patch: the position, and its derivatives along u and v.
    numbers : float64 array
    extent : float
        Size of the patch, metres: what is small against it is zero.
    turn : float
        1 where the normal points along d/du x d/dv, else -1.
    origin, direction : three float64 each
        The ray; unit direction.
    u, v : float
        Where it hits the mesh, from 0 to 1 over the patch.

    Returns
    -------
    met : bool
    distance : float
    normal : three float64
        Unit, outward.
    """
    if abs(direction[0]) < 0.6:
        across_1 = unit(cross(direction, (1.0, 0.0, 0.0)))
    else:
        across_1 = unit(cross(direction, (0.0, 1.0, 0.0)))
    across_2 = cross(direction, across_1)
    position, along_u, along_v = point_and_tangents(numbers, u, v)
    offset = along(position, -1.0, origin)
    started = dot(offset, direction)
    f, g = dot(offset, across_1), dot(offset, across_2)
    share = 1.0
    for _ in range(48):
        fu, fv, gu, gv = dot(along_u, across_1), dot(along_v, across_1), dot(along_u, across_2), dot(along_v, across_2)
        determinant = fu * gv - fv * gu
        found = f * f + g * g <= (1e-14 * extent) ** 2
        if found or share < 1e-3 or abs(determinant) <= 1e-12 * extent * extent:
            break
        # A little beyond the border, because the mesh there may stand before the neighbouring patch.
        next_u = min(max(u - share * (f * gv - fv * g) / determinant, -0.05), 1.05)
        next_v = min(max(v - share * (fu * g - f * gu) / determinant, -0.05), 1.05)
        position, next_along_u, next_along_v = point_and_tangents(numbers, next_u, next_v)
        next_offset = along(position, -1.0, origin)
        next_f, next_g = dot(next_offset, across_1), dot(next_offset, across_2)
        if next_f * next_f + next_g * next_g < f * f + g * g:
            u, v, f, g, offset, along_u, along_v = (
                next_u,
                next_v,
                next_f,
                next_g,
                next_offset,
                next_along_u,
                next_along_v,
            )
            share = min(2.0 * share, 1.0)
        else:
            share *= 0.5
    distance = dot(offset, direction)
    normal = cross(along_u, along_v)
    normal = (turn * normal[0], turn * normal[1], turn * normal[2])
    # Far from where the mesh was hit lies another sheet of the patch; a vanishing normal is a pole.
    met = (
        f * f + g * g <= (1e-9 * extent) ** 2
        and abs(distance - started) <= 0.25 * extent
        and dot(normal, normal) > (1e-7 * extent * extent) ** 2
    )
    return met, distance, unit(normal) if met else (0.0, 0.0, 0.0)
