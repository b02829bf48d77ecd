"""One step of many light paths at once: look at what each ray hit, and end it or bend it. Compiled.

The paths are held as arrays side by side; those that go on are moved to the front, so that the next cast sees them
without gaps.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from anamorph.base.compiled import compiled, inlined
from anamorph.base.vectors import Vector, along, cross, dot, unit
from anamorph.frame import Status
from anamorph.methods.tracing.leaving import LEAST_CLIMB, climb, corner_of, put_back, rounding, side_and_size
from anamorph.surfaces.intersection import NONE, PATCHES, PLANE, meet

DIFFUSE, MIRROR, GLASS = range(3)
WORDS = 16

_DIRECT, _TRACED, _SKY = int(Status.DIRECT), int(Status.TRACED), int(Status.SKY)
_TOTAL, _OUTSIDE = int(Status.TOTAL_REFLECTION), int(Status.OUTSIDE)


class World(NamedTuple):
    """The scene as the compiled loop reads it. Arrays by object have a row 0 for the sky, which is never read."""

    positions: np.ndarray
    """(V, 3) float32"""
    normals: np.ndarray
    """(V, 3) float32"""
    parameters: np.ndarray
    """(V, 2) float64: (u, v) on the exact surface."""
    faces: np.ndarray
    """(F, 3) int32"""
    face_object: np.ndarray
    """(F,) uint32"""
    material: np.ndarray
    """(objects + 1,) int64: DIFFUSE, MIRROR or GLASS."""
    tint: np.ndarray
    """(objects + 1, 3) float64"""
    constant: np.ndarray
    """(objects + 1,) float64: a mirror's reflectance, a glass's refractive index for the light that is followed."""
    disperses: np.ndarray
    """(objects + 1,) bool: whether light of other colours takes other ways through this object."""
    surface: np.ndarray
    """(objects + 1,) int64: the kind of exact surface, from `exact.pack`."""
    numbers: np.ndarray
    """(N,) float64: the numbers of all of them, one after the other."""
    first_number: np.ndarray
    """(objects + 2,) int64: object i owns numbers first_number[i] to first_number[i + 1]."""
    lens: np.ndarray
    """(objects + 1,) int64: the number of the lens, from 1, of which this object is a face or the edge; else 0."""
    max_bounces: int


class VertexRays(NamedTuple):
    """The rays of ray meshes, by vertex of the geometry; none where all light bends at its surface."""

    origins: np.ndarray
    """(V, 3) float64"""
    directions: np.ndarray
    """(V, 3) float64"""
    transmittance: np.ndarray
    """(V,) float64: what share of the light crosses a lens."""
    leaves: np.ndarray
    """(V,) bool: whether the ray leaves its lens by the far face."""
    far: np.ndarray
    """(objects + 1,) int64: of a lens's near face, the far one; else 0."""


NO_RAYS = VertexRays(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros(0, np.bool_), np.zeros(0, np.int64))


class Paths(NamedTuple):
    """Light paths on their way: the ray each is on, what it hit, and what is known of it."""

    origin: np.ndarray
    direction: np.ndarray
    near: np.ndarray
    distance: np.ndarray
    triangle: np.ndarray
    barycentric: np.ndarray
    throughput: np.ndarray
    """(N, 3) float64"""
    pixel: np.ndarray
    """(N,) int64: the row of its record."""
    specular: np.ndarray
    """(N,) int64: the first specular object, or 0."""
    bounces: np.ndarray
    """(N,) int64"""
    total: np.ndarray
    """(N,) bool: whether some reflection was total."""
    dispersed: np.ndarray
    """(N,) bool: whether some glass disperses that was met."""
    left: np.ndarray
    """(N,) int64: the object that the ray leaves, positive on its outside and negative inside; 0 for the eye."""
    source: np.ndarray
    """(N,) int64: the triangle that the ray leaves; -1 for the eye, and once it has been put back into its lens."""
    skin: np.ndarray
    """(N,) float64: how far from there the mesh can still be in the way of its own exact surface; 0 where both are
    flat, or there is none."""

    @classmethod
    def reserved(cls, count: int) -> Paths:
        """Arrays for `count` paths, not filled."""
        vector, number, integer = (count, 3), np.empty, np.int64
        return cls(
            origin=number(vector),
            direction=number(vector),
            near=number(count),
            distance=number(count),
            triangle=number(count, np.int32),
            barycentric=number((count, 2)),
            throughput=number(vector),
            pixel=number(count, integer),
            specular=number(count, integer),
            bounces=number(count, integer),
            total=number(count, np.bool_),
            dispersed=number(count, np.bool_),
            left=number(count, integer),
            source=number(count, integer),
            skin=number(count),
        )


@inlined
def _blend(values: np.ndarray, face: np.ndarray, weights: Vector) -> Vector:
    """Values (V, 3) at the three vertices of `face`, weighted."""
    total = (0.0, 0.0, 0.0)
    for corner in range(3):
        total = along(total, weights[corner], corner_of(values, face[corner]))
    return total


@inlined
def _finish(records: np.ndarray, words: np.ndarray, paths: Paths, i: int, limited: bool) -> None:
    """Write the record of path i, whose last ray has been cast."""
    record = paths.pixel[i]
    for axis in range(3):
        records[record, axis] = paths.origin[i, axis]
        records[record, 4 + axis] = paths.direction[i, axis]
        records[record, 8 + axis] = paths.throughput[i, axis]
    if limited:
        status = _OUTSIDE
    elif paths.total[i]:
        status = _TOTAL
    elif paths.triangle[i] < 0:
        status = _SKY
    else:
        status = _TRACED if paths.bounces[i] else _DIRECT
    words[record, 3] = np.uint32(paths.triangle[i])
    words[record, 7] = np.uint32(paths.specular[i] | (status << 16) | (paths.bounces[i] << 24))
    records[record, 11] = paths.distance[i]
    records[record, 12], records[record, 13] = paths.barycentric[i, 0], paths.barycentric[i, 1]
    words[record, 14], records[record, 15] = np.uint32(paths.dispersed[i]), 0.0


@compiled
def schlick(reflectance: float, cosine: float) -> float:
    return reflectance + (1.0 - reflectance) * (1.0 - min(max(cosine, 0.0), 1.0)) ** 5


@compiled
def through_glass(direction: Vector, normal: Vector, eta: float) -> tuple[Vector, float, bool]:
    """Refracted direction, Fresnel's transmittance, and whether light crosses; if not, the reflected direction."""
    cosine = -dot(normal, direction)
    tangential = along(direction, cosine, normal)
    square = 1.0 - eta * eta * dot(tangential, tangential)
    if square < 0.0:
        return along(direction, 2.0 * cosine, normal), 1.0, False
    transmitted = math.sqrt(square)
    across = (eta * cosine - transmitted) / (eta * cosine + transmitted)
    parallel = (cosine - eta * transmitted) / (cosine + eta * transmitted)
    scaled = (eta * tangential[0], eta * tangential[1], eta * tangential[2])
    return along(scaled, -transmitted, normal), 1.0 - 0.5 * (across * across + parallel * parallel), True


@inlined
def _surface_normal(
    world: World,
    item: int,
    face: np.ndarray,
    weights: Vector,
    origin: Vector,
    direction: Vector,
    distance: float,
    geometric: Vector,
    side: float,
) -> tuple[float, Vector, bool]:
    """Where the ray meets the surface, the normal there against the ray, and whether both are exact.

    Without an exact surface, or where it is missed, the normal is Phong's and the place is on the triangle.
    """
    kind = world.surface[item]
    if kind != NONE:
        u, v = 0.0, 0.0
        for corner in range(3):
            u += weights[corner] * world.parameters[face[corner], 0]
            v += weights[corner] * world.parameters[face[corner], 1]
        numbers = world.numbers[world.first_number[item] : world.first_number[item + 1]]
        met, exact, normal = meet(kind, numbers, origin, direction, distance, u, v, geometric)
        # The faces may be turned against the surface's own normals, as in a concave mirror cut from a sphere.
        turn = 1.0 if dot(normal, geometric) > 0.0 else -1.0
        normal = (turn * normal[0], turn * normal[1], turn * normal[2])
        if met and dot(normal, direction) < 0.0:
            return exact, normal, True
    normal = _blend(world.normals, face, weights)
    if side * dot(normal, geometric) <= 1e-6:
        return distance, geometric, False
    return distance, unit((side * normal[0], side * normal[1], side * normal[2])), False


@inlined
def _bend(
    world: World,
    item: int,
    face: np.ndarray,
    origin: Vector,
    direction: Vector,
    distance: float,
    rays: VertexRays,
    far: int,
) -> tuple[Vector, Vector, float, bool]:
    """The ray after a hit on specular object `item`; where it leaves the lens by the face `far`, if that is not 0.

    Returns
    -------
    origin, direction : three float64 each
    transmittance : float
        Of the light that goes this way.
    crosses : bool
        Whether the ray goes on on the other side.
    """
    a = corner_of(world.positions, face[0])
    edge_1 = along(corner_of(world.positions, face[1]), -1.0, a)
    edge_2 = along(corner_of(world.positions, face[2]), -1.0, a)
    area = cross(edge_1, edge_2)
    square, slope = dot(area, area), dot(area, direction)
    # Where the ray meets the flat triangle, in float64.
    if slope * slope > 1e-18 * square:
        distance = dot(area, along(a, -1.0, origin)) / slope
    inside = along(along(origin, distance, direction), -1.0, a)
    u, v = dot(cross(inside, edge_2), area) / square, dot(cross(edge_1, inside), area) / square
    weights = (1.0 - u - v, u, v)
    mirror, constant = world.material[item] == MIRROR, world.constant[item]

    if len(rays.origins) and (mirror or far):
        bent = unit(_blend(rays.directions, face, weights))
        change = along(bent, -1.0, direction)
        transmittance = schlick(constant, 0.5 * math.sqrt(dot(change, change)))
        if far:
            transmittance = 0.0
            for corner in range(3):
                transmittance += weights[corner] * rays.transmittance[face[corner]]
        return _blend(rays.origins, face, weights), bent, transmittance, far > 0

    side = 1.0 if slope < 0.0 else -1.0
    geometric = unit((side * area[0], side * area[1], side * area[2]))
    distance, normal, exact = _surface_normal(world, item, face, weights, origin, direction, distance, geometric, side)
    crosses = False
    if mirror:
        cosine = -dot(normal, direction)
        bent, transmittance = along(direction, 2.0 * cosine, normal), schlick(constant, cosine)
    else:
        if dot(normal, direction) >= 0.0:
            normal = geometric
        bent, transmittance, crosses = through_glass(direction, normal, 1.0 / constant if side > 0.0 else constant)
    if not exact:
        # An interpolated normal can send the ray through the flat triangle: it stays on its side.
        height = dot(bent, geometric)
        least = -LEAST_CLIMB if crosses else LEAST_CLIMB
        if (height < least) != crosses:
            bent = unit(along(bent, least - height, geometric))
    return along(origin, distance, direction), bent, transmittance, crosses


@inlined
def _far_face(rays: VertexRays, item: int, face: np.ndarray) -> int:
    """The face by which the interpolated ray leaves the lens whose near face is `item`; 0 where there is none.

    Where a corner's ray does not leave there, because it is reflected totally or meets the edge, none is interpolated.
    """
    if not len(rays.origins) or not rays.far[item]:
        return 0
    return rays.far[item] if rays.leaves[face[0]] and rays.leaves[face[1]] and rays.leaves[face[2]] else 0


@inlined
def _keep(paths: Paths, i: int, going: int, origin: Vector, direction: Vector) -> None:
    """Move path i, which goes on along this ray, to the front."""
    for axis in range(3):
        paths.origin[going, axis], paths.direction[going, axis] = origin[axis], direction[axis]
        paths.throughput[going, axis] = paths.throughput[i, axis]
    paths.pixel[going], paths.specular[going], paths.bounces[going] = (
        paths.pixel[i],
        paths.specular[i],
        paths.bounces[i],
    )
    paths.total[going], paths.dispersed[going] = paths.total[i], paths.dispersed[i]
    paths.left[going], paths.skin[going], paths.source[going] = paths.left[i], paths.skin[i], paths.source[i]


@compiled
def advance(world: World, paths: Paths, count: int, rays: VertexRays, records: np.ndarray, words: np.ndarray) -> int:
    """End or bend the first `count` paths, whose rays have been cast.

    With `rays` a mirror sends on the interpolated ray of a ray mesh, and the near face of a lens that which leaves the
    far one; with `NO_RAYS` light bends at every surface.

    Returns
    -------
    int
        How many paths go on; they have been moved to the front, and each is on its next ray.
    """
    going = 0
    for i in range(count):
        triangle = paths.triangle[i]
        item = np.int64(world.face_object[triangle]) if triangle >= 0 else 0
        material, left, skin = world.material[item], paths.left[i], paths.skin[i]
        origin = (paths.origin[i, 0], paths.origin[i, 1], paths.origin[i, 2])
        direction = (paths.direction[i, 0], paths.direction[i, 1], paths.direction[i, 2])
        # A face is curved and its mesh is not, so that a ray within glass can start beyond the seam of a lens's edge.
        lens = world.lens[-left] if left < 0 and paths.source[i] >= 0 else 0
        if lens != 0 and world.lens[item] != lens:
            origin = put_back(world.positions, world.faces[paths.source[i]], origin)
            _keep(paths, i, going, origin, direction)
            paths.source[going], paths.near[going], paths.skin[going] = -1, 0.0, max(skin, rounding(origin, 0.0))
            going += 1
            continue
        if material == DIFFUSE:
            _finish(records, words, paths, i, False)
            continue
        face = world.faces[triangle]
        outside, longest = side_and_size(world.positions, face, direction)
        curved = world.surface[item] != NONE and world.surface[item] != PLANE
        kind = world.surface[item]
        # Patches of one body meet along borders where the one's mesh can stand before the other's surface.
        related = abs(left) == item or (kind == world.surface[abs(left)] and kind in PATCHES)
        # An exact surface and its mesh do not coincide: a ray that leaves the one may first have to pass the other,
        # from the side it cannot be on. A flat triangle cannot be met by what leaves it, nor can what lies behind it.
        passes = left != 0 and related and skin == 0.0 and triangle == paths.source[i]
        if left != 0 and related and (left > 0) != outside and not passes:
            passes = paths.distance[i] < skin
            if skin == 0.0:
                height = paths.distance[i] * climb(world.positions, world.faces[paths.source[i]], left, direction)
                passes = height < rounding(origin, paths.distance[i] + longest)
        if not passes:
            if material == MIRROR and not outside:
                _finish(records, words, paths, i, False)
                continue
            if paths.specular[i] == 0:
                paths.specular[i] = item
            if paths.bounces[i] >= world.max_bounces:
                _finish(records, words, paths, i, True)
                continue

        transmittance, tinted, total, dispersed, far = 1.0, False, paths.total[i], paths.dispersed[i], 0
        if passes:
            near = paths.distance[i] + rounding(origin, paths.distance[i])
        else:
            both = outside and paths.bounces[i] + 2 <= world.max_bounces
            far = _far_face(rays, item, face) if both else 0
            origin, direction, transmittance, crosses = _bend(
                world, item, face, origin, direction, paths.distance[i], rays, far
            )
            tinted = material == MIRROR or crosses
            total, dispersed = total or not tinted, dispersed or world.disperses[item]
            left = far if far else item if outside != crosses else -item
            near, skin, paths.source[i] = rounding(origin, 0.0), longest if curved or far else 0.0, triangle
        _keep(paths, i, going, origin, direction)
        for axis in range(3):
            factor = transmittance * world.tint[item, axis] if tinted else transmittance
            # A lens is crossed at two faces at once.
            paths.throughput[going, axis] *= factor * (world.tint[far, axis] if far else 1.0)
        paths.bounces[going] += 0 if passes else 2 if far else 1
        paths.total[going], paths.dispersed[going] = total, dispersed
        paths.left[going], paths.skin[going], paths.near[going] = left, skin, near
        going += 1
    return going
