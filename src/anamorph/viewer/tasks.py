"""What a request begins: work in steps, between which the viewer goes on drawing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from anamorph.files.view_file import Opened
from anamorph.scene.camera import Camera
from anamorph.scene.model import Scene
from anamorph.viewer.facts import Progress, Request
from anamorph.viewer.saving import Saving, free_name, save_comparison, save_image, save_scene
from anamorph.viewer.showing import Showing
from anamorph.viewer.state import State, looking_eye, shown_camera
from anamorph.viewer.turntable import between, orbit, turntable

SWING = 20.0
"""Degrees to either side that the eye goes in a turntable; an observer goes all the way round."""

MOST_SAMPLES = 2
"""A side, of a video's frames: it has many."""


@dataclass(frozen=True, eq=False)
class Shot:
    """What is on the canvas when something is asked for.

    Parameters
    ----------
    opened : Opened
    scene : Scene
        With what its controls are set to.
    state : State
    size : (width, height)
        Of the image, pixels.
    showing : Showing
    pixels : callable
        Gives the image as it is shown, (H, W, 3) uint8 sRGB.
    """

    opened: Opened
    scene: Scene
    state: State
    size: tuple[int, int]
    showing: Showing
    pixels: Callable[[], np.ndarray]


def saving_of(request: Request, shot: Shot, directory: Path) -> Saving:
    """The work that a request asks for, in a directory, under a name that is free there."""

    def name(suffix: str) -> Path:
        return free_name(directory, shot.opened.scene.name, suffix)

    state, size = shot.state, shot.size
    match request:
        case Request.SAVE_SCENE:
            return _at_once(lambda: save_scene(name(".toml"), shot.opened, state, size))
        case Request.SAVE_COMPARISON:
            methods = tuple(dict.fromkeys(half.method for half in (state.first, state.second)))
            scene = replace(shot.scene, camera=looking_eye(state))
            return save_comparison(name(".html"), scene, methods, size, "anamorph view")
        case Request.SAVE_TURNTABLE | Request.SAVE_TURNTABLE_SERIES:
            cameras = orbit(shown_camera(state), swing=None if state.observer else SWING)
            return _filmed(shot, cameras, name(".webm" if request is Request.SAVE_TURNTABLE else ""))
        case Request.SAVE_PATH | Request.SAVE_PATH_SERIES:
            return _filmed(shot, between(state.views), name(".webm" if request is Request.SAVE_PATH else ""))
    return _once_refined(shot, lambda: save_image(name(".png"), shot.pixels()))


def _filmed(shot: Shot, cameras: Sequence[Camera], path: Path) -> Saving:
    """What the first half's method shows to cameras one after another."""
    samples = min(shot.state.samples, MOST_SAMPLES)
    return turntable(path, shot.scene, shot.state.first.method, cameras, shot.size, samples)


def _at_once(save: Callable[[], str]) -> Saving:
    """Work of a single step."""
    yield Progress("saving", 0, 1)
    return save()


def _once_refined(shot: Shot, save: Callable[[], str]) -> Saving:
    """Work of a single step, when the image is as good as it gets."""
    while shot.showing.rest():
        yield Progress("refining the image", shot.showing.samples_done, max(shot.state.samples**2, 1))
    return save()
