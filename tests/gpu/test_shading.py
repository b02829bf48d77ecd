"""The colours of the device against a float64 twin of the shading, written here from its description."""

from __future__ import annotations

from dataclasses import replace
from importlib import resources

import numpy as np
import pytest
from scenes import drawn, open_view

from anamorph.base.errors import AnamorphError
from anamorph.base.srgb import decode_srgb, encode_srgb
from anamorph.frame import View
from anamorph.gallery import make
from anamorph.gallery.solids import grid
from anamorph.gallery.textures import checkerboard
from anamorph.gpu.buffers import MOST_LIGHTS
from anamorph.gpu.device import get_device
from anamorph.gpu.drawing import draw_mesh, make_pipeline, submit
from anamorph.gpu.shaders import shader_module
from anamorph.gpu.targets import begin_pass, make_target, read_texture
from anamorph.gpu.textures import mip_levels
from anamorph.methods import METHODS
from anamorph.methods.stage import Stage
from anamorph.projection import camera_projection
from anamorph.scene.camera import Camera
from anamorph.scene.model import AmbientLight, Diffuse, DirectionalLight, PointLight, Scene, Sky, Texture

HALF = 2e-3
"""What half precision leaves of a colour."""

LEFT, RIGHT = np.array([-1.0, 1.0])
CAMERA = Camera((0.0, 0.0, 2.0), (0.0, 0.0, 0.0), field_of_view=40.0)
SIZE = (64, 48)


def decode(encoded):
    """sRGB to linear, one value at a time."""
    value = encoded / 255.0
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


def quad(material=None, colors=None, texcoords=True, turn=0.0, tilt=0.0):
    """Two metres square around the origin, facing +z, tilted downward and then turned about the y axis."""
    shape = grid((-1.0, -1.0, 0.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0)).turned(tilt, axis=0).turned(turn)
    mesh = shape.mesh("quad", material or Diffuse())
    square = np.array([[0.0, 1.0], [1.0, 1.0], [0.0, 0.0], [1.0, 0.0]], np.float32)
    return replace(mesh, colors=colors, texcoords=square if texcoords else None)


def image(mesh, lights, camera=CAMERA, sky=None, size=SIZE, method="pervertex"):
    return drawn(Scene("quad", (mesh,), camera, tuple(lights), Sky() if sky is None else sky), method, size)


def twin(frame, normal, lights, color, eye):
    """The diffuse colour at every seen point, (H, W, 3)."""
    points = frame.position.astype(float)
    shape = points.shape[:2]
    normal = np.asarray(normal, float) / np.linalg.norm(normal)
    facing = np.sign((eye - points) @ normal)[..., None] * normal
    total = np.zeros((*shape, 3))
    for light in lights:
        match light:
            case AmbientLight(sky=above, ground=below):
                share = (0.5 + 0.5 * facing[..., 1])[..., None]
                total += share * np.array(above) + (1.0 - share) * np.array(below)
            case DirectionalLight(toward=toward, color=shine):
                toward = np.asarray(toward) / np.linalg.norm(toward)
                total += np.maximum(facing @ toward, 0.0)[..., None] * np.array(shine)
            case PointLight(position=place, color=shine):
                offset = np.array(place) - points
                distance = np.linalg.norm(offset, axis=-1, keepdims=True)
                cosine = np.sum(facing * offset, axis=-1, keepdims=True) / distance
                total += np.maximum(cosine, 0.0) / distance**2 * np.array(shine)
    return total * np.asarray(color)


LIGHTS = {
    "none": (),
    "ambient": (AmbientLight((0.5, 0.6, 0.7), (0.3, 0.2, 0.1)),),
    "two ambient": (AmbientLight((0.2, 0.1, 0.3), (0.3, 0.2, 0.1)), AmbientLight((0.1, 0.4, 0.1), (0.2, 0.1, 0.0))),
    "directional": (DirectionalLight((0.3, 0.4, 0.8), (0.9, 0.8, 0.7)),),
    "directional from behind": (DirectionalLight((0.3, 0.4, -0.8), (0.9, 0.8, 0.7)),),
    "point": (PointLight((0.4, 0.3, 0.7), (0.5, 0.4, 0.3)),),
    "all": (
        PointLight((0.4, 0.3, 0.7), (0.5, 0.4, 0.3)),
        AmbientLight((0.2, 0.1, 0.3), (0.3, 0.2, 0.1)),
        DirectionalLight((0.3, 0.4, 0.8), (0.4, 0.3, 0.2)),
        PointLight((-1.0, 0.0, 1.0), (0.2, 0.4, 0.3)),
        DirectionalLight((-0.3, 0.9, 0.1), (0.1, 0.3, 0.2)),
    ),
}


@pytest.mark.parametrize(("turn", "tilt"), [(0.0, 0.0), (40.0, 25.0), (180.0, -50.0)])
@pytest.mark.parametrize("lights", LIGHTS.values(), ids=LIGHTS)
def test_lights(lights, turn, tilt):
    """Also seen from the back: the normal is turned to the side that is seen."""
    frame = image(quad(Diffuse((0.8, 0.5, 0.3)), turn=turn, tilt=tilt), lights)
    around, down = np.radians(turn), np.radians(tilt)
    normal = (np.cos(down) * np.sin(around), -np.sin(down), np.cos(down) * np.cos(around))
    seen = frame.object_id == 1
    assert seen.sum() > 700
    expected = twin(frame, normal, lights, (0.8, 0.5, 0.3), np.array(CAMERA.position))
    assert frame.color[seen] == pytest.approx(expected[seen], rel=HALF, abs=HALF)


def test_vertex_colours_are_linear_and_blend_on_the_triangle():
    colors = np.array([[1, 0, 0], [0, 1, 0], [0.2, 0, 1], [1, 0.5, 0.1]], np.float32)
    camera = Camera((1.2, 0.3, 1.2), (0.0, 0.0, 0.0), field_of_view=40.0)
    frame = image(quad(Diffuse((0.9, 0.8, 1.0)), colors), (AmbientLight((1, 1, 1), (1, 1, 1)),), camera)
    seen = frame.object_id == 1
    points = frame.position[seen].astype(float)
    s, t = (points[:, :1] + 1.0) / 2.0, (points[:, 1:2] + 1.0) / 2.0
    # The diagonal runs from the lower left to the upper right corner.
    low = (1 - s) * colors[0] + (s - t) * colors[1] + t * colors[3]
    high = (1 - t) * colors[0] + s * colors[3] + (t - s) * colors[2]
    expected = np.where(s > t, low, high) * [0.9, 0.8, 1.0]
    assert frame.color[seen] == pytest.approx(expected, abs=HALF)


def test_textures_are_decoded_from_srgb_and_blended_in_linear_light():
    generator = np.random.default_rng(4)
    pixels = generator.integers(0, 256, (4, 4, 4), dtype=np.uint8)
    material = Diffuse((1.0, 1.0, 1.0), Texture(pixels))
    frame = image(quad(material), (AmbientLight((1, 1, 1), (1, 1, 1)),), replace(CAMERA, field_of_view=50.0))
    seen = frame.object_id == 1
    points = frame.position[seen].astype(float)
    # Bilinear between texel centres, repeating.
    linear = np.vectorize(decode)(pixels[..., :3].astype(float))
    x, y = (points[:, 0] + 1.0) / 2.0 * 4 - 0.5, (1.0 - points[:, 1]) / 2.0 * 4 - 0.5
    column, row = np.floor(x).astype(int), np.floor(y).astype(int)
    u, v = (x - column)[:, None], (y - row)[:, None]
    expected = (1 - v) * ((1 - u) * linear[row % 4, column % 4] + u * linear[row % 4, (column + 1) % 4])
    expected += v * ((1 - u) * linear[(row + 1) % 4, column % 4] + u * linear[(row + 1) % 4, (column + 1) % 4])
    assert frame.color[seen] == pytest.approx(expected, abs=8e-3)


@pytest.mark.parametrize("method", METHODS)
def test_two_textures_of_different_shapes_keep_apart(method):
    plain = [np.full(shape, 255, np.uint8) for shape in ((2, 8, 4), (16, 4, 4))]
    plain[0][..., :3], plain[1][..., :3] = (200, 30, 30), (30, 30, 200)
    left = quad(Diffuse((1, 1, 1), Texture(plain[0])))
    right = replace(quad(Diffuse((1, 1, 1), Texture(plain[1]))), positions=left.positions + np.float32([2, 0, 0]))
    bare = replace(quad(Diffuse((0.5, 0.4, 0.3))), positions=left.positions - np.float32([2, 0, 0]))
    camera = replace(CAMERA, field_of_view=80.0)
    scene = Scene("quads", (left, right, bare), camera, (AmbientLight((1, 1, 1), (1, 1, 1)),))
    frame = drawn(scene, method, SIZE)
    for number, color in [
        (1, [decode(c) for c in (200, 30, 30)]),
        (2, [decode(c) for c in (30, 30, 200)]),
        (3, [0.5, 0.4, 0.3]),
    ]:
        found = frame.color[frame.object_id == number]
        assert len(found) > 50
        assert found == pytest.approx(np.tile(color, (len(found), 1)), abs=3e-3)


def test_a_minified_chequerboard_tends_to_its_mean():
    board = checkerboard(64, 32, (255, 255, 255), (0, 0, 0))
    mesh = quad(Diffuse((1, 1, 1), board))
    ambient = (AmbientLight((1, 1, 1), (1, 1, 1)),)
    spreads = []
    for distance in (3.0, 12.0, 60.0):
        camera = Camera((0.0, 0.0, distance), (0.0, 0.0, 0.0), field_of_view=float(np.degrees(1.6 / distance)))
        size = (2 * int(60 / distance), 2 * int(60 / distance))
        frame = image(mesh, ambient, camera, size=size)
        assert (frame.object_id == 1).all()
        assert frame.color.mean() == pytest.approx(0.5, abs=0.03)
        spreads.append(frame.color.std())
    assert spreads[1] < 0.1 and spreads[2] < 0.02
    assert spreads[0] > spreads[1]


def test_a_slanted_texture_is_averaged_over_each_pixels_footprint():
    """Against the mean over 16 x 16 points in every pixel, where the footprint is long and narrow."""
    generator = np.random.default_rng(5)
    coarse = generator.integers(40, 216, (16, 16, 1), dtype=np.uint8).repeat(8, 0).repeat(8, 1)
    pixels = np.concatenate([np.repeat(coarse, 3, axis=2), np.full((128, 128, 1), 255, np.uint8)], axis=2)
    camera = Camera((0.0, -1.6, 0.35), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 30.0)
    scene = Scene("slant", (quad(Diffuse((1, 1, 1), Texture(pixels))),), camera, (AmbientLight((1, 1, 1), (1, 1, 1)),))
    size = (48, 36)
    session = open_view(scene, "pervertex", size)
    session.draw(camera)
    frame = session.frame(seen=True)
    # A reference without the sampler: sub-pixel rays to the plane z = 0, looked up in linear light.
    steps = (np.arange(16) + 0.5) / 16
    x = (np.arange(size[0])[:, None] + steps).ravel()
    y = (np.arange(size[1])[:, None] + steps).ravel()
    looks = camera.directions(np.stack(np.meshgrid(x, y), axis=-1), size)
    with np.errstate(divide="ignore", invalid="ignore"):
        points = camera.position + (-camera.position[2] / looks[..., 2:]) * looks
    column = np.floor((points[..., 0] + 1.0) / 2.0 * 128)
    row = np.floor((1.0 - points[..., 1]) / 2.0 * 128)
    on = (looks[..., 2] < 0) & (np.abs(points[..., 0]) < 1) & (np.abs(points[..., 1]) < 1)
    linear = decode_srgb(pixels[..., 0] / 255.0)
    values = linear[np.where(on, row, 0).astype(int) % 128, np.where(on, column, 0).astype(int) % 128]
    blocks = values.reshape(size[1], 16, size[0], 16).mean(axis=(1, 3))
    whole = on.reshape(size[1], 16, size[0], 16).all(axis=(1, 3))
    assert whole.sum() > 600
    error = np.abs(frame.color[..., 0] - blocks)[whole]
    assert np.sqrt(np.mean(error**2)) < 0.03
    assert np.abs(frame.color[..., 0][whole].mean() - blocks[whole].mean()) < 0.01


@pytest.mark.parametrize("shape", [(1, 1), (8, 8), (4, 16), (5, 3), (1, 7)])
def test_mip_levels_halve_in_linear_light(shape):
    pixels = np.random.default_rng(6).integers(0, 256, (*shape, 4), dtype=np.uint8)
    levels = mip_levels(pixels)
    assert (levels[0] == pixels).all()
    assert len(levels) == max(shape).bit_length()
    for level, image in enumerate(levels):
        assert image.shape == (max(shape[0] >> level, 1), max(shape[1] >> level, 1), 4)
    if shape == (8, 8):
        mean = decode_srgb(pixels / 255.0).mean(axis=(0, 1))
        assert decode_srgb(levels[-1][0, 0] / 255.0) == pytest.approx(mean, abs=0.01)
        first = decode_srgb(pixels[:2, :2] / 255.0).mean(axis=(0, 1))
        assert levels[1][0, 0] == pytest.approx(encode_srgb(first) * 255.0, abs=0.6)


def test_srgb_curves_undo_each_other_and_are_the_standards():
    values = np.linspace(0.0, 1.0, 1001)
    assert encode_srgb(decode_srgb(values)) == pytest.approx(values, abs=1e-6)
    assert decode_srgb(np.array([0.0, 0.04045, 0.5, 1.0])) == pytest.approx([0.0, 0.0031308, 0.2140411, 1.0], abs=1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_the_skys_gradient(method):
    sky = Sky(zenith=(0.1, 0.2, 0.9), horizon=(0.8, 0.7, 0.6), nadir=(0.3, 0.2, 0.1))
    away = replace(quad(), positions=quad().positions + np.float32([0, 0, 50]))
    for target in [(0.0, 0.4, -1.0), (0.3, 1.0, -0.1), (0.0, -1.0, -0.4)]:
        camera = Camera((0.0, 0.0, 0.0), target, (0.0, 0.0, -1.0), 70.0)
        frame = image(away, (), camera, sky, method=method)
        assert (frame.object_id == 0).all()
        height = frame.position[..., 1:2].astype(float)
        assert frame.position == pytest.approx(
            camera.directions(np.stack(np.meshgrid(np.arange(64), np.arange(48)), axis=-1) + 0.5, SIZE), abs=1e-5
        )
        ends = np.where(height > 0, sky.zenith, sky.nadir)
        share = np.sqrt(np.abs(height))
        assert frame.color == pytest.approx((1 - share) * sky.horizon + share * ends, abs=4e-3)


def test_the_skys_image_has_its_centre_at_minus_z_and_its_top_up():
    """Each texel of a small image is looked at, through its centre."""
    generator = np.random.default_rng(7)
    pixels = generator.integers(0, 256, (8, 16, 4), dtype=np.uint8)
    away = replace(quad(), positions=quad().positions * np.float32(1e-3) + np.float32([50, 50, 50]))
    for row, column in [(0, 0), (3, 8), (4, 7), (4, 12), (2, 3), (7, 15), (5, 0)]:
        longitude, latitude = ((column + 0.5) / 16 - 0.5) * 2 * np.pi, (0.5 - (row + 0.5) / 8) * np.pi
        look = np.cos(latitude) * np.array([np.sin(longitude), 0, -np.cos(longitude)]) + [0, np.sin(latitude), 0]
        camera = Camera((0, 0, 0), tuple(look.tolist()), (0.3, 0.9, 0.1), 1.0)
        frame = image(away, (), camera, Sky(image=Texture(pixels)), size=(3, 3))
        assert frame.color[1, 1] == pytest.approx([decode(c) for c in pixels[row, column, :3]], abs=6e-3)


@pytest.mark.parametrize(
    "method",
    [
        "pervertex",
        "pervertex:map=image,bounces=1",
        "pervertex:map=image,bounces=1,antialias=4",
        "environment",
        "raytrace",
    ],
)
def test_an_image_of_one_colour_is_the_sky_of_that_colour(method):
    """Directly, in mirrors, and where a mirror has nothing else to show: two drawings, one of which knows no image."""
    color = tuple(decode(value) for value in (30, 120, 210))
    pixels = np.broadcast_to(np.uint8([30, 120, 210, 255]), (8, 16, 4))
    scene = replace(make("spheres"), meshes=make("spheres").meshes[:4])
    plain = drawn(replace(scene, sky=Sky(color, color, color)), method, SIZE).color
    assert drawn(replace(scene, sky=Sky(image=Texture(pixels))), method, SIZE).color == pytest.approx(plain, abs=HALF)


def test_all_lights_that_a_scene_may_have_shine_and_one_more_is_refused():
    dark = [DirectionalLight((0.0, 0.0, 1.0), (0.0, 0.0, 0.0))] * (MOST_LIGHTS - 1)
    bright = DirectionalLight((0.0, 0.0, 1.0), (0.5, 0.25, 0.125))
    white = quad(Diffuse((1.0, 1.0, 1.0)))
    assert image(white, (*dark, bright)).color[24, 32] == pytest.approx(bright.color, abs=HALF)
    with pytest.raises(AnamorphError, match="1025 lights, and 1024 are the most"):
        image(white, (*dark, bright, bright))
    # Some drivers read on beyond a uniform's end, so that an image does not tell.
    assert f"array<Light, {MOST_LIGHTS}>" in (resources.files("anamorph") / "gpu/shading.wgsl").read_text()


def test_a_light_that_touches_a_surface_leaves_finite_colours():
    """Also where it stands exactly at the point that a pixel sees."""
    point = image(quad(), ()).position[24, 32].astype(float)
    for height in (0.0, 1e-5, 1e-2):
        light = PointLight((float(point[0]), float(point[1]), float(point[2]) + height), (10.0, 10.0, 10.0))
        assert np.isfinite(image(quad(), (light,)).color).all()


def test_a_light_beyond_half_floats_is_as_bright_as_they_can_be():
    """Drawn in full floats: what a driver makes of numbers that half floats cannot hold is its own affair."""
    light = DirectionalLight((0.0, 0.0, 1.0), (1e9, 1e9, 1.0))
    stage = Stage(View(Scene("quad", (quad(),), CAMERA, (light,)), CAMERA, SIZE))
    stage.projection.write(camera_projection(CAMERA, SIZE), SIZE)
    target = make_target(SIZE, ("rgba32float",))
    encoder = get_device().create_command_encoder()
    render_pass = begin_pass(encoder, target)
    render_pass.set_bind_group(0, stage.buffers.shading)
    render_pass.set_bind_group(1, stage.projection.group)
    render_pass.set_pipeline(
        make_pipeline(shader_module("gpu/scene.wgsl"), "scene_vertex", "scene_color", ("rgba32float",))
    )
    draw_mesh(render_pass, stage.buffers, 0)
    render_pass.end()
    submit(encoder)
    assert read_texture(target.textures[0])[..., :3].max() == np.finfo(np.float16).max


@pytest.mark.parametrize("shape", [(1, 1), (4, 1), (1, 4)])
def test_an_image_of_a_texel_is_an_image(shape):
    away = replace(quad(), positions=quad().positions * np.float32(1e-3) + np.float32([50, 50, 50]))
    pixels = np.broadcast_to(np.uint8([255, 0, 0, 255]), (*shape, 4))
    frame = image(away, (), CAMERA, Sky(image=Texture(pixels)), size=(3, 3))
    assert frame.color == pytest.approx(np.broadcast_to([1.0, 0.0, 0.0], (3, 3, 3)), abs=HALF)
