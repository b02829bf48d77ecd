"""The outline of a mirror or a lens is that of its exact surface."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import drawn, open_view, scene_with, spherical_mirror

from anamorph.gallery.solids import globe
from anamorph.methods import METHODS
from anamorph.optics.tessellation import OUTLINE, outline_errors, outlined_scene
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import flatten
from anamorph.scene.lens_pairs import border_edges
from anamorph.scene.model import Glass, Mesh, Mirror, Scene
from anamorph.surfaces.sphere import Sphere

CENTER, RADIUS = np.array([0.1, 0.5, -0.2]), 0.4
EYE = Camera((0.5, 0.9, 1.6), (0.15, 0.45, -0.2), field_of_view=40.0)
SIZE = (320, 240)


def ball(material=None, center=CENTER, name="ball"):
    """Of 6 x 12 cells: far too few for its outline."""
    parameters, faces = globe(6, 12)
    return Mesh.exact(name, Sphere(center, RADIUS), parameters, faces, material or Mirror())


def clearance(camera, size, center=CENTER):
    """How far outside a ball's outline each pixel's centre is, (H, W), in pixels; negative on the ball. To first order
    in the distance, by the angle between the ray and the centre."""
    directions = camera.pixel_directions(size)
    toward = center - np.asarray(camera.position)
    angle = np.arccos(np.clip(directions @ toward / np.linalg.norm(toward), -1.0, 1.0))
    beyond = angle - np.arcsin(RADIUS / np.linalg.norm(toward))
    ahead = directions @ camera.axes()[2]
    focal = size[1] / (2.0 * np.tan(np.radians(camera.field_of_view) / 2.0))
    return beyond * focal / ahead


@pytest.mark.parametrize("method", METHODS)
def test_every_method_draws_a_coarse_ball_within_its_analytic_outline(method):
    outside = clearance(EYE, SIZE)
    on = drawn(scene_with(ball(), camera=EYE), method, SIZE).specular > 0
    assert on[outside < -OUTLINE].all()
    assert not on[outside > OUTLINE].any()
    assert (np.abs(outside) < OUTLINE).sum() > 100


def test_the_outline_of_a_ball_of_glass_is_its_own():
    outside = clearance(EYE, SIZE)
    on = drawn(scene_with(ball(Glass(1.5)), camera=EYE), "raytrace", SIZE).specular > 0
    assert on[outside < -OUTLINE].all() and not on[outside > OUTLINE].any()


def test_what_the_ball_shows_is_reflected_by_the_sphere():
    """Up to its outline: the last rays are those of the sphere, to 1e-5 radians."""
    frame = drawn(Scene("test", (ball(),), EYE), "raytrace", SIZE)
    on = frame.specular > 0
    incident = EYE.pixel_directions(SIZE)[on]
    toward = CENTER - np.asarray(EYE.position)
    middle = incident @ toward
    half = np.sqrt(np.maximum(RADIUS**2 - (toward @ toward - middle**2), 0.0))
    normal = ((middle - half)[:, None] * incident - toward) / RADIUS
    expected = incident - 2.0 * np.sum(incident * normal, axis=1, keepdims=True) * normal
    # Where the sphere is met well: at the outline itself the reflected ray turns without bounds.
    well = clearance(EYE, SIZE)[on] < -1.0
    assert np.abs(frame.ray_direction[on] - expected)[well].max() < 1e-5


def test_two_balls_are_refined_alike():
    scene = outlined_scene(Scene("test", (ball(), ball(center=CENTER + np.array([0.9, 0.0, 0.0]))), EYE), EYE, SIZE)
    for mesh in scene.meshes:
        assert len(mesh.faces) > 1000
        assert outline_errors(mesh, EYE, SIZE).max() <= OUTLINE
        assert np.abs(np.linalg.norm(mesh.positions - mesh.surface.center, axis=1) - RADIUS).max() < 1e-8


def test_what_has_no_outline_of_its_own_is_refined_at_its_border_alone():
    """Inside of the border of a cap whose whole front is seen, all edges are as they were."""
    (coarse,) = (mesh for mesh in scene_with(spherical_mirror(count=2)).meshes if mesh.specular)
    scene = scene_with(coarse)
    (fine,) = (mesh for mesh in outlined_scene(scene, scene.camera, (1024, 768)).meshes if mesh.specular)
    new = np.setdiff1d(np.unique(fine.faces), np.unique(border_edges(fine)))
    assert len(fine.positions) > len(coarse.positions) and (new < len(coarse.positions)).all()


def test_vertices_are_numbered_as_before_where_a_scene_deforms():
    scene = scene_with(ball(), camera=EYE)
    session, geometry = open_view(scene, "raytrace", SIZE), flatten(scene)
    positions = geometry.positions.copy()
    positions[geometry.first_vertex[1] :] += [0.0, 0.05, 0.0]
    session.draw(EYE)
    before = session.frame(seen=True)
    session.deform(positions, geometry.normals)
    session.draw(EYE)
    after = session.frame(seen=True)
    assert (before.specular == after.specular).mean() > 0.99
    both = (before.object_id == after.object_id) & (before.object_id == 2) & (before.specular == 0)
    assert np.median(after.position[both][:, 1] - before.position[both][:, 1]) == pytest.approx(0.05, abs=1e-5)
