"""The rays of a scene's ray meshes, by vertex of the scene, for the truth along the interpolated rays of a ray mesh."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from anamorph.methods.tracing.bounces import VertexRays
from anamorph.optics.ray_meshes import Body, Line, side_rays
from anamorph.raymesh import RayStatus
from anamorph.scene.camera import Eye
from anamorph.scene.geometry import Geometry


def vertex_rays(bodies: Sequence[Body], geometry: Geometry, eye: Eye, line: Line) -> VertexRays:
    """The rays of light of one line: of both sides of a lens, of which a path from the eye may meet either."""
    count = len(geometry.positions)
    origins, directions = np.zeros((2, count, 3))
    transmittance, leaves = np.zeros(count), np.zeros(count, np.bool_)
    far = np.zeros(len(geometry.kind) + 1, np.int64)
    for body in bodies:
        for side, other in zip(body.sides, reversed(body.sides), strict=True):
            rays, own = side_rays(side, eye, line), side.vertices
            origins[own], directions[own] = rays.origins, rays.directions
            if rays.transmittance is not None:
                transmittance[own] = rays.transmittance
                leaves[own] = np.isin(rays.status, (RayStatus.OK, RayStatus.BACK_FACING))
                far[list(side.objects)] = other.objects
    return VertexRays(origins, directions, transmittance, leaves, far)
