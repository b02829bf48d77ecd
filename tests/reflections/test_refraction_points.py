"""All the places of lenses by which an eye sees points, against closed forms, dense starts and rays the other way."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from lens_scenes import CENTER as VERTEX
from lens_scenes import EYE, slab
from reflected_truth import unmatched
from refracted_truth import (
    RADIUS,
    TRIALS,
    LensTrial,
    astigmatic,
    ball_points,
    beside_caustic,
    biconvex,
    dense_points,
    glass_ball,
    points_behind,
    rays_through,
)

from anamorph import AnamorphError, ReflectionStatus, refraction_points
from anamorph.optics.dispersion import line_indices
from anamorph.scene.camera import Camera
from anamorph.scene.model import Diffuse, Scene

CLOSE = 1e-9
"""Of the lens's size."""


@pytest.fixture(scope="module")
def trials():
    return {name: make() for name, make in TRIALS.items()}


def lawful(trial: LensTrial, points, color: str = "green", index: float | None = None, foci: bool = False):
    """The refraction points, each held against Snell's law at both faces, and against the sides of these.

    Some may be `foci`, and then their places are less exact.
    """
    found = refraction_points(trial.scene, trial.eye, points, color=color)
    index = trial.index if index is None else index
    entry, leave = found.position[:, 0], found.position[:, 1]
    ways = [entry - trial.eye, leave - entry, points[found.point] - leave]
    lengths = [np.linalg.norm(way, axis=1) for way in ways]
    np.testing.assert_allclose(found.length, lengths[0] + index * lengths[1] + lengths[2], rtol=1e-12)
    units = [way / length[:, None] for way, length in zip(ways, lengths, strict=True)]
    for number, (face, before, after) in enumerate(zip(trial.faces, (1.0, index), (index, 1.0), strict=True)):
        np.testing.assert_allclose(
            face.surface.position(found.parameters[:, number]), found.position[:, number], atol=CLOSE * trial.size
        )
        outward = np.broadcast_to(np.asarray(face.normals, float).mean(axis=0), leave.shape)
        normals = face.surface.normals_toward(found.parameters[:, number], outward)
        bent = np.cross(before * units[number] - after * units[number + 1], normals)
        assert np.linalg.norm(bent, axis=1).max(initial=0.0) < 1e-8
        for way in units[number : number + 2]:
            crossing = np.sum(way * normals, axis=1)
            assert (crossing * (-1.0 if number == 0 else 1.0)).min(initial=1.0) > 0.0
    np.testing.assert_allclose(found.direction, units[0], atol=1e-12)
    assert foci or (set(np.unique(found.order)) <= {-1, 1} and not found.status.any())
    assert ((found.order == 0) == (found.status == ReflectionStatus.FOCUS)).all()
    meshes = trial.scene.meshes
    assert all(meshes[near] is trial.faces[0] and meshes[far] is trial.faces[1] for near, far in found.mesh)
    return found


@pytest.mark.parametrize("name", TRIALS)
def test_a_point_on_a_ray_behind_a_lens_is_seen_where_the_ray_entered(name, trials):
    trial = trials[name]
    entries, exits, ways = rays_through(trial, 2500, 7)
    far = np.exp(np.random.default_rng(8).uniform(np.log(1e-3), np.log(300.0), (len(exits), 1)))
    points = exits + trial.size * far * ways
    found = lawful(trial, points)
    assert len(points) > 800 and not found.point_status.any()
    # Where a caustic passes near the point, rounding of the point itself moves its place.
    assert not len(unmatched(np.arange(len(points)), entries, found.point, found.position[:, 0], 1e-7 * trial.size))
    assert not len(unmatched(np.arange(len(points)), exits, found.point, found.position[:, 1], 1e-7 * trial.size))


@pytest.mark.parametrize("name", TRIALS)
def test_no_start_of_many_finds_more(name, trials):
    trial = trials[name]
    # Starts far from where a point beside the lens is seen lead nowhere.
    points = points_behind(trial, 60, 11, nearest=0.05)
    found = lawful(trial, points)
    who, places = dense_points(trial, points, 24)
    assert not len(unmatched(who, places, found.point, found.position[:, 0], CLOSE * trial.size))
    assert len(points) > 20 and len(who) <= len(found.point) <= 1.02 * len(who) + 1


@pytest.mark.parametrize("index", [1.3, 1.5, 2.2])
def test_a_ball_of_glass_shows_what_its_own_plane_says(index):
    trial = glass_ball(index)
    points = points_behind(trial, 400, 5)
    found = lawful(trial, points)
    truth = ball_points(index, trial.eye, points)
    who, places = np.repeat(np.arange(len(points)), [len(each) for each in truth]), np.concatenate(truth)
    assert not len(unmatched(who, places, found.point, found.position[:, 0], CLOSE * trial.size))
    assert not len(unmatched(found.point, found.position[:, 0], who, places, CLOSE * trial.size))
    assert len(who) == len(found.point) and found.counts.max() == 3


@pytest.mark.parametrize("index", [1.3, 1.5, 2.2])
def test_two_places_that_are_about_to_merge_are_both_found_or_are_a_focus(index):
    trial = glass_ball(index)
    entries, points = beside_caustic(index, trial.eye, 1500, 13)
    found, who = lawful(trial, points, foci=True), np.arange(len(points))
    assert len(points) > 300
    places = found.position[:, 0]
    lost = unmatched(who, entries, found.point, places, 1e-7 * trial.size)
    # Where places are so close that rounding moves them, the point is said to be at a focus.
    assert (found.point_status[lost] == ReflectionStatus.FOUND).sum() <= 0.001 * len(points)
    assert len(lost) < 0.05 * len(points)
    # On the lit side of the caustic there are two, of two orders.
    assert (found.order < 0).sum() > 100


def test_a_slab_shifts_each_point_as_one_equation_says():
    lens = slab(index=1.5, thickness=0.02)
    trial = LensTrial(lens, np.array(EYE), True)
    random = np.random.default_rng(3)
    points = random.uniform((-0.3, 0.2, -2.0), (0.3, 0.8, 0.0), (400, 3))
    before, behind = EYE[2] - VERTEX[2], VERTEX[2] - 0.02 - points[:, 2]
    across = np.hypot(points[:, 0] - EYE[0], points[:, 1] - EYE[1])
    low, high = np.zeros(400), np.ones(400)
    for _ in range(100):
        sine = 0.5 * (low + high)
        glass = 0.02 * (sine / 1.5) / np.sqrt(1.0 - (sine / 1.5) ** 2)
        less = (before + behind) * sine / np.sqrt(1.0 - sine**2) + glass < across
        low, high = np.where(less, sine, low), np.where(less, high, sine)
    aside = before * sine / np.sqrt(1.0 - sine**2)
    ways = (points[:, :2] - EYE[:2]) / across[:, None]
    entries = np.column_stack([EYE[:2] + aside[:, None] * ways, np.full(400, VERTEX[2])])
    ends = np.linalg.norm(entries[:, :2] + (glass[:, None] * ways) - VERTEX[:2], axis=1)
    seen = (np.linalg.norm(entries[:, :2] - VERTEX[:2], axis=1) < 0.06) & (ends < 0.06)
    found = lawful(trial, points)
    assert 50 < seen.sum() < 390 and found.point.tolist() == np.flatnonzero(seen).tolist()
    np.testing.assert_allclose(found.position[:, 0], entries[seen], atol=1e-12)
    camera = Camera(EYE, (0.0, 0.5, 0.0))
    shown = refraction_points(trial.scene, camera, points, (320, 240))
    np.testing.assert_allclose(shown.image, camera.image(entries[seen], (320, 240)), atol=1e-8)


@pytest.mark.parametrize("name", ["biconvex", "aspheric", "moulded", "glass_ball"])
def test_the_order_is_the_sense_in_which_the_neighbourhood_is_seen(name, trials):
    """Three points around another are seen in the same sense about it, or in the other."""
    trial, step = trials[name], 1e-6
    points = points_behind(trial, 500, 21)
    found = lawful(trial, points)
    chosen = np.unique(np.concatenate([np.flatnonzero(found.order < 0), np.arange(0, len(found.point), 7)]))
    ways = points[found.point[chosen]] - found.position[chosen, 1]
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    right = np.cross(ways, (0.3, 0.9, 0.2))
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    up = np.cross(right, ways)
    beside = points[found.point[chosen], None] + step * np.stack([right, up], axis=1)
    moved = refraction_points(trial.scene, trial.eye, beside.reshape(-1, 3))
    agreed = np.zeros(3, int)
    for number, row in enumerate(chosen):
        look, sights = found.direction[row], []
        for point in (2 * number, 2 * number + 1):
            own = moved.direction[moved.point == point]
            if len(own):
                sights.append(own[np.linalg.norm(own - look, axis=1).argmin()] - look)
        # Close to a caustic a small step may lose the place.
        if len(sights) < 2 or max(np.linalg.norm(each) for each in sights) > 1e-3:
            continue
        sense = np.dot(np.cross(sights[0], sights[1]), -look) * np.dot(
            np.cross(right[number], up[number]), -ways[number]
        )
        assert np.sign(sense) == found.order[row]
        agreed[found.order[row]] += 1
    assert agreed[1] > 30 and agreed[-1] > 3


def test_a_ring_of_places_is_a_focus_and_the_middle_of_it_is_found_beside_it():
    trial = glass_ball(1.5, (0.0, 0.0, 0.5))
    # Paraxial light meets at -0.21, and light further out before.
    points = np.array([[0.0, 0.0, -0.17], [0.01, 0.0, -0.17], [0.0, 0.0, -0.3]])
    found = refraction_points(trial.scene, trial.eye, points)
    status = [ReflectionStatus(each) for each in found.point_status]
    assert status == [ReflectionStatus.FOCUS, ReflectionStatus.FOUND, ReflectionStatus.FOUND]
    assert found.order[found.point == 0].tolist() in ([0, 1], [1, 0])
    ring = found.position[(found.point == 0) & (found.order == 0), 0]
    assert np.linalg.norm(ring) == pytest.approx(RADIUS, rel=1e-9) and np.hypot(*ring[0, :2]) > 0.01
    assert all(np.isfinite(each).all() for each in (found.position, found.parameters, found.length, found.direction))


def test_colours_are_bent_by_their_own_index():
    trial = astigmatic()
    points = points_behind(trial, 200, 4)
    glass = trial.lens.front.material
    places = {}
    for color, index in zip(("red", "green", "blue"), line_indices(glass.index, glass.abbe), strict=True):
        found = lawful(trial, points, color, index)
        places[color] = {point: place for point, place in zip(found.point.tolist(), found.position[:, 0], strict=True)}
    shared = set.intersection(*(set(each) for each in places.values()))
    apart = [np.linalg.norm(places["red"][each] - places["blue"][each]) for each in shared]
    assert len(shared) > 100 and np.median(apart) > 1e-6


def test_a_lens_ends_at_its_round_border_and_not_at_its_mesh():
    trial = LensTrial(slab(vertices=7), np.array(EYE), True)
    # The mesh is a hexagon, whose sides are at 0.87 of the radius. A slab sends rays on as they came.
    angle = np.arange(6) * np.pi / 3.0 + np.pi / 6.0
    across = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(6)])
    for share, seen in ((0.9999, 6), (1.0001, 0)):
        leave = 0.06 * share
        low, high = 0.0, leave
        for _ in range(80):
            enter = 0.5 * (low + high)
            sine = enter / np.hypot(enter, EYE[2] - VERTEX[2]) / 1.5
            low, high = (enter, high) if enter + 0.02 * sine / np.sqrt(1.0 - sine**2) < leave else (low, enter)
        exits = VERTEX - (0.0, 0.0, 0.02) + leave * across
        points = exits + 2.0 * (VERTEX + enter * across - EYE)
        found = lawful(trial, points)
        assert len(found.point) == seen
        np.testing.assert_allclose(found.position[:, 1], exits[:seen], atol=1e-9)


def test_a_point_on_a_face_has_a_status_and_one_beside_it_is_found():
    trial = biconvex()
    _, exits, ways = rays_through(trial, 10, 2)
    points = np.concatenate([exits[:1], exits[:1] + 1e-7 * ways[:1], trial.lens.front.exact_positions()[[5]]])
    found = refraction_points(trial.scene, trial.eye, points)
    status = [ReflectionStatus(each) for each in found.point_status]
    assert status == [ReflectionStatus.ON_SURFACE, ReflectionStatus.FOUND, ReflectionStatus.ON_SURFACE]
    assert found.counts.tolist() == [0, 1, 0]
    assert np.linalg.norm(found.position[:, 1] - exits[0]) < 1e-6


def test_an_eye_sees_through_a_lens_from_both_sides_and_not_from_within():
    trial = biconvex()
    points = points_behind(trial, 100, 6)
    there = refraction_points(trial.scene, trial.eye, points)
    for point, position in zip(there.point[:40], there.position[:40], strict=True):
        back = refraction_points(trial.scene, points[point], trial.eye)
        assert (back.mesh == [[1, 0]]).all()
        assert np.abs(back.position - position[::-1]).max(axis=(1, 2)).min() < 1e-7 * trial.size
    assert not refraction_points(trial.scene, (0.0, 0.0, 0.0), points).counts.any()


@pytest.mark.parametrize(
    ("eye", "points", "color", "said"),
    [
        ((0, 0, 2), np.zeros((2, 2)), "green", "points"),
        ((0, 0, 2), [[0.0, np.nan, 1.0]], "green", "points"),
        ((0, 2), np.zeros((2, 3)), "green", "eye"),
        ((0, 0, np.inf), np.zeros((2, 3)), "green", "eye"),
        ((0, 0, 0.02), np.ones((2, 3)), "green", "is on the lens face 'lens/front'"),
        ((0, 0, -0.02), np.ones((2, 3)), "green", "is on the lens face 'lens/back'"),
        ((0, 0, 2), np.ones((2, 3)), "yellow", "color is 'yellow'"),
    ],
)
def test_what_cannot_be_answered_is_refused_in_one_line(eye, points, color, said):
    with pytest.raises(AnamorphError, match=said) as error:
        refraction_points(biconvex().scene, eye, points, color=color)
    assert "\n" not in str(error.value)


def test_a_scene_without_a_lens_is_refused():
    scene = biconvex().scene
    for meshes in (scene.meshes[:1], tuple(replace(mesh, material=Diffuse()) for mesh in scene.meshes)):
        with pytest.raises(AnamorphError, match="has no lens"):
            refraction_points(Scene("none", meshes, scene.camera), scene.camera, np.ones((1, 3)))


def test_what_is_kept_of_a_lens_is_right_for_each_eye_and_each_colour():
    trial = biconvex()
    points = points_behind(trial, 50, 9)
    fresh = {tuple(eye): refraction_points(biconvex().scene, eye, points) for eye in (trial.eye, trial.eye * 1.2)}
    for eye in (trial.eye, trial.eye * 1.2, trial.eye):
        found = refraction_points(trial.scene, eye, points)
        assert found.position.shape == fresh[tuple(eye)].position.shape
        assert (found.position == fresh[tuple(eye)].position).all()
    lens = astigmatic()
    places = [
        refraction_points(lens.scene, lens.eye, points_behind(lens, 9, 9), color=color) for color in ("red", "blue")
    ]
    assert (places[0].position != places[1].position).any()


def test_no_points_have_no_places():
    trial = biconvex()
    found = refraction_points(trial.scene, trial.eye, np.zeros((0, 3)))
    assert len(found.point) == len(found.point_status) == 0
