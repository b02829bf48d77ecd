"""A scene that leaves as glTF: what is read back, here and by others, is what was written."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh

from anamorph.base.errors import AnamorphError
from anamorph.files.gltf.exporting import save_gltf
from anamorph.files.models import load_model
from anamorph.gallery import make
from anamorph.gallery.solids import grid
from anamorph.scene.camera import Camera
from anamorph.scene.model import (
    AmbientLight,
    Diffuse,
    DirectionalLight,
    Glass,
    Material,
    Mesh,
    Mirror,
    PointLight,
    Scene,
    Texture,
)

CAMERA = Camera((1.0, 2.0, 3.0), (4.0, 2.5, -3.0), field_of_view=35.0)


def header(path: Path) -> dict:
    data = path.read_bytes()
    (length,) = struct.unpack("<I", data[12:16])
    assert len(data) == struct.unpack("<I", data[8:12])[0] and len(data) % 4 == 0
    return json.loads(data[20 : 20 + length])


def pane(material: Material, name: str = "pane", at: float = 0.0) -> Mesh:
    return grid((at, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)).mesh(name, material)


def returned(folder: Path, *meshes: Mesh) -> tuple[Mesh, ...]:
    save_gltf(folder / "s.glb", Scene("s", meshes, CAMERA))
    return load_model(folder / "s.glb")


@pytest.mark.parametrize("name", ["car-mirror", "spectacles-plus", "facing-mirrors"])
def test_a_built_in_scene_comes_back_part_by_part(tmp_path: Path, name: str) -> None:
    scene = make(name)
    save_gltf(tmp_path / "s.glb", scene)
    meshes = load_model(tmp_path / "s.glb")
    assert [mesh.name for mesh in meshes] == [mesh.name for mesh in scene.meshes]
    for mesh, own in zip(meshes, scene.meshes, strict=True):
        assert type(mesh.material) is type(own.material)
        scale = float(np.ptp(own.positions, axis=0).max())
        assert corner_points(mesh) == pytest.approx(corner_points(own), abs=1e-6 * scale)
        for mine, its in ((mesh.normals, own.normals), (mesh.colors, own.colors), (mesh.texcoords, own.texcoords)):
            assert (mine is None) == (its is None)
        assert mesh.normals[mesh.faces] == pytest.approx(own.normals[own.faces], abs=1e-5)


def corner_points(mesh: Mesh) -> np.ndarray:
    return np.asarray(mesh.positions, float)[mesh.faces]


@pytest.mark.parametrize(
    "material",
    [
        Mirror((1.0, 0.5, 0.25), 0.8),
        Glass(1.74, (0.9, 1.0, 0.8), 33.0),
        Glass(1.5),
        Diffuse((0.25, 0.5, 1.0)),
    ],
)
def test_materials_come_back(tmp_path: Path, material: Material) -> None:
    (mesh,) = returned(tmp_path, pane(material))
    for name, value in vars(material).items():
        assert getattr(mesh.material, name) == (value if value is None else pytest.approx(value))


def test_images_come_back_with_what_lies_beyond_their_edges(tmp_path: Path) -> None:
    pixels = np.random.default_rng(2).integers(0, 256, (3, 5, 4), dtype=np.uint8)
    pixels[..., 3] = 255
    shared = Diffuse((1.0, 1.0, 1.0), Texture(pixels, ("mirror", "clamp")))
    own = [pane(shared, "one"), pane(shared, "two", 2.0)]
    texcoords = np.array([[0.0, 1.0], [1.0, 1.0], [0.0, 0.0], [1.0, 0.0]], np.float32)
    meshes = returned(tmp_path, *(Mesh(**{**vars(mesh), "texcoords": texcoords}) for mesh in own))
    for mesh in meshes:
        assert isinstance(mesh.material, Diffuse) and mesh.material.texture is not None
        assert np.array_equal(mesh.material.texture.pixels, pixels)
        assert mesh.material.texture.wraps == ("mirror", "clamp")
    assert len(header(tmp_path / "s.glb")["images"]) == 1


def test_what_float32_would_blur_is_written_about_its_middle(tmp_path: Path) -> None:
    far = pane(Diffuse())
    far = Mesh(**{**vars(far), "positions": far.positions + np.array([4.5e5 + 1e-4, 0.0, 6.2e6])})
    (mesh,) = returned(tmp_path, far)
    assert mesh.positions == pytest.approx(far.positions, abs=1e-8)


def test_another_programs_reader_finds_the_same_shapes_in_the_same_places(tmp_path: Path) -> None:
    scene = make("spheres")
    save_gltf(tmp_path / "s.glb", scene)
    theirs = trimesh.load_scene(tmp_path / "s.glb", process=False)
    mine = np.concatenate([np.asarray(mesh.positions, float) for mesh in scene.meshes])
    assert theirs.bounds == pytest.approx(np.stack([mine.min(axis=0), mine.max(axis=0)]), abs=1e-5)
    assert sum(len(mesh.faces) for mesh in theirs.geometry.values()) == sum(len(mesh.faces) for mesh in scene.meshes)


def test_camera_and_lights_stand_and_look_as_they_do_here(tmp_path: Path) -> None:
    lights = (
        AmbientLight(),
        DirectionalLight((0.6, 0.8, 0.0), (0.5, 1.0, 2.0)),
        PointLight((1.0, 2.0, 3.0), (3.0, 1.5, 0.0)),
    )
    save_gltf(tmp_path / "s.glb", Scene("s", (pane(Diffuse()),), CAMERA, lights))
    content = header(tmp_path / "s.glb")
    _, sun, lamp, eye = content["nodes"]
    directional, point = content["extensions"]["KHR_lights_punctual"]["lights"]
    assert directional["type"] == "directional" and point["type"] == "point"
    assert np.array(directional["color"]) * directional["intensity"] == pytest.approx(np.pi * np.array([0.5, 1.0, 2.0]))
    assert np.array(point["color"]) * point["intensity"] == pytest.approx(np.pi * np.array([3.0, 1.5, 0.0]))
    # Both shine and look along -z, the third column.
    assert np.array(sun["matrix"]).reshape(4, 4)[2, :3] == pytest.approx([0.6, 0.8, 0.0])
    assert lamp["translation"] == [1.0, 2.0, 3.0]
    matrix = np.array(eye["matrix"]).reshape(4, 4).T
    right, up, forward = CAMERA.axes()
    assert matrix[:3, :3] == pytest.approx(np.stack([right, up, -forward], axis=1))
    assert matrix[:3, 3] == pytest.approx(CAMERA.position)
    assert np.linalg.det(matrix[:3, :3]) == pytest.approx(1.0)
    assert content["cameras"][0]["perspective"]["yfov"] == pytest.approx(np.radians(35.0))


def test_another_suffix_is_refused(tmp_path: Path) -> None:
    with pytest.raises(AnamorphError, match=r"s\.gltf: cannot write '\.gltf' files; end the name in \.glb"):
        save_gltf(tmp_path / "s.gltf", make("flat-mirror"))
