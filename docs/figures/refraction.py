"""The paper's figures of lenses: Figures 12 to 15."""

from __future__ import annotations

from dataclasses import replace

from figures.panels import HALF, WARP, Panel, cropped, draw, outlined

import anamorph as an
from anamorph import gallery
from anamorph.gallery.lenses import EYE, GAZE, PLUS, rim
from anamorph.lenses.making import worn_lens
from anamorph.optics.dispersion import line_indices

INDICES = (1.60, 1.62)
"""Of red and of blue light in Figure 15."""


def spectacles() -> list[list[Panel]]:
    """Figure 12: a convex and a concave spectacle lens."""
    named = (("spectacles-plus", "+6 D"), ("spectacles-minus", "-6 D"))
    return [
        [Panel(draw(scene), f"{words}, per-vertex"), Panel(draw(scene, "raytrace", samples=3), f"{words}, truth")]
        for scene, words in named
    ]


def reversed_image() -> list[list[Panel]]:
    """Figure 13: a lens beyond whose focus the street stands on its head."""
    return [
        [Panel(draw("magnifier"), "per-vertex"), Panel(draw("magnifier", "raytrace", samples=3), "truth")],
    ]


def overlay() -> list[list[Panel]]:
    """Figure 14: the balls at the hits of the refracted rays, seen through the lens at its vertices."""
    size = (2375, 1780)
    pixels = draw("spectacles-minus", f"{WARP},overlay=mesh", size)
    box = (600, 690, 600 + 475, 690 + 356)
    whole = cropped(outlined(pixels, box, 14), (0, 0, *size), HALF, smooth=True)
    return [[Panel(whole, "the lens's mesh, and balls at the hits"), Panel(cropped(pixels, box, HALF), "enlarged")]]


def dispersion() -> list[list[Panel]]:
    """Figure 15: a convex lens whose index is 1.60 for red light and 1.62 for blue."""
    scene, words = chromatic()
    size, box = (1900, 1424), (560, 170, 560 + 475, 170 + 356)
    fringed, reference = draw(scene, size=size, samples=1), draw(scene, "raytrace", size, samples=2)
    whole = cropped(outlined(fringed, box, 9), (0, 0, *size), HALF, smooth=True)
    return [
        [Panel(whole, words), Panel(draw(scene, "raytrace:dispersion=false"), "truth with one index")],
        [
            Panel(cropped(fringed, box, HALF), "per-vertex, enlarged"),
            Panel(cropped(reference, box, HALF), "truth, enlarged"),
        ],
    ]


def chromatic() -> tuple[an.Scene, str]:
    """The scene `spectacles-plus` with a glass of the wanted indices, and these in words.

    Where between red and blue the d line lies is not free: Cauchy's formula says it.
    """
    red, blue = INDICES
    low, middle, high = line_indices(1.6, 60.0)
    index = red + (blue - red) * (middle - low) / (high - low)
    abbe = (index - 1.0) / (blue - red)
    scene = gallery.make("spectacles-plus")
    lens = worn_lens(replace(PLUS, index=index, abbe=abbe), EYE, GAZE)
    rest = tuple(mesh for mesh in scene.meshes if not mesh.specular and mesh.name not in ("lens/rim", "lens/edge"))
    material = next(mesh.material for mesh in scene.meshes if mesh.name == "lens/rim")
    mount = rim(lens, GAZE, 0.0012).mesh("lens/rim", material)
    indices = line_indices(index, abbe)
    words = "per-vertex; n = " + ", ".join(f"{n:.3f}" for n in indices) + f" (Abbe number {abbe:.1f})"
    return replace(scene, meshes=(*lens.meshes, mount, *rest)), words
