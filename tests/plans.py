"""What per-vertex drawing plans of a scene, without a device: bodies, their rays, patches and maps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scenes import SIZE

from anamorph.methods.pervertex import Options
from anamorph.methods.pervertex.division import divide, seen_faces
from anamorph.methods.pervertex.surroundings import Surroundings, surroundings_of
from anamorph.methods.pervertex.warp import MapPlan, plan_map
from anamorph.optics.ray_meshes import BodyRays, bodies_of, rays_of
from anamorph.scene.camera import Camera, Eye
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Scene

FIELD = 100.0


@dataclass(frozen=True, eq=False)
class Planned:
    """The first body of a scene as an eye sees it, and the maps of its patches."""

    surroundings: Surroundings
    body_rays: BodyRays
    occluder: np.ndarray
    patches: tuple[np.ndarray, ...]
    plans: tuple[MapPlan | None, ...]


def planned(
    scene: Scene,
    camera: Camera | None = None,
    size: tuple[int, int] = SIZE,
    options: Options | None = None,
    field: float = FIELD,
    eye: Eye | None = None,
) -> Planned:
    """Steps 1 to 3 for all patches of the scene's first body."""
    camera = camera or scene.camera
    eye = eye or camera.eye(size)
    geometry = flatten(scene)
    bodies = bodies_of(scene, geometry)
    surroundings = surroundings_of(geometry, bodies)
    body_rays = rays_of(bodies[0], eye)
    occluder = surroundings.occluders(np.asarray(camera.position, float), body_rays.side.optics.positions)
    patches = divide(body_rays.rays, seen_faces(body_rays.rays, size), np.radians(field))
    plans = [plan_map(body_rays, faces, occluder, surroundings, options or Options()) for faces in patches]
    return Planned(surroundings, body_rays, occluder, tuple(patches), tuple(plans))


def plan_of(
    scene: Scene, camera: Camera | None = None, size: tuple[int, int] = SIZE, options: Options | None = None
) -> tuple[BodyRays, MapPlan | None]:
    """The first body's rays, and the plan of the one patch that it needs."""
    found = planned(scene, camera, size, options)
    assert len(found.plans) <= 1
    return found.body_rays, found.plans[0] if found.plans else None
