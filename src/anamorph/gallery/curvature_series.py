"""Nine equal spherical mirrors on a board in a room, from strongly convex over flat to strongly concave.

After section 4.2 and Figure 9 of Kakimoto, Tatsukawa, Chun and Nishita, "Real-time reflection and refraction on a
per-vertex basis" (2007). Before each mirror the same two things stand on a shelf: nearer to the concave ones than their
reflected rays converge, so that they show upright and large, while the room behind the eye shows reversed.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from PIL import Image, ImageDraw

from anamorph.base.errors import AnamorphError
from anamorph.base.vectors import Vector
from anamorph.gallery import room
from anamorph.gallery.dice import die, letters
from anamorph.gallery.mounts import bezel
from anamorph.gallery.solids import box, grid, join, lathe, lattice
from anamorph.gallery.textures import centered, planks, texture
from anamorph.scene.camera import Camera
from anamorph.scene.model import (
    AmbientLight,
    Color,
    Diffuse,
    DirectionalLight,
    Mesh,
    Mirror,
    PointLight,
    Scene,
    Texture,
)
from anamorph.surfaces.plane import Plane
from anamorph.surfaces.sphere import Sphere

RADII = (0.5, 1.0, 2.0, 6.0, np.inf, -6.0, -2.0, -1.0, -0.5)
"""Metres, positive convex, in reading order."""
SIZE = 0.32
VERTICES = 9
FLATTEST = 1e-7
"""Curvature, 1/m, below which a mirror is taken for flat: its sag and the rounding of so large a sphere are then both
some nanometres."""

MIDDLE: Vector = (0.2, 1.43, 1.83)
PITCH = (0.50, 0.44)
BOARD = 1.93
AXES = np.array([[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]])
EYE: Vector = (0.26, 1.46, -0.80)
PAWN: Color = (0.62, 0.04, 0.03)
BRASS: Color = (0.55, 0.40, 0.14)


def curvature_series() -> Scene:
    """The built-in scene `curvature-series`."""
    stands = []
    for number, radius in enumerate(RADII):
        row, column = divmod(number, 3)
        x, y, z = MIDDLE
        # Right is -x for who looks at the board.
        apex = (x - (column - 1) * PITCH[0], y - (row - 1) * PITCH[1], z)
        stands += stand(f"{number + 1}", 1.0 / radius, apex, number)
    return _scene("curvature-series", stands, 31.0)


def one_mirror(curvature: float) -> Scene:
    """The mirror in the middle of `curvature_series` alone, of any curvature in 1/m, seen larger."""
    return _scene(f"curvature {curvature:g}", stand("1", curvature, MIDDLE, None), 11.0)


def _scene(name: str, stands: list[Mesh], field_of_view: float) -> Scene:
    x, y, _ = MIDDLE
    board = box((x - 0.86, y - 0.74, BOARD), (x + 0.86, y + 0.72, BOARD + 0.05), "+x-x+y-y-z", (0, 0, 1.5, 1.2))
    return Scene(
        name=name,
        meshes=(
            *stands,
            board.mesh("board", Diffuse(color=(1.0, 1.0, 1.0), texture=planks(512, 6, (118, 132, 140), 61))),
            *room.furniture(),
        ),
        camera=Camera(position=EYE, target=(x, y - 0.025, BOARD), field_of_view=field_of_view),
        lights=(
            PointLight(position=(-0.3, 1.65, 0.1), color=(0.72, 0.68, 0.62)),
            DirectionalLight(toward=(-0.48, 0.64, -0.6), color=(0.36, 0.35, 0.32)),
            AmbientLight(sky=(0.50, 0.50, 0.52), ground=(0.40, 0.37, 0.34)),
        ),
    )


def curved_mirror(
    curvature: float,
    apex: Vector = (0.0, 0.0, 0.0),
    axes: np.ndarray | None = None,
    size: float = SIZE,
    vertices: int = VERTICES,
    name: str = "mirror",
) -> Mesh:
    """A square piece of a sphere, looked at along its axis; vertices and rays change continuously with the curvature.

    Parameters
    ----------
    curvature : float
        One over the radius, in 1/m: positive convex, 0 flat, negative concave.
    apex : three floats
        The mirror's middle, metres.
    axes : (3, 3) array, optional
        Rows: the unit vectors right, up and outward (to the eye) there, right-handed; by default x, y and z.
    size : float
        Edge of the square as seen along the axis, metres.
    vertices : int
        Along each edge.
    name : str

    Returns
    -------
    Mesh
        Its `surface` is a `Sphere`, of which a concave mirror is the inside, or a `Plane`.
    """
    axes = np.eye(3) if axes is None else np.asarray(axes, float)
    if not abs(curvature) * size < np.sqrt(2.0):
        most = np.sqrt(2.0) / size
        raise AnamorphError(f"curved mirror: curvature is {curvature}; below {most:.3g}/m a sphere has these corners")
    surface = _surface(curvature, np.asarray(apex, float), axes)
    side = np.linspace(-size / 2, size / 2, vertices)
    plane = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    square = np.sum(plane**2, axis=1)
    sag = curvature * square / (1.0 + np.sqrt(1.0 - curvature**2 * square))
    parameters = surface.parameters(np.asarray(apex) + np.column_stack([plane, -sag]) @ axes)
    return Mesh.exact(name, surface, parameters, lattice(vertices, vertices), Mirror(reflectance=0.92), axes[2])


def _surface(curvature: float, apex: np.ndarray, axes: np.ndarray) -> Plane | Sphere:
    if abs(curvature) < FLATTEST:
        return Plane(origin=apex, edge_u=axes[0], edge_v=axes[1])
    # A sphere's own axis leads outward, which for a concave mirror is away from the eye.
    turned = axes if curvature > 0.0 else axes * [[-1.0], [1.0], [-1.0]]
    return Sphere(center=apex - axes[2] / curvature, radius=1.0 / abs(curvature), axes=turned)


def stand(number: str, curvature: float, apex: Vector, label: int | None) -> list[Mesh]:
    """A mirror in its bezel over a shelf with a pawn and a die, and its radius on the shelf's edge."""
    x, y, z = apex
    mirror = curved_mirror(curvature, apex, AXES, name=f"mirror-{number}")
    base = y - SIZE / 2 - 0.035
    front = z - 0.16
    plank = box((x - 0.21, base - 0.034, front), (x + 0.21, base, BOARD))
    pawn = lathe(PROFILE, 20, 45.0).moved(x + 0.07, base, z - 0.11).painted(PAWN)
    post = lathe(COLUMN, 16, 45.0).moved(x - 0.065, base, z - 0.11).painted(BRASS)
    cube = die(0.05).turned(24.0).moved(x - 0.065, base + 0.117, z - 0.11)
    frame = bezel(mirror, VERTICES, VERTICES, 0.012, 0.02)
    parts = [
        mirror,
        frame.mesh(f"stand-{number}/bezel", Diffuse(color=(0.07, 0.06, 0.055))),
        plank.mesh(f"stand-{number}/shelf", Diffuse(color=(0.42, 0.29, 0.17))),
        join([pawn, post]).mesh(f"stand-{number}/pawn", Diffuse(color=(1.0, 1.0, 1.0))),
        cube.mesh(f"stand-{number}/die", Diffuse(color=(1.0, 1.0, 1.0), texture=letters())),
    ]
    if label is None:
        return parts
    row, column = divmod(label, 2)
    image = (column / 2, row / 8, (column + 1) / 2, (row + 1) / 8)
    plate = grid((x + 0.068, base - 0.034, front - 0.002), (-0.136, 0, 0), (0, 0.034, 0), image=image)
    return [*parts, plate.mesh(f"stand-{number}/label", Diffuse(color=(1.0, 1.0, 1.0), texture=labels()))]


PROFILE = (
    *((0.0, 0.0), (0.027, 0.0), (0.028, 0.007), (0.023, 0.013), (0.015, 0.024), (0.0095, 0.06), (0.0085, 0.12)),
    *((0.018, 0.127), (0.011, 0.132), (0.0165, 0.142), (0.0185, 0.152), (0.0165, 0.164), (0.010, 0.172), (0.0, 0.174)),
)
COLUMN = ((0.0, 0.0), (0.022, 0.0), (0.021, 0.008), (0.006, 0.012), (0.005, 0.11), (0.018, 0.116), (0.0, 0.117))
"""Radius and height of a pawn and of what carries the die, metres."""


@cache
def labels() -> Texture:
    """The nine radii, two across and five of eight rows down."""
    image = Image.new("RGB", (512, 512), (236, 230, 214))
    draw = ImageDraw.Draw(image)
    for number, radius in enumerate(RADII):
        row, column = divmod(number, 2)
        words = "flat" if np.isinf(radius) else f"R = {radius:+g} m"
        centered(draw, (column * 256 + 128, row * 64 + 31), words, 40, (40, 34, 30))
    return texture(image)
