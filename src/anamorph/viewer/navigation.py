"""Moving a camera: around its target, along the image, nearer, and turned in place.

Every function takes a camera and gives another; none has a state of its own. "Up" is the camera's own up vector
throughout: it stays as it is, so that no sequence of movements tilts the horizon.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from anamorph.base.vectors import Vector, tuple_of
from anamorph.scene.camera import Camera
from anamorph.viewer.state import State

STEEPEST = np.radians(89.0)
"""How far a view may rise or fall: at the pole itself, right and left would be undefined."""

NEAREST, FARTHEST = 1e-3, 1e5
"""Limits of the distance between eye and target, metres."""

OUTERMOST = 1e6
"""How far out a target can get along any axis, metres: beyond, eye and target would run into one number."""

NARROWEST, WIDEST = 1.0, 150.0
"""Limits of the field of view, degrees."""


def orbit(camera: Camera, right: float, up: float) -> Camera:
    """The camera moved around its target, which stays where it is and as far away.

    Parameters
    ----------
    camera : Camera
    right, up : float
        How far the eye goes, radians. It stops short of the pole above the target and of the one below.
    """
    away = np.subtract(camera.position, camera.target)
    return replace(camera, position=tuple_of(camera.target + _turned(away, camera.up, right, up)))


def look(camera: Camera, right: float, up: float) -> Camera:
    """The camera turned in place: its target goes around it.

    Parameters
    ----------
    camera : Camera
    right, up : float
        How far it turns, radians. It stops short of straight up and straight down.
    """
    ahead = _turned(np.subtract(camera.target, camera.position), camera.up, -right, up)
    return _placed(camera, camera.position + ahead, -ahead)


def pan(camera: Camera, right: float, up: float) -> Camera:
    """The camera moved along its image, so that what is seen at the target's distance moves in it.

    Parameters
    ----------
    camera : Camera
    right, up : float
        How far that moves, as shares of the image's height.
    """
    target = camera.target - _in_image(camera, right, up)
    return _placed(camera, target, np.subtract(camera.position, camera.target))


def zoom(camera: Camera, factor: float, toward: tuple[float, float] = (0.0, 0.0)) -> Camera:
    """The camera brought nearer, so that what is seen at the target's distance is `factor` times as large.

    Parameters
    ----------
    camera : Camera
    factor : float
        Above 1 to come nearer, between 0 and 1 to go away.
    toward : (right, up)
        The point at the target's distance that keeps its place in the image: its offset from the image's middle,
        as shares of the image's height.
    """
    away = np.subtract(camera.position, camera.target)
    distance = np.linalg.norm(away)
    scale = np.clip(distance / factor, NEAREST, FARTHEST) / distance
    return _placed(camera, camera.target + (1.0 - scale) * _in_image(camera, *toward), scale * away)


def magnify(camera: Camera, factor: float) -> Camera:
    """The camera with another field of view, so that its image's middle is `factor` times as large."""
    half = np.arctan(np.tan(np.radians(camera.field_of_view) / 2.0) / factor)
    return replace(camera, field_of_view=float(np.clip(np.degrees(2.0 * half), NARROWEST, WIDEST)))


def steer(state: State, move: Callable[[Camera], Camera]) -> State:
    """The state with what is steered moved: the observer where one looks, else the eye midway between the two."""
    if state.observer is not None:
        return replace(state, observer=move(state.observer))
    return replace(state, camera=move(state.camera))


def _placed(camera: Camera, target: np.ndarray, away: np.ndarray) -> Camera:
    """The camera with `target` (3,), or the nearest that is allowed, and its eye `away` (3,) from it."""
    target = np.clip(target, -OUTERMOST, OUTERMOST)
    return replace(camera, position=tuple_of(target + away), target=tuple_of(target))


def _in_image(camera: Camera, right: float, up: float) -> np.ndarray:
    """The world vector, metres, that spans these shares of the image's height at the target's distance."""
    distance = np.linalg.norm(np.subtract(camera.target, camera.position))
    height = 2.0 * distance * np.tan(np.radians(camera.field_of_view) / 2.0)
    across, above, _ = camera.axes()
    return height * (right * across + up * above)


def _turned(vector: np.ndarray, pole: Vector, around: float, up: float) -> np.ndarray:
    """`vector` (3,) turned counter-clockwise `around` the pole, and `up` toward it; radians."""
    axis = np.asarray(pole, float) / np.linalg.norm(pole)
    length = np.linalg.norm(vector)
    height = float(vector @ axis)
    horizontal = vector - height * axis
    reach = float(np.linalg.norm(horizontal))
    rise = np.clip(np.arctan2(height, reach) + up, -STEEPEST, STEEPEST)
    horizontal = horizontal / reach
    horizontal = np.cos(around) * horizontal + np.sin(around) * np.cross(axis, horizontal)
    return length * (np.cos(rise) * horizontal + np.sin(rise) * axis)
