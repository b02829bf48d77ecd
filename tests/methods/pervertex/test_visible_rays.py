"""What is left of a patch in the image: all that the image shows of it, and little more."""

from __future__ import annotations

import numpy as np
import pytest

from anamorph.methods.pervertex.bundle import areas_of
from anamorph.methods.pervertex.visible_rays import AROUND, visible_rays
from anamorph.raymesh import RayMesh, RayStatus

SIZE = (64, 48)


def mesh(image, faces):
    """A ray mesh whose rays tell their place in the image."""
    image = np.asarray(image, float)
    count = len(image)
    return RayMesh(
        image, image.copy(), np.add(image, (0.0, 0.0, 1.0)), np.asarray(faces, np.int32), np.zeros(count, np.uint8)
    )


def test_triangles_inside_the_image_stay_as_they_are():
    rays = mesh([[1, 1, 1], [60, 2, 1], [30, 40, 1], [10, 44, 1]], [[0, 1, 2], [0, 2, 3]])
    shown = visible_rays(rays, np.array([0, 1]), SIZE)
    assert shown.rays.faces.tolist() == [[0, 1, 2], [0, 2, 3]] and shown.parent.tolist() == [0, 1]
    assert shown.rays.image.tolist() == rays.image.tolist()


@pytest.mark.parametrize("far", [100.0, 1e5])
def test_of_a_triangle_larger_than_the_image_the_image_is_left(far):
    rays = mesh([[-far, -far, 1], [3 * far, -far, 1], [0, 3 * far, 1]], [[0, 1, 2]])
    shown = visible_rays(rays, np.array([0]), SIZE)
    area = areas_of(shown.rays.places()[shown.rays.faces]).sum()
    assert area == pytest.approx((SIZE[0] + 2 * AROUND) * (SIZE[1] + 2 * AROUND), rel=1e-6)
    # Rays are linear with the homogeneous place, as they are on a flat mirror.
    assert shown.rays.origins == pytest.approx(shown.rays.image, rel=1e-9)
    assert shown.weights.sum(axis=1) == pytest.approx(np.ones(len(shown.weights)))


def test_what_is_behind_the_eye_is_cut_away():
    rays = mesh([[0, 0, 1], [64, 0, 1], [-40, -30, -1]], [[0, 1, 2]])
    shown = visible_rays(rays, np.array([0]), SIZE)
    assert len(shown.rays.faces) and (shown.rays.image[:, 2] > 0.0).all()


def test_a_triangle_beside_the_image_is_gone():
    rays = mesh([[-90, 0, 1], [-80, 0, 1], [-85, 40, 1]], [[0, 1, 2]])
    assert not len(visible_rays(rays, np.array([0]), SIZE).rays.faces)


def test_a_corner_that_turns_away_tells_so():
    rays = mesh([[-30, 5, 1], [30, 5, 1], [20, 40, 1]], [[0, 1, 2]])
    rays.status[0] = RayStatus.BACK_FACING
    shown = visible_rays(rays, np.array([0]), SIZE)
    assert (shown.rays.status == RayStatus.BACK_FACING).any() and (shown.rays.status == RayStatus.OK).any()
    assert shown.least(np.array([1.0, 2.0, 3.0])).min() == 1.0
