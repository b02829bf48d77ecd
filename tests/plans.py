"""What per-vertex drawing plans of a scene, without a device: bodies, sights, patches and maps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scenes import SIZE

from anamorph.methods.pervertex.bodies import Sight, bodies_of, see
from anamorph.methods.pervertex.division import divide, seen_faces
from anamorph.methods.pervertex.warp import MapPlan, PlanOptions, plan_map
from anamorph.methods.pervertex.world import World, world_of
from anamorph.scene.camera import Camera, Eye
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Scene

FIELD = 100.0


@dataclass(frozen=True, eq=False)
class Planned:
    """The first body of a scene as an eye sees it, and the maps of its patches."""

    world: World
    sight: Sight
    hider: np.ndarray
    patches: tuple[np.ndarray, ...]
    plans: tuple[MapPlan | None, ...]


def planned(
    scene: Scene,
    camera: Camera | None = None,
    size: tuple[int, int] = SIZE,
    options: PlanOptions | None = None,
    field: float = FIELD,
    eye: Eye | None = None,
) -> Planned:
    """Steps 1 to 3 for all patches of the scene's first body."""
    camera = camera or scene.camera
    eye = eye or camera.eye(size)
    geometry = flatten(scene)
    world = world_of(geometry)
    sight = see(bodies_of(scene, geometry, world)[0], eye)
    hider = world.hiders(np.asarray(camera.position, float), sight.side.optics.positions)
    patches = divide(sight.rays, seen_faces(sight.rays, size), np.radians(field))
    plans = [plan_map(sight, faces, hider, world, options or PlanOptions()) for faces in patches]
    return Planned(world, sight, hider, tuple(patches), tuple(plans))


def plan_of(
    scene: Scene, camera: Camera | None = None, size: tuple[int, int] = SIZE, options: PlanOptions | None = None
) -> tuple[Sight, MapPlan | None]:
    """The first body's sight, and the plan of the one patch that it needs."""
    found = planned(scene, camera, size, options)
    assert len(found.plans) <= 1
    return found.sight, found.plans[0] if found.plans else None
