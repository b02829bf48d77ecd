"""Families of random scenes with mirrors: each makes a scene of the dice that it is given."""

from __future__ import annotations

import math

import numpy as np

from oracle import parts
from oracle.scene import Camera, Scene
from oracle.surroundings import Place, around, boxes, place, rotation, unit

Random = np.random.Generator


def balls(random: Random) -> Scene:
    """A whole mirror ball."""
    radius = random.uniform(0.1, 0.8)
    where = place(random, radius, radius * random.uniform(2.2, 6.0))
    return around(random, "ball", where, parts.whole_ball("mirror", where.middle, radius, 64, 128))


def convex_caps(random: Random) -> Scene:
    radius = random.uniform(0.3, 2.5)
    reach = radius * random.uniform(0.2, 0.6)
    where = place(random, reach, reach * random.uniform(2.5, 8.0))
    rings = int(random.integers(6, 16))
    return around(
        random, "convex cap", where, parts.cap("mirror", where.middle, where.facing, 1.0 / radius, reach, rings)
    )


def concave_caps(random: Random) -> Scene:
    """The eye is anywhere from near the mirror to well beyond its centre."""
    radius = random.uniform(0.8, 2.5)
    reach = radius * random.uniform(0.2, 0.5)
    where = place(random, reach, radius * random.choice([0.3, 0.45, 0.8, 1.25, 1.6, 3.0]), tilt=0.3)
    mirror = parts.cap("mirror", where.middle, where.facing, -1.0 / radius, reach, int(random.integers(8, 16)))
    return around(random, "concave cap", where, mirror)


def inside_balls(random: Random) -> Scene:
    """The eye inside a concave ball, with boxes that hang in it."""
    radius = random.uniform(1.0, 2.0)
    mirror = parts.whole_ball("mirror", np.zeros(3), radius, 48, 96, side=-1.0)
    eye = 0.4 * radius * random.uniform(-1.0, 1.0, 3)
    hanging = []
    while len(hanging) < 24:
        center, half = unit(random.normal(size=3)) * radius * random.uniform(0.1, 0.8), random.uniform(0.03, 0.25, 3)
        if (
            np.linalg.norm(center - eye) > 0.2 + np.linalg.norm(half)
            and np.linalg.norm(center) + np.linalg.norm(half) < 0.95 * radius
        ):
            hanging.append(parts.box(f"box-{len(hanging)}", center, half, rotation(random)))
    target = eye + unit(random.normal(size=3) * [1.0, 0.4, 1.0])
    return Scene("inside ball", (mirror, *hanging), Camera(tuple(eye.tolist()), tuple(target.tolist()), 80.0))


def toroids(random: Random) -> Scene:
    reach = random.uniform(0.25, 0.5)
    where = place(random, reach, reach * random.uniform(2.5, 6.0))
    curvatures = random.uniform(-0.7, 0.7, 2) / reach * [1.0, 0.9]
    if random.random() < 0.2:
        curvatures[random.integers(2)] = 0.0
    squared = bool(random.random() < 0.5)
    if squared:
        curvatures *= 0.6
    numbers = tuple(curvatures.tolist())
    roll = random.uniform(0.0, math.pi)
    mirror = parts.sag_mirror("mirror", "toroid", numbers, where.middle, where.facing, reach, 14, roll, squared)
    return around(random, "toroid", where, mirror)


def aspheres(random: Random) -> Scene:
    reach = random.uniform(0.3, 0.5)
    where = place(random, reach, reach * random.uniform(2.5, 6.0))
    numbers = random.uniform(-0.45, 0.45) / reach, random.uniform(-1.5, 0.6)
    count = int(random.integers(0, 3))
    powers = random.uniform(-0.08, 0.08, count) / reach ** np.array([3.0, 5.0])[:count]
    mirror = parts.sag_mirror("mirror", "asphere", (*numbers, *powers.tolist()), where.middle, where.facing, reach, 16)
    return around(random, "asphere", where, mirror)


def wavy_meshes(random: Random) -> Scene:
    """A mesh with interpolated normals, without a surface."""
    where = place(random, 0.45, 0.5 * random.uniform(2.5, 6.0))
    mirror = parts.wavy("mirror", random, where.middle, where.facing, 0.4, int(random.integers(16, 40)))
    return around(random, "wavy mesh", where, mirror)


def cylinders(random: Random) -> Scene:
    return _tube(random, "cylinder", 1.0)


def cones(random: Random) -> Scene:
    return _tube(random, "cone", random.uniform(0.1, 0.7))


def _tube(random: Random, name: str, narrowing: float) -> Scene:
    """An upright mirror tube of many or few facets, with normals to interpolate."""
    radius, length = random.uniform(0.1, 0.4), random.uniform(0.4, 1.0)
    where = place(random, 0.6 * length, 0.6 * length * random.uniform(2.5, 6.0))
    facets = int(random.choice([16, 24, 48, 96]))
    foot, radii = where.middle - [0.0, 0.5 * length, 0.0], (radius, narrowing * radius)
    mirror = parts.tube("mirror", foot, (0.0, 1.0, 0.0), radii, length, facets, 8)
    return around(random, name, where, mirror)


def two_balls(random: Random) -> Scene:
    """Two mirror balls side by side, each seen in the other."""
    radii = random.uniform(0.25, 0.5, 2)
    where = place(random, 0.7, 2.6)
    aside = unit(np.cross(where.gaze, (0.0, 1.0, 0.0)))
    gap = random.uniform(0.02, 0.2)
    mirrors = [
        parts.whole_ball(f"mirror-{number}", where.middle + sign * (radius + gap) * aside, radius, 64, 128)
        for number, (sign, radius) in enumerate(zip((-1.0, 1.0), radii, strict=True))
    ]
    return around(random, "two balls", where, *mirrors, near=1.6)


def facing_pairs(random: Random) -> Scene:
    """A curved mirror and a flat one that see each other."""
    where = place(random, 0.7, 2.2)
    aside = unit(np.cross(where.gaze, (0.0, 1.0, 0.0)))
    curvature = random.choice([-1.0, 1.0]) / random.uniform(0.8, 1.6)
    curved = parts.cap("curved", where.middle + 0.5 * aside, -0.6 * where.gaze - 0.8 * aside, curvature, 0.35)
    right, up, _ = parts.axes_toward(-0.6 * where.gaze + 0.8 * aside)
    flat = parts.wall("flat", where.middle - 0.6 * aside, 0.4 * right, 0.4 * up, "mirror")
    return around(random, "facing pair", where, curved, flat, near=2.2)


def wall_mirrors(random: Random) -> Scene:
    """A flat mirror of two triangles, from 5 cm to 100 m away."""
    distance = 0.05 * 2000.0 ** random.random()
    width, height = distance * random.uniform(0.4, 4.0, 2)
    where = place(random, 0.6 * max(width, height), distance, tilt=0.8)
    right, up, _ = parts.axes_toward(where.facing)
    mirror = parts.wall("mirror", where.middle, 0.5 * width * right, 0.5 * height * up, "mirror")
    # Boxes before the mirror and behind it, and around the eye.
    middle = where.middle + 0.5 * distance * where.facing
    span = max(2.0 * distance, 1.0)
    free = Place(where.middle, where.facing, where.eye, 0.3 * min(width, height))
    around_all = boxes(random, free, 40, 0.4 * distance, span, (0.03 * span, 0.2 * span))
    ground = parts.floor(middle[1] - span, 4.0 * span)
    return Scene("wall mirror", (mirror, ground, *around_all), where.camera(float(random.uniform(40.0, 80.0))))
