"""The main scene: a convex door mirror beside the driver's eye, in a town of about 10,000 triangles.

After section 5 and Figure 1 of Kakimoto, Tatsukawa, Chun and Nishita, "Real-time reflection and refraction on a
per-vertex basis" (2007): the mirror has 7 x 7 vertices.
"""

from __future__ import annotations

import numpy as np

from anamorph.base.vectors import Vector
from anamorph.gallery import town_textures as wear
from anamorph.gallery.car import CABIN, HALF_WIDTH, PILLAR, STATIONS, saloon
from anamorph.gallery.solids import Solid, lattice, loft
from anamorph.gallery.town import car_shade, cars, ground, houses, lamps, trees
from anamorph.scene.camera import Camera
from anamorph.scene.model import AmbientLight, Diffuse, DirectionalLight, Mesh, Mirror, Scene, Sky
from anamorph.scene.pose import WORLD_UP, upright_axes
from anamorph.surfaces.sphere import Sphere

RADIUS = 1.4
GLASS_SIZE = (0.19, 0.13)
VERTICES = 7
EYE = (1.26, 1.15, 0.0)
MIRROR = (0.70, 1.055, -0.48)
LOOK = (0.71, 1.062, -0.48)
REARWARD = (-0.14, -0.03, 1.0)
OWN_CAR = (1.72, 0.0, 0.35)
PAINT = (0.36, 0.018, 0.02)
PLASTIC = (0.045, 0.046, 0.05)
TOWARD_SUN = np.array([0.42, 0.72, -0.55]) / np.linalg.norm([0.42, 0.72, -0.55])
LIGHTS = (
    DirectionalLight(toward=tuple(TOWARD_SUN), color=(0.92, 0.87, 0.76)),
    AmbientLight(sky=(0.46, 0.50, 0.58), ground=(0.26, 0.25, 0.23)),
)
SKY = Sky(zenith=(0.16, 0.36, 0.78), horizon=(0.72, 0.83, 0.94), nadir=(0.30, 0.31, 0.28))


def car_mirror() -> Scene:
    """The built-in scene `car-mirror`."""
    sphere = mirror_sphere()
    x, y, z = OWN_CAR
    diffuse = Diffuse(color=(1.0, 1.0, 1.0))
    own = [
        saloon(PAINT, own=True).moved(x, y, z).mesh("own-car", diffuse),
        door_top().mesh("own-car/door-top", diffuse),
        housing(sphere).mesh("housing", diffuse),
        foot(sphere).mesh("housing/foot", diffuse),
        car_shade(x, z).mesh("own-car/shade", Diffuse(color=(1, 1, 1), texture=wear.road())),
    ]
    return Scene(
        name="car-mirror",
        meshes=(glass(sphere), *own, *ground(), *houses(), *trees(), *lamps(), *cars()),
        camera=Camera(position=EYE, target=LOOK, field_of_view=13.6),
        lights=LIGHTS,
        sky=SKY,
    )


def mirror_sphere(rearward: Vector = REARWARD) -> Sphere:
    """The glass's sphere: its outward axis bisects the directions to the eye and to what it shows, the road behind."""
    to_eye = np.subtract(EYE, MIRROR)
    outward = to_eye / np.linalg.norm(to_eye) + np.asarray(rearward) / np.linalg.norm(rearward)
    outward /= np.linalg.norm(outward)
    axes = upright_axes(outward, WORLD_UP)
    return Sphere(center=np.asarray(MIRROR) - RADIUS * outward, radius=RADIUS, axes=axes)


def on_sphere(sphere: Sphere, plane: np.ndarray, lift: float | np.ndarray = 0.0) -> np.ndarray:
    """World points over points (..., 2) of the tangent plane at the mirror's middle, `lift` above the sphere."""
    right, up, outward = np.asarray(sphere.axes)
    height = np.sqrt(sphere.radius**2 - np.sum(plane**2, axis=-1)) + lift
    return sphere.center + plane[..., :1] * right + plane[..., 1:] * up + height[..., None] * outward


def glass(sphere: Sphere) -> Mesh:
    """The mirror itself: a rectangle seen along its axis, every vertex on the sphere."""
    x, y = (np.linspace(-extent / 2, extent / 2, VERTICES) for extent in GLASS_SIZE)
    plane = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    parameters = sphere.parameters(on_sphere(sphere, plane))
    polished = Mirror(tint=(0.97, 0.985, 1.0), reflectance=0.9)
    return Mesh.exact("mirror", sphere, parameters, lattice(VERTICES, VERTICES), polished)


def rounded_rectangle(half_width: float, half_height: float, corner: float, arc: int = 9) -> np.ndarray:
    """An outline, (4 arc, 2), counter-clockwise."""
    quarter = np.linspace(0, np.pi / 2, arc)
    arcs = []
    for turn, (x, y) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        angle = quarter + turn * np.pi / 2
        middle = np.array([x * (half_width - corner), y * (half_height - corner)])
        arcs.append(middle + corner * np.stack([np.cos(angle), np.sin(angle)], axis=-1))
    return np.concatenate(arcs)


def housing(sphere: Sphere) -> Solid:
    """A dark frame whose bevelled inner edge lies just before the border of the glass, and the shell behind it.

    The bevel leans outward by more than the widest reflected ray, as on a real mirror: the glass does not show it.
    """
    wide, high = GLASS_SIZE[0] / 2, GLASS_SIZE[1] / 2
    rings = [
        (0.030, 0.030, 0.012, -0.085),
        (wide * 0.75, high * 0.75, 0.04, -0.075),
        (wide * 0.98, high * 0.98, 0.04, -0.05),
        (wide + 0.012, high + 0.012, 0.036, -0.02),
        (wide + 0.014, high + 0.014, 0.034, 0.0),
        (wide + 0.0125, high + 0.0125, 0.032, 0.0055),
        (wide + 0.009, high + 0.009, 0.029, 0.0075),
        (wide + 0.006, high + 0.006, 0.026, 0.007),
        (wide - 0.003, high - 0.003, 0.022, 0.001),
    ]
    outline = [on_sphere(sphere, rounded_rectangle(w, h, r), lift) for w, h, r, lift in rings]
    outline.insert(0, np.broadcast_to(outline[0].mean(axis=0), outline[0].shape))
    return loft(np.stack(outline), crease=50.0).painted(PLASTIC)


def foot(sphere: Sphere) -> Solid:
    """The arm from the housing to the door."""
    angle = np.linspace(0, 2 * np.pi, 14, endpoint=False)
    start = np.add(MIRROR, (0.03, -0.045, -0.055))
    end = np.array([OWN_CAR[0] - HALF_WIDTH + 0.02, 0.90, MIRROR[2] - 0.09])
    rings = []
    for share, size in ((0.0, 0.030), (0.5, 0.026), (1.0, 0.042)):
        middle = start + share * (end - start)
        rings.append(middle + np.stack([0 * angle, size * 0.6 * np.cos(angle), size * np.sin(angle)], axis=-1))
    return loft(np.stack(rings)).painted(PLASTIC)


def door_top() -> Solid:
    """The rubber strip along the lower edge of the driver's window."""
    first, last = CABIN[0], PILLAR
    along = STATIONS[first : last + 1]
    corners = np.array([[0.055, -0.02], [0.105, -0.02], [0.105, 0.018], [0.055, 0.018]])
    rings = [[(inset - wide, waist + up, z) for inset, up in corners] for z, wide, _, waist, _, _ in along]
    return loft(np.array(rings)).painted(PLASTIC).moved(*OWN_CAR)
