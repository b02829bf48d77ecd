"""A saddle-shaped and a cylindrical mirror on posts in a street, both turned obliquely about their normals.

After section 4.3 and Figure 10 of Kakimoto, Tatsukawa, Chun and Nishita, "Real-time reflection and refraction on a
per-vertex basis" (2007): such mirrors spread their rays wide one way and little the other, and a view volume wastes
its map unless it is aligned with those ways.
"""

from __future__ import annotations

import numpy as np

from anamorph.base.vectors import Vector
from anamorph.gallery import town
from anamorph.gallery.car_mirror import LIGHTS, SKY
from anamorph.gallery.mounts import bezel, turned_axes
from anamorph.gallery.solids import cylinder, join, lathe, lattice
from anamorph.scene.camera import Camera
from anamorph.scene.model import Color, Diffuse, Mesh, Mirror, Scene
from anamorph.surfaces.toroid import Toroid

SIZE = (1.3, 1.3)
VERTICES = 11
BENDS = (0.75, -0.45)
"""Curvatures, 1/m: the saddle's outward along one way and inward along the other. The cylinder has the first alone."""
TURNS = (30.0, -25.0)
"""Degrees, about the normals of saddle and cylinder."""
SADDLE: Vector = (-1.0, 1.62, -20.0)
CYLINDER: Vector = (0.85, 1.62, -20.0)
EYE: Vector = (-0.08, 1.72, -15.6)
STEEL: Color = (0.10, 0.11, 0.12)


def saddle() -> Scene:
    """The built-in scene `saddle`."""
    bends = ((SADDLE, TURNS[0], BENDS[1], "saddle"), (CYLINDER, TURNS[1], 0.0, "cylinder"))
    meshes: list[Mesh] = []
    for middle, turn, across, name in bends:
        mirror = toric_mirror(
            Toroid(np.asarray(middle), BENDS[0], across, turned_axes(facing(middle), turn)), SIZE, name
        )
        x, y, z = middle
        foot = lathe([(0.0, 0.0), (0.26, 0.0), (0.25, 0.03), (0.05, 0.05), (0.0, 0.05)], 24)
        post = join([foot, cylinder(0.035, y - 0.4, 12)]).moved(x, 0.0, z - 0.28).painted(STEEL)
        steel = Diffuse(color=(1.0, 1.0, 1.0))
        meshes += [mirror, bezel(mirror, VERTICES, VERTICES, 0.03, 0.02).painted(STEEL).mesh(f"mount-{name}", steel)]
        meshes.append(post.mesh(f"mount-{name}/post", steel))
    return Scene(
        name="saddle",
        meshes=(*meshes, *town.town()),
        camera=Camera(position=EYE, target=(-0.06, 1.5, -20.0), field_of_view=35.5),
        lights=LIGHTS,
        sky=SKY,
    )


def facing(middle: Vector) -> np.ndarray:
    """Unit normal of a mirror that shows the eye the street behind it and a little of the fronts."""
    normal = 0.8 * np.array([0.0, 0.02, 1.0]) + 0.2 * np.subtract(EYE, middle)
    return normal / np.linalg.norm(normal)


def toric_mirror(surface: Toroid, size: tuple[float, float], name: str) -> Mesh:
    """A rectangle of a toroid, metres along its right and up, on a square lattice of vertices."""
    u, v = (np.linspace(-extent / 2, extent / 2, VERTICES) for extent in size)
    parameters = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    return Mesh.exact(name, surface, parameters, lattice(VERTICES, VERTICES), Mirror(reflectance=0.92))
