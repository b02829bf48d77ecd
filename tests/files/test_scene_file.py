"""Scene files: the documented example loads, and every mistake is named by file, line and key."""

from __future__ import annotations

import re
import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from anamorph import gallery
from anamorph.base.errors import AnamorphError
from anamorph.files.key_lines import key_lines
from anamorph.files.model_scene import stand_before_mirror
from anamorph.files.models import load_model
from anamorph.files.opening import open_scene
from anamorph.files.scene_file import Settings
from anamorph.frame import View
from anamorph.measure.status import gaps
from anamorph.methods import Specification
from anamorph.rendering import draw_frame
from anamorph.scene.model import AmbientLight, Diffuse, DirectionalLight, Glass, Mirror, PointLight
from anamorph.surfaces.bezier import BezierPatch
from anamorph.surfaces.plane import Plane
from anamorph.surfaces.similarity import Similarity, rotation
from anamorph.surfaces.sphere import Sphere

DOCUMENT = Path(__file__).resolve().parents[2] / "docs" / "scene-file.md"
EYE = "[eye]\nposition = [0.3, 0.2, 5]\ntarget = [0, 0, 0]\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A cabinet in millimetres with z up, whose door (y = -20 mm, 1.4 to 1.7 m up) is to be a mirror; and towels."""
    (tmp_path / "cabinet.obj").write_text(
        "o door\nv -200 -20 1400\nv 200 -20 1400\nv 200 -20 1700\nv -200 -20 1700\nf 1 2 3 4\n"
        "o wall\nv -900 0 0\nv 900 0 0\nv 900 0 2000\nv -900 0 2000\nf 5 6 7 8\n"
    )
    box = trimesh.creation.box((0.2, 0.4, 0.1))
    box.visual = trimesh.visual.TextureVisuals(
        material=trimesh.visual.material.PBRMaterial(name="Plastic_1", baseColorFactor=[1.0, 0.0, 0.0, 1.0])
    )
    trimesh.Scene({"towel": box}).export(tmp_path / "towels.glb")
    return tmp_path


def write(folder: Path, text: str) -> Path:
    path = folder / "scene.toml"
    path.write_text(text)
    return path


def complaint(path: Path) -> str:
    with pytest.raises(AnamorphError) as caught:
        open_scene(path)
    message = str(caught.value)
    assert message.startswith(str(path)) and "\n" not in message
    return message


def test_the_documented_example_loads(folder: Path) -> None:
    example = re.search(r"```toml\n(.*?)```", DOCUMENT.read_text(), re.DOTALL)
    assert example
    scene, settings = open_scene(write(folder, example[1]))
    assert (scene.name, settings) == ("bathroom", Settings((800, 600), "pervertex"))
    parts = {mesh.name: mesh for mesh in scene.meshes}
    assert list(parts) == ["door", "wall", "towel"]
    assert isinstance(parts["door"].material, Mirror) and parts["door"].material.reflectance == 0.88
    assert isinstance(parts["towel"].material, Diffuse) and parts["towel"].material.color == (0.2, 0.3, 0.6)
    # Millimetres became metres, z became y, and the door's front (-y in the file) faces +z.
    assert np.allclose(parts["door"].positions.min(axis=0), [-0.2, 1.4, 0.02], atol=1e-6)
    assert np.allclose(parts["door"].positions.max(axis=0), [0.2, 1.7, 0.02], atol=1e-6)
    assert np.allclose(parts["door"].normals, [0, 0, 1], atol=1e-6)
    assert np.allclose(parts["towel"].positions.mean(axis=0), [0.3, 0.9, 1.2], atol=1e-6)
    assert scene.camera.position == (0.4, 1.6, 1.8) and scene.camera.field_of_view == 45.0
    assert isinstance(scene.lights[0], PointLight) and isinstance(scene.lights[1], AmbientLight)
    assert scene.sky.nadir == (0.3, 0.3, 0.3)


@pytest.mark.parametrize("name", gallery.names())
def test_every_built_in_scene_is_fit_to_be_drawn(name: str) -> None:
    scene, settings = open_scene(name)
    assert scene.name == name and settings == Settings()
    Specification.parse(settings.method)


def test_the_tunnel_is_drawn_by_a_method_that_follows_it_to_its_end() -> None:
    scene, settings = open_scene("facing-mirrors")
    assert (
        gaps(draw_frame(View(scene, scene.camera, (96, 64)), Specification.parse(settings.method), seen=True), scene)[1]
        == 0.0
    )


def test_a_built_in_scene_can_be_changed(tmp_path: Path) -> None:
    base = gallery.make("spheres")
    mirror = next(mesh for mesh in base.meshes if isinstance(mesh.material, Mirror))
    text = (
        'builtin = "spheres"\n[eye]\nfield_of_view = 50\n[[light]]\nkind = "directional"\ntoward = [0, 3, 4]\n'
        f'[[part]]\nname = "{mirror.name}"\nglass = {{ index = 1.4 }}\nrename = "lens"\ntranslate = [0, 0.5, 0]\n'
    )
    scene, _ = open_scene(write(tmp_path, text))
    assert len(scene.meshes) == len(base.meshes)
    assert scene.camera.position == base.camera.position and scene.camera.field_of_view == 50.0
    light = scene.lights[0]
    assert len(scene.lights) == 1 and isinstance(light, DirectionalLight) and np.allclose(light.toward, (0, 0.6, 0.8))
    lens = next(mesh for mesh in scene.meshes if mesh.name == "lens")
    assert isinstance(lens.material, Glass) and lens.material.index == 1.4
    assert np.allclose(lens.positions - mirror.positions, [0, 0.5, 0], atol=1e-6)
    assert lens.surface is not None and lens.parameters is not None
    assert np.allclose(lens.surface.position(lens.parameters), lens.positions, atol=1e-5)


def test_parts_are_turned_moved_and_bent_where_they_stand(folder: Path) -> None:
    text = EYE + "[[model]]\nfile = 'cabinet.obj'\nscale = 0.001\nrotate = [-90, 0, 0]\n"
    text += "[[part]]\nname = '*'\nturn = [90, 0, 0]\nmove = [0, 0, 0.5]\n"
    scene, _ = open_scene(write(folder, text))
    # Both face +z: each turns about its own middle to face +x, and moves along what was its normal.
    for mesh, middle in zip(scene.meshes, ([0.0, 1.55, 0.52], [0.0, 1.0, 0.5]), strict=True):
        np.testing.assert_allclose(mesh.normals, [[1.0, 0.0, 0.0]] * 4, atol=1e-6)
        np.testing.assert_allclose(mesh.positions.mean(axis=0), middle, atol=1e-6)
    text = "builtin = 'flat-mirror'\n[[part]]\nname = 'mirror'\ncurvature = -0.25\nreflectance = 0.5\n"
    mirror = next(mesh for mesh in open_scene(write(folder, text))[0].meshes if mesh.specular)
    assert isinstance(mirror.surface, Sphere) and mirror.surface.radius == pytest.approx(4.0)
    assert isinstance(mirror.material, Mirror) and mirror.material.reflectance == 0.5


def test_a_lens_is_one_part_under_the_name_its_faces_share(folder: Path) -> None:
    text = "builtin = 'spectacles-plus'\n[[part]]\nname = 'lens'\npower = 4\nindex = 1.5\nmove = [0, 0, 0.01]\n"
    before, (after, _) = gallery.make("spectacles-plus"), open_scene(write(folder, text))
    for old, new in zip(before.meshes, after.meshes, strict=True):
        assert (not np.array_equal(old.positions, new.positions)) == old.name.startswith("lens/")
        assert not isinstance(new.material, Glass) or new.material.index == 1.5


def test_parts_can_be_removed_and_get_names_of_their_own(folder: Path) -> None:
    model = '[[model]]\nfile = "cabinet.obj"\n'
    scene, _ = open_scene(write(folder, EYE + model + model + '[[part]]\nname = "wall*"\nremove = true\n'))
    assert [mesh.name for mesh in scene.meshes] == ["door", "door-2"]


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        (EYE.replace("position", "positoin"), 2, ["'positoin'", "did you mean 'position'"]),
        (EYE + "field_of_view = '40'\n", 4, ["field_of_view", "a number"]),
        (EYE + "field_of_view = 180\n", 4, ["field_of_view", "179"]),
        (EYE + "up = [0, 1]\n", 4, ["up", "three numbers"]),
        (EYE + f"field_of_view = {10**400}\n", 4, ["field_of_view", "..."]),
        (EYE + "up = [0, nan, 0]\n", 4, ["up", "three numbers"]),
        ("size = [800]\n" + EYE, 1, ["size", "two whole numbers"]),
        ("size = [800, 0]\n" + EYE, 1, ["size", "two whole numbers"]),
        ("size = [800, 600.5]\n" + EYE, 1, ["size", "two whole numbers"]),
        ("method = 3\n" + EYE, 1, ["method", "text"]),
        ("eye = 3\n", 1, ["eye", "[eye]"]),
        ("[eye]\nposition = [0, 0, 1]\n", 1, ["eye needs the key 'target'"]),
        ("\n\nlights = 3\n" + EYE, 3, ["'lights'", "did you mean 'light'"]),
        ('builtin = "car-miror"\n', 1, ["car-miror", "did you mean 'car-mirror'"]),
        (EYE + "[[model]]\nfile = 'cabinet.ob'\n", 5, ["file", "cabinet.ob"]),
        (EYE + "[[model]]\nscale = 2\n", 4, ["model needs the key 'file'"]),
        (EYE + "[[model]]\nfile = 'cabinet.obj'\nscale = 0\n", 6, ["scale", "positive"]),
        (EYE + "[model]\nfile = 'cabinet.obj'\n", 4, ["model", "[[model]]"]),
        (EYE + "[[part]]\nname = 'dor'\n", 5, ["'dor'", "did you mean 'door'"]),
        (EYE + "[[part]]\nmaterial = 'Chrome'\n", 5, ["no material is called 'Chrome'"]),
        (EYE + "[[part]]\nremove = true\n", 4, ["'name' or 'material'"]),
        (EYE + "[[part]]\nname = 'wall'\nremove = 'yes'\n", 6, ["remove", "true or false"]),
        (EYE + "[[part]]\nname = 'door'\nmirror = { tnt = [1, 1, 1] }\n", 6, ["'tnt'", "did you mean 'tint'"]),
        (EYE + "[[part]]\nname = 'door'\nmirror = { reflectance = 1.2 }\n", 6, ["reflectance", "from 0 to 1"]),
        (EYE + "[[part]]\nname = 'door'\nmirror = {}\nglass = {}\n", 7, ["mirror and glass"]),
        (EYE + "[[part]]\nname = 'door'\n[part.glass]\nindex = -1\n", 7, ["index"]),
        (EYE + "[[part]]\nname = 'door'\nturn = [1, 2]\n", 6, ["turn", "three numbers"]),
        (EYE + "[[part]]\nname = 'door'\nmove = 3\n", 6, ["move", "three numbers"]),
        (EYE + "[[part]]\nname = 'door'\ncurvature = 'flat'\n", 6, ["curvature", "a number"]),
        (EYE + "[[part]]\nname = 'door'\ncurvature = 0.5\n", 6, ["'door'", "is 0 mirrors"]),
        (EYE + "[[part]]\nname = 'door'\nturn = [0, 9, 0]\npower = 1\n", 6, ["'door'", "is no lens"]),
        (EYE + "[[part]]\nname = 'door'\nindex = 1.5\n", 6, ["'door'", "no index"]),
        (EYE + "[[light]]\nkind = 'spot'\n", 5, ["'spot'", "point"]),
        (EYE + "[[light]]\nkind = 'directional'\n", 4, ["needs the key 'toward'"]),
        (EYE + "[[light]]\nkind='ambient'\n[[light]]\nkind='directional'\ntoward=[0,0,0]\n", 8, ["toward"]),
        (EYE + "[sky]\nzenith = [-1, 0, 0]\n", 5, ["zenith", "at least 0"]),
        (EYE + "[sky]\nimage = 'no.png'\n", 5, ["image", "no.png"]),
    ],
)
def test_a_mistake_is_named_with_its_line_and_key(folder: Path, text: str, line: int, words: list[str]) -> None:
    if "[[model]]" not in text and "[model]" not in text and "builtin" not in text:
        text += "[[model]]\nfile = 'cabinet.obj'\n"
    message = complaint(write(folder, text))
    assert f", line {line}: " in message, message
    assert all(word in message for word in words), message


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("size = [800, 600\n" + EYE, ["is not TOML", "line 2"]),
        ("", ["nothing to show", "[[model]]"]),
        ("[[model]]\nfile = 'cabinet.obj'\n", ["[eye]"]),
        (EYE.replace("0.3, 0.2, 5", "0, 0, 0") + "[[model]]\nfile = 'cabinet.obj'\n", ["same point"]),
        (EYE.replace("[0.3, 0.2, 5]", "[0, 9, 0]") + "[[model]]\nfile = 'cabinet.obj'\n", ["up", "along the view"]),
        (
            EYE + "[[model]]\nfile = 'cabinet.obj'\n[[part]]\nname = 'door'\ndiffuse = { image = 'a.png' }\n",
            ["'door'", "texture coordinates"],
        ),
        (
            EYE.replace("0.2, 5", "90, 5") + "[[model]]\nfile='cabinet.obj'\n[[part]]\nname='door'\nmirror={}\n",
            ["behind the mirror 'door'"],
        ),
    ],
)
def test_a_scene_that_cannot_be_drawn_is_refused(folder: Path, text: str, words: list[str]) -> None:
    Image.new("RGB", (2, 2)).save(folder / "a.png")
    message = complaint(write(folder, text))
    assert all(word in message for word in words), message


def test_a_file_that_is_not_text_or_not_there_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    assert "no such scene file" in complaint(path)
    path.write_bytes(b"\xff\xfe\x00")
    assert "UTF-8" in complaint(path)


def test_a_sky_image_is_read(folder: Path) -> None:
    Image.new("RGB", (8, 4), (10, 20, 30)).save(folder / "sky.png")
    text = EYE + "[[model]]\nfile = 'cabinet.obj'\n[sky]\nimage = 'sky.png'\n"
    scene, _ = open_scene(write(folder, text))
    assert scene.sky.image is not None and scene.sky.image.pixels.shape == (4, 8, 4)
    assert scene.sky.image.pixels[0, 0].tolist() == [10, 20, 30, 255]


def test_lines_are_found_through_strings_arrays_and_nested_tables() -> None:
    text = 'a = """\nb = 1\n[c]\n"""\n"d e".f = [\n  1, # ]\n  2,\n]\n'
    text += '[[g]]\n[g.h]\ni = "[["\n[[g]]\nj = {k = "\\"["}\n[[g.l]]\nm = 1\n'
    assert key_lines(text) == {
        ("a",): 1,
        ("d e", "f"): 5,
        ("g", 0): 9,
        ("g", 0, "h"): 10,
        ("g", 0, "h", "i"): 11,
        ("g", 1): 12,
        ("g", 1, "j"): 13,
        ("g", 1, "l", 0): 14,
        ("g", 1, "l", 0, "m"): 15,
    }


degrees = st.floats(-360, 360)


@given(st.tuples(degrees, degrees, degrees), st.floats(0.01, 100), st.integers(0, 2**32 - 1))
def test_a_moved_mesh_stays_on_its_moved_surface(angles: tuple[float, float, float], scale: float, seed: int) -> None:
    random = np.random.default_rng(seed)
    by = Similarity(scale, rotation(angles), random.normal(size=3))
    parameters = random.uniform(0.1, 0.9, (5, 2))
    patch = np.stack([*np.meshgrid(np.arange(4.0), np.arange(4.0), indexing="ij"), random.normal(size=(4, 4))], axis=-1)
    template = gallery.make("spheres").meshes[0]
    for surface in (Plane(np.ones(3), *np.eye(3)[:2]), Sphere(np.ones(3), 0.7), BezierPatch(patch)):
        mesh = type(template)(
            "m",
            surface.position(parameters).astype(np.float32),
            np.array([[0, 1, 2]], np.int32),
            surface.normal(parameters).astype(np.float32),
            surface=surface,
            parameters=parameters,
        )
        moved = mesh.moved(by)
        assert moved.surface is not None
        assert np.allclose(moved.surface.position(parameters), moved.positions, atol=1e-4 * max(scale, 1.0))
        assert np.allclose(moved.surface.normal(parameters), moved.normals, atol=1e-4)


def test_rotations_turn_about_x_then_y_then_z() -> None:
    assert np.allclose(rotation((90, 0, 0)) @ [0, 1, 0], [0, 0, 1])
    assert np.allclose(rotation((90, 90, 0)) @ [0, 1, 0], [1, 0, 0])
    assert np.allclose(rotation((90, 90, 90)) @ [0, 1, 0], [0, 1, 0])


def reflected(scene_mirror_surface: Sphere, eye: np.ndarray, direction: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where a ray meets the sphere, and its direction after it."""
    offset = eye - scene_mirror_surface.center
    along = offset @ direction
    distance = -along - np.sqrt(along**2 - offset @ offset + scene_mirror_surface.radius**2)
    point = eye + distance * direction
    normal = (point - scene_mirror_surface.center) / scene_mirror_surface.radius
    return point, direction - 2 * (normal @ direction) * normal


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("extents", [(1, 1, 1), (4, 0.2, 1), (0.1, 3, 0.1), (1, 0, 2)])
def test_a_bare_model_is_seen_whole_in_its_mirror(unit: float, extents: tuple[float, float, float]) -> None:
    middle = unit * np.array([3.0, -2.0, 5.0])
    corners = middle + unit * np.array(extents) * (np.indices((2, 2, 2)).reshape(3, -1).T - 0.5)
    faces = np.array([[0, 1, 3], [4, 5, 7], [0, 1, 5]], np.int32)
    normals = np.tile(np.float32([0, 1, 0]), (8, 1))
    template = gallery.make("spheres").meshes[0]
    model = type(template)("box", corners.astype(np.float32), faces, normals)
    scene = stand_before_mirror((model,), "box")
    mirror = scene.meshes[0]
    assert isinstance(mirror.material, Mirror) and isinstance(mirror.surface, Sphere)
    assert np.allclose(mirror.surface.position(mirror.parameters), mirror.positions, atol=1e-5 * unit * 10)
    eye = np.array(scene.camera.position)
    size = np.linalg.norm(extents) / 2 * unit

    # The ray to the mirror's middle goes on to the model's middle.
    outward = mirror.surface.axes[2]
    center = mirror.surface.center + mirror.surface.radius * outward
    _, after = reflected(mirror.surface, eye, (center - eye) / np.linalg.norm(center - eye))
    assert np.linalg.norm(np.cross(after, middle - center)) < 1e-6 * size

    # Rays to the mirror's edges pass outside the model's bounding sphere, on all sides: it is seen whole.
    edge = mirror.positions.reshape(13, 17, 3)
    edge = np.concatenate([edge[0], edge[-1], edge[:, 0], edge[:, -1]]).astype(float)
    for place in edge:
        point, after = reflected(mirror.surface, eye, (place - eye) / np.linalg.norm(place - eye))
        assert np.linalg.norm(np.cross(after, middle - point)) > size
        # And the bounding sphere does not hide the mirror from the eye.
        toward = (place - eye) / np.linalg.norm(place - eye)
        assert np.linalg.norm(np.cross(toward, middle - eye)) > size

    # The whole mirror is in the image, above the ground.
    right, up, forward = scene.camera.axes()
    seen = (edge - eye) @ np.stack([right, up, forward]).T
    limit = np.tan(np.radians(scene.camera.field_of_view / 2))
    assert np.abs(seen[:, 1] / seen[:, 2]).max() < limit and np.abs(seen[:, 0] / seen[:, 2]).max() < 4 / 3 * limit
    assert edge[:, 1].min() > corners[:, 1].min()


def test_opening_by_name_by_file_and_by_neither(folder: Path) -> None:
    scene, settings = open_scene(folder / "towels.glb")
    assert scene.name == "towels" and settings == Settings()
    assert [mesh.name for mesh in scene.meshes] == ["mirror", "mirror-plate", "ground", "towel"]
    assert np.array_equal(scene.meshes[-1].positions, load_model(folder / "towels.glb")[0].positions)
    scene, settings = open_scene(write(folder, 'size = [8, 6]\nbuiltin = "spheres"\n'))
    assert settings.size == (8, 6)
    for wrong, words in [
        ("car-miror", "did you mean 'car-mirror'"),
        (str(folder / "none.glb"), "no such model file"),
        (str(folder / "cabinet"), "built in: car-mirror"),
        (str(folder), "built in"),
    ]:
        with pytest.raises(AnamorphError, match=re.escape(words)):
            open_scene(wrong)
    (folder / "model.3dm").write_bytes(struct.pack("<i", 0))
    with pytest.raises(AnamorphError, match=r"model\.3dm: is no scene file and no known model.* \.toml, \.glb"):
        open_scene(folder / "model.3dm")
