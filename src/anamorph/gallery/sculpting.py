"""Sculptures of lumps that run into each other, and their surface in triangles of any fineness.

A lump is a function that is negative inside, and elsewhere about the distance to its surface; a sculpture is a smooth
union of lumps. Its triangles are a surface net (Gibson, "Constrained elastic surface nets", 1998): one vertex in each
small cube that the surface passes through. Cubes that it cannot reach are left out from the coarsest on.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import PchipInterpolator

from anamorph.base.compiled import compiled, over_all_cores
from anamorph.base.vectors import Vector
from anamorph.gallery.solids import Solid
from anamorph.scene.model import Color

Distance = Callable[[np.ndarray], np.ndarray]
"""From points (N, 3) to (N,): negative inside, and changing by `STEEPEST` at the most in each metre."""

STEEPEST = 1.8
HALVINGS = 4
"""How often the coarsest cubes are halved."""
COARSE = 40
"""Cubes along the longest side of a sculpture when it is first looked at."""
CLOSE, REFINED, TRIES = 0.02, 16, 6
"""How near the number of triangles has to be to what is wanted, by how much it grows at once, and how often."""
TOGETHER = 1024
"""Points that are looked at together: lumps far from all of them are left out."""
FAR = 12.0
"""In lengths of the blend: what is farther than another lump by so much adds nothing to the surface."""
SPANS = 6
"""Straight pieces of a limb from one of its rows to the next."""

CORNERS = np.array(list(product((0, 1), repeat=3)))
EDGES = np.array([(i, i | 4 >> k) for k in range(3) for i in range(8) if not i & 4 >> k])
"""Pairs of a cube's corners: four along each axis."""


@dataclass(frozen=True, eq=False)
class Lump:
    """What is inside a part of a sculpture, its colour, and two corners (2, 3) of a box around it."""

    distance: Distance
    color: Color
    box: np.ndarray


@dataclass(frozen=True, eq=False)
class Sculpture:
    """Lumps that stand on y = 0.

    Parameters
    ----------
    lumps : tuple of Lump
    low, high : three floats
        A box around all, metres.
    blend : float
        How far lumps run into each other, metres.
    relief : callable
        From points (N, 3) to how far the surface is raised there (N,), metres.
    """

    lumps: tuple[Lump, ...]
    low: Vector
    high: Vector
    blend: float
    relief: Distance = lambda points: np.zeros(len(points))

    @cached_property
    def boxes(self) -> np.ndarray:
        """Around each of the M lumps, (M, 2, 3)."""
        return np.stack([lump.box for lump in self.lumps])

    def distances(self, points: np.ndarray) -> tuple[np.ndarray, list[int]]:
        """Of points (N, 3), which are near each other, to the K lumps that matter, (K, N), and which these are."""
        apart = np.maximum(self.boxes[:, 0] - points.max(axis=0), points.min(axis=0) - self.boxes[:, 1])
        gaps = np.linalg.norm(np.maximum(apart, 0.0), axis=1) / STEEPEST
        order, least, found = np.argsort(gaps, kind="stable").tolist(), np.inf, list[np.ndarray]()
        for number in order:
            if gaps[number] > least + FAR * self.blend:
                break
            found.append(self.lumps[number].distance(points))
            least = min(least, found[-1].max())
        return np.stack(found), order[: len(found)]

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Of points (N, 3) to the whole, (N,)."""
        found = np.empty(len(points))

        def work(start: int, stop: int) -> None:
            own, _ = self.distances(points[start:stop])
            least = own.min(axis=0)
            found[start:stop] = least - self.blend * np.log(np.exp((least - own) / self.blend).sum(axis=0))

        over_all_cores(work, len(points), TOGETHER)
        return found - self.relief(points)

    def colors(self, points: np.ndarray) -> np.ndarray:
        """Of points (N, 3) on the surface: each lump's where it is nearest, (N, 3)."""
        colors, found = np.array([lump.color for lump in self.lumps]), np.empty(points.shape)

        def work(start: int, stop: int) -> None:
            own, numbers = self.distances(points[start:stop])
            weights = np.exp((own.min(axis=0) - own) / (0.2 * self.blend))
            found[start:stop] = weights.T @ colors[numbers] / weights.sum(axis=0)[:, None]

        over_all_cores(work, len(points), TOGETHER)
        return found


def limb(rows: ArrayLike, color: Color, flat: Vector | None = None) -> Lump:
    """A smooth curve of balls through `rows` of (x, y, z, radius); along `flat` it is thinner by 1 + its length."""
    curve = np.asarray(rows, float)
    if len(curve) > 2:
        steps = np.linspace(0, len(curve) - 1, SPANS * (len(curve) - 1) + 1)
        curve = PchipInterpolator(np.arange(len(curve)), curve)(steps)
    squeeze, scale = np.eye(3), 1.0
    if flat is not None:
        length = float(np.linalg.norm(flat))
        squeeze, scale = squeeze + np.outer(flat, flat) / length, np.sqrt(1.0 + length)
    reach = curve[:, 3:]
    box = np.stack([(curve[:, :3] - reach).min(axis=0), (curve[:, :3] + reach).max(axis=0)])
    places, radii = curve[:, :3] @ squeeze, curve[:, 3]

    def distance(points: np.ndarray) -> np.ndarray:
        found = np.empty(len(points))
        _nearest(points @ squeeze, places, radii, found)
        return found / scale

    return Lump(distance, color, box)


@compiled
def _nearest(points: np.ndarray, places: np.ndarray, radii: np.ndarray, found: np.ndarray) -> None:
    """Distances (N,) of points (N, 3) to cones from place to place, whose ends are balls."""
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        least = np.inf
        for k in range(len(places) - 1):
            a, b, c = x - places[k, 0], y - places[k, 1], z - places[k, 2]
            u, v, w = places[k + 1, 0] - places[k, 0], places[k + 1, 1] - places[k, 1], places[k + 1, 2] - places[k, 2]
            share = min(max((a * u + b * v + c * w) / (u * u + v * v + w * w), 0.0), 1.0)
            a, b, c = a - share * u, b - share * v, c - share * w
            radius = radii[k] + share * (radii[k + 1] - radii[k])
            least = min(least, math.sqrt(a * a + b * b + c * c) - radius)
        found[i] = least


def mirrored(lump: Lump) -> Lump:
    """The lump and its mirror image in x = 0."""
    both = np.abs(lump.box[:, 0]).max()
    box = np.column_stack([(-both, both), lump.box[:, 1:]])
    return Lump(lambda points: lump.distance(np.column_stack([np.abs(points[:, 0]), points[:, 1:]])), lump.color, box)


def sculpted(sculpture: Sculpture, triangles: int) -> Solid:
    """The closed surface of a sculpture in about so many triangles."""
    cell = float(np.ptp([sculpture.low, sculpture.high], axis=0).max()) / COARSE
    positions, faces = surface_net(sculpture, cell)
    for _ in range(TRIES):
        # The number of cubes along a surface goes with the square of their fineness, nearly.
        cell *= np.sqrt(len(faces) / min(triangles, REFINED * len(faces)))
        positions, faces = surface_net(sculpture, cell)
        if abs(len(faces) / triangles - 1.0) < CLOSE:
            break
    a, b, c = np.moveaxis(positions[faces], 1, 0)
    normals = np.zeros_like(positions)
    for corner in range(3):
        for axis in range(3):
            area = np.cross(b - a, c - a)[:, axis]
            normals[:, axis] += np.bincount(faces[:, corner], area, len(positions))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Solid(positions, normals, np.zeros((len(positions), 2)), sculpture.colors(positions), faces)


def surface_net(sculpture: Sculpture, cell: float) -> tuple[np.ndarray, np.ndarray]:
    """Positions (V, 3) and faces (F, 3): a vertex in each cube of side `cell` that the surface passes through."""
    low = np.asarray(sculpture.low) - 2.0 * cell
    count = np.ceil(np.ptp([sculpture.low, sculpture.high], axis=0) / cell).astype(np.int64) + 5
    cubes = _reached(sculpture.distance, low, cell, count)

    def key(places: np.ndarray) -> np.ndarray:
        return (places[..., 0] * count[1] + places[..., 1]) * count[2] + places[..., 2]

    every = (cubes[:, None] + CORNERS).reshape(-1, 3)
    _, chosen, number = np.unique(key(every), return_index=True, return_inverse=True)
    # In the order of the cubes, in which neighbours stand together.
    order = np.argsort(chosen)
    height = np.empty(len(chosen))
    height[order] = sculpture.distance(low + cell * every[chosen[order]])
    height = height[number.reshape(-1, 8)]
    mixed = (height < 0.0).any(axis=1) & (height >= 0.0).any(axis=1)
    cubes, height = cubes[mixed], height[mixed]
    order = np.argsort(key(cubes))
    cubes, height = cubes[order], height[order]

    first, last = height[:, EDGES[:, 0]], height[:, EDGES[:, 1]]
    crossed = (first < 0.0) != (last < 0.0)
    share = np.where(crossed, first / np.where(crossed, first - last, 1.0), 0.0)
    ends = CORNERS[EDGES]
    crossings = ends[:, 0] + share[..., None] * (ends[:, 1] - ends[:, 0])
    middles = (crossings * crossed[..., None]).sum(axis=1) / crossed.sum(axis=1)[:, None]

    keys, quads = key(cubes), []
    for axis in range(3):
        # Around each lattice edge on which the sign changes stand four cubes.
        b, c = np.roll(np.eye(3, dtype=np.int64), -axis, axis=0)[1:]
        corner = 4 >> axis
        for inside in (True, False):
            own = cubes[((height[:, 0] < 0.0) == inside) & ((height[:, corner] < 0.0) != inside)]
            ring = np.stack([own, own - b, own - b - c, own - c], axis=1)
            quads.append(np.searchsorted(keys, key(ring if inside else ring[:, ::-1])))
    positions = low + cell * (cubes + middles)
    return positions, _halved(positions, np.concatenate(quads))


def _reached(distance: Distance, low: np.ndarray, cell: float, count: np.ndarray) -> np.ndarray:
    """The cubes (N, 3) that the surface may pass through, of `count` along each axis."""
    coarse = -(-count // 2**HALVINGS)
    cubes = np.stack(np.unravel_index(np.arange(coarse.prod()), coarse), axis=-1)
    for halving in range(HALVINGS, -1, -1):
        side = 2**halving * cell
        reach = STEEPEST * np.sqrt(0.75) * side
        cubes = cubes[np.abs(distance(low + side * (cubes + 0.5))) <= reach]
        if halving:
            cubes = (2 * cubes[:, None] + CORNERS).reshape(-1, 3)
    return cubes[(cubes < count).all(axis=1)]


def _halved(positions: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Two triangles of each of `quads` (N, 4), cut along the shorter diagonal."""
    a, b, c, d = np.moveaxis(positions[quads], 1, 0)
    turned = np.linalg.norm(b - d, axis=1) < np.linalg.norm(a - c, axis=1)
    ring = np.where(turned[:, None], np.roll(quads, -1, axis=1), quads)
    return ring[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
