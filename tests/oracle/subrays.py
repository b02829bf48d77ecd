"""What a frame shows, and whether one of many rays through a pixel sees it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from oracle.scene import Camera
from oracle.tracer import Seen, Tracer

ACROSS = (9, 17)
"""Sub-rays from side to side of a pixel's circle: of every pixel, and of those where one of the first
passes by what is shown and sees something else."""

MANY = 1 << 20
"""Sub-rays that are traced in one go."""

CLOSE = 1e-5
"""Radians: what is seen as near as this is the same."""

DEPTH = 0.05
"""By what share of its distance a point may be nearer or farther than what a ray in its direction meets."""

ROUNDING = 2.0**-22
"""By how much of its largest coordinate a position of float32 may be off, twice its rounding in three directions."""


@dataclass(frozen=True, eq=False)
class Shown:
    """The seen buffers of a frame, (H, W, ...) or (N, ...).

    Sky pixels have the direction as their position. `direction` is that of the frame's own last rays, where it has
    them, and else zero.
    """

    position: np.ndarray
    object_id: np.ndarray
    specular: np.ndarray
    status: np.ndarray
    direction: np.ndarray

    @property
    def size(self) -> tuple[int, int]:
        height, width = self.object_id.shape
        return width, height

    def flat(self) -> Shown:
        numbers = (getattr(self, name).astype(np.int64).ravel() for name in ("object_id", "specular", "status"))
        vectors = (getattr(self, name).astype(float).reshape(-1, 3) for name in ("position", "direction"))
        return Shown(next(vectors), *numbers, next(vectors))

    def __getitem__(self, chosen: np.ndarray) -> Shown:
        return Shown(**{name: values[chosen] for name, values in vars(self).items()})


def toward(seen: Seen, shown: Shown) -> tuple[np.ndarray, np.ndarray]:
    """Unit directions, (N, 3), from the last rays' origins to what is shown, and its distances; infinite for the sky.

    A point at the origin itself is in the ray's own direction.
    """
    sky = shown.object_id == 0
    offset = np.where(sky[:, None], shown.position, shown.position - seen.origin)
    length = np.linalg.norm(offset, axis=1)
    at_origin = length <= ROUNDING * np.abs(seen.origin).max(axis=1, initial=0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        directions = np.where((at_origin & ~sky)[:, None], seen.direction, offset / length[:, None])
    return directions, np.where(sky, np.inf, length)


def offsets_of(seen: Seen, shown: Shown, rounded: bool = True) -> np.ndarray:
    """From the last rays' directions to those of what is shown, (N, 3); with `rounded`, less what rounding explains.

    Where nothing is shown, the offset is not a number.
    """
    directions, distance = toward(seen, shown)
    offset = directions - seen.direction
    if not rounded:
        return offset
    length = np.linalg.norm(offset, axis=1)
    coordinate = np.where(np.isinf(distance), 1.0, np.abs(shown.position).max(axis=1))
    explained = ROUNDING * coordinate / np.where(np.isinf(distance), 1.0, np.maximum(distance, 1e-300))
    with np.errstate(invalid="ignore", divide="ignore"):
        return offset * np.where(length > explained, 1.0 - explained / length, 0.0)[:, None]


def any_subray_sees(
    tracer: Tracer, camera: Camera, size: tuple[int, int], centres: np.ndarray, shown: Shown, radius: float
) -> np.ndarray:
    """Whether some ray within `radius` pixels of image points (N, 2) sees what is shown there, (N,) bool.

    It does if it looks at the same specular surface, ends on the same object, and passes by the point shown, and ends
    before or behind it, no further than the next ray of the grid does.
    """
    sees, left = np.zeros(len(centres), bool), np.arange(len(centres))
    for across in ACROSS:
        few, again = MANY // across**2, []
        for start in range(0, len(left), few):
            own = left[start : start + few]
            sees[own], passes = _any_of_few(tracer, camera, size, centres[own], shown[own], radius, across)
            again.append(own[passes & ~sees[own]])
        left = np.concatenate([*again, np.zeros(0, np.int64)])
    return sees


def _any_of_few(
    tracer: Tracer, camera: Camera, size: tuple[int, int], centres: np.ndarray, shown: Shown, radius: float, across: int
) -> tuple[np.ndarray, np.ndarray]:
    """Whether some of a grid of sub-rays sees what is shown, and whether some passes by it, (N,) bool each."""
    ticks = radius * np.linspace(-1.0, 1.0, across)
    grid = np.stack(np.meshgrid(ticks, ticks), axis=-1)
    inside = np.linalg.norm(grid, axis=-1) <= radius * (1.0 + 1e-9)
    count, rays = len(centres), int(inside.sum())
    seen = tracer.look(camera, (centres[:, None] + grid[inside]).reshape(-1, 2), size)
    every = shown[np.repeat(np.arange(count), rays)]
    distance = toward(seen, every)[1]
    path = seen.specular * 4096 + seen.last * 16 + seen.bounces
    turn = _spacing(inside, count, path, seen.direction, CLOSE)
    step = _spacing(inside, count, path * 65536 + seen.object_id, depths(seen)[:, None], 0.0)
    passes = (np.linalg.norm(offsets_of(seen, every), axis=1) <= turn) & (seen.specular == every.specular)
    near = (every.object_id == 0) | (np.abs(depths(seen) - distance) <= step + DEPTH * distance)
    sees = passes & near & (seen.object_id == every.object_id)
    return sees.reshape(count, rays).any(axis=1), passes.reshape(count, rays).any(axis=1)


def depths(seen: Seen) -> np.ndarray:
    """How long the last rays are, (N,) metres; 0 for the sky."""
    return np.where(seen.object_id == 0, 0.0, np.linalg.norm(seen.position - seen.origin, axis=1))


def _spacing(inside: np.ndarray, count: int, labels: np.ndarray, values: np.ndarray, least: float) -> np.ndarray:
    """How far the values (rays, K) of neighbours in a pixel's grid that have one label are apart, at most, (rays,)."""
    label = np.full((count, *inside.shape), -1)
    value, spacing = np.zeros((*label.shape, values.shape[1])), np.full(label.shape, least)
    label[:, inside], value[:, inside] = labels.reshape(count, -1), values.reshape(count, -1, values.shape[1])
    every, before, after = np.s_[:], np.s_[:-1], np.s_[1:]
    for one, other in (
        ((every, before), (every, after)),
        ((every, every, before), (every, every, after)),
    ):
        apart = np.where(label[one] == label[other], np.linalg.norm(value[one] - value[other], axis=-1), 0.0)
        spacing[one], spacing[other] = np.maximum(spacing[one], apart), np.maximum(spacing[other], apart)
    # A ray alone on its path, between two silhouettes, is taken to be as far from the next as others of its pixel are.
    largest = spacing.max(axis=(1, 2), keepdims=True)
    return np.where(spacing <= least, largest, spacing)[:, inside].ravel()
