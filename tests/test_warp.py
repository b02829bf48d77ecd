"""Planning a map: each step of the paper against a twin written here, and what the plan promises of every mirror."""

from __future__ import annotations

import numpy as np
import pytest
from plans import plan_of, planned
from scenes import CAMERA, SIZE, flat_mirror, pixels_of, scene_with, spherical_mirror

from anamorph.methods.warp import _aligned, _near_normal
from anamorph.projection import map_frame
from anamorph.scene.camera import Camera

CURVED = scene_with(spherical_mirror())


def twin(scene, camera):
    """Steps 1 to 3 of the paper in float64: viewpoint, hits, and where the projection plane meets each line to it."""
    mesh, eye = scene.meshes[0], np.array(camera.position)
    normals = mesh.surface.normal(mesh.parameters)
    normals *= np.sign(np.sum(normals * mesh.normals, axis=1, keepdims=True))
    points = mesh.surface.position(mesh.parameters)
    incident = (points - eye) / np.linalg.norm(points - eye, axis=1, keepdims=True)
    reflected = incident - 2.0 * np.sum(incident * normals, axis=1, keepdims=True) * normals
    # 3.2: least squares over the stacked equations of the lines, each as often as there are pixels around its vertex
    x, y = pixels_of(camera, SIZE, points).T
    pixels = np.zeros(len(points))
    for a, b, c in mesh.faces:
        pixels[[a, b, c]] += abs(x[a] * (y[b] - y[c]) + x[b] * (y[c] - y[a]) + x[c] * (y[a] - y[b]))
    across = np.sqrt(pixels)[:, None, None] * (np.eye(3) - reflected[:, :, None] * reflected[:, None, :])
    right_side = np.einsum("nij,nj->ni", across, points).ravel()
    viewpoint = np.linalg.lstsq(across.reshape(-1, 3), right_side, rcond=None)[0]
    forward = pixels @ reflected
    # (3.1): nearest triangle, by Cramer's rule on all of them
    hits = np.full(points.shape, np.nan)
    best = np.full(len(points), np.inf)
    for other in scene.meshes[1:]:
        for a, b, c in np.asarray(other.positions, float)[other.faces]:
            system = np.stack([np.tile(b - a, (len(points), 1)), np.tile(c - a, (len(points), 1)), -reflected], axis=-1)
            solvable = np.abs(np.linalg.det(system)) > 1e-14
            u, v, t = np.full((3, len(points)), np.inf)
            u[solvable], v[solvable], t[solvable] = np.linalg.solve(
                system[solvable], (points - a)[solvable][..., None]
            )[..., 0].T
            found = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 1e-4) & (t < best)
            best[found] = t[found]
            hits[found] = (points + t[:, None] * reflected)[found]
    return points, reflected, viewpoint, forward / np.linalg.norm(forward), hits


def test_the_plan_is_the_papers_steps_in_double_precision():
    sight, plan = plan_of(CURVED)
    rays = sight.rays
    points, reflected, viewpoint, forward, hits = twin(CURVED, CAMERA)
    assert rays.origins == pytest.approx(points, abs=1e-12)
    assert rays.unit_directions() == pytest.approx(reflected, abs=1e-12)

    seen = np.isfinite(hits[:, 0])
    assert np.isfinite(plan.distances).tolist() == seen.tolist()
    assert plan.hits[seen] == pytest.approx(hits[seen], abs=2e-5)

    projection = plan.projections[0]
    # (3.2) and (3.3): the projection plane of the plan, and the line from the twin's viewpoint to the hit.
    axes = np.stack([projection.right, projection.up])
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    assert np.cross(*axes) == pytest.approx(-forward, abs=1e-9)
    lines = plan.hits - viewpoint
    crossing = viewpoint + (((projection.eye - viewpoint) @ forward) / (lines @ forward))[:, None] * lines
    places = (crossing - projection.eye) @ axes.T

    # (3.4): local coordinates of the picture, whose rectangle the map's own base, right and up span.
    distance = (projection.eye - viewpoint) @ forward
    middle = (viewpoint + distance * projection.base - projection.eye) @ axes.T
    half = distance * np.array([np.linalg.norm(projection.right), np.linalg.norm(projection.up)])
    expected = 0.5 + 0.5 * (places - middle) / half * [1.0, -1.0]
    assert plan.lookups[0, :, 3].all()
    assert plan.lookups[0, :, :2] / plan.lookups[0, :, 2:3] == pytest.approx(expected, abs=1e-7)
    assert (plan.lookups[0, :, :2] / plan.lookups[0, :, 2:3] >= 0.0).all()
    assert (plan.lookups[0, :, :2] / plan.lookups[0, :, 2:3] <= 1.0).all()


def test_the_view_volume_is_no_larger_than_the_hits_need():
    _, plan = plan_of(CURVED)
    places = plan.lookups[0, :, :2] / plan.lookups[0, :, 2:3]
    assert places.min(axis=0) == pytest.approx([0.0, 0.0], abs=0.02)
    assert places.max(axis=0) == pytest.approx([1.0, 1.0], abs=0.02)


def test_normals_that_cancel_out_leave_the_near_plane_across_the_view():
    """A corridor of mirrors: its rays agree, its normals do not."""
    frame = map_frame(np.array([0.0, 0.0, 1.0, 1.0]), np.zeros(3), np.diag([1.0, 1.0, -1.0]))
    normals, directions = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]), np.array([[0.0, 0.0, -1.0]] * 2)
    assert _near_normal(np.array([0.5, 0.5]), normals, directions, frame).tolist() == [0.0, 0.0, -1.0]


def test_the_maps_resolution_follows_the_pixels_that_it_fills():
    sizes = {}
    for size in [(80, 60), (160, 120), (640, 480)]:
        _, plan = plan_of(CURVED, size=size)
        sizes[size] = np.array(plan.texels)
    assert sizes[160, 120] == pytest.approx(2.0 * sizes[80, 60], rel=0.02)
    assert sizes[640, 480] == pytest.approx(4.0 * sizes[160, 120], rel=0.02)
    # A flat mirror's map is the mirror's own picture: about as many texels as pixels.
    flat = scene_with(flat_mirror(), camera=Camera((0, 0.5, 0.9), (0, 0.5, 0), field_of_view=32.0))
    _, plan = plan_of(flat)
    corners = pixels_of(flat.camera, SIZE, flat_mirror().positions)
    assert np.array(plan.texels) == pytest.approx(np.ptp(corners, axis=0), rel=0.05)


