"""What the rays of a warp may hit, and what its maps may see."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from anamorph.rays.caster import Caster
from anamorph.scene.geometry import Geometry

MOST_LAYERS = 4
"""How many of a body's own surfaces a ray is followed through."""

CLOSED = 0.9
"""The share of a closed surface behind which its own other side is."""

MOSTLY = 0.4
"""The share of a border beside which something stands where there is a frame."""

LYING = 0.05
"""How far from a surface, in its sizes, what lies on it may begin."""

BESIDE = 0.1
"""How far from a surface's border, in its sizes, a frame stands."""


@dataclass(frozen=True, eq=False)
class World:
    """A scene around its mirrors.

    Parameters
    ----------
    caster : Caster
    face_object : (F,) uint32
        The object of each triangle that it casts at.
    corners : (8, 3) float64
        Corners of a box around the scene.
    mesh_corners : (meshes, 8, 3) float64
        Corners of the boxes around its meshes.
    diagonal : float
        Of the box around the scene, metres.
    """

    caster: Caster
    face_object: np.ndarray
    corners: np.ndarray
    mesh_corners: np.ndarray
    diagonal: float

    def visible(self, clip: np.ndarray) -> np.ndarray:
        """Which meshes, (meshes,) bool, may be seen through a projection whose `clip` is (4, 4)."""
        x, y, z, w = np.moveaxis(self.mesh_corners @ clip[:, :3].T + clip[:, 3], -1, 0)
        # A box is out of sight where one plane of the view volume has all its corners on the other side.
        planes = (w + x, w - x, w + y, w - y, w - z, z)
        return np.all([(plane >= 0.0).any(axis=1) for plane in planes], axis=0)

    def hiders(self, eye: np.ndarray, points: np.ndarray) -> np.ndarray:
        """The object that hides each of `points` (N, 3) from an eye, (N,); 0 for none."""
        sight = self.caster.cast(np.broadcast_to(eye, points.shape), points - eye)
        hidden = (sight.triangle >= 0) & (sight.distance < 1.0 - 1e-4)
        return np.where(hidden, self.face_object[sight.triangle], 0)

    def behind(self, points: np.ndarray, outward: np.ndarray, own: tuple[int, ...]) -> tuple[np.ndarray, bool]:
        """How far behind a surface, at `points` (N, 3) with normals `outward`, something else stands, (N,).

        `own` are the numbers of its own objects; infinite where one of them comes first, or nothing. Also whether one
        of them comes first almost everywhere, because the surface is closed.
        """
        reach = float(np.linalg.norm(np.ptp(points, axis=0)))
        hits = self.caster.cast(points, -outward, 1e-4 * reach)
        foreign = (hits.triangle >= 0) & ~np.isin(self.face_object[hits.triangle], own)
        closed = ((hits.triangle >= 0) & ~foreign).mean() > CLOSED
        return np.where(foreign & (not closed), hits.distance, np.inf), bool(closed)

    def sees(self, eye: np.ndarray, points: np.ndarray, own: tuple[int, ...]) -> bool:
        """Whether an eye sees `points` (N, 3), but for what the objects `own` hide."""
        origins = np.broadcast_to(eye, points.shape)
        distance, _ = self.cast_past(origins, points - eye, np.zeros(len(points)), own)
        return not (distance < 1.0 - 1e-3).any()

    def bordered(self, points: np.ndarray, border: np.ndarray, outward: np.ndarray, own: tuple[int, ...]) -> bool:
        """Whether something else stands close beside most of the border of a surface, as a frame does.

        The surface has `points` (N, 3), its border the numbers `border` (B,) of them with normals `outward` (B, 3).
        """
        if not len(border):
            return False
        reach = float(np.linalg.norm(np.ptp(points, axis=0)))
        away = points[border] - points.mean(axis=0)
        away -= np.einsum("ni,ni->n", away, outward)[:, None] * outward
        away /= np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-12)
        # A little downward: a frame may be flush.
        hits = self.caster.cast(points[border] + 1e-3 * reach * outward, away - 0.3 * outward)
        foreign = (hits.triangle >= 0) & ~np.isin(self.face_object[hits.triangle], own)
        return bool((foreign & (hits.distance < BESIDE * reach)).mean() > MOSTLY)

    def covered(self, points: np.ndarray, outward: np.ndarray) -> np.ndarray:
        """How high what lies on a surface, at `points` (N, 3) with normals `outward`, rises near each, (N,).

        That is what begins close above a point, as a rim over a mirror's border does; 0 for none. It is looked for
        straight up and aslant, away from the middle.
        """
        reach = float(np.linalg.norm(np.ptp(points, axis=0)))
        away = points - points.mean(axis=0)
        aslant = outward + away / np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-12)
        highest = np.zeros(len(points))
        for ways in (outward, aslant):
            hits = self.caster.cast(points, ways, 1e-5 * reach)
            lying = (hits.triangle >= 0) & (hits.distance < LYING * reach)
            first, height = self.face_object[hits.triangle], np.zeros(len(points))
            for _ in range(MOST_LAYERS):
                height = np.where(lying, hits.distance, height)
                hits = self.caster.cast(points, ways, height + self.caster.near)
                lying &= (hits.distance < reach) & (self.face_object[hits.triangle] == first)
            highest = np.maximum(highest, height * np.einsum("ni,ni->n", ways, outward))
        return highest

    def cast_past(
        self, origins: np.ndarray, directions: np.ndarray, near: np.ndarray, own: tuple[int, ...]
    ) -> tuple[np.ndarray, np.ndarray]:
        """How far rays go that pass through the objects `own`, (N,), and whether they met them."""
        start, met = near, np.zeros(len(origins), bool)
        for _ in range(MOST_LAYERS):
            hits = self.caster.cast(origins, directions, start)
            passed = (hits.triangle >= 0) & np.isin(self.face_object[hits.triangle], own)
            if not passed.any():
                break
            met |= passed
            start = np.where(passed, hits.distance + self.caster.near, start)
        return np.where(passed, np.inf, hits.distance), met


def world_of(geometry: Geometry, caster: Caster | None = None) -> World:
    """The world of a scene's geometry, with a tree of its own or with the `caster` over it."""
    counts = np.diff(geometry.first_vertex)
    lows, highs = np.zeros((2, len(counts), 3))
    if counts.any():
        starts = geometry.first_vertex[:-1][counts > 0]
        lows[counts > 0] = np.minimum.reduceat(geometry.positions, starts)
        highs[counts > 0] = np.maximum.reduceat(geometry.positions, starts)
    mesh_corners = _corners(lows, highs)
    whole = mesh_corners[counts > 0].reshape(-1, 3)
    corners = _corners(whole.min(axis=0), whole.max(axis=0))
    diagonal = float(np.linalg.norm(np.ptp(corners, axis=0)))
    return World(caster or Caster(geometry), geometry.face_object, corners, mesh_corners, diagonal)


def _corners(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """The corners, (..., 8, 3) float64, of boxes from `low` to `high`, (..., 3)."""
    upper = np.array(list(product((0.0, 1.0), repeat=3)))
    return low[..., None, :] * (1.0 - upper) + high[..., None, :] * upper
