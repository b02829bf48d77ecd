"""The built-in scenes, made by parametric code with fixed seeds: the same arrays on every machine.

To add one: a module beside this one with a function that returns a `Scene`, and a line in `SCENES`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from anamorph.base.errors import AnamorphError
from anamorph.gallery.car_mirror import car_mirror
from anamorph.gallery.car_windows import car_windows
from anamorph.gallery.cube_mirrors import cube_in_sphere, cube_in_wavy_mirror
from anamorph.gallery.curvature_series import curvature_series
from anamorph.gallery.deforming import deforming
from anamorph.gallery.facing_mirrors import facing_mirrors
from anamorph.gallery.flat_mirror import flat_mirror
from anamorph.gallery.kitchen import kitchen
from anamorph.gallery.lenses import magnifier, spectacles_minus, spectacles_plus
from anamorph.gallery.room import room
from anamorph.gallery.saddle import saddle
from anamorph.gallery.spheres import spheres
from anamorph.gallery.torus import torus
from anamorph.scene.model import Scene


@dataclass(frozen=True)
class BuiltIn:
    """A built-in scene: its name, one line for lists, and how to make it."""

    name: str
    summary: str
    make: Callable[[], Scene]


SCENES: dict[str, BuiltIn] = {
    entry.name: entry
    for entry in (
        BuiltIn("car-mirror", "the driver's eye beside a convex door mirror, in a town", car_mirror),
        BuiltIn("spheres", "a mirror ball and a flat mirror among coloured balls, all of closed form", spheres),
        BuiltIn("room", "a polished Utah teapot, of 32 Bezier patches, on a table in a room", room),
        BuiltIn("flat-mirror", "a flat wall mirror of two triangles, seen obliquely", flat_mirror),
        BuiltIn("spectacles-minus", "a lens of -6 D before an eye in a room: all smaller", spectacles_minus),
        BuiltIn("spectacles-plus", "a lens of +6 D before an eye in a room: all larger", spectacles_plus),
        BuiltIn("magnifier", "a reading glass of +10 D at arm's length in a street: all reversed", magnifier),
        BuiltIn("curvature-series", "nine spherical mirrors, from convex over flat to concave", curvature_series),
        BuiltIn("saddle", "a saddle-shaped and a cylindrical mirror in a street, both oblique", saddle),
        BuiltIn("car-windows", "the town in the windows of cars, and both in the door mirror", car_windows),
        BuiltIn(
            "facing-mirrors",
            "two flat mirrors before each other, not quite parallel: a tunnel",
            facing_mirrors,
        ),
        BuiltIn("torus", "a closed mirror ring on its exact surface, over a chequered floor", torus),
        BuiltIn("kitchen", "a polished kettle among pans, a toaster and a bowl on a laid table", kitchen),
        BuiltIn("deforming", "a convex mirror over a rolling sea with flags: 300,000 moving triangles", deforming),
        BuiltIn("cube-in-sphere", "a numbered cube over a board in a small part of a mirror ball", cube_in_sphere),
        BuiltIn("cube-in-wavy-mirror", "the same in a flat mirror with random normals", cube_in_wavy_mirror),
    )
}


def names() -> tuple[str, ...]:
    """The names of the built-in scenes, the main one first."""
    return tuple(SCENES)


def make(name: str) -> Scene:
    """The built-in scene called `name`."""
    if name not in SCENES:
        raise AnamorphError(f"scene '{name}' is not built in; choose one of: {', '.join(SCENES)}")
    return SCENES[name].make()
