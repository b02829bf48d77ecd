"""The surroundings of a scene's bodies: what the rays of a warp may hit, and what its maps may see."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np

from anamorph.methods.pervertex.mounting import Mounting, mounting_of, size_of
from anamorph.optics.ray_meshes import Body, Side
from anamorph.rays.caster import Caster, beyond
from anamorph.scene.geometry import Geometry

MOST_LAYERS = 4
"""How many of a body's own surfaces a ray is followed through."""


@dataclass(frozen=True, eq=False)
class Surroundings:
    """A scene around its bodies.

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
    mountings : dict of Side to Mounting
        How each side of a body is mounted in the scene, as it was at first.
    """

    caster: Caster
    face_object: np.ndarray
    corners: np.ndarray
    mesh_corners: np.ndarray
    diagonal: float
    mountings: dict[Side, Mounting] = field(default_factory=dict)

    def moved(self, geometry: Geometry) -> Surroundings:
        """The same after vertices have moved to where `geometry` has them; the caster follows by itself."""
        return replace(_around(geometry, self.caster), mountings=self.mountings)

    def visible(self, clip: np.ndarray) -> np.ndarray:
        """Which meshes, (meshes,) bool, may be seen through a projection whose `clip` is (4, 4)."""
        x, y, z, w = np.moveaxis(self.mesh_corners @ clip[:, :3].T + clip[:, 3], -1, 0)
        # A box is out of sight where one plane of the view volume has all its corners on the other side.
        planes = (w + x, w - x, w + y, w - y, w - z, z)
        return np.all([(plane >= 0.0).any(axis=1) for plane in planes], axis=0)

    def occluders(self, eye: np.ndarray, points: np.ndarray) -> np.ndarray:
        """The object that hides each of `points` (N, 3) from an eye, (N,); 0 for none."""
        hits = self.caster.cast(np.broadcast_to(eye, points.shape), points - eye)
        hidden = (hits.triangle >= 0) & (hits.distance < 1.0 - 1e-4)
        return np.where(hidden, self.face_object[hits.triangle], 0)

    def sees(self, eye: np.ndarray, points: np.ndarray, own: tuple[int, ...]) -> bool:
        """Whether an eye sees `points` (N, 3), but for what the objects `own` hide."""
        origins = np.broadcast_to(eye, points.shape)
        distance, _ = self.cast_past(origins, points - eye, np.zeros(len(points)), own)
        return not (distance < 1.0 - 1e-3).any()

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
            start = np.where(passed, beyond(origins, directions, hits.distance), start)
        return np.where(passed, np.inf, hits.distance), met


def surroundings_of(geometry: Geometry, bodies: Sequence[Body] = ()) -> Surroundings:
    """The surroundings of the `bodies` of a scene's geometry, with a tree of their own."""
    around = _around(geometry, Caster(geometry))
    sides = [side for body in bodies for side in body.sides]
    mountings = {side: mounting_of(side, around.caster, around.face_object) for side in sides}
    return replace(around, mountings=mountings)


def _around(geometry: Geometry, caster: Caster) -> Surroundings:
    counts = np.diff(geometry.first_vertex)
    lows, highs = np.zeros((2, len(counts), 3))
    if counts.any():
        starts = geometry.first_vertex[:-1][counts > 0]
        lows[counts > 0] = np.minimum.reduceat(geometry.positions, starts)
        highs[counts > 0] = np.maximum.reduceat(geometry.positions, starts)
    mesh_corners = _corners(lows, highs)
    whole = mesh_corners[counts > 0].reshape(-1, 3)
    corners = _corners(whole.min(axis=0), whole.max(axis=0))
    return Surroundings(caster, geometry.face_object, corners, mesh_corners, size_of(corners))


def _corners(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """The corners, (..., 8, 3) float64, of boxes from `low` to `high`, (..., 3)."""
    upper = np.array(list(product((0.0, 1.0), repeat=3)))
    return low[..., None, :] * (1.0 - upper) + high[..., None, :] * upper
