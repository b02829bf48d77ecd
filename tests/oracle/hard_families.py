"""Families of scenes that are hard on rounding, on coarse meshes and on what stands near a mirror."""

from __future__ import annotations

import math

import numpy as np

from oracle import lens_families, mirror_families, parts
from oracle.scene import Camera, Part, Scene
from oracle.surroundings import Place, around, place, unit

Random = np.random.Generator


def near_mirrors(random: Random) -> Scene:
    """The eye centimetres before a concave mirror."""
    radius = random.uniform(0.4, 1.2)
    mirror = parts.cap("mirror", np.zeros(3), (0.0, 0.0, 1.0), -1.0 / radius, 0.3 * radius, 14)
    eye = np.array([*random.uniform(-0.03, 0.03, 2), random.uniform(0.03, 0.08)])
    where = Place(np.zeros(3), np.array([0.0, 0.0, 1.0]), eye, 0.3 * radius)
    camera = Camera(tuple(eye.tolist()), (*random.uniform(-0.03, 0.03, 2).tolist(), 0.0), 80.0)
    return around(random, "near mirror", where, mirror, camera=camera)


def near_things(random: Random) -> Scene:
    """Boxes millimetres and centimetres before a mirror."""
    return _blocks(random, "near things", lambda: 10.0 ** random.uniform(-3.0, -1.0))


def touching_things(random: Random) -> Scene:
    """Blocks that stand on a mirror, half a millimetre in it."""
    return _blocks(random, "touching things", lambda: -0.0005)


def _blocks(random: Random, name: str, gap_of) -> Scene:
    """A mirror ball or cap with small blocks along its normals, seen over its whole front."""
    radius = random.uniform(0.4, 0.8)
    where = place(random, radius, radius * random.uniform(3.0, 5.0))
    mirror = parts.whole_ball("mirror", where.middle, radius, 64, 128)
    blocks: list[Part] = []
    while len(blocks) < 8:
        outward = unit(-where.gaze + 0.7 * random.normal(size=3))
        half = random.uniform(0.01, 0.05, 3)
        center = where.middle + (radius + gap_of() + half[2]) * outward
        blocks.append(parts.box(f"block-{len(blocks)}", center, half, parts.axes_toward(outward)))
    return around(random, name, where, mirror, *blocks)


def coarse_balls(random: Random) -> Scene:
    """An exact ball over a mesh of few triangles: its outline is the ball's."""
    radius = random.uniform(0.3, 0.6)
    where = place(random, radius, radius * random.uniform(2.5, 5.0))
    rows = int(random.integers(6, 13))
    return around(random, "coarse ball", where, parts.whole_ball("mirror", where.middle, radius, rows, 2 * rows))


def coarse_caps(random: Random) -> Scene:
    """An exact cap over a mesh of few triangles."""
    radius = random.uniform(0.5, 1.5)
    reach = 0.6 * radius
    where = place(random, reach, reach * random.uniform(2.5, 5.0))
    curvature = random.choice([-1.0, 1.0]) / radius
    mirror = parts.cap("mirror", where.middle, where.facing, curvature, reach, int(random.integers(2, 5)))
    return around(random, "coarse cap", where, mirror)


def meshed_balls(random: Random) -> Scene:
    """A ball that is a mesh with interpolated normals and nothing else."""
    radius = random.uniform(0.3, 0.6)
    where = place(random, radius, radius * random.uniform(2.5, 5.0))
    rows = int(random.integers(8, 40))
    ball = parts.whole_ball("mirror", where.middle, radius, rows, 2 * rows)
    return around(random, "meshed ball", where, ball).meshed()


def knife_lenses(random: Random) -> Scene:
    """A lens whose faces share their border: there is no edge."""
    reach, curvature = 0.1, random.uniform(2.0, 4.0)
    where = place(random, reach, random.uniform(0.3, 0.5), tilt=0.1)
    thickness = 2.0 / curvature * (1.0 - math.sqrt(1.0 - (curvature * reach) ** 2))
    made = parts.lens(
        "lens", where.middle, -where.facing, 2 * (curvature,), 2 * (curvature,), thickness, reach, 1.5, edge=False
    )
    return around(random, "knife lens", where, *made)


def small_families(random: Random) -> Scene:
    """A scene of another family a million times as small: micrometres."""
    return _other(random).moved(1e-6)


def large_families(random: Random) -> Scene:
    """A scene of another family some thousand times as large: kilometres."""
    return _other(random).moved(float(random.uniform(500.0, 3000.0)))


def far_families(random: Random) -> Scene:
    """A mirror of another family kilometres from the origin.

    Lenses are left out: where float32 rounds to a quarter of a millimetre, their edges do not meet their faces.
    """
    distance = random.uniform(2000.0, 6000.0)
    return _other(random, lenses=False).moved(1.0, tuple((distance * unit(random.normal(size=3))).tolist()))


def large_grounds(random: Random) -> Scene:
    """A worn lens, or blocks on a mirror, above a ground that reaches kilometres."""
    made = lens_families.worn_lenses(random) if random.random() < 0.75 else touching_things(random)
    half = float(random.choice([1000.0, 5000.0, 20000.0]))
    grounds = [parts.floor(part.mesh.positions[0, 1], half) if part.name == "floor" else part for part in made.parts]
    return Scene("large ground", tuple(grounds), made.camera)


def _other(random: Random, lenses: bool = True) -> Scene:
    makers = (
        mirror_families.convex_caps, mirror_families.concave_caps, mirror_families.toroids, mirror_families.aspheres,
        mirror_families.wavy_meshes, lens_families.spherical_lenses,
    )  # fmt: skip
    return makers[random.integers(len(makers) - (not lenses))](random)
