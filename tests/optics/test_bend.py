"""A pixel's own ray, bent on the device at the exact surfaces of mirrors and lenses, against float64 and the tracer.

The point where a ray is bent may be off by 2e-7 of the body's size and 1e-7 of the eye's distance, over the cosine of
incidence; the direction by 1e-6 rad, and by what the surface turns on that way.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from bent_rays import Meeting, bent, meeting, origins_of
from curved_surfaces import height_field, mesh_on, torus_surface, wavy
from lens_scenes import AXES, CENTER, of_glass, slab

from anamorph.base.steps import drain
from anamorph.lenses.lens import Lens, lens_between
from anamorph.lenses.making import make_lens, worn_lens
from anamorph.lenses.prescription import Prescription
from anamorph.methods.tracing.launch import GivenRays
from anamorph.methods.tracing.paths import PathTracer
from anamorph.optics.dispersion import line_indices
from anamorph.optics.exact_sides import exact_sides
from anamorph.optics.laws import reflect
from anamorph.optics.ray_meshes import bodies_of
from anamorph.optics.refraction import refracted_rays
from anamorph.raymesh import RayMesh, RayStatus
from anamorph.rays.caster import Caster
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Glass, Mirror, Scene
from anamorph.surfaces.bezier import BezierPatch
from anamorph.surfaces.device_numbers import PATCH, ROUND, TOROID
from anamorph.surfaces.even_asphere import EvenAsphere
from anamorph.surfaces.intersection import meet_all, pack
from anamorph.surfaces.plane import Plane
from anamorph.surfaces.similarity import Similarity, rotation
from anamorph.surfaces.sphere import Sphere, round_surface
from anamorph.surfaces.toroid import Toroid

MISSED = 4
CAMERA = Camera((0.0, 0.0, 1.0), (0.0, 0.0, 0.0))
TURN = Similarity(1.0, rotation((20.0, 30.0, -10.0)), np.array([0.3, -0.2, 0.1]))

MIRRORS = {
    "plane": (Plane(np.zeros(3), *np.eye(3)[:2]), (-0.5, -0.5), (0.5, 0.5), 1.0),
    "cap": (Sphere(np.zeros(3), 1.4), (-0.3, -0.3), (0.3, 0.3), 1.0),
    "ball": (Sphere(np.zeros(3), 0.5), (-3.1, -1.5), (3.1, 1.5), 1.0),
    "concave": (Sphere(np.zeros(3), 1.4), (-0.3, -0.3), (0.3, 0.3), -1.0),
    "all but flat": (round_surface(np.zeros(3), np.eye(3), 2e-6), (-2e-7, -2e-7), (2e-7, 2e-7), 1.0),
    "toroid": (Toroid(np.zeros(3), 0.9, -0.4), (-0.4, -0.4), (0.4, 0.4), 1.0),
    "asphere": (EvenAsphere(np.zeros(3), 0.8, -0.7, (0.1, -0.05)), (-0.4, -0.4), (0.4, 0.4), 1.0),
    "patch": (wavy().moved(Similarity(3.0, np.eye(3), np.zeros(3))), (0.0, 0.0), (1.0, 1.0), 1.0),
    "height field": (height_field(), (0.0, 0.0), (2.0, 2.0), 1.0),
    "torus": (torus_surface(0.35, 0.15), (0.0, 0.0), (4.0, 4.0), 1.0),
}
"""Surfaces about a metre large, the box of parameters that is a mirror, and which side."""


def mirror_scene(name: str, scale: float, cells: tuple[int, int] = (24, 20)) -> Scene:
    """The mirror, turned, moved by about its size, and made larger."""
    surface, low, high, side = MIRRORS[name]
    mesh = mesh_on(surface, low, high, cells, side).moved(TURN)
    mesh = mesh.moved(Similarity(scale, np.eye(3), np.zeros(3)))
    return Scene(name, (replace(mesh, material=Mirror(reflectance=0.7)),), CAMERA)


def size_of(rays: Meeting) -> float:
    return float(np.ptp(rays.geometry.positions, axis=0).max())


def aimed(scene: Scene, distance: float, count: int = 3000, seed: int = 0) -> Meeting:
    """Rays from eyes `distance` sizes away, all around, at points near the vertices of its specular meshes."""
    random = np.random.default_rng(seed)
    meshes = [mesh for mesh in scene.meshes if mesh.specular]
    positions = np.concatenate([mesh.positions for mesh in meshes]).astype(float)
    size = np.ptp(positions, axis=0).max()
    targets = positions[random.integers(0, len(positions), count)] + 0.02 * size * random.normal(size=(count, 3))
    around = random.normal(size=(count, 3))
    around *= distance * size / np.linalg.norm(around, axis=1, keepdims=True)
    return meeting(scene, positions.mean(axis=0) + around, targets)


def unit_directions(rays: Meeting) -> np.ndarray:
    directions = rays.directions.astype(float)
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


def flat_normals(rays: Meeting) -> np.ndarray:
    """Unit normals of the triangles that rays hit, against them."""
    a, b, c = np.moveaxis(rays.geometry.positions[rays.geometry.faces[rays.faces]].astype(float), 1, 0)
    area = np.cross(b - a, c - a)
    return area / np.linalg.norm(area, axis=1, keepdims=True)


def exactly_met(rays: Meeting, mesh: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where rays that hit the triangles of a mesh meet its exact surface: positions, normals against them, and ok."""
    geometry, directions, flat = rays.geometry, unit_directions(rays), flat_normals(rays)
    corners, own = geometry.faces[rays.faces], rays.scene.meshes[mesh]
    a, b, c = np.moveaxis(geometry.positions[corners].astype(float), 1, 0)
    eyes = rays.eyes.astype(float)
    distances = np.sum(flat * (a - eyes), axis=1) / np.sum(flat * directions, axis=1)
    edges = np.stack([b - a, c - a], axis=-1)
    inside = np.einsum("nij,nj->ni", np.linalg.pinv(edges), eyes + distances[:, None] * directions - a)
    weights = np.column_stack([1.0 - inside.sum(axis=1), inside])
    uv = np.einsum("nk,nki->ni", weights, own.parameters[corners - geometry.first_vertex[mesh]])
    points, normals, met = np.empty_like(eyes), np.empty_like(eyes), np.empty(len(eyes), bool)
    meet_all(*pack(own.surface), eyes, directions, distances, uv, flat, points, normals, met)
    return points, np.where(np.sum(normals * directions, axis=1, keepdims=True) > 0.0, -normals, normals), met


def curvature_of(rays: Meeting, points: np.ndarray, mesh: int = 0) -> np.ndarray:
    own = rays.scene.meshes[mesh]
    near = own.parameters[rays.geometry.faces[rays.faces][:, 0] - rays.geometry.first_vertex[mesh]]
    return np.abs(own.surface.curvatures(own.surface.parameters(points, near))).max(axis=1)


@pytest.mark.parametrize("distance", [0.8, 30.0, 1000.0])
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("name", MIRRORS)
def test_a_mirror_bends_rays_as_float64_does(name, scale, distance):
    rays = aimed(mirror_scene(name, scale), distance)
    found, (points, normals, ok) = bent(rays), exactly_met(rays, 0)
    directions = unit_directions(rays)
    cosine = -np.sum(normals * directions, axis=1)
    fit = ok & (cosine > 0.02) & (found["way"] == RayStatus.OK)
    assert fit[cosine > 0.1].mean() > 0.97 and fit.sum() > 500
    away = np.linalg.norm(points - rays.eyes, axis=1)
    off = (2e-7 * size_of(rays) + 1e-7 * away) / np.maximum(cosine, 0.02)
    assert (np.linalg.norm(origins_of(rays, found) - points, axis=1) <= off)[fit].all()
    error = np.linalg.norm(found["direction"] - reflect(directions, normals), axis=1)
    turned = curvature_of(rays, points) * off
    assert (error <= 2e-6 + 2.0 * turned)[fit].all()
    if distance < 1.0:
        assert np.median(error[fit]) <= 1e-6
    dimmer = np.abs(found["transmittance"] - (0.7 + 0.3 * (1.0 - cosine) ** 5))
    assert (dimmer <= 1e-6 + 1.5 * turned)[fit].all()


def traced(rays: Meeting, bounces: int, line: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """The tracer's records of the same rays, (N, 16) float32, and their words."""
    tracer = PathTracer(rays.scene, rays.geometry, Caster(rays.geometry), bounces)
    given = GivenRays(rays.eyes.astype(float), unit_directions(rays))
    records = drain(tracer.tracing(given))
    return records, records.view(np.uint32)


def plain(scene: Scene) -> Scene:
    return replace(scene, meshes=tuple(replace(mesh, surface=None, parameters=None) for mesh in scene.meshes))


@pytest.mark.parametrize(("lean", "most", "middle"), [(0.4, 1e-4, 1e-6), (1.5, 1e-3, 2e-6)])
@pytest.mark.parametrize("name", ["cap", "ball", "patch", "torus"])
def test_a_plain_mesh_bends_rays_as_the_tracer_does(name, lean, most, middle):
    scene = plain(mirror_scene(name, 1.0, (9, 7)))
    # Normals that lean send some rays through the triangles; some that lean more are turned away and short.
    leaning = scene.meshes[0].normals + lean * np.random.default_rng(1).normal(size=scene.meshes[0].normals.shape)
    leaning /= np.linalg.norm(leaning, axis=1, keepdims=True)
    scene = replace(scene, meshes=(replace(scene.meshes[0], normals=leaning.astype(np.float32)),))
    rays = aimed(scene, 1.5)
    found, (records, words) = bent(rays), traced(rays, 1)
    flat, once = flat_normals(rays), words[:, 7] >> 24 == 1
    assert once.mean() > 0.95 and (found["way"] == RayStatus.OK).all()
    steep = once & (np.abs(np.sum(flat * rays.directions, axis=1)) > 0.05)
    np.testing.assert_allclose(origins_of(rays, found)[steep], records[steep, :3], atol=2e-6)
    # Where a ray just stays on its side, a hair decides whether it is bent back.
    error = np.linalg.norm(found["direction"] - records[:, 4:7], axis=1)[steep]
    assert error.max() < most and np.median(error) < middle
    np.testing.assert_allclose(found["transmittance"][steep], records[steep, 8], atol=1e-4)
    held = np.abs(np.sum(flat * found["direction"], axis=1)) < 1e-6
    assert held.sum() > 20, "some rays would go through the triangles"


def test_rays_that_pass_the_exact_surface_by_are_bent_at_the_mesh():
    scene = mirror_scene("ball", 1.0)
    mesh = scene.meshes[0]
    middle = np.asarray(mesh.surface.center)
    swollen = (middle + 1.05 * (mesh.positions - middle)).astype(np.float32)
    rays = aimed(replace(scene, meshes=(replace(mesh, positions=swollen),)), 2.0)
    found, (records, words) = bent(rays), traced(rays, 1)
    to_middle = middle - rays.eyes
    across = np.linalg.norm(np.cross(to_middle, unit_directions(rays)), axis=1) / mesh.surface.radius
    assert ((found["way"] == MISSED) == (across > 1.0))[np.abs(across - 1.0) > 1e-5].all()
    missed = (found["way"] == MISSED) & (words[:, 7] >> 24 == 1)
    assert missed.sum() > 50
    assert np.linalg.norm(found["direction"] - records[:, 4:7], axis=1)[missed].max() < 5e-5


def test_faces_that_are_wound_the_other_way_bend_rays_alike():
    for scene in (mirror_scene("cap", 1.0), plain(mirror_scene("cap", 1.0))):
        rays = aimed(scene, 1.5)
        turned = replace(rays.geometry, faces=rays.geometry.faces[:, ::-1], normals=-rays.geometry.normals)
        one, other = bent(rays), bent(rays._replace(geometry=turned))
        np.testing.assert_allclose(other["direction"], one["direction"], atol=1e-5)


def test_an_exact_surface_behind_the_eye_is_not_met():
    scene = mirror_scene("ball", 1.0, (9, 7))
    mesh = scene.meshes[0]
    corners = mesh.positions[mesh.faces].astype(float)
    middles, away = corners.mean(axis=1), np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    deep = mesh.surface.radius - np.linalg.norm(middles - mesh.surface.center, axis=1)
    away *= (0.5 * deep / np.linalg.norm(away, axis=1))[:, None]
    found = bent(meeting(scene, middles + away, middles))
    assert len(found) > 50 and (found["way"] == MISSED).all()


def test_total_reflection_before_a_lens_of_less_than_the_index_around_it():
    lens = slab(0.7, vertices=547)
    rays = aimed(Scene("bubble", lens.meshes, CAMERA), 0.8)
    found, directions, normals = bent(rays), unit_directions(rays), flat_normals(rays)
    total = np.sum(normals * directions, axis=1) ** 2 < 1.0 - 0.7**2
    assert total.sum() > 100 and (found["way"][total] == RayStatus.TOTAL_REFLECTION).all()
    np.testing.assert_allclose(found["direction"][total], reflect(directions, normals)[total], atol=1e-6)
    assert (found["transmittance"][total] == 1.0).all()


def lens(prescription: Prescription, vertices: int = 547) -> Lens:
    return make_lens(prescription, tuple(CENTER.tolist()), (0.0, 0.0, -1.0), vertices=vertices)


def of_patches() -> Lens:
    """A lens whose faces are wavy patches."""
    grid = np.stack([*np.meshgrid(np.arange(4.0) - 1.5, np.arange(4.0) - 1.5, indexing="ij"), np.zeros((4, 4))], -1)
    faces = []
    for seed, along in ((0, 0.004), (1, 0.0)):
        control = 0.03 * grid
        control[..., 2] = along + 0.001 * np.random.default_rng(seed).normal(size=(4, 4))
        faces.append(BezierPatch(CENTER + control @ AXES))
    return lens_between(*faces, CENTER, AXES, 0.03, Glass(1.6))


def of_aspheres() -> Lens:
    front = EvenAsphere(CENTER + 0.009 * AXES[2], 12.0, -0.8, (150.0,), AXES)
    back = EvenAsphere(CENTER, 3.0, 0.3, (-200.0, 1e4), AXES * [[-1], [1], [-1]])
    return lens_between(front, back, CENTER, AXES, 0.028, Glass(1.5, abbe=50.0))


LENSES = {
    "minus": lens(Prescription(-6.0, diameter=80.0)),
    "plus": lens(Prescription(6.0, diameter=60.0, centre_thickness=9.0)),
    "toric": lens(Prescription(-3.0, cylinder=-2.5, axis=35.0)),
    "prism": lens(Prescription(-2.0, cylinder=1.0, axis=120.0, prism=4.0, base=60.0, centre_thickness=4.0)),
    "worn": worn_lens(Prescription(-7.0, diameter=70.0, abbe=30.0), (0.0, 0.5, 0.4), (0.1, 0.0, -1.0)),
    "slab": slab(1.5, 0.02, 0.06, vertices=547),
    "diamond": of_glass(lens(Prescription(4.0, diameter=40.0, centre_thickness=6.0)), Glass(2.4)),
    "aspheres": of_aspheres(),
    "patches": of_patches(),
}


def lens_scene(name: str, scale: float = 1.0) -> Scene:
    meshes = tuple(mesh.moved(Similarity(scale, np.eye(3), np.zeros(3))) for mesh in LENSES[name].meshes)
    return Scene(name, meshes, CAMERA)


class Eyes:
    """An eye of its own for each point, as `refracted_rays` asks for it."""

    def __init__(self, points: np.ndarray) -> None:
        self._points = points

    def offsets(self, points: np.ndarray) -> np.ndarray:
        return points - self._points

    def image(self, points: np.ndarray) -> np.ndarray:
        return np.zeros_like(points)


def seen_by(rays: Meeting, mesh: int) -> Meeting:
    """Those of the rays that meet one mesh."""
    own = rays.meshes == mesh
    return rays._replace(**{name: getattr(rays, name)[own] for name in ("eyes", "directions", "meshes", "faces")})


def through(rays: Meeting, line: int) -> tuple[RayMesh, np.ndarray]:
    """`refracted_rays` of rays that meet one face of a lens, from where they meet it exactly; and their cosines."""
    points, normals, _ = exactly_met(rays, rays.meshes[0])
    sides = {side.meshes[0]: side for side in bodies_of(rays.scene, rays.geometry)[0].sides}
    lens = sides[rays.meshes[0]].optics
    there = replace(lens, positions=points, normals=normals, faces=np.zeros((0, 3), np.int32))
    index = line_indices(lens.index, lens.abbe)[line]
    return refracted_rays(there, Eyes(rays.eyes.astype(float)), index), -np.sum(normals * unit_directions(rays), axis=1)


@pytest.mark.parametrize("distance", [0.8, 30.0])
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("name", [name for name in LENSES if name != "patches"])
def test_a_lens_bends_rays_as_float64_does(name, scale, distance):
    rays = aimed(lens_scene(name, scale), distance)
    for mesh in (0, 1):
        own = seen_by(rays, mesh)
        for line in range(3):
            found, (twin, cosine) = bent(own, line), through(own, line)
            # A ray at the very edge, or at the critical angle, may go either way.
            assert (found["way"] == twin.status).mean() >= 0.995
            fit = (found["way"] == RayStatus.OK) & (twin.status == RayStatus.OK) & (cosine > 0.02)
            assert fit.sum() > 100
            off = np.linalg.norm(origins_of(own, found) - twin.origins, axis=1)[fit]
            error = np.linalg.norm(found["direction"] - twin.unit_directions(), axis=1)[fit]
            dimmer = np.abs(found["transmittance"] - twin.transmittance)[fit]
            assert np.median(off) <= (1e-7 + 1e-7 * distance) * size_of(rays)
            assert np.median(error) <= 5e-7 + 5e-8 * distance
            assert np.quantile(error, 0.99) <= 2e-6 + 1e-6 * distance
            assert np.median(dimmer) <= 1e-6 + 2e-7 * distance
            total = (found["way"] == RayStatus.TOTAL_REFLECTION) & (twin.status == RayStatus.TOTAL_REFLECTION)
            aside = np.linalg.norm(found["direction"] - twin.unit_directions(), axis=1)[total & (cosine > 0.02)]
            assert (aside <= 1e-5 + 1e-5 * distance).all()


@pytest.mark.parametrize("name", LENSES)
def test_what_becomes_of_rays_in_a_lens_is_what_the_tracer_finds(name):
    rays = aimed(lens_scene(name), 0.8)
    found, (inside, words), (after, _) = bent(rays), traced(rays, 1), traced(rays, 2)
    geometry, next_face = rays.geometry, words[:, 3].view(np.int32)
    far_normals = flat_normals(rays._replace(faces=next_face))
    by_edge = geometry.face_object[next_face] == 3
    leaves = ~by_edge & (np.sum(after[:, 4:7] * far_normals, axis=1) > 0.0)
    ways = np.select([leaves, by_edge], [RayStatus.OK, RayStatus.LEFT_BY_EDGE], RayStatus.TOTAL_REFLECTION)
    # The mesh of an edge is a polygon, where the lens is round.
    assert (found["way"] == ways).mean() > 0.985
    both = leaves & (found["way"] == RayStatus.OK)
    error = np.linalg.norm(found["direction"] - after[:, 4:7], axis=1)[both]
    assert np.quantile(error, 0.99) < 5e-6 and both.sum() > 500
    np.testing.assert_allclose(found["transmittance"][both], after[both, 8], atol=1e-3)
    edge = by_edge & (found["way"] == RayStatus.LEFT_BY_EDGE)
    assert np.median(np.linalg.norm(found["direction"] - inside[:, 4:7], axis=1)[edge]) < 1e-6
    ends = inside[:, :3] + inside[:, 11:12] * inside[:, 4:7]
    assert np.median(np.linalg.norm(origins_of(rays, found) - ends, axis=1)[edge]) < 0.01 * size_of(rays)


def test_what_is_packed_says_each_mesh_of_a_scene():
    mirror = mirror_scene("height field", 1.0).meshes[0]
    lens = LENSES["prism"]
    scene = Scene("all", (mirror, *lens.meshes, *plain(mirror_scene("cap", 1.0)).meshes), CAMERA)
    geometry = flatten(scene)
    sides = exact_sides(scene, geometry, bodies_of(scene, geometry))
    assert sides.kinds.tolist() == [[PATCH, 0], [ROUND, TOROID], [TOROID, ROUND], [0, 0], [0, 0]]
    front, back = sides.records[1:3]
    assert front["reflectance"] == 0.0 and sides.records[0]["reflectance"] == np.float32(0.7)
    np.testing.assert_allclose(front["indices"][:3], line_indices(1.5, 58.0), rtol=1e-7)
    np.testing.assert_allclose(front["axis"][:3], -back["axis"][:3], atol=1e-6)
    np.testing.assert_allclose(front["radius"] * front["unit"], 0.03, rtol=1e-6)
    assert np.log2(sides.records["unit"][:3]).tolist() == np.log2(sides.records["unit"][:3]).round().tolist()
    uv = sides.parameters[: len(mirror.positions)]
    np.testing.assert_allclose(uv * 2.0, mirror.parameters, atol=1e-6)
    assert not sides.records[3:4]["unit"].any() and not sides.parameters[len(mirror.positions) :].any()
