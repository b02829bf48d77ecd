"""How long a frame takes, in the steady state: the eye moves each frame, and nothing is read back."""

from __future__ import annotations

import statistics
import time
from collections.abc import Generator, Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from anamorph.base.vectors import tuple_of
from anamorph.methods.session import Session
from anamorph.raymesh import RayMesh
from anamorph.scene.camera import Camera
from anamorph.scene.model import Scene

Name = TypeVar("Name", bound=Hashable)

WARM_UP = 3
"""Frames that are drawn but not counted: shaders are compiled at their first use."""

ORBIT = 0.005
"""Radius of the eye's path, relative to its distance from the nearest mirror: 4 mm at 0.8 m."""


@dataclass(frozen=True)
class Timing:
    """Milliseconds a frame, over `n` frames."""

    median: float
    min: float
    max: float
    n: int


def timing_of(milliseconds: Sequence[float]) -> Timing:
    """The timing of frames that took so long each."""
    return Timing(statistics.median(milliseconds), min(milliseconds), max(milliseconds), len(milliseconds))


def eye_path(scene: Scene, n: int) -> list[Camera]:
    """`n` cameras with the scene's target, whose eyes go round a small circle about its own, in the image's plane.

    Its radius follows from how far the nearest vertex of a specular mesh is, or the target where there is none.
    """
    camera = scene.camera
    right, up, _ = camera.axes()
    places = [mesh.positions for mesh in scene.meshes if mesh.specular] or [np.array([camera.target])]
    radius = ORBIT * np.linalg.norm(np.concatenate(places).astype(float) - camera.position, axis=1).min()
    turns = 2.0 * np.pi * np.arange(n) / n
    offsets = radius * (np.cos(turns)[:, None] * right + np.sin(turns)[:, None] * up)
    return [replace(camera, position=tuple_of(camera.position + offset)) for offset in offsets]


def timing_rounds(
    sessions: Mapping[Name, Session], cameras: Sequence[Camera | RayMesh], minimum: int = 30
) -> Generator[tuple[int, int], None, dict[Name, Timing]]:
    """Time sessions side by side: each draws a frame from one camera before any goes on to the next.

    What else the machine does thus falls on all of them alike. Yields the rounds done, and their number.
    """
    spent: dict[Name, list[float]] = {name: [] for name in sessions}
    counted = max(minimum, len(cameras))
    for round_number in range(-WARM_UP, counted):
        for name, session in sessions.items():
            start = time.perf_counter()
            session.draw(cameras[round_number % len(cameras)])
            session.wait()
            if round_number >= 0:
                spent[name].append(1000.0 * (time.perf_counter() - start))
        yield round_number + WARM_UP + 1, counted + WARM_UP
    return {name: timing_of(ms) for name, ms in spent.items()}
