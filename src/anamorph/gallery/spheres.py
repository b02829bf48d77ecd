"""A mirror ball and a flat mirror among diffuse balls on a chequered floor: all that tests know in closed form."""

from __future__ import annotations

import numpy as np

from anamorph.gallery.flat_mirror import plane_mirror
from anamorph.gallery.solids import ball, globe, grid
from anamorph.gallery.textures import checkerboard
from anamorph.scene.camera import Camera
from anamorph.scene.model import AmbientLight, Color, Diffuse, DirectionalLight, Mesh, Mirror, Scene, Sky
from anamorph.surfaces.sphere import Sphere

BALLS: tuple[tuple[tuple[float, float, float], float, Color], ...] = (
    ((-1.25, 0.32, 0.95), 0.32, (0.70, 0.08, 0.06)),
    ((0.35, 0.22, 1.35), 0.22, (0.80, 0.58, 0.06)),
    ((1.25, 0.40, 0.55), 0.40, (0.08, 0.22, 0.62)),
    ((-0.55, 0.18, 1.60), 0.18, (0.10, 0.46, 0.18)),
    ((0.85, 0.26, 2.60), 0.26, (0.50, 0.16, 0.52)),
)


def spheres() -> Scene:
    """The built-in scene `spheres`."""
    board = Diffuse(color=(1, 1, 1), texture=checkerboard(256, 2, (222, 218, 208), (60, 66, 74)))
    balls = [
        ball(3, radius, middle).mesh(f"ball-{number}", Diffuse(color=color))
        for number, (middle, radius, color) in enumerate(BALLS)
    ]
    toward = np.array([0.4, 0.8, 0.5])
    return Scene(
        name="spheres",
        meshes=(
            mirror_ball("mirror-ball", (0.0, 0.62, 0.0), 0.6),
            plane_mirror("mirror-flat", (-2.3, 0.15, -0.4), (1.1, 0.0, -0.9), (0.0, 1.3, 0.0)),
            grid((-5, 0, 6), (10, 0, 0), (0, 0, -10), (10, 10), (0, 0, 10, 10)).mesh("floor", board),
            *balls,
        ),
        camera=Camera(position=(0.35, 1.25, 4.2), target=(-0.2, 0.55, 0.0), field_of_view=40.0),
        lights=(
            DirectionalLight(toward=tuple(toward / np.linalg.norm(toward)), color=(0.85, 0.82, 0.75)),
            AmbientLight(sky=(0.48, 0.52, 0.58), ground=(0.25, 0.24, 0.22)),
        ),
        sky=Sky(),
    )


def mirror_ball(
    name: str, center: tuple[float, float, float], radius: float, rows: int = 48, columns: int = 96
) -> Mesh:
    """A whole mirror sphere, tessellated by longitude and latitude."""
    sphere = Sphere(center=np.asarray(center, float), radius=radius)
    parameters, faces = globe(rows, columns)
    return Mesh.exact(name, sphere, parameters, faces, Mirror(reflectance=0.92), decimals=9)
