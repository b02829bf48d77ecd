"""Which reflection points and refraction points nothing hides, against the reference's pixels."""

from __future__ import annotations

import numpy as np
import pytest
from lens_scenes import MINUS, PLUS, lens_of, scene_of
from scenes import SIZE, drawn, scene_with, spherical_mirror

from anamorph.frame import Status
from anamorph.gallery import make
from anamorph.gallery.solids import box
from anamorph.reflections.open_paths import visible
from anamorph.reflections.reflection_points import reflection_points
from anamorph.reflections.refraction_points import refraction_points
from anamorph.scene.model import Diffuse, Scene


def searched(
    scene: Scene, points: np.ndarray, size: tuple[int, int] = SIZE
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of each reflection point its point's number, its pixel, and whether it is visible."""
    found = reflection_points(scene, scene.camera, points, size)
    assert (found.image[:, 2] > 0.0).all()
    return found.point, found.image[:, :2] / found.image[:, 2:], visible(scene, scene.camera, points, found, size)


@pytest.mark.parametrize(("radius", "cells"), [(1.4, 8), (-0.6, 8), (0.5, 2)])
def test_a_pixel_that_sees_a_point_in_a_mirror_is_one_of_those_that_show_it(radius, cells):
    scene = scene_with(spherical_mirror(radius, cells))
    frame = drawn(scene, "raytrace:bounces=1")
    rows, columns = np.nonzero((frame.specular == 1) & (frame.object_id > 0) & (frame.status == Status.TRACED))
    point, pixels, seen = searched(scene, frame.position[rows, columns].astype(float))
    away = np.linalg.norm(pixels - np.column_stack([columns, rows])[point] - 0.5, axis=1)
    # The points are float32, and one of a concave mirror's may be magnified.
    own = np.bincount(point[(away < 0.02)], minlength=len(rows))
    shown = np.bincount(point[(away < 0.02) & seen], minlength=len(rows))
    # At the very border, it is rounding that tells whether there is one.
    assert len(rows) > 1000 and (own == 1).mean() > 0.999 and (shown == own).mean() > 0.999


def test_a_visible_place_is_where_the_image_shows_that_point():
    scene, size = make("torus"), (480, 360)
    frame = drawn(scene, "raytrace:bounces=1", size)
    rows, columns = (each[::29] for each in np.nonzero((frame.object_id > 0) & (frame.status != Status.OUTSIDE)))
    points = frame.position[rows, columns].astype(float)
    point, pixels, seen = searched(scene, points, size)
    x, y = pixels.astype(int).T
    around = [np.s_[y + down, x + right] for down in (-1, 0, 1) for right in (-1, 0, 1)]
    # Away from silhouettes, a pixel and those around it see one object, but for what is smaller than a pixel.
    here = frame.object_id[y, x]
    even = np.all([(frame.specular[each] == 1) & (frame.object_id[each] == here) for each in around], axis=0)
    same = here == frame.object_id[rows, columns][point]
    assert (seen & even).sum() > 1000 and (seen & even & ~same).sum() < 0.02 * (seen & even).sum()
    away = np.linalg.norm(frame.position[y, x] - points[point], axis=1)
    spread = np.max([np.linalg.norm(frame.position[each] - frame.position[y, x], axis=1) for each in around], axis=0)
    assert (away <= spread)[seen & even & same].all()
    # What is hidden there is not seen there.
    assert (~seen & even).sum() > 300 and (away > 1e-2)[~seen & even].all()


@pytest.mark.parametrize("prescription", [MINUS, PLUS], ids=["minus", "plus"])
def test_a_pixel_that_sees_a_point_through_a_lens_is_one_of_those_that_show_it(prescription):
    scene, size = scene_of(lens_of(prescription)), (120, 90)
    frame = drawn(scene, "raytrace:bounces=2", size)
    # The third object is the band around the lens, which is seen from within.
    rows, columns = np.nonzero((frame.specular == 2) & (frame.object_id > 3) & (frame.status == Status.TRACED))
    points = frame.position[rows, columns].astype(float)
    found = refraction_points(scene, scene.camera, points, size)
    seen = visible(scene, scene.camera, points, found, size)
    away = np.linalg.norm(
        found.image[:, :2] / found.image[:, 2:] - np.column_stack([columns, rows])[found.point] - 0.5, axis=1
    )
    own = np.bincount(found.point[away < 0.02], minlength=len(rows))
    shown = np.bincount(found.point[(away < 0.02) & seen], minlength=len(rows))
    assert len(rows) > 1000 and (own == 1).mean() > 0.999 and (shown == own).mean() > 0.999
    # What stands before the lens, or behind it, hides them all.
    for depth in (0.5, 0.3):
        wall = box((-0.5, 0.0, depth), (0.5, 1.0, depth + 0.01)).mesh("obstacle", Diffuse())
        hidden = Scene("hidden", (*scene.meshes, wall), scene.camera)
        beyond = points[:, 2] < 0.2
        assert not visible(hidden, scene.camera, points, found, size)[beyond[found.point]].any() and beyond.sum() > 500
