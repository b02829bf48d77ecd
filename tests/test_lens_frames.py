"""Frames of lenses by per-vertex refraction, against rays and against what opticians reckon."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scenes import drawn

from anamorph.frame import Frame, Status
from anamorph.measure.errors import measure, silhouettes
from anamorph.optics.dispersion import line_indices
from anamorph.scene.builtin import make
from anamorph.scene.builtin.flat_mirror import plane_mirror
from anamorph.scene.builtin.shapes import box, grid
from anamorph.scene.builtin.textures import checkerboard
from anamorph.scene.camera import Camera
from anamorph.scene.lens import Lens, Prescription, make_lens
from anamorph.scene.lens_mesh import lens_between
from anamorph.scene.model import AmbientLight, Diffuse, Glass, Mesh, Scene
from anamorph.scene.prescription import round_surface

SIZE = (200, 150)
METHODS = ("pervertex", "pervertex:refine=2")
BUILT_IN = ("spectacles-minus", "spectacles-plus", "magnifier")

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


@cache
def built_in(name: str, specification: str) -> Frame:
    return drawn(make(name), specification, SIZE)


def inner(truth: Frame) -> np.ndarray:
    return (truth.specular > 0) & ~silhouettes(truth.object_id, truth.specular)


@pytest.mark.parametrize("name", BUILT_IN)
@pytest.mark.parametrize("specification", METHODS)
def test_built_in_lenses_are_right_to_a_twentieth_of_a_pixel(name, specification):
    errors = measure(built_in(name, "raytrace"), built_in(name, specification))
    assert errors.pixels.median <= 0.02
    assert errors.pixels.p95 <= 0.05
    assert errors.pixels.max <= 1.0
    assert errors.other_object_percent <= 0.1


@pytest.mark.parametrize("name", BUILT_IN)
def test_no_pixel_of_a_lens_goes_without_an_answer(name):
    truth, frame = built_in(name, "raytrace"), built_in(name, "pervertex")
    assert frame.outside_share <= 1e-3
    away = ~silhouettes(truth.specular)
    assert (frame.specular == truth.specular)[away].all()


@pytest.mark.parametrize("name", BUILT_IN)
def test_built_in_lenses_have_the_truths_colours_where_it_is_smooth(name):
    """Tint, Fresnel's share and dispersion are the truth's; what differs is how finely textures are filtered."""
    truth, frame = built_in(name, "raytrace"), built_in(name, "pervertex:refine=2")
    smooth = inner(truth)
    for axis in (0, 1):
        for step in (-1, 1):
            smooth &= np.abs(np.roll(truth.color, step, axis) - truth.color).max(axis=-1) < 0.02
    assert smooth.sum() > 500
    difference = np.abs(frame.color - truth.color)[smooth]
    assert np.percentile(difference, 95) <= 0.01
    assert np.abs((frame.color - truth.color)[smooth].mean()) <= 1e-3
