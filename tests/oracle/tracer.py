"""Paths of light through a scene, one ray after the other, in float64.

A ray leaves a primitive by its identity: the triangle is not met again, and of a shape the root at the ray's origin is
left out. So there is no distance below which nothing is seen, however large the scene.
"""

from __future__ import annotations

import math
import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields

import numpy as np

from oracle.scene import DIFFUSE, GLASS, MIRROR, Camera, Scene
from oracle.shapes import WORDS, meet_shape, packed, shape_normal
from oracle.triangles import meet_triangles, triangles_of
from oracle.vectors import along, compiled, cross, dot, scaled, unit

TOTAL, LIMIT, ASTRAY = 1, 2, 4
"""Flags: some reflection was total; the bounce limit ended the path; an interpolated normal sent a ray through its own
triangle, where a mesh says nothing about what is seen."""

GRAIN = 4096
NONE = -1
MATERIALS = {DIFFUSE: 0, MIRROR: 1, GLASS: 2}


@dataclass(frozen=True, eq=False)
class Seen:
    """What N rays see.

    Parameters
    ----------
    position : (N, 3) float64
        The point at the path's end; where `object_id` is 0 (sky), the last ray's direction.
    object_id, specular, last : (N,) int64
        The object at the end, the first specular object and the last one; 0 for none.
    origin, direction : (N, 3) float64
        The last ray.
    bounces, flags : (N,) int64
    """

    position: np.ndarray
    object_id: np.ndarray
    specular: np.ndarray
    last: np.ndarray
    origin: np.ndarray
    direction: np.ndarray
    bounces: np.ndarray
    flags: np.ndarray

    @classmethod
    def empty(cls, count: int) -> Seen:
        vectors = {"position", "origin", "direction"}
        shapes = {each.name: (count, 3) if each.name in vectors else count for each in fields(cls)}
        return cls(**{name: np.zeros(shape, float if name in vectors else np.int64) for name, shape in shapes.items()})

    def __getitem__(self, chosen: np.ndarray) -> Seen:
        return Seen(**{name: values[chosen] for name, values in vars(self).items()})


class Tracer:
    """A scene, ready to trace rays in.

    Parameters
    ----------
    scene : Scene
    max_bounces : int
        Bounces after which a path ends where it is.
    """

    def __init__(self, scene: Scene, max_bounces: int = 8) -> None:
        numbered = list(enumerate(scene.parts, start=1))
        shaped = [(number, part) for number, part in numbered if part.shape is not None]
        self._triangles = triangles_of(
            [(number, part.finer or part.mesh) for number, part in numbered if part.shape is None]
        )
        self._rows = np.array([packed(part.shape, part.trim) for _, part in shaped]).reshape(len(shaped), WORDS)
        self._owner = np.array([number for number, _ in shaped], np.int64)
        self._material = np.array([0, *(MATERIALS[part.material] for part in scene.parts)])
        self._index = np.array([1.0, *(part.index for part in scene.parts)])
        self._bounces = max_bounces

    def trace(self, origins: np.ndarray, directions: np.ndarray) -> Seen:
        """What rays (N, 3) with unit directions (N, 3) see; one origin (3,) may serve them all."""
        directions = np.ascontiguousarray(directions, float)
        origins = np.ascontiguousarray(np.broadcast_to(np.asarray(origins, float), directions.shape))
        seen = Seen.empty(len(directions))

        def work(start: int) -> None:
            part = slice(start, start + GRAIN)
            _trace(
                self._triangles, self._rows, self._owner, self._material, self._index, self._bounces,
                origins[part], directions[part], *(values[part] for values in vars(seen).values()),
            )  # fmt: skip

        with ThreadPoolExecutor(os.cpu_count()) as threads:
            list(threads.map(work, range(0, len(directions), GRAIN)))
        return seen

    def look(self, camera: Camera, points: np.ndarray, size: tuple[int, int]) -> Seen:
        """What is seen at image points (N, 2)."""
        return self.trace(np.array(camera.position, float), camera.directions(points, size))


@compiled
def _mesh_normals(corners, normals, u, v):
    """The flat triangle's unit normal, and the interpolated one on the same side."""
    edge_1 = corners[1, 0], corners[1, 1], corners[1, 2]
    edge_2 = corners[2, 0], corners[2, 1], corners[2, 2]
    flat, blended = unit(cross(edge_1, edge_2)), (0.0, 0.0, 0.0)
    for corner, weight in enumerate((1.0 - u - v, u, v)):
        blended = along(blended, weight, (normals[corner, 0], normals[corner, 1], normals[corner, 2]))
    return flat, scaled(math.copysign(1.0, dot(blended, flat)), unit(blended))


@compiled
def bend(direction, normal, eta):
    """The refracted direction for a normal against the ray, and whether there is one; if not, the reflected one."""
    cosine = -dot(normal, direction)
    square = 1.0 - eta * eta * (1.0 - cosine * cosine)
    if square < 0.0:
        return along(direction, 2.0 * cosine, normal), False
    return unit(along(scaled(eta, direction), eta * cosine - math.sqrt(square), normal)), True


@compiled
def _trace(
    triangles, rows, owner, material, index, max_bounces, origins, directions,
    position, object_id, specular, last, end_origin, end_direction, bounces, flags,
):  # fmt: skip
    for ray in range(len(origins)):
        origin = origins[ray, 0], origins[ray, 1], origins[ray, 2]
        direction = directions[ray, 0], directions[ray, 1], directions[ray, 2]
        left_triangle, left_shape, left_part = NONE, NONE, NONE
        while True:
            best, shape = math.inf, NONE
            for number in range(len(rows)):
                distance = meet_shape(rows[number], origin, direction, best, number == left_shape)
                if distance < best:
                    best, shape = distance, number
            best, triangle, u, v = meet_triangles(triangles, origin, direction, best, left_triangle, left_part)
            for axis in range(3):
                end_origin[ray, axis], end_direction[ray, axis] = origin[axis], direction[axis]
            if best == math.inf:
                object_id[ray] = 0
                for axis in range(3):
                    position[ray, axis] = direction[axis]
                break
            point = along(origin, best, direction)
            for axis in range(3):
                position[ray, axis] = point[axis]
            if triangle != NONE:
                shape, part = NONE, triangles.part[triangle]
                flat, normal = _mesh_normals(triangles.corners[triangle], triangles.normals[triangle], u, v)
            else:
                part = owner[shape]
                normal = shape_normal(rows[shape], point)
                flat = normal
            object_id[ray] = part
            front = dot(flat, direction) < 0.0
            if material[part] == 0 or (material[part] == 1 and not front):
                break
            if specular[ray] == 0:
                specular[ray] = part
            if bounces[ray] >= max_bounces:
                flags[ray] |= LIMIT
                break
            last[ray] = part
            if not front:
                flat, normal = scaled(-1.0, flat), scaled(-1.0, normal)
            if dot(normal, direction) >= 0.0:
                flags[ray] |= ASTRAY
                normal = flat
            if material[part] == 1:
                bent, crosses = along(direction, -2.0 * dot(normal, direction), normal), False
            else:
                bent, crosses = bend(direction, normal, 1.0 / index[part] if front else index[part])
                if not crosses:
                    flags[ray] |= TOTAL
            lift = dot(bent, flat)
            if (lift > 0.0) == crosses:
                flags[ray] |= ASTRAY
                bent = along(bent, -lift, flat)
            origin, direction = point, unit(bent)
            left_triangle, left_shape, left_part = triangle, shape, part
            bounces[ray] += 1
