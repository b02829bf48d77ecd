"""Cameras made by hand: rays of closed form, images filled once, and the thesis's cube in front of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from camera_rays import centers, from_line, rays_at, unit
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scenes import spherical_mirror

from anamorph import cameras
from anamorph.base.errors import AnamorphError
from anamorph.cameras.grid import grid_points
from anamorph.cameras.linear import lines_of_sight
from anamorph.gallery.cube import BOARD_HEIGHT, EDGE, FRONT, LEFT, cube, cube_and_board, cube_scene
from anamorph.gallery.cube_mirrors import BALL, cube_in_sphere, cube_in_wavy_mirror
from anamorph.optics.reflection import reflected_rays, reflector
from anamorph.raymesh import RayMesh, RayStatus
from anamorph.rays.caster import Caster
from anamorph.scene.camera import Camera
from anamorph.scene.checks import check_scene
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Diffuse, Scene
from anamorph.surfaces.sphere import Sphere

ASKEW = Camera((1.0, 2.0, 3.0), (-0.5, 0.25, -1.0), (0.2, 1.0, 0.1), 55.0)
NARROW = replace(ASKEW, field_of_view=30.0)
SIZE = (48, 32)
THIRDS = (90, 30)
BALL_AT = Sphere(np.array([0.3, 0.2, -0.1]), 1.5)

MAKERS = {
    "pinhole": (lambda: cameras.pinhole(ASKEW, SIZE), 2),
    "orthographic": (lambda: cameras.orthographic(ASKEW, SIZE), 2),
    "pushbroom": (lambda: cameras.pushbroom(ASKEW, SIZE), 2),
    "more perspective": (lambda: cameras.perspective(ASKEW, SIZE, 1.7), 2),
    "reversed": (lambda: cameras.perspective(ASKEW, SIZE, -1.0), 2),
    "anti-perspective": (lambda: cameras.anti_perspective(ASKEW, SIZE), 2),
    "on a street": (lambda: cameras.strip([LEFT, FRONT], SIZE, 6), 12),
    "outside a ball": (lambda: cameras.from_surface(BALL_AT, SIZE, True, ((-1, 2), (-0.5, 1)), 3, 5), 30),
    "panorama": (lambda: cameras.panorama(ASKEW, SIZE), 72),
    "figure 6.4": (lambda: cameras.detail_and_context(ASKEW, SIZE), 18),
    "fine detail": (lambda: cameras.detail_and_context(ASKEW, SIZE, rows=7, columns=9), 126),
    "figure 6.7": (lambda: cameras.multi_perspective(LEFT, FRONT, SIZE), 6),
    "slow turn": (lambda: cameras.multi_perspective(LEFT, FRONT, SIZE, transition=0.5, columns=6), 16),
    "figure 6.9": (lambda: cameras.inward_sphere((0.1, 0.2, 0.3), 2.0, SIZE), 200),
    "to the poles": (lambda: cameras.inward_sphere((0.1, 0.2, 0.3), 2.0, SIZE, pole=0.0), 200),
    "figure 7.6": (lambda: cameras.refracting_plane(ASKEW, SIZE), 50),
}
every_maker = pytest.mark.parametrize("name", MAKERS)


def seen(mesh: RayMesh, scene: Scene, size: tuple[int, int]) -> np.ndarray:
    """Which object each pixel sees, (H, W); 0 is the sky."""
    geometry = flatten(scene)
    origins, directions, _ = rays_at(mesh, centers(size))
    triangle = Caster(geometry).cast(origins, directions).triangle
    return np.where(triangle < 0, 0, geometry.face_object[triangle]).reshape(size[1], size[0])


@every_maker
def test_triangles_fill_the_image_once_and_turn_as_a_mirrors_do(name):
    make, count = MAKERS[name]
    mesh = make()
    assert len(mesh.faces) == count and mesh.faces.dtype == np.int32
    assert (mesh.image[:, 2] == 1.0).all() and (mesh.status == RayStatus.OK).all() and mesh.status.dtype == np.uint8
    assert mesh.origins.shape == mesh.directions.shape == mesh.image.shape == (len(mesh.status), 3)
    assert mesh.origins.dtype == mesh.directions.dtype == mesh.image.dtype == np.float64
    areas = np.linalg.det(mesh.image[mesh.faces]) / 2.0
    front = reflected_rays(reflector(spherical_mirror()), Camera((0, 0.5, 1), (0, 0.5, 0)).eye(SIZE))
    of_mirror = np.linalg.det((front.image / front.image[:, 2:])[front.faces])
    assert (np.sign(areas) == np.sign(of_mirror[0])).all() and (np.sign(of_mirror) == np.sign(of_mirror[0])).all()
    assert -areas.sum() == pytest.approx(SIZE[0] * SIZE[1])
    points = np.random.default_rng(1).uniform((0, 0), SIZE, (2000, 2))
    assert (rays_at(mesh, points)[2] == 1).all()
    assert np.linalg.norm(mesh.directions, axis=1).min() > 0.0


@given(
    st.tuples(*[st.floats(-3, 3)] * 3), st.tuples(*[st.floats(-3, 3)] * 3), st.floats(0.5, 175.0),
    st.integers(1, 60), st.integers(1, 60),
)  # fmt: skip
def test_a_pinhole_is_the_camera_at_every_pixel(position, target, angle, width, height):
    forward = np.subtract(target, position)
    assume(np.linalg.norm(np.cross(forward, (0, 1, 0))) > 1e-3 * np.linalg.norm(forward) > 1e-6)
    camera = Camera(position, target, field_of_view=angle)
    origins, directions, _ = rays_at(cameras.pinhole(camera, (width, height)), centers((width, height)))
    assert np.abs(unit(directions) - camera.directions(centers((width, height)), (width, height))).max() < 1e-9
    assert np.abs(origins - position).max() < 1e-12


def test_orthographic_rays_are_parallel_and_as_far_apart_as_asked():
    right, up, forward = ASKEW.axes()
    corners = np.array([[0, 0], [48, 0], [0, 32], [24, 16]], float)
    origins, directions, _ = rays_at(cameras.orthographic(ASKEW, SIZE, height=2.0), corners)
    assert directions == pytest.approx(np.tile(forward, (4, 1)))
    assert origins[1] - origins[0] == pytest.approx(3.0 * right)
    assert origins[0] - origins[2] == pytest.approx(2.0 * up)
    assert origins[3] == pytest.approx(np.array(ASKEW.position))
    # Where no height is given, what the pinhole shows of the target's plane.
    far = np.linalg.norm(np.subtract(ASKEW.target, ASKEW.position))
    parallel, sight = cameras.orthographic(ASKEW, SIZE), cameras.pinhole(ASKEW, SIZE)
    assert parallel.origins + far * parallel.directions == pytest.approx(sight.origins + far * sight.directions)


def test_a_pushbroom_is_a_pinhole_upright_and_moves_across():
    right, up, forward = ASKEW.axes()
    points = centers(SIZE)
    origins, directions, _ = rays_at(cameras.pushbroom(ASKEW, SIZE, height=2.0), points)
    sight = lines_of_sight(ASKEW, points, SIZE)
    assert directions @ np.stack([right, up, forward]).T == pytest.approx(
        np.column_stack([np.zeros(len(points)), sight @ up, np.ones(len(points))]), abs=1e-12
    )
    assert (origins - ASKEW.position) @ right == pytest.approx((points[:, 0] - 24.0) / 16.0)
    assert np.cross(origins - ASKEW.position, right) == pytest.approx(np.zeros_like(origins), abs=1e-12)


def test_a_panorama_goes_all_around_and_closes():
    mesh = cameras.panorama(ASKEW, SIZE, columns=12)
    rays = mesh.directions.reshape(2, 13, 3)
    right, up, forward = ASKEW.axes()
    assert rays[:, 0] == pytest.approx(rays[:, -1])
    turn = np.arctan2(rays @ right, rays @ forward)
    assert np.diff(np.unwrap(turn, axis=1), axis=1) == pytest.approx(np.full((2, 12), np.pi / 6))
    assert np.degrees(np.arctan(rays[0] @ up)) == pytest.approx(np.full(13, 27.5))
    # The middle column of an odd number of flat ones is a pinhole's image: straight ahead it is the camera's.
    _, ahead, _ = rays_at(cameras.panorama(ASKEW, SIZE, columns=9), np.array([[24.0, 16.0]]))
    assert unit(ahead)[0] == pytest.approx(forward)


@pytest.mark.parametrize("quads", [3, 9])
def test_the_rim_of_detail_and_context_is_the_perspective_cameras(quads):
    mesh = cameras.detail_and_context(ASKEW, SIZE, rows=quads, columns=quads)
    along = np.random.default_rng(2).uniform(0, 1, 50)
    rim = np.concatenate([np.column_stack([48 * along, 32 * (along > 0.5)]), np.column_stack([0 * along, 32 * along])])
    origins, directions, _ = rays_at(mesh, rim)
    assert unit(directions) == pytest.approx(ASKEW.directions(rim, SIZE), abs=1e-12)
    assert from_line(np.array(ASKEW.position), origins, directions).max() < 1e-12


@pytest.mark.parametrize(("magnification", "spread"), [(1.0, 1), (1.6, 1), (2.0, 0), (3.0, -1)])
def test_the_detail_is_magnified_and_its_rays_spread_less_than_the_eyes(magnification, spread):
    forward = ASKEW.axes()[2]
    far = np.linalg.norm(np.subtract(ASKEW.target, ASKEW.position))
    points = np.random.default_rng(3).uniform((16, 11), (32, 21), (50, 2))
    origins, directions, _ = rays_at(cameras.detail_and_context(ASKEW, SIZE, magnification), points)
    met = origins + directions
    assert (met - ASKEW.target) @ forward == pytest.approx(np.zeros(50), abs=1e-12)
    plain = lines_of_sight(ASKEW, points, SIZE) * far + ASKEW.position - ASKEW.target
    assert (met - ASKEW.target) * magnification == pytest.approx(plain, abs=1e-12)
    outward = np.sum((directions - forward * far / 2) * plain, axis=1)
    assert (np.sign(np.round(outward, 9)) == spread).all()


def test_without_magnification_detail_and_context_is_the_camera():
    _, directions, _ = rays_at(cameras.detail_and_context(ASKEW, SIZE, 1.0, rows=5, columns=4), centers(SIZE))
    assert unit(directions) == pytest.approx(ASKEW.directions(centers(SIZE), SIZE), abs=1e-12)


def test_the_parts_of_multi_perspective_are_the_two_views():
    mesh = cameras.multi_perspective(LEFT, FRONT, THIRDS)
    points = centers((30, 30))
    origins, directions, _ = rays_at(mesh, points)
    parallel = rays_at(cameras.orthographic(LEFT, (30, 30)), points)
    assert unit(directions) == pytest.approx(parallel[1])
    assert np.cross(origins - parallel[0], parallel[1]) == pytest.approx(np.zeros((900, 3)), abs=1e-12)
    origins, directions, _ = rays_at(mesh, points + np.array([60, 0]))
    assert unit(directions) == pytest.approx(FRONT.directions(points, (30, 30)))
    assert from_line(np.array(FRONT.position), origins, directions).max() < 1e-12


@pytest.mark.parametrize("columns", [1, 4])
def test_the_transition_turns_from_one_view_to_the_other(columns):
    mesh = cameras.multi_perspective(LEFT, FRONT, THIRDS, parallel=(False, False), columns=columns)
    points = np.column_stack([np.linspace(30, 60, 61), np.full(61, 15.0)])
    origins, directions, _ = rays_at(mesh, points)
    for end, camera, pixel in ((0, LEFT, 30.0), (-1, FRONT, 0.0)):
        assert unit(directions)[end] == pytest.approx(camera.directions(np.array([pixel, 15.0]), (30, 30)))
        assert from_line(np.array(camera.position), origins[[end]], directions[[end]]).max() < 1e-12
    heading = np.degrees(np.arctan2(-directions[:, 2], directions[:, 0]))
    assert (np.diff(heading) > 0).all() and heading[-1] - heading[0] > 60.0
    steps = np.diff(origins[:, 0])
    # One quad turns evenly, several slowly near either view.
    assert steps[15] / steps[0] == pytest.approx(1.0 if columns == 1 else 0.34375 / 0.15625)


@pytest.mark.parametrize("pole", [0.0, 5.0, 40.0])
@settings(max_examples=20)
@given(center=st.tuples(*[st.floats(-5, 5)] * 3), radius=st.floats(0.1, 10.0), rows=st.integers(2, 8))
def test_all_rays_of_an_inward_sphere_meet_in_its_center(pole, center, radius, rows):
    mesh = cameras.inward_sphere(center, radius, SIZE, rows, 5, pole)
    assert np.abs(np.linalg.norm(mesh.origins - center, axis=1) / radius - 1.0).max() < 1e-9
    origins, directions, _ = rays_at(mesh, centers(SIZE))
    assert np.abs(origins + directions - center).max() < 1e-9


def test_an_inward_sphere_is_a_map_as_of_the_earth():
    mesh = cameras.inward_sphere((0, 0, 0), 2.0, SIZE, rows=8, columns=8, pole=10.0)
    rays = unit(mesh.origins).reshape(9, 9, 3)
    # The middle is the side of +z; to the right comes +x, and -z is at both borders.
    assert rays[4, [0, 2, 4, 6, 8]] == pytest.approx(
        np.array([[0, 0, -1], [-1, 0, 0], [0, 0, 1], [1, 0, 0], [0, 0, -1]])
    )
    assert np.degrees(np.arcsin(rays[:, 3, 1])) == pytest.approx(np.linspace(80, -80, 9))
    turned = cameras.inward_sphere((0, 0, 0), 2.0, SIZE, axes=[[0, 0, -1], [0, 1, 0], [1, 0, 0]])
    assert unit(turned.origins).reshape(11, 11, 3)[5, 5] == pytest.approx([1, 0, 0])


@pytest.mark.parametrize(("pole", "alike"), [(0.0, 20), (5.0, 0)])
def test_only_a_map_to_the_poles_has_triangles_with_one_ray_twice(pole, alike):
    mesh = cameras.inward_sphere((0, 0, 0), 1.0, SIZE, pole=pole)
    origins = mesh.origins[mesh.faces]
    twice = np.linalg.norm(origins - np.roll(origins, 1, axis=1), axis=2).min(axis=1) < 1e-9
    assert twice.sum() == alike


@pytest.mark.parametrize("options", [{"index": 1.0}, {"index": 1.0, "focus": 3.0}, {"index": 1.0, "focus": -9.0}])
def test_a_plane_of_no_index_is_the_pinhole(options):
    _, directions, _ = rays_at(cameras.refracting_plane(ASKEW, SIZE, 2, **options), centers(SIZE))
    assert unit(directions) == pytest.approx(ASKEW.directions(centers(SIZE), SIZE), abs=1e-12)


def test_normals_that_meet_in_the_eye_bend_nothing():
    mesh = cameras.refracting_plane(ASKEW, SIZE, 4, distance=1.5, focus=-1.5)
    assert mesh.unit_directions() == pytest.approx(ASKEW.directions(mesh.image[:, :2], SIZE), abs=1e-12)


@pytest.mark.parametrize(("index", "focus"), [(1.5, 1.0), (1.33, -5.0), (0.9, 3.0)])
def test_vertices_refract_by_snells_law(index, focus):
    forward = NARROW.axes()[2]
    mesh = cameras.refracting_plane(NARROW, SIZE, 4, index, distance=1.5, focus=focus)
    point = np.array(NARROW.position) + (1.5 + focus) * forward
    normals = unit(mesh.origins - point)
    assert (mesh.origins - ASKEW.position) @ forward == pytest.approx(np.full(25, 1.5))
    before, after = NARROW.directions(mesh.image[:, :2], SIZE), mesh.unit_directions()
    assert np.cross(after, normals) * index == pytest.approx(np.cross(before, normals), abs=1e-12)
    assert (np.sum(after * normals, axis=1) * np.sum(before * normals, axis=1) > 0).all()


@pytest.mark.parametrize("index", [1.2, 1.5, 0.8])
def test_a_near_focus_makes_rays_near_the_axis_parallel(index):
    narrow = replace(ASKEW, field_of_view=0.5)
    mesh = cameras.refracting_plane(narrow, (10, 10), 2, index, distance=2.0, focus=2.0 * (index - 1.0))
    angles = np.arccos(np.clip(mesh.unit_directions() @ ASKEW.axes()[2], -1, 1))
    assert angles.max() < 1e-4 < np.radians(0.25)


def test_what_no_light_passes_and_what_turns_away_is_marked():
    total = cameras.refracting_plane(NARROW, SIZE, 4, index=0.5, focus=1.0)
    assert set(total.status) == {RayStatus.OK, RayStatus.TOTAL_REFLECTION}
    behind = cameras.refracting_plane(ASKEW, SIZE, 4, distance=1.5, focus=0.05)
    assert behind.status[12] == RayStatus.OK and behind.status[0] == RayStatus.BACK_FACING
    for mesh in (total, behind):
        assert np.isfinite(mesh.directions).all() and np.linalg.norm(mesh.directions, axis=1).min() > 0.0


def test_a_grid_keeps_its_rays_in_order_and_its_lines_in_place():
    origins = np.arange(18.0).reshape(2, 3, 3)
    mesh = cameras.from_grid(origins, origins + 1.0, (12, 8), columns=[0, 3, 12], rows=[-1, 8])
    assert mesh.image[:, :2].tolist() == [[0, -1], [3, -1], [12, -1], [0, 8], [3, 8], [12, 8]]
    assert mesh.origins == pytest.approx(origins.reshape(6, 3)) and mesh.directions == pytest.approx(mesh.origins + 1.0)
    assert cameras.from_grid(origins, origins + 1.0, (12, 8)).image[:, 0].tolist() == [0, 6, 12, 0, 6, 12]
    assert grid_points((12, 8), (2, 1))[1, 2].tolist() == [12, 8]


RAYS = np.ones((2, 2, 3))
BROKEN = RAYS * [[[np.nan, 1, 1]]]
OPPOSED = np.stack([RAYS[0], -RAYS[0]])


@pytest.mark.parametrize(("make", "said"), [
    (lambda: cameras.from_grid(RAYS, RAYS[:1], SIZE), r"directions \(1, 2, 3\); give both as"),
    (lambda: cameras.from_grid(RAYS[:1], RAYS[:1], SIZE), "at least 2 of each"),
    (lambda: cameras.from_grid(RAYS[..., :2], RAYS[..., :2], SIZE), "give both as"),
    (lambda: cameras.from_grid("rays", RAYS, SIZE), "origins are no array"),
    (lambda: cameras.from_grid(BROKEN, RAYS, SIZE), "origins have NaN"),
    (lambda: cameras.from_grid(RAYS, 0 * RAYS, SIZE), "directions at row 0, column 0 are 0"),
    (lambda: cameras.from_grid(RAYS, OPPOSED, SIZE), "directions of neighbours are opposite"),
    (lambda: cameras.from_grid(RAYS, RAYS, (0, 4)), "size is .* whole pixels"),
    (lambda: cameras.from_grid(RAYS, RAYS, (4.5, 4)), "size is"),
    (lambda: cameras.from_grid(RAYS, RAYS, SIZE, columns=[4, 0]), "columns are .* increasing"),
    (lambda: cameras.from_grid(RAYS, RAYS, SIZE, rows=[0, 1, 2]), "rows are .* give 2 places"),
    (lambda: cameras.pinhole(ASKEW, (3,)), "size is"),
    (lambda: cameras.pinhole(replace(ASKEW, field_of_view=190.0), SIZE), "field_of_view is 190"),
    (lambda: cameras.orthographic(replace(ASKEW, target=ASKEW.position), SIZE), "same point"),
    (lambda: cameras.orthographic(ASKEW, SIZE, height=0.0), "height is 0.0; give metres above 0"),
    (lambda: cameras.pushbroom(ASKEW, SIZE, height=np.nan), "height is nan"),
    (lambda: cameras.panorama(ASKEW, SIZE, angle=0.0), "angle is"),
    (lambda: cameras.panorama(ASKEW, SIZE, columns=2), "angle is 360.0; give degrees between 0 and 360"),
    (lambda: cameras.panorama(replace(ASKEW, up=(0, 0, 0)), SIZE), "up is"),
    (lambda: cameras.detail_and_context(ASKEW, SIZE, magnification=0.5), "magnification is 0.5; give 1 or more"),
    (lambda: cameras.detail_and_context(ASKEW, SIZE, detail=1.0), "detail is 1.0"),
    (lambda: cameras.detail_and_context(ASKEW, SIZE, surface=1.0), "surface is 1.0"),
    (lambda: cameras.detail_and_context(ASKEW, SIZE, rows=2), "rows is 2; give a whole number, 3 or more"),
    (lambda: cameras.multi_perspective(LEFT, FRONT, SIZE, transition=0.0), "transition is 0.0"),
    (lambda: cameras.multi_perspective(LEFT, FRONT, SIZE, columns=0), "columns is 0"),
    (lambda: cameras.multi_perspective(LEFT, Camera(LEFT.target, LEFT.position), SIZE, (True, True)), "left and right"),
    (lambda: cameras.inward_sphere((0, 0), 1.0, SIZE), "center is"),
    (lambda: cameras.inward_sphere((0, 0, 0), -1.0, SIZE), "radius is -1.0"),
    (lambda: cameras.inward_sphere((0, 0, 0), 1.0, SIZE, columns=2), "columns is 2; give a whole number, 3 or more"),
    (lambda: cameras.inward_sphere((0, 0, 0), 1.0, SIZE, rows=1), "rows is 1; give a whole number, 2 or more"),
    (lambda: cameras.inward_sphere((0, 0, 0), 1.0, SIZE, pole=90.0), "pole is 90.0"),
    (lambda: cameras.refracting_plane(ASKEW, SIZE, quads=0), "quads is 0"),
    (lambda: cameras.refracting_plane(ASKEW, SIZE, index=-1.0), "index is -1.0; give a number above 0"),
    (lambda: cameras.refracting_plane(ASKEW, SIZE, distance=0.0), "distance is 0.0; give metres above 0"),
    (lambda: cameras.refracting_plane(ASKEW, SIZE, focus=0.0), "focus is 0.0"),
    (lambda: cube_in_sphere(0), "quads is 0"),
])  # fmt: skip
def test_what_makes_no_camera_is_refused_in_one_line(make, said):
    with pytest.raises(AnamorphError, match=said) as error:
        make()
    assert "\n" not in str(error.value)


def test_the_cube_scene_has_the_thesiss_triangles_and_can_be_drawn():
    scene = check_scene(cube_scene())
    assert [(mesh.name, len(mesh.faces)) for mesh in scene.meshes] == [("cube", 588), ("board", 98)]
    numbered, board = cube_and_board()
    assert np.ptp(board.positions, axis=0).tolist() == [3.5, 0.0, 3.5]
    assert numbered.positions[:, 1].min() > BOARD_HEIGHT + 0.2, "sides that touch fight for pixels"
    a, b, c = np.moveaxis(numbered.positions[numbered.faces].astype(float), 1, 0)
    assert np.sum(np.cross(b - a, c - a) * a) / 6.0 == pytest.approx(EDGE**3, abs=1e-6)


def test_the_numbers_on_the_cube_are_six_and_not_reversed():
    mesh = cube()
    a, b, c = np.moveaxis(mesh.texcoords[mesh.faces].astype(float), 1, 0)
    # Counter-clockwise from outside, and so in the image, whose second coordinate goes down.
    assert (np.cross(np.pad(b - a, ((0, 0), (0, 1))), np.pad(c - a, ((0, 0), (0, 1))))[:, 2] < 0).all()
    assert isinstance(mesh.material, Diffuse) and mesh.material.texture is not None
    pixels = mesh.material.texture.pixels[..., :3].astype(int)
    fields = [pixels[256 * (n // 3) :, 256 * (n % 3) :][:256, :256] for n in range(6)]
    assert len({tuple(field[2, 2]) for field in fields}) == 6
    # A number is darker than its field, and each has its own form.
    masks = [np.abs(field[40:216, 40:216] - field[2, 2]).sum(axis=2) > 150 for field in fields]
    assert all(0.05 < mask.mean() < 0.5 for mask in masks)
    assert all((one ^ other).mean() > 0.03 for i, one in enumerate(masks) for other in masks[:i])


def test_detail_and_context_enlarges_the_cube_and_keeps_the_boards_edges():
    scene, size = cube_scene(), (90, 90)
    plain, bent = (
        seen(make(scene.camera, size), scene, size) for make in (cameras.pinhole, cameras.detail_and_context)
    )
    assert (bent == 1).sum() > 1.5 * (plain == 1).sum() > 0
    rim = np.ones(size, bool)
    rim[2:-2, 2:-2] = False
    assert (plain[rim] == 2).mean() > 0.05 and (plain[rim] == bent[rim]).mean() > 0.97


def test_multi_perspective_shows_two_sides_of_the_cube_and_walks_around_its_corner():
    scene = replace(cube_scene(), meshes=(cube(),))
    mesh, geometry = cameras.multi_perspective(LEFT, FRONT, THIRDS), flatten(scene)
    origins, directions, _ = rays_at(mesh, centers(THIRDS))
    hits = Caster(geometry).cast(origins, directions)
    point = origins + np.where(np.isfinite(hits.distance), hits.distance, 0.0)[:, None] * directions
    hit = (hits.triangle >= 0).reshape(30, 90)
    left, front = ((np.abs(point[:, axis] - at) < 1e-4).reshape(30, 90) & hit for axis, at in ((0, -0.5), (2, 0.5)))
    assert left[:, :30].mean() > 0.2 and front[:, 60:].mean() > 0.2
    assert not front[:, :30].any() and not left[:, 60:].any()
    middle = hit[15, 16:74]
    assert middle.all()
    around = np.where(left[15], point.reshape(30, 90, 3)[15, :, 2], 1.0 + point.reshape(30, 90, 3)[15, :, 0])
    assert (np.diff(around[16:74]) > 0).all(), "the cube's sides follow each other, nothing is reversed"


def test_an_inward_sphere_maps_all_six_sides():
    scene = replace(cube_scene(), meshes=(cube(),))
    origins, directions, _ = rays_at(cameras.inward_sphere((0, 0, 0), 2.0, (60, 60)), centers((60, 60)))
    hits = Caster(flatten(scene)).cast(origins, directions)
    assert (hits.triangle >= 0).all()
    side = (hits.triangle // 98).reshape(60, 60)
    assert side[30, [30, 45, 1, 15]].tolist() == [0, 1, 2, 3] and (side[0] == 4).all() and (side[59] == 5).all()


@pytest.mark.parametrize("quads", [1, 2, 5])
def test_the_part_of_the_ball_fills_a_square_image_with_vertices_on_the_ball(quads):
    scene = check_scene(cube_in_sphere(quads))
    mirror = scene.meshes[0]
    assert len(mirror.faces) == 2 * quads**2 and isinstance(mirror.surface, Sphere)
    plain = check_scene(cube_in_sphere(quads, exact=False)).meshes[0]
    assert plain.surface is None and (plain.normals == mirror.normals).all()
    assert np.linalg.norm(mirror.positions - BALL.center, axis=1) == pytest.approx(1.0, abs=1e-6)
    assert (seen(cameras.pinhole(scene.camera, (81, 81)), scene, (81, 81)) == 1).all()
    offset = np.asarray(scene.camera.position) - mirror.positions
    assert (np.sum(offset * mirror.normals, axis=1) > 0.2).all(), "the side near the eye, from close by"
    edges = np.array([[0.5, 0.5], [799.5, 0.5], [400.0, 0.5], [0.5, 400.0], [799.5, 799.5], [0.5, 799.5]])
    directions = scene.camera.directions(edges, (800, 800))
    first = Caster(flatten(scene)).cast(np.tile(scene.camera.position, (6, 1)), directions).triangle
    assert (first >= 0).all() and (first < len(mirror.faces)).all()


def test_the_wavy_mirror_is_flat_and_its_normals_are_turned_by_chance_and_always_alike():
    scene = check_scene(cube_in_wavy_mirror())
    mirror = scene.meshes[0]
    assert len(mirror.faces) == 50 and mirror.surface is None
    assert (mirror.positions[:, 2] == -2.0).all()
    turned = np.degrees(np.arccos(mirror.normals[:, 2].astype(float)))
    assert 3.0 < np.sqrt((turned**2).mean() / 2.0) < 5.0 and len(np.unique(turned)) == 36
    assert (cube_in_wavy_mirror().meshes[0].normals == mirror.normals).all()
    assert (cube_in_wavy_mirror(seed=8).meshes[0].normals != mirror.normals).any()
    assert (seen(cameras.pinhole(scene.camera, (81, 81)), scene, (81, 81)) == 1).all()
    flat = cube_in_wavy_mirror(degrees=0.0).meshes[0]
    assert (flat.normals == [0, 0, 1]).all()
