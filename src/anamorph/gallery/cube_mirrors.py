"""The numbered cube in the two mirrors of the thesis on trilinear projection.

Source: Vallance, "Trilinear projection" (PhD thesis, 2005), section 7.4: Figures 7.3 and 7.4, a part of a mirror sphere
close before the eye that fills a square image; Figure 7.5, a flat mirror of 5 x 5 quads whose normals are perturbed
at random. Where things stand and by how much normals turn is ours: the thesis does not tell.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.gallery.cube import LIGHTS, cube_and_board
from anamorph.gallery.solids import lattice
from anamorph.scene.camera import Camera
from anamorph.scene.model import Mesh, Mirror, Scene, Sky
from anamorph.surfaces.sphere import Sphere

QUADS = 5
MARGIN = 1.01
"""The mirror is seen a little larger than the square image, so that rounding opens no gap at its border."""

BALL = Sphere(np.array([-1.4, 1.5, -2.0]), 1.0)
BALL_CAMERA = Camera(position=(-0.75, 1.1, -0.9), target=(-1.4, 1.24, -2.0), field_of_view=52.0)

WAVY_CAMERA = Camera(position=(0.9, 1.3, -0.8), target=(0.0, -0.1, -4.0), field_of_view=50.0)
WAVY_PLACE = -2.0
"""The flat mirror's z, metres; it faces +z."""
WAVE = 4.0
"""By how much normals turn, degrees: the standard deviation in either direction."""
SEED = 7


def cube_in_sphere(quads: int = QUADS, exact: bool = True) -> Scene:
    """The built-in scene `cube-in-sphere`; Figures 7.4 (b) to (f) are those of 1 x 1 to 5 x 5 `quads`.

    Those are not `exact`: the thesis knows the sphere by the normals at the vertices alone. No border is made rounder.
    """
    camera = BALL_CAMERA
    directions = _sight(camera, quads)
    offset = np.asarray(camera.position) - BALL.center
    along = directions @ offset
    inside = along**2 - (offset @ offset - BALL.radius**2)
    parameters = BALL.parameters(camera.position + (-along - np.sqrt(inside))[:, None] * directions)
    mirror = Mesh.exact("mirror", BALL, parameters, lattice(quads + 1, quads + 1), Mirror(reflectance=0.92))
    if not exact:
        mirror = replace(mirror, surface=None, parameters=None)
    return Scene("cube-in-sphere", (mirror, *cube_and_board()), camera, LIGHTS, Sky())


def cube_in_wavy_mirror(degrees: float = WAVE, seed: int = SEED) -> Scene:
    """The built-in scene `cube-in-wavy-mirror`: flat, and smooth between normals that are turned by some `degrees`.

    No exact surface has such normals on a plane: the truth is the interpolated normal.
    """
    camera = WAVY_CAMERA
    directions = _sight(camera, QUADS)
    reach = (WAVY_PLACE - camera.position[2]) / directions[:, 2]
    positions = camera.position + reach[:, None] * directions
    generator = np.random.default_rng(seed)
    slopes = np.tan(np.radians(degrees)) * generator.normal(size=(len(positions), 2))
    normals = np.column_stack([slopes, np.ones(len(positions))])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    mirror = Mesh(
        name="mirror",
        positions=positions.astype(np.float32),
        faces=lattice(QUADS + 1, QUADS + 1).astype(np.int32),
        normals=normals.astype(np.float32),
        material=Mirror(reflectance=0.92),
    )
    return Scene("cube-in-wavy-mirror", (mirror, *cube_and_board()), camera, LIGHTS, Sky())


def _sight(camera: Camera, quads: int) -> np.ndarray:
    """Unit directions through a grid over a square image, row by row from the bottom, (N, 3)."""
    if not np.isfinite(quads) or quads != int(quads) or quads < 1:
        raise AnamorphError(f"cube-in-sphere: quads is {quads}; give a whole number, 1 or more")
    steps = 0.5 + MARGIN * np.linspace(-0.5, 0.5, int(quads) + 1)
    pixels = np.stack(np.meshgrid(steps, 1.0 - steps), axis=-1).reshape(-1, 2)
    return camera.directions(pixels, (1, 1))
