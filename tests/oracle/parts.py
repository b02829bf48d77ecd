"""Mirrors, lenses and what stands around them, as parts of scenes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from oracle import meshes
from oracle.scene import DIFFUSE, GLASS, MIRROR, Camera, Mesh, Part, Scene, Shape, Trim
from oracle.tracer import Tracer


def axes_toward(outward: np.ndarray, roll: float = 0.0) -> np.ndarray:
    """Rows right, up and outward; up is as near to +y as can be, then turned by `roll` radians."""
    outward = np.asarray(outward, float) / np.linalg.norm(outward)
    right = np.cross((0.0, 1.0, 0.0), outward)
    if np.linalg.norm(right) < 1e-6:
        right = np.cross((1.0, 0.0, 0.0), outward)
    right /= np.linalg.norm(right)
    up = np.cross(outward, right)
    cosine, sine = math.cos(roll), math.sin(roll)
    return np.stack([cosine * right + sine * up, cosine * up - sine * right, outward])


def whole_ball(
    name: str, center: np.ndarray, radius: float, rows: int = 40, columns: int = 80, side: float = 1.0
) -> Part:
    """A mirror ball; with `side` -1 a hollow one, looked at from within."""
    shape = Shape("sphere", np.array(center, float), np.eye(3), (radius,), side)
    return Part(name, meshes.ball(shape.origin, radius, rows, columns, side), MIRROR, shape=shape)


def round_shape(apex: np.ndarray, axes: np.ndarray, curvature: float) -> Shape:
    """A sphere or plane through `apex` that bulges along the third axis where its curvature is positive."""
    if curvature == 0.0:
        return Shape("plane", np.array(apex, float), axes)
    side = math.copysign(1.0, curvature)
    own = axes if side > 0.0 else axes * np.array([[1.0], [-1.0], [-1.0]])
    return Shape("sphere", apex - axes[2] / curvature, own, (abs(1.0 / curvature),), side)


def face(
    name: str,
    shape: Shape,
    axes: np.ndarray,
    apex: np.ndarray,
    radius: float,
    rings: int = 14,
    squared: bool = False,
    material: str = MIRROR,
    index: float = 1.0,
) -> Part:
    """What of a shape lies within `radius` of the axis (third of `axes`) through `apex`: a disc, or a square of it."""
    axes, apex = np.asarray(axes, float), np.asarray(apex, float)
    unit, faces = meshes.square(2 * rings) if squared else meshes.disc(rings)
    mesh = meshes.over(shape, Trim(apex, axes), radius * unit, faces)
    height = (mesh.positions - apex) @ axes[2]
    room = 0.05 * radius
    corners, phase, around = (4, 0.25 * math.pi, math.sqrt(2.0) * radius) if squared else (0, 0.0, radius)
    trim = Trim(apex, axes, around, height.min() - room, height.max() + room, corners, phase)
    return Part(name, mesh, material, index, shape, trim)


def cap(name: str, apex: np.ndarray, facing: np.ndarray, curvature: float, radius: float, rings: int = 14) -> Part:
    """A spherical mirror; concave where its curvature is negative."""
    axes = axes_toward(facing)
    return face(name, round_shape(apex, axes, curvature), axes, apex, radius, rings)


def sag_mirror(
    name: str,
    kind: str,
    numbers: tuple[float, ...],
    apex: np.ndarray,
    facing: np.ndarray,
    radius: float,
    rings: int = 14,
    roll: float = 0.0,
    squared: bool = False,
) -> Part:
    """A mirror on a toroid or an even asphere."""
    axes = axes_toward(facing, roll)
    return face(name, Shape(kind, np.asarray(apex, float), axes, numbers), axes, apex, radius, rings, squared)


def lens(
    name: str,
    middle: np.ndarray,
    outward: np.ndarray,
    front: tuple[float, float],
    back: tuple[float, float],
    thickness: float,
    radius: float,
    index: float,
    rings: int = 13,
    rolls: tuple[float, float] = (0.0, 0.0),
    edge: bool = True,
) -> list[Part]:
    """A lens of two faces and the diffuse band around them; each face has two curvatures, positive out of the glass."""
    axes = axes_toward(outward)
    turned = axes * np.array([[-1.0], [1.0], [-1.0]])
    faces = []
    for side, own, curvatures, roll in (("front", axes, front, rolls[0]), ("back", turned, back, rolls[1])):
        apex = np.asarray(middle, float) + 0.5 * thickness * own[2]
        if curvatures[0] == curvatures[1]:
            shape = round_shape(apex, own, curvatures[0])
        else:
            shape = Shape("toroid", apex, _rolled(own, roll), curvatures)
        faces.append(face(f"{name}/{side}", shape, own, apex, radius, rings, False, GLASS, index))
    if not edge:
        return faces
    band = _band(*(each.mesh for each in faces), axes, 6 * rings)
    return [*faces, Part(f"{name}/edge", band, finer=round_edge(*faces, axes))]


def round_edge(front: Part, back: Part, axes: np.ndarray, count: int = 2048) -> Mesh:
    """The band around a lens, so fine that it is round: between the circles in which its faces end."""
    angle = 2.0 * math.pi * np.arange(count) / count
    away = np.stack([np.cos(angle), np.sin(angle)], axis=-1) @ axes[:2]
    rims = []
    for part in (front, back):
        trim, toward = part.trim, -part.trim.axes[2]
        # What looks along the axis sees where the face is; a little more of it is there than in the lens.
        wider = replace(part, material=DIFFUSE, trim=replace(trim, radius=1.001 * trim.radius))
        start = trim.origin + trim.radius * away - trim.high * toward
        seen = Tracer(Scene("rim", (wider,), Camera((0, 0, 1), (0, 0, 0), 40.0))).trace(
            start, np.tile(toward, (count, 1))
        )
        assert (seen.object_id == 1).all()
        rims.append(seen.position)
    return _between(*rims, away)


def _rolled(axes: np.ndarray, roll: float) -> np.ndarray:
    cosine, sine = math.cos(roll), math.sin(roll)
    return np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]]) @ axes


def _band(front: Mesh, back: Mesh, axes: np.ndarray, count: int) -> Mesh:
    """The band between the last `count` vertices of two meshes."""
    middle = front.positions[-count:].mean(axis=0)
    rims = []
    for mesh in (front, back):
        rim = mesh.positions[-count:]
        x, y = axes[:2] @ (rim - middle).T
        # From the middle of a step, so that rounding does not part the first from the last.
        rims.append(rim[np.argsort((np.arctan2(y, x) + math.pi / count) % (2.0 * math.pi))])
    away = rims[0] - middle
    away -= np.outer(away @ axes[2], axes[2])
    return _between(*rims, away / np.linalg.norm(away, axis=1, keepdims=True))


def _between(front: np.ndarray, back: np.ndarray, away: np.ndarray) -> Mesh:
    """The triangles between two closed lines, (N, 3) each, with the unit normals `away`."""
    count = len(front)
    one, following = np.arange(count), (np.arange(count) + 1) % count
    faces = [np.stack([one + count, following + count, following], -1), np.stack([one + count, following, one], -1)]
    return Mesh(np.concatenate([front, back]), np.concatenate([away, away]), np.concatenate(faces))


def wavy(name: str, random: np.random.Generator, apex: np.ndarray, facing: np.ndarray, half: float, cells: int) -> Part:
    """A mirror mesh with interpolated normals: a paraboloid of random curvature under four random waves."""
    axes = axes_toward(facing)
    places, faces = meshes.square(cells)
    places = half * places
    curvature = random.uniform(-0.4, 0.4) / half
    height, slopes = -0.5 * curvature * np.sum(places**2, axis=1), -curvature * places
    for _ in range(4):
        wave, phase = random.normal(size=2) * 2.0 / half, random.uniform(0.0, 2.0 * math.pi)
        depth = half * random.uniform(0.004, 0.02)
        height = height + depth * np.sin(places @ wave + phase)
        slopes = slopes + depth * np.cos(places @ wave + phase)[:, None] * wave
    normals = np.column_stack([-slopes, np.ones(len(slopes))])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Part(name, Mesh(apex + np.column_stack([places, height]) @ axes, normals @ axes, faces), MIRROR)


def tube(
    name: str, origin: np.ndarray, outward: np.ndarray, radii: tuple[float, float], length: float, around: int, up: int
) -> Part:
    """A mirror cylinder or cone, as a mesh with interpolated normals."""
    return Part(name, meshes.tube(np.asarray(origin, float), axes_toward(outward), radii, length, around, up), MIRROR)


def box(name: str, center: np.ndarray, half: np.ndarray, axes: np.ndarray | None = None) -> Part:
    return Part(name, meshes.box(np.asarray(center, float), np.eye(3) if axes is None else axes, np.asarray(half)))


def wall(name: str, center: np.ndarray, right: np.ndarray, up: np.ndarray, material: str = DIFFUSE) -> Part:
    """Two triangles that look along right x up; right and up are half sides."""
    return Part(name, meshes.rectangle(center, right, up), material)


def floor(height: float, half: float = 12.0) -> Part:
    return wall("floor", (0.0, height, 0.0), (half, 0.0, 0.0), (0.0, 0.0, -half))
