"""The continuity error along patch borders: nought where optics says so, and else what a twin written here finds."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from scenes import CAMERA, CENTER, SIZE, flat_mirror, pixels_of, scene_with, sky_scene, spherical_mirror

from anamorph import gallery
from anamorph.frame import View
from anamorph.gallery.solids import grid
from anamorph.measure.continuity import border_errors, continuity
from anamorph.methods.pervertex import Options
from anamorph.methods.pervertex.pervertex import PerVertexDrawing
from anamorph.methods.stage import Stage
from anamorph.scene.model import Diffuse, Scene

ALL = np.linspace(0.0, 1.0, 9)
WALL = 3.0
DIVIDED = Options(field=15.0)


def before_a_wall(mirror, camera=CAMERA):
    """Where every ray meets one plane: nothing hides anything."""
    wall = grid((60.0, -60.0, WALL), (-120.0, 0.0, 0.0), (0.0, 120.0, 0.0)).mesh("wall", Diffuse())
    return Scene("wall", (mirror, wall), camera)


def slopes_to_the_wall(points, radius):
    """The sines of the angles between the wall and the rays that a sphere reflects at points (N, 3)."""
    normals = (points - (CENTER - [0.0, 0.0, radius])) / radius
    incident = points - np.asarray(CAMERA.position)
    reflected = incident - 2.0 * np.sum(incident * normals, axis=1, keepdims=True) * normals
    return np.abs(reflected[:, 2]) / np.linalg.norm(reflected, axis=1)


def planned(scene, options=DIVIDED):
    drawing = PerVertexDrawing(Stage(View(scene, scene.camera, SIZE)), options)
    return drawing.plan(scene.camera).seen, drawing.surroundings


def test_patches_of_a_flat_mirror_agree_everywhere():
    flat = grid((-0.2, 0.35, 0.0), (0.4, 0.0, 0.0), (0.0, 0.3, 0.0), (6, 5)).mesh("mirror", flat_mirror().material)
    errors = continuity(View(scene_with(flat), CAMERA, SIZE), Options(field=10.0), ALL)
    assert errors.edges >= 10 and errors.left_out == 0
    assert len(errors.points) == 9 * errors.edges
    assert errors.angular_mrad.max() < 1e-8
    assert errors.pixels.max() < 1e-8


@pytest.mark.parametrize("radius", [0.5, -0.3])
def test_patches_agree_at_the_vertices_that_they_share_and_not_between(radius):
    scene = before_a_wall(spherical_mirror(radius))
    errors = continuity(View(scene, CAMERA, SIZE), DIVIDED, ALL)
    assert errors.edges >= 10
    ends = (errors.along == 0.0) | (errors.along == 1.0)
    # Where a ray meets the wall, rounding counts more the less steep the ray is.
    slope = slopes_to_the_wall(errors.points, radius)
    assert (slope * errors.pixels)[ends].max() < 1e-6 < 1e-3 < (slope * errors.pixels)[~ends].max()
    assert (slope * errors.angular_mrad)[ends].max() < 1e-5 < 1e-2 < (slope * errors.angular_mrad)[~ends].max()
    assert pixels_of(CAMERA, SIZE, errors.points) == pytest.approx(errors.places, abs=1e-6)


def test_the_borders_that_are_measured_are_those_that_are_drawn():
    scene = gallery.make("car-mirror")
    seen, surroundings = planned(scene)
    drawn = border_errors(seen, surroundings, SIZE)
    errors = continuity(View(scene, scene.camera, SIZE), DIVIDED)
    assert errors.edges == drawn.edges > 10
    assert errors.points == pytest.approx(drawn.points, abs=1e-9)


def on_the_wall(plan, lookups):
    """The points of the wall that the map shows at lookups (N, 4): two rows of its matrix and the wall's equation."""
    clip = plan.projections[0].clip
    found = []
    for s, t, q, _ in lookups:
        x, y = 2.0 * s / q - 1.0, 1.0 - 2.0 * t / q
        rows = np.stack([clip[0] - x * clip[3], clip[1] - y * clip[3], [0.0, 0.0, 1.0, -WALL]])
        found.append(np.linalg.solve(rows[:, :3], -rows[:, 3]))
    return np.array(found)


def middles(seen):
    """At each shared edge's middle: the point between its ends, and what the two patches show of the wall."""
    edges = [
        {tuple(sorted(edge)) for face in seen.body_rays.rays.faces[faces] for edge in combinations(face, 2)}
        for faces in seen.patches
    ]
    for one, other in combinations(range(len(edges)), 2):
        for ends in sorted(edges[one] & edges[other]):
            shown = []
            for plan in (seen.plans[one], seen.plans[other]):
                rows = plan.lookups[0, np.searchsorted(plan.vertices, ends)]
                shown.append(on_the_wall(plan, [0.5 * rows.sum(axis=0)])[0])
            yield seen.body_rays.rays.origins[list(ends)].mean(axis=0), *shown


def seen_on_the_wall(sphere, places):
    """Which points of the wall the exact mirror shows at image places (N, 2)."""
    lines = CAMERA.directions(places, SIZE)
    offset = np.array(CAMERA.position) - sphere.center
    half = lines @ offset
    points = CAMERA.position + (-half - np.sqrt(half**2 - offset @ offset + sphere.radius**2))[:, None] * lines
    normals = (points - sphere.center) / sphere.radius
    reflected = lines - 2.0 * np.sum(lines * normals, axis=1, keepdims=True) * normals
    return points + ((WALL - points[:, 2]) / reflected[:, 2])[:, None] * reflected


def test_the_errors_between_are_those_of_a_twin():
    mirror = spherical_mirror(0.5)
    seen, around = planned(before_a_wall(mirror))
    errors = border_errors(seen, around, SIZE, np.array([0.5]))
    twin = {tuple(np.round(point, 9)): shown for point, *shown in middles(seen[0])}
    assert errors.edges == len(twin) == len(errors.points)
    expected_angle, expected_pixels = [], []
    for point, place in zip(errors.points, errors.places, strict=True):
        first, second = twin[tuple(np.round(point, 9))]
        a, b = ((each - point) / np.linalg.norm(each - point) for each in (first, second))
        expected_angle.append(1e3 * np.arcsin(np.linalg.norm(np.cross(a, b))))
        here, right, below = seen_on_the_wall(mirror.surface, place + np.array([[0.0, 0.0], [0.1, 0.0], [0.0, 0.1]]))
        per_pixel = np.stack([right - here, below - here], axis=1)[:2] / 0.1
        expected_pixels.append(np.linalg.norm(np.linalg.solve(per_pixel, (second - first)[:2])))
    assert errors.angular_mrad == pytest.approx(expected_angle, rel=1e-3, abs=1e-4)
    large = np.array(expected_pixels) > 1e-3
    assert large.sum() > 5
    # A face's rays change by one and the same step from vertex to vertex, the sphere's do not.
    assert errors.pixels[large] == pytest.approx(np.array(expected_pixels)[large], rel=0.35)


def test_the_sky_counts_by_its_direction():
    scene = sky_scene(spherical_mirror(0.5))
    errors = continuity(View(scene, CAMERA, SIZE), DIVIDED, ALL)
    # What is infinitely far is the same from every viewpoint, but for the length at which vertex rays end.
    assert errors.edges > 10
    assert 0.0 < errors.angular_mrad.max() < 0.1
    assert 0.0 < errors.pixels.max() < 0.1
    # Where one patch shows the sky and the other what stands before it, they show much the same direction.
    errors = continuity(View(scene_with(spherical_mirror(0.5, 16)), CAMERA, SIZE), DIVIDED, ALL)
    assert 1.0 < errors.angular_mrad.max() < 100.0


def test_meshes_that_touch_are_one_surface():
    """The same mirror in two halves, each with vertices of its own along the seam."""
    whole = spherical_mirror(0.5)
    left = np.asarray(whole.positions)[whole.faces][..., 0].mean(axis=1) < 0.0
    halves = [replace(whole, name=name, faces=whole.faces[side]) for name, side in (("a", left), ("b", ~left))]
    one = continuity(View(before_a_wall(whole), CAMERA, SIZE), DIVIDED)
    wall = before_a_wall(whole).meshes[1]
    two = continuity(View(Scene("halves", (*halves, wall), CAMERA), CAMERA, SIZE), DIVIDED)
    assert two.edges == one.edges > 0
    assert np.sort(two.pixels) == pytest.approx(np.sort(one.pixels), rel=1e-3, abs=1e-6)


def test_one_patch_has_no_border():
    for scene in (before_a_wall(spherical_mirror(5.0)), before_a_wall(spherical_mirror(), CAMERA)):
        errors = continuity(View(scene, CAMERA, SIZE), Options(field=100.0))
        assert errors.edges == errors.left_out == len(errors.points) == 0
        assert errors.angular.max is errors.in_image.median is None
    nothing = border_errors([], None, SIZE)
    assert nothing.edges == 0 and nothing.places.shape == (0, 2)


def test_an_edge_without_a_place_in_a_map_is_counted_and_left_out():
    seen, around = planned(before_a_wall(spherical_mirror(0.5)))
    before = border_errors(seen, around, SIZE)
    plan = seen[0].plans[0]
    plan.lookups[0, :, 3] = 0.0
    after = border_errors(seen, around, SIZE)
    assert before.left_out == 0 < after.left_out < after.edges == before.edges
    assert len(after.points) == len(before.points) - 8 * after.left_out
