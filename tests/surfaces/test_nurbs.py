"""NURBS surfaces: position, normal and curvature against closed forms, and rays that meet them."""

from __future__ import annotations

import numpy as np
import pytest
from curved_surfaces import CENTER, FIELDS, QUARTERS, RADIUS, height_field, sphere_surface, torus_surface
from hypothesis import given
from hypothesis import strategies as st

from anamorph.base.errors import AnamorphError
from anamorph.base.steps import drain
from anamorph.methods.tracing.launch import eye_rays
from anamorph.methods.tracing.paths import PathTracer
from anamorph.rays.caster import Caster
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Mesh, Mirror, Scene
from anamorph.surfaces.intersection import intersect
from anamorph.surfaces.nurbs import NurbsSurface
from anamorph.surfaces.nurbs_pieces import point_and_tangents
from anamorph.surfaces.sphere import Sphere

around = st.one_of(st.sampled_from([0.0, 1.0, 2.0, 4.0]), st.floats(0.0, 4.0))
upward = st.one_of(st.sampled_from([0.0, 1e-6, 1.0, 2.0]), st.floats(0.0, 2.0))


@given(around, upward, st.sampled_from([1.0, -1.0]))
def test_a_rational_sphere_is_round_everywhere_poles_and_seam_included(u, v, sign):
    surface, uv = sphere_surface(sign=sign), np.array([[u, v]])
    outward = (surface.position(uv) - CENTER) / RADIUS
    assert np.linalg.norm(outward) == pytest.approx(1.0, abs=1e-14)
    np.testing.assert_allclose(surface.normal(uv), sign * outward, atol=1e-8)
    np.testing.assert_allclose(surface.curvatures(uv), [[sign / RADIUS] * 2], rtol=1e-6)


@given(around, around)
def test_curvatures_of_a_torus_follow_its_closed_form(u, v):
    surface, uv = torus_surface(2.0, 0.5), np.array([[u, v]])
    x, y, _ = surface.position(uv)[0]
    distance = np.hypot(x, y)
    across = (distance - 2.0) / 0.5 / distance
    np.testing.assert_allclose(surface.curvatures(uv), [sorted([2.0, across], reverse=True)], atol=1e-9)


@given(st.integers(0, 20), st.floats(0.001, 1.999), st.floats(0.001, 1.999))
def test_derivatives_are_those_of_the_position(seed, u, v):
    surface, uv, step = height_field(seed), np.array([[u, v]]), 1e-4
    for axis in range(2):
        aside = np.zeros((1, 2))
        aside[0, axis] = step
        if np.any(np.abs(uv[0, axis] - np.unique([*surface.knots_u, *surface.knots_v])) < 2 * step):
            return
        for orders in ((0, 0), (1, 0), (0, 1)):
            change = (surface.derivative(uv + aside, *orders) - surface.derivative(uv - aside, *orders)) / (2 * step)
            more = tuple(np.add(orders, (1 - axis, axis)))
            np.testing.assert_allclose(surface.derivative(uv, *more), change, atol=2e-5)


def test_many_points_at_once_are_those_one_by_one():
    surface = height_field()
    uv = np.random.default_rng(0).uniform(0, 2, (9000, 2))
    np.testing.assert_array_equal(
        surface.position(uv)[[0, 4095, 4096, 8999]], surface.position(uv[[0, 4095, 4096, 8999]])
    )


@pytest.mark.parametrize("surface", [height_field(), height_field(1, (1, 5), (4, 1)), sphere_surface()])
def test_the_compiled_pieces_are_the_surface(surface):
    numbers = surface.numbers
    low, high = surface.domain
    random = np.random.default_rng(0)
    share = np.concatenate([random.uniform(size=(60, 2)), [[0, 0], [1, 1], [0.5, 0.25], [0, 1]]])
    uv = low + share * (high - low)
    found = np.array([point_and_tangents(numbers, u, v) for u, v in share])
    np.testing.assert_allclose(found[:, 0], surface.position(uv), atol=1e-14)
    np.testing.assert_allclose(found[:, 1], surface.derivative(uv, 1, 0) * (high - low)[0], atol=1e-12)
    np.testing.assert_allclose(found[:, 2], surface.derivative(uv, 0, 1) * (high - low)[1], atol=1e-12)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_rays_meet_a_rational_sphere_where_they_meet_the_sphere(sign):
    surface = sphere_surface(sign=sign)
    random = np.random.default_rng(0)
    uv = np.stack([random.uniform(0, 4, 400), random.uniform(0.05, 1.95, 400)], axis=-1)
    points = surface.position(uv)
    origins = points + sign * surface.normal(uv) * 2.0 + random.normal(scale=0.5, size=points.shape)
    directions = points - origins
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    start = np.clip(uv + random.normal(scale=0.02, size=uv.shape), [0, 0], [4, 2])
    positions, normals, ok = intersect(surface, origins, directions, start)
    assert ok.all()
    np.testing.assert_allclose(positions, points, atol=1e-12)
    np.testing.assert_allclose(normals, sign * (points - CENTER) / RADIUS, atol=1e-12)


def cap(surface, uv):
    count = int(np.sqrt(len(uv)))
    first = np.add.outer(np.arange(count - 1) * count, np.arange(count - 1)).reshape(-1, 1)
    corners = first + np.array([0, 1, count + 1, 0, count + 1, count])
    return Mesh(
        "mirror", surface.position(uv).astype(np.float32), corners.reshape(-1, 3).astype(np.int32),
        surface.normal(uv).astype(np.float32), Mirror(), surface=surface, parameters=uv,
    )  # fmt: skip


def test_surface_truth_bends_at_the_exact_nurbs():
    nurbs = sphere_surface()
    side = np.linspace(-0.1, 0.1, 7)
    uv = np.stack(np.meshgrid(1.5 + side, 1.0 + side), axis=-1).reshape(-1, 2)
    mesh = cap(nurbs, uv)
    ball = Sphere(CENTER, RADIUS)
    middle = mesh.positions.mean(axis=0)
    camera = Camera(tuple(middle + 0.8 * mesh.normals.mean(axis=0)), tuple(middle), (0.0, 0.0, 1.0), 20.0)
    records = []
    for surface, parameters in ((nurbs, uv), (ball, ball.parameters(mesh.positions))):
        exact = Mesh("mirror", mesh.positions, mesh.faces, mesh.normals, Mirror(), None, None, surface, parameters)
        scene = Scene("cap", (exact,), camera)
        geometry = flatten(scene)
        records.append(drain(PathTracer(scene, geometry, Caster(geometry)).tracing(eye_rays(camera, (32, 24)))))
    assert (records[0][:, 7].view(np.uint32) >> 24 == 1).mean() > 0.3
    np.testing.assert_allclose(records[0][:, [0, 1, 2, 4, 5, 6]], records[1][:, [0, 1, 2, 4, 5, 6]], atol=2e-7)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("poles", np.zeros((9, 4, 3))),
        ("weights", np.zeros((9, 5))),
        ("knots_u", np.full(12, np.nan)),
        ("knots_u", QUARTERS[::-1].copy()),
        ("knots_v", np.ones(8)),
        ("degree_v", 0),
    ],
)
def test_numbers_that_make_no_surface_are_refused_in_one_line(name, value):
    numbers = {field: getattr(sphere_surface(), field) for field in ("poles", *FIELDS)}
    with pytest.raises(AnamorphError, match=r"^NURBS: [^\n]*$"):
        NurbsSurface(**{**numbers, name: value})
