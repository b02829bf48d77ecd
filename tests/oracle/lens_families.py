"""Families of random scenes with lenses."""

from __future__ import annotations

import math

import numpy as np

from anamorph import AnamorphError, Prescription
from oracle import parts
from oracle.conversion import worn_parts
from oracle.scene import Camera, Scene
from oracle.surroundings import Place, around, place

Random = np.random.Generator


def spherical_lenses(random: Random) -> Scene:
    return _lens(random, "spherical lens", astigmatic=False)


def toric_lenses(random: Random) -> Scene:
    return _lens(random, "toric lens", astigmatic=True)


def _lens(random: Random, name: str, astigmatic: bool) -> Scene:
    """A lens of 5 to 10 cm at reading distance, thick enough that its faces stay apart by a millimetre."""
    reach = random.uniform(0.05, 0.1)
    where = place(random, reach, random.uniform(0.25, 0.5), tilt=0.15)
    front, back = (random.uniform(-0.4, 0.4, 2) / reach for _ in range(2))
    if not astigmatic:
        front[1], back[1] = front[0], back[0]
    sag = max(front.max(), 0.0) + max(back.max(), 0.0)
    thickness = 0.002 + 0.65 * sag * reach**2
    index = random.uniform(1.4, 1.8)
    rings, rolls = int(random.integers(6, 18)), tuple(random.uniform(0.0, math.pi, 2).tolist())
    curvatures = tuple(front.tolist()), tuple(back.tolist())
    made = parts.lens("lens", where.middle, -where.facing, *curvatures, thickness, reach, index, rings, rolls)
    return around(random, name, where, *made)


def worn_lenses(random: Random) -> Scene:
    """A prescription as the wearer's eye sees through it, 40 to 100 degrees wide."""
    prescription = random_prescription(random)
    view = float(random.uniform(40.0, 100.0))
    return worn(random, prescription, view, int(random.choice([300, 547, 1500])))


def random_prescription(random: Random) -> Prescription:
    """One that opticians could write, with a lens thick enough."""
    while True:
        sphere, cylinder = 0.25 * random.integers(-28, 20), 0.25 * random.integers(-12, 9)
        power = max(sphere, sphere + cylinder, 0.0)
        try:
            prescription = Prescription(
                sphere=float(sphere),
                cylinder=float(cylinder),
                axis=float(random.integers(0, 36) * 5),
                prism=float(random.choice([0.0, 0.0, 2.0, 4.0])),
                base=float(random.choice([0.0, 90.0, 180.0, 270.0])),
                index=float(random.choice([1.5, 1.56, 1.6, 1.67])),
                centre_thickness=2.5 + 1.2 * float(power),
                diameter=float(random.choice([50.0, 60.0])),
                vertex_distance=float(random.uniform(10.0, 20.0)),
            )
            worn_parts(prescription, (0.0, 0.0, 0.0), (0.0, 0.0, -1.0), 37)
        except AnamorphError:
            continue
        return prescription


def worn(random: Random, prescription: Prescription, field_of_view: float, vertices: int = 547) -> Scene:
    """A lens before an eye at the origin that looks along -z."""
    eye, gaze = (0.0, 0.0, 0.0), (0.0, 0.0, -1.0)
    middle = np.array([0.0, 0.0, -1e-3 * prescription.vertex_distance])
    where = Place(middle, np.array([0.0, 0.0, 1.0]), np.array(eye), 5e-4 * prescription.diameter)
    made = worn_parts(prescription, eye, gaze, vertices)
    return around(random, "worn lens", where, *made, camera=Camera(eye, gaze, field_of_view), near=0.6)


def lenses_near_focus(random: Random) -> Scene:
    """A reading lens held away, until the eye is at its focus: it magnifies without bound."""
    power, distance = ((3.0, 100.0), (3.0, 330.0), (6.0, 150.0), (3.0, 600.0), (-4.0, 300.0))[random.integers(5)]
    thickness = 2.0 if power < 0.0 else 1.5 + 1.2 * power
    prescription = Prescription(sphere=power, centre_thickness=thickness, vertex_distance=distance)
    view = 2.0 * math.degrees(math.atan(1.3 * 30.0 / distance))
    return worn(random, prescription, view)
