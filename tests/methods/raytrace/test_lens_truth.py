"""raytrace:truth=raymesh behind lenses: the interpolated ray that leaves the far face."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import anamorph as an
from anamorph import gallery
from anamorph.base.steps import drain
from anamorph.frame import Status
from anamorph.measure.errors import measure
from anamorph.methods.tracing import paths
from anamorph.methods.tracing.launch import eye_rays
from anamorph.methods.tracing.paths import PathTracer
from anamorph.methods.tracing.vertex_rays import vertex_rays
from anamorph.optics.ray_meshes import bodies_of
from anamorph.optics.refraction import refracted_rays, refractor
from anamorph.raymesh import RayStatus
from anamorph.rays.caster import Caster
from anamorph.scene.geometry import flatten
from anamorph.scene.lens_pairs import scene_glass
from anamorph.scene.model import Glass

SIZE = (160, 120)


@pytest.mark.parametrize("name", ["spectacles-minus", "spectacles-plus", "magnifier"])
def test_it_is_near_to_the_surfaces_truth_but_not_the_same(name):
    scene = gallery.make(name)
    surface, raymesh = (an.render(scene, f"raytrace:truth={truth}", size=SIZE, seen=True) for truth in
                        ("surface", "raymesh"))  # fmt: skip
    errors = measure(surface, raymesh)
    assert 1e-4 < errors.pixels.median < 0.03 and errors.pixels.p95 < 0.05
    assert errors.other_object_percent == 0.0
    assert (surface.specular == raymesh.specular).all() and (surface.status == raymesh.status).all()
    # The same light gets through: Fresnel's share and the tint of both faces, of all three colours.
    seen = (surface.specular > 0) & (surface.object_id == raymesh.object_id)
    assert np.percentile(np.abs(surface.color - raymesh.color)[seen], 90.0) < 5e-3


def test_the_ray_is_the_ray_meshs_between_vertices():
    scene = gallery.make("magnifier")
    tinted = Glass(1.5, tint=(0.9, 0.8, 0.7))
    meshes = (replace(mesh, material=tinted) if mesh.specular else mesh for mesh in scene.meshes)
    scene = replace(scene, meshes=tuple(meshes))
    geometry, eye = flatten(scene), scene.camera.eye(SIZE)
    lens = scene_glass(scene).lenses[0]
    records = drain(
        PathTracer(scene, geometry, Caster(geometry), truth="raymesh").tracing(eye_rays(scene.camera, SIZE))
    )
    words = records.view(np.uint32)
    status, bounces = (words[:, 7] >> 16) & 0xFF, words[:, 7] >> 24
    through = (
        np.isin(words[:, 7] & 0xFFFF, (lens.front + 1, lens.back + 1)) & (bounces == 2) & (status == Status.TRACED)
    )
    assert through.sum() > 500
    near = int(np.unique(words[through, 7] & 0xFFFF)[0]) - 1
    far = lens.back if near == lens.front else lens.front
    mesh = refracted_rays(refractor(scene.meshes[near], scene.meshes[far]), eye)
    hits = Caster(geometry).cast(*_eye_rays(scene.camera))
    own = np.flatnonzero(through & (hits.triangle >= 0))[::37]
    corners = geometry.faces[hits.triangle[own]] - geometry.first_vertex[near]
    weights = np.column_stack([1.0 - hits.barycentric[own].sum(axis=1), hits.barycentric[own]])
    origin = np.einsum("nc,ncd->nd", weights, mesh.origins[corners])
    direction = np.einsum("nc,ncd->nd", weights, mesh.directions[corners])
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    assert records[own, 0:3] == pytest.approx(origin, abs=2e-6)
    assert records[own, 4:7] == pytest.approx(direction, abs=2e-5)
    share = np.einsum("nc,nc->n", weights, mesh.transmittance[corners])
    tint = np.array(scene.meshes[near].material.tint) * scene.meshes[far].material.tint
    assert records[own, 8:11] == pytest.approx(share[:, None] * tint, abs=1e-4)


def _eye_rays(camera):
    x, y = np.meshgrid(np.arange(SIZE[0]) + 0.5, np.arange(SIZE[1]) + 0.5)
    looks = camera.directions(np.stack([x.ravel(), y.ravel()], axis=-1), SIZE)
    return np.broadcast_to(np.asarray(camera.position), looks.shape), looks


def test_only_rays_that_leave_by_the_far_face_are_interpolated():
    scene = gallery.make("spectacles-minus")
    geometry, eye = flatten(scene), scene.camera.eye(SIZE)
    bodies = bodies_of(scene, geometry)
    rays = vertex_rays(bodies, geometry, eye, 1)
    for lens in scene_glass(scene).lenses:
        for near, far in ((lens.front, lens.back), (lens.back, lens.front)):
            mesh = refracted_rays(refractor(scene.meshes[near], scene.meshes[far]), eye)
            own = slice(geometry.first_vertex[near], geometry.first_vertex[near + 1])
            lost = np.isin(mesh.status, (RayStatus.TOTAL_REFLECTION, RayStatus.LEFT_BY_EDGE))
            assert (rays.leaves[own] == ~lost).all()
            assert rays.far[near + 1] == far + 1
    red, blue = (vertex_rays(bodies, geometry, eye, line).directions for line in (0, 2))
    assert not np.array_equal(red, blue)


def test_light_that_cannot_leave_by_the_far_face_goes_on_as_at_the_surfaces(monkeypatch):
    scene = gallery.make("magnifier")
    geometry = flatten(scene)
    truth, mesh = (PathTracer(scene, geometry, Caster(geometry), truth=each) for each in ("surface", "raymesh"))

    def no_ray_leaves(*arguments):
        rays = vertex_rays(*arguments)
        return rays._replace(leaves=np.zeros_like(rays.leaves))

    monkeypatch.setattr(paths, "vertex_rays", no_ray_leaves)
    expected, found = (drain(tracer.tracing(eye_rays(scene.camera, SIZE))).view(np.uint32) for tracer in (truth, mesh))
    assert (found == expected).all()
