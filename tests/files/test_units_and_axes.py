"""The unit and the axes of models, in scene files, on the command line and in Python; and models without a scene."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pytest
import trimesh
from trimesh.visual.material import PBRMaterial

from anamorph.base.errors import AnamorphError
from anamorph.files.models import load_model
from anamorph.files.opening import open_scene
from anamorph.files.source import Source
from anamorph.files.source_words import source_in
from anamorph.files.units_and_axes import UNITS, WAYS, metres_in, turn_of
from anamorph.files.view_file import open_view, save_view
from anamorph.surfaces.similarity import rotation

EYE = "[eye]\nposition = [1, 1, 4]\ntarget = [0, 0, 0]\n"
DIRECTIONS = {"right": [1, 0, 0], "left": [-1, 0, 0], "up": [0, 1, 0], "down": [0, -1, 0], "back": [0, 0, 1],
              "forward": [0, 0, -1]}  # fmt: skip


def obj(folder: Path) -> Path:
    """A slab of 10 by 20 by 30 from the origin along x, y and z."""
    box = trimesh.creation.box((10, 20, 30))
    box.apply_translation((5, 10, 15))
    box.export(folder / "slab.obj")
    return folder / "slab.obj"


def reach(positions: np.ndarray) -> np.ndarray:
    """How far a slab from the origin reaches along the axes of the world, with signs."""
    low, high = positions.min(axis=0), positions.max(axis=0)
    return np.where(-low > high, low, high)


def test_two_axes_and_the_third_follows() -> None:
    for (one, first), (two, second) in product(product("xyz", WAYS), repeat=2):
        words = f"{one} {first}, {two.upper()}  {second}"
        if one == two or abs(np.dot(DIRECTIONS[first], DIRECTIONS[second])) == 1:
            with pytest.raises(AnamorphError, match="comes after another"):
                turn_of(words)
            continue
        turn = turn_of(words)
        assert np.array_equal(turn[:, "xyz".index(one)], DIRECTIONS[first])
        assert np.array_equal(turn[:, "xyz".index(two)], DIRECTIONS[second])
        assert np.linalg.det(turn) == pytest.approx(1.0)
        third = next(axis for axis in range(3) if axis not in ("xyz".index(one), "xyz".index(two)))
        way = next(way for way, along in DIRECTIONS.items() if np.array_equal(along, turn[:, third]))
        assert np.array_equal(turn_of(f"{words}, {'xyz'[third]} {way}"), turn)


def test_one_axis_alone_turns_about_the_third() -> None:
    assert np.allclose(turn_of("z up"), rotation((-90, 0, 0)))
    assert np.allclose(turn_of("x up"), rotation((0, 0, 90)))
    assert np.array_equal(turn_of("y up"), np.eye(3)) and np.array_equal(turn_of(""), np.eye(3))


@pytest.mark.parametrize(
    ("axes", "words"),
    [
        ("z upp", "'z upp' is no axis with right, left, up, down, back, forward"),
        ("w up", "'w up' is no axis"),
        ("up", "'up' is no axis"),
        ("x right,", "'' is no axis"),
        ("y down", "one axis alone does not say"),
        ("x right, y up, z forward", "left-handed"),
    ],
)
def test_what_are_no_axes_is_named(axes: str, words: str) -> None:
    with pytest.raises(AnamorphError, match=rf"^axes is '{axes}', and .*{words}.*; give two of x, y and z"):
        turn_of(axes)


def test_units_are_metres() -> None:
    assert [metres_in(unit) for unit in ("", "m", "mm", "in")] == [1.0, 1.0, 0.001, 0.0254]
    with pytest.raises(AnamorphError, match=r"^units is 'millimetre'.*known: m, mm, cm"):
        metres_in("millimetre")


@pytest.mark.parametrize("suffix", ["obj", "stl", "ply", "glb"])
def test_every_kind_of_model_takes_them(tmp_path: Path, suffix: str) -> None:
    trimesh.load_mesh(obj(tmp_path)).export(tmp_path / f"slab.{suffix}")
    (mesh,) = load_model(tmp_path / f"slab.{suffix}", scale=2.0, units="mm", axes="x back, z up")
    assert reach(mesh.positions) == pytest.approx([0.04, 0.06, 0.02], abs=1e-6)
    corners = mesh.positions[mesh.faces]
    outward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.sum(outward * (corners.mean(axis=1) - mesh.positions.mean(axis=0)), axis=1) > 0).all()


def test_a_scene_file_a_command_and_a_saved_view_say_them_alike(tmp_path: Path) -> None:
    path, right = obj(tmp_path), np.array([0.02, 0.03, 0.01])
    (tmp_path / "s.toml").write_text(f'{EYE}[[model]]\nfile = "slab.obj"\nunits = "mm"\naxes = "x back, z up"\n')
    assert reach(open_scene(tmp_path / "s.toml")[0].meshes[0].positions) == pytest.approx(right)
    (tmp_path / "b.toml").write_text('base = "slab.obj"\nunits = "mm"\naxes = "x back, z up"\n')
    assert reach(open_scene(tmp_path / "b.toml")[0].meshes[-1].positions) == pytest.approx(right)
    source = source_in(f"'{path}' --units mm --axes 'x back, z up'")
    assert source == Source(str(path), units="mm", axes="x back, z up")
    opened = open_view(source.name, units=source.units, axes=source.axes)
    assert reach(opened.scene.meshes[-1].positions) == pytest.approx(right)
    save_view(tmp_path / "v.toml", opened, opened.camera, (8, 6), "raytrace", {}, {})
    assert reach(open_scene(tmp_path / "v.toml")[0].meshes[-1].positions) == pytest.approx(right)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('[[model]]\nfile = "slab.obj"\nunits = "mn"\n', r"line 6: units is 'mn'; did you mean 'm'\?"),
        ('[[model]]\nfile = "slab.obj"\naxes = "z upp"\n', "line 6: axes is 'z upp'"),
        ('[[model]]\nfile = "slab.step"\nunits = "mm"\n', "slab.step: names its unit itself; leave units out"),
    ],
)
def test_mistakes_in_a_scene_file_are_named(tmp_path: Path, text: str, words: str) -> None:
    obj(tmp_path)
    (tmp_path / "slab.step").write_bytes(b"")
    (tmp_path / "s.toml").write_text(EYE + text)
    with pytest.raises(AnamorphError, match=words):
        open_scene(tmp_path / "s.toml")


def test_what_is_no_model_takes_neither(tmp_path: Path) -> None:
    for key in ("units", "axes"):
        (tmp_path / "s.toml").write_text(f'builtin = "spheres"\n{key} = ""\n')
        with pytest.raises(AnamorphError, match=rf"line 2: {key} is for a base that is a model"):
            open_scene(tmp_path / "s.toml")
    with pytest.raises(AnamorphError, match="spheres: --units and --axes are for a model"):
        open_scene("spheres", units="mm")


@pytest.mark.parametrize("suffix", ["obj", "ply", "glb"])
def test_map_coordinates_are_moved_before_they_are_rounded(tmp_path: Path, suffix: str) -> None:
    """Float32 has half metres there. Of glTF, whose vertices are float32, the place of a node is as exact."""
    true = np.random.default_rng(3).uniform(-50, 50, (60, 3)).round(3)
    place, faces = np.array([432000.0, 510.0, -5350000.0]), np.arange(60).reshape(-1, 3)
    if suffix == "glb":
        scene = trimesh.Scene()
        scene.add_geometry(
            trimesh.Trimesh(true, faces, process=False), transform=trimesh.transformations.translation_matrix(place)
        )
        scene.export(tmp_path / "site.glb")
    elif suffix == "obj":
        lines = ["v {:.3f} {:.3f} {:.3f}\n".format(*corner) for corner in true + place]
        (tmp_path / "site.obj").write_text("".join(lines) + "".join("f {} {} {}\n".format(*face) for face in faces + 1))
    else:
        lines = ["{:.3f} {:.3f} {:.3f}\n".format(*corner) for corner in true + place]
        header = "ply\nformat ascii 1.0\nelement vertex 60\nproperty double x\nproperty double y\nproperty double z\n"
        header += "element face 20\nproperty list uchar int vertex_indices\nend_header\n"
        (tmp_path / "site.ply").write_text(
            header + "".join(lines) + "".join("3 {} {} {}\n".format(*face) for face in faces)
        )
    moved = "translate = [-432000.0, -510.0, 5350000.0]"
    (tmp_path / "s.toml").write_text(f'{EYE}[[model]]\nfile = "site.{suffix}"\n{moved}\n')
    (mesh,) = open_scene(tmp_path / "s.toml")[0].meshes
    assert len(mesh.positions) == 60
    distances = np.linalg.norm(mesh.positions[:, None] - true, axis=2).min(axis=1)
    assert distances.max() < 1e-5


def with_mirror(folder: Path, normal_turn: float) -> Path:
    """A metal panel of 1.2 by 1.6 m, turned about the vertical, and a red box before it."""
    panel = trimesh.Trimesh([[-0.6, 0, 0], [0.6, 0, 0], [0.6, 1.6, 0], [-0.6, 1.6, 0]], [[0, 1, 2], [0, 2, 3]])
    box = trimesh.creation.box((0.3, 0.3, 0.3))
    for mesh, place, metallic in ((panel, (0, 0, -1), 1.0), (box, (0.2, 0.15, 0), 0.0)):
        material = PBRMaterial(baseColorFactor=[0.9, 0.2, 0.2, 1.0], metallicFactor=metallic, roughnessFactor=0.0)
        mesh.visual = trimesh.visual.TextureVisuals(material=material)
        mesh.apply_translation(place)
    turn = trimesh.transformations.rotation_matrix(normal_turn, (0, 1, 0))
    scene = trimesh.Scene({"mirror": panel, "ground": box})
    scene.apply_transform(turn)
    scene.export(folder / "own.glb")
    return folder / "own.glb"


@pytest.mark.parametrize("turn", [0.0, 1.3, np.pi, -2.0])
def test_a_model_with_a_mirror_of_its_own_is_seen_as_itself(tmp_path: Path, turn: float) -> None:
    """Nothing is added, all of it is in the image, and the eye stands before the mirror."""
    scene, _ = open_scene(with_mirror(tmp_path, turn))
    assert {mesh.name for mesh in scene.meshes} == {"mirror", "ground"}
    camera = scene.camera
    axes = np.stack(camera.axes())
    seen = np.concatenate([mesh.positions for mesh in scene.meshes]) @ axes.T - axes @ np.array(camera.position)
    assert (
        np.abs(seen[:, :2] / seen[:, 2:]).max() < np.tan(np.radians(camera.field_of_view / 2.0))
        and seen[:, 2].min() > 0
    )
    (mirror,) = (mesh for mesh in scene.meshes if mesh.specular)
    outward = mirror.normals.astype(float).mean(axis=0)
    away = np.array(camera.position) - mirror.positions.mean(axis=0)
    assert outward @ away / np.linalg.norm(away) > 0.7


def test_what_stands_around_a_model_has_names_of_its_own(tmp_path: Path) -> None:
    trimesh.Scene({"mirror": trimesh.creation.box(), "ground": trimesh.creation.icosphere(1)}).export(
        tmp_path / "m.glb"
    )
    names = [mesh.name for mesh in open_scene(tmp_path / "m.glb")[0].meshes]
    assert names == ["mirror", "mirror-plate", "ground", "mirror-2", "ground-2"]


def test_every_unit_is_told(tmp_path: Path) -> None:
    """The page on scene files lists what the program knows."""
    page = (Path(__file__).resolve().parents[2] / "docs" / "scene-file.md").read_text()
    assert ", ".join(f'`"{unit}"`' for unit in UNITS) in page
    assert all(f"`{way}`" in page for way in WAYS)
