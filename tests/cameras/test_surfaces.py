"""Cameras that are surfaces or sets of rays, and the one number of perspective: their rays in closed form."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from camera_rays import centers, from_line, rays_at, unit
from hypothesis import given, settings
from hypothesis import strategies as st

import anamorph as an
from anamorph import cameras
from anamorph.base.errors import AnamorphError
from anamorph.cameras.linear import target_distance
from anamorph.gallery.cube import cube_scene
from anamorph.gallery.torus import torus_surface
from anamorph.raymesh import RayMesh
from anamorph.scene.camera import Camera
from anamorph.surfaces.bezier import BezierPatch
from anamorph.surfaces.even_asphere import EvenAsphere
from anamorph.surfaces.plane import Plane
from anamorph.surfaces.sphere import Sphere
from anamorph.surfaces.toroid import Toroid

ASKEW = Camera((1.0, 2.0, 3.0), (-0.5, 0.25, -1.0), (0.2, 1.0, 0.1), 55.0)
SIZE = (48, 32)
DOME = np.array(
    [
        [[x, 2.5 * (abs(x) < 1.0 and abs(z) < 1.0) + 0.2, z] for z in (1.2, 0.9, -0.9, -1.2)]
        for x in (-1.2, -0.9, 0.9, 1.2)
    ]
)
"""Control points over the thesis's cube, steep at the rim."""

SURFACES = {
    "plane": (
        Plane(np.array([1.0, 2.0, 3.0]), np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])),
        ((-1, 1), (-1, 2)),
    ),
    "sphere": (Sphere(np.array([1.0, 2.0, 3.0]), 0.7), ((-2.0, 2.5), (-1.0, 1.2))),
    "toroid": (Toroid(np.array([1.0, 2.0, 3.0]), 0.5, -0.3), ((-1, 1), (-1, 1))),
    "asphere": (EvenAsphere(np.array([1.0, 2.0, 3.0]), 0.5, -0.4, (0.01,)), ((-1, 1), (-1, 1))),
    "patch": (BezierPatch(DOME), None),
    "mirrored patch": (BezierPatch(DOME * [-1.0, 1.0, 1.0]), None),
    "torus": (torus_surface((0.0, 1.0, 0.0), np.eye(3), 1.5, 0.4), ((0.0, 4.0), (0.3, 1.9))),
}
every_surface = pytest.mark.parametrize("name", SURFACES)


@pytest.mark.parametrize("inward", [False, True])
@every_surface
def test_rays_leave_a_surface_along_its_normals(name: str, inward: bool) -> None:
    surface, window = SURFACES[name]
    mesh = cameras.from_surface(surface, SIZE, inward, window, rows=5, columns=7)
    uv = surface.parameters(mesh.origins)
    assert surface.position(uv) == pytest.approx(mesh.origins, abs=1e-9)
    assert surface.normal(uv) * (-1.0 if inward else 1.0) == pytest.approx(mesh.directions, abs=1e-6)


@pytest.mark.parametrize("inward", [False, True])
@every_surface
def test_what_a_surface_sees_is_not_mirrored(name: str, inward: bool) -> None:
    surface, window = SURFACES[name]
    mesh = cameras.from_surface(surface, SIZE, inward, window, rows=6, columns=6)
    middle = np.array([[24.0, 16.0], [24.5, 16.0], [24.0, 15.5]])
    origins, directions, _ = rays_at(mesh, middle)
    right, up = origins[1:] - origins[0]
    assert np.linalg.det([unit(right), unit(up), unit(directions)[0]]) < -0.3


@pytest.mark.parametrize("name", ["toroid", "asphere", "patch", "torus"])
def test_twice_the_quads_are_four_times_as_near_to_the_normals(name: str) -> None:
    """Of a plane one quad is exact, and between points of a sphere the rays still run through its center."""
    surface, window = SURFACES[name]
    points = np.random.default_rng(1).uniform((12, 8), (36, 24), (200, 2))
    off = []
    for quads in (12, 24):
        origins, directions, _ = rays_at(cameras.from_surface(surface, SIZE, False, window, quads, quads), points)
        normals = surface.normal(surface.parameters(origins))
        off.append(np.linalg.norm(unit(directions) - normals, axis=1).mean())
    assert 0.1 < off[1] / off[0] < 0.45 and off[1] < 0.03


def test_a_ball_that_looks_inward_is_the_map_of_a_thing() -> None:
    ball = Sphere(np.array([0.1, 0.2, 0.3]), 2.0)
    top = np.radians(85.0)
    mesh = cameras.from_surface(ball, SIZE, True, ((-np.pi, np.pi), (-top, top)), 10, 10)
    mapped = cameras.inward_sphere((0.1, 0.2, 0.3), 2.0, SIZE)
    assert mesh.origins == pytest.approx(mapped.origins, abs=1e-12)
    assert mesh.directions * 2.0 == pytest.approx(mapped.directions, abs=1e-12)


def test_the_dome_sees_five_sides_of_the_cube() -> None:
    """The thesis's Figure 11: in a perspective image there are three at most."""
    cube = replace(cube_scene(), meshes=cube_scene().meshes[:1])
    sides = {}
    for name, camera in {"dome": cameras.from_surface(BezierPatch(DOME), (60, 60), True), "eye": cube.camera}.items():
        frame = an.render(cube, "raytrace", camera=camera, size=(60, 60), seen=True)
        points = frame.position[frame.object_id == 1]
        axis = np.abs(points).argmax(axis=1)
        sides[name] = set(zip(axis, points[np.arange(len(axis)), axis] > 0.0, strict=True))
    assert sides["dome"] == {(0, False), (0, True), (1, True), (2, False), (2, True)}
    assert len(sides["eye"]) == 3


def shown(camera: Camera, amount: float, depth: float) -> np.ndarray:
    """Where rays through the corners of the image meet the plane `depth` beyond the target: (2, 2), right and up."""
    mesh = cameras.perspective(camera, SIZE, amount)
    right, up, forward = camera.axes()
    origins, directions, _ = rays_at(mesh, np.array([[48.0, 0.0], [0.0, 32.0]]))
    way = (depth - (origins - camera.target) @ forward) / (directions @ forward)
    met = origins + way[:, None] * directions - camera.target
    return np.stack([met @ right, met @ up], axis=-1)


@given(amount=st.floats(-5.0, 5.0) | st.sampled_from((0.0, 1.0, -1.0, 1e-12)), depth=st.floats(-0.5, 3.0))
def test_the_height_that_is_shown_grows_with_depth_as_the_amount_says(amount: float, depth: float) -> None:
    distance = target_distance(ASKEW)
    height = 2.0 * distance * np.tan(np.radians(27.5)) * (1.0 + amount * depth / distance)
    corner = shown(ASKEW, amount, depth)
    assert corner[0] == pytest.approx([0.75 * height, 0.5 * height], abs=1e-9)
    assert corner[1] == pytest.approx([-0.75 * height, -0.5 * height], abs=1e-9)


def test_reversed_perspective_enlarges_what_is_farther_away() -> None:
    """A thing of one size is as large in the image as the height shown there is small."""
    depths = np.linspace(-2.0, 2.0, 9)
    for amount, sign in ((0.8, -1.0), (-0.8, 1.0)):
        size = [1.0 / shown(ASKEW, amount, depth)[0, 1] for depth in depths]
        assert (np.sign(np.diff(size)) == sign).all()
    assert np.ptp([shown(ASKEW, 0.0, depth)[0, 1] for depth in depths]) < 1e-12


def test_the_amount_of_perspective_has_no_jump_at_its_middle() -> None:
    points = centers(SIZE)
    at_zero = rays_at(cameras.perspective(ASKEW, SIZE, 0.0), points)
    parallel = rays_at(cameras.orthographic(ASKEW, SIZE), points)
    assert unit(at_zero[1]) == pytest.approx(parallel[1], abs=1e-12)
    assert from_line(at_zero[0][0], parallel[0][:1], parallel[1][:1]) < 1e-12
    for amount in (1e-7, -1e-7):
        origins, directions, _ = rays_at(cameras.perspective(ASKEW, SIZE, amount), points)
        assert np.abs(unit(directions) - unit(at_zero[1])).max() < 1e-6
        assert np.abs(origins - at_zero[0]).max() < 1e-6
    plain = rays_at(cameras.perspective(ASKEW, SIZE, 1.0), points)
    assert unit(plain[1]) == pytest.approx(ASKEW.directions(points, SIZE), abs=1e-12)
    assert np.abs(plain[0] - ASKEW.position).max() < 1e-12


@given(amount=st.floats(1.0, 20.0))
def test_much_perspective_begins_where_its_rays_part(amount: float) -> None:
    origins, _, _ = rays_at(cameras.perspective(ASKEW, SIZE, amount), centers(SIZE)[::97])
    assert np.ptp(origins, axis=0).max() < 1e-9


@settings(max_examples=30)
@given(distance=st.floats(0.01, 50.0), angle=st.floats(1.0, 170.0))
def test_anti_perspective_rays_leave_a_rectangle_and_converge_in_one_point(distance: float, angle: float) -> None:
    camera = replace(ASKEW, field_of_view=angle)
    right, up, forward = camera.axes()
    origins, directions, _ = rays_at(cameras.anti_perspective(camera, SIZE, distance), centers(SIZE))
    point = camera.position + distance * forward
    assert np.abs(origins + directions - point).max() < 1e-9 * distance * np.tan(np.radians(angle / 2.0)) + 1e-9
    assert (origins - camera.position) @ forward == pytest.approx(np.zeros(len(origins)), abs=1e-6)
    corner, _, _ = rays_at(cameras.anti_perspective(camera, SIZE, distance), np.array([[48.0, 0.0]]))
    half = distance * np.tan(np.radians(angle / 2.0))
    assert ((corner - camera.position) @ np.stack([right, up]).T)[0] == pytest.approx([1.5 * half, half], rel=1e-9)


def test_a_set_of_rays_is_interpolated_between_its_places() -> None:
    generator = np.random.default_rng(2)
    places = np.concatenate([[[0, 0], [48, 0], [0, 32], [48, 32]], generator.uniform((0, 0), SIZE, (40, 2))])
    plain = cameras.pinhole(ASKEW, SIZE)
    origins, directions, _ = rays_at(plain, places)
    found = rays_at(cameras.from_rays(places, origins, directions), centers(SIZE))
    assert (found[2] >= 1).all()
    # A pinhole's rays are linear in the image, so that any triangles between them are exact.
    assert found[0] == pytest.approx(rays_at(plain, centers(SIZE))[0], abs=1e-12)
    assert found[1] == pytest.approx(rays_at(plain, centers(SIZE))[1], abs=1e-9)


def turned_quad() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Two triangles across ASKEW's view with normals that spread, the second one turned the other way."""
    right, up, forward = ASKEW.axes()
    corners = np.array([[-1.5, 1.0], [1.5, 1.0], [1.5, -1.0], [-1.5, -1.0]])
    across = corners @ np.stack([right, up])
    return ASKEW.position + across, 2.0 * forward + across, np.array([[0, 1, 2], [0, 2, 3][::-1]])


def test_triangles_with_normals_lie_in_the_image_as_seen_from_behind() -> None:
    positions, normals, faces = turned_quad()
    mesh = cameras.from_triangles(positions, normals, faces, SIZE, up=ASKEW.up)
    assert mesh.image[:, :2] == pytest.approx(np.array([[0, 0], [48, 0], [48, 32], [0, 32]]), abs=1e-9)
    assert (np.linalg.det(mesh.image[mesh.faces]) < 0.0).all()
    origins, directions, _ = rays_at(mesh, centers(SIZE))
    assert np.abs(origins - directions - ASKEW.position + 2.0 * ASKEW.axes()[2]).max() < 1e-9
    # In a wider image they keep their proportions, and where they are told to be they are.
    wide = cameras.from_triangles(positions, normals, faces, (96, 32), up=ASKEW.up)
    assert wide.image[:, :2] == pytest.approx(mesh.image[:, :2] + [24.0, 0.0], abs=1e-9)
    told = [[1, 2], [9, 3], [8, 20], [2, 30]]
    assert cameras.from_triangles(positions, normals, faces, SIZE, told).image[:, :2].tolist() == told


def immediate(size: tuple[int, int], kind: str, positions: np.ndarray, normals: np.ndarray, **settings: int) -> RayMesh:
    surface = cameras.RaySurface(size)
    surface.begin_surface(kind, **settings)
    for position, normal in zip(positions, normals, strict=True):
        surface.normal(*normal)
        surface.vertex(*position)
    surface.end_surface()
    return surface.ray_mesh()


def same_rays(one: RayMesh, other: RayMesh) -> None:
    assert np.array_equal(one.image, other.image) and np.array_equal(one.faces, other.faces)
    assert np.array_equal(one.origins, other.origins) and np.array_equal(one.directions, other.directions)


def test_immediate_mode_makes_what_the_makers_make() -> None:
    origins, directions, _ = rays_at(
        cameras.pinhole(ASKEW, SIZE), np.array([[x, y] for y in (0, 16, 32) for x in (0, 48)])
    )
    made = cameras.from_grid(origins.reshape(3, 2, 3), directions.reshape(3, 2, 3), SIZE)
    same_rays(immediate(SIZE, "rays", origins, directions, columns=2), made)
    positions, normals, faces = turned_quad()
    positions, normals = positions[faces.ravel()], normals[faces.ravel()]
    made = cameras.from_triangles(positions, normals, np.arange(6).reshape(2, 3), SIZE)
    same_rays(immediate(SIZE, "triangles", positions, normals), made)


def test_control_points_row_by_row_are_the_image_of_their_patch() -> None:
    rows = DOME.transpose(1, 0, 2)[::-1]
    mesh = immediate(SIZE, "patch", rows.reshape(-1, 3), np.ones((16, 3)), quads=16)
    made = cameras.from_surface(BezierPatch(DOME), SIZE, True)
    assert mesh.image == pytest.approx(made.image)
    assert mesh.origins == pytest.approx(made.origins, abs=1e-12)
    assert mesh.directions == pytest.approx(made.directions, abs=1e-9)


def test_control_points_in_a_mirrored_order_see_to_the_other_side() -> None:
    """And their image is as little mirrored as that of the others."""
    rows = DOME.transpose(1, 0, 2)[::-1, ::-1]
    mesh = immediate(SIZE, "patch", rows.reshape(-1, 3), np.ones((16, 3)), quads=16)
    assert mesh.origins == pytest.approx(cameras.from_surface(BezierPatch(DOME), SIZE).origins, abs=1e-12)
    assert mesh.directions == pytest.approx(cameras.from_surface(BezierPatch(DOME), SIZE).directions, abs=1e-9)


def test_surfaces_fill_their_viewports() -> None:
    surface = cameras.RaySurface((60, 20))
    for left in (0.0, 0.5):
        surface.viewport(left, 0.0, left + 0.5, 1.0)
        surface.begin_surface("rays", columns=2)
        surface.normal(left, 0.0, -1.0)
        for x, y in ((-1, 1), (1, 1), (-1, -1), (1, -1)):
            surface.vertex(x, y, 0.0)
        surface.end_surface()
    mesh = surface.ray_mesh()
    origins, directions, counts = rays_at(mesh, centers((60, 20)))
    assert (counts == 1).all()
    half = centers((60, 20))[:, 0] > 30.0
    assert (directions[half, 0] == 0.5).all() and (directions[~half, 0] == 0.0).all()
    assert origins[:30, 0] == pytest.approx(origins[30:60, 0])


def ended(kind: str, vertices: int) -> Callable[[], object]:
    def build() -> None:
        immediate(SIZE, kind, np.zeros((vertices, 3)), np.ones((vertices, 3)))

    return build


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: cameras.from_surface(Sphere(np.zeros(3), 1.0), SIZE), "window is not given"),
        (lambda: cameras.from_surface(Sphere(np.zeros(3), 1.0), SIZE, False, ((1, 1), (0, 1))), "no two alike"),
        (lambda: cameras.from_surface(Sphere(np.zeros(3), 1.0), SIZE, False, ((1, np.nan), (0, 1))), "finite"),
        (lambda: cameras.from_surface(Sphere(np.zeros(3), 1.0), SIZE, False, ((1, 2), 3)), "window is"),
        (lambda: cameras.from_surface(BezierPatch(np.zeros((4, 4, 3))), SIZE), "collapse"),
        (lambda: cameras.from_surface(BezierPatch(DOME * [1, 0, 0]), SIZE), "collapse"),
        (lambda: cameras.from_surface(BezierPatch(DOME), SIZE, rows=0), "rows is 0"),
        (lambda: cameras.perspective(ASKEW, SIZE, np.inf), "amount is inf"),
        (lambda: cameras.anti_perspective(ASKEW, SIZE, 0.0), "distance is 0.0"),
        (lambda: cameras.from_rays([[0, 0], [1, 1]], np.zeros((2, 3)), np.ones((2, 3))), "places are 2"),
        (lambda: cameras.from_rays([[0, 0], [1, 1], [2, 2]], np.zeros((3, 3)), np.ones((3, 3))), "one line"),
        (lambda: cameras.from_rays([[0, 0], [1, 1], [2, 1]], np.zeros((3, 3)), np.zeros((3, 3))), "no length"),
        (lambda: cameras.from_rays([[0, 0], [1, 1], [2, 1]], np.zeros((2, 3)), np.ones((3, 3))), "origins are"),
        (lambda: cameras.from_rays("a", np.zeros((3, 3)), np.ones((3, 3))), "places are no array"),
        (lambda: cameras.from_triangles(np.eye(3), np.eye(3), [[0, 1, 3]], SIZE), "vertex 3"),
        (lambda: cameras.from_triangles(np.eye(3), np.eye(3), [[0, 1, 1.5]], SIZE), "whole numbers"),
        (lambda: cameras.from_triangles(np.eye(3), [[0, 1, 0]] * 3, [[0, 1, 2]], SIZE), "up runs along"),
        (lambda: cameras.from_triangles([[0, 0, 0]] * 3, [[0, 0, 1]] * 3, [[0, 1, 2]], SIZE), "is a line"),
        (lambda: cameras.RaySurface(SIZE).vertex(0, 0, 0), "outside a surface"),
        (lambda: cameras.RaySurface(SIZE).end_surface(), "no begin_surface"),
        (lambda: cameras.RaySurface(SIZE).ray_mesh(), "there is no surface"),
        (lambda: cameras.RaySurface(SIZE).normal(0, 0, 0), "normal is"),
        (lambda: cameras.RaySurface(SIZE).begin_surface("circle"), "kind of surface is 'circle'"),
        (lambda: cameras.RaySurface(SIZE).viewport(0, 0, 1.5, 1), "viewport is"),
        (lambda: cameras.RaySurface(SIZE).viewport(0, 0, 1e-3, 1), "0 x 32 pixels"),
        (ended("rays", 5), "no two rows of 2"),
        (ended("triangles", 4), "4 vertices"),
        (ended("patch", 15), "15 control points"),
        (ended("patch", 16), "collapse"),
    ],
)  # fmt: skip
def test_what_makes_no_camera_is_refused_in_one_line(make: Callable[[], object], words: str) -> None:
    with pytest.raises(AnamorphError, match=words) as told:
        make()
    assert "\n" not in str(told.value)


def test_immediate_mode_says_what_is_out_of_order() -> None:
    surface = cameras.RaySurface(SIZE)
    surface.begin_surface("rays")
    with pytest.raises(AnamorphError, match="within a surface"):
        surface.begin_surface("rays")
    with pytest.raises(AnamorphError, match="not ended"):
        surface.ray_mesh()
    for _ in range(4):
        surface.vertex(0, 0, 0)
    with pytest.raises(AnamorphError, match="before any normal"):
        surface.end_surface()
