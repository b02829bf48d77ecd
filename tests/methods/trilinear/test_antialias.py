"""Four samples a pixel by `trilinear`: the mean of four images where colours are flat, and no fringes at outlines."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import SIZE, drawn, flat_mirror, scene_with, spherical_mirror

from anamorph import cameras
from anamorph.frame import View
from anamorph.gallery import make
from anamorph.measure.errors import silhouettes
from anamorph.methods import Specification
from anamorph.raymesh import RayMesh
from anamorph.rendering import draw_frame
from anamorph.scene.camera import Camera
from anamorph.scene.model import AmbientLight, Diffuse, Mesh, Scene, Sky

FLAT_LIGHT = (AmbientLight(sky=(1.0, 1.0, 1.0), ground=(1.0, 1.0, 1.0)),)
PLAIN_SKY = Sky(zenith=(0.3, 0.4, 0.6), horizon=(0.3, 0.4, 0.6), nadir=(0.3, 0.4, 0.6))


def flat_scene(seed: int = 3, count: int = 25) -> Scene:
    """Triangles of one colour each, whatever the light, before a sky of one colour."""
    random = np.random.default_rng(seed)
    meshes = []
    for number in range(count):
        middle = random.uniform([-1.6, -1.2, -1.5], [1.6, 1.2, 1.5])
        corners = (middle + 0.6 * random.normal(size=(3, 3))).astype(np.float32)
        normals = np.tile(np.float32([0.0, 0.0, 1.0]), (3, 1))
        color = tuple(random.uniform(0.05, 0.95, 3).tolist())
        faces = np.array([[0, 1, 2]], np.int32)
        meshes.append(Mesh(f"triangle-{number}", corners, faces, normals, Diffuse(color=color)))
    camera = Camera((0.0, 0.0, 5.0), (0.0, 0.0, 0.0), field_of_view=40.0)
    return Scene("flat", tuple(meshes), camera, FLAT_LIGHT, sky=PLAIN_SKY)


def color(scene: Scene, camera: Camera | RayMesh, method: str, shift=(0.0, 0.0), size=SIZE) -> np.ndarray:
    session = Specification.parse(method).open(View(scene, camera, size))
    session.draw(camera, shift)
    return session.frame().color


def four(scene: Scene, camera: Camera | RayMesh, method: str, size=SIZE) -> np.ndarray:
    """The mean of four shifted images."""
    view = View(scene, camera, size, samples=2)
    return draw_frame(view, Specification.parse(method)).color


RAYS = {
    "pinhole": lambda size: cameras.pinhole(CAMERA, size),
    "orthographic": lambda size: cameras.orthographic(CAMERA, size),
    "6.4": lambda size: cameras.detail_and_context(CAMERA, size),
}
CAMERA = Camera((0.0, 0.0, 5.0), (0.0, 0.0, 0.0), field_of_view=40.0)


@pytest.mark.parametrize("name", RAYS)
def test_flat_colors_are_the_mean_of_four_samples(name):
    scene, camera = flat_scene(), RAYS[name](SIZE)
    one, smooth = (color(scene, camera, method) for method in ("trilinear", "trilinear:antialias=4"))
    for method in ("trilinear", "raytrace"):
        mean = four(scene, camera, method)
        assert np.abs(mean - one).max() > 0.1
        wrong = np.abs(smooth - mean).max(axis=-1)
        # Half floats; and of pixels on the rim some samples have no rays where the mesh ends with the image.
        assert (wrong <= 2e-3).mean() > 0.999 and np.median(wrong) <= 1e-3


@pytest.mark.parametrize("shift", [(0.375, -0.375), (-0.45, 0.2), (0.49, 0.49)])
def test_a_shifted_image_is_smooth_up_to_its_rim(shift):
    """Its frame is not drawn: black would come in from where the shifted ray mesh has ended."""
    (triangle, *_) = flat_scene().meshes
    middle = replace(triangle, positions=np.float32([[-0.5, -0.6, 0.0], [0.7, -0.3, 0.0], [0.1, 0.6, 0.0]]))
    scene, camera = replace(flat_scene(), meshes=(middle,)), RAYS["pinhole"](SIZE)
    plain, smooth = (color(scene, camera, method, shift) for method in ("trilinear", "trilinear:antialias=4"))
    rim = np.ones(SIZE[::-1], bool)
    rim[1:-1, 1:-1] = False
    assert (np.abs(plain - smooth)[rim].max(axis=-1) <= 1e-3).all()
    assert np.abs(smooth.astype(float) - plain).max() > 0.05


def test_the_average_of_smooth_images_comes_close_to_that_of_many():
    scene, camera = flat_scene(), RAYS["6.4"](SIZE)
    view = View(scene, camera, SIZE, samples=6)
    reference = draw_frame(view, Specification.parse("raytrace")).color
    errors = [np.abs(color(scene, camera, "trilinear:antialias=4") - reference).mean()]
    errors.append(np.abs(four(scene, camera, "trilinear:antialias=4") - reference).mean())
    assert errors[1] < 1.3 * errors[0] < 0.6 * np.abs(color(scene, camera, "trilinear") - reference).mean()


def test_a_ray_mesh_that_ends_within_the_image_ends_smoothly_and_not_darker():
    scene = replace(flat_scene(), meshes=flat_scene().meshes[:1])
    camera = RAYS["pinhole"](SIZE)
    small = replace(camera, image=camera.image * [0.6, 0.6, 1.0] + camera.image[:, 2:] * [20.5, 15.5, 0.0])
    smooth = color(scene, small, "trilinear:antialias=4")
    levels = np.unique(np.round(smooth[15] @ [1.0, 1.0, 1.0] / np.sum(PLAIN_SKY.zenith), 2))
    assert set(levels) <= {0.0, 0.25, 0.5, 0.75, 1.0} and 1.0 > levels[1] > 0.0


@pytest.mark.parametrize("mirror", [flat_mirror(), spherical_mirror()], ids=["flat", "sphere"])
@pytest.mark.parametrize("shift", [(0.0, 0.0), (0.31, -0.22)])
def test_outlines_of_mirrors_lie_between_what_is_on_either_side(mirror, shift):
    """No fringe: a pixel of an outline is no darker and no brighter than all that its neighbours show."""
    scene = scene_with(mirror)
    smooth, plain = (color(scene, scene.camera, f"trilinear:antialias={n}", shift) for n in (4, 1))
    specular = drawn(scene, "trilinear").specular
    outline = np.zeros(SIZE[::-1], bool)
    for axis in (0, 1):
        for step in (-1, 1):
            outline |= np.roll(specular, step, axis=axis) != specular
    around = np.pad(plain, ((2, 2), (2, 2), (0, 0)), mode="edge")
    shifted = [around[y : y + SIZE[1], x : x + SIZE[0]] for y in range(5) for x in range(5)]
    low, high = np.min(shifted, axis=0), np.max(shifted, axis=0)
    beyond = np.maximum(low - smooth, smooth - high).max(axis=-1)
    assert outline.sum() > 100
    assert np.percentile(beyond[outline], 99) <= 0.02 and beyond[outline].max() <= 0.1
    away = ~outline
    assert np.abs(smooth - plain)[away].mean() <= 0.01


def test_mirrors_are_as_smooth_as_four_images():
    scene = replace(scene_with(spherical_mirror(), sky=PLAIN_SKY), lights=FLAT_LIGHT)
    scene = replace(
        scene,
        meshes=tuple(
            replace(mesh, material=Diffuse(color=(0.5, 0.3, 0.2))) if mesh.name == "floor" else mesh
            for mesh in scene.meshes
        ),
    )
    mean = four(scene, scene.camera, "trilinear")
    one, smooth = (color(scene, scene.camera, f"trilinear:antialias={n}") for n in (1, 4))
    inside = drawn(scene, "trilinear").specular > 0
    inside[1:-1, 1:-1] &= inside[:-2, 1:-1] & inside[2:, 1:-1] & inside[1:-1, :-2] & inside[1:-1, 2:]
    wrong = np.abs(smooth - mean)[inside].max(axis=-1)
    assert np.abs(one - mean)[inside].max() > 0.1
    assert (wrong <= 5e-3).mean() > 0.99 and wrong.max() <= 0.12


def test_every_color_is_smooth_through_glass_that_disperses():
    scene, size = make("magnifier"), (120, 90)
    mean = four(scene, scene.camera, "trilinear", size)
    one, smooth = (color(scene, scene.camera, f"trilinear:antialias={n}", size=size) for n in (1, 4))
    specular = drawn(scene, "trilinear", size).specular
    counted = (specular > 0) & ~silhouettes(specular)
    wrong, before = (np.abs(each - mean)[counted].mean(axis=0) for each in (smooth, one))
    assert counted.sum() > 1000
    assert (wrong < 0.4 * before).all()


def test_what_is_seen_of_a_pixel_is_seen_from_its_middle():
    scene = scene_with(spherical_mirror())
    one, smooth = (drawn(scene, f"trilinear:antialias={n}") for n in (1, 4))
    assert np.abs(one.color - smooth.color).max() > 0.1
    for name in ("position", "object_id", "specular", "status", "ray_origin", "ray_direction"):
        assert (getattr(one, name) == getattr(smooth, name)).all()
