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

PICTURE = (240, 240)
TRUTH, ONCE = "raytrace:truth=raymesh,bounces=1", "trilinear:bounces=1"
"""Both end where a second mirror follows."""

LEFT = Camera(position=(-3.0, 1.0, 0.6), target=(0.0, 0.0, 0.0), field_of_view=40.0)
RIGHT = Camera(position=(0.3, 1.0, 3.2), target=(0.0, 0.0, 0.0), field_of_view=40.0)

BARE = {
    "pinhole": lambda: cameras.pinhole(CAMERA, PICTURE),
    "orthographic": lambda: cameras.orthographic(CAMERA, PICTURE),
    "pushbroom": lambda: cameras.pushbroom(CAMERA, PICTURE),
    "panorama": lambda: cameras.panorama(CAMERA, PICTURE),
    "6.4": lambda: cameras.detail_and_context(CAMERA, PICTURE),
    "6.4, crossing": lambda: cameras.detail_and_context(CAMERA, PICTURE, magnification=3.0, rows=7, columns=7),
    "6.7": lambda: cameras.multi_perspective(LEFT, RIGHT, PICTURE),
    "6.9": lambda: cameras.inward_sphere((0.0, 0.0, 0.0), 2.0, PICTURE),
    "6.9, to the poles": lambda: cameras.inward_sphere((0.0, 0.0, 0.0), 2.0, PICTURE, pole=0.0),
    "7.6, 1": lambda: cameras.refracting_plane(CAMERA, PICTURE, quads=1),
    "7.6, 3": lambda: cameras.refracting_plane(CAMERA, PICTURE, quads=3),
    "7.6, 5": lambda: cameras.refracting_plane(CAMERA, PICTURE, quads=5),
}

MIRRORS = {
    "7.4, 1": (lambda: cube_in_sphere(1), PICTURE, 0.001),
    "7.4, 5": (lambda: cube_in_sphere(5), PICTURE, 0.001),
    "7.5": (lambda: make("cube-in-wavy-mirror"), PICTURE, 0.002),
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


def assert_same_geometry(truth: Frame, frame: Frame) -> None:
    """No pixel of another object away from silhouettes, and all else within a hundredth of a pixel, or of a mrad.

    Where a picture shows the sky by parallel rays, a pixel is no measure of it.
    """
    errors = measure(truth, frame)
    ends = truth.status == Status.OUTSIDE
    assert ((frame.status == Status.OUTSIDE) == ends)[~silhouettes(ends, truth.object_id)].all()
    count = errors.maps.specular & ~errors.maps.silhouette & ~ends
    assert count.sum() > 1000
    assert not (errors.maps.other_object & count).any()
    wrong = np.minimum(errors.maps.pixels, errors.maps.angular)[count]
    # A few pixels stand where rays cross, which no float32 resolves.
    assert np.percentile(wrong, 99.9) <= 0.01 and wrong.max() <= 1.0
    assert np.percentile(np.where(truth.object_id > 0, errors.maps.pixels, 0.0)[count], 95) <= 0.01
    differ = (truth.object_id != frame.object_id) & ~ends
    assert differ.sum() <= 0.01 * errors.maps.specular.sum()


@pytest.mark.parametrize("name", BARE)
def test_a_bare_ray_mesh_shows_what_its_rays_see(name):
    camera, scene = BARE[name](), cube_scene()
    truth, frame = (shown(scene, camera, method, PICTURE) for method in ("raytrace", "trilinear"))
    assert_same_geometry(truth, frame)
    assert frame.ray_mesh and not frame.specular.any()
    expected = np.where(truth.status == Status.DIRECT, Status.PROJECTED, truth.status)
    assert (frame.status == expected).mean() > 0.999
    assert measure(truth, frame).flip <= 0.002


@pytest.mark.parametrize("name", MIRRORS)
def test_mirrors_show_what_the_rays_of_their_ray_mesh_see(name):
    maker, size, flip = MIRRORS[name]
    scene = maker()
    truth, frame = (drawn(scene, method, size) for method in (TRUTH, ONCE))
    assert_same_geometry(truth, frame)
    assert (truth.specular != frame.specular).sum() <= 5
    once = (truth.status != Status.OUTSIDE) & ~silhouettes(truth.object_id, truth.specular)
    expected = np.where(truth.status == Status.TRACED, Status.PROJECTED, truth.status)
    assert (frame.status == expected)[once].all()
    assert np.median(np.abs(frame.color - truth.color)[once]) <= 1e-3
    if (truth.status != Status.OUTSIDE).all():
        assert measure(truth, frame).flip <= flip


@cache
def pictured(mirror: str, specification: str) -> Frame:
    return drawn(scene_with(flat_mirror() if mirror == "flat" else spherical_mirror()), specification)


@pytest.mark.parametrize("mirror", ["flat", "sphere"])
def test_what_stands_before_a_mirror_hides_it(mirror):
    truth, frame = pictured(mirror, "raytrace:truth=raymesh"), pictured(mirror, "trilinear")
    before = 1 + [mesh.name for mesh in scene_with(flat_mirror()).meshes].index("box-3")
    direct = (frame.object_id == before) & (frame.specular == 0)
    assert direct.sum() > 100 and (frame.status[direct] == Status.DIRECT).all()
    assert ((frame.object_id == before) & (frame.specular > 0)).sum() > 50
    assert (frame.specular == truth.specular).all()
    assert np.abs(frame.color - truth.color)[frame.specular == 0].mean() <= 1e-3
    assert_same_geometry(truth, frame)


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
    "hollow": (spherical_mirror(-1.0), SMALL_CAMERA),
    "hollow and coarse": (spherical_mirror(-0.5, count=3), SMALL_CAMERA),
}


@pytest.mark.parametrize("name", AROUND)
def test_mirrors_may_reach_behind_the_eye_or_be_hollow(name):
    mirror, camera = AROUND[name]
    scene = scene_with(mirror, camera=camera)
    truth, frame = (drawn(scene, method) for method in (TRUTH, ONCE))
    assert_same_geometry(truth, frame)
    assert (truth.specular != frame.specular).sum() <= 5
    assert measure(truth, frame).flip <= 0.01 or (truth.status == Status.OUTSIDE).any()


def test_a_body_does_not_show_its_own_back():
    """Near its silhouette a coarse ball with smooth normals sends rays through itself: as if it were not there."""
    ball = trimesh.creation.icosphere(subdivisions=1)
    positions = (0.3 * ball.vertices + [0.0, 0.5, 0.0]).astype(np.float32)
    mirror = Mesh("mirror", positions, ball.faces.astype(np.int32), ball.vertices.astype(np.float32), Mirror())
    truth, frame = (drawn(scene_with(mirror), method) for method in (TRUTH, ONCE))
    backs = (truth.object_id == 1) & (truth.specular == 1) & (truth.status == Status.TRACED)
    assert backs.sum() > 100
    assert not ((frame.object_id == 1) & (frame.specular == 1) & (frame.status == Status.PROJECTED)).any()
    assert (frame.object_id == truth.object_id)[~silhouettes(backs, truth.object_id, truth.specular)].mean() > 0.95


@pytest.mark.parametrize("shift", [(0.31, -0.47), (-0.45, 0.4)])
def test_shifted_pixels_show_what_shifted_rays_see(shift):
    scene, camera = cube_scene(), BARE["6.4"]()
    frames = [shown(scene, camera, method, PICTURE, shift) for method in ("raytrace", "trilinear")]
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
    left, right = (cameras.pinhole(camera, PICTURE) for camera in (LEFT, RIGHT))
    places = left.picture.copy(), right.picture.copy()
    places[0][places[0][:, 0] > 0.0, 0] = border
    places[1][places[1][:, 0] == 0.0, 0] = border
    both = RayMesh(
        np.concatenate(places),
        *(np.concatenate([getattr(left, name), getattr(right, name)]) for name in ("origins", "directions")),
        np.concatenate([left.faces, right.faces + len(left.picture)]),
        np.concatenate([left.status, right.status]),
    )
    truth, frame = (shown(cube_scene(), both, method, PICTURE) for method in ("raytrace", "trilinear"))
    assert np.ptp(truth.position[:, 119:122], axis=1).max(axis=1).mean() > 0.1
    assert (frame.object_id[:, 119:122] == truth.object_id[:, 119:122]).all()
    assert np.abs(frame.position - truth.position)[:, 119:122].max() <= 1e-4


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
    scene, camera = shell(radius, random), jittered(PICTURE, weighted, random)
    assert len(camera.faces) == 200
    truth = shown(scene, camera, "raytrace", PICTURE)
    assert (truth.object_id > 0).all() and len(np.unique(truth.object_id)) >= 4
    session = Specification.parse("trilinear").open(View(scene, camera, PICTURE))
    for shift in ((0.0, 0.0), *random.uniform(-0.5, 0.5, (3, 2))):
        session.draw(camera, tuple(shift))
        frame = session.frame(seen=True)
        assert (frame.status[1:-1, 1:-1] == Status.PROJECTED).all()
        assert np.isin(frame.status, [Status.PROJECTED, Status.OUTSIDE]).all()
        if not any(shift):
            assert (frame.status == Status.PROJECTED).all()
            assert_same_geometry(truth, frame)
            assert (frame.object_id != truth.object_id).sum() <= 2
