"""The reference's light paths against closed forms."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from anamorph.base.errors import AnamorphError
from anamorph.base.steps import drain
from anamorph.frame import Status
from anamorph.methods.tracing.launch import eye_rays
from anamorph.methods.tracing.paths import PathTracer, specular_rectangle
from anamorph.optics.laws import fresnel, reflect
from anamorph.optics.reflection import reflected_rays, reflector
from anamorph.raymesh import RayStatus
from anamorph.rays.caster import Caster
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import Geometry, flatten
from anamorph.scene.model import Glass, Mesh, Mirror, Scene
from anamorph.surfaces.bezier import BezierPatch
from anamorph.surfaces.intersection import intersect
from anamorph.surfaces.plane import Plane
from anamorph.surfaces.sphere import Sphere

SIZE = (64, 48)
ANGLE = 1e-5


def patch(surface, low, high, count, name="mirror", material=None, inside=False, exact=True):
    """A grid of (u, v) on a surface; `inside` turns it over."""
    u, v = np.meshgrid(np.linspace(low[0], high[0], count + 1), np.linspace(low[1], high[1], count + 1))
    uv = np.stack([u, v], axis=-1).reshape(-1, 2)
    corner = (np.arange(count)[:, None] * (count + 1) + np.arange(count)).ravel()
    faces = np.concatenate([corner[:, None] + [0, 1, count + 2], corner[:, None] + [0, count + 2, count + 1]])
    normals = surface.normal(uv)
    return Mesh(
        name,
        surface.position(uv).astype(np.float32),
        (faces[:, ::-1] if inside else faces).astype(np.int32),
        (-normals if inside else normals).astype(np.float32),
        Mirror() if material is None else material,
        surface=surface if exact else None,
        parameters=uv if exact else None,
    )


def box(name="room", half=6.0, material=None, inward=True):
    """A cube around the origin, seen from within or from without."""
    corners = np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    positions, faces, normals = [], [], []
    for axis in range(3):
        for side in (-1.0, 1.0):
            quad = corners[corners[:, axis] == side]
            outward = np.eye(3)[axis] * side
            order = [0, 1, 3, 2] if np.cross(quad[1] - quad[0], quad[3] - quad[0]) @ outward > 0 else [0, 2, 3, 1]
            first = len(positions) * 4
            triangles = np.array([[0, 1, 2], [0, 2, 3]]) + first
            positions.append(quad[order] * half)
            faces.append(triangles[:, ::-1] if inward else triangles)
            normals.append(np.tile(-outward if inward else outward, (4, 1)))
    arrays = [np.concatenate(each) for each in (positions, faces, normals)]
    mesh = Mesh(name, arrays[0].astype(np.float32), arrays[1].astype(np.int32), arrays[2].astype(np.float32))
    return mesh if material is None else replace(mesh, material=material)


def rectangle_at(center, half_u, half_v, name="mirror", material=None):
    center, half_u, half_v = (np.asarray(each, float) for each in (center, half_u, half_v))
    return patch(Plane(center - half_u - half_v, 2 * half_u, 2 * half_v), (0, 0), (1, 1), 1, name, material)


@dataclass
class Traced:
    """Records taken apart."""

    records: np.ndarray
    geometry: Geometry

    @property
    def origin(self):
        return self.records[:, :3].astype(float)

    @property
    def direction(self):
        return self.records[:, 4:7].astype(float)

    @property
    def triangle(self):
        return self.records.view(np.int32)[:, 3]

    @property
    def flags(self):
        return self.records.view(np.uint32)[:, 7]

    @property
    def specular(self):
        return self.flags & 0xFFFF

    @property
    def status(self):
        return self.flags >> 16 & 0xFF

    @property
    def bounces(self):
        return self.flags >> 24

    @property
    def end_object(self):
        return np.where(self.triangle < 0, 0, self.geometry.face_object[self.triangle])

    @property
    def seen(self):
        """The points at the paths' ends, by triangle and weights."""
        weights = self.records[:, 12:14].astype(float)
        a, b, c = np.moveaxis(self.geometry.positions.astype(float)[self.geometry.faces[self.triangle]], 1, 0)
        return a + weights[:, :1] * (b - a) + weights[:, 1:] * (c - a)


def trace(meshes, camera, size=SIZE, rectangle=None, shift=(0.0, 0.0), **options):
    scene = Scene("test", tuple(meshes), camera)
    geometry = flatten(scene)
    tracer = PathTracer(scene, geometry, Caster(geometry), **options)
    return Traced(drain(tracer.tracing(eye_rays(camera, size, rectangle, shift))), geometry)


def pixel_rays(camera, size=SIZE):
    x, y = np.meshgrid(np.arange(size[0]) + 0.5, np.arange(size[1]) + 0.5)
    return camera.directions(np.stack([x, y], axis=-1).reshape(-1, 2), size)


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def angle(a, b):
    return 2.0 * np.arcsin(np.minimum(np.linalg.norm(unit(a) - unit(b), axis=-1) / 2.0, 1.0))


def test_without_a_mirror_every_pixel_is_direct():
    camera = Camera((0.3, 0.2, 1.0), (-1.0, 0.4, -3.0), field_of_view=70)
    out = trace([box()], camera)
    assert (out.status == Status.DIRECT).all() and (out.end_object == 1).all() and not out.specular.any()
    assert (angle(out.direction, pixel_rays(camera)) < 1e-6).all()
    assert (angle(out.seen - camera.position, pixel_rays(camera)) < ANGLE).all()
    assert np.allclose(np.linalg.norm(out.seen - camera.position, axis=1), out.records[:, 11], rtol=1e-5)
    assert (out.records[:, 8:11] == 1).all() and not out.records[:, 14:].any()


def test_an_empty_sky():
    camera = Camera((0, 0, 20.0), (0, 0, 40.0))
    out = trace([box()], camera)
    assert (out.status == Status.SKY).all() and (out.triangle == -1).all()
    assert np.isinf(out.records[:, 11]).all() and not out.records[:, 12:].any()


@pytest.mark.parametrize("truth", ["surface", "raymesh"])
@pytest.mark.parametrize("exact", [True, False])
def test_flat_mirror_is_the_mirrored_camera(exact, truth):
    mirror = rectangle_at((0.2, 0.1, -2.0), (1.5, 0.1, 0.2), (-0.1, 1.2, 0.3), material=Mirror((0.5, 0.75, 1.0), 0.8))
    if not exact:
        mirror = replace(mirror, surface=None, parameters=None)
    camera = Camera((0.4, -0.3, 1.5), (0.0, 0.1, -2.0), field_of_view=50)
    out = trace([box(), mirror], camera, truth=truth)
    on = out.specular == 2
    assert 500 < on.sum() < len(on)
    assert (out.status[on] == Status.TRACED).all() and (out.bounces[on] == 1).all() and (out.end_object[on] == 1).all()
    normal = unit(np.cross(*(mirror.positions[[1, 2]] - mirror.positions[0]).astype(float)))
    eye = np.array(camera.position)
    mirrored = eye - 2 * ((eye - mirror.positions[0]) @ normal) * normal
    incident = pixel_rays(camera)
    wanted = reflect(incident, np.tile(normal, (len(incident), 1)))
    assert (angle(out.direction, wanted)[on] < ANGLE).all()
    assert (angle(out.origin - mirrored, wanted)[on] < ANGLE).all()
    assert (angle(out.seen - mirrored, wanted)[on] < ANGLE).all()
    assert (np.abs((out.origin[on] - mirror.positions[0]) @ normal) < 1e-6).all()
    schlick = 0.8 + 0.2 * (1.0 + incident[on] @ normal) ** 5
    share = schlick[:, None] * [0.5, 0.75, 1.0]
    assert np.allclose(out.records[on, 8:11], share, rtol=1e-5)


def alhazen(eye, points, center, radius):
    """Reflection points on a sphere, outside it: the root of incidence minus reflection angle, by bisection."""
    to_eye, to_point = eye - center, points - center
    first = np.broadcast_to(unit(to_eye), to_point.shape)
    second = unit(to_point - np.sum(to_point * first, axis=1, keepdims=True) * first)
    low, high = np.zeros(len(points)), angle(to_point, first)
    place = center + radius * first
    for _ in range(80):
        middle = (low + high) / 2.0
        normal = np.cos(middle)[:, None] * first + np.sin(middle)[:, None] * second
        place = center + radius * normal
        short = angle(eye - place, normal) < angle(points - place, normal)
        low, high = np.where(short, middle, low), np.where(short, high, middle)
    return place


@pytest.mark.parametrize(("radius", "distance"), [(1.4, 1.0), (0.25, 0.5), (0.25, 4.0)])
def test_convex_sphere_is_alhazens(radius, distance):
    center = np.array([0.1, -0.2, -radius - 1.0])
    mirror = patch(Sphere(center, radius), (-1.0, -1.0), (1.0, 1.0), 8)
    camera = Camera((0.3 * distance, 0.2, distance - 1.0), (0.1, -0.2, -1.0), field_of_view=25)
    out = trace([box(), mirror], camera)
    on = (out.specular == 2) & (out.end_object == 1)
    assert on.sum() > 90 and (out.bounces[on] == 1).all()
    place = alhazen(np.array(camera.position), out.seen[on], center, radius)
    assert (angle(place - camera.position, pixel_rays(camera)[on]) < ANGLE).all()
    assert (angle(out.seen[on] - place, out.direction[on]) < ANGLE).all()
    assert np.allclose(out.origin[on], place, atol=2e-5)


def test_concave_sphere_follows_the_law_and_does_not_hit_itself():
    center, radius = np.array([0.0, 0.0, 1.0]), 3.0
    mirror = patch(Sphere(center, radius, np.diag([-1.0, 1.0, -1.0])), (-0.5, -0.4), (0.5, 0.4), 5, inside=True)
    camera = Camera((0.2, 0.1, -1.0), (0.0, 0.0, -2.0), field_of_view=60)
    out = trace([box(), mirror], camera)
    on = out.specular == 2
    assert on.sum() > 300 and (out.end_object[on] == 1).all() and (out.bounces[on] == 1).all()
    incident = pixel_rays(camera)[on]
    to_center = center - camera.position
    along = incident @ to_center
    place = camera.position + (along + np.sqrt(along**2 - to_center @ to_center + radius**2))[:, None] * incident
    assert np.allclose(out.origin[on], place, atol=1e-6)
    assert (angle(out.direction[on], reflect(incident, (center - place) / radius)) < ANGLE).all()
    mesh = reflected_rays(reflector(mirror), camera.eye(SIZE))
    assert (mesh.status == RayStatus.OK).all()


@pytest.mark.parametrize(("bowl", "eye"), [(-1.0, (0.7, 0.4, -0.6)), (1.0, (-0.7, 0.1, -1.2))])
def test_patches_bend_at_the_patch_and_pass_each_other(bowl, eye):
    x, y = np.meshgrid(np.arange(4) / 3.0, np.arange(4) / 3.0, indexing="ij")
    halves = [BezierPatch(np.stack([x + dx, y - 0.5, np.zeros((4, 4))], axis=-1)) for dx in (-1, 0)]
    # Cubic control points of one smooth surface, cut in two at x = 0.
    for surface, dx in zip(halves, (-1, 0), strict=True):
        blossom_x = np.array([dx**2, dx**2 + 2 * dx / 3, dx**2 + 4 * dx / 3 + 1 / 3, (dx + 1) ** 2])
        blossom_y = np.array([0.25, -1 / 12, -1 / 12, 0.25])
        surface.control[..., 2] = 0.5 * blossom_x[:, None] + 0.5 * bowl * blossom_y[None, :] - 2.0
    meshes = [patch(surface, (0, 0), (1, 1), 4, f"patch {i}") for i, surface in enumerate(halves)]
    camera = Camera(eye, (0.0, 0.0, -2.0), field_of_view=80)
    out = trace([box(), *meshes], camera)
    incident, checked = pixel_rays(camera), 0
    for number, surface in enumerate(halves, start=2):
        on = (out.specular == number) & (out.bounces == 1)
        # No ray ends at the back of the mesh that stands before its own surface or its neighbour's.
        assert not np.isin(out.end_object[on], [2, 3]).any()
        start = np.stack([out.origin[on, 0] - (number - 3), out.origin[on, 1] + 0.5], axis=-1)
        place, normal, ok = intersect(surface, np.tile(camera.position, (on.sum(), 1)), incident[on], start)
        assert ok.all()
        assert np.allclose(out.origin[on], place, atol=1e-6)
        assert (angle(out.direction[on], reflect(incident[on], normal)) < ANGLE).all()
        checked += on.sum()
    assert checked > 300


@pytest.mark.parametrize("truth", ["surface", "raymesh"])
def test_facing_mirrors_bounce_as_often_as_unfolding_says(truth):
    width, length = 1.0, 4.0
    left = rectangle_at((-width / 2, 0, 0), (0, 0, -length), (0, 9.0, 0), "left", Mirror(reflectance=1.0))
    right = rectangle_at((width / 2, 0, 0), (0, 0, length), (0, 9.0, 0), "right", Mirror(reflectance=1.0))
    camera = Camera((0.1, 0.0, length - 0.01), (0.1, 0.0, 0.0), field_of_view=60)
    out = trace([box(half=20.0), left, right], camera, max_bounces=5, truth=truth)
    rays = pixel_rays(camera)
    # Unfolded, the ray runs straight on through a row of walls, one width apart.
    end = 0.1 + rays[:, 0] / -rays[:, 2] * (2 * length - 0.01)
    walls = np.abs(np.round(end / width)).astype(int)
    clear = np.abs(end / width - np.round(end / width)) < 0.499
    limited = walls > 5
    assert np.array_equal(out.bounces[clear], np.minimum(walls, 5)[clear])
    assert (out.status[clear & limited] == Status.OUTSIDE).all()
    assert np.isin(out.end_object[clear & limited], [2, 3]).all()
    assert (out.status[clear & ~limited & (walls > 0)] == Status.TRACED).all()
    assert (clear & limited).any() and len(np.unique(walls[clear & ~limited])) >= 4


def test_slab_lets_out_parallel_rays_shifted():
    slab = box("slab", 0.5, Glass(1.5, (0.9, 0.8, 0.7)), inward=False)
    camera = Camera((0.9, 0.0, 2.0), (0.0, 0.0, 0.5), field_of_view=16)
    out = trace([box(), slab], camera)
    through = (out.specular == 2) & (out.bounces == 2) & (np.abs(out.origin[:, 2] + 0.5) < 1e-6)
    assert through.sum() > 300
    rays = pixel_rays(camera)[through]
    assert (angle(out.direction[through], rays) < ANGLE).all()
    cosine = -rays[:, 2]
    transmitted = np.sqrt(1 - (1 - cosine**2) / 1.5**2)
    entry = camera.position + ((0.5 - 2.0) / rays[:, 2])[:, None] * rays
    tangent = rays[:, :2] / cosine[:, None] * cosine[:, None] / 1.5 / transmitted[:, None]
    assert np.allclose(out.origin[through, :2], entry[:, :2] + tangent, atol=1e-6)
    share = (1 - fresnel(1 / 1.5, cosine)) * (1 - fresnel(1.5, transmitted))
    assert np.allclose(out.records[through, 8:11], share[:, None] * np.square([0.9, 0.8, 0.7]), rtol=1e-5)
    assert (out.status[through] == Status.TRACED).all()


def test_total_reflection_in_a_prism_turns_the_ray_by_a_right_angle():
    points = np.array([[-1, -1], [1, -1], [-1, 1]], float)
    positions = np.concatenate([np.column_stack([points, np.full(3, z)]) for z in (-3.0, 3.0)])
    faces = np.array([[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]])
    corners = positions[faces]
    normals = unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    prism = Mesh(
        "prism", corners.reshape(-1, 3).astype(np.float32), np.arange(24, dtype=np.int32).reshape(-1, 3),
        np.repeat(normals, 3, axis=0).astype(np.float32), Glass(1.5, (0.5, 1, 1)),
    )  # fmt: skip
    camera = Camera((-5.0, -0.2, 0.0), (0.0, -0.2, 0.0), field_of_view=6)
    out = trace([box(), prism], camera)
    assert (out.status == Status.TOTAL_REFLECTION).all() and (out.bounces == 3).all()
    rays = pixel_rays(camera)
    # The hypotenuse x + y = 0 exchanges x and -y.
    assert (angle(out.direction, np.stack([-rays[:, 1], -rays[:, 0], rays[:, 2]], axis=-1)) < ANGLE).all()
    # Two crossings are tinted, the total reflection is not.
    assert np.allclose(out.records[:, 8], 0.25 * out.records[:, 9], rtol=1e-5)
    assert (out.records[:, 9] > 0.9).all()
    sky = trace([prism], camera)
    assert (sky.status == Status.TOTAL_REFLECTION).all() and (sky.triangle == -1).all()


def test_glass_ball_deviates_each_ray_by_twice_the_difference_of_the_angles():
    ball = patch(Sphere(np.zeros(3), 1.0), (-np.pi, -np.pi / 2), (np.pi, np.pi / 2), 12, "ball", Glass(1.5))
    camera = Camera((0.5, 0.3, 4.0), (0.0, 0.0, 0.0), field_of_view=24)
    out = trace([box(half=30.0), ball], camera)
    rays = pixel_rays(camera)
    impact = np.linalg.norm(np.cross(camera.position, rays), axis=1)
    on = (out.specular == 2) & (impact < 0.9)
    assert on.sum() > 500 and (out.bounces[on] == 2).all() and (out.end_object[on] == 1).all()
    deviation = 2 * (np.arcsin(impact[on]) - np.arcsin(impact[on] / 1.5))
    assert np.allclose(angle(out.direction[on], rays[on]), deviation, atol=ANGLE)
    assert np.allclose(np.linalg.norm(out.origin[on], axis=1), 1.0, atol=1e-6)


def test_interpolated_normals_bend_and_never_send_a_ray_through_its_triangle():
    sphere = Sphere(np.array([0.0, 0, -2.0]), 1.0)
    mirror = patch(sphere, (-np.pi, -1.5), (np.pi, 1.5), 9, exact=False)
    camera = Camera((0.2, 0.1, 1.0), (0, 0, -2.0), field_of_view=45)
    out = trace([box(), mirror], camera)
    on = (out.specular == 2) & (out.bounces == 1)
    assert on.sum() > 500
    hits = Caster(out.geometry).cast(np.tile(camera.position, (on.sum(), 1)), pixel_rays(camera)[on])
    faces = out.geometry.faces[hits.triangle]
    weights = np.column_stack([1 - hits.barycentric.sum(axis=1), hits.barycentric])
    phong = unit(np.einsum("nc,nck->nk", weights, out.geometry.normals[faces].astype(float)))
    a, b, c = np.moveaxis(out.geometry.positions.astype(float)[faces], 1, 0)
    flat = unit(np.cross(b - a, c - a))
    wanted = reflect(pixel_rays(camera)[on], phong)
    height = np.sum(wanted * flat, axis=1)
    assert (angle(out.direction[on], wanted)[height > 1e-3] < ANGLE).all()
    below = height < -1e-3
    assert below.any()
    lifted = unit(wanted - height[:, None] * flat)
    assert (angle(out.direction[on], lifted)[below] < ANGLE).all()


def test_ray_mesh_truth_interpolates_the_vertex_rays_across_the_image():
    mirror = patch(Sphere(np.array([0.0, 0, -2.4]), 1.4), (-0.4, -0.3), (0.4, 0.3), 3)
    camera = Camera((0.4, 0.2, 0.3), (0, 0, -1.0), field_of_view=55)
    out = trace([box(), mirror], camera, truth="raymesh")
    mesh = reflected_rays(reflector(mirror), camera.eye(SIZE))
    assert np.allclose(mesh.image[:, 2], (mesh.origins - camera.position) @ camera.axes()[2])
    x, y = np.meshgrid(np.arange(SIZE[0]) + 0.5, np.arange(SIZE[1]) + 0.5)
    pixels = np.stack([x.ravel(), y.ravel(), np.ones(x.size)])
    checked = 0
    for face in mesh.faces:
        # Weights on the surface are linear in the homogeneous image coordinates.
        weights = np.linalg.solve(mesh.image[face].T, pixels)
        inside = (weights > 1e-3 * weights.sum(axis=0)).all(axis=0)
        share = (weights / weights.sum(axis=0))[:, inside].T
        assert (out.specular[inside] == 2).all()
        assert np.allclose(out.origin[inside], share @ mesh.origins[face], atol=2e-6)
        assert (angle(out.direction[inside], share @ mesh.directions[face]) < ANGLE).all()
        checked += inside.sum()
    assert checked > 300


def test_ray_mesh_truth_is_surface_truth_at_a_vertex():
    mirror = patch(Sphere(np.array([0.0, 0, -2.4]), 1.4), (-0.4, -0.3), (0.4, 0.3), 2)
    camera = Camera((0.4, 0.2, 0.3), (0, 0, -1.0), field_of_view=5)
    surface, mesh = (
        trace([box(), mirror], camera, (65, 65), (32, 32, 33, 33), truth=truth) for truth in ("surface", "raymesh")
    )
    assert angle(surface.direction, mesh.direction)[0] < ANGLE


def test_vertices_turned_away_are_said_to_be():
    mirror = patch(Sphere(np.zeros(3), 1.0), (-np.pi, -1.5), (np.pi, 1.5), 16, exact=False)
    camera = Camera((0, 0, 3.0), (0, 0, 0))
    mesh = reflected_rays(reflector(mirror), camera.eye(SIZE))
    away = np.sum((mirror.positions - camera.position) * mirror.normals, axis=1) >= 0
    assert np.array_equal(mesh.status == RayStatus.BACK_FACING, away) and 0 < away.sum() < len(away)
    # As long as the eye is far, with which interpolation is exact on a flat mirror.
    distance = np.linalg.norm(mesh.origins - camera.position, axis=1)
    assert np.allclose(np.linalg.norm(mesh.directions, axis=1), distance)


def test_refraction_at_vertices_is_refused():
    ball = patch(Sphere(np.zeros(3), 1.0), (-1, -1), (1, 1), 4, "ball", Glass())
    with pytest.raises(AnamorphError, match=r"'ball'.*give it the material Mirror"):
        reflected_rays(reflector(ball), Camera((0, 0, 3), (0, 0, 0)).eye(SIZE))
    with pytest.raises(AnamorphError, match=r"'ball'.*raytrace"):
        trace([ball], Camera((0, 0, 3), (0, 0, 0)), truth="raymesh")


@pytest.mark.parametrize("options", [{"truth": "phong"}, {"max_bounces": -1}, {"max_bounces": 256}])
def test_wrong_options_are_named(options):
    with pytest.raises(AnamorphError, match=next(iter(options))):
        trace([box()], Camera((0, 0, 3), (0, 0, 0)), **options)


def test_a_zero_normal_is_named():
    mirror = rectangle_at((0, 0, 0), (1, 0, 0), (0, 1, 0))
    mirror = replace(mirror, normals=np.zeros_like(mirror.normals), surface=None)
    with pytest.raises(AnamorphError, match="normals"):
        reflected_rays(reflector(mirror), Camera((0, 0, 3), (0, 0, 0)).eye(SIZE))
    out = trace([box(), mirror], Camera((0, 0, 3), (0, 0, 0)))
    assert (out.status[out.specular == 2] == Status.TRACED).all() and np.isfinite(out.direction).all()


def test_the_back_of_a_mirror_is_diffuse():
    out = trace([rectangle_at((0, 0, 0), (-5, 0, 0), (0, 5, 0))], Camera((0, 0, 3), (0, 0, 0)))
    assert (out.status == Status.DIRECT).all() and not out.specular.any() and (out.end_object == 1).all()


def test_no_bounce_allowed():
    out = trace([rectangle_at((0, 0, 0), (5, 0, 0), (0, 5, 0))], Camera((0, 0, 3), (0, 0, 0)), max_bounces=0)
    assert (out.status == Status.OUTSIDE).all() and (out.specular == 1).all() and not out.bounces.any()


def test_a_part_of_the_image_is_that_part_and_both_ways_of_casting_agree(monkeypatch):
    mirror = patch(Sphere(np.array([0.0, 0, -2.4]), 1.4), (-0.4, -0.3), (0.4, 0.3), 7)
    camera = Camera((0.4, 0.2, 0.3), (0, 0, -1.0))
    size = (160, 120)
    whole = trace([box(), mirror], camera, size, shift=(0.25, -0.125))
    part = trace([box(), mirror], camera, size, (30, 20, 141, 99), shift=(0.25, -0.125))
    same = whole.records.view(np.uint32).reshape(120, 160, 16)[20:99, 30:141].reshape(-1, 16)
    assert np.array_equal(same, part.records.view(np.uint32))
    x, y = np.meshgrid(np.arange(160) + 0.75, np.arange(120) + 0.375)
    rays = camera.directions(np.stack([x, y], axis=-1).reshape(-1, 2), size)
    direct = whole.bounces == 0
    assert (angle(whole.direction, rays)[direct] < 1e-6).all()
    monkeypatch.setenv("ANAMORPH_RAYS", "embreex")
    other = trace([box(), mirror], camera, size, shift=(0.25, -0.125))
    same = (other.flags == whole.flags) & (other.triangle == whole.triangle)
    assert same.mean() > 0.999
    assert np.allclose(other.records[same, :3], whole.records[same, :3], atol=1e-6)
    assert np.allclose(other.records[same, 11], whole.records[same, 11], rtol=1e-4)


def test_records_are_filled_again():
    camera = Camera((0, 0, 3), (0, 0, 0))
    scene = Scene("test", (box(),), camera)
    geometry = flatten(scene)
    tracer = PathTracer(scene, geometry, Caster(geometry))
    first = drain(tracer.tracing(eye_rays(camera, SIZE)))
    kept = first.copy()
    first[:] = 7.0
    assert drain(tracer.tracing(eye_rays(camera, SIZE), first)) is first and np.array_equal(first, kept)
    assert drain(tracer.tracing(eye_rays(camera, (9, 9)), first)).shape == (81, 16)
    assert drain(tracer.tracing(eye_rays(camera, SIZE, (5, 5, 5, 9)))).shape == (0, 16)


def test_rectangle_holds_every_pixel_that_looks_at_a_mirror():
    mirror = patch(Sphere(np.array([0.2, 0.1, -2.0]), 0.4), (-np.pi, -1.5), (np.pi, 1.5), 12)
    camera = Camera((0.4, 0.2, 0.3), (0, 0, -1.0))
    out = trace([box(), mirror], camera)
    rows, columns = np.nonzero(out.specular.reshape(SIZE[::-1]))
    rectangle = specular_rectangle(Scene("test", (box(), mirror), camera), camera, SIZE)
    assert rectangle is not None
    x0, y0, x1, y1 = rectangle
    assert x0 <= columns.min() <= x0 + 3 and x1 - 4 <= columns.max() < x1
    assert y0 <= rows.min() <= y0 + 3 and y1 - 4 <= rows.max() < y1


def test_rectangle_of_no_mirror_one_behind_and_one_around_the_eye():
    camera = Camera((0, 0, 3), (0, 0, 0))

    def found(*meshes):
        return specular_rectangle(Scene("test", (box(), *meshes), camera), camera, SIZE)

    ball = Sphere(np.zeros(3), 0.5)
    assert found() is None
    assert found(patch(replace(ball, center=np.array([0, 0, 5.0])), (-3, -1), (3, 1), 6)) is None
    assert found(patch(replace(ball, center=np.array([50.0, 0, 0])), (-3, -1), (3, 1), 6)) is None
    assert found(patch(replace(ball, center=np.array([0, 0, 3.0])), (-3, -1), (3, 1), 6)) == (0, 0, *SIZE)
