"""Two flat mirrors that face each other in a room, not quite parallel: a tunnel that bends, seen over the lower one.

The case of section 4.4 of Kakimoto, Tatsukawa, Chun and Nishita, "Real-time reflection and refraction on a per-vertex
basis" (2007), in which surfaces must be followed to a limit of depth.
"""

from __future__ import annotations

import numpy as np

from anamorph.base.vectors import Vector
from anamorph.gallery import room
from anamorph.gallery.dice import die, letters
from anamorph.gallery.flat_mirror import plane_mirror
from anamorph.gallery.mounts import bezel, turned_axes
from anamorph.gallery.solids import Solid, box, join, lathe
from anamorph.scene.camera import Camera
from anamorph.scene.model import AmbientLight, Diffuse, DirectionalLight, Mesh, PointLight, Scene

FAR_NORMAL: Vector = (0.052, -0.014, 1.0)
FAR: tuple[Vector, float, float] = ((0.0, 1.12, -1.0), 2.6, 2.0)
NEAR: tuple[Vector, float, float] = ((0.0, 0.82, 0.45), 2.6, 1.44)
"""Middle, width and height of the mirrors, metres."""
EYE: Vector = (-0.30, 1.82, 0.84)
LOOK: Vector = (-0.10, 1.36, -1.0)


def facing_mirrors() -> Scene:
    """The built-in scene `facing-mirrors`."""
    far, near = hung("mirror-far", *FAR, FAR_NORMAL), hung("mirror-near", *NEAR, (0.0, 0.0, -1.0))
    furniture = (*room.shell(), *room.window(), *room.shelf(), *room.images(), room.door())
    return Scene(
        name="facing-mirrors",
        meshes=(*far, *near, *things(), *furniture),
        camera=Camera(position=EYE, target=LOOK, field_of_view=48.0),
        lights=(
            PointLight(position=(-0.3, 1.7, 0.1), color=(0.75, 0.70, 0.62)),
            DirectionalLight(toward=(-0.64, 0.6, 0.48), color=(0.30, 0.29, 0.27)),
            AmbientLight(sky=(0.52, 0.52, 0.54), ground=(0.40, 0.37, 0.34)),
        ),
    )


def hung(name: str, middle: Vector, width: float, height: float, normal: Vector) -> list[Mesh]:
    """A flat mirror in its frame, looked at along `normal`."""
    axes = turned_axes(np.asarray(normal) / np.linalg.norm(normal), 0.0)
    right, up = width * axes[0], height * axes[1]
    mirror = plane_mirror(name, np.asarray(middle) - right / 2 - up / 2, right, up)
    # The near one's back is seen in the far one.
    frame = bezel(mirror, 2, 2, 0.03, 0.03, closed=name == "mirror-near")
    return [mirror, frame.mesh(f"frame/{name}", Diffuse(color=(0.30, 0.16, 0.07)))]


def things() -> list[Mesh]:
    """What stands between the mirrors: a vase on a stool, a tower of dice, and a ball."""
    vase = lathe(VASE, 32, 50.0).moved(0.0, 0.45, 0.0).painted((0.10, 0.28, 0.50))
    legs = [box((x - 0.02, 0.0, z - 0.02), (x + 0.02, 0.42, z + 0.02)) for x in (-0.14, 0.14) for z in (-0.14, 0.14)]
    stool = join([*legs, lathe([(0.0, 0.42), (0.22, 0.42), (0.22, 0.45), (0.0, 0.45)], 32)])
    stool = stool.painted((0.45, 0.27, 0.12))
    latitude = np.radians(np.linspace(-90, 90, 17))
    ball = lathe([(0.16 * np.cos(v), 0.16 * (1 + np.sin(v))) for v in latitude], 32, 60.0).painted((0.75, 0.20, 0.05))
    tower: list[Solid] = []
    height = 0.0
    for edge, turn in ((0.26, 20.0), (0.20, -12.0), (0.15, 35.0)):
        tower.append(die(edge).turned(turn).moved(-0.55, height, -0.45))
        height += edge
    return [
        join([vase, stool]).moved(0.0, 0.0, -0.62).mesh("vase", Diffuse(color=(1.0, 1.0, 1.0))),
        ball.moved(0.50, 0.0, -0.3).mesh("ball", Diffuse(color=(1.0, 1.0, 1.0))),
        join(tower).mesh("dice", Diffuse(color=(1.0, 1.0, 1.0), texture=letters())),
    ]


VASE = (
    *((0.0, 0.0), (0.07, 0.0), (0.075, 0.01), (0.11, 0.10), (0.115, 0.16), (0.09, 0.24), (0.05, 0.30), (0.045, 0.34)),
    *((0.07, 0.39), (0.062, 0.39), (0.036, 0.33), (0.0, 0.30)),
)
"""Radius and height, metres."""
