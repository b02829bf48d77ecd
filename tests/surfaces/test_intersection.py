"""Hits on exact surfaces: on the ray, on the surface, and the right one of several."""

from __future__ import annotations

import numpy as np
import pytest

from anamorph.base.errors import AnamorphError
from anamorph.surfaces.bezier import BezierPatch
from anamorph.surfaces.intersection import intersect, pack
from anamorph.surfaces.plane import Plane
from anamorph.surfaces.sphere import Sphere


def rays_at(points, seed=0, spread=1.0):
    """Rays from scattered eyes through `points`."""
    random = np.random.default_rng(seed)
    origins = np.array([0.2, 0.3, 4.0]) + random.normal(scale=spread, size=points.shape) * [1, 1, 0.1]
    directions = points - origins
    return origins, directions / np.linalg.norm(directions, axis=1, keepdims=True)


def test_a_ray_along_a_plane_or_away_from_it_is_not_ok():
    plane = Plane(np.zeros(3), np.array([1.0, 0, 0]), np.array([0.0, 1, 0]))
    origins, directions = [[0, 0, 1.0], [0, 0, -1.0], [0, 0, 1.0]], [[1, 0, 0.0], [1, 0, 0.0], [0, 0, 1.0]]
    *_, ok = intersect(plane, origins, directions, np.zeros((3, 2)))
    assert not ok.any()


@pytest.mark.parametrize("radius", [1e-3, 1.0, 50.0])
def test_sphere_takes_the_root_nearest_the_mesh(radius):
    sphere = Sphere(np.array([0.1, 0.2, -0.3]), radius)
    random = np.random.default_rng(0)
    uv = np.stack([random.uniform(-np.pi, np.pi, 60), random.uniform(-1.5, 1.5, 60)], axis=-1)
    points = sphere.position(uv)
    origins = sphere.center + radius * np.array([0.0, 0.0, 5.0]) + random.normal(scale=radius, size=(60, 3)) * 0.3
    directions = (points - origins) / np.linalg.norm(points - origins, axis=1, keepdims=True)
    graze = np.abs(np.sum(directions * sphere.normal(uv), axis=1)) > 0.1
    positions, normals, ok = intersect(sphere, origins, directions, uv)
    assert ok[graze].all() and graze.sum() > 30
    assert np.allclose(positions[graze], points[graze], atol=1e-12 * radius)
    assert np.allclose(normals[graze], sphere.normal(uv)[graze], atol=1e-11)


def test_a_ray_past_a_sphere_is_not_ok():
    *_, ok = intersect(Sphere(np.zeros(3), 1.0), [[1.0 + 1e-9, 0, 3]], [[0, 0, -1.0]], [[0.5, 0.0]])
    assert not ok[0]


def curved_patch():
    random = np.random.default_rng(3)
    x, y = np.meshgrid(np.arange(4) / 3.0, np.arange(4) / 3.0, indexing="ij")
    return BezierPatch(np.stack([x, y, 0.25 * random.normal(size=(4, 4))], axis=-1))


def test_patch_converges_from_a_nearby_start():
    patch = curved_patch()
    random = np.random.default_rng(1)
    uv = np.concatenate([random.uniform(0, 1, (300, 2)), [[0, 0], [1, 1], [0, 0.5], [0.5, 1]]])
    origins, directions = rays_at(patch.position(uv), spread=0.3)
    start = np.clip(uv + random.normal(scale=0.03, size=uv.shape), 0, 1)
    positions, normals, ok = intersect(patch, origins, directions, start)
    assert ok.all()
    assert np.allclose(positions, patch.position(uv), atol=1e-11)
    assert np.allclose(normals, patch.normal(uv), atol=1e-9)


def test_patch_from_a_far_start_is_on_the_ray_and_on_the_patch_or_not_ok():
    patch = curved_patch()
    random = np.random.default_rng(2)
    origins, directions = rays_at(patch.position(random.uniform(0, 1, (300, 2))), spread=2.0)
    positions, normals, ok = intersect(patch, origins, directions, random.uniform(0, 1, (300, 2)))
    assert ok.mean() > 0.5
    assert np.allclose(np.cross(positions - origins, directions)[ok], 0.0, atol=1e-9)
    assert np.isfinite(positions).all() and np.isfinite(normals).all()
    assert np.allclose(np.linalg.norm(normals[ok], axis=1), 1.0)


def test_a_ray_past_a_patch_is_not_ok():
    *_, ok = intersect(curved_patch(), [[5.0, 5, 3]], [[0, 0, -1.0]], [[0.5, 0.5]])
    assert not ok[0]


def test_a_pole_is_not_ok_and_near_it_is():
    control = curved_patch().control.copy()
    control[:, 0] = control[0, 0]
    patch = BezierPatch(control)
    uv = np.array([[0.5, 0.0], [0.5, 1e-3]])
    origins, directions = rays_at(patch.position(uv), spread=0.0)
    _, normals, ok = intersect(patch, origins, directions, uv)
    assert ok.tolist() == [False, True]
    assert np.allclose(normals[1], patch.normal(uv)[1], atol=1e-6)
    assert np.isfinite(normals).all()


def test_an_unknown_surface_is_named():
    class Torus:
        def position(self, uv):
            return uv

        normal = position

    with pytest.raises(AnamorphError, match="Torus"):
        pack(Torus())
