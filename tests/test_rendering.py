"""`anamorph.render`, as someone who has read the README would call it."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image
from scenes import CAMERA, SIZE, flat_mirror, scene_with, spherical_mirror, surroundings

import anamorph as an

SCENE = scene_with(spherical_mirror())


def same(one, other):
    return all(
        (getattr(one, name) is None and getattr(other, name) is None)
        or np.all(getattr(one, name) == getattr(other, name))
        for name in vars(one)
    )


def test_every_public_name_is_there():
    for name in an.__all__:
        assert getattr(an, name) is not None
    assert sorted(an.__all__) == an.__all__ == dir(an)
    assert len(set(an.__all__)) == len(an.__all__)
    with pytest.raises(AttributeError, match="nothing"):
        _ = an.nothing


def test_by_name_and_saved(tmp_path):
    frame = an.render("flat-mirror", method="pervertex", size=SIZE)
    frame.save(tmp_path / "mirror.png")
    image = np.asarray(Image.open(tmp_path / "mirror.png").convert("RGB"))
    assert image.shape == (SIZE[1], SIZE[0], 3)
    linear = np.clip(frame.color, 0.0, 1.0)
    encoded = np.where(linear <= 0.0031308, linear * 12.92, 1.055 * linear ** (1 / 2.4) - 0.055) * 255.0
    assert image == pytest.approx(encoded, abs=0.51)
    assert frame.position is None


def test_the_default_method_is_auto_and_the_default_size_1024_by_768():
    scene = scene_with(flat_mirror())
    frame = an.render(scene, seen=True)
    assert frame.color.shape == (768, 1024, 3)
    assert same(frame, an.render(scene, method="auto", seen=True))
    assert an.Status.DOUBTFUL not in frame.status


def test_a_scene_and_a_camera():
    camera = an.Camera((-0.3, 0.6, 0.9), (0.0, 0.5, 0.0), field_of_view=35.0)
    frame = an.render(SCENE, camera=camera, size=SIZE, seen=True)
    moved = an.Scene(SCENE.name, SCENE.meshes, camera, SCENE.lights, SCENE.sky)
    assert same(frame, an.render(moved, size=SIZE, seen=True))
    assert not same(frame, an.render(SCENE, size=SIZE, seen=True))


def test_a_camera_for_a_named_scene():
    camera = an.Camera((1.0, 1.3, 2.2), (0.0, 0.7, 0.0))
    frame = an.render("flat-mirror", camera=camera, size=SIZE)
    assert not (frame.color == an.render("flat-mirror", size=SIZE).color).all()


def test_a_scene_made_of_arrays_by_hand():
    floor = an.Mesh(
        name="floor",
        positions=np.array([[-5, 0, 5], [5, 0, 5], [5, 0, -5], [-5, 0, -5]], np.float32),
        faces=np.array([[0, 1, 2], [0, 2, 3]], np.int32),
        normals=np.tile(np.float32([0, 1, 0]), (4, 1)),
        material=an.Diffuse((0.2, 0.5, 0.1)),
    )
    # Two triangles tilted forward show the floor; float64, lists and wide integers are taken too.
    mirror = an.Mesh(
        name="mirror",
        positions=np.array([[-0.5, 0.5, 0.0], [0.5, 0.5, 0.0], [0.5, 1.4, 0.5], [-0.5, 1.4, 0.5]]),
        faces=np.array([[0, 1, 2], [0, 2, 3]]),
        normals=np.tile(np.array([0.0, -0.5, 0.9]) / np.hypot(0.5, 0.9), (4, 1)),
        material=an.Mirror(tint=(1.0, 0.5, 1.0), reflectance=1.0),
    )
    scene = an.Scene(
        name="by hand",
        meshes=(floor, mirror),
        camera=an.Camera((0.0, 1.0, 3.0), (0.0, 0.9, 0.0)),
        lights=(an.AmbientLight((1.0, 1.0, 1.0), (1.0, 1.0, 1.0)),),
    )
    for method in an.METHODS:
        frame = an.render(scene, method, size=SIZE, seen=True)
        looks = (frame.specular == 2) & (frame.object_id == 1)
        assert looks.sum() > 300
        assert np.median(frame.color[looks], axis=0) == pytest.approx([0.2, 0.25, 0.1], abs=2e-3)
        assert np.abs(frame.position[looks][:, 1]).max() < 1e-3


def test_options_in_text_and_as_keywords():
    text = an.render(SCENE, "environment:face=64,update=once", size=SIZE)
    words = an.render(SCENE, "environment", size=SIZE, face=64, update="once")
    both = an.render(SCENE, "environment:face=64", size=SIZE, update="once")
    assert same(text, words) and same(text, both)
    assert not same(text, an.render(SCENE, "environment:face=16", size=SIZE))
    # A keyword wins over the text.
    assert same(text, an.render(SCENE, "environment:face=16", size=SIZE, face=64))


def test_samples_are_averaged_and_the_seen_buffers_stay():
    one, three = (an.render(SCENE, "pervertex", size=SIZE, samples=samples, seen=True) for samples in (1, 3))
    assert (one.object_id == three.object_id).all() and (one.position == three.position).all()
    edges = np.abs(one.color - three.color).max(axis=-1) > 0.05
    assert 50 < edges.sum() < 0.3 * edges.size


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"scene": "no-such-scene"}, "no-such-scene"),
        ({"method": "magic"}, "magic"),
        ({"method": "pervertex", "shine": 3}, "shine"),
        ({"method": "pervertex", "antialias": 3}, "antialias"),
        ({"size": (0, 100)}, "0x100"),
        ({"size": (10**6, 100)}, "1000000x100"),
        ({"size": (64.0, 48.0)}, "two whole numbers of pixels"),
        ({"size": (64, 48, 3)}, "two whole numbers of pixels"),
        ({"size": ("64", "48")}, "two whole numbers of pixels"),
        ({"size": 64}, "two whole numbers of pixels"),
        ({"size": (64, (48, 2))}, "two whole numbers of pixels"),
        ({"samples": 1.5}, "samples is 1.5; give a whole number"),
        ({"samples": 0}, "samples"),
        ({"samples": 1000}, "samples"),
        ({"camera": an.Camera((0, 0.5, -1), (0, 0.5, 0))}, "behind"),
        ({"camera": an.Camera((0, 0.5, 1), (0, 0.5, 1))}, "same point"),
        ({"scene": an.Scene("empty", (), CAMERA)}, "no meshes"),
    ],
)
def test_what_a_user_can_mend_is_one_line(arguments, said):
    with pytest.raises(an.AnamorphError, match=said) as caught:
        an.render(**({"scene": SCENE, "size": SIZE} | arguments))
    assert "\n" not in str(caught.value)


def test_a_scene_without_mirrors_is_a_scene():
    frame = an.render(an.Scene("diffuse", surroundings(), CAMERA), size=SIZE, seen=True)
    assert (frame.specular == 0).all() and frame.color.max() > 0.1
