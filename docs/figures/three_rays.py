"""The drawings of the paper on three-ray cameras, of what this package computes: Figures 3 and 4."""

from __future__ import annotations

import numpy as np
from figures import diagram as dg
from figures.panels import Panel, draw, labelled, places

import anamorph as an
from anamorph.gallery.solids import lathe
from anamorph.optics.reflection import reflected_rays, reflector
from anamorph.raytriangle import project_points, switches

SIZE = (475, 440)
UP = (0.0, 1.0, 0.0)
RED, GREEN, GREY = (0.80, 0.02, 0.02), (0.02, 0.42, 0.08), (0.10, 0.12, 0.14)
WAYS: tuple[tuple[float, float, float], ...] = ((0.85, 0.45, 0.02), (0.02, 0.42, 0.52), (0.30, 0.10, 0.60))
"""Of three rays, linear."""

GLASS = (
    (0.0, 0.0), (0.36, 0.0), (0.34, 0.03), (0.10, 0.07), (0.055, 0.16), (0.05, 0.36), (0.06, 0.52), (0.16, 0.60),
    (0.30, 0.72), (0.37, 0.88), (0.385, 1.04), (0.36, 1.20), (0.32, 1.34),
)  # fmt: skip
"""Radius and height of the glass, metres."""
AROUND = 18
EYE = np.array([-0.7, 1.7, 3.4])
LENGTH = 0.75
"""Of the rays that are drawn, metres."""
SHOWN = (0.68, 0.80, 0.98, 1.12, 1.26, 0.30)
"""Heights at which the camera that faces the eye most is shown, metres."""

ORIGINS = np.array([[-0.5, -0.3, 0.0], [0.5, -0.3, 0.0], [0.0, 0.55, 0.0]])
DIRECTIONS = np.array([[-0.43, 0.61, -0.66], [0.61, 0.0, -0.79], [-0.17, 0.20, -0.96]])
"""A camera that sees some points twice."""
DIRECTIONS /= np.linalg.norm(DIRECTIONS, axis=1, keepdims=True)
SWEPT = np.linspace(0.0, 4.0, 17)
BETWEEN = (0.3, 0.7)
"""Where in the interval in which points may be seen twice the two triangles are that intersect."""


def glass() -> list[list[Panel]]:
    """Figure 3: the construction rays of some cameras of a glass-shaped reflector."""
    solid = lathe(GLASS, AROUND, 180.0)
    camera = an.Camera((float(EYE[0]), float(EYE[1]), float(EYE[2])), (0.0, 0.8, 0.0), UP, 30.0)
    rays = reflected_rays(reflector(solid.mesh("glass", an.Mirror())), camera.eye(SIZE))
    ways, corners = rays.unit_directions(), rays.origins[rays.faces]
    outward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    middle = corners.mean(axis=1)
    facing = np.einsum("fi,fi->f", outward, EYE - middle)
    chosen = []
    for number, height in enumerate(SHOWN):
        side = 0.5 * np.sin(2.4 * number)
        worth = facing - 6.0 * np.abs(middle[:, 1] - height) - 2.0 * np.abs(middle[:, 0] - side * 0.5)
        chosen.append(int(worth.argmax()))
    vertices = rays.faces[chosen]
    starts = rays.origins[vertices].reshape(-1, 3)
    lifted = corners[chosen] + 0.004 * outward[chosen][:, None]
    meshes = [
        solid.mesh("glass", an.Diffuse((0.70, 0.78, 0.84))),
        dg.rods(dg.edges(solid.mesh("glass", an.Diffuse())), 0.0022, dg.SURFACE, "edges"),
        *(dg.sheet(triangle, GREY, f"camera {number}") for number, triangle in enumerate(lifted)),
        dg.rods(np.stack([starts, starts + LENGTH * ways[vertices].reshape(-1, 3)], axis=1), 0.005, RED, "rays"),
    ]
    side = dg.far_camera(np.array([0.1, 0.85, 0.25]), (1.0, 0.12, 0.25), UP, 2.0)
    return [
        [
            Panel(draw(dg.drawing("glass", meshes, camera), "raytrace", SIZE), "from the eye"),
            Panel(draw(dg.drawing("glass", meshes, side), "raytrace", SIZE), "from the side, the eye is at the left"),
        ]
    ]


def sweeping() -> list[list[Panel]]:
    """Figure 4: the view volume as a sweeping triangle, and instances of it that intersect."""
    t, real = switches(ORIGINS, DIRECTIONS)
    ahead = np.sort(t[real & (t > 0.0)])
    first, last = float(ahead[0]), float(ahead[-1])
    camera = dg.far_camera(np.array([0.0, 0.82, -2.0]), (1.0, 0.28, 0.45), UP, 4.5)
    rays = [
        dg.rods(np.array([[o, o + SWEPT[-1] * d]]), 0.014, color, f"ray {i}")
        for i, (o, d, color) in enumerate(zip(ORIGINS, DIRECTIONS, WAYS, strict=True))
    ]
    outlines = [dg.rods(dg.loop(ORIGINS + at * DIRECTIONS), 0.006, dg.SURFACE, f"t={at:g}") for at in SWEPT[1:]]
    base = dg.sheet(ORIGINS, (0.45, 0.52, 0.58), "base")
    swept = dg.drawing("sweeping triangle", [*rays, *outlines, base], camera)

    instances = [first + share * (last - first) for share in BETWEEN]
    triangles = [ORIGINS + at * DIRECTIONS for at in instances]
    both = common(*triangles)
    inside = both[0] + np.linspace(0.02, 0.98, 25)[:, None] * (both[1] - both[0])
    least = int(project_points(ORIGINS, DIRECTIONS, inside).seen.sum(axis=1).min())
    pieces = np.stack([ORIGINS + first * DIRECTIONS, ORIGINS + last * DIRECTIONS], axis=1)
    crossing = dg.drawing(
        "two instances",
        [
            *rays,
            base,
            *(
                dg.sheet(corners, color, f"instance {i}")
                for i, (corners, color) in enumerate(
                    zip(triangles, ((0.50, 0.62, 0.86), (0.94, 0.78, 0.40)), strict=True)
                )
            ),
            dg.rods(pieces, 0.03, RED, "interval"),
            dg.rods(both[None], 0.03, GREEN, "both"),
        ],
        camera,
    )
    at = places(camera, SIZE, one=triangles[0][0], other=triangles[1][0])
    labels = [(f"t = {t:.2f}", (x - 14, y), "rm") for t, (x, y) in zip(instances, at.values(), strict=True)]
    return [
        [
            Panel(draw(swept, "raytrace", SIZE), "the base (grey) sweeps along the three rays"),
            Panel(
                labelled(draw(crossing, "raytrace", SIZE), labels, 15),
                f"red: t in [{first:.2f}, {last:.2f}], where rays change sides\n"
                f"green: in both triangles, so each point is seen {least} times",
            ),
        ]
    ]


def common(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """The ends (2, 3) of the line that two triangles (3, 3) have in common."""
    ends = np.array([*_through(one, other), *_through(other, one)])
    way = ends[1] - ends[0]
    order = np.argsort((ends - ends[0]) @ way)
    return ends[order[1:3]]


def _through(corners: np.ndarray, plane: np.ndarray) -> list[np.ndarray]:
    """Where the sides of a triangle pass through another's plane."""
    height = (corners - plane[0]) @ np.cross(plane[1] - plane[0], plane[2] - plane[0])
    found = []
    for a in range(3):
        b = (a + 1) % 3
        if (height[a] < 0.0) != (height[b] < 0.0):
            found.append(corners[a] + height[a] / (height[a] - height[b]) * (corners[b] - corners[a]))
    return found
