"""CONVENTIONS.md, row by row, against what the code does."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scenes import CENTER, drawn, scene_with, spherical_mirror

from anamorph import gallery
from anamorph.base.errors import AnamorphError
from anamorph.base.srgb import decode_srgb
from anamorph.frame import Status, View
from anamorph.gallery.solids import grid
from anamorph.methods import METHODS
from anamorph.optics.laws import reflect
from anamorph.optics.reflection import reflected_rays, reflector
from anamorph.projection import camera_projection
from anamorph.scene.camera import Camera
from anamorph.scene.model import AmbientLight, Diffuse, Mirror, Scene, Texture

CAMERA = Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0), field_of_view=40.0)
SIZE = (80, 60)
TESTED = {
    "World frame", "Camera", "Image", "Clip space", "Matrices", "Texture coordinates", "Colours", "Triangles",
    "Normals", "Ray directions", "Refraction", "Lenses", "Turning", "Curvature", "Objects", "Sky pixels", "Precision",
    "Shapes", "Angles", "Failure",
}  # fmt: skip


def four_colours():
    """Red and green above, blue and white below."""
    pixels = np.full((2, 2, 4), 255, np.uint8)
    pixels[0, 0, :3], pixels[0, 1, :3], pixels[1, 0, :3] = (255, 0, 0), (0, 255, 0), (0, 0, 255)
    return Texture(pixels.repeat(16, 0).repeat(16, 1))


def quad(repeat=1.0):
    """Two metres square, facing +z, whose texture's top left is at (-1, 1, 0)."""
    shape = grid((-1.0, -1.0, 0.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0), image=(0.0, 0.0, repeat, repeat))
    return shape.mesh("quad", Diffuse((1, 1, 1), four_colours()))


@pytest.fixture(scope="module")
def frame():
    return drawn(Scene("quad", (quad(),), CAMERA, (AmbientLight((1, 1, 1), (1, 1, 1)),)), "pervertex", SIZE)


def test_every_row_of_the_page_has_a_test_here_or_in_its_room():
    page = (Path(__file__).parents[1] / "CONVENTIONS.md").read_text()
    assert set(re.findall(r"^\| ([A-Z][^|]*?) \|", page, re.MULTILINE)) == TESTED


def test_world_and_camera_are_right_handed_with_y_up(frame):
    right, up, forward = CAMERA.axes()
    assert (right, up, forward) == (pytest.approx([1, 0, 0]), pytest.approx([0, 1, 0]), pytest.approx([0, 0, -1]))
    askew = Camera((1.0, 2.0, 3.0), (-2.0, 0.5, 1.0), (0.2, 1.0, 0.1)).axes()
    assert askew @ askew.T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(askew) == pytest.approx(-1.0), "right x up is backward"
    # In the drawn image +x is on the right and +y above.
    seen = frame.object_id == 1
    assert (frame.position[:, 40:][seen[:, 40:]][:, 0] > 0).all()
    assert (frame.position[:30][seen[:30]][:, 1] > 0).all()


def test_the_field_of_view_is_the_full_vertical_angle():
    for size in [(80, 60), (20, 60)]:
        top, bottom = CAMERA.directions(np.array([[size[0] / 2, 0.0], [size[0] / 2, 60.0]]), size)
        assert np.degrees(np.arccos(top @ bottom)) == pytest.approx(40.0)


def test_pixels_count_from_the_top_left_and_the_first_centre_is_half_half(frame):
    first = CAMERA.directions(np.array([0.5, 0.5]), SIZE)
    assert first[0] < 0 and first[1] > 0
    assert frame.position[0, 0] == pytest.approx(first, abs=1e-6)
    # A pixel sees what its centre sees, to float32.
    row, column = 25, 50
    look = CAMERA.directions(np.array([column + 0.5, row + 0.5]), SIZE)
    assert frame.position[row, column] == pytest.approx(CAMERA.position - 3.0 / look[2] * look, abs=1e-5)
    assert frame.color.shape == (60, 80, 3)


def test_clip_space_is_webgpus_with_reversed_depth(frame):
    matrix = camera_projection(CAMERA, SIZE).clip
    assert matrix.dtype == np.float64
    right_up, near, far = (matrix @ [*point, 1.0] for point in [(0.2, 0.1, 0.0), (0, 0, 2.9), (0, 0, -500.0)])
    assert right_up[0] / right_up[3] > 0 and right_up[1] / right_up[3] > 0
    assert near[2] / near[3] > far[2] / far[3] > 0
    # The nearer of two surfaces is seen, whichever comes first.
    behind = replace(quad(), positions=quad().positions - np.float32([0, 0, 1]))
    for meshes, number in [((quad(), behind), 1), ((behind, quad()), 2)]:
        assert drawn(Scene("two", meshes, CAMERA), "pervertex", SIZE).object_id[30, 40] == number


def test_matrices_act_on_columns_and_are_transposed_for_the_device():
    projection = camera_projection(CAMERA, SIZE)
    words = projection.uniform(SIZE)
    assert words.dtype == np.float32
    assert pytest.approx(projection.clip, rel=1e-6) == words[:16].reshape(4, 4).T
    assert projection.clip @ [0.0, 0.0, 0.0, 1.0] == pytest.approx([0.0, 0.0, 3e-6, 3.0])


@pytest.mark.parametrize("method", METHODS)
def test_textures_begin_at_the_top_left_and_repeat(method):
    lights = (AmbientLight((1, 1, 1), (1, 1, 1)),)
    red, green, blue, white = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]])
    image = drawn(Scene("quad", (quad(),), CAMERA, lights), method, SIZE).color
    for (row, column), color in {(15, 25): red, (15, 55): green, (45, 25): blue, (45, 55): white}.items():
        assert image[row, column] == pytest.approx(color, abs=2e-3)
    twice = drawn(Scene("quad", (quad(2.0),), CAMERA, lights), method, SIZE).color
    for row, column in [(12, 22), (12, 43), (33, 22), (33, 43)]:
        assert twice[row, column] == pytest.approx(red, abs=2e-2)


def test_colours_are_linear_but_in_textures_which_are_srgb(frame):
    grey = Texture(np.full((4, 4, 4), 128, np.uint8))
    ambient = (AmbientLight((1, 1, 1), (1, 1, 1)),)
    textured = replace(quad(), material=Diffuse((1, 1, 1), grey))
    plain = replace(quad(), material=Diffuse((0.5, 0.5, 0.5)))
    for mesh, expected in [(textured, decode_srgb(np.array(128 / 255))), (plain, 0.5)]:
        color = drawn(Scene("grey", (mesh,), CAMERA, ambient), "pervertex", SIZE).color[30, 40]
        assert color == pytest.approx(np.full(3, expected), abs=1e-3)
    assert frame.color.dtype == np.float32


@pytest.mark.parametrize("name", gallery.names())
def test_triangles_turn_counter_clockwise_and_normals_point_outside(name):
    scene = gallery.make(name)
    for mesh in scene.meshes:
        corners = np.asarray(mesh.positions, float)[mesh.faces]
        area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        mean = np.asarray(mesh.normals, float)[mesh.faces].mean(axis=1)
        assert (np.einsum("fi,fi->f", area, mean) > 0.0).mean() > 0.98, mesh.name
        assert np.linalg.norm(mesh.normals, axis=1) == pytest.approx(1.0, abs=1e-3)
    # The side of a mirror that is looked at is its outside.
    eye = np.array(scene.camera.position)
    facing = [
        np.einsum("vi,vi->v", eye - mesh.positions, mesh.normals).max() > 0
        for mesh in scene.meshes
        if isinstance(mesh.material, Mirror)
    ]
    assert any(facing) or not facing


def test_rays_point_away_from_the_eye_and_reflect_by_the_law():
    scene = scene_with(spherical_mirror())
    mirror = reflector(scene.meshes[0])
    rays = reflected_rays(mirror, scene.camera.eye(SIZE))
    incident = mirror.positions - np.array(scene.camera.position)
    incident /= np.linalg.norm(incident, axis=1, keepdims=True)
    cosine = np.sum(mirror.normals * incident, axis=1, keepdims=True)
    assert rays.unit_directions() == pytest.approx(incident - 2.0 * cosine * mirror.normals, abs=1e-12)
    assert reflect(incident, mirror.normals) == pytest.approx(rays.unit_directions(), abs=1e-12)
    assert (rays.origins == mirror.positions).all()


@pytest.mark.parametrize("method", METHODS)
def test_objects_are_numbered_from_one_and_the_sky_is_nought(method):
    scene = scene_with(spherical_mirror())
    frame = drawn(scene, method)
    numbers = {mesh.name: number for number, mesh in enumerate(scene.meshes, start=1)}
    for name, point in [("box-3", (-0.115, 0.4, 0.3)), ("box-4", (0.25, 0.7, -0.4))]:
        x, y, _, w = camera_projection(scene.camera, (160, 120)).clip @ [*point, 1.0]
        column, row = int((x / w + 1) * 80), int((1 - y / w) * 60)
        assert frame.object_id[row, column] == numbers[name]
    assert set(np.unique(frame.specular)) == {0, numbers["mirror"]}
    assert frame.object_id[0, 0] == 0 and frame.specular[0, 0] == 0
    # The mirror's own number stands in `specular`; what it shows in `object_id`.
    assert numbers["floor"] in frame.object_id[frame.specular == 1]


@pytest.mark.parametrize("method", METHODS)
def test_sky_pixels_hold_the_unit_direction_that_is_seen(method):
    scene = scene_with(spherical_mirror())
    frame = drawn(scene, method)
    sky = frame.object_id == 0
    assert np.linalg.norm(frame.position[sky], axis=1) == pytest.approx(1.0, abs=1e-4)
    direct = sky & (frame.specular == 0)
    rows, columns = np.nonzero(direct)
    looks = scene.camera.directions(np.stack([columns, rows], axis=-1) + 0.5, (160, 120))
    assert frame.position[direct] == pytest.approx(looks, abs=1e-5)
    mirrored = sky & (frame.specular == 1)
    assert (frame.position[mirrored][:, 2] > 0.5).all(), "a mirror that faces +z shows the sky over +z"


def test_images_are_float32_and_optics_float64(frame):
    assert frame.color.dtype == frame.position.dtype == np.float32
    scene = scene_with(spherical_mirror())
    assert scene.meshes[0].positions.dtype == np.float32
    rays = reflected_rays(reflector(scene.meshes[0]), scene.camera.eye(SIZE))
    assert rays.origins.dtype == rays.directions.dtype == rays.image.dtype == np.float64
    assert rays.origins.shape == rays.directions.shape == (81, 3)
    assert scene.camera.directions(np.zeros((4, 5, 2)), SIZE).dtype == np.float64


def test_failure_is_data_or_one_error(frame):
    assert frame.status.dtype == np.uint8 and set(np.unique(frame.status)) <= {int(status) for status in Status}
    with pytest.raises(AnamorphError):
        METHODS["pervertex"].open(View(Scene("q", (quad(),), CAMERA), CAMERA, (0, 0)), METHODS["pervertex"].options())


def test_the_shared_mirror_stands_where_the_tests_say():
    assert np.asarray(spherical_mirror().positions).mean(axis=0) == pytest.approx(CENTER, abs=0.02)
