"""PLY and STL files: strips and polygons, colours, texture coordinates, and what stands after the end."""

from __future__ import annotations

import struct
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from anamorph.base.errors import AnamorphError
from anamorph.base.notes import AnamorphNote
from anamorph.files.models import load_model
from anamorph.files.opening import open_scene
from anamorph.files.ply_elements import read_ply
from anamorph.scene.model import Diffuse, Mesh
from anamorph.scene.triangles import doubled_areas

SQUARE = np.array([[-1, 0, 0], [1, 0, 0], [1, 2, 0], [-1, 2, 0]], float)
NOTCHED = "-1 0 0,1 0 0,1 2 0,-1 2 0,-1 1.6 0,0.6 1.6 0,0.6 0.4 0,-1 0.4 0"
GREY = 0.21404
"""Linear light of the sRGB value 0.5."""


@pytest.fixture(autouse=True)
def no_notes() -> object:
    """What is shown whole says nothing."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", AnamorphNote)
        yield


def ply(folder: Path, vertices: str, *elements: str, more: str = "", comment: str = "") -> Mesh:
    """A PLY text: vertices with commas between them, and elements as "NAME|PROPERTIES|ENTRIES"."""
    rows = vertices.split(",")
    properties = "".join(f"property float {name}\n" for name in ["x", "y", "z", *more.split()])
    header = f"ply\nformat ascii 1.0\n{comment}element vertex {len(rows)}\n{properties}"
    for element in elements:
        name, listed, entries = element.split("|")
        header += f"element {name} {len(entries.split(','))}\n"
        header += "".join(f"property {each}\n" for each in listed.split(","))
        rows += entries.split(",")
    (folder / "m.ply").write_text(header + "end_header\n" + "\n".join(rows) + "\n")
    (mesh,) = load_model(folder / "m.ply")
    return mesh


FACES = "list uchar int vertex_indices"
CORNERS = ",".join(" ".join(f"{value:g}" for value in corner) for corner in SQUARE)


def area(mesh: Mesh) -> float:
    return float(np.linalg.norm(doubled_areas(mesh.positions, mesh.faces), axis=1).sum() / 2.0)


def diffuse(mesh: Mesh) -> Diffuse:
    assert isinstance(mesh.material, Diffuse)
    return mesh.material


def color_at(mesh: Mesh, x: float, y: float) -> np.ndarray:
    """The colours of the triangle around a point."""
    assert mesh.colors is not None
    for face in mesh.faces:
        corners = mesh.positions[face][:, :2] - (x, y)
        following = np.roll(corners, -1, axis=0)
        if (corners[:, 0] * following[:, 1] - corners[:, 1] * following[:, 0] > 0).all():
            return mesh.colors[face]
    raise AssertionError((x, y))


def test_concave_faces_of_a_ply_file_keep_their_notch(tmp_path: Path) -> None:
    assert area(ply(tmp_path, NOTCHED, f"face|{FACES}|8 0 1 2 3 4 5 6 7")) == pytest.approx(2.08)


@pytest.mark.parametrize(
    ("strips", "right"),
    [
        ("5 0 1 3 2 -1", 4.0),
        ("4 0 1 3 2", 4.0),
        ("8 0 1 3 -1 1 2 3 -1", 4.0),
        ("3 0 1 3,3 1 2 3", 4.0),
        ("10 0 1 3 2 -1 0 1 3 2 -1", 8.0),
        ("6 0 1 3 3 2 -1", 2.0),
    ],
)
def test_strips_of_a_ply_file_are_triangles(tmp_path: Path, strips: str, right: float) -> None:
    """Every other triangle of a strip is wound the other way; each strip begins anew; what repeats has no area."""
    mesh = ply(tmp_path, CORNERS, f"tristrips|list int int vertex_indices|{strips}")
    assert area(mesh) == right
    assert (doubled_areas(mesh.positions, mesh.faces)[:, 2] > 0).all()


def test_faces_and_strips_stand_in_one_file(tmp_path: Path) -> None:
    """Faces have their colours; strips have none, and are grey."""
    strips = "tristrips|list int int vertex_indices|3 1 2 3"
    mesh = ply(tmp_path, CORNERS, f"face|{FACES},uchar red,uchar green,uchar blue|3 0 1 3 255 0 0", strips)
    assert area(mesh) == 4.0
    assert np.allclose(color_at(mesh, -0.5, 0.5), [1, 0, 0]) and np.allclose(color_at(mesh, 0.5, 1.5), 0.8)


@pytest.mark.parametrize("kind", ["uchar", "ushort", "float"])
def test_colours_of_vertices_are_srgb_of_any_type(tmp_path: Path, kind: str) -> None:
    full = {"uchar": 255, "ushort": 65535, "float": 1.0}[kind]
    half = {"uchar": 127.5, "ushort": 32767.5, "float": 0.5}[kind]
    header = f"ply\nformat ascii 1.0\nelement vertex 3\n{''.join(f'property float {axis}' + chr(10) for axis in 'xyz')}"
    header += "".join(f"property {kind} diffuse_{shade}\n" for shade in ("red", "green", "blue"))
    rows = "".join(
        f"{place} {full} {half if kind == 'float' else int(half)} 0\n" for place in ("0 0 0", "1 0 0", "0 1 0")
    )
    (tmp_path / "m.ply").write_text(f"{header}element face 1\nproperty {FACES}\nend_header\n{rows}3 0 1 2\n")
    (mesh,) = load_model(tmp_path / "m.ply")
    assert mesh.colors is not None and diffuse(mesh).color == (1, 1, 1)
    assert np.allclose(mesh.colors, [1, GREY, 0], atol=4e-3)


def test_colours_of_polygons_stay_on_them(tmp_path: Path) -> None:
    mesh = ply(
        tmp_path,
        NOTCHED + ",-1 5 0,1 5 0",
        f"face|{FACES},uchar red,uchar green,uchar blue|8 0 1 2 3 4 5 6 7 255 0 0,4 3 2 9 8 0 0 255",
    )
    assert np.allclose(color_at(mesh, 0.8, 1.0), [1, 0, 0]) and np.allclose(color_at(mesh, 0.1, 4.0), [0, 0, 1])
    assert area(mesh) == pytest.approx(2.08 + 6.0)


@pytest.mark.parametrize("names", ["s t", "u v", "texture_u texture_v"])
def test_texture_coordinates_of_a_ply_file_stay_for_an_image_of_the_scene_file(tmp_path: Path, names: str) -> None:
    ply(tmp_path, "-1 0 0 0 0,1 0 0 1 0,1 2 0 1 1,-1 2 0 0 1", f"face|{FACES}|4 0 1 2 3", more=names)
    Image.new("RGB", (2, 2)).save(tmp_path / "paint.png")
    eye = "[eye]\nposition = [0, 1, 4]\ntarget = [0, 1, 0]\n"
    (tmp_path / "s.toml").write_text(f'{eye}[[model]]\nfile = "m.ply"\ndiffuse = {{ image = "paint.png" }}\n')
    (mesh,) = open_scene(tmp_path / "s.toml")[0].meshes
    assert mesh.texcoords is not None and diffuse(mesh).texture is not None
    assert np.allclose(mesh.texcoords, mesh.positions[:, :2] * (0.5, -0.5) + (0.5, 1))


def test_texture_coordinates_of_the_corners_of_faces_are_read(tmp_path: Path) -> None:
    """Each face has its own, at vertices that they share."""
    faces = f"face|{FACES},list uchar float texcoord|3 0 1 2 6 0 0 1 0 1 1,3 0 2 3 6 0.5 0 1 1 0.5 1"
    mesh = ply(tmp_path, CORNERS, faces)
    assert mesh.texcoords is not None and area(mesh) == 4.0
    found = {
        (tuple(place[:2]), tuple(at))
        for place, at in zip(mesh.positions.tolist(), mesh.texcoords.tolist(), strict=True)
    }
    assert found == {((-1, 0), (0, 1)), ((1, 0), (1, 1)), ((1, 2), (1, 0)), ((-1, 0), (0.5, 1)), ((-1, 2), (0.5, 0))}


def test_what_a_ply_file_has_besides_is_told(tmp_path: Path) -> None:
    with pytest.warns(AnamorphNote, match=r"m\.ply: its element 'edge' is left out"):
        ply(tmp_path, CORNERS, f"face|{FACES}|4 0 1 2 3", "edge|int vertex1,int vertex2|0 1")
    with pytest.warns(AnamorphNote, match=r"has no texture coordinates; its image 'paint\.png' is left out"):
        ply(tmp_path, CORNERS, f"face|{FACES}|4 0 1 2 3", comment="comment TextureFile paint.png\n")


def test_digits_of_a_ply_text_outlive_its_type_of_float(tmp_path: Path) -> None:
    mesh = ply(
        tmp_path, "432000.013 5350000.21 0,432001.013 5350000.21 0,432000.013 5350001.21 0", f"face|{FACES}|3 0 1 2"
    )
    assert mesh.positions[0] - (432000, 5350000, 0) == pytest.approx([0.013, 0.21, 0.0], abs=1e-6)


@pytest.mark.parametrize(
    ("entries", "words"),
    [
        ("3 0 1 7", "a face names vertex 7, but there are 4"),
        ("3 0 1 -1", "a face names vertex -1"),
        ("9 0 1 2", "it ends among its 1 entries of 'face'"),
        ("-3 0 1 2", "a list of 'face' has -3 entries"),
        ("3 0 x 2", "could not convert"),
    ],
)
def test_damaged_faces_of_a_ply_file_are_named(tmp_path: Path, entries: str, words: str) -> None:
    with pytest.raises(AnamorphError, match=words):
        ply(tmp_path, CORNERS, f"face|{FACES}|{entries}")


@given(st.sampled_from("<>"), st.sampled_from(["uchar", "ushort", "int"]), st.lists(st.integers(0, 5), max_size=8))
def test_binary_lists_of_any_lengths_come_back(order: str, counted: str, lengths: list[int]) -> None:
    """In both orders of bytes, with numbers before and after them; what is cut off is refused."""
    letter = {"uchar": "B", "ushort": "H", "int": "i"}[counted]
    lists = [list(range(row, row + length)) for row, length in enumerate(lengths)]
    body = b"".join(
        struct.pack(f"{order}h{letter}{len(own)}if", -row, len(own), *own, row / 2) for row, own in enumerate(lists)
    )
    kind = {"<": "little", ">": "big"}[order]
    header = f"ply\nformat binary_{kind}_endian 1.0\nelement vertex {len(lists)}\nproperty short before\n"
    header += f"property list {counted} int own\nproperty float after\nend_header\n"
    vertex = read_ply(header.encode() + body, Path("m.ply")).elements["vertex"]
    assert (
        vertex.lists["own"].values.tolist() == [number for own in lists for number in own]
        and vertex.lists["own"].counts.tolist() == lengths
    )
    assert vertex.numbers["before"].tolist() == [-row for row in range(len(lists))]
    assert vertex.numbers["after"].tolist() == [row / 2 for row in range(len(lists))]
    if body:
        with pytest.raises(AnamorphError, match="it ends among its"):
            read_ply(header.encode() + body[:-1], Path("m.ply"))


def stl(triangles: np.ndarray, header: bytes = b"", words: Sequence[int] | None = None) -> bytes:
    """A binary STL file; `words` are the two bytes after each triangle."""
    data = header.ljust(80, b"\0") + struct.pack("<I", len(triangles))
    for corners, word in zip(triangles, words or [0] * len(triangles), strict=True):
        data += struct.pack("<12fH", 0, 0, 0, *corners.reshape(-1), word)
    return data


TWO = SQUARE[[[0, 1, 2], [0, 2, 3]]]


@pytest.mark.parametrize("header", [b"", b"solid x", b"solid of vertex 1 2 3 endsolid"])
def test_bytes_after_the_last_triangle_are_told(tmp_path: Path, header: bytes) -> None:
    (tmp_path / "m.stl").write_bytes(stl(TWO, header) + b"trailer")
    with pytest.warns(AnamorphNote, match=r"m\.stl: has 7 bytes after its last triangle, which are left out"):
        (mesh,) = load_model(tmp_path / "m.stl")
    assert area(mesh) == 4.0


@pytest.mark.parametrize("header", [b"", b"solid x"])
def test_an_stl_file_that_is_cut_off_is_refused(tmp_path: Path, header: bytes) -> None:
    (tmp_path / "m.stl").write_bytes(stl(TWO, header)[:-20])
    with pytest.raises(AnamorphError, match=r"m\.stl: is damaged .*room for 1 of 2 triangles"):
        load_model(tmp_path / "m.stl")


def test_colours_of_viscam_and_of_magics_are_read(tmp_path: Path) -> None:
    red, half = 31, 15
    # VisCAM: bit 15 marks a colour, red in the high bits.
    (tmp_path / "v.stl").write_bytes(stl(TWO, words=[0x8000 | red << 10 | half << 5, red << 10]))
    (mesh,) = load_model(tmp_path / "v.stl")
    assert np.allclose(color_at(mesh, 0.5, 0.5), [1, GREY, 0], atol=0.02) and np.allclose(
        color_at(mesh, -0.5, 1.5), 0.8
    )
    # Magics: a colour for the whole, bit 15 marks what keeps to it, red in the low bits.
    header = b"COLOR=" + bytes([0, 255, 0, 255]) + b",MATERIAL="
    (tmp_path / "m.stl").write_bytes(stl(TWO, header, words=[red | half << 5, 0x8000 | red]))
    (mesh,) = load_model(tmp_path / "m.stl")
    assert np.allclose(color_at(mesh, 0.5, 0.5), [1, GREY, 0], atol=0.02) and np.allclose(
        color_at(mesh, -0.5, 1.5), [0, 1, 0]
    )
    # Numbers that mark nothing are no colours.
    (tmp_path / "n.stl").write_bytes(stl(TWO, words=[1234, 5]))
    (mesh,) = load_model(tmp_path / "n.stl")
    assert mesh.colors is None


def test_solids_of_a_text_are_parts(tmp_path: Path) -> None:
    facet = "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  VERTEX 1 0 0\n  vertex 0 1e0 0\n endloop\nendfacet\n"
    (tmp_path / "m.stl").write_text(f"solid one mirror\n{facet}endsolid one mirror\nsolid\n{facet}{facet}endsolid\n")
    one, two = load_model(tmp_path / "m.stl")
    assert (one.name, area(one)) == ("one mirror", 0.5) and (two.name, area(two)) == ("m", 1.0)
    (tmp_path / "m.stl").write_text(f"solid alone\n{facet}endsolid\n")
    assert [mesh.name for mesh in load_model(tmp_path / "m.stl")] == ["m"]


@pytest.mark.parametrize(
    ("old", "new", "words"), [("1 0 0", "1 0 q", "could not"), ("vertex 0 0 0", "", "three corners")]
)
def test_a_damaged_text_is_named(tmp_path: Path, old: str, new: str, words: str) -> None:
    facet = "facet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    (tmp_path / "m.stl").write_text(f"solid a\n{facet.replace(old, new)}endsolid a\n")
    with pytest.raises(AnamorphError, match=rf"m\.stl: is damaged or no STL file \(.*{words}"):
        load_model(tmp_path / "m.stl")
