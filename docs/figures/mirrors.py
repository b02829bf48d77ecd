"""The paper's figures of mirrors that are drawn by the warp itself: Figures 5 to 7, 9 to 11 and 16."""

from __future__ import annotations

from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from figures import diagram as dg
from figures.panels import HALF, WARP, Panel, cropped, draw, labelled, lined, outlined, places, shrunk
from figures.warps import warps

import anamorph as an
from anamorph import gallery
from anamorph.base.output import to_pixels
from anamorph.files.cad import chosen_faces
from anamorph.files.own_mirror import replace_mirror
from anamorph.files.source import FaceChoice
from anamorph.frame import View
from anamorph.gallery.car_mirror import REARWARD, foot, glass, housing, mirror_sphere
from anamorph.gallery.curvature_series import RADII, one_mirror
from anamorph.measure.angles import normalized
from anamorph.measure.continuity import continuity
from anamorph.measure.errors import measure
from anamorph.methods.pervertex import Options

THIRD = (313, 235)
LARGE = (960, 720)
STEP = Path(an.__file__).parent / "gallery" / "assets" / "aspheric-door-mirror.step"
ANGLES = (REARWARD, (-0.30, -0.03, 1.0))
"""The ways that the door mirror looks in Figure 5."""
PATCHES = np.array(
    [
        (0.80, 0.12, 0.08), (0.06, 0.30, 0.70), (0.90, 0.62, 0.05), (0.10, 0.48, 0.16), (0.48, 0.14, 0.55),
        (0.05, 0.55, 0.58), (0.92, 0.32, 0.05), (0.55, 0.60, 0.62), (0.75, 0.20, 0.40), (0.35, 0.22, 0.08),
    ]
)  # fmt: skip
"""Linear colours of patches."""
BRIGHT = 0.2
"""Pixels of continuity error that are drawn yellow."""


def cad() -> list[list[Panel]]:
    """Figure 5: the STEP mirror at two angles; nothing where no CAD reader is installed."""
    if find_spec("OCP") is None:
        return []
    faces = chosen_faces(STEP, FaceChoice())
    rows = []
    for rearward, words in zip(ANGLES, ("first angle", "turned outward"), strict=True):
        sphere = mirror_sphere(rearward)
        turned = {
            "mirror": glass(sphere),
            "housing": housing(sphere).mesh("housing", an.Diffuse((1.0, 1.0, 1.0))),
            "housing/foot": foot(sphere).mesh("housing/foot", an.Diffuse((1.0, 1.0, 1.0))),
        }
        scene = gallery.make("car-mirror")
        scene = replace(scene, meshes=tuple(turned.get(mesh.name, mesh) for mesh in scene.meshes))
        scene = replace_mirror(scene, faces, 24, str(STEP.name))
        rows.append([Panel(draw(scene), f"{words}: per-vertex"), Panel(draw(scene, "raytrace", samples=3), "truth")])
    return rows


def subdivision() -> list[list[Panel]]:
    """Figure 6: the patches of the teapot and of the torus, each of which has a map of its own."""
    rows = []
    for name, box in (("room", (150, 190, 790, 670)), ("torus", (155, 80, 775, 545))):
        scene = gallery.make(name)
        found = warps(scene, LARGE)
        patches = [warp.mesh(tuple(PATCHES[i % len(PATCHES)]), f"patch-{i}") for i, warp in enumerate(found)]
        rest = tuple(mesh for mesh in scene.meshes if not mesh.specular)
        colored = replace(scene, meshes=(*patches, *rest))
        rows.append(
            [
                Panel(cropped(draw(colored, size=LARGE), box, THIRD, smooth=True), f"{len(found)} patches"),
                Panel(cropped(draw(scene, size=LARGE), box, THIRD, smooth=True), "per-vertex"),
                Panel(cropped(draw(scene, "raytrace", LARGE), box, THIRD, smooth=True), "truth"),
            ]
        )
    return rows


def continuity_of_two() -> list[list[Panel]]:
    """Figure 7: a mirror of two patches, their maps, and by how much these differ along the border."""
    scene = gallery.make("car-mirror")
    options = Options(field=32.0)
    found = warps(scene, LARGE, options)
    errors = continuity(View(scene, scene.camera, LARGE), options)
    image = draw(scene, f"{WARP},field={options.field:g}", LARGE)
    dots = image.copy()
    rows, columns = np.ogrid[: dots.shape[0], : dots.shape[1]]
    for (x, y), pixels in zip(errors.places, errors.pixels, strict=True):
        away = (columns + 0.5 - x) ** 2 + (rows + 0.5 - y) ** 2
        dots[away < 49.0] = 255
        dots[away < 30.0] = false_color(pixels / BRIGHT)
    named = [f"{name} {_typical(name)}" for name in ("torus", "room", "saddle")]
    words = f"along the border, {_typical('car-mirror', options)} px"
    words += f"\n(dark 0, yellow {BRIGHT:g} px and more; 960 x 720)"
    maps = [
        fitted(lined(warp.map, warp.mesh_in_map(), (255, 255, 255), 2), size)
        for warp, size in zip(found, ((475, 300), (240, 300)), strict=True)
    ]
    return [
        [
            Panel(cropped(image, (0, 0, *LARGE), HALF, smooth=True), "two patches with a map each"),
            Panel(cropped(dots, (0, 0, *LARGE), HALF, smooth=True), words),
        ],
        [
            Panel(maps[0], "map 1, and its patch in it"),
            Panel(maps[1], "map 2"),
            Panel(np.full((300, 225, 3), 255, np.uint8), ""),
        ],
        [Panel(np.full((1, 960, 3), 255, np.uint8), "other scenes, px: " + ";  ".join(named))],
    ]


def _typical(name: str, options: Options | None = None) -> str:
    """The continuity error of a scene in words."""
    scene = gallery.make(name)
    errors = continuity(View(scene, scene.camera, LARGE), options)
    found = errors.in_image
    return f"median {found.median:.2f}, {100.0 * (errors.pixels < 1.0).mean():.0f}% < 1"


def curvature() -> list[list[Panel]]:
    """Figure 9: mirrors from convex over flat to concave."""
    scene, size = gallery.make("curvature-series"), (475, 450)
    plates = {
        f"R{i}": next(mesh for mesh in scene.meshes if mesh.name == f"stand-{i + 1}/label").positions.mean(axis=0)
        for i in range(len(RADII))
    }
    at = places(scene.camera, size, **plates)
    labels = [
        ("flat" if np.isinf(radius) else f"R = {radius:+g} m", at[f"R{i}"], "mm") for i, radius in enumerate(RADII)
    ]
    drawn = draw(scene, size=size), draw(scene, "raytrace", size)
    return [
        [
            Panel(labelled(pixels, labels, 15), words)
            for pixels, words in zip(drawn, ("per-vertex", "truth"), strict=True)
        ]
    ]


def alignment() -> list[list[Panel]]:
    """Figure 10: the map of a saddle whose axes follow the principal directions of the rays, and one whose do not."""
    scene = gallery.make("saddle")
    reference = an.render(scene, method="raytrace", size=LARGE, seen=True)
    maps = []
    for align, words in ((False, "upright"), (True, "aligned")):
        # One map for the whole saddle, as in the paper.
        options = Options(field=150.0, align=align)
        warp = warps(scene, LARGE, options)[0]
        frame = an.render(scene, method="pervertex:map=image", size=LARGE, seen=True, field=150.0, align=align)
        error = measure(reference, frame).pixels
        height, width = warp.map.shape[:2]
        caption = f"{words}: {width} x {height} texels, {100.0 * warp.plan.used:.0f}% used;"
        caption += f"\nerror {error.median:.3f} px (median), {error.p95:.2f} px (95%)"
        maps.append(Panel(fitted(lined(warp.map, warp.mesh_in_map(), (255, 255, 255), 2), (475, 320)), caption))
    return [[Panel(draw(scene), "per-vertex"), Panel(draw(scene, "raytrace", samples=3), "truth")], maps]


def two_bounces() -> list[list[Panel]]:
    """Figure 11: the town in the windows of cars, and these in the door mirror."""
    box = (400, 300, 400 + 240, 300 + 180)
    whole, reference = draw("car-windows", size=LARGE), draw("car-windows", "raytrace", LARGE, 3)
    return [
        [
            Panel(cropped(outlined(whole, box, 4), (0, 0, *LARGE), HALF, smooth=True), "per-vertex"),
            Panel(cropped(reference, (0, 0, *LARGE), HALF, smooth=True), "truth"),
        ],
        [
            Panel(cropped(whole, box, HALF), "enlarged: town, window, mirror"),
            Panel(cropped(reference, box, HALF), "truth, enlarged"),
        ],
    ]


def occlusion() -> list[list[Panel]]:
    """Figure 16: what stands between the virtual viewpoint and what a ray hits, and hides it though the ray passes."""
    scene = _with_rod(one_mirror(4.0))
    reference = an.render(scene, method="raytrace", size=LARGE, seen=True)
    # One map for the whole mirror, as in the paper.
    plain = an.render(scene, method="pervertex:map=image,field=150", size=LARGE, seen=True)
    mended = an.render(scene, method="pervertex:field=150", size=LARGE, seen=True, tolerance=0.5)
    wrong = measure(reference, plain).maps.other_object
    still = measure(reference, mended).maps.other_object
    assert reference.specular is not None and mended.status is not None
    mirror = reference.specular > 0
    grey = to_pixels(reference.color).mean(axis=2, keepdims=True).repeat(3, axis=2) * 0.4 + 140.0
    errors, traced = grey.astype(np.uint8), grey.astype(np.uint8)
    errors[wrong] = (200, 30, 20)
    traced[mirror & (mended.status == an.Status.TRACED)] = (230, 140, 10)
    box = (230, 60, 730, 435)
    share = 100.0 * (mended.status[mirror] == an.Status.TRACED).mean()

    def part(pixels: np.ndarray) -> np.ndarray:
        return cropped(pixels, box, HALF, smooth=True)

    return [
        [
            Panel(part(to_pixels(plain.color)), "per-vertex: near things hide what is beside them"),
            Panel(part(errors), f"red: shows another thing, {100.0 * wrong[mirror].mean():.2f}% of the mirror"),
        ],
        [
            Panel(part(traced), f"orange: found doubtful and traced, {share:.1f}%"),
            Panel(
                part(to_pixels(mended.color)), f"tolerance=0.5: {100.0 * still[mirror].mean():.2f}% show another thing"
            ),
        ],
    ]


def _with_rod(scene: an.Scene) -> an.Scene:
    """The scene with an upright rod close before its mirror."""
    mirror = next(mesh for mesh in scene.meshes if mesh.name == "mirror-1")
    middle, outward = mirror.positions.mean(axis=0, dtype=float), normalized(mirror.normals.mean(axis=0, dtype=float))
    up = np.array([0.0, 1.0, 0.0])
    foot = middle + 0.05 * outward + 0.05 * np.cross(up, outward)
    rod = dg.rods(np.stack([[foot - 0.3 * up, foot + 0.3 * up]]), 0.006, (0.1, 0.3, 0.9), "rod")
    return replace(scene, meshes=(*scene.meshes, rod))


def false_color(pixels: float) -> np.ndarray:
    """From dark (0) to yellow (1 pixel and more), (3,) uint8."""
    stops = np.array([(68, 1, 84), (59, 82, 139), (33, 145, 140), (94, 201, 98), (253, 231, 37)], float)
    place = 4.0 * min(max(pixels, 0.0), 1.0)
    low = min(int(place), 3)
    return np.round(stops[low] + (place - low) * (stops[low + 1] - stops[low])).astype(np.uint8)


def fitted(pixels: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Pixels shrunk to fit into `size`, on white."""
    height, width = pixels.shape[:2]
    scale = min(size[0] / width, size[1] / height)
    small = shrunk(pixels, (round(width * scale), round(height * scale)))
    page = np.full((small.shape[0], size[0], 3), 255, np.uint8)
    page[:, : small.shape[1]] = small
    return page
