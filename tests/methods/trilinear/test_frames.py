"""Frames of `trilinear` against a ray for each pixel through the same ray mesh: what is seen, where, and its colour."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import trimesh
from jittered_rays import jittered
from scenes import CAMERA as SMALL_CAMERA
from scenes import SIZE, drawn, flat_mirror, open_view, scene_with, spherical_mirror

from anamorph import cameras
from anamorph.frame import Frame, Status, View
from anamorph.gallery import make
from anamorph.gallery.cube import CAMERA, cube_scene
from anamorph.gallery.cube_mirrors import cube_in_sphere
from anamorph.gallery.flat_mirror import plane_mirror
from anamorph.measure.errors import measure, silhouettes
from anamorph.methods import Specification
from anamorph.raymesh import RayMesh
from anamorph.scene.camera import Camera
from anamorph.scene.model import Diffuse, Mesh, Mirror, Scene, Sky

IMAGE = (240, 240)
REFERENCE, ONCE = "raytrace:truth=raymesh,bounces=1", "trilinear:bounces=1"
"""Both end where a second mirror follows."""

LEFT = Camera(position=(-3.0, 1.0, 0.6), target=(0.0, 0.0, 0.0), field_of_view=40.0)
RIGHT = Camera(position=(0.3, 1.0, 3.2), target=(0.0, 0.0, 0.0), field_of_view=40.0)

BARE = {
    "pinhole": lambda: cameras.pinhole(CAMERA, IMAGE),
    "orthographic": lambda: cameras.orthographic(CAMERA, IMAGE),
    "pushbroom": lambda: cameras.pushbroom(CAMERA, IMAGE),
    "panorama": lambda: cameras.panorama(CAMERA, IMAGE),
    "6.4": lambda: cameras.detail_and_context(CAMERA, IMAGE),
    "6.4, crossing": lambda: cameras.detail_and_context(CAMERA, IMAGE, magnification=3.0, rows=7, columns=7),
    "6.7": lambda: cameras.multi_perspective(LEFT, RIGHT, IMAGE),
    "6.9": lambda: cameras.inward_sphere((0.0, 0.0, 0.0), 2.0, IMAGE),
    "6.9, to the poles": lambda: cameras.inward_sphere((0.0, 0.0, 0.0), 2.0, IMAGE, pole=0.0),
    "7.6, 1": lambda: cameras.refracting_plane(CAMERA, IMAGE, quads=1),
    "7.6, 3": lambda: cameras.refracting_plane(CAMERA, IMAGE, quads=3),
    "7.6, 5": lambda: cameras.refracting_plane(CAMERA, IMAGE, quads=5),
}

MIRRORS = {
    "7.4, 1": (lambda: cube_in_sphere(1), IMAGE, 0.001),
    "7.4, 5": (lambda: cube_in_sphere(5), IMAGE, 0.001),
    "7.5": (lambda: make("cube-in-wavy-mirror"), IMAGE, 0.002),
    "flat-mirror": (lambda: make("flat-mirror"), (240, 180), 0.001),
    "car-mirror": (lambda: make("car-mirror"), (240, 180), 0.001),
    "spheres": (lambda: make("spheres"), (240, 180), 0.01),
    "saddle": (lambda: make("saddle"), (240, 180), 0.004),
    "curvature-series": (lambda: make("curvature-series"), (240, 180), 0.004),
    "torus": (lambda: make("torus"), (240, 180), 0.02),
    "room": (lambda: make("room"), (240, 180), 0.05),
    "facing-mirrors": (lambda: make("facing-mirrors"), (240, 180), 0.001),
}
"""Scene, size, and a bound on FLIP: at the border of a ray triangle a traced texture's footprint is its neighbour's."""


def shown(scene: Scene, camera: Camera | RayMesh, specification: str, size: tuple[int, int], shift=(0.0, 0.0)) -> Frame:
    session = Specification.parse(specification).open(View(scene, camera, size))
    session.draw(camera, shift)
    return session.frame(seen=True)


def assert_same_geometry(reference: Frame, frame: Frame) -> None:
    """No pixel of another object away from silhouettes, and all else within a hundredth of a pixel, or of a mrad.

    Where an image shows the sky by parallel rays, a pixel is no measure of it.
    """
    errors = measure(reference, frame)
    ends = reference.status == Status.OUTSIDE
    assert ((frame.status == Status.OUTSIDE) == ends)[~silhouettes(ends, reference.object_id)].all()
    count = errors.maps.specular & ~errors.maps.silhouette & ~ends
    assert count.sum() > 1000
    assert not (errors.maps.other_object & count).any()
    wrong = np.minimum(errors.maps.pixels, errors.maps.angular)[count]
    # A few pixels stand where rays cross, which no float32 resolves.
    assert np.percentile(wrong, 99.9) <= 0.01 and wrong.max() <= 1.0
    # At the poles of a sphere a pixel is less than what float32 resolves of a ray.
    offset = reference.position - reference.ray_origin
    unresolved = np.linalg.norm(frame.position - reference.position, axis=-1) <= 5e-7 * np.linalg.norm(offset, axis=-1)
    counted = (reference.object_id > 0) & ~unresolved
    assert np.percentile(np.where(counted, errors.maps.pixels, 0.0)[count], 95) <= 0.01
    differ = (reference.object_id != frame.object_id) & ~ends
    assert differ.sum() <= 0.01 * errors.maps.specular.sum()


@pytest.mark.parametrize("name", BARE)
def test_a_bare_ray_mesh_shows_what_its_rays_see(name):
    camera, scene = BARE[name](), cube_scene()
    reference, frame = (shown(scene, camera, method, IMAGE) for method in ("raytrace", "trilinear"))
    assert_same_geometry(reference, frame)
    assert frame.ray_mesh and not frame.specular.any()
    expected = np.where(reference.status == Status.DIRECT, Status.PROJECTED, reference.status)
    assert (frame.status == expected).mean() > 0.999
    assert measure(reference, frame).flip <= 0.002


@pytest.mark.parametrize("name", MIRRORS)
def test_mirrors_show_what_the_rays_of_their_ray_mesh_see(name):
    maker, size, flip = MIRRORS[name]
    scene = maker()
    reference, frame = (drawn(scene, method, size) for method in (REFERENCE, ONCE))
    assert_same_geometry(reference, frame)
    assert (reference.specular != frame.specular).sum() <= 5
    once = (reference.status != Status.OUTSIDE) & ~silhouettes(reference.object_id, reference.specular)
    expected = np.where(reference.status == Status.TRACED, Status.PROJECTED, reference.status)
    assert (frame.status == expected)[once].all()
    assert np.median(np.abs(frame.color - reference.color)[once]) <= 1e-3
    if (reference.status != Status.OUTSIDE).all():
        assert measure(reference, frame).flip <= flip


@cache
def pictured(mirror: str, specification: str) -> Frame:
    return drawn(scene_with(flat_mirror() if mirror == "flat" else spherical_mirror()), specification)


@pytest.mark.parametrize("mirror", ["flat", "sphere"])
def test_what_stands_before_a_mirror_hides_it(mirror):
    reference, frame = pictured(mirror, "raytrace:truth=raymesh"), pictured(mirror, "trilinear")
    before = 1 + [mesh.name for mesh in scene_with(flat_mirror()).meshes].index("box-3")
    direct = (frame.object_id == before) & (frame.specular == 0)
    assert direct.sum() > 100 and (frame.status[direct] == Status.DIRECT).all()
    assert ((frame.object_id == before) & (frame.specular > 0)).sum() > 50
    assert (frame.specular == reference.specular).all()
    assert np.abs(frame.color - reference.color)[frame.specular == 0].mean() <= 1e-3
    assert_same_geometry(reference, frame)


def hall_of_mirrors() -> Mesh:
    """The inside of a ball around everything."""
    ball = trimesh.creation.icosphere(subdivisions=2)
    positions = (3.0 * ball.vertices + [0.0, 0.5, 1.0]).astype(np.float32)
    faces = ball.faces[:, ::-1].astype(np.int32)
    return Mesh("mirror", positions, faces, (-ball.vertices).astype(np.float32), Mirror(reflectance=0.9))


AROUND = {
    "beside the eye": (
        plane_mirror("mirror", (-6.0, -0.5, -1.0), (12.0, 0.0, 0.0), (0.0, 3.0, 0.0)),
        Camera(position=(-0.5, 0.65, -0.3), target=(-3.0, 0.5, -0.9), field_of_view=60.0),
    ),
    "around the eye": (
        hall_of_mirrors(),
        Camera(position=(0.25, 0.65, 0.9), target=(0.3, 0.5, 3.0), field_of_view=60.0),
    ),
    "concave": (spherical_mirror(-1.0), SMALL_CAMERA),
    "concave and coarse": (spherical_mirror(-0.5, count=3), SMALL_CAMERA),
}


@pytest.mark.parametrize("name", AROUND)
def test_mirrors_may_reach_behind_the_eye_or_be_concave(name):
    mirror, camera = AROUND[name]
    scene = scene_with(mirror, camera=camera)
    reference, frame = (drawn(scene, method) for method in (REFERENCE, ONCE))
    assert_same_geometry(reference, frame)
    assert (reference.specular != frame.specular).sum() <= 5
    assert measure(reference, frame).flip <= 0.01 or (reference.status == Status.OUTSIDE).any()


def test_a_body_does_not_show_its_own_back():
    """Near its silhouette a coarse ball with smooth normals sends rays through itself: as if it were not there."""
    ball = trimesh.creation.icosphere(subdivisions=1)
    positions = (0.3 * ball.vertices + [0.0, 0.5, 0.0]).astype(np.float32)
    mirror = Mesh("mirror", positions, ball.faces.astype(np.int32), ball.vertices.astype(np.float32), Mirror())
    reference, frame = (drawn(scene_with(mirror), method) for method in (REFERENCE, ONCE))
    for each, found in ((reference, Status.TRACED), (frame, Status.PROJECTED)):
        assert not ((each.object_id == 1) & (each.specular == 1) & (each.status == found)).any()
    plain = ~silhouettes(reference.object_id, reference.specular)
    assert (frame.object_id == reference.object_id)[plain].mean() > 0.99


@pytest.mark.parametrize("shift", [(0.31, -0.47), (-0.45, 0.4)])
def test_shifted_pixels_show_what_shifted_rays_see(shift):
    scene, camera = cube_scene(), BARE["6.4"]()
    frames = [shown(scene, camera, method, IMAGE, shift) for method in ("raytrace", "trilinear")]
    assert_same_geometry(*frames)
    assert ((frames[0].status == Status.OUTSIDE) == (frames[1].status == Status.OUTSIDE)).mean() > 0.998
    mirrored = scene_with(spherical_mirror())
    methods = "raytrace:truth=raymesh", "trilinear"
    assert_same_geometry(*(shown(mirrored, mirrored.camera, method, SIZE, shift) for method in methods))


def test_what_moves_is_drawn_where_it_is():
    scene = scene_with(spherical_mirror())
    moved = replace(
        scene,
        meshes=tuple(
            replace(mesh, positions=mesh.positions + np.float32([0.1, 0.0, 0.05])) if mesh.name == "box-1" else mesh
            for mesh in scene.meshes
        ),
    )
    session = open_view(scene, "trilinear")
    session.draw(scene.camera)
    before = session.frame(seen=True)
    positions, normals = (np.concatenate([getattr(m, name) for m in moved.meshes]) for name in ("positions", "normals"))
    session.deform(positions, normals)
    session.draw(scene.camera)
    after, anew = session.frame(seen=True), drawn(moved, "trilinear")
    assert (before.object_id != after.object_id).sum() > 50
    assert (after.object_id == anew.object_id).all() and (after.status == anew.status).all()
    assert np.abs(after.color - anew.color).max() <= 1e-3


def test_the_same_view_gives_the_same_frame():
    scene = scene_with(spherical_mirror())
    one, other = (drawn(scene, "trilinear") for _ in range(2))
    for name in ("color", "position", "object_id", "status", "specular"):
        assert (getattr(one, name) == getattr(other, name)).all()


@pytest.mark.parametrize("border", [120.49, 120.51])
def test_a_pixel_at_a_border_shows_what_its_own_rays_see(border):
    """Two ray meshes that have nothing in common meet close to a column of pixels' centres."""
    left, right = (cameras.pinhole(camera, IMAGE) for camera in (LEFT, RIGHT))
    places = left.image.copy(), right.image.copy()
    places[0][places[0][:, 0] > 0.0, 0] = border
    places[1][places[1][:, 0] == 0.0, 0] = border
    both = RayMesh(
        np.concatenate(places),
        *(np.concatenate([getattr(left, name), getattr(right, name)]) for name in ("origins", "directions")),
        np.concatenate([left.faces, right.faces + len(left.image)]),
        np.concatenate([left.status, right.status]),
    )
    reference, frame = (shown(cube_scene(), both, method, IMAGE) for method in ("raytrace", "trilinear"))
    assert np.ptp(reference.position[:, 119:122], axis=1).max(axis=1).mean() > 0.1
    assert (frame.object_id[:, 119:122] == reference.object_id[:, 119:122]).all()
    assert np.abs(frame.position - reference.position)[:, 119:122].max() <= 1e-4


def shell(radius: float, random: np.random.Generator) -> Scene:
    """A closed surface of 20480 triangles around the origin, jagged, in eight parts that share their borders."""
    ball = trimesh.creation.icosphere(subdivisions=5)
    bumps = radius * random.uniform(0.97, 1.03, (len(ball.vertices), 1))
    positions = (bumps * ball.vertices + random.normal(scale=0.008 * radius, size=bumps.shape)).astype(np.float32)
    normals = (-ball.vertices).astype(np.float32)
    part = (ball.triangles_center > 0.0) @ [1, 2, 4]
    meshes = tuple(
        Mesh(
            f"part-{number}", positions, ball.faces[part == number].astype(np.int32), normals, Diffuse((0.5, 0.5, 0.5))
        )
        for number in range(8)
    )
    return Scene("shell", meshes, Camera((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), sky=Sky())


@pytest.mark.parametrize("radius", [2.0, 2000.0])
@pytest.mark.parametrize("weighted", [False, True])
def test_a_closed_surface_has_no_hole_and_no_overlap(radius, weighted):
    random = np.random.default_rng(int(radius) + weighted)
    scene, camera = shell(radius, random), jittered(IMAGE, weighted, random)
    assert len(camera.faces) == 200
    reference = shown(scene, camera, "raytrace", IMAGE)
    assert (reference.object_id > 0).all() and len(np.unique(reference.object_id)) >= 4
    session = Specification.parse("trilinear").open(View(scene, camera, IMAGE))
    for shift in ((0.0, 0.0), *random.uniform(-0.5, 0.5, (3, 2))):
        session.draw(camera, tuple(shift))
        frame = session.frame(seen=True)
        assert (frame.status[1:-1, 1:-1] == Status.PROJECTED).all()
        assert np.isin(frame.status, [Status.PROJECTED, Status.OUTSIDE]).all()
        if not any(shift):
            assert (frame.status == Status.PROJECTED).all()
            assert_same_geometry(reference, frame)
            assert (frame.object_id != reference.object_id).sum() <= 2
