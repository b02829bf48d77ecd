"""A mirror torus, one closed mesh on its exact rational surface, on a patterned floor in a bright round of pillars.

Its outside bulges and its inside is a saddle; rays reach it from its own other side, and what it shows goes all the
way around: the closed reflectors of section 4.1 of Kakimoto, Tatsukawa, Chun and Nishita, "Real-time reflection and
refraction on a per-vertex basis" (2007), which have to be subdivided.
"""

from __future__ import annotations

import numpy as np

from anamorph.base.vectors import Vector
from anamorph.gallery.dice import die, letters
from anamorph.gallery.mounts import turned_axes
from anamorph.gallery.solids import ball, cylinder, grid, join, lathe, lattice
from anamorph.gallery.textures import checkerboard
from anamorph.scene.camera import Camera
from anamorph.scene.model import AmbientLight, Color, Diffuse, DirectionalLight, Mesh, Mirror, Scene, Sky
from anamorph.surfaces.nurbs import NurbsSurface

MAJOR, MINOR = 0.55, 0.19
"""Radius of the ring and of its tube, metres."""
VERTICES = (96, 36)
"""Around the ring and around the tube."""
MIDDLE: Vector = (0.0, 0.94, 0.0)
AXIS: Vector = (0.55, 0.16, 0.86)
EYE: Vector = (0.45, 1.62, 3.3)
ROUND = 4.1
"""Radius of the circle of pillars, metres; their colours come twice."""
PILLARS: tuple[Color, ...] = (
    (0.70, 0.10, 0.07), (0.86, 0.80, 0.66), (0.08, 0.22, 0.62), (0.80, 0.55, 0.06),
    (0.10, 0.46, 0.20), (0.86, 0.80, 0.66), (0.52, 0.16, 0.52), (0.75, 0.30, 0.05),
)  # fmt: skip
BALLS: tuple[tuple[Vector, float, Color], ...] = (
    ((-1.05, 0.28, 0.45), 0.28, (0.80, 0.58, 0.06)),
    ((1.0, 0.24, 0.25), 0.24, (0.70, 0.08, 0.06)),
    ((0.06, 0.90, -0.05), 0.11, (0.10, 0.42, 0.66)),
    ((-0.2, 0.34, 2.4), 0.34, (0.08, 0.42, 0.22)),
)
"""Middle, radius and colour; the last ball floats in the ring."""


def torus() -> Scene:
    """The built-in scene `torus`."""
    board = Diffuse(color=(1, 1, 1), texture=checkerboard(256, 4, (226, 222, 208), (54, 92, 104)))
    white = Diffuse(color=(1.0, 1.0, 1.0))
    balls = [
        ball(2, radius, middle).mesh(f"ball-{number}", Diffuse(color=color))
        for number, (middle, radius, color) in enumerate(BALLS)
    ]
    pillar, turn = lathe(PILLAR, 20, 40.0).moved(0.0, 0.0, ROUND), 360.0 / (2 * len(PILLARS))
    pillars = [pillar.turned((number + 0.5) * turn).painted(color) for number, color in enumerate(2 * PILLARS)]
    toward = np.array([0.4, 0.8, 0.5])
    return Scene(
        name="torus",
        meshes=(
            mirror_torus("mirror", MIDDLE, AXIS),
            grid((-6, 0, 6), (12, 0, 0), (0, 0, -12), (12, 12), (0, 0, 6, 6)).mesh("floor", board),
            cylinder(0.30, FOOT, 40).painted((0.62, 0.58, 0.50)).mesh("foot", white),
            die(0.34).turned(28.0).moved(-0.45, 0.0, 1.05).mesh("die", Diffuse(color=(1, 1, 1), texture=letters())),
            *balls,
            join(pillars).mesh("pillars", white),
            lathe(BEAM, 64, 40.0).painted((0.80, 0.74, 0.62)).mesh("beam", white),
        ),
        camera=Camera(position=EYE, target=(0.0, 0.80, 0.0), field_of_view=39.0),
        lights=(
            DirectionalLight(toward=tuple(toward / np.linalg.norm(toward)), color=(0.85, 0.82, 0.75)),
            AmbientLight(sky=(0.48, 0.52, 0.58), ground=(0.28, 0.27, 0.25)),
        ),
        sky=Sky(),
    )


PILLAR = ((0.0, 0.0), (0.26, 0.0), (0.26, 0.12), (0.18, 0.16), (0.15, 2.1), (0.23, 2.18), (0.23, 2.3), (0.0, 2.3))
BEAM = ((ROUND - 0.2, 2.3), (ROUND + 0.2, 2.3), (ROUND + 0.2, 2.7), (ROUND - 0.2, 2.7), (ROUND - 0.2, 2.3))
"""Radius and height, metres."""
FOOT = 0.2


def torus_surface(middle: Vector, axes: np.ndarray, major: float, minor: float) -> NurbsSurface:
    """A torus about the third of `axes`: a circle of four quadratic quarters, turned along another such circle.

    Parameters
    ----------
    middle : three floats
        Metres.
    axes : (3, 3) array
        Rows: unit vectors, right-handed and perpendicular.
    major, minor : float
        Radius of the ring and of its tube, metres.
    """
    ring = np.array([[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1], [1, 0]], float)
    weights = np.where(np.arange(9) % 2, np.sqrt(0.5), 1.0)
    out = major + minor * ring[:, 0]
    local = np.stack(
        [
            np.multiply.outer(ring[:, 0], out),
            np.multiply.outer(ring[:, 1], out),
            np.broadcast_to(minor * ring[:, 1], (9, 9)),
        ],
        axis=-1,
    )
    knots = np.array([0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4], float)
    return NurbsSurface(np.asarray(middle) + local @ axes, np.outer(weights, weights), knots, knots, 2, 2)


def mirror_torus(name: str, middle: Vector, axis: Vector) -> Mesh:
    """The closed ring as one mesh, whose seams have vertices twice, so that parameters are continuous in triangles."""
    axes = turned_axes(np.asarray(axis) / np.linalg.norm(axis), 0.0)
    surface = torus_surface(middle, axes, MAJOR, MINOR)
    u, v = np.meshgrid(*(_even(count) for count in VERTICES))
    parameters = np.stack([u.ravel(), v.ravel()], axis=-1)
    faces = lattice(VERTICES[1] + 1, VERTICES[0] + 1)
    return Mesh.exact(name, surface, parameters, faces, Mirror(reflectance=0.92), decimals=9)


def _even(count: int) -> np.ndarray:
    """Parameters 0 to 4 of `count` equal angles on a circle of four rational quadratic quarters."""
    quarter, angle = np.divmod(np.arange(count + 1) * 4.0 / count, 1.0)
    half = np.tan(angle * np.pi / 4.0)
    return quarter + half / (half + np.sqrt(0.5) * (1.0 - half))
