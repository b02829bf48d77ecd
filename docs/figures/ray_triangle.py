"""The thesis's line drawing of a parametric triangle, as a scene: Figure 3.2."""

from __future__ import annotations

import numpy as np
from figures import diagram as dg
from figures.comparing import EXACT, Drawn, pixels
from figures.configurations import Example
from figures.curves import FINE, TRIANGLE, Single, circled, triangle_scene
from figures.panels import Panel, draw, labelled, places

import anamorph as an

SIZE = (636, 330)
BESIDE = (313, 271)
RAYS = Example(
    corners=np.array([[-0.12, -0.14, -1.5], [0.53, -0.02, -2.3], [0.12, 0.52, -2.7]]),
    origins=np.array([[-0.5, -0.4, 0.0], [0.5, -0.4, 0.0], [0.0, 0.5, 0.0]]),
    directions=np.array([[0.16, -0.20, -1.0], [0.22, 0.25, -1.0], [-0.25, 0.06, -1.0]]),
)
UP = (0.0, 1.0, 0.0)
TOWARD = (1.0, 0.45, 0.75)
"""From the drawing to who looks at it."""
LENGTH = 3.1
LEVELS = (0.0, 1.0, 2.0, 3.0)
"""The t of the triangles that are drawn."""
RADIUS = 0.012
WAYS: tuple[tuple[float, float, float], ...] = ((0.80, 0.02, 0.02), (0.02, 0.42, 0.08), (0.05, 0.16, 0.72))
"""Of the three rays, linear."""


def parametric() -> Drawn:
    """Figure 3.2: three rays, the triangles between them at some t, and a scene triangle; and what is seen of that."""
    origins, directions, corners = RAYS.origins, RAYS.directions, RAYS.corners
    meshes = [
        dg.rods(np.array([[o, o + LENGTH * d]]), RADIUS, color, f"ray-{i}")
        for i, (o, d, color) in enumerate(zip(origins, directions, WAYS, strict=True))
    ]
    for t in LEVELS:
        meshes.append(dg.rods(dg.loop(origins + t * directions), 0.6 * RADIUS, dg.SURFACE, f"t={t:g}"))
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    meshes.append(
        an.Mesh(
            "scene triangle",
            corners.astype(np.float32),
            np.array([[0, 1, 2]], np.int32),
            np.tile(normal / np.linalg.norm(normal), (3, 1)).astype(np.float32),
            colors=np.eye(3, dtype=np.float32),
            material=an.Diffuse((1.0, 1.0, 1.0)),
        )
    )
    page = dg.drawing("ray triangle", meshes, dg.far_camera(np.array([0.0, 0.11, -1.75]), TOWARD, UP, 2.16))
    labels = [
        (f"t = {t:g}", place, "mt")
        for t, place in zip(LEVELS, places(page.camera, SIZE, **lowest()).values(), strict=True)
    ]
    size = (BESIDE[0] * FINE, BESIDE[1] * FINE)
    shown = Single(RAYS, triangle_scene("seen", corners, np.eye(3)), TRIANGLE * size[0], size)
    return [
        [
            Panel(
                labelled(draw(page, "raytrace", SIZE), labels),
                "three rays, the triangles at some t, and a scene triangle",
            ),
            Panel(circled(pixels(shown.draw(EXACT)), shown), "what the rays between see of it"),
        ]
    ], []


def lowest() -> dict[str, np.ndarray]:
    """For each of the levels, a place below its triangle."""
    found = {}
    for t in LEVELS:
        points = RAYS.origins + t * RAYS.directions
        found[f"t{t}".replace(".", "_")] = points[points[:, 1].argmin()] - (0.0, 0.07, 0.0)
    return found
