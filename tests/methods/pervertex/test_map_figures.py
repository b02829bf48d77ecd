"""What `pervertex` tells of its maps, against twins made from its plans."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import CAMERA, SIZE, drawn, flat_mirror, scene_with, sky_scene, spherical_mirror

from anamorph import gallery
from anamorph.frame import View
from anamorph.methods.pervertex import Options
from anamorph.methods.pervertex.pervertex import PerVertexDrawing
from anamorph.methods.stage import Stage
from anamorph.scene.camera import Camera


def covered(seen):
    """The share of each plan's map that lies in some triangle: by points on a grid, (plans,)."""
    shares = []
    x, y = np.meshgrid(*2 * [(np.arange(200) + 0.5) / 200.0])
    for plan, faces in zip(seen.plans, seen.patches, strict=True):
        corners = np.searchsorted(plan.vertices, seen.body_rays.rays.faces[faces])
        s, t = (plan.lookups[0, :, :2] / plan.lookups[0, :, 2:3]).T
        inside = np.zeros(x.shape, bool)
        for a, b, c in corners:
            sides = [(s[j] - s[i]) * (y - t[i]) - (t[j] - t[i]) * (x - s[i]) for i, j in ((a, b), (b, c), (c, a))]
            inside |= np.all(np.array(sides) > 0.0, axis=0) | np.all(np.array(sides) < 0.0, axis=0)
        shares.append(inside.mean())
    return shares


@pytest.mark.parametrize(("mirror", "field"), [(flat_mirror(), 100.0), (spherical_mirror(0.5), 30.0)])
def test_the_figures_are_those_of_the_plans(mirror, field):
    scene = scene_with(mirror)
    drawing = PerVertexDrawing(Stage(View(scene, CAMERA, SIZE)), Options(field=field))
    (seen,) = drawing.plan(CAMERA).seen
    figures = drawing.figures()
    assert figures["maps"] == len(seen.plans) >= (1 if field == 100.0 else 3)
    texels = [max(int(plan.texels[0][0]), 16) * max(int(plan.texels[0][1]), 16) for plan in seen.plans]
    assert figures["map_texels"] == sum(texels)
    assert figures["maps_used_percent"] == pytest.approx(100.0 * np.average(covered(seen), weights=texels), abs=1.5)
    assert drawn(scene, f"pervertex:map=image,field={field}").figures == figures


def test_they_are_of_the_last_frame_alone():
    scene = scene_with(spherical_mirror())
    drawing = PerVertexDrawing(Stage(View(scene, CAMERA, SIZE)), Options())
    drawing.plan(CAMERA)
    first = drawing.figures()
    drawing.plan(CAMERA)
    assert drawing.figures() == first
    drawing.plan(Camera((0.0, 0.5, -3.0), (0.0, 0.5, -9.0)))
    assert drawing.figures() == {"maps": 0.0, "map_texels": 0.0}


def test_alignment_leaves_less_of_a_map_unused():
    saddle = gallery.make("saddle")
    used = {}
    for align in (False, True):
        drawing = PerVertexDrawing(Stage(View(saddle, saddle.camera, (512, 384))), Options(align=align))
        drawing.plan(saddle.camera)
        used[align] = drawing.figures()
    assert used[True]["maps_used_percent"] > 1.1 * used[False]["maps_used_percent"]
    assert used[True]["map_texels"] < used[False]["map_texels"]


def test_other_methods_tell_nothing():
    for method in ("raytrace", "environment"):
        assert drawn(sky_scene(spherical_mirror()), method).figures == {}
