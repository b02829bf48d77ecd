"""A turntable: the eye goes round what it looks at, or from one view to the next, and a video keeps what it sees."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from anamorph.errors import AnamorphError
from anamorph.frame import View
from anamorph.methods import parse
from anamorph.methods.averaging import averaging
from anamorph.output import to_pixels
from anamorph.scene.camera import Camera
from anamorph.scene.model import Scene
from anamorph.steps import retold
from anamorph.video import MOST_FRAMES, check_video, video
from anamorph.viewer.facts import Progress
from anamorph.viewer.saving import Saving, saved

FRAMES = 120
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
    return [camera, *(_moved(camera, np.add(camera.target, offset)) for offset in offsets[1:])]


def between(views: Sequence[Camera], frames: int = FRAMES) -> list[Camera]:
    """Cameras that go through some views in equal times, and stand still for a moment in each.

    The eye turns about its target on the way, its distance growing or shrinking evenly, so that it passes through
    nothing that it looks at. The first and the last are the first and the last view.
    """
    _check_frames(frames)
    if not views:
        raise AnamorphError("a path needs a view; give at least one camera")
    path = []
    for place in np.linspace(0.0, len(views) - 1, frames):
        number = min(int(place), max(len(views) - 2, 0))
        share = place - number
        path.append(
            _between(views[number], views[min(number + 1, len(views) - 1)], share * share * (3.0 - 2.0 * share))
        )
    return path


def _between(one: Camera, other: Camera, share: float) -> Camera:
    if share in (0.0, 1.0) or one == other:
        return other if share == 1.0 else one
    # Right, up and backward: a right-handed frame, which is what a rotation is.
    frames = [camera.axes() * [[1.0], [1.0], [-1.0]] for camera in (one, other)]
    _, up, back = Slerp([0.0, 1.0], Rotation.from_matrix(frames))(share).as_matrix()
    target = (1.0 - share) * np.array(one.target) + share * np.array(other.target)
    first, last = (np.linalg.norm(np.subtract(each.target, each.position)) for each in (one, other))
    distance = first ** (1.0 - share) * last**share
    x, y, z = target.tolist()
    up_x, up_y, up_z = up.tolist()
    field = one.field_of_view ** (1.0 - share) * other.field_of_view**share
    return _moved(Camera((0.0, 0.0, 0.0), (x, y, z), (up_x, up_y, up_z), float(field)), target + distance * back)


def _moved(camera: Camera, position: np.ndarray) -> Camera:
    x, y, z = position.tolist()
    return replace(camera, position=(x, y, z))


def _check_frames(frames: int) -> None:
    if not 1 <= frames <= MOST_FRAMES:
        raise AnamorphError(f"frames is {frames}; give a whole number from 1 to {MOST_FRAMES}")


def turntable(
    path: str | Path,
    scene: Scene,
    method: str,
    cameras: Sequence[Camera],
    size: tuple[int, int],
    samples: int = 1,
    rate: float = RATE,
) -> Saving:
    """Save a video of what cameras see one after another.

    Parameters
    ----------
    path : str or Path
        Ends in .webm or .webp; without a suffix, a folder for numbered PNG pictures.
    scene : Scene
    method : str
        "NAME[:option=value,...]".
    cameras : sequence of Camera
        One for each frame: `orbit`'s or `between`'s.
    size : (width, height)
        Pixels.
    samples : int
        A side: a frame averages samples x samples pictures.
    rate : float
        Frames a second.
    """
    path = Path(path)
    check_video(path, size)
    chosen, options = parse(method)
    total = len(cameras) * samples**2
    yield Progress(f"opening {chosen.name}", 0, total)
    session = chosen.open(View(scene, cameras[0], size), options)
    with video(path, size, rate) as add:
        for number, camera in enumerate(cameras):
            told = partial(_told, f"frame {number + 1} of {len(cameras)}", number * samples**2, total)
            add(to_pixels((yield from retold(averaging(session, camera, samples), told))))
    return saved(path)


def _told(frame: str, before: int, total: int, drawn: tuple[int, int]) -> Progress:
    return Progress(frame, before + drawn[0], total)
