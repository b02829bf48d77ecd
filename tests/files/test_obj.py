"""OBJ and MTL files, as the programs that people use write them."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from anamorph.base.errors import AnamorphError
from anamorph.base.notes import AnamorphNote
from anamorph.files.models import Part, load_parts
from anamorph.files.opening import open_scene
from anamorph.scene.model import Diffuse
from anamorph.scene.triangles import doubled_areas

SQUARE = "v -1 0 0\nv 1 0 0\nv 1 2 0\nv -1 2 0\n"
BESIDE = "v 2 0 0\nv 4 0 0\nv 4 2 0\nv 2 2 0\n"
CORNERS = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"


@pytest.fixture(autouse=True)
def no_notes() -> object:
    """What is shown whole says nothing."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", AnamorphNote)
        yield


def parts_of(folder: Path, text: str, **libraries: str) -> tuple[Part, ...]:
    for name, library in libraries.items():
        (folder / f"{name.replace('_', ' ')}.mtl").write_text(library)
    (folder / "model.obj").write_text(text)
    return load_parts(folder / "model.obj")


def looks(part: Part) -> Diffuse:
    assert isinstance(part.mesh.material, Diffuse)
    return part.mesh.material


def area(part: Part) -> float:
    return float(np.linalg.norm(doubled_areas(part.mesh.positions, part.mesh.faces), axis=1).sum() / 2.0)


def image(path: Path, level: int = 100) -> str:
    Image.new("RGB", (4, 2), (level, level, level)).save(path)
    return path.name


def test_a_concave_face_keeps_its_notch(tmp_path: Path) -> None:
    notched = "v -1 0 0\nv 1 0 0\nv 1 2 0\nv -1 2 0\nv -1 1.6 0\nv .6 1.6 0\nv .6 .4 0\nv -1 .4 0\nf 1 2 3 4 5 6 7 8\n"
    dart = "v -1 0 0\nv 0 .4 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 4\n"
    for text, right in ((notched, 2.08), (dart, 0.6)):
        (part,) = parts_of(tmp_path, text)
        assert area(part) == pytest.approx(right)
        assert np.allclose(part.mesh.normals, [0, 0, 1])


def test_indices_count_back_from_their_own_line(tmp_path: Path) -> None:
    """Of vertices, texture coordinates and normals alike."""
    text = ""
    for name, vertices, normal in (("red", SQUARE, "0 0 1"), ("blue", BESIDE, "0 0.6 0.8")):
        text += f"o {name}\nusemtl {name}\n{vertices}{CORNERS}vn {normal}\nf -4/-4/-1 -3/-3/-1 -2/-2/-1 -1/-1/-1\n"
    red, blue = parts_of(tmp_path, "mtllib w.mtl\n" + text, w="newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n")
    assert [(part.mesh.name, looks(part).color) for part in (red, blue)] == [("red", (1, 0, 0)), ("blue", (0, 0, 1))]
    assert red.mesh.positions[:, 0].max() == 1.0 and blue.mesh.positions[:, 0].min() == 2.0
    assert np.allclose(red.mesh.normals, [0, 0, 1]) and np.allclose(blue.mesh.normals, [0, 0.6, 0.8])
    for part in (red, blue):
        assert part.mesh.texcoords is not None
        lowest = part.mesh.positions - part.mesh.positions.min(axis=0)
        assert np.allclose(part.mesh.texcoords, lowest[:, :2] * (0.5, -0.5) + (0, 1))


@pytest.mark.parametrize(
    ("face", "words"),
    [
        ("f -5 -2 -1", "a face names v -5, and 4 stand above it"),
        ("f 1 2 -0", "a face names v -0"),
        ("f 1 2 5", "a face names v 5, and there are 4"),
        ("f 0 1 2", "a face names v 0, and there are 4"),
        ("f 1/1 2/1 3/1", "a face names vt 1, and there are 0"),
        ("f 1//-1 2//-1 3//-1", "a face names vn -1, and 0 stand above it"),
        ("f 1 2 x", "a face has the corner 'x'"),
        ("v 1 2", "line 5: v needs 3 numbers"),
        ("v 1 2 z", "line 5: could not convert"),
    ],
)
def test_what_is_no_index_or_number_is_named(tmp_path: Path, face: str, words: str) -> None:
    with pytest.raises(AnamorphError, match=rf"model\.obj: is damaged or no OBJ file \(.*{words}"):
        parts_of(tmp_path, f"{SQUARE}{face}\nf 1 2 3\n")


@pytest.mark.parametrize("lines", ["mtllib one.mtl\nmtllib two parts.mtl", "mtllib one.mtl two parts.mtl"])
def test_every_library_is_read(tmp_path: Path, lines: str) -> None:
    """On lines of their own or on one, names with spaces too; the first of two materials of one name counts."""
    text = f"{lines}\n{SQUARE}usemtl a\nf 1 2 3\nusemtl b c\nf 1 3 4\n"
    one, two = parts_of(
        tmp_path, text, one="newmtl a\nKd 1 0 0\n", two_parts="newmtl b c\nKd 0 0 1\nnewmtl a\nKd 0 1 0\n"
    )
    assert (one.material, looks(one).color, area(one)) == ("a", (1, 0, 0), 2.0)
    assert (two.material, looks(two).color, area(two)) == ("b c", (0, 0, 1), 2.0)


def test_libraries_may_be_called_otherwise(tmp_path: Path) -> None:
    for name, shade in (("a", "1 0 0"), ("b", "0 0 1")):
        (tmp_path / f"{name}.txt").write_text(f"newmtl {name}\nKd {shade}\n")
    one, two = parts_of(tmp_path, f"mtllib a.txt b.txt\n{SQUARE}usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\n")
    assert (looks(one).color, looks(two).color) == ((1, 0, 0), (0, 0, 1))


def test_a_library_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(AnamorphError, match=r"names the file 'my two\.mtl', which is not there"):
        parts_of(tmp_path, f"mtllib one.mtl my two.mtl\n{SQUARE}f 1 2 3\n", one="")


def test_a_material_that_no_library_has_is_told(tmp_path: Path) -> None:
    with pytest.warns(AnamorphNote, match=r"part 'model': its material 'b' is in no library"):
        (part,) = parts_of(tmp_path, f"mtllib one.mtl\nusemtl b\n{SQUARE}f 1 2 3\n", one="newmtl a\n")
    assert part.material == "b" and looks(part).color == Diffuse().color


def test_options_of_an_image_are_followed(tmp_path: Path) -> None:
    name = image(tmp_path / "my wall paint.png", 100)
    text = f"mtllib m.mtl\nusemtl a\n{SQUARE}{CORNERS}f 1/1 2/2 3/3 4/4\n"
    options = "-blendu on -s 2 3 1 -mm 0.1 0.5 -o 0.25 -clamp on -texres 512"
    (part,) = parts_of(tmp_path, text, m=f"newmtl a\nmap_Kd {options} {name}\n")
    texture, texcoords = looks(part).texture, part.mesh.texcoords
    assert texture is not None and texcoords is not None and looks(part).color == (1, 1, 1)
    assert texture.wraps == ("clamp", "clamp")
    assert (texture.pixels[..., :3] == round(0.1 * 255 + 0.5 * 100)).all() and (texture.pixels[..., 3] == 255).all()
    # From the bottom left u goes from 0.25 to 2.25 and v from 0 to 3, over 2 m each.
    upright = np.column_stack([part.mesh.positions[:, 0] + 1.25, 1.5 * part.mesh.positions[:, 1]])
    assert np.allclose(texcoords, upright * (1, -1) + (0, 1))


def test_an_option_without_its_number_is_named(tmp_path: Path) -> None:
    with pytest.raises(AnamorphError, match=r"m\.mtl, line 2: map_Kd has -s without a number"):
        parts_of(tmp_path, f"mtllib m.mtl\n{SQUARE}f 1 2 3\n", m="newmtl a\nmap_Kd -s wall.png\n")


def test_an_image_without_texture_coordinates_is_told(tmp_path: Path) -> None:
    library = f"newmtl a\nmap_Kd {image(tmp_path / 'w.png')}\n"
    with pytest.warns(AnamorphNote, match=r"has no texture coordinates; the image 'w\.png' is left out"):
        (part,) = parts_of(tmp_path, f"mtllib m.mtl\nusemtl a\n{SQUARE}f 1 2 3\n", m=library)
    assert looks(part).texture is None


@pytest.mark.parametrize("library", ["", "newmtl plain\nKd 1 1 1\n"])
def test_texture_coordinates_stay_for_an_image_of_the_scene_file(tmp_path: Path, library: str) -> None:
    parts_of(
        tmp_path, f"mtllib m.mtl\n{'usemtl plain' * bool(library)}\n{SQUARE}{CORNERS}f 1/1 2/2 3/3 4/4\n", m=library
    )
    image(tmp_path / "paint.png")
    eye = "[eye]\nposition = [0, 1, 4]\ntarget = [0, 1, 0]\n"
    (tmp_path / "scene.toml").write_text(f'{eye}[[model]]\nfile = "model.obj"\ndiffuse = {{ image = "paint.png" }}\n')
    (mesh,) = open_scene(tmp_path / "scene.toml")[0].meshes
    assert isinstance(mesh.material, Diffuse) and mesh.material.texture is not None and mesh.texcoords is not None
    assert np.allclose(mesh.texcoords, mesh.positions[:, :2] * (0.5, -0.5) + (0.5, 1))


def test_groups_are_parts(tmp_path: Path) -> None:
    """Under their own names; what has no group is called after its object, or after the file."""
    faces = """f 1 2 3;o car;g mirror_left;f 1 2 3;usemtl body;f 1 3 4;g housing;f 1 2 4;g default;f 2 3 4
        g two words;f 1 2 3;o van;f 1 2 3;g mirror_left;f 1 3 4;o car;g mirror_left;f 1 2 4"""
    parts = parts_of(tmp_path, SQUARE + faces.replace(";", "\n"))
    named = [(part.mesh.name, part.material, area(part)) for part in parts]
    assert named == [
        ("model", "", 2.0),
        ("mirror_left", "", 2.0),
        ("mirror_left-2", "body", 4.0),
        ("housing", "body", 2.0),
        ("car", "body", 2.0),
        ("two words", "body", 2.0),
        ("van", "body", 2.0),
        ("mirror_left-3", "body", 2.0),
    ]


def test_what_is_no_polygon_is_told(tmp_path: Path) -> None:
    with pytest.warns(AnamorphNote, match=r"model\.obj: its free-form surfaces and lines and points are left out"):
        (part,) = parts_of(tmp_path, f"{SQUARE}l 1 2\np 1\nsurf 0 1 0 1 1 2\nend\nf 1 2 3 4\n")
    assert area(part) == 4.0


def test_long_lines_go_on_and_comments_end_them(tmp_path: Path) -> None:
    (part,) = parts_of(tmp_path, f"{SQUARE}f 1 2 \\\n3 4 # the whole\n".replace("\n", "\r\n"))
    assert area(part) == 4.0


def test_colours_of_vertices_are_srgb(tmp_path: Path) -> None:
    (part,) = parts_of(tmp_path, "v 0 0 0 1 0.5 0\nv 1 0 0 1 0.5 0\nv 0 1 0\nf 1 2 3\n")
    assert part.mesh.colors is not None and looks(part).color == (1, 1, 1)
    assert np.allclose(part.mesh.colors, [[1, 0.21404, 0], [1, 0.21404, 0], [1, 1, 1]], atol=1e-4)


def test_corners_with_and_without_normals_stand_in_one_part(tmp_path: Path) -> None:
    (part,) = parts_of(tmp_path, f"{SQUARE}{BESIDE}vn 0 0.6 0.8\nf 1//1 2//1 3//1 4//1\nf 5 6 7 8\n")
    left = part.mesh.positions[:, 0] < 1.5
    assert np.allclose(part.mesh.normals[left], [0, 0.6, 0.8]) and np.allclose(part.mesh.normals[~left], [0, 0, 1])
