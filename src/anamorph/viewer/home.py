"""Where a viewer of a scene starts, and what its resets return to."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from anamorph.methods import METHODS
from anamorph.methods.environment import reflectors
from anamorph.optics.laws import reflect
from anamorph.scene.camera import Camera, Vector
from anamorph.scene.model import Glass, Scene
from anamorph.viewer.state import State

ASIDE, FACING, ABOVE = 1.0, 0.6, 0.9
"""From where an observer looks: to the side of the eye, before the mirror, and from above, in these parts."""

SHOWN = 2.5
"""How much of the reflected line of sight an observer sees, in distances between eye and mirror."""

FIELD_OF_VIEW = 45.0
"""The observer's, degrees."""

FLAT = 0.3
"""How long the mean of a mirror's normals is, at least, where the mirror as a whole faces somewhere."""

FILLED = 0.75
"""The share of the observer's picture, as high as wide, that is filled at the start."""


@dataclass(frozen=True, eq=False)
class Home:
    """Where a viewer starts.

    Parameters
    ----------
    state : State
    scene : Scene
        As it was opened.
    """

    state: State
    scene: Scene

    @property
    def methods(self) -> tuple[str, ...]:
        """The names of the methods that can draw the scene."""
        return tuple(name for name, method in METHODS.items() if method.refracts or not self.scene.refracts)


def reset_view(state: State, home: Home) -> State:
    """The camera back at its start, and the observer, if one looks, at where it starts."""
    camera = home.state.camera
    observer = None if state.observer is None else first_observer(home.scene, camera)
    return replace(state, camera=camera, observer=observer)


def first_observer(scene: Scene, camera: Camera) -> Camera:
    """A place aside and above from which the eye, the mirror or lens, and where its line of sight goes on are seen.

    Parameters
    ----------
    scene : Scene
        Of its mirrors and lenses, the one nearest to the line of sight counts. Without any, the camera's target
        stands for it.
    camera : Camera
        The eye.
    """
    eye = np.asarray(camera.position, float)
    right, above, _ = camera.axes()
    points, facing, onward = _looked_at(scene, camera)
    middle = points.mean(axis=0)
    shown = np.stack([eye, middle + SHOWN * np.linalg.norm(middle - eye) * onward, *points])
    # On the side that a mirror turns to, its face is seen and not its back.
    side = -1.0 if facing @ right < 0.0 else 1.0
    toward = _unit(ASIDE * side * right + FACING * facing + ABOVE * above)
    target = (shown.min(axis=0) + shown.max(axis=0)) / 2.0
    observer = Camera(_tuple(target + toward), _tuple(target), camera.up, FIELD_OF_VIEW)
    across, upward, ahead = observer.axes() @ (shown - target).T
    slope = FILLED * np.tan(np.radians(FIELD_OF_VIEW) / 2.0)
    distance = (np.maximum(np.abs(across), np.abs(upward)) / slope - ahead).max()
    return replace(observer, position=_tuple(target + distance * toward))


def _looked_at(scene: Scene, camera: Camera) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of the mirror or lens that is looked at: the corners of its box (8, 3), where it faces, and where sight goes."""
    eye, forward = np.asarray(camera.position, float), camera.axes()[2]
    boxes = []
    for group in reflectors(scene):
        positions = np.concatenate([scene.meshes[index].positions for index in group]).astype(float)
        boxes.append((group, positions.min(axis=0), positions.max(axis=0)))
    if not boxes:
        return np.tile(camera.target, (8, 1)).astype(float), -forward, forward
    group, low, high = max(boxes, key=lambda box: float(_unit((box[1] + box[2]) / 2.0 - eye) @ forward))
    corners = np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(-1, 3)
    sight = _unit((low + high) / 2.0 - eye)
    meshes = [scene.meshes[index] for index in group]
    normal = np.concatenate([mesh.normals for mesh in meshes]).astype(float).mean(axis=0)
    if any(isinstance(mesh.material, Glass) for mesh in meshes):
        return corners, -sight, sight
    # A ball's normals cancel each other out: what is seen of it faces the eye.
    facing = _unit(normal) if np.linalg.norm(normal) > FLAT else -sight
    return corners, facing, reflect(sight[None], facing[None])[0]


def _unit(vector: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vector)
    return vector / length if length > 0.0 else vector


def _tuple(vector: np.ndarray) -> Vector:
    x, y, z = vector.tolist()
    return (x, y, z)
