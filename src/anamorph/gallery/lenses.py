"""Lenses before an eye: two spectacle lenses in a room, and a reading glass held up in a street.

After Figures 12 and 13 of Kakimoto, Tatsukawa, Chun and Nishita, "Real-time reflection and refraction on a per-vertex
basis" (2007): spectacle lenses 6 and 7 cm from the viewpoint, a convex lens at 76 cm that shows the scene reversed.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from anamorph.gallery import room
from anamorph.gallery.car_mirror import LIGHTS, SKY
from anamorph.gallery.solids import Solid, cylinder, join, lathe
from anamorph.gallery.town import town
from anamorph.lenses.lens import Lens, lens_between
from anamorph.lenses.making import lens_axes, worn_lens
from anamorph.lenses.prescription import Prescription
from anamorph.scene.camera import Camera
from anamorph.scene.model import AmbientLight, Diffuse, Glass, PointLight, Scene
from anamorph.surfaces.even_asphere import EvenAsphere

EYE = (-0.25, 1.42, 0.30)
GAZE = (0.06, -0.03, -1.0)
MINUS = Prescription(-6.0, index=1.6, abbe=42.0, centre_thickness=1.4, diameter=58.0, vertex_distance=60.0)
PLUS = Prescription(6.0, index=1.6, abbe=42.0, centre_thickness=9.0, diameter=58.0, vertex_distance=70.0)

STREET_EYE = (-0.6, 1.65, -24.0)
STREET_GAZE = (0.03, 0.02, 1.0)
READING_DISTANCE = 0.76
READING_POWER = 10.0
READING_RADIUS = 0.045
READING_THICKNESS = 0.023
READING_INDEX = 1.5
CONIC = -1.5
METAL = (0.10, 0.09, 0.08)
WOOD = (0.20, 0.09, 0.04)


def spectacles_minus() -> Scene:
    """The built-in scene `spectacles-minus`."""
    return _spectacles("spectacles-minus", MINUS)


def spectacles_plus() -> Scene:
    """The built-in scene `spectacles-plus`."""
    return _spectacles("spectacles-plus", PLUS)


def _spectacles(name: str, prescription: Prescription) -> Scene:
    lens = worn_lens(prescription, EYE, GAZE)
    return Scene(
        name=name,
        meshes=(*lens.meshes, rim(lens, GAZE, 0.0012).mesh("lens/rim", Diffuse(color=METAL)), *room.furniture()),
        camera=_looking(EYE, lens, 62.0),
        lights=(
            PointLight(position=(-0.4, 2.2, 0.6), color=(2.0, 1.9, 1.75)),
            AmbientLight(sky=(0.46, 0.46, 0.48), ground=(0.32, 0.29, 0.26)),
        ),
    )


def magnifier() -> Scene:
    """The built-in scene `magnifier`."""
    lens = reading_glass()
    frame = rim(lens, STREET_GAZE, 0.003)
    right, up, outward = lens_axes(STREET_GAZE)
    grip = join([cylinder(0.0035, 0.03).moved(0, 0.10, 0).painted(METAL), cylinder(0.009, 0.105, 20).painted(WOOD)])
    handle = placed(grip, _middle(lens) - (READING_RADIUS + 0.13) * up, np.stack([right, up, outward]))
    return Scene(
        name="magnifier",
        meshes=(
            *lens.meshes,
            frame.mesh("lens/rim", Diffuse(color=METAL)),
            handle.mesh("lens/handle", Diffuse(color=(1.0, 1.0, 1.0))),
            *town(),
        ),
        camera=_looking(STREET_EYE, lens, 12.0),
        lights=LIGHTS,
        sky=SKY,
    )


def reading_glass() -> Lens:
    """A round lens of two like aspheres, concave nowhere, whose power is `READING_POWER`."""
    axes = lens_axes(STREET_GAZE)
    right, up, outward = axes
    middle = np.asarray(STREET_EYE) + READING_DISTANCE * outward
    curvature = like_curvature(READING_POWER, READING_INDEX, READING_THICKNESS)
    half = 0.5 * READING_THICKNESS * outward
    return lens_between(
        EvenAsphere(middle + half, curvature, CONIC, axes=axes),
        EvenAsphere(middle - half, curvature, CONIC, axes=np.stack([-right, up, -outward])),
        middle,
        axes,
        READING_RADIUS,
        Glass(READING_INDEX, abbe=58.0),
        vertices=721,
    )


def like_curvature(power: float, index: float, thickness: float) -> float:
    """The curvature, 1/m, of both faces of a lens: power = 2 F - F^2 t / n with F = (n - 1) curvature."""
    reduced = thickness / index
    return float((1.0 - np.sqrt(1.0 - power * reduced)) / reduced / (index - 1.0))


def rim(lens: Lens, outward: tuple[float, float, float], wire: float) -> Solid:
    """A band of metal, `wire` metres thick, around the edge of a lens."""
    axes = lens_axes(outward)
    middle = _middle(lens)
    along = (lens.edge.positions - middle) @ axes[2]
    radius = float(np.linalg.norm((lens.edge.positions - middle) @ axes[:2].T, axis=1).max())
    low, high = float(along.min()) - 0.2 * wire, float(along.max()) + 0.2 * wire
    # Clear of the glass: it must not cut into a face.
    inner, outer = radius + 0.03 * wire, radius + wire
    band = lathe([(inner, low), (outer, low), (outer, high), (inner, high), (inner, low)], 96)
    return placed(band, middle, axes[[0, 2, 1]] * [[1], [1], [-1]])


def placed(shape: Solid, origin: np.ndarray, axes: np.ndarray) -> Solid:
    """A shape's own x, y and z along the rows of `axes`, from `origin`."""
    return replace(shape, positions=shape.positions @ axes + origin, normals=shape.normals @ axes)


def _middle(lens: Lens) -> np.ndarray:
    return lens.edge.positions.mean(axis=0, dtype=float)


def _looking(eye: tuple[float, float, float], lens: Lens, field_of_view: float) -> Camera:
    """An eye whose target is the lens: whoever goes round that keeps it in the image."""
    x, y, z = _middle(lens).tolist()
    return Camera(position=eye, target=(x, y, z), field_of_view=field_of_view)
