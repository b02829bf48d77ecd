"""A flat wall mirror of two triangles: every method must show in it exactly what a mirrored camera would.

Behind it the wall has a niche, so that it can be turned and bent where it hangs.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from anamorph.gallery.solids import Rectangle, Solid, box, grid, lattice, loft
from anamorph.gallery.textures import checkerboard, mottled, texture
from anamorph.scene.camera import Camera
from anamorph.scene.model import AmbientLight, Color, Diffuse, DirectionalLight, Mesh, Mirror, Scene, Sky
from anamorph.surfaces.plane import Plane

BOXES: tuple[tuple[tuple[float, float, float], tuple[float, float, float], float, Color], ...] = (
    ((-0.75, 0.0, 1.5), (0.30, 0.55, 0.30), 20.0, (0.70, 0.10, 0.08)),
    ((-0.15, 0.0, 1.0), (0.24, 0.35, 0.24), -15.0, (0.10, 0.45, 0.16)),
    ((0.40, 0.0, 1.7), (0.34, 0.80, 0.34), 35.0, (0.10, 0.20, 0.62)),
    ((0.85, 0.0, 0.9), (0.22, 0.45, 0.22), 5.0, (0.80, 0.60, 0.08)),
    ((-1.30, 0.0, 0.9), (0.26, 0.95, 0.26), 0.0, (0.45, 0.16, 0.50)),
)


WALL: Rectangle = (-3.0, 0.0, 3.0, 2.4)
FRAME: Rectangle = (-0.95, 0.20, 0.95, 1.60)
OPENING: Rectangle = (-0.88, 0.27, 0.88, 1.53)
"""Of frame and wall, a little smaller than the mirror before it."""
BACK: Rectangle = (0.0, 0.9, 0.0, 0.9)
"""Where the niche's back is closed. All four: left, bottom, right and top, metres."""
FRONT, NICHE = 0.022, 0.75
"""How far the frame stands before the wall, and how deep the niche is, metres."""


def flat_mirror() -> Scene:
    """The built-in scene `flat-mirror`."""
    board = Diffuse(color=(1, 1, 1), texture=checkerboard(256, 4, (206, 202, 192), (96, 110, 118)))
    plaster = Diffuse(color=(1, 1, 1), texture=texture(mottled((256, 256), (196, 186, 170), 31, (4, 16), 3.0)))
    floor = grid((-3, 0, 4), (6, 0, 0), (0, 0, -4), (6, 4), (0, 0, 3, 2)).mesh("floor", board)
    frame = loft(rings((FRAME, 0.0), (FRAME, FRONT), (OPENING, FRONT), (OPENING, 0.0)))
    bare = loft(rings((WALL, 0.0), (OPENING, 0.0), (OPENING, -NICHE), (BACK, -NICHE)))
    # Along z too, so that the niche's sides show no streaks.
    x, y, z = bare.positions.T
    wall = replace(bare, texcoords=np.column_stack([3.0 + x + z, 2.4 - y + z]) / 2.0).mesh("wall", plaster)
    blocks = [
        block(size, color).turned(turn).moved(*place).mesh(f"block-{number}", Diffuse(color=(1, 1, 1)))
        for number, (place, size, turn, color) in enumerate(BOXES)
    ]
    toward = np.array([0.35, 0.8, 0.5])
    return Scene(
        name="flat-mirror",
        meshes=(
            plane_mirror("mirror", (-0.9, 0.25, 0.03), (1.8, 0, 0), (0, 1.3, 0)),
            frame.mesh("frame", Diffuse(color=(0.18, 0.10, 0.055))),
            floor,
            wall,
            *blocks,
        ),
        camera=Camera(position=(1.5, 1.45, 2.6), target=(-0.05, 0.72, 0.2), field_of_view=44.0),
        lights=(
            DirectionalLight(toward=tuple(toward / np.linalg.norm(toward)), color=(0.85, 0.82, 0.75)),
            AmbientLight(sky=(0.48, 0.5, 0.55), ground=(0.26, 0.24, 0.21)),
        ),
        sky=Sky(),
    )


def rings(*stations: tuple[Rectangle, float]) -> np.ndarray:
    """Corners, (R, 4, 3), of rectangles at their heights z, counter-clockwise seen from +z."""
    return np.array(
        [
            [(x, y, z) for x, y in ((left, bottom), (right, bottom), (right, top), (left, top))]
            for (left, bottom, right, top), z in stations
        ]
    )


def block(size: tuple[float, float, float], color: Color) -> Solid:
    """A coloured box that stands on the origin; its six sides differ a little, so that a reversed image shows."""
    x, y, z = size
    shape = box((-x / 2, 0.0, -z / 2), (x / 2, y, z / 2)).painted(color)
    return shape.shaded(np.repeat([1.0, 0.8, 1.1, 0.5, 0.95, 0.7], 4))


def plane_mirror(
    name: str, origin: tuple[float, float, float], right: tuple[float, float, float], up: tuple[float, float, float]
) -> Mesh:
    """A flat mirror of two triangles, to be looked at from the side of right x up."""
    plane = Plane(origin=np.asarray(origin, float), edge_u=np.asarray(right, float), edge_v=np.asarray(up, float))
    parameters = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    return Mesh.exact(name, plane, parameters, lattice(2, 2), Mirror(reflectance=0.92))
