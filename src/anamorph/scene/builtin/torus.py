"""A mirror torus, one closed mesh on its exact rational surface, standing on a patterned floor among bright things.

Its outside bulges and its inside is a saddle; rays reach it from its own other side, and what it shows goes all the
way around: the closed reflectors of section 4.1 of Kakimoto, Tatsukawa, Chun and Nishita, "Real-time reflection and
refraction on a per-vertex basis" (2007), which have to be subdivided.
"""

from __future__ import annotations

import numpy as np

from anamorph.scene.builtin.dice import die, letters
from anamorph.scene.builtin.mounts import turned_axes
from anamorph.scene.builtin.shapes import Shape, cylinder, grid, icosphere, lathe, lattice
from anamorph.scene.builtin.textures import checkerboard
from anamorph.scene.camera import Camera, Vector
from anamorph.scene.model import AmbientLight, Color, Diffuse, DirectionalLight, Mesh, Mirror, Scene, Sky
from anamorph.scene.nurbs import NurbsSurface

MAJOR, MINOR = 0.55, 0.19
"""Radius of the ring and of its tube, metres."""
VERTICES = (96, 36)
"""Around the ring and around the tube."""
MIDDLE: Vector = (0.0, 0.94, 0.0)
AXIS: Vector = (0.50, 0.38, 0.86)
EYE: Vector = (0.55, 1.55, 3.4)
PILLARS: tuple[tuple[float, float, Color], ...] = (
    (-1.5, -1.1, (0.70, 0.10, 0.07)), (1.5, -1.2, (0.08, 0.22, 0.62)), (-1.9, 1.7, (0.80, 0.55, 0.06)),
    (1.9, 1.5, (0.10, 0.46, 0.20)), (0.2, -2.6, (0.52, 0.16, 0.52)), (0.3, 5.0, (0.75, 0.30, 0.05)),
)  # fmt: skip
BALLS: tuple[tuple[Vector, float, Color], ...] = (
    ((-0.75, 0.20, 0.80), 0.20, (0.80, 0.58, 0.06)),
    ((0.80, 0.16, 0.95), 0.16, (0.70, 0.08, 0.06)),
    ((0.05, 0.84, -0.02), 0.10, (0.10, 0.42, 0.66)),
)
"""Middle, radius and colour; the last ball floats in the ring."""


def torus() -> Scene:
    """The built-in scene `torus`."""
    board = Diffuse(color=(1, 1, 1), texture=checkerboard(256, 4, (226, 222, 208), (54, 92, 104)))
    white = Diffuse(color=(1.0, 1.0, 1.0))
    points, faces = icosphere(3)
    balls = [
        Shape(points * radius + middle, points, np.zeros((len(points), 2)), np.ones_like(points), faces).mesh(
            f"ball-{number}", Diffuse(color=color)
        )
        for number, (middle, radius, color) in enumerate(BALLS)
    ]
    pillar = lathe(PILLAR, 24, 40.0)
    pillars = [
        pillar.moved(x, 0.0, z).painted(color).mesh(f"pillar-{number}", white)
        for number, (x, z, color) in enumerate(PILLARS)
    ]
    toward = np.array([0.4, 0.8, 0.5])
    return Scene(
        name="torus",
        meshes=(
            mirror_torus("mirror", MIDDLE, AXIS),
            grid((-6, 0, 7), (12, 0, 0), (0, 0, -12), (12, 12), (0, 0, 6, 6)).mesh("floor", board),
            cylinder(0.30, FOOT, 40).painted((0.62, 0.58, 0.50)).mesh("foot", white),
            die(0.34).turned(28.0).moved(-0.15, 0.0, 1.25).mesh("die", Diffuse(color=(1, 1, 1), texture=letters())),
            *balls,
            *pillars,
        ),
        camera=Camera(position=EYE, target=(0.0, 0.72, 0.0), field_of_view=38.0),
        lights=(
            DirectionalLight(toward=tuple(toward / np.linalg.norm(toward)), color=(0.85, 0.82, 0.75)),
            AmbientLight(sky=(0.48, 0.52, 0.58), ground=(0.28, 0.27, 0.25)),
        ),
        sky=Sky(),
    )


PILLAR = ((0.0, 0.0), (0.24, 0.0), (0.24, 0.10), (0.16, 0.14), (0.14, 1.5), (0.20, 1.56), (0.20, 1.66), (0.0, 1.66))
FOOT = 0.08


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
    return Mesh(
        name=name,
        positions=np.round(surface.position(parameters), 9).astype(np.float32),
        faces=lattice(VERTICES[1] + 1, VERTICES[0] + 1).astype(np.int32),
        normals=surface.normal(parameters).astype(np.float32),
        material=Mirror(reflectance=0.92),
        surface=surface,
        parameters=parameters,
    )


def _even(count: int) -> np.ndarray:
    """Parameters 0 to 4 of `count` equal angles on a circle of four rational quadratic quarters."""
    quarter, angle = np.divmod(np.arange(count + 1) * 4.0 / count, 1.0)
    half = np.tan(angle * np.pi / 4.0)
    return quarter + half / (half + np.sqrt(0.5) * (1.0 - half))
