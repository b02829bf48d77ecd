"""Scenes on which a method once failed, kept as they were found.

Most come from sweeps of random scenes; their boxes, and the mesh of one, lie in `found.npz`. The others are made here
from a few numbers: a flat wall mirror near the eye, a box where a concave mirror's rays cross, a ground of kilometres
under a worn lens, lenses near their focus, and built-in lenses seen from elsewhere.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from pathlib import Path

import numpy as np

from anamorph import Prescription
from oracle import parts
from oracle.conversion import built_in, worn_parts
from oracle.lens_families import worn
from oracle.meshes import lattice
from oracle.scene import MIRROR, Camera, Mesh, Part, Scene

Numbers = tuple[float, ...]


@cache
def _kept() -> dict[str, np.ndarray]:
    return dict(np.load(Path(__file__).with_suffix(".npz")))


def _with_boxes(name: str, bodies: list[Part], camera: Camera) -> Scene:
    """A scene of the sweeps: its floor and boxes are read."""
    floor = [parts.wall("floor", *_kept()[f"{name}/floor"])] if f"{name}/floor" in _kept() else []
    boxes = []
    for number, (center, *edges) in enumerate(_kept()[f"{name}/boxes"].astype(float)):
        half = np.linalg.norm(edges, axis=1)
        boxes.append(parts.box(f"box-{number}", center, half, edges / half[:, None]))
    return Scene(name, (*bodies, *floor, *boxes), camera)


def _asphere(name: str, apex: Numbers, numbers: Numbers, outward: Numbers, reach: float, camera: Camera) -> Scene:
    return _with_boxes(name, [parts.sag_mirror("mirror", "asphere", numbers, apex, outward, reach, 16)], camera)


def _wavy_mesh() -> Scene:
    """One with interpolated normals; with the tolerance, some of its pixels showed another object."""
    kept = _kept()
    camera = Camera((1.55961695, -0.61866193, 1.87185816), (-0.07300716, 0.12676635, 0.02209055), 29.211485)
    mesh = Mesh(kept["wavy-mesh/positions"], kept["wavy-mesh/normals"], lattice(31, 31))
    return _with_boxes("wavy-mesh", [Part("mirror", mesh, MIRROR)], camera)


def _concave_cap() -> Scene:
    center, radius = np.array([0.887645854, -0.056265129, 0.478950607]), 0.96553828
    facing = np.array([0.953080031, -0.037083525, 0.300438212])
    mirror = parts.cap("mirror", center - radius * facing, facing, -1.0 / radius, 0.39326, 14)
    camera = Camera((1.198456261, 0.148430601, -0.056820363), (-0.016136687, -0.003675462, 0.205495309), 43.391456)
    return _with_boxes("concave-cap", [mirror], camera)


def _ball(name: str, center: Numbers, radius: float, rows: int, camera: Camera, side: float = 1.0) -> Scene:
    return _with_boxes(name, [parts.whole_ball("mirror", center, radius, rows, 2 * rows, side)], camera)


def _tube(name: str, radii: tuple[float, float], around: int, up: int) -> Scene:
    mirror = parts.tube("mirror", (0.0, -0.4, 0.0), (0.0, 1.0, 0.0), radii, 0.8, around, up)
    return _with_boxes(name, [mirror], Camera((0.3, 0.5, 2.0), (0.0, 0.0, 0.0), 34.0))


def _near_mirror() -> Scene:
    """The eye 5 cm before a concave mirror."""
    mirror = parts.cap("mirror", np.zeros(3), (0.0, 0.0, 1.0), -1.0 / 0.8, 0.3, 14)
    return _with_boxes("near-mirror", [mirror], Camera((0.01, 0.02, 0.05), (0.02, 0.0, 0.0), 80.0))


def _sharp_lens(name: str, crossing: float, edge: bool) -> Scene:
    """A biconvex lens without an edge, or whose faces cross at the border by so many metres."""
    thickness = 2.0 * 0.015353599527684787 - crossing
    curvatures = 2 * ((3.0, 3.0),)
    made = parts.lens("lens", np.zeros(3), (0.0, 0.0, -1.0), *curvatures, thickness, 0.1, 1.5, edge=edge)
    return _with_boxes(name, made, Camera((0.0, 0.0, 0.35), (0.0, 0.0, 0.0), 39.307648))


def normals_against_the_winding() -> Scene:
    """A mirror mesh whose normals point away from the side that its triangles face."""
    scene = _wavy_mesh()
    mirror = scene.parts[0]
    turned = replace(mirror, mesh=replace(mirror.mesh, normals=-mirror.mesh.normals))
    return replace(scene, name="normals-against-the-winding", parts=(turned, *scene.parts[1:]))


def flat_wall_mirror(width: float, height: float, distance: float) -> Scene:
    """Two triangles of so many metres, seen from near by; a wall stands 3 m behind the eye's side."""
    mirror = parts.wall("mirror", np.zeros(3), (0.5 * width, 0.0, 0.0), (0.0, 0.5 * height, 0.0), MIRROR)
    wall = parts.wall("wall", (0.0, 0.0, 3.0), (-4.0, 0.0, 0.0), (0.0, 3.0, 0.0))
    eye = (0.05 * width, 0.05 * height, distance)
    return Scene("flat-wall-mirror", (mirror, wall), Camera(eye, (0.5 * eye[0], 0.5 * eye[1], 0.0), 60.0))


def box_at_crossing(share: float, half: float) -> Scene:
    """A box where the rays of a concave mirror cross that shows the eye its own image: there at `share` 1."""
    eye, center = np.array([0.25, 0.0, 1.22]), np.array([0.0, 0.0, 1.0])
    away = float(np.linalg.norm(center - eye))
    crossing = center + (center - eye) / (1.0 + 2.0 * away)
    mirror = parts.cap("mirror", np.zeros(3), (0.0, 0.0, 1.0), -1.0, 0.2, 16)
    box = parts.box("box", center + share * (crossing - center), np.full(3, half))
    wall = parts.wall("wall", (0.0, 0.0, 4.0), (-6.0, 0.0, 0.0), (0.0, 6.0, 0.0))
    return Scene("box-at-crossing", (mirror, box, wall), Camera(tuple(eye.tolist()), (0.0, 0.0, 0.0), 20.0))


def large_ground(half: float) -> Scene:
    """A worn lens above a ground that reaches so many metres, before a row of posts."""
    eye, gaze = (0.0, 1.6, 0.0), (0.0, 0.0, -1.0)
    posts = [
        parts.wall(f"post-{number}", (x, 1.6, -3.0), (0.2, 0.0, 0.0), (0.0, 1.0, 0.0))
        for number, x in enumerate(np.arange(-3.0, 3.1, 0.8))
    ]
    made = worn_parts(Prescription(sphere=-4.0), eye, gaze)
    return Scene("large-ground", (*made, parts.floor(0.0, half), *posts), Camera(eye, (0.0, 1.6, -1.0), 60.0))


def worn_wide(prescription: Prescription, vertices: int, field_of_view: float) -> Scene:
    return worn(np.random.default_rng(9), prescription, field_of_view, vertices)


def near_focus(power: float, distance: float, vertices: int) -> Scene:
    """A lens of so many dioptres, so many millimetres before the eye, which sees little more than the lens."""
    thickness = 2.0 if power < 0.0 else 1.5 + 1.2 * power
    prescription = Prescription(sphere=power, centre_thickness=thickness, vertex_distance=distance)
    return worn_wide(prescription, vertices, min(60.0, 2.0 * math.degrees(math.atan(26.0 / distance))))


def moved_eye(name: str, share: float) -> Scene:
    """A built-in scene with a lens, seen from `share` of the distance from which it is meant to be seen."""
    scene = built_in(name)
    camera = scene.camera
    lens = scene.parts[0].mesh.positions.mean(axis=0)
    eye = lens + share * (np.array(camera.position) - lens)
    view = 2.0 * math.degrees(math.atan(math.tan(math.radians(0.5 * camera.field_of_view)) / share))
    return replace(scene, camera=Camera(tuple(eye.tolist()), tuple(lens.tolist()), min(view, 100.0), camera.up))


FOUND: dict[str, Callable[[], Scene]] = {
    "sixth-order-asphere": partial(
        _asphere, "sixth-order-asphere", (0.293192445, 0.014954796, -0.160836842), (0.3, 0.0, -1.5, 2.0),
        (-0.783238624, -0.280287122, 0.554956203), 0.394430709,
        Camera((-0.6791416, -0.087408316, 1.281633034), (0.275575303, 0.00846407, -0.162277218), 33.587206),
    ),
    "concave-asphere": partial(
        _asphere, "concave-asphere", (-0.225562617, 0.258563364, 0.101010014),
        (-0.868623091, -0.020386341, 0.569028582),
        (-0.059724602, -0.383398700, 0.921649830), 0.301860526,
        Camera((0.051858268, 0.184445425, 0.809775457), (-0.237642362, 0.268662766, 0.087238410), 55.516363),
    ),
    "wavy-mesh": _wavy_mesh,
    "concave-cap": _concave_cap,
    "ball-of-6x12": partial(
        _ball, "ball-of-6x12", (-0.20296958, 0.094637052, 0.134940831), 0.45, 6,
        Camera((1.387493908, 0.373671602, -0.660399104), (-0.213801548, 0.101406283, 0.129998087), 40.646264),
    ),
    "inside-ball": partial(
        _ball, "inside-ball", (0.0, 0.0, 0.0), 1.5, 48, Camera((0.3, 0.2, 0.6), (-0.2, 0.0, -1.0), 90.0), -1.0
    ),
    "blocks-on-ball": partial(
        _ball, "blocks-on-ball", (0.0, 0.0, 0.0), 0.5, 40, Camera((0.0, 0.3, 2.0), (0.0, 0.0, 0.0), 36.0)
    ),
    "cylinder-of-16": partial(_tube, "cylinder-of-16", (0.3, 0.3), 16, 2),
    "cone": partial(_tube, "cone", (0.45, 0.05), 96, 8),
    "near-mirror": _near_mirror,
    "knife-lens": partial(_sharp_lens, "knife-lens", 0.0, False),
    "crossing-lens": partial(_sharp_lens, "crossing-lens", 1e-4, True),
    "wall-mirror-40cm": partial(flat_wall_mirror, 2.0, 2.0, 0.4),
    "wall-mirror-15cm": partial(flat_wall_mirror, 1.2, 0.8, 0.15),
    "box-at-crossing": partial(box_at_crossing, 1.0, 0.025),
    "large-box-at-crossing": partial(box_at_crossing, 1.0, 0.1),
    "ground-of-20-m": partial(large_ground, 10.0),
    "ground-of-4-km": partial(large_ground, 2000.0),
    "ground-of-40-km": partial(large_ground, 20000.0),
    "worn-minus-7": partial(worn_wide, Prescription(sphere=-7.0, cylinder=-0.75, axis=140.0, index=1.67), 547, 100.0),
    "worn-plus-5": partial(worn_wide, Prescription(sphere=5.0, centre_thickness=7.0), 547, 100.0),
    "plus-3-at-330-mm": partial(near_focus, 3.0, 330.0, 547),
    "plus-6-at-150-mm": partial(near_focus, 6.0, 150.0, 4000),
    "magnifier-near": partial(moved_eye, "magnifier", 0.25),
    "spectacles-plus-far": partial(moved_eye, "spectacles-plus", 3.0),
    "spectacles-minus-half": partial(moved_eye, "spectacles-minus", 0.5),
}  # fmt: skip
"""By name, what makes each scene."""

AGREEING = [
    "near-mirror", "box-at-crossing", "wall-mirror-15cm", "worn-minus-7", "ball-of-6x12", "ground-of-4-km",
    "spectacles-minus-half",
]  # fmt: skip
"""Those on which the tests hold `raytrace` to the tracer."""
