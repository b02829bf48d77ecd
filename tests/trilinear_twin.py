"""Ray triangles and scene triangles, many of them degenerate on purpose, and what the rays meet by brute force."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from anamorph.base.steps import drain
from anamorph.methods.trilinear.beams import Beams, making_beams
from anamorph.methods.trilinear.box_tree import make_tree
from anamorph.methods.trilinear.pairs import ALL, Own
from anamorph.methods.trilinear.plan import Plan, Planner
from anamorph.methods.trilinear.ray_records import seen_words
from anamorph.methods.trilinear.sights import Sights
from anamorph.raytriangle.camera_frames import Frames
from anamorph.raytriangle.owners import places_of

SIZE = (200, 160)

RAYS = [
    "any", "pinhole", "parallel", "crossing", "opposed", "two alike", "in a plane", "far away", "short and long",
]  # fmt: skip
IMAGES = ["any", "weighted", "behind the eye", "thin", "small", "large", "beside the image", "flat"]
TRIANGLES = ["any", "huge", "tiny", "thin", "point", "line", "through the origins", "edge-on"]


class RayTriangles(NamedTuple):
    """K ray triangles: the rows of their corners' homogeneous images, origins and directions, (K, 3, 3) each."""

    image: np.ndarray
    origins: np.ndarray
    directions: np.ndarray


class Meeting(NamedTuple):
    """What the rays of Q image points meet of M triangles."""

    own: np.ndarray
    """(Q,) bool: the points that are in the ray triangle's part of the image."""
    t: np.ndarray
    """(Q, M)"""
    weights: np.ndarray
    """(Q, M, 3)"""
    front: np.ndarray
    """(Q, M) bool: whether the triangle is counter-clockwise along the ray."""
    slant: np.ndarray
    """(Q, M): direction . normal, as a share of its greatest; 0 for triangles without an area."""

    def hit(self, near: float = 0.0) -> np.ndarray:
        return self.own[:, None] & (self.weights >= 0.0).all(axis=-1) & (self.t > near)

    def sure(self, near: float = 0.0) -> np.ndarray:
        """Where float64 can tell: not along a triangle's plane, and not where seeing starts."""
        return (np.abs(self.slant) > 1e-9) & (np.abs(self.t - near) > 1e-9)


def ray_triangle(rays: str, image: str, random: np.random.Generator) -> RayTriangles:
    """One, (1, 3, 3)."""
    o = random.normal(size=(3, 3))
    d = random.normal(size=(3, 3)) * 0.4 + [0.0, 0.0, 1.0]
    if rays == "pinhole":
        o[:] = o[0]
    elif rays == "parallel":
        d = d[0] * random.uniform(0.5, 2.0, (3, 1))
    elif rays == "crossing":
        d = (
            random.normal(size=3)
            + np.array([0.0, 0.0, 3.0])
            - o
            + random.choice([0.0, 1e-9, 0.05]) * random.normal(size=(3, 3))
        )
    elif rays == "opposed":
        d[1] = -d[0]
    elif rays == "two alike":
        o[1], d[1] = o[0], d[0]
    elif rays == "in a plane":
        o[:, 1], d[:, 1] = 0.0, 0.0
    elif rays == "far away":
        o += 1000.0 * random.normal(size=3)
    elif rays == "short and long":
        d *= 10.0 ** random.uniform(-4, 4, (3, 1))
    place = random.uniform(0.0, 1.0, (3, 2)) * SIZE
    if image == "thin":
        place[2] = 0.5 * (place[0] + place[1]) + random.normal(size=2) * 10.0 ** random.uniform(-2, 0)
    elif image == "small":
        place = place[0] + random.normal(size=(3, 2))
    elif image == "large":
        place = (place - 100.0) * 30.0
    elif image == "beside the image":
        place += [3.0 * SIZE[0], 0.0]
    elif image == "flat":
        place[2] = 0.3 * place[0] + 0.7 * place[1]
    w = np.ones((3, 1))
    if image == "weighted":
        w = 10.0 ** random.uniform(-2, 2, (3, 1))
    elif image == "behind the eye":
        w = random.uniform(0.2, 2.0, (3, 1)) * random.permutation([1.0, random.choice([-1.0, 1.0]), -1.0])[:, None]
    return RayTriangles(np.concatenate([place * w, w], axis=1)[None], o[None], d[None])


def scene_triangles(
    kind: str, rays: RayTriangles, count: int, random: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Triangles (count, 3, 3) that rays of the first ray triangle meet, and image points (Q, 2) of such rays."""
    o, d = rays.origins[0], rays.directions[0]
    # Rays that the image shows: those of corners behind the eye weigh less.
    weights = random.dirichlet([1.0] * 3, count) * np.where(rays.image[0, :, 2] > 0.0, 1.0, 0.05)
    weights /= weights.sum(axis=1, keepdims=True)
    along = weights @ d
    points = weights @ o + random.exponential(2.0, (count, 1)) * along
    extent = random.choice([0.3, 2.0], (count, 1, 1))
    if kind == "through the origins":
        points, extent = weights @ o, 2.0 + 0.0 * extent
    offsets = extent * random.normal(size=(count, 3, 3))
    if kind == "huge":
        offsets *= 1e4
    elif kind == "tiny":
        offsets *= 1e-3
    elif kind == "thin":
        offsets[:, 2] = 0.4 * offsets[:, 0] + 1e-5 * offsets[:, 2]
    elif kind == "point":
        offsets[:] = 0.0
    elif kind == "line":
        offsets[:, 2] = 2.0 * offsets[:, 0] - offsets[:, 1]
    offsets -= offsets.mean(axis=1, keepdims=True)
    if kind == "edge-on":
        # In a plane that has one of the rays in it.
        offsets[:, 1] = random.normal(size=(count, 1)) * along
        offsets[:, 2] = -offsets[:, 0] + random.normal(size=(count, 1)) * along
    homogeneous = weights @ rays.image[0]
    places = homogeneous[:, :2] / np.where(homogeneous[:, 2:] > 0.0, homogeneous[:, 2:], np.nan)
    return points[:, None] + offsets, places[((places >= 0.0) & (places <= SIZE)).all(axis=1)]


def image_points(rays: RayTriangles, count: int, random: np.random.Generator) -> np.ndarray:
    """Points (count, 2) of the image, those in the ray triangle's part of it and others."""
    weights = random.dirichlet([0.7] * 3, 20 * count)
    homogeneous = weights @ rays.image[0]
    places = homogeneous[:, :2] / np.where(homogeneous[:, 2:] > 1e-6, homogeneous[:, 2:], np.nan)
    shown = places[((places >= 0.0) & (places <= SIZE)).all(axis=1)]
    return np.concatenate([shown[:count], random.uniform(0.0, 1.0, (count - len(shown[:count]), 2)) * SIZE])


def meet(rays: RayTriangles, triangles: np.ndarray, points: np.ndarray) -> Meeting:
    """What the first ray triangle's rays at points (Q, 2) meet of triangles (M, 3, 3), in extended precision."""
    corners = rays.image[0].astype(np.longdouble)
    cofactors = np.cross(np.roll(corners, -1, axis=0), np.roll(corners, -2, axis=0))
    determinant = np.vecdot(corners[0], cofactors[0])
    homogeneous = np.column_stack([points, np.ones(len(points))]).astype(np.longdouble)
    weights = homogeneous @ cofactors.T * np.sign(determinant)
    own = (weights >= 0.0).all(axis=1)
    own &= weights.sum(axis=1) > 0.0
    weights = weights / np.where(own, weights.sum(axis=1), 1.0)[:, None]
    origin, direction = (weights @ each[0].astype(np.longdouble) for each in (rays.origins, rays.directions))
    a, b, c = np.moveaxis(triangles.astype(np.longdouble), 1, 0)
    normal = np.cross(b - a, c - a)
    across = direction @ normal.T
    edges = np.linalg.norm(b - a, axis=1) * np.linalg.norm(c - a, axis=1)
    flat = np.linalg.norm(normal, axis=1) <= 1e-12 * edges
    pace = np.where(own, np.linalg.norm(direction, axis=1), 1.0)[:, None]
    slant = np.where(flat, 0.0, across / (pace * np.where(flat, 1.0, edges)))
    across = np.where(slant == 0.0, 1.0, across)
    offset = origin[:, None] - a
    turned = np.cross(offset, direction[:, None])
    second, third = -np.vecdot(turned, c - a) / across, np.vecdot(turned, b - a) / across
    t = -np.vecdot(offset, normal) / across
    return Meeting(own, t, np.stack([1.0 - second - third, second, third], axis=-1), across < 0.0, slant)


def beams_of(rays: RayTriangles, near: float = 0.0, size: tuple[int, int] = SIZE) -> tuple[Beams, Frames]:
    """The ray triangles over which the image has samples, as functions of it; image points are in samples."""
    box = places_of(rays.image, size).box
    held = np.flatnonzero((box[:, :2] < box[:, 2:]).all(axis=1))
    beams, frames = drain(making_beams(*(each[held] for each in rays), box[held], near))
    return beams._replace(number=held.astype(np.int32)), frames


def within(beams: Beams, k: int, points: np.ndarray) -> np.ndarray:
    """Which image points (Q, 2) lie in the box of a ray triangle's samples."""
    return (points >= beams.box[k, :2]).all(axis=1) & (points <= beams.box[k, 2:] - 1).all(axis=1)


def whole(own: Own | None, beams: Beams) -> Own:
    """What beams see of the surface that they leave; all, unless it is told for the ray triangles."""
    count = len(beams.number)
    if own is None:
        return Own(np.full(count, -1, np.int32), np.full(count, -1, np.int32), np.full(count, ALL, np.int32))
    return Own(*(each[beams.number] for each in own))


def planned(
    rays: RayTriangles,
    triangles: np.ndarray,
    near: float = 0.0,
    group: np.ndarray | None = None,
    own: Own | None = None,
    planner: Planner | None = None,
    size: tuple[int, int] = SIZE,
) -> tuple[Beams, Plan]:
    """What `trilinear.plan` makes of ray triangles before triangles (M, 3, 3)."""
    beams, frames = beams_of(rays, near, size)
    group = np.zeros(len(triangles), np.int32) if group is None else group
    going = (planner or Planner()).planning(beams, frames, make_tree(triangles), group, whole(own, beams))
    return beams, drain(going)


def looked(
    beams: Beams,
    frames: Frames,
    owner: np.ndarray,
    triangles: np.ndarray,
    fronts: np.ndarray | None = None,
    own: Own | None = None,
) -> Sights:
    """What samples with known owners (height, width) see of triangles; `fronts` (M,) are those with specular fronts."""
    sights = Sights.reserved(owner.shape[::-1])
    sights.owner[:] = owner
    group = np.zeros(len(triangles), np.int32)
    words = seen_words(np.zeros(len(triangles), bool) if fronts is None else fronts)
    drain(Planner().looking(beams, frames, make_tree(triangles), group, whole(own, beams), words, sights))
    return sights


def evaluated(terms: np.ndarray, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A pair's five functions at places (Q, 2) from the center, (Q, 5), and the sums of their terms' magnitudes."""
    x, y = places.T
    one = np.ones_like(x)
    square = np.stack([x * x, x * y, y * y, x, y, one], axis=1)
    linear = np.stack([x, y, one], axis=1)
    parts = [(square, terms[6 * i : 6 * i + 6]) for i in range(3)] + [(linear, terms[18:21]), (linear, terms[21:24])]
    values = [powers @ factors for powers, factors in parts]
    sizes = [np.abs(powers) @ np.abs(factors) for powers, factors in parts]
    return np.stack(values, axis=1), np.stack(sizes, axis=1)


def magnitudes(rays: RayTriangles, triangle: np.ndarray, beams: Beams, places: np.ndarray) -> np.ndarray:
    """What the five functions of the first ray triangle and a scene triangle are the small differences of, (Q, 5)."""
    inverse = np.linalg.inv(rays.image[0])
    inverse[2] += beams.center[0] @ inverse[:2]
    inverse /= np.abs(inverse[2]).sum()
    weight = (np.abs(np.column_stack([places, np.ones(len(places))])) @ np.abs(inverse)).sum(axis=1)
    reach = np.linalg.norm(triangle - beams.anchor[0], axis=1).max()
    start = np.linalg.norm(rays.origins[0] - beams.anchor[0], axis=1).max()
    pace = np.linalg.norm(rays.directions[0], axis=1).max()
    edge = np.linalg.norm(triangle - np.roll(triangle, 1, axis=0), axis=1).max()
    side = weight**2 * pace * reach * (reach + start)
    return np.stack([side, side, side, weight * pace * edge**2, weight * edge**2 * (reach + start)], axis=1)
