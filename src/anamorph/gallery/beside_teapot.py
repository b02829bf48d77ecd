"""A mirror teapot of about 4,000 triangles in a hall, and beside it one of six sculptures.

After the scenes by which Mei, Popescu and Sacks, "A hybrid backward-forward method for interactive reflections" (2007),
measure; their objects were scanned. Ours are sculpted, of as many triangles as
the paper's have points: each triangle is a surfel.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

from anamorph.gallery.animals import bunny, dinosaur, dragon
from anamorph.gallery.hall import hall
from anamorph.gallery.sculpting import Sculpture, sculpted
from anamorph.gallery.solids import Solid
from anamorph.gallery.statue import statue
from anamorph.gallery.teapot import teapot
from anamorph.scene.camera import Camera
from anamorph.scene.model import AmbientLight, Diffuse, DirectionalLight, Mesh, Mirror, Scene

PATCH_VERTICES = 9
"""Along a side of each of the pot's 32 patches: 4,032 triangles."""


@dataclass(frozen=True)
class Beside:
    """A sculpture beside the pot: how many triangles it has, its scale, where (x, z) it stands, and degrees turned."""

    sculpture: Callable[[], Sculpture]
    triangles: int
    scale: float
    place: tuple[float, float]
    turn: float


OBJECTS = {
    "Statue0": Beside(statue, 543_000, 0.64, (-0.68, 0.66), 20.0),
    "Dragon0": Beside(dragon, 437_000, 0.62, (-0.80, 0.78), 62.0),
    "Bunny0": Beside(bunny, 147_000, 0.62, (-0.70, 0.74), 35.0),
    "Dragon1": Beside(dragon, 100_000, 0.62, (0.76, 0.84), -75.0),
    "Bunny1": Beside(bunny, 37_000, 0.62, (0.68, 0.74), -35.0),
    "Dinosaur": Beside(dinosaur, 10_000, 0.62, (-0.72, 0.84), 80.0),
}
"""By the names that the paper gives its scenes."""


def beside_teapot(name: str, triangles: int | None = None) -> Scene:
    """The pot with the object of that name in `OBJECTS`, sculpted in its own number of triangles or another one."""
    beside = OBJECTS[name]
    solid, (x, z) = _solid(beside.sculpture, triangles or beside.triangles), beside.place
    placed = replace(solid, positions=beside.scale * solid.positions).turned(beside.turn).moved(x, -0.5, z)
    scene = in_hall(name, placed.mesh(name, Diffuse(color=(1.0, 1.0, 1.0))))
    # As the paper's pot has no more triangles in a larger image, ours must not be made finer on its exact surface.
    plain = tuple(replace(mesh, surface=None, parameters=None) for mesh in scene.meshes)
    return replace(scene, meshes=plain)


def in_hall(name: str, *objects: Mesh) -> Scene:
    """The pot, on its exact surface, with any objects."""
    silver = Mirror(tint=(1.0, 0.97, 0.93), reflectance=0.9)
    return Scene(
        name=name,
        meshes=(*teapot((0.0, -0.5, 0.0), 1.0, 0.0, silver, PATCH_VERTICES), *objects),
        camera=Camera(position=(0.0, 0.75, 4.0), target=(0.0, -0.05, 0.3), field_of_view=30.0),
        lights=(
            DirectionalLight(toward=(0.48, 0.6, 0.64), color=(0.75, 0.72, 0.66)),
            AmbientLight(sky=(0.62, 0.63, 0.66), ground=(0.40, 0.37, 0.33)),
        ),
        sky=hall(),
    )


@cache
def _solid(sculpture: Callable[[], Sculpture], triangles: int) -> Solid:
    return sculpted(sculpture(), triangles)
