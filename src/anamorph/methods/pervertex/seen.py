"""What an eye sees of the bodies of a scene, and the maps that show it: steps 1 to 3 of the paper, without a device.

Source: Kakimoto et al. 2007, sections 3 and 4.1.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from anamorph.methods.pervertex.cube_plan import plan_cube
from anamorph.methods.pervertex.division import divide, part_where_hidden, seen_faces
from anamorph.methods.pervertex.options import Options
from anamorph.methods.pervertex.surroundings import Surroundings
from anamorph.methods.pervertex.warp import MapPlan, plan_map
from anamorph.optics.ray_meshes import Body, BodyRays, rays_of
from anamorph.scene.camera import Camera


@dataclass(frozen=True, eq=False)
class Seen:
    """One body in an image.

    Parameters
    ----------
    body_rays : BodyRays
    hits : (V, 3) float64
        Where its vertex rays meet the scene.
    distances : (V,) float64
        How far that is; infinite for the sky, and where no map shows the vertex.
    plans : tuple of MapPlan
        Of its patches.
    patches : tuple of int arrays
        The faces of each, by their numbers in the ray mesh.
    lost : tuple of int arrays
        The faces of each patch that has no map.
    """

    body_rays: BodyRays
    hits: np.ndarray
    distances: np.ndarray
    plans: tuple[MapPlan, ...]
    patches: tuple[np.ndarray, ...]
    lost: tuple[np.ndarray, ...]


def seen_bodies(
    bodies: Sequence[Body], surroundings: Surroundings, camera: Camera, size: tuple[int, int], options: Options
) -> list[Seen]:
    """The mirrors and lenses that `camera` sees in an image of `size` (width, height), with the maps that show them."""
    eye, position = camera.eye(size), np.asarray(camera.position, float)
    found = (seen_body(rays_of(body, eye), size, position, surroundings, options) for body in bodies)
    return [seen for seen in found if seen.plans]


def seen_body(
    body_rays: BodyRays,
    size: tuple[int, int],
    position: np.ndarray | None,
    surroundings: Surroundings,
    options: Options,
    most: float = np.inf,
) -> Seen:
    """Divide what is seen of a body into patches, and plan the map of each.

    Parameters
    ----------
    body_rays : BodyRays
    size : (width, height)
        Of the image, pixels.
    position : (3,) float64, optional
        Of the eye, from which something may hide vertices; nothing does if it is not given.
    surroundings : Surroundings
    options : Options
    most : float
        No patch gets a map once there are so many.
    """
    vertices = body_rays.side.optics.positions
    occluder = np.zeros(len(vertices), int)
    if position is not None:
        occluder = surroundings.occluders(position, vertices)
    planned = list(_planned(body_rays, size, occluder, surroundings, options, most))
    shown = [(faces, plan) for faces, plan in planned if plan is not None]
    hits, distances = np.zeros((len(occluder), 3)), np.full(len(occluder), np.inf)
    for _, plan in shown:
        hits[plan.vertices], distances[plan.vertices] = plan.hits, plan.distances
    return Seen(
        body_rays, hits, distances,
        plans=tuple(plan for _, plan in shown),
        patches=tuple(faces for faces, _ in shown),
        lost=tuple(faces for faces, plan in planned if plan is None),
    )  # fmt: skip


def _planned(
    body_rays: BodyRays,
    size: tuple[int, int],
    occluder: np.ndarray,
    surroundings: Surroundings,
    options: Options,
    most: float,
) -> Iterator[tuple[np.ndarray, MapPlan | None]]:
    """The faces of each patch, and its plan: none where no map can show it, or there are enough maps."""
    rays, side = body_rays.rays, body_rays.side
    faces = seen_faces(rays, size)
    patches = divide(rays, faces, np.radians(options.field))
    if options.wide == "cube" and len(patches) > 1:
        plan = plan_cube(body_rays, faces, occluder, surroundings, options)
        if plan is not None:
            yield faces, plan
            return
    if surroundings.mountings[side].closed:
        patches = [part for patch in patches for part in part_where_hidden(rays, patch, surroundings, side.objects)]
    maps = 0
    for patch in patches:
        plan = plan_map(body_rays, patch, occluder, surroundings, options) if maps < most else None
        maps += 0 if plan is None else len(plan.projections)
        yield patch, plan
