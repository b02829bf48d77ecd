"""The scene of the thesis on trilinear projection: a cube with numbers on its sides, over a checkerboard.

Source: Vallance, "Trilinear projection" (PhD thesis, 2005), section 6.1 and Table 8.1: 686 triangles, 588 of them the
cube's, which are six sides of 7 x 7 quads; so 7 x 7 quads remain for the board. It draws them so finely as to have the
work of a larger scene. The numbers, sizes and colours are ours: the thesis does not tell them.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from PIL import Image, ImageDraw

from anamorph.gallery.solids import grid, six_sided
from anamorph.gallery.textures import Rgb, centered, checkerboard, texture
from anamorph.scene.camera import Camera
from anamorph.scene.model import AmbientLight, Diffuse, DirectionalLight, Mesh, Scene, Sky, Texture

QUADS = 7
EDGE = 1.0
"""The cube's, metres; its middle is the origin."""
BOARD = 3.5
BOARD_HEIGHT = -0.75
"""The cube floats: sides that touch the board would fight with it for pixels."""

COLORS: tuple[Rgb, ...] = (
    (226, 112, 92), (112, 176, 96), (236, 188, 84), (98, 148, 212), (240, 234, 218), (176, 124, 192),
)  # fmt: skip

CAMERA = Camera(position=(-1.9, 3.5, 3.3), target=(0.0, -0.15, 0.0), field_of_view=46.0)
"""Figures 6.3, 6.4 and 7.6: the board reaches the image's borders, and the cube is in the middle third."""
LEFT = Camera(position=(-3.6, 0.9, -0.55), target=(-0.5, 0.0, -0.55), field_of_view=28.0)
FRONT = Camera(position=(0.55, 0.9, 3.6), target=(0.55, 0.0, 0.5), field_of_view=28.0)
"""The two views of Figure 6.7. Their inner borders meet on the cube, so that its corner fills what is between."""

_TOWARD = np.array([-0.35, 0.8, 0.6])
LIGHTS = (
    DirectionalLight(toward=tuple(_TOWARD / np.linalg.norm(_TOWARD)), color=(0.5, 0.48, 0.45)),
    AmbientLight(sky=(0.62, 0.62, 0.64), ground=(0.5, 0.5, 0.5)),
)
"""Much of it from all around, so that the numbers below and behind can be read."""


def cube() -> Mesh:
    """588 triangles: a side of 7 x 7 quads for each number from 1 to 6."""
    sides = six_sided((-EDGE / 2,) * 3, (EDGE / 2,) * 3, (QUADS, QUADS))
    return sides.mesh("cube", Diffuse(color=(1, 1, 1), texture=numbers()))


def board() -> Mesh:
    """98 triangles, a quad for each of 7 x 7 fields."""
    corner, extent = (-BOARD / 2, BOARD_HEIGHT, BOARD / 2), BOARD
    repeated = (0.0, 0.0, QUADS / 2, QUADS / 2)
    fields = grid(corner, (extent, 0, 0), (0, 0, -extent), (QUADS, QUADS), repeated)
    return fields.mesh("board", Diffuse(color=(1, 1, 1), texture=checkerboard(64, 2, (58, 70, 82), (222, 220, 212))))


def cube_and_board() -> tuple[Mesh, Mesh]:
    """The 686 triangles."""
    return cube(), board()


def cube_scene() -> Scene:
    """Cube and board alone, for cameras that are ray meshes; its own camera shows the thesis's Figure 6.3."""
    return Scene(name="cube", meshes=cube_and_board(), camera=CAMERA, lights=LIGHTS, sky=Sky())


@cache
def numbers() -> Texture:
    """The sides of the cube: six fields in the left three quarters, three across and two down."""
    field = 256
    image = Image.new("RGB", (4 * field, 2 * field))
    draw = ImageDraw.Draw(image)
    for number, color in enumerate(COLORS):
        row, column = divmod(number, 3)
        left, top = column * field, row * field
        red, green, blue = color
        ink = (red * 3 // 10, green * 3 // 10, blue * 3 // 10)
        draw.rectangle((left, top, left + field - 1, top + field - 1), fill=color)
        draw.rectangle((left + 10, top + 10, left + field - 11, top + field - 11), outline=ink, width=8)
        centered(draw, (left + field / 2, top + field / 2 - 4), str(number + 1), 190, ink)
    return texture(image)
