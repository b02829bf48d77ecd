"""Timing methods on one scene, while the camera moves from frame to frame."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.base.steps import drain
from anamorph.frame import View
from anamorph.measure.frame_times import ORBIT, Timing, eye_path, timing_rounds
from anamorph.methods import Session, Specification
from anamorph.raymesh import RayMesh
from anamorph.scene.model import Scene


def camera_path(view: View, count: int) -> list:
    """`count` cameras about that of `view`, none like another: those of `eye_path`, or ray meshes that are moved.

    A ray mesh goes round a circle across its mean direction, as large as `ORBIT` of the box around its origins, or of
    the mean length of its directions where they start at one point.
    """
    rays = view.camera
    if not isinstance(rays, RayMesh):
        return eye_path(view.scene, count)
    extent = np.linalg.norm(np.ptp(rays.origins, axis=0)) or np.linalg.norm(rays.directions, axis=1).mean()
    across = np.linalg.svd(rays.directions.mean(axis=0)[None])[2][1:]
    turns = 2.0 * np.pi * np.arange(count) / count
    offsets = ORBIT * extent * (np.column_stack([np.cos(turns), np.sin(turns)]) @ across)
    return [replace(rays, origins=rays.origins + offset) for offset in offsets]


def open_sessions(view: View, methods: Iterable[Specification]) -> dict[Specification, Session]:
    """A session of each method."""
    return {method: method.open(view) for method in methods}


@dataclass(frozen=True)
class Times:
    """What a frame takes by each method, milliseconds, its session, and why some could not draw it."""

    timings: dict[Specification, Timing]
    sessions: dict[Specification, Session]
    refusals: dict[Specification, str]


def time_methods(
    scene: Scene, camera: RayMesh | None, size: tuple[int, int], methods: Sequence[Specification], frames: int
) -> Times:
    """Time methods, which take turns; without a `camera`, that of the scene."""
    view = View(scene, camera or scene.camera, size)
    sessions, refusals = open_sessions(view, methods), {}
    for method in methods:
        try:
            sessions[method].draw(view.camera)
        except AnamorphError as error:
            refusals[method] = str(error)
            del sessions[method]
    return Times(drain(timing_rounds(sessions, camera_path(view, frames), frames)), sessions, refusals)
