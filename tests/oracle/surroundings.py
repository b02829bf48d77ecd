"""An eye before a mirror or lens, and boxes all around them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from oracle.parts import box, floor
from oracle.scene import Camera, Part, Scene

FILLED = 0.75
"""The share of the image's height that a mirror or lens takes."""


@dataclass(frozen=True, eq=False)
class Place:
    """Where a mirror or lens stands: its middle, where it looks, and where the eye is, metres."""

    middle: np.ndarray
    facing: np.ndarray
    eye: np.ndarray
    reach: float
    """How far it goes from its middle."""

    @property
    def gaze(self) -> np.ndarray:
        """The unit direction from the eye to the middle."""
        return (self.middle - self.eye) / np.linalg.norm(self.middle - self.eye)

    def camera(self, field_of_view: float | None = None) -> Camera:
        """A camera in the eye that looks at the middle, and by default sees the whole mirror or lens."""
        distance = float(np.linalg.norm(self.middle - self.eye))
        fitting = 2.0 * math.degrees(math.atan(self.reach / FILLED / distance))
        view = min(fitting, 120.0) if field_of_view is None else field_of_view
        return Camera(tuple(self.eye.tolist()), tuple(self.middle.tolist()), view)


def unit(vector: np.ndarray) -> np.ndarray:
    return np.asarray(vector, float) / np.linalg.norm(vector)


def rotation(random: np.random.Generator) -> np.ndarray:
    """Random axes, right-handed."""
    axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
    return axes * np.sign(np.linalg.det(axes))


def place(random: np.random.Generator, reach: float, distance: float, tilt: float = 0.5) -> Place:
    """Somewhere near the origin, with the eye at a distance and the facing turned away from it by about `tilt`."""
    middle = np.array([0.0, 0.2, 0.0]) + random.uniform(-0.3, 0.3, 3)
    toward = unit(random.normal(size=3) * [1.0, 0.3, 1.0])
    facing = unit(toward + 0.6 * tilt * random.normal(size=3))
    return Place(middle, facing if facing @ toward > 0.3 else toward, middle + distance * toward, reach)


def boxes(
    random: np.random.Generator,
    where: Place,
    count: int = 60,
    near: float | None = None,
    far: float = 6.0,
    sizes: tuple[float, float] = (0.08, 0.6),
) -> list[Part]:
    """Boxes all around, which leave the mirror, the eye and what is between them free."""
    near = max(1.3 * where.reach + 0.1, 0.4) if near is None else near
    distance = float(np.linalg.norm(where.middle - where.eye))
    made: list[Part] = []
    for _ in range(200 * count):
        if len(made) == count:
            break
        center = where.middle + unit(random.normal(size=3)) * random.uniform(near, far)
        half, axes = 0.5 * random.uniform(*sizes, 3), rotation(random)
        size = float(np.linalg.norm(half))
        ahead = float(np.clip((center - where.eye) @ where.gaze, 0.0, distance))
        aside = float(np.linalg.norm(center - where.eye - ahead * where.gaze))
        at_mirror = np.linalg.norm(center - where.middle) < 1.15 * where.reach + size
        if not at_mirror and aside > size + max(0.15 * min(1.0, distance), 1.05 * where.reach * ahead / distance):
            made.append(box(f"box-{len(made)}", center, half, axes))
    return made


def around(
    random: np.random.Generator, name: str, where: Place, *bodies: Part, camera: Camera | None = None, **how: object
) -> Scene:
    """A scene of mirrors or lenses, a floor below and boxes all around; `how` is for `boxes`."""
    ground = floor(where.middle[1] - 2.5 - where.reach)
    return Scene(name, (*bodies, ground, *boxes(random, where, **how)), camera or where.camera())
