"""Lenses from prescriptions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.base.vectors import Vector
from anamorph.lenses.lens import Lens, lens_between, thickness
from anamorph.lenses.prescription import Prescription
from anamorph.scene.model import WHITE, Color, Glass

LEAST_EDGE = 0.5
"""Edge thickness, millimetres, that a remedy aims at."""

STEEPEST = 0.95
"""How far out the edge may lie, as a share of a face's radius: further out the face runs along the axis."""


def lens_axes(outward: Vector, up: Vector = (0.0, 1.0, 0.0)) -> np.ndarray:
    """Rows right, up and outward, (3, 3) float64, as seen by who faces the wearer."""
    forward = np.asarray(outward, float)
    right = np.cross(up, forward)
    if not np.linalg.norm(right) > 1e-9 * np.linalg.norm(up) * np.linalg.norm(forward):
        raise AnamorphError(f"lens: outward {outward} and up {up} are one direction or none; give two that differ")
    forward, right = forward / np.linalg.norm(forward), right / np.linalg.norm(right)
    return np.stack([right, np.cross(forward, right), forward])


def make_lens(
    prescription: Prescription,
    back_vertex: Vector,
    outward: Vector,
    up: Vector = (0.0, 1.0, 0.0),
    name: str = "lens",
    vertices: int = 547,
    tint: Color = WHITE,
) -> Lens:
    """The lens that `prescription` describes.

    Parameters
    ----------
    prescription : Prescription
    back_vertex : three floats
        Where the axis meets the face toward the wearer, metres.
    outward : three floats
        From the wearer to what is looked at; of any length.
    up : three floats
        Toward the 90 degrees of the prescription; need not be perpendicular to `outward`.
    name : str
    vertices : int
        About how many each face gets.
    tint : three floats
        Linear colour of the light that a crossing lets through.

    Returns
    -------
    Lens
        Its glass has the index and the Abbe number of the prescription.

    Raises
    ------
    AnamorphError
        No such lens can be made.
    """
    axes = lens_axes(outward, up)
    least = edge_thickness(prescription)
    if least <= 0.0:
        raise AnamorphError(
            f"prescription: edge thickness is {least:.2f} mm; "
            f"give a centre_thickness of at least {_enough(prescription):.1f} mm, or a smaller diameter"
        )
    front, back = prescription.surfaces(np.asarray(back_vertex, float), axes)
    glass = Glass(prescription.index, tint, prescription.abbe)
    radius = 5e-4 * prescription.diameter
    return lens_between(front, back, np.asarray(back_vertex, float), axes, radius, glass, name, vertices)


def worn_lens(
    prescription: Prescription,
    eye: Vector,
    gaze: Vector,
    up: Vector = (0.0, 1.0, 0.0),
    name: str = "lens",
    vertices: int = 547,
    tint: Color = WHITE,
) -> Lens:
    """The lens before an `eye` (metres) that looks along `gaze`, at the prescription's vertex distance."""
    direction = np.asarray(gaze, float) / np.linalg.norm(gaze)
    x, y, z = np.asarray(eye, float) + 1e-3 * prescription.vertex_distance * direction
    return make_lens(prescription, (float(x), float(y), float(z)), gaze, up, name, vertices, tint)


def edge_thickness(prescription: Prescription) -> float:
    """The least thickness around the edge, millimetres; negative where the faces cross."""
    _check_radii(prescription)
    angle = np.arange(180) * 2.0 * np.pi / 180
    rim = 5e-4 * prescription.diameter * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    axes = np.eye(3)
    front, back = prescription.surfaces(np.zeros(3), axes)
    return 1e3 * float(thickness(front, back, np.zeros(3), axes, rim).min())


def _check_radii(prescription: Prescription) -> None:
    """Both faces must reach the edge."""
    per_power = 1e-3 / (prescription.index - 1.0)
    back = (prescription.back_power(prescription.sphere + more) for more in (0.0, prescription.cylinder))
    faces = (
        ("front", abs(prescription.front_power), 0.0),
        ("back", max(map(abs, back)), np.sin(prescription.back_tilt)),
    )
    for side, power, aside in faces:
        curvature = power * per_power
        # A tilted face's centre stands aside, by this share of its radius.
        if curvature * prescription.diameter / 2.0 > STEEPEST - aside:
            raise AnamorphError(
                f"prescription: the {side} surface needs a radius of {1.0 / curvature:.1f} mm, too small for the "
                f"diameter; give a diameter of at most {2.0 * max(STEEPEST - aside, 0.0) / curvature:.1f} mm, "
                "another base_curve or a higher index"
            )


def _enough(prescription: Prescription) -> float:
    """A centre thickness, in tenths of millimetres, that leaves the edge some glass."""
    thick = prescription.centre_thickness
    for _ in range(20):
        missing = LEAST_EDGE - edge_thickness(replace(prescription, centre_thickness=thick))
        if missing <= 0.0:
            break
        thick = np.ceil(10.0 * (thick + 1.02 * missing)) / 10.0
    return float(thick)
