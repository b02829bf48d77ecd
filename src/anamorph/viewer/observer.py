"""Where one looks from to see an eye, the mirror before it, and what the mirror shows it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from anamorph.base.vectors import Vector, tuple_of
from anamorph.measure.angles import normalized
from anamorph.optics.laws import reflect
from anamorph.rays.caster import Caster, beyond
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Glass, Scene
from anamorph.scene.parts import specular_parts

ASIDE = np.radians([55.0, 80.0, 30.0, 105.0])
"""Angles between where the eye stands and where the observer does, seen from above the mirror, the best first."""

ABOVE = np.radians([35.0, 15.0, 60.0])
"""Of the observer's view, the best first."""

SHOWN, SKY = 2.5, 1.0
"""How much of the line of sight beyond the mirror is seen at most, and where it leads into the sky: in distances
between eye and mirror."""

SHARES = 1.0, 0.5, 0.2
"""How much of that is seen, the best first: in a room there may be no place from which more is."""

FIELD_OF_VIEW = 45.0
"""The observer's, degrees, where nothing stands in its way; it goes up to `WIDEST` to look from before a wall."""

WIDEST, TOO_WIDE = 90.0, 120.0

FILLED = 0.75
"""The share of the observer's image, as high as wide, that is filled at the start."""

CLEARANCE = 0.9
"""How far toward a wall an observer goes."""

FLAT = 0.3
"""How long the mean of a mirror's normals is, at least, where the mirror as a whole faces somewhere."""


@dataclass(frozen=True, eq=False)
class _Subject:
    """What the observer's image is about: an eye, the middle of a mirror or lens, and the end of the line of sight.

    With the `corners` (8, 3) of the box around the mirror or lens, and the unit vector to where it faces.
    """

    eye: np.ndarray
    middle: np.ndarray
    end: np.ndarray
    corners: np.ndarray
    facing: np.ndarray

    def shortened(self, share: float) -> _Subject:
        """With less beyond the mirror."""
        return replace(self, end=self.middle + share * (self.end - self.middle))

    @property
    def points(self) -> np.ndarray:
        """All that is to be in the observer's image, (10, 3)."""
        return np.stack([self.eye, self.end, *self.corners])

    @property
    def unhidden(self) -> np.ndarray:
        """What nothing should hide from the observer, (3, 3): the mirror by a point before it."""
        before = self.middle + 0.6 * np.linalg.norm(np.ptp(self.corners, axis=0)) * self.facing
        return np.stack([self.eye, before, self.end])


def first_observer(scene: Scene, camera: Camera) -> Camera:
    """A place aside and above from which the eye, the mirror or lens, and where its line of sight goes on are seen.

    Of several such places the one from which most of these are not hidden; within a room, if the eye is.

    Parameters
    ----------
    scene : Scene
        Of its mirrors and lenses, the one nearest to the line of sight counts. Without any, the camera's target
        stands for it.
    camera : Camera
        The eye.
    """
    caster = Caster(flatten(scene)) if scene.meshes else None
    subject = _subject_of(scene, camera, caster)
    up = np.asarray(camera.up, float) / np.linalg.norm(camera.up)
    right = camera.axes()[0]
    back = np.cross(right, up)
    # On the side that a mirror turns to, its face is seen and not its back.
    side = -1.0 if subject.facing @ right < 0.0 else 1.0
    candidates = []
    for share, above, sideways, aside in product(SHARES, ABOVE, (side, -side), ASIDE):
        horizontal = np.cos(aside) * back + sideways * np.sin(aside) * right
        toward = np.cos(above) * horizontal + np.sin(above) * up
        candidates.append(_observer(subject.shortened(share), toward, camera.up, caster))
    return max(candidates, key=lambda observer: _merit(observer, subject, caster))


def _subject_of(scene: Scene, camera: Camera, caster: Caster | None) -> _Subject:
    eye, forward = np.asarray(camera.position, float), camera.axes()[2]
    boxes = []
    for part in specular_parts(scene.meshes).values():
        group = [index for index in part if scene.meshes[index].specular]
        positions = np.concatenate([scene.meshes[index].positions for index in group]).astype(float)
        boxes.append((group, positions.min(axis=0), positions.max(axis=0)))
    if not boxes:
        target = np.asarray(camera.target, float)
        return _Subject(eye, target, target, np.tile(target, (8, 1)), -forward)
    group, low, high = max(boxes, key=lambda box: float(normalized((box[1] + box[2]) / 2.0 - eye) @ forward))
    middle, looking = (low + high) / 2.0, normalized((low + high) / 2.0 - eye)
    meshes = [scene.meshes[index] for index in group]
    normal = np.concatenate([mesh.normals for mesh in meshes]).astype(float).mean(axis=0)
    refracts = any(isinstance(mesh.material, Glass) for mesh in meshes)
    # A ball's normals cancel each other out: what is seen of it faces the eye.
    facing = normalized(normal) if np.linalg.norm(normal) > FLAT and not refracts else -looking
    onward = looking if refracts else reflect(looking[None], facing[None])[0]
    size = float(np.linalg.norm(high - low))
    distance = float(np.linalg.norm(middle - eye))
    free = _free(caster, middle, onward, np.inf, near=size)
    reach = min(free, SHOWN * distance) if np.isfinite(free) else SKY * distance
    corners = np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(-1, 3)
    return _Subject(eye, middle, middle + reach * onward, corners, facing)


def _observer(subject: _Subject, toward: np.ndarray, up: Vector, caster: Caster | None) -> Camera:
    """One that looks from `toward` (3,), as far away as shows all, or as the next wall lets it."""
    points = subject.points
    target = (points.min(axis=0) + points.max(axis=0)) / 2.0
    axes = Camera(tuple_of(target + toward), tuple_of(target), up).axes()
    across, upward, ahead = axes @ (points - target).T
    offset = np.maximum(np.abs(across), np.abs(upward)) / FILLED
    wanted = float((offset / np.tan(np.radians(FIELD_OF_VIEW) / 2.0) - ahead).max())
    distance = _free(caster, target, toward, wanted)
    slope = (offset / np.maximum(distance + ahead, 1e-9 * wanted)).max()
    field_of_view = float(np.degrees(2.0 * np.arctan(slope)))
    return Camera(tuple_of(target + distance * toward), tuple_of(target), up, min(field_of_view, TOO_WIDE))


def _merit(observer: Camera, subject: _Subject, caster: Caster | None) -> float:
    """How much of what counts can be seen; below 0 where everything is too small for that."""
    if observer.field_of_view > WIDEST or caster is None:
        return -observer.field_of_view
    rays = subject.unhidden - observer.position
    length = np.linalg.norm(rays, axis=1)
    hits = caster.cast(np.tile(observer.position, (3, 1)), rays / length[:, None])
    return float((hits.distance > (1.0 - 1e-3) * length).sum())


def _free(caster: Caster | None, start: np.ndarray, toward: np.ndarray, wanted: float, near: float = 0.0) -> float:
    """How far one gets from `start` (3,), up to what is `wanted`, without getting too near to anything."""
    if caster is None:
        return wanted
    origin, direction = start[None], toward[None]
    found = float(caster.cast(origin, direction, np.maximum(near, beyond(origin, direction))).distance[0])
    return min(wanted, CLEARANCE * found)
