"""The figures of the paper on multi-perspective images, appendix F of the thesis: 3 to 6, and 9 to 14."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from figures import diagram as dg
from figures.beside_teapot import placed
from figures.panels import HALF, Panel

import anamorph as an
from anamorph import cameras, gallery
from anamorph.base.output import to_pixels
from anamorph.gallery.animals import bunny
from anamorph.gallery.cube import CAMERA, cube_scene
from anamorph.gallery.solids import cylinder, grid, join
from anamorph.gallery.statue import statue
from anamorph.gallery.textures import checkerboard
from anamorph.gallery.torus import torus_surface
from anamorph.methods import Specification
from anamorph.raymesh import RayMesh
from anamorph.surfaces.bezier import BezierPatch
from anamorph.viewer.turntable import orbit

THIRD = (313, 313)
WIDE = (960, 320)
METHOD = "trilinear:antialias=4"

RIM, EDGE, TOP = (1.4, -0.7), (2.2, 0.4, -0.8), (2.4, 3.1)
"""Control points over the cube, metres: x or z, and y, of the corners, of others at the rim, and of the inner four."""

COLUMNS = [(x, z) for x in (-3.0, 0.0, 3.0) for z in (-3.0, 0.0, 3.0) if x or z]
RING = torus_surface((0.0, 1.9, 0.0), np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]), 1.4, 0.35)
"""A ring that lies level among the columns."""


def seen(
    scene: an.Scene, rays: RayMesh | None, size: tuple[int, int], method: str | Specification = METHOD
) -> np.ndarray:
    """A scene through a ray mesh, or as its own camera has it, smooth, as pixels."""
    return to_pixels(an.render(scene, method, rays, size, samples=2).color)


def dome() -> BezierPatch:
    """The patch of Figure 10: 16 control points over the cube, typed in by hand as in the paper."""
    (corner, foot), (far, beside, low), (inner, top) = RIM, EDGE, TOP
    control = np.empty((4, 4, 3))
    for i, x in enumerate((-1, -1, 1, 1)):
        for j, z in enumerate((1, 1, -1, -1)):
            if i in (0, 3) and j in (0, 3):
                control[i, j] = corner * x, foot, corner * z
            elif i in (1, 2) and j in (1, 2):
                control[i, j] = inner * x, top, inner * z
            elif i in (0, 3):
                control[i, j] = far * x, low, beside * z
            else:
                control[i, j] = beside * x, low, far * z
    return BezierPatch(control)


def cube_world() -> list[list[Panel]]:
    """Figures 9 to 11: the cube, the surface over it, and what that sees: five of the cube's sides."""
    scene, patch = cube_scene(), dome()
    coarse = cameras.from_surface(patch, THIRD, inward=True, rows=12, columns=12)
    outside = replace(CAMERA, position=(-4.6, 5.2, 8.2), target=(0.0, 1.1, 0.0), field_of_view=40.0)
    lines = np.stack([coarse.origins, coarse.origins + 0.35 * coarse.directions], axis=1)
    net = coarse.origins.reshape(13, 13, 3)
    threads = [np.stack([each[:-1], each[1:]], axis=1) for each in (*net, *net.swapaxes(0, 1))]
    shown = replace(
        scene,
        camera=outside,
        meshes=(
            *scene.meshes,
            dg.rods(np.concatenate(threads), 0.012, dg.SURFACE, "net"),
            dg.rods(lines, 0.007, dg.REFLECTED, "rays"),
            dg.balls(list(patch.control.reshape(-1, 3)), 0.05, dg.VIEWPOINT, "control points"),
        ),
    )
    fine = cameras.from_surface(patch, THIRD, inward=True, rows=40, columns=40)
    return [
        [
            Panel(seen(scene, None, THIRD, "raytrace:antialias=4"), "9: the cube in perspective"),
            Panel(
                seen(shown, None, THIRD, "raytrace:antialias=4"),
                "10: the surface over it, its\ncontrol points and some rays",
            ),
            Panel(seen(scene, fine, THIRD), "11: seen from that surface:\nfive sides of the cube"),
        ]
    ]


def amounts() -> list[list[Panel]]:
    """Figures 12 to 14: perspective, none, and reversed; and half way between them."""
    words = {
        1.0: "12: amount 1, perspective",
        0.5: "0.5",
        0.0: "13: amount 0, orthographic",
        -0.5: "-0.5",
        -1.0: "14: amount -1, reversed",
    }
    size = (236, 236)
    panels = [
        Panel(seen(cube_scene(), cameras.perspective(CAMERA, size, amount), size), said)
        for amount, said in words.items()
    ]
    return [panels[:3], panels[3:]]


def columns() -> list[list[Panel]]:
    """Figures 5 and 6: columns as an eye sees them, and from a ring among them."""
    colors = ((0.70, 0.10, 0.07), (0.86, 0.80, 0.66), (0.08, 0.22, 0.62), (0.80, 0.55, 0.06))
    shafts = [cylinder(0.35, 3.8, 24).moved(x, 0.0, z).painted(colors[n % 4]) for n, (x, z) in enumerate(COLUMNS)]
    board = an.Diffuse((1.0, 1.0, 1.0), checkerboard(128, 2, (208, 204, 190), (96, 110, 112)))
    room = gallery.make("torus")
    scene = replace(
        room,
        meshes=(
            join(shafts).mesh("columns", an.Diffuse((1.0, 1.0, 1.0))),
            grid((-6, 0, 6), (12, 0, 0), (0, 0, -12), (12, 12), (0, 0, 6, 6)).mesh("floor", board),
        ),
        camera=an.Camera((2.2, 3.6, 8.5), (0.0, 1.6, 0.0), field_of_view=48.0),
    )
    rays = cameras.from_surface(RING, HALF, window=((0.0, 4.0), (-0.9, 0.9)), rows=24, columns=96)
    return [
        [
            Panel(seen(scene, None, HALF, "raytrace:antialias=4"), "5: columns, in perspective"),
            Panel(seen(scene, rays, HALF), "6: the same from a level ring among them"),
        ]
    ]


def strips() -> list[list[Panel]]:
    """Figures 3 and 4: an animal from one side to the other, and a head from all around."""
    hall = gallery.make("torus")
    animal = placed(bunny(), "bunny", (0.0, 0.0, 0.0), 0.0, 1.0)
    person = placed(statue(), "statue", (0.0, 0.0, 0.0), 0.0, 1.0)
    ahead = an.Camera((0.0, 0.62, 2.6), (0.0, 0.52, 0.0), field_of_view=26.0)
    around = orbit(ahead, 16)
    half = [*around[11:], *around[:6]]
    head = orbit(an.Camera((0.0, 1.12, -0.9), (0.0, 1.12, 0.0), field_of_view=20.0), 16)
    size = (475, 320)
    drawn = (
        (animal, cameras.strip(half, size, 4), "3: a bunny, from its right side to its left"),
        (person, cameras.strip([*head, head[0]], size, 4), "4: a head from all sides"),
    )
    return [[Panel(seen(replace(hall, meshes=(mesh,)), rays, size), words) for mesh, rays, words in drawn]]


def street() -> list[list[Panel]]:
    """Ours: one side of the town's street, from an eye that goes along its other side."""
    views = [an.Camera((2.5, 1.7, z), (-6.0, 2.6, z), field_of_view=50.0) for z in (19.5, 6.5, -6.5, -19.5)]
    scene = gallery.make("car-mirror")
    names = ("own-car", "mirror", "housing")
    town = replace(
        scene, meshes=tuple(mesh for mesh in scene.meshes if not mesh.name.startswith(names) and not mesh.specular)
    )
    rays = cameras.strip(views, WIDE, 16)
    plain = replace(town, camera=replace(views[1], field_of_view=50.0))
    return [
        [Panel(seen(town, rays, WIDE), "39 m of the street, seen on the way along it")],
        [Panel(seen(plain, None, WIDE, "raytrace:antialias=4"), "from one place of that way")],
    ]
