"""Lenses between an eye and chequered walls."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from anamorph.frame import Frame
from anamorph.gallery.solids import box, grid
from anamorph.gallery.textures import checkerboard
from anamorph.lenses.lens import Lens, lens_between
from anamorph.lenses.making import make_lens
from anamorph.lenses.prescription import Prescription
from anamorph.scene.camera import Camera
from anamorph.scene.model import Diffuse, Glass, Mesh, Scene
from anamorph.surfaces.sphere import round_surface

SIZE = (200, 150)

EYE = (0.0, 0.5, 0.6)

CENTER = np.array([0.0, 0.5, 0.4])
"""The back vertex of the lenses here, which the eye sees along -z."""

CAMERA = Camera(EYE, (0.0, 0.5, 0.0), field_of_view=24.0)

AXES = np.array([[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]])
"""A lens's right, up and outward, as seen by who faces the eye."""


def lens_of(prescription: Prescription, tint=(1.0, 1.0, 1.0), abbe: float | None = None, vertices: int = 547) -> Lens:
    lens = make_lens(prescription, tuple(CENTER.tolist()), (0.0, 0.0, -1.0), tint=tint, vertices=vertices)
    return of_glass(lens, Glass(prescription.index, tint, abbe))


def of_glass(lens: Lens, glass: Glass) -> Lens:
    return replace(lens, front=replace(lens.front, material=glass), back=replace(lens.back, material=glass))


def slab(index: float = 1.5, thickness: float = 0.02, radius: float = 0.06, vertices: int = 7) -> Lens:
    """A flat lens of as few vertices as there can be."""
    front, back = (
        round_surface(CENTER + along * AXES[2], axes, 0.0)
        for along, axes in ((thickness, AXES), (0.0, AXES * [[-1], [1], [-1]]))
    )
    return lens_between(front, back, CENTER, AXES, radius, Glass(index), vertices=vertices)


def walls() -> tuple[Mesh, ...]:
    """Chequered walls beyond the lens and behind the eye, with boxes of one colour before each."""
    board = Diffuse(color=(1.0, 1.0, 1.0), texture=checkerboard(128, 8, (220, 210, 200), (60, 70, 80)))
    walls = [
        grid((-2.0, -1.0, -1.6), (4.0, 0.0, 0.0), (0.0, 3.0, 0.0)).mesh("wall", board),
        grid((2.0, -1.0, 2.0), (-4.0, 0.0, 0.0), (0.0, 3.0, 0.0)).mesh("wall behind", board),
    ]
    places = [
        ((-0.35, 0.35, -0.9), (-0.15, 0.55, -0.7), (0.7, 0.1, 0.1)),
        ((0.1, 0.1, -1.4), (0.4, 0.7, -1.2), (0.1, 0.6, 0.2)),
        ((-0.02, 0.53, -0.4), (0.03, 0.6, -0.35), (0.1, 0.2, 0.7)),
        ((0.2, 0.2, 1.2), (0.5, 0.9, 1.4), (0.6, 0.2, 0.6)),
        ((-0.5, 0.3, 0.9), (-0.2, 0.6, 1.1), (0.8, 0.7, 0.1)),
    ]
    boxes = [
        box(low, high).mesh(f"box-{number}", Diffuse(color=color)) for number, (low, high, color) in enumerate(places)
    ]
    return (*walls, *boxes)


def scene_of(lens: Lens, *others: Mesh, camera: Camera = CAMERA) -> Scene:
    return Scene("lens", (*lens.meshes, *others, *walls()), camera)


MINUS = Prescription(-6.0, diameter=80.0)

PLUS = Prescription(6.0, diameter=60.0, centre_thickness=9.0)


def defined(frame: Frame) -> None:
    for name in ("color", "position", "deviation"):
        assert np.isfinite(getattr(frame, name)).all()
    assert (np.abs(np.linalg.norm(frame.position[frame.object_id == 0], axis=-1) - 1.0) < 1e-4).all()
