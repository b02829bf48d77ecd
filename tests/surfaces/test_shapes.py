"""Exact surfaces: their shape, and normals that are unit and outside everywhere, poles included."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from anamorph.base.errors import AnamorphError
from anamorph.surfaces.bezier import BezierPatch
from anamorph.surfaces.plane import Plane
from anamorph.surfaces.sphere import Sphere

coordinate = st.floats(-3.0, 3.0).map(lambda x: round(x, 3))
unit_interval = st.one_of(st.sampled_from([0.0, 0.5, 1.0]), st.floats(0.0, 1.0))
TILTED = np.array([[0.8, 0.0, -0.6], [0.36, 0.8, 0.48], [0.48, -0.6, 0.64]])
FLAT = np.stack([*np.meshgrid(np.arange(4.0), np.arange(4.0), indexing="ij"), np.zeros((4, 4))], axis=-1)


@given(
    arrays(float, 3, elements=coordinate),
    st.floats(1e-3, 1e3),
    st.one_of(st.sampled_from([-np.pi / 2, 0.0, np.pi / 2]), st.floats(-1.5, 1.5)),
    st.floats(-3.1, 3.1),
)
def test_a_sphere_is_round_and_its_normal_points_away_from_its_centre(center, radius, v, u):
    sphere = Sphere(center, radius, TILTED)
    uv = np.array([[u, v]])
    normal = sphere.normal(uv)
    assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-14)
    np.testing.assert_allclose(sphere.position(uv), center + radius * normal, atol=1e-12 * radius)


@given(st.floats(-3.1, 3.1), st.floats(-1.5, 1.5))
def test_a_spheres_parameters_undo_its_position(u, v):
    sphere = Sphere(np.array([1.0, -2.0, 0.5]), 1.4, TILTED)
    np.testing.assert_allclose(sphere.parameters(sphere.position(np.array([[u, v]]))), [[u, v]], atol=1e-12)


def test_a_spheres_origin_lies_outward_with_u_to_the_right_and_v_upward():
    sphere = Sphere(np.zeros(3), 2.0, TILTED)
    right, up, outward = TILTED
    step = 1e-6
    here, aside, above = sphere.position(np.array([[0.0, 0.0], [step, 0.0], [0.0, step]]))
    np.testing.assert_allclose(here, 2.0 * outward, atol=1e-14)
    np.testing.assert_allclose((aside - here) / (2.0 * step), right, atol=1e-6)
    np.testing.assert_allclose((above - here) / (2.0 * step), up, atol=1e-6)


@pytest.mark.parametrize(
    ("radius", "axes", "word"),
    [(0.0, TILTED, "radius"), (np.nan, TILTED, "radius"), (1.0, -TILTED, "axes"), (1.0, 2 * TILTED, "axes")],
)
def test_a_sphere_without_size_or_frame_is_refused_in_one_line(radius, axes, word):
    with pytest.raises(AnamorphError, match=rf"^sphere: {word} [^\n]*$"):
        Sphere(np.zeros(3), radius, axes)


def test_a_plane_spans_its_edges_and_faces_their_cross_product():
    plane = Plane(np.array([1.0, 2.0, 3.0]), np.array([2.0, 0.0, 0.0]), np.array([0.0, 3.0, 0.0]))
    np.testing.assert_array_equal(plane.position(np.array([[0.5, 1.0]])), [[2.0, 5.0, 3.0]])
    np.testing.assert_array_equal(plane.normal(np.zeros((2, 2))), [[0.0, 0.0, 1.0]] * 2)


@given(arrays(float, (4, 4, 3), elements=coordinate), unit_interval, unit_interval)
def test_a_patch_is_the_cubic_of_its_control_points(control, u, v):
    # De Casteljau's construction, the other definition of the same surface.
    points = control
    for _ in range(3):
        points = (1 - u) * points[:-1] + u * points[1:]
    points = points[0]
    for _ in range(3):
        points = (1 - v) * points[:-1] + v * points[1:]
    np.testing.assert_allclose(BezierPatch(control).position(np.array([[u, v]])), points, atol=1e-12)


@given(
    arrays(float, (4, 4, 3), elements=coordinate),
    st.floats(0.1, 0.9),
    st.floats(0.1, 0.9),
    st.sampled_from([(1, 0), (0, 1), (1, 1), (2, 0), (0, 2)]),
)
def test_derivatives_of_a_patch_agree_with_differences(control, u, v, order):
    patch, step = BezierPatch(control), 1e-5
    axis = 0 if order[0] else 1
    lower = (order[0] - (axis == 0), order[1] - (axis == 1))
    move = step * np.eye(2)[axis]
    ends = [patch.derivative(np.array([[u, v]]) + sign * move, *lower) for sign in (1, -1)]
    difference = (ends[0] - ends[1]) / (2 * step)
    np.testing.assert_allclose(patch.derivative(np.array([[u, v]]), *order), difference, atol=1e-4)


bumps = arrays(float, (4, 4, 3), elements=st.floats(-0.3, 0.3).map(lambda x: round(x, 2)))


@given(bumps, unit_interval, unit_interval)
def test_a_patchs_normal_is_unit_and_at_right_angles_to_it(bump, u, v):
    patch, uv = BezierPatch(FLAT + bump), np.array([[u, v]])
    normal = patch.normal(uv)[0]
    assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-12)
    assert normal @ patch.derivative(uv, 1, 0)[0] == pytest.approx(0.0, abs=1e-11)
    assert normal @ patch.derivative(uv, 0, 1)[0] == pytest.approx(0.0, abs=1e-11)
    assert normal[2] > 0


@given(bumps, st.sampled_from(["u0", "u1", "v0", "v1"]), st.sampled_from([0.0, 0.3, 1.0]))
def test_on_a_collapsed_edge_the_normal_is_the_limit_from_inside(bump, edge, along):
    control = FLAT + bump
    axis, end = "uv".index(edge[0]), int(edge[1])
    row = (slice(None),) * axis + (-end,)
    control[row] = control[row].mean(axis=0)
    pole = np.array([[along, along]])
    pole[0, axis] = end
    near = pole.copy()
    near[0, axis] = abs(end - 1e-5)
    patch = BezierPatch(control)
    assert np.linalg.norm(patch.normal(pole)) == pytest.approx(1.0, abs=1e-12)
    np.testing.assert_allclose(patch.normal(pole), patch.normal(near), atol=2e-3)


def test_where_a_corner_collapses_to_second_order_the_normal_is_finite():
    control = FLAT.copy()
    control[:2, :2] = control[0, 0]
    control[2, 0] = control[0, 2] = control[0, 0]
    np.testing.assert_allclose(BezierPatch(control).normal(np.array([[0.0, 0.0]])), [[0.0, 0.0, 1.0]], atol=1e-9)


def test_a_patch_without_area_is_refused_in_one_line():
    with pytest.raises(AnamorphError, match=r"^surface: [^\n]*line[^\n]*$"):
        BezierPatch(FLAT * (1.0, 0.0, 0.0)).normal(np.array([[0.5, 0.5]]))


@pytest.mark.parametrize("control", [np.zeros((4, 3)), np.full((4, 4, 3), np.nan)])
def test_a_patch_of_other_shape_or_without_numbers_is_refused(control):
    with pytest.raises(AnamorphError, match=r"^Bezier patch: control "):
        BezierPatch(control)
