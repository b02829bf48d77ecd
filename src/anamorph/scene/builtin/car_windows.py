"""The town in the side windows of cars, and both in the door mirror: two mirrors on a path.

After section 4.4 and Figure 11 of Kakimoto, Tatsukawa, Chun and Nishita, "Real-time reflection and refraction on a
per-vertex basis" (2007). The scene is `car-mirror` with the mirror turned out to a car that is overtaking, and with
panes in the side windows: dark glass that reflects a part of the light, and hides what is behind it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from anamorph.scene.builtin import town_textures as wear
from anamorph.scene.builtin.car import STATIONS, number_plates, saloon, section
from anamorph.scene.builtin.car_mirror import OWN_CAR, PLASTIC, car_mirror, foot, glass, housing, mirror_sphere
from anamorph.scene.builtin.shapes import lattice
from anamorph.scene.builtin.town import CARS, car_shade
from anamorph.scene.camera import Vector
from anamorph.scene.model import Color, Diffuse, Mesh, Mirror, Scene
from anamorph.scene.sag import Toroid

REARWARD: Vector = (-0.36, -0.02, 1.0)
OVERTAKING: Vector = (-1.25, 0.0, 3.1)
PAINT: Color = (0.62, 0.63, 0.60)
GLASS = Mirror(tint=(0.82, 0.93, 0.90), reflectance=0.42)
FIELD_OF_VIEW = 14.5
VERTICES = (9, 5)
BEND = (0.06, 0.45)
"""Curvatures of a pane along the car and across, 1/m."""
CLEAR = 0.006
"""Metres from the body to a pane's border."""
PANES = {"front": ((-0.70, 0.07), (-0.22, 0.07)), "rear": ((0.21, 0.93), (0.21, 0.86))}
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
    x, _, z = OVERTAKING
    matt = Diffuse(color=(1.0, 1.0, 1.0))
    overtaking = [
        saloon(PAINT).moved(*OVERTAKING).mesh("overtaking", matt),
        number_plates(2).moved(*OVERTAKING).mesh("overtaking/plates", Diffuse(color=(1, 1, 1), texture=wear.plates())),
        car_shade(x, z).mesh("overtaking/shade", Diffuse(color=(1, 1, 1), texture=wear.road())),
    ]
    panes = [pane("own-window", OWN_CAR, "rear", -1), *(pane(f"window-{name}", OVERTAKING, name, 1) for name in PANES)]
    return Scene(
        name="car-windows",
        meshes=(*(turned.get(mesh.name, mesh) for mesh in street.meshes), *overtaking, *panes),
        camera=replace(street.camera, field_of_view=FIELD_OF_VIEW),
        lights=street.lights,
        sky=street.sky,
    )


def pane(name: str, place: Vector, window: str, side: int) -> Mesh:
    """A side window of a car that stands at `place`, its nose to -z: `side` is 1 on the right and -1 on the left."""
    corners = np.array([edge(z, upper) for upper, ends in enumerate(PANES[window]) for z in ends])
    corners = corners * (side, 1, 1) + place
    middle = corners.mean(axis=0)
    along = (corners[1] - corners[0]) * -side
    outward = np.cross(along, corners[2:].mean(axis=0) - corners[:2].mean(axis=0))
    outward /= np.linalg.norm(outward)
    right = along - (along @ outward) * outward
    right /= np.linalg.norm(right)
    surface = Toroid(middle, *BEND, np.stack([right, np.cross(outward, right), outward]))
    flat = surface.parameters(corners)
    # The border stands clear of the body, so that the apex stands out by the pane's sag there.
    lift = CLEAR + surface.sag(flat)[0].max()
    surface = replace(surface, apex=middle + lift * outward)

    s, t = (axis.ravel()[:, None] for axis in np.meshgrid(*(np.linspace(0.0, 1.0, count) for count in VERTICES)))
    ends = flat if side < 0 else flat[[1, 0, 3, 2]]
    parameters = (1 - t) * ((1 - s) * ends[0] + s * ends[1]) + t * ((1 - s) * ends[2] + s * ends[3])
    return Mesh(
        name=name,
        positions=surface.position(parameters).astype(np.float32),
        faces=lattice(VERTICES[1], VERTICES[0]).astype(np.int32),
        normals=surface.normal(parameters).astype(np.float32),
        material=GLASS,
        surface=surface,
        parameters=parameters,
    )


def edge(z: float, upper: int) -> np.ndarray:
    """A point of the right side's window line below, or above if `upper`, at `z` along a car."""
    station = [np.interp(z, STATIONS[:, 0], column) for column in STATIONS.T]
    low, high = section(np.array(station))[[5, 6]]
    x, y = low + (0.97 if upper else 0.04) * (high - low)
    return np.array([x, y, z])
