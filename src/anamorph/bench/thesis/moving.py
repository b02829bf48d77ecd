"""Timing methods on one scene, while the camera moves from frame to frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.frame import View
from anamorph.measure.frame_times import ORBIT, Timing, eye_path, time_in_turn
from anamorph.methods import parse
from anamorph.methods.protocol import Session
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


def open_sessions(view: View, methods: Sequence[str]) -> dict[str, Session]:
    """A session of each method specification."""
    opened = {}
    for specification in methods:
        method, options = parse(specification)
        opened[specification] = method.open(view, options)
    return opened


@dataclass(frozen=True)
class Times:
    """What a frame takes by each method, milliseconds, and why some could not draw it."""

    timings: dict[str, Timing]
    refusals: dict[str, str]


def time_methods(
    scene: Scene, camera: RayMesh | None, size: tuple[int, int], methods: Sequence[str], frames: int
) -> Times:
    """Time methods, which take turns; without a `camera`, that of the scene."""
    view = View(scene, camera or scene.camera, size)
    sessions, refusals = open_sessions(view, methods), {}
    for name in methods:
        try:
            sessions[name].draw(view.camera)
        except AnamorphError as error:
            refusals[name] = str(error)
            del sessions[name]
    return Times(time_in_turn(sessions, camera_path(view, frames), frames), refusals)
