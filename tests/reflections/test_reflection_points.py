"""All the places of mirrors at which an eye sees points, against closed forms, dense starts and rays the other way."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from reflected_truth import (
    CENTER,
    RADIUS,
    Trial,
    ball_points,
    beside_caustic,
    dense_points,
    door_mirror,
    normal_at,
    points_before,
    ripples,
    saddle,
    toroid,
    torus,
    turned,
    unmatched,
    whole_ball,
)

import anamorph as an
from anamorph import AnamorphError, ReflectionStatus, reflection_points
from anamorph.gallery.flat_mirror import plane_mirror
from anamorph.gallery.torus import AXIS, MAJOR, MIDDLE, MINOR
from anamorph.optics.laws import reflect
from anamorph.scene.model import Diffuse, Mesh, Mirror, Scene
from anamorph.surfaces.even_asphere import EvenAsphere

CLOSE = 1e-9
"""Of the mirror's size."""

TRIALS = {each.__name__: each for each in (saddle, toroid, torus, door_mirror)}
TRIALS["ripples"] = lambda: replace(ripples(0.016, 3), cells=330)


@pytest.fixture(scope="module")
def trials():
    return {name: make() for name, make in TRIALS.items()}


def found_by(trial: Trial, points):
    """The reflection points, each held against the law of reflection and the mirror's front."""
    found = reflection_points(trial.scene, trial.eye, points)
    normals = normal_at(trial, found.parameters)
    to_eye, to_point = trial.eye - found.position, points[found.point] - found.position
    for way in (to_eye, to_point):
        way /= np.linalg.norm(way, axis=1, keepdims=True)
        assert np.einsum("mi,mi->m", way, normals).min(initial=1.0) > 0.0
    leaning = np.linalg.norm(np.cross(to_eye + to_point, normals), axis=1)
    assert leaning.max(initial=0.0) < 1e-8
    ends = points[found.point]
    length = np.linalg.norm(trial.eye - found.position, axis=1) + np.linalg.norm(ends - found.position, axis=1)
    np.testing.assert_allclose(found.length, length)
    np.testing.assert_allclose(trial.mesh.surface.position(found.parameters), found.position, atol=CLOSE)
    assert set(np.unique(found.order)) <= {-1, 1} and not found.status.any()
    return found


def agrees(trial: Trial, found, who, places) -> None:
    """The same places, no more and no less."""
    order = np.argsort(who, kind="stable")
    who, places, close = who[order], places[order], CLOSE * trial.size
    assert not len(unmatched(who, places, found.point, found.position, close))
    assert not len(unmatched(found.point, found.position, who, places, close))
    assert len(who) == len(found.point)


@pytest.mark.parametrize(
    ("eye", "concave"),
    [((0.6, 0.6, 1.7), False), ((0.4, 0.3, -0.75), True), ((0.12, 0.21, -0.27), True), ((0.6, 0.6, 0.4), True)],
    ids=["convex", "inside", "near the centre", "near the wall"],
)
def test_a_ball_shows_what_alhazen_s_quartic_says(eye, concave):
    trial, random = whole_ball(eye, concave), np.random.default_rng(3)
    ways = random.normal(size=(1500, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    far = np.exp(random.uniform(np.log(0.01), np.log(10.0), (1500, 1)))
    inside = 0.999 * random.uniform(0.0, 1.0, (1500, 1)) ** (1 / 3)
    points = CENTER + RADIUS * ways * (inside if concave else 1.0 + far)
    found = found_by(trial, points)
    agrees(trial, found, *ball_points(np.array(CENTER), RADIUS, trial.eye, points, concave))
    assert not found.point_status.any()


@pytest.mark.parametrize("eye", [(0.4, 0.3, -0.75), (0.12, 0.21, -0.27), (0.6, 0.6, 0.4)])
def test_two_places_that_are_about_to_merge_are_both_found_or_are_a_focus(eye):
    trial = whole_ball(eye, True)
    places, points = beside_caustic(trial.eye, 600, 3)
    found, who = reflection_points(trial.scene, trial.eye, points), np.arange(len(points))
    assert len(points) > 400
    lost = unmatched(who, places, found.point, found.position, 1e-7 * trial.size)
    # Where places are so close that rounding moves them, the point is said to be at a focus.
    assert (found.point_status[lost] == ReflectionStatus.FOUND).sum() <= 0.001 * len(points)
    assert len(lost) < 0.05 * len(points)


@pytest.mark.parametrize("concave", [False, True])
@pytest.mark.parametrize("height", [1e-2, 1e-4, 1e-6])
def test_an_eye_close_to_a_mirror_sees_all_that_it_shows(height, concave):
    """Pieces of the mirror that are longer than the eye is high over it cover whole quarters of what the eye sees."""
    random = np.random.default_rng(12)
    eye = np.array(CENTER) + RADIUS * (1.0 - height if concave else 1.0 + height) * np.array([0.48, 0.6, 0.64])
    trial, ways = whole_ball(eye, concave), random.normal(size=(1500, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    far = np.exp(random.uniform(np.log(0.01), np.log(10.0), (1500, 1)))
    points = CENTER + RADIUS * ways * (random.uniform(0.1, 0.99, (1500, 1)) if concave else 1.0 + far)
    agrees(trial, found_by(trial, points), *ball_points(np.array(CENTER), RADIUS, trial.eye, points, concave))


@pytest.mark.parametrize(
    ("name", "count"), [("saddle", 250), ("toroid", 250), ("torus", 150), ("door_mirror", 200), ("ripples", 20)]
)
def test_no_start_of_a_dense_grid_finds_more(name, count, trials):
    trial = replace(trials[name], cells=trials[name].cells * 2 // 3)
    points = points_before(trial, count, 5)
    found = found_by(trial, points)
    who, places, _ = dense_points(trial, points)
    assert not len(unmatched(who, places, found.point, found.position, CLOSE * trial.size))
    # What the grid does not find is nearer to the surface than its cells.
    assert len(who) <= len(found.point) <= 1.002 * len(who) + 1
    assert (name == "ripples") == (found.counts.max() > 6)


@pytest.mark.parametrize("name", TRIALS)
def test_a_point_on_a_reflected_ray_is_seen_where_the_ray_was(name, trials):
    trial, random = trials[name], np.random.default_rng(7)
    uv = random.uniform(trial.low, trial.high, (2000, 2))
    places, normals = trial.mesh.surface.position(uv), normal_at(trial, uv)
    front = np.einsum("ni,ni->n", trial.eye - places, normals) > 0.02
    places, normals = places[front], normals[front]
    ways = reflect(places - trial.eye, normals)
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    points = places + trial.size * np.exp(random.uniform(np.log(1e-3), np.log(30.0), (len(places), 1))) * ways
    found = found_by(trial, points)
    # Where a caustic passes near the point, rounding of the point itself moves its place.
    lost = unmatched(np.arange(len(points)), places, found.point, found.position, 1e-7 * trial.size)
    # Waves that show a point dozens of times have caustics everywhere: there two that merge may be missed.
    assert len(lost) <= (0.001 * len(points) if name == "ripples" else 0)


@pytest.mark.parametrize(("make", "total"), [(lambda: whole_ball((0.6, 0.6, 1.9), False), 2), (torus, 0)])
def test_the_orders_on_a_closed_mirror_sum_to_its_euler_characteristic(make, total):
    """Both sides together, where nothing crosses the straight way from eye to point, which is a least length, too."""
    trial = make()
    points = points_before(replace(trial, low=np.full(2, -3.0), high=np.full(2, 3.0)), 400) if total else None
    points = points_before(trial, 400) if points is None else points
    ways = points - trial.eye
    if total:
        t = np.clip(-np.sum((trial.eye - CENTER) * ways, axis=1) / np.sum(ways**2, axis=1), 0.0, 1.0)[:, None]
        clear = np.linalg.norm(trial.eye + t * ways - CENTER, axis=1) > 1.001 * RADIUS
    else:
        steps = np.linspace(0.0, 1.0, 400)[:, None]
        clear = np.array([outside_torus(trial.eye + steps * way) for way in ways])
    points = points[clear]
    orders = np.zeros(len(points))
    for mesh in (trial.mesh, turned(trial.mesh)):
        found = reflection_points(replace(trial.scene, meshes=(mesh,)), trial.eye, points)
        orders += np.bincount(found.point, found.order, minlength=len(points))
    assert len(points) > 100 and (orders == total).all()


def outside_torus(points) -> bool:
    """Whether a row of points (N, 3) keeps clear of the gallery's torus."""
    axis = np.array(AXIS) / np.linalg.norm(AXIS)
    away = points - MIDDLE
    height = away @ axis
    ring = np.linalg.norm(away - np.outer(height, axis), axis=1)
    return bool((np.hypot(ring - MAJOR, height) > 1.01 * MINOR).all())


def test_a_flat_mirror_shows_each_point_where_its_mirror_image_is():
    mesh = plane_mirror("flat", (-1.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.0, 1.5, 0.0))
    side = float(np.sign(mesh.normals[0, 2]))
    eye, random = np.array([0.3, 0.7, 2.0 * side]), np.random.default_rng(2)
    points = random.uniform([-2.0, -1.0, -3.0], [2.0, 2.0, 3.0], (500, 3))
    share = eye[2] / (eye[2] + points[:, 2])
    places = eye + share[:, None] * (points * (1.0, 1.0, -1.0) - eye)
    seen = (points[:, 2] * side > 0.0) & (np.abs(places[:, 0]) < 1.0) & (places[:, 1] > 0.0) & (places[:, 1] < 1.5)
    for surface in (mesh.surface, None):
        scene = Scene("flat", (replace(mesh, surface=surface),), an.Camera(tuple(eye), (0.0, 0.7, 0.0)))
        found = reflection_points(scene, scene.camera, points, (320, 240))
        np.testing.assert_array_equal(found.point, np.flatnonzero(seen))
        np.testing.assert_allclose(found.position, places[seen], atol=1e-12)
        np.testing.assert_allclose(found.image, scene.camera.image(places[seen], (320, 240)), atol=1e-9)
        np.testing.assert_allclose(
            found.direction, (places[seen] - eye) / np.linalg.norm(places[seen] - eye, axis=1)[:, None]
        )


def test_a_plain_mesh_reflects_by_its_interpolated_normals():
    trial, random = saddle(), np.random.default_rng(4)
    mesh = replace(trial.mesh, surface=None, parameters=None)
    triangle = random.integers(len(mesh.faces), size=2000)
    weights = random.dirichlet(np.ones(3), 2000)
    places = np.einsum("nk,nki->ni", weights, mesh.positions[mesh.faces[triangle]].astype(float))
    corners = mesh.normals[mesh.faces[triangle]].astype(float)
    corners /= np.linalg.norm(corners, axis=2, keepdims=True)
    normals = np.einsum("nk,nki->ni", weights, corners)
    ways = reflect(places - trial.eye, normals / np.linalg.norm(normals, axis=1, keepdims=True))
    points = places + random.uniform(0.02, 4.0, (2000, 1)) * ways
    found = reflection_points(replace(trial.scene, meshes=(mesh,)), trial.eye, points)
    own = np.flatnonzero(np.isin(found.point * 1000 + found.triangle, np.arange(2000) * 1000 + triangle))
    assert set(found.point[own]) == set(range(2000))
    assert not len(unmatched(np.arange(2000), places, found.point, found.position, CLOSE * trial.size))


def disc() -> Trial:
    """A round asphere of 24 triangles."""
    angle = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    uv = np.concatenate([[[0.0, 0.0]], 0.3 * np.stack([np.cos(angle), np.sin(angle)], axis=-1)])
    ring = np.arange(24)
    faces = np.stack([np.zeros(24, int), 1 + ring, 1 + (ring + 1) % 24], axis=-1)
    mesh = Mesh.exact("disc", EvenAsphere(np.zeros(3), 0.8, -0.5, (0.3,)), uv, faces, Mirror())
    return Trial(mesh, np.array([0.1, 0.2, 1.5]), np.zeros(2), np.zeros(2))


def test_a_mirror_ends_at_its_round_border_and_not_at_its_mesh():
    trial = disc()
    angle = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False) + np.pi / 24.0
    for radius, seen in ((0.2999, True), (0.3001, False)):
        assert 0.3 * np.cos(np.pi / 24.0) < 0.2999
        uv = radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        places = trial.mesh.surface.position(uv)
        points = places + 2.0 * reflect(places - trial.eye, trial.mesh.surface.normal(uv))
        found = reflection_points(trial.scene, trial.eye, points)
        assert len(unmatched(np.arange(24), places, found.point, found.position, 1e-9)) == (0 if seen else 24)


@pytest.mark.parametrize(("eye", "point"), [((0, 0, 0), (0, 0, 0)), ((0.3, 0, 0), (-0.3, 0, 0))])
def test_a_curve_or_a_surface_of_reflection_points_is_a_focus(eye, point):
    eye, point = (np.add(CENTER, each) for each in (eye, point))
    trial = whole_ball(eye, True)
    aside = np.add(point, (0.05, 0.1, 0.02))
    found = reflection_points(trial.scene, eye, [point, aside])
    assert found.point_status.tolist() == [ReflectionStatus.FOCUS, ReflectionStatus.FOUND]
    at = (found.point == 0) & (found.status == ReflectionStatus.FOCUS)
    assert at.sum() == 1 and found.order[at] == 0
    np.testing.assert_allclose(np.linalg.norm(found.position[at] - CENTER, axis=1), RADIUS)
    assert all(np.isfinite(each).all() for each in (found.position, found.parameters, found.length, found.direction))


def test_a_point_on_a_mirror_has_a_status_and_one_beside_it_is_found():
    trial = saddle()
    place, normal = trial.mesh.surface.position(np.array([[0.21, 0.13]])), normal_at(trial, np.array([[0.21, 0.13]]))
    points = np.concatenate([place, place + 1e-7 * normal, place - 1e-3 * normal])
    found = reflection_points(trial.scene, trial.eye, points)
    assert found.point_status.tolist() == [ReflectionStatus.ON_SURFACE, ReflectionStatus.FOUND, ReflectionStatus.FOUND]
    assert found.counts.tolist() == [0, 1, 0]
    assert np.linalg.norm(found.position - place) < 1e-6


def test_an_eye_inside_a_ball_that_mirrors_outside_sees_nothing():
    trial = whole_ball(np.add(CENTER, 0.1), False)
    assert not reflection_points(trial.scene, trial.eye, points_before(saddle(), 50)).counts.any()


def broken(mesh: Mesh) -> Mesh:
    normals = mesh.normals.copy()
    normals[3] = np.nan
    return replace(mesh, normals=normals)


@pytest.mark.parametrize(
    ("mesh", "eye", "points", "said"),
    [
        (lambda mesh: mesh, (0, 0, 2), np.zeros((2, 2)), "points"),
        (lambda mesh: mesh, (0, 0, 2), [[0.0, np.nan, 1.0]], "points"),
        (lambda mesh: mesh, (0, 2), np.zeros((2, 3)), "eye"),
        (lambda mesh: mesh, (0, 0, np.inf), np.zeros((2, 3)), "eye"),
        (lambda mesh: mesh, (0, 0, 0), np.ones((2, 3)), "is on the mirror 'saddle'"),
        (broken, (0, 0, 2), np.ones((2, 3)), "normals"),
        (lambda mesh: replace(mesh, material=Diffuse()), (0, 0, 2), np.ones((2, 3)), "has no mirror"),
    ],
)
def test_what_cannot_be_answered_is_refused_in_one_line(mesh, eye, points, said):
    trial = saddle()
    with pytest.raises(AnamorphError, match=said) as error:
        reflection_points(replace(trial.scene, meshes=(mesh(trial.mesh),)), eye, points)
    assert "\n" not in str(error.value)


def test_what_is_kept_of_a_mirror_is_right_for_each_eye():
    trial = saddle()
    points = points_before(trial, 50)
    other = trial.eye + 0.3 * (points[0] - trial.eye)
    fresh = {tuple(eye): reflection_points(saddle().scene, eye, points) for eye in (trial.eye, other)}
    for eye in (trial.eye, trial.eye, other, trial.eye):
        found = reflection_points(trial.scene, eye, points)
        assert (found.position == fresh[tuple(eye)].position).all()
    assert (fresh[tuple(other)].position.shape != fresh[tuple(trial.eye)].position.shape) or (
        fresh[tuple(other)].position != fresh[tuple(trial.eye)].position
    ).any()


def test_no_points_have_no_places():
    trial = saddle()
    found = reflection_points(trial.scene, trial.eye, np.zeros((0, 3)))
    assert len(found.point) == len(found.point_status) == 0
