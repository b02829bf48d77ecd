"""The thesis's figures of the numbered cube: Figures 6.3 to 6.9 by cameras made by hand, 7.4 to 7.6 by optics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from figures.comparing import Compared, Drawn, compared, in_words, pixels, table_row
from figures.panels import Panel, shrunk

import anamorph as an
from anamorph.cameras import detail_and_context, inward_sphere, multi_perspective, refracting_plane
from anamorph.gallery.cube import CAMERA, FRONT, LEFT, cube_scene
from anamorph.gallery.cube_mirrors import cube_in_sphere, cube_in_wavy_mirror
from anamorph.raymesh import RayMesh

SQUARE = (800, 800)
WIDE = (900, 300)
MAP = (600, 600)
"""Sizes in table 8.1."""
SPHERE_RADIUS = 2.0
"""Of the sphere around the cube, metres."""
HALF, THIRD = (475, 475), (313, 313)
MANY = 100
"""Quads across that stand for a ray that is bent at every pixel."""


def pair(found: Compared, words: str, size: tuple[int, int]) -> list[Panel]:
    """Traced and projected, with what they differ by."""
    same = f"projected: {in_words(found.traced, found.errors)}"
    return [Panel(shrunk(pixels(found.traced), size), words), Panel(shrunk(pixels(found.exact), size), same)]


def perspective() -> Drawn:
    """Figures 6.3 and 6.4: the cube as a camera sees it, and with its middle magnified."""
    scene, rays = cube_scene(), detail_and_context(CAMERA, SQUARE)
    found = compared(scene, rays, SQUARE)
    plain = pixels(an.render(scene, method="raytrace", size=SQUARE, seen=True))
    traced, projected = pair(found, "6.4 (a): a ray for every pixel", THIRD)
    projected = replace(projected, caption="6.4 (b): " + projected.caption.replace(": ", "\n", 1))
    return [[Panel(shrunk(plain, THIRD), "6.3: in perspective"), traced, projected]], [
        table_row("6.4", len(rays.faces), found)
    ]


def two_views() -> Drawn:
    """Figure 6.7: from the left and from the front, and between them the way from one to the other."""
    rays = multi_perspective(LEFT, FRONT, WIDE)
    found = compared(cube_scene(), rays, WIDE)
    return [[panel] for panel in pair(found, "(a): a ray for every pixel", WIDE)], [
        table_row("6.7", len(rays.faces), found)
    ]


def mapping() -> Drawn:
    """Figure 6.9: a map of the cube, from a sphere around it."""
    scene = replace(cube_scene(), meshes=cube_scene().meshes[:1])
    rays = inward_sphere((0.0, 0.0, 0.0), SPHERE_RADIUS, MAP)
    found = compared(scene, rays, MAP)
    return [pair(found, "(a): a ray for every pixel", HALF)], [table_row("6.9", len(rays.faces), found)]


def series(figure: str, original: an.Frame, drawn: Mapping[int, tuple[an.Scene, RayMesh | None]]) -> Drawn:
    """Figures 7.4 and 7.6: (a) the reference, then (b) to (f) by ray meshes of 1 x 1 to 5 x 5 quads."""
    panels = [Panel(shrunk(pixels(original), THIRD), "(a): rays bent at every pixel")]
    table = []
    for letter, (quads, (scene, rays)) in zip("bcdef", drawn.items(), strict=True):
        found = compared(scene, rays, SQUARE, original)
        assert found.original
        words = f"({letter}): {quads} x {quads} quads, projected\nfrom (a): {in_words(original, found.original)}"
        panels.append(Panel(shrunk(pixels(found.exact), THIRD), words))
        table.append(table_row(f"{figure} ({letter})", 2 * quads**2, found))
    return [panels[:3], panels[3:]], table


def on_a_sphere() -> Drawn:
    """Figure 7.4: reflected by a part of a ball."""
    original = an.render(cube_in_sphere(), method="raytrace:bounces=1", size=SQUARE, seen=True)
    return series("7.4", original, {quads: (cube_in_sphere(quads, exact=False), None) for quads in range(1, 6)})


def wavy() -> Drawn:
    """Figure 7.5: reflected by a plane whose normals are turned at random."""
    scene = cube_in_wavy_mirror()
    original = an.render(scene, method="raytrace:bounces=1", size=SQUARE, seen=True)
    found = compared(scene, None, SQUARE, original)
    assert found.original
    near = in_words(found.traced, found.errors).replace(", ", ",\n")
    same = f"along the mesh's own rays, traced;\n(b) from this: {near}"
    return [
        [
            Panel(shrunk(pixels(original), THIRD), "(a): rays bent at every pixel"),
            Panel(shrunk(pixels(found.traced), THIRD), same),
            Panel(
                shrunk(pixels(found.exact), THIRD), f"(b): projected\nfrom (a): {in_words(original, found.original)}"
            ),
        ]
    ], [table_row("7.5 (b)", 50, found)]


def refracted() -> Drawn:
    """Figure 7.6: refracted by a plane whose normals meet in a point."""
    scene = cube_scene()
    many = refracting_plane(CAMERA, SQUARE, MANY)
    original = an.render(scene, camera=many, method="raytrace", size=SQUARE, seen=True)
    drawn = {quads: (scene, refracting_plane(CAMERA, SQUARE, quads)) for quads in range(1, 6)}
    return series("7.6", original, drawn)
