"""The town in the side windows of cars, and both in the door mirror: two mirrors on a path.

After section 4.4 and Figure 11 of Kakimoto, Tatsukawa, Chun and Nishita, "Real-time reflection and refraction on a
per-vertex basis" (2007). The scene is `car-mirror` with the mirror turned out to a car that has just passed, and with
another one that comes. Both have panes in their side windows: dark glass that reflects a part of the light, and hides
what is behind it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from anamorph.base.vectors import Vector
from anamorph.gallery import town_textures as wear
from anamorph.gallery.car import STATIONS, number_plates, saloon, section
from anamorph.gallery.car_mirror import LIGHTS, PLASTIC, SKY, car_mirror, foot, glass, housing, mirror_sphere
from anamorph.gallery.solids import join, lattice
from anamorph.gallery.town import car_shade
from anamorph.scene.model import Color, Diffuse, Mesh, Mirror, Scene
from anamorph.surfaces.toroid import Toroid

REARWARD: Vector = (-0.50, -0.02, 1.0)
ONCOMING: tuple[tuple[str, float, float, Color], ...] = (
    ("passed", -1.62, 3.2, (0.62, 0.63, 0.60)),
    ("coming", -1.62, -1.8, (0.10, 0.22, 0.40)),
)
"""Name, x, z and paint; both drive toward +z."""
GLASS = Mirror(tint=(0.82, 0.93, 0.90), reflectance=0.42)
LOOK: Vector = (0.71, 1.085, -0.48)
FIELD_OF_VIEW = 17.5
VERTICES = (9, 5)
BEND = (0.06, 0.45)
"""Curvatures of a pane along the car and across, 1/m."""
CLEAR = 0.006
"""Metres from the body to a pane's border, at least."""
PANES = {"front": ((-0.66, 0.07), (-0.15, 0.07)), "rear": ((0.21, 0.84), (0.21, 0.82))}
"""From where to where along a car, in metres, its side windows' lower and upper edges go."""


def car_windows() -> Scene:
    """The built-in scene `car-windows`."""
    sphere = mirror_sphere(REARWARD)
    street = car_mirror()
    turned = {
        "mirror": glass(sphere),
        "housing": housing(sphere).mesh("housing", Diffuse(color=PLASTIC)),
        "housing/foot": foot(sphere).mesh("housing/foot", Diffuse(color=PLASTIC)),
    }
    diffuse, plates = Diffuse(color=(1.0, 1.0, 1.0)), Diffuse(color=(1.0, 1.0, 1.0), texture=wear.plates())
    cars: list[Mesh] = []
    for number, (name, x, z, paint) in enumerate(ONCOMING):
        cars += [pane(f"{name}-{window}-window", (x, 0.0, z), window) for window in PANES]
        cars.append(saloon(paint).turned(180.0).moved(x, 0.0, z).mesh(name, diffuse))
        cars.append(number_plates(number + 1).turned(180.0).moved(x, 0.0, z).mesh(f"{name}/plates", plates))
    shades = join([car_shade(x, z) for _, x, z, _ in ONCOMING])
    shade = shades.mesh("oncoming-shade", Diffuse(color=(1.0, 1.0, 1.0), texture=wear.road()))
    return Scene(
        name="car-windows",
        meshes=(*(turned.get(mesh.name, mesh) for mesh in street.meshes), *cars, shade),
        camera=replace(street.camera, target=LOOK, field_of_view=FIELD_OF_VIEW),
        lights=LIGHTS,
        sky=SKY,
    )


def pane(name: str, place: Vector, window: str) -> Mesh:
    """A left side window of a car that stands at `place`, its nose to +z: seen from +x."""
    corners = np.array([edge(z, upper) for upper, ends in enumerate(PANES[window]) for z in ends])
    corners = corners * (1, 1, -1) + place
    middle = corners.mean(axis=0)
    along = corners[1] - corners[0]
    outward = np.cross(along, corners[2:].mean(axis=0) - corners[:2].mean(axis=0))
    outward /= np.linalg.norm(outward)
    right = along - (along @ outward) * outward
    right /= np.linalg.norm(right)
    surface = Toroid(middle, *BEND, np.stack([right, np.cross(outward, right), outward]))
    flat = surface.parameters(corners)
    # A car's window line is a little twisted: each corner stands clear of the body.
    lift = CLEAR + float((surface.sag(flat)[0] + (corners - middle) @ outward).max())
    surface = replace(surface, apex=middle + lift * outward)

    s, t = (axis.ravel()[:, None] for axis in np.meshgrid(*(np.linspace(0.0, 1.0, count) for count in VERTICES)))
    parameters = (1 - t) * ((1 - s) * flat[0] + s * flat[1]) + t * ((1 - s) * flat[2] + s * flat[3])
    return Mesh.exact(name, surface, parameters, lattice(VERTICES[1], VERTICES[0]), GLASS)


def edge(z: float, upper: int) -> np.ndarray:
    """A point of the window line below, or above if `upper`, at `z` along a car whose nose is to -z."""
    station = [np.interp(z, STATIONS[:, 0], column) for column in STATIONS.T]
    low, high = section(np.array(station))[[5, 6]]
    x, y = low + (0.97 if upper else 0.04) * (high - low)
    return np.array([x, y, z])
