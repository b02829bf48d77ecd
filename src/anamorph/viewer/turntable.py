"""A turntable: the eye goes round what it looks at, or from one view to the next, and a video keeps what it sees."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from anamorph.base.errors import AnamorphError
from anamorph.base.output import to_pixels
from anamorph.base.steps import mapped
from anamorph.base.vectors import tuple_of
from anamorph.base.video import MOST_FRAMES, check_video, video
from anamorph.frame import View
from anamorph.methods import Specification
from anamorph.methods.averaging import averaging
from anamorph.scene.camera import Camera
from anamorph.scene.camera_path import camera_between
from anamorph.scene.model import Scene
from anamorph.viewer.facts import Progress
from anamorph.viewer.remembered import LEAST
from anamorph.viewer.saving import Saving, saved

FRAMES = 120
"""Of a turntable."""

LEG = 60
"""Frames from one view of a path to the next."""

RATE = 30.0
"""Frames a second."""


def orbit(camera: Camera, frames: int = FRAMES, swing: float | None = None) -> list[Camera]:
    """Cameras that go once round the target, about the camera's own upward direction; the first is `camera`.

    With a `swing`, in degrees, they go that far to the right, that far to the left, and back: behind a mirror there is
    little to see.
    """
    _check_frames(frames)
    if swing is not None and not 0.0 < swing <= 180.0:
        raise AnamorphError(f"swing is {swing:g}; give more than 0 and at most 180 degrees to either side")
    turns = 2.0 * np.pi * np.arange(frames) / frames
    angles = turns if swing is None else np.radians(swing) * np.sin(turns)
    axis = np.array(camera.up, float) / np.linalg.norm(camera.up)
    offsets = Rotation.from_rotvec(angles[:, None] * axis).apply(np.subtract(camera.position, camera.target))
    return [camera, *(replace(camera, position=tuple_of(camera.target + offset)) for offset in offsets[1:])]


def between(views: Sequence[Camera], frames: int | None = None) -> list[Camera]:
    """Cameras that go through some views in equal times, and stand still for a moment in each.

    On the way they orbit about their target, about the upward direction, so that a horizon that is level stays so; the
    distance grows or shrinks evenly, so that they pass through nothing that they look at.

    Parameters
    ----------
    views : sequence of Camera
        The first and the last of them are the first and the last camera.
    frames : int, optional
        As many as there are views, or more; `LEG` from each view to the next, unless given.
    """
    if len(views) < LEAST:
        raise AnamorphError(f"a path goes through at least {LEAST} views, not {len(views)}; remember more of them")
    frames = min(LEG * (len(views) - 1) + 1, MOST_FRAMES) if frames is None else frames
    _check_frames(frames)
    if frames < len(views):
        raise AnamorphError(f"frames is {frames}; give at least {len(views)}, one for each view of the path")
    path = []
    for place in np.linspace(0.0, len(views) - 1, frames):
        number = min(int(place), len(views) - 2)
        share = place - number
        path.append(camera_between(views[number], views[number + 1], share * share * (3.0 - 2.0 * share)))
    return path


def _check_frames(frames: int) -> None:
    if not 1 <= frames <= MOST_FRAMES:
        raise AnamorphError(f"frames is {frames}; give a whole number from 1 to {MOST_FRAMES}")


def turntable(
    path: str | Path,
    scene: Scene,
    method: Specification,
    cameras: Sequence[Camera],
    size: tuple[int, int],
    samples: int = 1,
    rate: float = RATE,
) -> Saving:
    """Save a video of what cameras see one after another.

    Parameters
    ----------
    path : str or Path
        Ends in .webm or .webp; without a suffix, a folder for numbered PNG images.
    scene : Scene
    method : Specification
    cameras : sequence of Camera
        One for each frame: `orbit`'s or `between`'s.
    size : (width, height)
        Pixels.
    samples : int
        A side: a frame averages samples x samples images.
    rate : float
        Frames a second.
    """
    path = Path(path)
    check_video(path, size)
    total = len(cameras) * samples**2
    yield Progress(f"opening {method.method.name}", 0, total)
    session = method.open(View(scene, cameras[0], size))
    with video(path, size, rate) as add:
        for number, camera in enumerate(cameras):
            as_progress = partial(_progress, f"frame {number + 1} of {len(cameras)}", number * samples**2, total)
            add(to_pixels((yield from mapped(averaging(session, camera, samples), as_progress))))
    return saved(path)


def _progress(frame: str, before: int, total: int, drawn: tuple[int, int]) -> Progress:
    return Progress(frame, before + drawn[0], total)
