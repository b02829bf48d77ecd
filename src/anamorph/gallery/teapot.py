"""The Utah teapot: the 32 bicubic Bezier patches of Martin Newell (University of Utah, 1975), as they are known.

Newell's numbers are symmetric, and are kept here as what they are made of: profiles turned about the axis for rim,
body, lid and bottom, and rings mirrored in the middle plane for handle and spout. His units: the pot is 3.15 high.
"""

from __future__ import annotations

import numpy as np

from anamorph.gallery.solids import lattice
from anamorph.scene.model import Material, Mesh
from anamorph.surfaces.bezier import BezierPatch

HEIGHT = 3.15

# Profiles from bottom to top: (radius, height) of four control points.
PROFILES: dict[str, tuple[tuple[tuple[float, float], ...], ...]] = {
    "rim": (((1.5, 2.4), (1.4375, 2.53125), (1.3375, 2.53125), (1.4, 2.4)),),
    "body": (
        ((2.0, 0.9), (2.0, 1.35), (1.75, 1.875), (1.5, 2.4)),
        ((1.5, 0.15), (1.5, 0.225), (2.0, 0.45), (2.0, 0.9)),
    ),
    "lid": (
        ((0.2, 2.7), (0.0, 2.85), (0.8, 3.15), (0.0, 3.15)),
        ((1.3, 2.4), (1.3, 2.55), (0.4, 2.55), (0.2, 2.7)),
    ),
    "bottom": (((0.0, 0.0), (1.425, 0.0), (1.5, 0.075), (1.5, 0.15)),),
}
# Handle and spout, ring by ring: (x, height) of the side that faces the lid, of the other side, and half the breadth.
RINGS: dict[str, tuple[tuple[float, float, float, float, float], ...]] = {
    "handle": (
        (-1.6, 2.025, -1.5, 2.25, 0.3),
        (-2.3, 2.025, -2.5, 2.25, 0.3),
        (-2.7, 2.025, -3.0, 2.25, 0.3),
        (-2.7, 1.8, -3.0, 1.8, 0.3),
        (-2.7, 1.575, -3.0, 1.35, 0.3),
        (-2.5, 1.125, -2.65, 0.9375, 0.3),
        (-2.0, 0.9, -1.9, 0.6, 0.3),
    ),
    "spout": (
        (1.7, 1.425, 1.7, 0.6, 0.66),
        (2.6, 1.425, 3.1, 0.825, 0.66),
        (2.3, 2.1, 2.4, 2.025, 0.25),
        (2.7, 2.4, 3.3, 2.4, 0.25),
        (2.8, 2.475, 3.525, 2.49375, 0.25),
        (2.9, 2.475, 3.45, 2.5125, 0.15),
        (2.8, 2.4, 3.2, 2.4, 0.15),
    ),
}
# A quarter of a circle as Newell drew it; the lid's knob alone has the second number.
ROUND = 0.56
KNOB_RADIUS, KNOB_ROUND = 0.8, 0.5625


def patches() -> list[tuple[str, np.ndarray]]:
    """Name and control points (4, 4, 3) of each of the 32 patches: y up, the spout along +x, normals outside."""
    found = [
        (part, control) for part, profiles in PROFILES.items() for profile in profiles for control in revolved(profile)
    ]
    for part, rings in RINGS.items():
        found += [(part, control) for half in (rings[:4], rings[3:]) for control in mirrored(half)]
    return found


def revolved(profile: tuple[tuple[float, float], ...]) -> list[np.ndarray]:
    """The four patches of a solid of revolution."""
    control = np.zeros((4, 4, 3))
    for row, (radius, height) in enumerate(profile):
        bend = KNOB_ROUND if radius == KNOB_RADIUS else ROUND
        circle = radius * np.array([[1.0, 0.0], [1.0, bend], [bend, 1.0], [0.0, 1.0]])
        control[:, row] = np.stack([circle[:, 0], np.full(4, height), -circle[:, 1]], axis=-1)
    quarter = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    found = [control]
    for _ in range(3):
        found.append(found[-1] @ quarter.T)
    return found


def mirrored(rings: tuple[tuple[float, float, float, float, float], ...]) -> list[np.ndarray]:
    """The two halves of four rings of a tube."""
    front = np.array([[(a, b, 0.0), (a, b, t), (c, d, t), (c, d, 0.0)] for a, b, c, d, t in rings])
    back = front[:, ::-1] * (1.0, 1.0, -1.0)
    return [np.swapaxes(half, 0, 1) for half in (front, back)]


def teapot(
    place: tuple[float, float, float], height: float, turn: float, material: Material, vertices: int
) -> list[Mesh]:
    """Each patch as a mesh of vertices x vertices, the pot standing at `place`, turned by `turn` degrees."""
    cosine, sine = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    rotation = np.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])
    side = np.linspace(0.0, 1.0, vertices)
    v, u = np.meshgrid(side, side, indexing="ij")
    parameters = np.stack([u.ravel(), v.ravel()], axis=-1)
    faces = lattice(vertices, vertices)
    numbers: dict[str, int] = {}
    meshes = []
    for part, control in patches():
        number = numbers[part] = numbers.get(part, -1) + 1
        surface = BezierPatch(control=control @ rotation.T * (height / HEIGHT) + place)
        # Rounded to a nanometre, so that neighbours have the same vertices along the border they share.
        positions = np.round(surface.position(parameters), 9)
        a, b, c = np.moveaxis(positions[faces], 1, 0)
        whole = np.linalg.norm(np.cross(b - a, c - a), axis=1) > 1e-14
        name = f"teapot/{part}-{number}"
        meshes.append(Mesh.exact(name, surface, parameters, faces[whole], material, decimals=9))
    return meshes
