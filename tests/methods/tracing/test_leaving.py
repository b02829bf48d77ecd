"""Rays leave a surface by what it is and by their own rounding, however large the scene is."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import flat_mirror

from anamorph.base.steps import drain
from anamorph.frame import Status
from anamorph.gallery.solids import ball, box, globe
from anamorph.lenses.making import worn_lens
from anamorph.lenses.prescription import Prescription
from anamorph.methods.tracing.launch import GivenRays
from anamorph.methods.tracing.paths import PathTracer
from anamorph.optics.laws import reflect
from anamorph.rays.caster import Caster
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Diffuse, Glass, Mesh, Mirror, Scene
from anamorph.scene.nearness import moved_scene, origin_of
from anamorph.surfaces.sphere import Sphere

CAMERA = Camera((0.0, 0.0, 1.0), (0.0, 0.0, 0.0))


def traced(meshes, origins, directions):
    """The records of given rays, (N, 16), and the object that each ends at."""
    scene = Scene("test", tuple(meshes), CAMERA)
    geometry = flatten(scene)
    tracer = PathTracer(scene, geometry, Caster(geometry))
    records = drain(tracer.tracing(GivenRays(np.asarray(origins, float), np.asarray(directions, float))))
    triangle = records.view(np.int32)[:, 3]
    return records, np.where(triangle < 0, 0, geometry.face_object[triangle])


def ground(half):
    return box((-half, -3.0, -half), (half, -2.0, half)).mesh("ground", Diffuse())


@pytest.mark.parametrize("half", [100.0, 5e3, 2e5])
def test_a_spectacle_lens_bends_light_alike_on_any_ground(half):
    lens = worn_lens(Prescription(sphere=-4.0), eye=(0.0, 0.0, 0.0), gaze=(0.0, 0.0, -1.0))
    x, y = (each.ravel() for each in np.meshgrid(np.linspace(-0.6, 0.6, 41), np.linspace(-0.6, 0.6, 41)))
    directions = np.stack([x, y, -np.ones_like(x)], axis=-1)
    alone, _ = traced(lens.meshes, np.zeros_like(directions), directions)
    found, _ = traced([*lens.meshes, ground(half)], np.zeros_like(directions), directions)
    np.testing.assert_allclose(found[:, 4:7], alone[:, 4:7], atol=1e-6)
    assert (found.view(np.uint32)[:, 7] >> 24 == 2).all(), "both faces"


@pytest.mark.parametrize("half", [100.0, 2e5])
def test_a_pane_of_a_tenth_of_a_millimetre_shifts_a_ray_aside(half):
    """By Snell's law, however thin."""
    thickness, index = 1e-4, 1.5
    pane = box((-0.1, -0.1, -thickness), (0.1, 0.1, 0.0)).mesh("pane", Glass(index))
    angle = 0.6
    directions = np.array([[np.sin(angle), 0.0, -np.cos(angle)]])
    origins = -0.3 * directions
    found, _ = traced([pane, ground(half)], origins, directions)
    inside = np.arcsin(np.sin(angle) / index)
    shift = thickness * np.sin(angle - inside) / np.cos(inside)
    offset = found[0, :3] - origins[0]
    aside = offset - (offset @ directions[0]) * directions[0]
    np.testing.assert_allclose(found[:, 4:7], directions, atol=1e-6)
    assert np.linalg.norm(aside) == pytest.approx(shift, rel=1e-2)


def test_what_stands_just_above_a_mirror_is_seen_in_it_on_a_large_ground():
    roof = box((-1.0, 0.0, 2e-5), (1.0, 1.0, 1e-3)).mesh("roof", Diffuse())
    slit = np.array([[0.0, 0.5, 1e-5]])
    _, seen = traced([flat_mirror(), roof, ground(5e3)], slit, [[0.3, 0.0, -1.0]])
    assert seen.tolist() == [2]


@pytest.mark.parametrize("place", [(0.0, 0.0, 0.0), (3.0, 1.0, -7.0)])
@pytest.mark.parametrize("fineness", [1, 2, 4])
def test_a_ball_of_triangles_never_sees_itself(place, fineness):
    """Along its outline interpolated normals send rays into its own mesh."""
    center = np.array(place)
    mirror = ball(fineness, 0.5, place).mesh("ball", Mirror())
    eye = center + np.array([0.0, 0.2, 2.0])
    x, y = (each.ravel() for each in np.meshgrid(np.linspace(-0.27, 0.27, 301), np.linspace(-0.37, 0.17, 301)))
    directions = np.stack([x, y, -np.ones_like(x)], axis=-1)
    records, seen = traced([mirror], np.broadcast_to(eye, directions.shape), directions)
    meets = records.view(np.uint32)[:, 7] & 0xFFFF == 1
    assert meets.sum() > 10_000
    assert (seen[meets] == 0).all()


def test_the_ray_at_a_balls_triangle_is_reflected_by_the_interpolated_normal():
    mirror = ball(5, 0.5, (0.0, 0.0, 0.0)).mesh("ball", Mirror())
    directions = np.array([[0.02, 0.03, -1.0], [0.1, -0.05, -1.0]])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    records, _ = traced([mirror], np.tile([0.0, 0.0, 2.0], (2, 1)), directions)
    normals = records[:, :3] / np.linalg.norm(records[:, :3], axis=1, keepdims=True)
    np.testing.assert_allclose(records[:, 4:7], reflect(directions, normals), atol=2e-3)


@pytest.mark.parametrize(
    "prescription",
    [Prescription(sphere=-4.0), Prescription(sphere=3.0, centre_thickness=5.0), Prescription(-7.0, -0.75, 140.0)],
    ids=str,
)
def test_the_seams_of_a_lens_edge_leak_no_ray(prescription):
    """Light that ends in the sky has crossed as many faces inward as outward, but where it was reflected totally.

    What meets a seam itself to the last bit may go either way.
    """
    lens = worn_lens(prescription, eye=(0.0, 0.0, 0.0), gaze=(0.0, 0.0, -1.0))
    random, count = np.random.default_rng(3), 100_000
    border = np.asarray(lens.edge.positions, float)[lens.edge.faces]
    weights = random.dirichlet([0.3, 0.3, 0.3], count)
    points = np.einsum("nk,nkj->nj", weights, border[random.integers(0, len(border), count)])
    points += random.normal(size=points.shape) * 10 ** random.uniform(-6.5, -3.0, (count, 1))
    directions = random.normal(size=points.shape)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    records, seen = traced(lens.meshes, points - 0.2 * directions, directions)
    flags = records.view(np.uint32)[:, 7]
    bounces, plain = flags >> 24, flags >> 16 & 0xFF != Status.TOTAL_REFLECTION
    assert (bounces > 0).sum() > 10_000
    assert ((seen == 0) & plain & (bounces % 2 == 1)).sum() <= 1e-5 * count


@pytest.mark.parametrize("place", [np.zeros(3), np.array([5e3, -20.0, 3e3])], ids=["near", "far"])
def test_the_faces_of_a_lens_and_its_edge_share_their_border_to_the_last_bit(place):
    lens = worn_lens(Prescription(sphere=3.0, centre_thickness=5.0), eye=tuple(place), gaze=(0.0, 0.0, -1.0))
    scene = Scene("test", lens.meshes, CAMERA.moved(place))
    scene = moved_scene(scene, -origin_of(scene))
    geometry = flatten(scene)
    vertices = np.split(geometry.positions, geometry.first_vertex[1:-1])
    front, back, edge = (set(map(tuple, part)) for part in vertices)
    assert edge <= front | back
    assert len(edge) == len(vertices[2])


def test_the_foot_of_a_post_on_a_ball_is_seen_in_the_ball():
    """From 0.2 to 10 mm beside the foot, where the ray meets the post's side by closed form."""
    radius, half = 0.5, 0.02
    parameters, faces = globe(300, 600)
    mirror = Mesh.exact("ball", Sphere(np.zeros(3), radius), parameters, faces, Mirror())
    post = box((-half, radius - 2e-3, -half), (half, radius + 0.3, half)).mesh("post", Diffuse())
    x = half + np.geomspace(2e-4, 1e-2, 400)
    z = np.linspace(-0.9, 0.9, 400) * half
    points = np.stack([x, np.sqrt(radius**2 - x**2 - z**2), z], axis=-1)
    directions = points - [0.9, 0.8, 0.1]
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    reflected = reflect(directions, points / radius)
    distance = (half - points[:, 0]) / reflected[:, 0]
    records, seen = traced([mirror, post, ground(5e3)], points - 0.5 * directions, directions)
    meets = np.abs(points[:, 2] + distance * reflected[:, 2]) < 0.999 * half
    assert meets.sum() > 300
    assert (seen[meets] == 2).all()
    np.testing.assert_allclose(records[meets, 11], distance[meets], rtol=1e-4, atol=1e-6)
