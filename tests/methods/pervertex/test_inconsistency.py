"""The overlays: what of an image with a pole before its mirror or behind its lens is doubted, against the truth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import CAMERA, SIZE, drawn, open_view, pixels_of, scene_with, spherical_mirror, surroundings

from anamorph.base.errors import AnamorphError
from anamorph.frame import View
from anamorph.gallery.solids import box, grid
from anamorph.lenses.making import make_lens
from anamorph.lenses.prescription import Prescription
from anamorph.measure.errors import measure, silhouettes
from anamorph.methods.pervertex import Options
from anamorph.methods.pervertex.inconsistency import inconsistent_vertices
from anamorph.methods.pervertex.pervertex import PerVertexDrawing
from anamorph.methods.stage import Stage
from anamorph.scene.camera import Camera
from anamorph.scene.model import Diffuse, Scene

IMAGE = (400, 300)
POLE = box((0.02, 0.0, 0.28), (0.05, 1.2, 0.31)).mesh("pole", Diffuse((0.9, 0.7, 0.1)))


def with_pole(mirror, camera=CAMERA, pole=POLE):
    scene = scene_with(mirror, camera=camera)
    return replace(scene, meshes=(*scene.meshes, pole))


def lens_with_pole():
    """A strong lens, a pole close behind it, and the boxes beyond."""
    camera = Camera((0.15, 0.56, -0.2), (0.0, 0.5, 0.0), field_of_view=20.0)
    lens = make_lens(Prescription(-8.0, diameter=50.0), (0.0, 0.5, 0.0), (0.0, 0.0, 1.0), vertices=61)
    pole = box((0.004, 0.0, 0.05), (0.008, 1.0, 0.054)).mesh("pole", Diffuse((0.9, 0.7, 0.1)))
    return Scene("lens", (*lens.meshes, pole, *surroundings()), camera)


def vertices_of(scene):
    return scene.meshes[0].positions


def marked_and_wrong(scene, options):
    """Pixels away from silhouettes and vertices: those marked, those that show what is off their ray, and the others.

    Between an error of 0.8 and one of 1.2 pixels they are neither. What stands before the shown point on the ray itself
    is no fragment's to know.
    """
    reference, plain = drawn(scene, "raytrace", IMAGE), drawn(scene, f"pervertex:map=image,{options}", IMAGE)
    shown = drawn(scene, f"pervertex:map=image,{options},overlay=inconsistency", IMAGE)
    assert (shown.position == plain.position).all() and (shown.status == plain.status).all()
    errors = measure(reference, plain)
    rows, columns = np.mgrid[: IMAGE[1], : IMAGE[0]] + 0.5
    counted = errors.maps.specular & ~silhouettes(reference.object_id, reference.specular) & (plain.specular > 0)
    # A lens's edge, which is seen through the glass, is not in the map.
    counted &= ~np.isin(reference.object_id, [i + 1 for i, mesh in enumerate(scene.meshes) if "edge" in mesh.name])
    for x, y in pixels_of(scene.camera, IMAGE, vertices_of(scene)):
        counted &= np.hypot(columns - x, rows - y) > 5.0
    marked = np.abs(shown.color - plain.color).max(axis=-1) > 1e-3
    other = reference.object_id != plain.object_id
    wrong, right = errors.maps.pixels > 1.2, (errors.maps.pixels < 0.8) & ~other
    assert counted.sum() > 5000
    return marked[counted], wrong[counted], right[counted]


@pytest.mark.parametrize("options", ["", "antialias=4"])
def test_before_a_mirror_what_is_wrong_is_marked_and_little_else(options):
    marked, wrong, right = marked_and_wrong(with_pole(spherical_mirror()), options)
    assert wrong.sum() >= 20
    assert marked[wrong].mean() >= 0.98
    assert marked[right].mean() <= 0.002


def test_behind_a_lens_what_is_wrong_is_marked_and_little_else():
    scene = lens_with_pole()
    marked, wrong, right = marked_and_wrong(scene, "projective=false")
    assert wrong.sum() >= 100
    assert marked[wrong].mean() >= 0.95
    assert marked[right].mean() <= 0.025


def test_the_sky_hides_nothing():
    """The lines of a nearly flat mirror's map leave its depth range long before the sky."""
    marked, _, right = marked_and_wrong(scene_with(spherical_mirror(-4.0, 16)), "")
    assert marked[right].mean() <= 0.001


def test_before_a_concave_mirror_the_near_map_is_asked_too():
    pole = box((0.12, 0.0, 0.28), (0.15, 1.2, 0.31)).mesh("pole", Diffuse((0.9, 0.7, 0.1)))
    marked, wrong, right = marked_and_wrong(with_pole(spherical_mirror(-1.4, 16), pole=pole), "")
    assert wrong.sum() >= 100
    assert marked[wrong].mean() >= 0.95
    # The pole stands near the crossing of the rays, where what the map sees beside it may be behind it.
    assert marked[right].mean() <= 0.12


def in_the_way(starts, ends, low, high):
    """Whether segments (N, 3) pass through a box, by its three slabs."""
    crossings = np.stack([low - starts, high - starts]) / (ends - starts)
    first, last = crossings.min(axis=0).max(axis=1), crossings.max(axis=0).min(axis=1)
    return (first < last) & (first > 0.0) & (first < 0.999)


@pytest.mark.parametrize("radius", [1.0, 1.4, -1.4])
def test_a_vertex_is_inconsistent_where_something_stands_between_the_viewpoint_and_its_hit(radius):
    wall = grid((60.0, -60.0, 3.0), (-120.0, 0.0, 0.0), (0.0, 120.0, 0.0)).mesh("wall", Diffuse())
    camera = Camera((0.8, 0.65, 0.5), (0.0, 0.5, 0.0), field_of_view=32.0)

    known = np.zeros(25 * 25, bool)

    def planned(*others):
        scene = Scene("wall", (spherical_mirror(radius, 24), wall, *others), camera)
        drawing = PerVertexDrawing(Stage(View(scene, camera, SIZE)), Options(field=150.0))
        (seen,) = drawing.plan(camera).seen
        (plan,) = seen.plans
        point = plan.viewpoint[:3] / plan.viewpoint[3]
        known[plan.vertices[(plan.lookups[0, :, 3] > 0.0) & (seen.body_rays.rays.status[plan.vertices] == 0)]] = True
        along = (point - seen.hits) / (point - seen.hits)[:, 2:]
        # Where the line through the viewpoint passes the mirror.
        return seen, drawing.surroundings, seen.hits + (0.02 - seen.hits[:, 2:]) * along

    # A box around the line of that vertex whose ray passes farthest from it.
    seen, around, starts = planned()
    assert not inconsistent_vertices(seen, around).any()
    ray, line = (first + (0.3 - first[:, 2:]) / (seen.hits - first)[:, 2:] * (seen.hits - first)
                 for first in (seen.body_rays.rays.origins, starts))  # fmt: skip
    ahead = (np.abs(ray) < 1.0).all(axis=1) & (np.abs(line) < 1.0).all(axis=1)
    apart = np.where(known & ahead, np.abs(ray - line)[:, :2].max(axis=1), 0.0)
    middle, half = line[apart.argmax()], 0.3 * apart.max()
    low, high = middle - half, middle + half
    seen, around, starts = planned(box(tuple(low), tuple(high)).mesh("box", Diffuse()))
    expected = known & in_the_way(starts, seen.hits, low, high)
    assert expected.any()
    assert inconsistent_vertices(seen, around).tolist() == expected.tolist()


def test_balls_tell_which_vertices_are_consistent():
    scene = with_pole(spherical_mirror(-1.4))
    stage = Stage(View(scene, CAMERA, IMAGE))
    drawing = PerVertexDrawing(stage, Options())
    (seen,) = drawing.plan(CAMERA).seen
    hidden = inconsistent_vertices(seen, drawing.surroundings)
    frame = drawn(scene, "pervertex:map=image,overlay=inconsistency", IMAGE)
    places = pixels_of(CAMERA, IMAGE, vertices_of(stage.view.scene))
    visible = np.array([frame.specular[int(y), int(x)] > 0 for x, y in places])
    colors = np.array([frame.color[int(y), int(x)] for x, y in places])
    blue = (colors[:, 2] > 3.0 * colors[:, 0]) & (colors[:, 2] > 3.0 * colors[:, 1])
    white = np.ptp(colors, axis=1) < 0.01 * colors.max(axis=1)
    assert (hidden & visible).sum() >= 3
    assert blue[hidden & visible].all() and not blue[~hidden & visible].any()
    assert white[~hidden & visible].mean() > 0.9


@pytest.mark.parametrize("overlay", ["true", "True", "wires", "", "mesh "])
def test_an_overlay_has_a_name(overlay):
    with pytest.raises(AnamorphError, match=r"overlay.*give none, mesh or inconsistency") as caught:
        method = f"pervertex:overlay={overlay}x" if overlay.endswith(" ") else f"pervertex:overlay={overlay}"
        open_view(scene_with(spherical_mirror()), method)
    assert "\n" not in str(caught.value)
