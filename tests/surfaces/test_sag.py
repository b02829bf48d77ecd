"""Toroids and even aspheres: their shape in closed form, their normals, and where rays meet them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from anamorph.base.errors import AnamorphError
from anamorph.surfaces.even_asphere import MOST_COEFFICIENTS, EvenAsphere
from anamorph.surfaces.intersection import intersect, meet, pack
from anamorph.surfaces.sphere import Sphere
from anamorph.surfaces.toroid import Toroid

TILTED = np.array([[0.8, 0.0, -0.6], [0.36, 0.8, 0.48], [0.48, -0.6, 0.64]])
APEX = np.array([0.1, -0.2, 0.3])
curvatures = st.one_of(st.sampled_from([0.0, 1e-9, 12.0, -12.0]), st.floats(-15.0, 15.0))
coefficients = st.lists(st.floats(-200.0, 200.0), max_size=2).map(tuple)
surfaces = st.one_of(
    st.builds(Toroid, st.just(APEX), curvatures, curvatures, st.just(TILTED)),
    st.builds(EvenAsphere, st.just(APEX), curvatures, st.floats(-3.0, 0.5), coefficients, st.just(TILTED)),
)
REACH = 0.03


def random_parameters(count=40, seed=0):
    return np.random.default_rng(seed).uniform(-REACH, REACH, (count, 2))


def root_along(surface, origins, directions, low, high):
    """Distances (N,) at which rays meet a surface between two distances, by halving."""

    def height(distance):
        points = origins + distance[:, None] * directions
        return (points - surface.position(surface.parameters(points))) @ surface.axes[2]

    low, high = low.copy(), high.copy()
    rising = height(high) > height(low)
    for _ in range(60):
        middle = 0.5 * (low + high)
        above = (height(middle) > 0.0) == rising
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return 0.5 * (low + high)


@given(surfaces)
def test_normals_agree_with_differences(surface):
    uv, step = random_parameters(), 1e-6
    along_u, along_v = (surface.position(uv + d) - surface.position(uv - d) for d in step * np.eye(2))
    expected = np.cross(along_u, along_v)
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    np.testing.assert_allclose(surface.normal(uv), expected, atol=1e-8)
    assert (surface.normal(uv) @ surface.axes[2] > 0.0).all()


@given(surfaces)
def test_parameters_undo_position_and_the_apex_is_touched(surface):
    uv = random_parameters()
    np.testing.assert_allclose(surface.parameters(surface.position(uv)), uv, atol=1e-15)
    np.testing.assert_allclose(surface.position(np.zeros((1, 2))), [APEX], atol=1e-15)
    np.testing.assert_allclose(surface.normal(np.zeros((1, 2))), [TILTED[2]], atol=1e-15)


@given(st.floats(2.0, 15.0), st.floats(2.0, 15.0), st.booleans())
def test_a_toroid_is_a_torus(base, cross, concave):
    sign = -1.0 if concave else 1.0
    x, y, z = (Toroid(np.zeros(3), sign * base, sign * cross).position(random_parameters())).T
    # About an axis along y, at depth 1/base: the distance from the circle of the arc's middles is 1/cross.
    lever = 1.0 / base - 1.0 / cross
    around = np.hypot(x, sign * z + 1.0 / base)
    np.testing.assert_allclose((around - lever) ** 2 + y**2, cross**-2, rtol=1e-12)


@pytest.mark.parametrize("curvature", [8.0, -8.0])
def test_with_one_curvature_all_are_spheres(curvature):
    uv = random_parameters()
    for surface in (Toroid(APEX, curvature, curvature, TILTED), EvenAsphere(APEX, curvature, 0.0, (), TILTED)):
        away = surface.position(uv) - (APEX - TILTED[2] / curvature)
        np.testing.assert_allclose(np.linalg.norm(away, axis=1), 1.0 / abs(curvature), rtol=1e-13)
        np.testing.assert_allclose(surface.normal(uv), away * curvature, atol=1e-12)


def test_an_asphere_is_its_formula():
    uv = random_parameters()
    square = np.sum(uv**2, axis=1)
    paraboloid = EvenAsphere(np.zeros(3), 6.0, -1.0, (40.0, -7e3))
    expected = 3.0 * square + 40.0 * square**2 - 7e3 * square**3
    np.testing.assert_allclose(-paraboloid.position(uv)[:, 2], expected, rtol=1e-13)


@given(surfaces, st.integers(0, 10**6))
def test_hits_are_those_of_a_root_finder(surface, seed):
    random = np.random.default_rng(seed)
    uv = random.uniform(-0.8 * REACH, 0.8 * REACH, (30, 2))
    points, normals = surface.position(uv), surface.normal(uv)
    # Steep rays, one way and the other: those have one root between the two ends.
    directions = normals + 0.5 * random.normal(size=points.shape).clip(-1.0, 1.0)
    directions *= random.choice([-1.0, 1.0], (30, 1)) / np.linalg.norm(directions, axis=1, keepdims=True)
    origins = points - directions * random.uniform(0.004, 2.0, (30, 1))
    near = np.linalg.norm(points - origins, axis=1)
    distance = root_along(surface, origins, directions, near - 0.003, near + 0.003)
    found, found_normals, ok = intersect(surface, origins, directions, uv + random.normal(scale=3e-4, size=uv.shape))
    assert ok.all()
    np.testing.assert_allclose(found, origins + distance[:, None] * directions, atol=1e-12)
    np.testing.assert_allclose(found_normals, surface.normal(surface.parameters(found)), atol=1e-12)


@pytest.mark.parametrize("surface", [Toroid(np.zeros(3), 10.0, 6.0), EvenAsphere(np.zeros(3), 8.0, -0.5, (30.0,))])
@pytest.mark.parametrize("slant", [0.15, 0.05, 0.005])
@pytest.mark.parametrize("start", [-0.2, 0.1, 0.4, 0.6, 0.9, 1.2])
def test_of_two_hits_the_side_that_the_mesh_faces_decides(surface, slant, start):
    uv = np.array([[0.004, -0.003]])
    point, normal = surface.position(uv)[0], surface.normal(uv)[0]
    along = np.cross(normal, [0.0, 1.0, 0.0])
    direction = along / np.linalg.norm(along) - slant * normal
    direction /= np.linalg.norm(direction)
    origin = point - 0.4 * direction
    # From the turning point, where the ray runs along the surface, out to far below or above it.
    samples = 0.4 + np.linspace(0.2 * slant / 8.0, 4.0 * slant / 8.0, 2000)
    places = origin + samples[:, None] * direction
    height = places[:, 2] - surface.position(surface.parameters(places))[:, 2]
    last = samples[np.argmax(height > 0.0)]
    kind, numbers = pack(surface)
    ends = []
    for facing in (normal, -normal):
        ray = tuple(origin), tuple(direction), 0.4 + start * (last - 0.4), 0.0, 0.0, tuple(facing)
        met, distance, found = meet(kind, numbers, *ray)
        assert met and np.sign(np.dot(found, direction)) == -np.sign(np.dot(facing, normal))
        ends.append(distance)
    assert ends[0] == pytest.approx(0.4, abs=1e-11)
    assert ends[1] == pytest.approx(last, abs=2e-3 * slant)


@pytest.mark.parametrize("surface", [Toroid(np.zeros(3), 10.0, 6.0), EvenAsphere(np.zeros(3), 8.0)])
def test_a_ray_past_the_surface_is_not_ok_and_finite(surface):
    origins = [[-1.0, 0.0, 0.01], [0.0, 0.0, 0.5], [1.0, 1.0, 1.0]]
    directions = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]
    positions, normals, ok = intersect(surface, origins, directions, np.zeros((3, 2)))
    assert not ok.any()
    assert np.isfinite(positions).all() and np.isfinite(normals).all()


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: Toroid(np.full(3, np.nan), 1.0, 1.0), "toroid: apex"),
        (lambda: Toroid(np.zeros(3), np.inf, 1.0), "toroid: its shape"),
        (lambda: Toroid(np.zeros(3), 1.0, 1.0, -TILTED), "toroid: axes"),
        (lambda: EvenAsphere(np.zeros(3), 1.0, 0.0, (np.nan,)), "asphere: its shape"),
        (lambda: EvenAsphere(np.zeros(3), 1.0, 0.0, (0.0,) * (MOST_COEFFICIENTS + 1)), "asphere: has 17"),
        (lambda: Toroid(np.zeros(3), 10.0, 1.0).position(np.array([[0.11, 0.0]])), "toroid: has no points"),
        (lambda: EvenAsphere(np.zeros(3), 10.0).normal(np.array([[0.08, 0.08]])), "asphere: has no points"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(make, word):
    with pytest.raises(AnamorphError, match=rf"^{word}[^\n]*$"):
        make()


def test_a_spheres_lens_faces_agree_with_the_asphere():
    sphere, asphere = Sphere(np.zeros(3), 0.1), EvenAsphere(np.array([0.0, 0.0, 0.1]), 10.0)
    points = asphere.position(random_parameters())
    np.testing.assert_allclose(sphere.position(sphere.parameters(points)), points, atol=1e-15)
