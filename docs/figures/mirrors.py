"""The paper's figures of mirrors that are drawn by the warp itself: Figures 5 to 7, 9 to 11 and 16."""

from __future__ import annotations

from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np

import anamorph as an
from anamorph.frame import View
from anamorph.measure.continuity import continuity
from anamorph.measure.errors import measure
from anamorph.methods.pervertex import Options
from anamorph.output import to_pixels
from anamorph.scene import builtin
from anamorph.scene.builtin.car_mirror import REARWARD, foot, glass, housing, mirror_sphere
from anamorph.scene.builtin.curvature_series import one_mirror
from anamorph.scene.cad import FaceChoice, chosen_faces
from anamorph.scene.placing import replace_mirror
from figures import diagram as dg
from figures.panels import HALF, WARP, Panel, cropped, draw, lined, outlined, shrunk
from figures.warps import warps

THIRD = (313, 235)
LARGE = (960, 720)
STEP = Path(an.__file__).parent / "scene" / "assets" / "aspheric-door-mirror.step"
ANGLES = (REARWARD, (-0.30, -0.03, 1.0))
"""The ways that the door mirror looks in Figure 5."""
PATCHES = np.array(
    [
        (0.80, 0.12, 0.08), (0.06, 0.30, 0.70), (0.90, 0.62, 0.05), (0.10, 0.48, 0.16), (0.48, 0.14, 0.55),
        (0.05, 0.55, 0.58), (0.92, 0.32, 0.05), (0.55, 0.60, 0.62), (0.75, 0.20, 0.40), (0.35, 0.22, 0.08),
    ]
)  # fmt: skip
"""Linear colours of patches."""


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
        scene = builtin.make("car-mirror")
        scene = replace(scene, meshes=tuple(turned.get(mesh.name, mesh) for mesh in scene.meshes))
        scene = replace_mirror(scene, faces, 24, str(STEP.name))
        rows.append([Panel(draw(scene), f"{words}: per-vertex"), Panel(draw(scene, "raytrace", samples=3), "truth")])
    return rows


def subdivision() -> list[list[Panel]]:
    """Figure 6: the patches of the teapot and of the torus, each of which has a map of its own."""
    rows = []
    for name, box in (("room", (150, 190, 790, 670)), ("torus", (200, 60, 760, 480 + 60 - 60))):
        scene = builtin.make(name)
        found = warps(scene, LARGE)
        patches = [warp.mesh(tuple(PATCHES[i % len(PATCHES)]), f"patch-{i}") for i, warp in enumerate(found)]
        rest = tuple(mesh for mesh in scene.meshes if not mesh.specular)
        colored = replace(scene, meshes=(*patches, *rest))
        size = tuple(THIRD)
        rows.append(
            [
                Panel(cropped(draw(colored, size=LARGE), box, size, smooth=True), f"{len(found)} patches"),
                Panel(cropped(draw(scene, size=LARGE), box, size, smooth=True), "per-vertex"),
                Panel(cropped(draw(scene, "raytrace", LARGE), box, size, smooth=True), "truth"),
            ]
        )
    return rows


def continuity_of_two() -> list[list[Panel]]:
    """Figure 7: a mirror of two patches, their maps, and by how much these differ along the border."""
    scene = builtin.make("car-mirror")
    options = Options(field=30.0)
    found = warps(scene, LARGE, options)
    errors = continuity(View(scene, scene.camera, LARGE), options)
    picture = draw(scene, f"{WARP},field=30", LARGE)
    dots = picture.copy()
    for (x, y), pixels in zip(errors.places, errors.pixels, strict=True):
        rows, columns = np.ogrid[: dots.shape[0], : dots.shape[1]]
        dots[(columns + 0.5 - x) ** 2 + (rows + 0.5 - y) ** 2 < 16.0] = false_color(pixels)
    box = (160, 120, 800, 600)
    size = (475, 356)
    stats = errors.in_picture
    words = f"along the border: median {stats.median:.2f}, at most {stats.max:.2f} pixels (dark 0, yellow 1)"
    maps = [
        Panel(fitted(lined(warp.map, warp.mesh_in_map(), (255, 255, 255)), size), f"map {i + 1}, and its patch in it")
        for i, warp in enumerate(found)
    ]
    return [
        [
            Panel(cropped(picture, box, size, smooth=True), f"{len(found)} patches with a map each"),
            Panel(cropped(dots, box, size, smooth=True), words),
        ],
        maps,
    ]


def curvature() -> list[list[Panel]]:
    """Figure 9: mirrors from convex over flat to concave."""
    name = "curvature-series"
    return [[Panel(draw(name, size=(475, 440)), "per-vertex"), Panel(draw(name, "raytrace", (475, 440), 3), "truth")]]


def alignment() -> list[list[Panel]]:
    """Figure 10: the map of a saddle whose axes follow the principal directions of the rays, and one whose do not."""
    scene = builtin.make("saddle")
    truth = an.render(scene, method="raytrace", size=LARGE, seen=True)
    maps = []
    for align, words in ((False, "upright"), (True, "aligned")):
        # One map for the whole saddle, as in the paper.
        options = Options(field=150.0, align=align)
        warp = warps(scene, LARGE, options)[0]
        frame = an.render(scene, method="pervertex", size=LARGE, seen=True, field=150.0, align=align)
        error = measure(truth, frame).pixels
        height, width = warp.map.shape[:2]
        caption = f"{words}: {width} x {height} texels, {100.0 * warp.plan.used:.0f}% used;"
        caption += f"\nerror {error.median:.3f} px (median), {error.p95:.2f} px (95%)"
        maps.append(Panel(fitted(lined(warp.map, warp.mesh_in_map(), (255, 255, 255), 2), (475, 320)), caption))
    return [[Panel(draw(scene), "per-vertex"), Panel(draw(scene, "raytrace", samples=3), "truth")], maps]


def two_bounces() -> list[list[Panel]]:
    """Figure 11: the town in the windows of cars, and these in the door mirror."""
    box = (330, 230, 330 + 240, 230 + 180)
    whole, truth = draw("car-windows", size=LARGE), draw("car-windows", "raytrace", LARGE, 3)
    return [
        [
            Panel(cropped(outlined(whole, box, 3), (0, 0, *LARGE), HALF, smooth=True), "per-vertex"),
            Panel(cropped(truth, (0, 0, *LARGE), HALF, smooth=True), "truth"),
        ],
        [
            Panel(cropped(whole, box, HALF), "enlarged: town, window, mirror"),
            Panel(cropped(truth, box, HALF), "truth, enlarged"),
        ],
    ]


def occlusion() -> list[list[Panel]]:
    """Figure 16: what stands between the virtual viewpoint and what a ray hits, and hides it though the ray passes."""
    scene = one_mirror(3.0)
    truth = an.render(scene, method="raytrace", size=LARGE, seen=True)
    plain = an.render(scene, method="pervertex", size=LARGE, seen=True)
    mended = an.render(scene, method="pervertex", size=LARGE, seen=True, tolerance=0.5)
    wrong = measure(truth, plain).maps.other_object
    still = measure(truth, mended).maps.other_object
    mirror = truth.specular > 0
    grey = to_pixels(truth.color).mean(axis=2, keepdims=True).repeat(3, axis=2) * 0.4 + 140.0
    errors, traced = grey.astype(np.uint8), grey.astype(np.uint8)
    errors[wrong] = (200, 30, 20)
    traced[mirror & (mended.status == an.Status.TRACED)] = (230, 140, 10)
    box, size = (230, 60, 730, 435 + 60 - 60), HALF
    share = 100.0 * (mended.status[mirror] == an.Status.TRACED).mean()
    return [
        [
            Panel(cropped(to_pixels(plain.color), box, size, smooth=True), "per-vertex: its bezel hides the room's edges"),
            Panel(cropped(errors, box, size, smooth=True), f"red: shows another thing, {100 * wrong[mirror].mean():.2f}% of the mirror"),
        ],
        [
            Panel(cropped(traced, box, size, smooth=True), f"orange: found doubtful and traced, {share:.1f}%"),
            Panel(cropped(to_pixels(mended.color), box, size, smooth=True), f"tolerance=0.5: {100 * still[mirror].mean():.2f}% show another thing"),
        ],
    ]


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
