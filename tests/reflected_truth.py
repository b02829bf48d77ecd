"""Reflection points by other ways than the package's: in closed form on balls, and from starts all over a chart."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numba
import numpy as np
from curved_surfaces import mesh_on
from door_mirror import spline
from scipy.interpolate import make_interp_spline

from anamorph.gallery.saddle import toric_mirror
from anamorph.gallery.spheres import mirror_ball
from anamorph.gallery.torus import AXIS, MIDDLE, mirror_torus
from anamorph.reflections.stationary import ORDER, PLACE, POSITION, WORDS, settle
from anamorph.scene.camera import Camera
from anamorph.scene.model import Mesh, Scene
from anamorph.surfaces.intersection import pack
from anamorph.surfaces.nurbs import NurbsSurface
from anamorph.surfaces.toroid import Toroid

CENTER, RADIUS = (0.1, 0.2, -0.3), 1.0


@dataclass(frozen=True, eq=False)
class Trial:
    """A mirror, an eye before it, and the box of parameters that the mirror fills."""

    mesh: Mesh
    eye: np.ndarray
    low: np.ndarray
    high: np.ndarray
    cells: int = 192
    closed: bool = False

    @property
    def scene(self) -> Scene:
        return Scene("trial", (self.mesh,), Camera(tuple(self.eye), tuple(self.eye + 1.0)))

    @property
    def size(self) -> float:
        return float(np.ptp(self.mesh.positions, axis=0).max())


def turned(mesh: Mesh) -> Mesh:
    """The mirror's other side."""
    return replace(mesh, faces=mesh.faces[:, ::-1].copy(), normals=-mesh.normals)


def whole_ball(eye: np.ndarray, concave: bool) -> Trial:
    """A mirror ball at `CENTER`, seen from outside or from inside."""
    mesh = mirror_ball("ball", CENTER, RADIUS, 24, 48)
    return Trial(turned(mesh) if concave else mesh, np.asarray(eye, float), np.zeros(2), np.zeros(2), closed=True)


def saddle() -> Trial:
    mesh = toric_mirror(Toroid(np.zeros(3), 0.75, -0.45), (1.3, 1.3), "saddle")
    return Trial(mesh, np.array([0.9, 0.1, 2.5]), np.full(2, -0.65), np.full(2, 0.65))


def toroid() -> Trial:
    mesh = toric_mirror(Toroid(np.zeros(3), -1.1, -0.8), (1.2, 1.2), "toroid")
    return Trial(mesh, np.array([0.1, -0.2, 1.1]), np.full(2, -0.6), np.full(2, 0.6))


def torus() -> Trial:
    mesh = mirror_torus("torus", MIDDLE, AXIS)
    return Trial(mesh, np.array([0.45, 1.62, 3.3]), np.zeros(2), np.full(2, 4.0), closed=True)


def door_mirror() -> Trial:
    poles, *knots = spline()
    surface = NurbsSurface(poles, np.ones(poles.shape[:2]), *knots, 5, 5)
    low, high = surface.domain
    return Trial(mesh_on(surface, low, high, (12, 8)), np.array([0.45, 0.25, 0.7]), low, high)


def ripples(height: float = 0.012, waves: int = 4) -> Trial:
    """A square of 2 m with waves both ways."""
    spans = 6 * 2 * waves
    knots = np.concatenate([[-1.0] * 5, np.linspace(-1.0, 1.0, spans + 1), [1.0] * 5])
    at = np.array([knots[i + 1 : i + 6].mean() for i in range(len(knots) - 6)])
    x, y = np.meshgrid(at, at, indexing="ij")
    z = height * np.sin(2.0 * np.pi * waves / 2.0 * x) * np.sin(2.0 * np.pi * waves / 2.0 * y + 0.4)
    along = make_interp_spline(at, z, 5, t=knots)
    across = make_interp_spline(at, along.c.T, 5, t=knots)
    poles = np.stack([x, y, across.c.T], axis=-1)
    surface = NurbsSurface(poles, np.ones(x.shape), knots, knots, 5, 5)
    low, high = surface.domain
    return Trial(mesh_on(surface, low, high, (24, 24)), np.array([0.3, -0.4, 2.6]), low, high, 512)


def ball_points(
    center: np.ndarray, radius: float, eye: np.ndarray, points: np.ndarray, concave: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Alhazen's problem on a whole ball, seen from outside or inside: for each place which point, and where it is.

    In the plane of eye, point and center, with complex numbers a and b in units of the radius, the place z on the
    circle has (a - z)(b - z) / z^2 real, which is a quartic.
    """
    first = (eye - center) / radius
    axis = first / np.linalg.norm(first)
    offsets = (points - center) / radius
    aside = offsets - np.outer(offsets @ axis, axis)
    high = np.linalg.norm(aside, axis=1)
    up = aside / high[:, None]
    a = np.full(len(points), np.linalg.norm(first), complex)
    b = offsets @ axis + 1j * high
    terms = np.stack([np.conj(a * b), -np.conj(a + b), np.zeros_like(a), a + b, -a * b], axis=-1)
    companion = np.zeros((len(points), 4, 4), complex)
    companion[:, 1:, :3] = np.eye(3)
    companion[:, :, 3] = -terms[:, :0:-1] / terms[:, :1]
    roots = np.linalg.eigvals(companion)
    angle = np.angle(roots)
    a, b = a[:, None], b[:, None]
    # Newton's steps on the angle: rounding moves double roots off the circle.
    for _ in range(3):
        z = np.exp(1j * angle)
        value = np.imag((a - z) * (b - z) / z**2)
        slope = np.imag(1j * z * ((2.0 * z - a - b) / z**2 - 2.0 * (a - z) * (b - z) / z**3))
        angle = angle - value / slope
    z = np.exp(1j * angle)
    side = -1.0 if concave else 1.0
    good = (np.abs(np.abs(roots) - 1.0) < 1e-5) & (np.real((a - z) * (b - z) / z**2) > 0.0)
    good &= (side * np.real((a - z) * np.conj(z)) > 0.0) & (side * np.real((b - z) * np.conj(z)) > 0.0)
    who = np.nonzero(good)[0]
    found = z[good]
    return who, center + radius * (found.real[:, None] * axis + found.imag[:, None] * up[who])


def beside_caustic(eye: np.ndarray, count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Places of a ball that an eye inside it sees, and points close to where the rays from there touch the caustic."""
    random = np.random.default_rng(seed)
    distance = float(np.linalg.norm(eye - CENTER))
    angle, step = random.uniform(0.1, 3.0, count), 1e-5

    def ray(angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        normal = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        way = RADIUS * normal - (distance, 0.0)
        way = way - 2.0 * np.sum(way * normal, axis=1, keepdims=True) * normal
        return RADIUS * normal, way / np.linalg.norm(way, axis=1, keepdims=True)

    def crossed(one: np.ndarray, other: np.ndarray) -> np.ndarray:
        return one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]

    (places, ways), low, high = (ray(angle + shift) for shift in (0.0, -step, step))
    touching = -crossed(high[0] - low[0], ways) / crossed(high[1] - low[1], ways)
    away = 10.0 ** random.uniform(-6.0, -1.0, count) * np.where(random.random(count) < 0.5, 1.0, -1.0)
    points = places + (touching * (1.0 + away))[:, None] * ways
    axis = (eye - CENTER) / distance
    aside = np.cross(axis, random.normal(size=(count, 3)))
    aside /= np.linalg.norm(aside, axis=1, keepdims=True)
    held = (touching > 0.0) & (np.linalg.norm(points, axis=1) < 0.999 * RADIUS)
    found = [CENTER + each[:, :1] * axis + each[:, 1:] * aside for each in (places, points)]
    return found[0][held], found[1][held]


def dense_points(trial: Trial, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What is found from all cells of a fine grid in which both slopes of the path's length may vanish.

    Returns
    -------
    who : (M,) int64
    places : (M, 3) float64
        Metres.
    orders : (M,) int64
    """
    surface = trial.mesh.surface
    sides = [np.linspace(trial.low[k], trial.high[k], trial.cells + 1) for k in range(2)]
    uv = np.stack([each.ravel() for each in np.meshgrid(*sides, indexing="ij")], axis=-1)
    step = 1e-5 * (trial.high - trial.low)
    shape = (trial.cells + 1, trial.cells + 1, 3)
    # The parameters' own steps may leave the domain, where splines go on otherwise.
    inside = np.clip(uv, trial.low + step, trial.high - step)
    along = [
        surface.position(inside + step * np.eye(2)[k]) - surface.position(inside - step * np.eye(2)[k])
        for k in range(2)
    ]
    along = [each / np.linalg.norm(each, axis=1).max() for each in along]
    position, side = surface.position(uv), 1.0 if np.sum(surface.normal(uv[:1]) * trial.mesh.normals[:1]) > 0 else -1.0
    normal = side * surface.normal(uv)
    rows = np.stack([each.reshape(shape) for each in (position, *along, normal)], axis=2)
    found = np.zeros((40 * len(points), 3), np.int64)
    count = _cells(rows, trial.eye, points, found)
    assert count < len(found)
    found = found[:count]
    kind, numbers = pack(surface)
    kept = []
    width = (trial.high - trial.low) / trial.cells
    lengths = np.full(len(found), 2.0 * trial.size / trial.cells)
    for corner in ((0.5, 0.5), (0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)):
        places = surface.places(trial.low + (found[:, 1:] + corner) * width)
        out, ok = np.zeros((len(found), WORDS)), np.zeros(len(found), bool)
        settle(
            kind, numbers, trial.size, tuple(map(float, trial.eye)), points[found[:, 0]], places, lengths, False,
            0, len(found), out, ok,
        )  # fmt: skip
        there = surface.placed(np.where(ok[:, None], out[:, PLACE : PLACE + 3], places))
        within = ((there >= trial.low) & (there <= trial.high)).all(axis=1)
        normal = surface.normals_toward(there, np.broadcast_to(normal_at(trial, there), (len(there), 3)))
        place = out[:, POSITION : POSITION + 3]
        for end in (trial.eye, points[found[:, 0]]):
            ok &= np.sum((end - place) * normal, axis=1) > 0.0
        good = ok & within
        kept.append(np.column_stack([found[good, 0], place[good], out[good, ORDER]]))
    rows = np.concatenate(kept)
    return unique(rows[:, 0].astype(int), rows[:, 1:4], rows[:, 4].astype(int), 1e-6 * trial.size)


def normal_at(trial: Trial, uv: np.ndarray) -> np.ndarray:
    """The mirror's outward normals."""
    surface = trial.mesh.surface
    side = 1.0 if np.sum(surface.normal(trial.mesh.parameters[:1]) * trial.mesh.normals[:1]) > 0.0 else -1.0
    return side * surface.normal(uv)


@numba.njit
def _cells(rows, eye, points, found):
    count = 0
    wide, high = rows.shape[0], rows.shape[1]
    below = np.zeros((2, high, 3))
    for k in range(len(points)):
        x, y, z = points[k]
        for i in range(wide):
            now, last = below[i % 2], below[1 - i % 2]
            for j in range(high):
                row = rows[i, j]
                a, b, c = row[0, 0] - eye[0], row[0, 1] - eye[1], row[0, 2] - eye[2]
                d, e, f = row[0, 0] - x, row[0, 1] - y, row[0, 2] - z
                one, other = 1.0 / np.sqrt(a * a + b * b + c * c), 1.0 / np.sqrt(d * d + e * e + f * f)
                p, q, r = one * a + other * d, one * b + other * e, one * c + other * f
                now[j, 0] = p * row[1, 0] + q * row[1, 1] + r * row[1, 2]
                now[j, 1] = p * row[2, 0] + q * row[2, 1] + r * row[2, 2]
                now[j, 2] = p * row[3, 0] + q * row[3, 1] + r * row[3, 2]
            if i == 0:
                continue
            for j in range(high - 1):
                if min(min(now[j, 2], now[j + 1, 2]), min(last[j, 2], last[j + 1, 2])) >= 0.0:
                    continue
                good = True
                for m in range(2):
                    low = min(min(now[j, m], now[j + 1, m]), min(last[j, m], last[j + 1, m]))
                    top = max(max(now[j, m], now[j + 1, m]), max(last[j, m], last[j + 1, m]))
                    pad = 0.2 * (top - low)
                    good = good and low - pad <= 0.0 and top + pad >= 0.0
                if good and count < len(found):
                    found[count, 0], found[count, 1], found[count, 2] = k, i - 1, j
                    count += 1
    return count


def unique(who: np.ndarray, places: np.ndarray, orders: np.ndarray, close: float):
    """Without those of one point that are nearer to each other than `close`, unless their orders differ."""
    order = np.lexsort([places[:, 0], who])
    who, places, orders = who[order], places[order], orders[order]
    keep = np.ones(len(who), bool)
    for shift in range(1, 400):
        same = who[shift:] == who[:-shift]
        if not same.any():
            break
        near = np.linalg.norm(places[shift:] - places[:-shift], axis=1) <= close
        keep[shift:] &= ~(same & near & (orders[shift:] == orders[:-shift]))
    return who[keep], places[keep], orders[keep]


def unmatched(who: np.ndarray, places: np.ndarray, others: np.ndarray, other_places: np.ndarray, close: float):
    """The numbers of the first that none of the others, of the same point, is within `close` of."""
    first, last = np.searchsorted(others, who), np.searchsorted(others, who, side="right")
    least = np.full(len(who), np.inf)
    for shift in range(int((last - first).max(initial=0))):
        at = np.minimum(first + shift, max(len(others) - 1, 0))
        near = np.linalg.norm(other_places[at] - places, axis=1)
        least = np.where(first + shift < last, np.minimum(least, near), least)
    return np.flatnonzero(least > close)


def points_before(trial: Trial, count: int, seed: int = 1) -> np.ndarray:
    """Random points at the mirror's front, and around a closed one: near and far, (N, 3)."""
    random = np.random.default_rng(seed)
    uv = random.uniform(trial.low, trial.high, (count, 2))
    feet, outward = trial.mesh.surface.position(uv), normal_at(trial, uv)
    ways = random.normal(size=(count, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    ways *= np.where(np.sum(ways * outward, axis=1, keepdims=True) < 0.0, -1.0, 1.0)
    # Not along the surface: the grid does not tell a point that is nearer to it than a cell.
    ways = (ways + 0.4 * outward) / np.linalg.norm(ways + 0.4 * outward, axis=1, keepdims=True)
    return feet + trial.size * np.exp(random.uniform(np.log(0.04), np.log(8.0), (count, 1))) * ways
