"""Points projected on the device, in float32, against float64.

"Equal" means: u and v within 1e-3 pixels of an image where the ray triangle is 800 pixels wide. It is asked of every
root inside the ray triangle that is well placed: the cubic's derivative, over the length of the ray's direction and the
square of the parametric triangle's longest side, is at least 1e-4 (it is 0 on a caustic, and where the parametric
triangle is a line), the parametric triangle is no smaller than 1e-6 of the coordinates that it comes from, and t is at
most 1e5 in units of the scene. Where both are small, what two floats lose is divided by both: then no more is asked
than that.
"""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from ray_triangles import KINDS, NEARLY, WITHIN, points_for, ray_triangle, well_placed

from anamorph.base.errors import AnamorphError
from anamorph.raytriangle import on_device, project_points
from anamorph.raytriangle.on_device import project_points_on_device


def nearest(result, other):
    """How far (K, N, 3) the nearest valid root of `other` is from each root of `result`, in u or v."""
    off = [np.abs(one[..., :, None] - two[..., None, :]) for one, two in ((result.u, other.u), (result.v, other.v))]
    return np.where(other.valid[..., None, :], np.maximum(*off), np.inf).min(axis=-1)


def assert_equal(p, n, points):
    """That both find the same roots in ray triangles (K, 3, 3); the share of inside ones that are not well placed."""
    reference, found = project_points(p, n, points), project_points_on_device(p, n, points)
    assert not (found.valid & ~found.real).any()
    assert (found.real[..., :-1] | ~found.real[..., 1:]).all()
    assert (np.diff(found.t, axis=-1)[found.real[..., 1:]] >= 0.0).all()
    assert not found.u[~found.valid].any() and not found.v[~found.valid].any() and not found.t[~found.real].any()
    asked, told = zip(well_placed(p, n, reference), well_placed(p, n, found), strict=True)
    for one, other, placed, within in ((reference, found, asked[0], told[0]), (found, reference, asked[1], told[1])):
        here = one.inside & placed
        off = nearest(one, other)[here] / within[here]
        assert len(off) > 0 and off.max() <= 1.0
    # As many roots, in and near the ray triangle, for points all of whose roots are well placed.
    counts = [
        ((np.abs(one.u - 0.5) < 1.5) & (np.abs(one.v - 0.5) < 1.5) & one.valid).sum(axis=-1)
        for one in (reference, found)
    ]
    whole = (asked[0] | ~reference.valid).all(axis=-1) & (asked[1] | ~found.valid).all(axis=-1)
    assert whole.any() and (counts[0] == counts[1])[whole].all()
    same = reference.inside & found.inside & asked[0] & (np.abs(reference.u - found.u) < WITHIN)
    size = np.abs(reference.t) + np.abs(p - p.mean(axis=1, keepdims=True)).max(axis=(1, 2))[:, None, None]
    assert (np.abs(reference.t - found.t) / np.maximum(size, 1e-300))[same].max() < 1e-6
    return 1.0 - asked[0][reference.inside].mean()


@pytest.mark.parametrize("away", [0.0, 1000.0])
def test_random_roots_are_equal_and_hardly_any_is_left_out(away):
    random = np.random.default_rng(3)
    p, n = random.uniform(-1, 1, (2, 20, 3, 3))
    weights, which = random.dirichlet([1, 1, 1], 2000), random.integers(0, 20, 2000)
    along = random.uniform(0, 10, (2000, 1))
    points = np.einsum("nk,nki->ni", weights, p[which]) + along * np.einsum("nk,nki->ni", weights, n[which])
    assert assert_equal(p + away, n, points + away) <= 1e-3


def test_narrow_beams_are_equal():
    # As a mirror's: rays a few centimetres apart, converging behind the waist or not.
    random = np.random.default_rng(4)
    middle = random.uniform(-0.5, 0.5, (20, 1, 3))
    p = middle + 0.03 * random.uniform(-1, 1, (20, 3, 3))
    n = np.array([0, 0, 1.0]) - (p - middle) * random.uniform(-3, 3, (20, 1, 1)) + 0.01 * random.normal(size=p.shape)
    weights, which = random.dirichlet([1, 1, 1], 1000), random.integers(0, 20, 1000)
    along = random.uniform(0, 10, (1000, 1))
    points = np.einsum("nk,nki->ni", weights, p[which]) + along * np.einsum("nk,nki->ni", weights, n[which])
    assert assert_equal(p, n, points) <= 2e-3


@pytest.mark.parametrize("kind", KINDS)
def test_degenerate_ray_triangles_are_equal(kind):
    random = np.random.default_rng(KINDS.index(kind))
    rays, points = [], []
    for nearly in [*NEARLY, *NEARLY]:
        rays.append(ray_triangle(kind, nearly, random))
        points.append(points_for(*rays[-1], nearly, random))
    p, n = np.moveaxis(np.array(rays), 1, 0)
    assert_equal(p, n, np.concatenate(points))


def test_a_pinhole_sees_each_point_once_by_the_ray_to_it():
    eye = np.array([0.3, -0.2, 5.0])
    p = np.array([[-1.0, -1.0, 0.0], [2.0, -1.0, 0.2], [0.0, 2.0, -0.1]])
    weights = np.random.default_rng(6).dirichlet([1, 1, 1], 500)
    for n in (p - eye, 0.2 * (eye - p)):
        far = np.random.default_rng(7).uniform(0.1, 3.0, (500, 1))
        result = project_points_on_device(p, n, weights @ p + far * (weights @ n))
        sees = np.abs(far[:, 0] - 5.0) > 1e-3
        assert (result.valid.sum(axis=1) == 1)[sees].all()
        assert result.u[:, 0][sees] == pytest.approx(weights[sees, 1], abs=WITHIN)
        assert result.v[:, 0][sees] == pytest.approx(weights[sees, 2], abs=WITHIN)
        assert result.t[:, 0][sees] == pytest.approx(far[sees, 0], rel=1e-6)


def test_rays_with_no_triangle_between_them_and_points_in_all_planes_project_nothing():
    p = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    n = np.array([[0.0, 1.0, 1.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]])
    assert not project_points_on_device(p, n, np.array([[0.0, 1.0, 1.0], [0.3, 0.4, 0.5]])).real.any()
    flat = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]])
    within = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]])
    result = project_points_on_device(flat, within, np.array([[0.3, 0.2, 1.0], [0.3, 0.2, 1.5]]))
    assert not result.real.any() and not result.t.any()


def test_the_two_sides_of_an_origin_are_told_apart_even_where_t_counts_from_a_distant_waist():
    p = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]])
    n = np.array([0.0, 0.0, 0.7]) - 0.0999 * p
    weights = np.array([0.3, 0.3, 0.4])
    for t in (1e-9, -1e-9, 1e-8, -1e-8):
        result = project_points_on_device(p, n, (weights @ p + t * (weights @ n))[None])
        nearest_origin = np.abs(result.t[result.inside]).argmin()
        assert result.t[result.inside][nearest_origin] == pytest.approx(t, rel=1e-3)


def test_a_point_on_a_caustic_is_reported_twice_near_it_and_not_at_all_beyond():
    p = np.array([[0.0, 0.0, 0.0], [1.0, -1.0, 0.0], [0.0, 0.0, 1.0]])
    n = np.array([[1.0, 0.0, 0.0], [1.0, 2.0, 0.0], [1.0, 0.0, 0.0]])
    top = np.array([2.0, 0.75 * 1.5, 0.0])
    depths = np.array([1e-3, 1e-5, 1e-8, -1e-5, -1e-3])
    points = top - depths[:, None] * np.array([0.0, 1.0, 0.0])
    result, reference = project_points_on_device(p, n, points), project_points(p, n, points)
    assert result.valid.sum(axis=1).tolist() == [2, 2, 2, 0, 0] == reference.valid.sum(axis=1).tolist()
    assert result.u == pytest.approx(reference.u, abs=1e-4)


def test_where_all_rays_cross_one_line_a_point_on_it_has_one_ray_and_one_in_the_same_plane_none():
    p = np.array([[0.1, 1.0, -2.0], [0.3, -1.0, -1.0], [-0.4, 0.2, -1.5]])
    n = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.0, 0.0]]) - p
    points = np.array([[0.5, 0.0, 0.0], [0.25, 0.0, 0.0], [0.5, 0.1, 0.3]])
    result, reference = project_points_on_device(p, n, points), project_points(p, n, points)
    at_line = result.valid & (np.abs(result.t - 1.0) < 1e-6)
    assert at_line.sum(axis=1).tolist() == [1, 1, 0]
    assert result.u[at_line] == pytest.approx([1 / 3, 1 / 12], abs=1e-6)
    assert (result.valid == reference.valid).all() and result.u == pytest.approx(reference.u, abs=1e-6)


def test_many_ray_triangles_are_projected_as_one_by_one_and_in_blocks(monkeypatch):
    random = np.random.default_rng(5)
    p, n = random.normal(size=(2, 7, 3, 3))
    points = random.normal(size=(50, 3))
    together = project_points_on_device(p, n, points)
    assert together.t.shape == together.valid.shape == (7, 50, 3)
    for k in range(7):
        alone = project_points_on_device(p[k], n[k], points)
        assert alone.t.shape == (50, 3)
        assert (alone.valid == together.valid[k]).all()
        assert alone.u == pytest.approx(together.u[k], rel=1e-6, abs=1e-6)
    for size in (16, 120):
        monkeypatch.setattr(on_device, "BLOCK", size)
        for name, array in vars(project_points_on_device(p, n, points)).items():
            assert (array == getattr(together, name)).all(), name


def test_nothing_projects_to_nothing():
    p, n = np.eye(3), np.ones((3, 3))
    assert project_points_on_device(p, n, np.zeros((0, 3))).t.shape == (0, 3)
    assert project_points_on_device(p[None][:0], n[None][:0], np.zeros((4, 3))).valid.shape == (0, 4, 3)


@pytest.mark.parametrize(
    ("p", "n", "points", "said"),
    [
        (np.eye(3), np.zeros((3, 3)), np.zeros((1, 3)), "all three directions are 0"),
        (np.full((3, 3), np.nan), np.eye(3), np.zeros((1, 3)), "finite"),
        (np.eye(3), np.eye(3), np.array([[0.0, np.inf, 0.0]]), "points: .*finite"),
        (np.eye(3), np.eye(3), np.zeros((1, 2)), r"points: must be \(N, 3\)"),
        (np.eye(3), np.eye(3), np.zeros((2, 1, 3)), r"points: must be \(N, 3\)"),
        (np.eye(3), np.eye(3), np.full((1, 3), 1e30), "points: too far"),
        (1e30 * np.eye(3), np.eye(3), np.zeros((1, 3)), "ray triangle: keep"),
        (np.tile(np.eye(3), (2, 2, 1, 1)), np.ones((2, 2, 3, 3)), np.zeros((1, 3)), r"\(K, 3, 3\)"),
        (np.eye(3)[:2], np.eye(3)[:2], np.zeros((1, 3)), "three rows"),
    ],
)
def test_what_cannot_be_projected_is_refused_in_one_line(p, n, points, said):
    with pytest.raises(AnamorphError, match=said) as raised:
        project_points_on_device(p, n, points)
    assert "\n" not in str(raised.value)


def test_the_package_is_there_without_a_device():
    code = "import sys, anamorph.raytriangle; sys.exit('wgpu' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
