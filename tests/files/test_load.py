"""Model files: what was written comes back right in place, colour and orientation; what is damaged is refused."""

from __future__ import annotations

import base64
import json
import logging
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from anamorph.base.errors import AnamorphError
from anamorph.files.models import load_model, load_parts
from anamorph.files.normals import creased
from anamorph.files.opening import open_scene
from anamorph.scene.model import Diffuse, Mesh
from anamorph.scene.triangles import has_area

SAMPLES = Path("/usr/share/assimp/models")
needs_samples = pytest.mark.skipif(not SAMPLES.is_dir(), reason="Debian's assimp-testmodels is not installed")

# Seen from +z: red top left, green top right, blue bottom left, white bottom right.
PIXELS = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [255, 255, 255]]], np.uint8)
CORNERS = np.array([[-1, 1, 0], [1, 1, 0], [-1, -1, 0], [1, -1, 0]], float)
SHADES = {(-1, 1): (255, 0, 0), (1, 1): (0, 255, 0), (-1, -1): (0, 0, 255), (1, -1): (255, 255, 255)}


def linear(srgb: float) -> float:
    return srgb / 12.92 if srgb <= 0.04045 else ((srgb + 0.055) / 1.055) ** 2.4


def diffuse(mesh: Mesh) -> Diffuse:
    assert isinstance(mesh.material, Diffuse)
    return mesh.material


def image_bytes(folder: Path) -> bytes:
    Image.fromarray(PIXELS).save(folder / "four.png")
    return (folder / "four.png").read_bytes()


def gltf(folder: Path, name: str, **changes: Any) -> Path:
    """A square in a .gltf file with everything inside; `changes` replace entries of the header."""
    uv = np.array([[0, 0], [1, 0], [0, 1], [1, 1]], "<f4")
    blobs = [
        CORNERS.astype("<f4").tobytes(),
        uv.tobytes(),
        np.array([0, 2, 1, 1, 2, 3], "<u2").tobytes(),
        np.array([[65535, 0, 0], [0, 32768, 0], [0, 0, 65535], [65535, 65535, 65535]], "<u2").tobytes(),
        image_bytes(folder),
    ]
    views, at = [], 0
    for blob in blobs:
        views.append({"buffer": 0, "byteOffset": at, "byteLength": len(blob)})
        at += len(blob)
    data = b"".join(blobs)
    header: dict[str, Any] = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "sign"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
        "materials": [
            {
                "name": "paint",
                "pbrMetallicRoughness": {"baseColorFactor": [0.001, 0.5, 1.0, 1.0], "baseColorTexture": {"index": 0}},
            }
        ],
        "textures": [{"source": 0}],
        "images": [{"bufferView": 4, "mimeType": "image/png"}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
            {"bufferView": 3, "componentType": 5123, "normalized": True, "count": 4, "type": "VEC3"},
        ],
        "bufferViews": views,
        "buffers": [
            {"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}
        ],
    }
    header.update(changes)
    path = folder / name
    path.write_text(json.dumps(header))
    return path


def glb(folder: Path) -> Path:
    square = trimesh.Trimesh(CORNERS, [[0, 2, 1], [1, 2, 3]], process=False)
    uv = (CORNERS[:, :2] + 1) / 2
    material = trimesh.visual.material.PBRMaterial(baseColorTexture=Image.fromarray(PIXELS))
    square.visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
    path = folder / "square.glb"
    trimesh.Scene({"square": square}).export(path)
    return path


OBJ = (
    "mtllib square.mtl\nusemtl paint\nv -1 1 0\nv 1 1 0\nv -1 -1 0\nv 1 -1 0\n"
    "vt 0 1\nvt 1 1\nvt 0 0\nvt 1 0\nf 1/1 3/3 2/2\nf 2/2 3/3 4/4\n"
)


def obj(folder: Path) -> Path:
    image_bytes(folder)
    (folder / "square.mtl").write_text("newmtl paint\nKd 1 1 1\nmap_Kd .\\four.png\n")
    (folder / "square.obj").write_text(OBJ)
    return folder / "square.obj"


def ply(folder: Path) -> Path:
    image_bytes(folder)
    lines = ["ply", "format ascii 1.0", "comment TextureFile four.png", "element vertex 4"]
    lines += [f"property float {name}" for name in ("x", "y", "z", "s", "t")]
    lines += ["element face 2", "property list uchar int vertex_indices", "end_header"]
    lines += [f"{x} {y} {z} {(x + 1) / 2} {(y + 1) / 2}" for x, y, z in CORNERS]
    (folder / "square.ply").write_text("\n".join([*lines, "3 0 2 1", "3 1 2 3", ""]))
    return folder / "square.ply"


@pytest.mark.parametrize("make", [glb, obj, ply, lambda folder: gltf(folder, "square.gltf")])
def test_an_image_is_the_right_way_up_and_round(tmp_path: Path, make: Any) -> None:
    (mesh,) = load_model(make(tmp_path))
    texture = diffuse(mesh).texture
    assert texture is not None and mesh.texcoords is not None
    for (x, y), shade in SHADES.items():
        vertex = np.flatnonzero((mesh.positions[:, :2] == (x, y)).all(axis=1))[0]
        # A texture coordinate just inside the corner, looked up from the top left.
        u, v = 0.98 * (mesh.texcoords[vertex] - 0.5) + 0.5
        height, width = texture.pixels.shape[:2]
        assert tuple(texture.pixels[int(v * height), int(u * width), :3]) == shade
    assert np.allclose(mesh.normals, [0, 0, 1])


def test_gltf_colours_are_exact_and_linear(tmp_path: Path) -> None:
    (part,) = load_parts(gltf(tmp_path, "a.gltf"))
    assert (part.mesh.name, part.material) == ("sign", "paint")
    assert diffuse(part.mesh).color == (0.001, 0.5, 1.0)


def test_gltf_vertex_colours_are_linear_with_and_without_a_material(tmp_path: Path) -> None:
    attributes = {"POSITION": 0, "TEXCOORD_0": 1, "COLOR_0": 3}
    for number, material in enumerate([{"material": 0}, {}]):
        path = gltf(
            tmp_path, f"{number}.gltf", meshes=[{"primitives": [{"attributes": attributes, "indices": 2, **material}]}]
        )
        (mesh,) = load_model(path)
        assert mesh.colors is not None
        green = mesh.colors[(mesh.positions == CORNERS[1]).all(axis=1)]
        assert np.allclose(green, [0, 0.5, 0], atol=1 / 255)


def test_gltf_texture_transforms_and_second_coordinates_are_applied(tmp_path: Path) -> None:
    transform = {"offset": [0.25, 0.5], "scale": [2.0, 3.0], "rotation": np.pi / 2, "texCoord": 1}
    texture = {"index": 0, "extensions": {"KHR_texture_transform": transform}}
    path = gltf(
        tmp_path,
        "a.gltf",
        extensionsRequired=["KHR_texture_transform"],
        materials=[{"pbrMetallicRoughness": {"baseColorTexture": texture}}],
        meshes=[{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_1": 1}, "indices": 2, "material": 0}]}],
    )
    (mesh,) = load_model(path)
    assert mesh.texcoords is not None
    # (u, v) is scaled, then turned by a quarter: u takes v's place, v takes -u's; then moved.
    for corner, (u, v) in zip(CORNERS, [(0, 0), (1, 0), (0, 1), (1, 1)], strict=True):
        found = mesh.texcoords[(mesh.positions == corner).all(axis=1)]
        assert np.allclose(found, [3 * v + 0.25, -2 * u + 0.5], atol=1e-6)


def test_gltf_transforms_nest_and_mirrored_parts_keep_their_outside(tmp_path: Path) -> None:
    nodes = [
        {"name": "wheel", "mesh": 0, "scale": [-2, 1, 1], "translation": [5, 0, 0]},
        {"name": "wheel", "children": [0], "rotation": [0, 2**-0.5, 0, 2**-0.5]},
        {"mesh": 0},
    ]
    path = gltf(tmp_path, "a.gltf", nodes=nodes, scenes=[{"nodes": [1, 2]}])
    turned, plain = load_model(path, scale=0.5)
    assert (turned.name, plain.name) == ("wheel", "part")
    # Scaled by -2 in x, moved to x = 5, turned from x to -z and from z to x, halved.
    assert np.allclose(turned.positions.min(axis=0), [0, -0.5, -3.5], atol=1e-6)
    assert np.allclose(turned.positions.max(axis=0), [0, 0.5, -1.5], atol=1e-6)
    for mesh, outside in ((turned, (1, 0, 0)), (plain, (0, 0, 1))):
        corners = mesh.positions[mesh.faces]
        assert np.allclose(mesh.normals, outside, atol=1e-6)
        assert (np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) @ outside > 0).all()


def test_normals_of_a_stretched_slope_stay_perpendicular(tmp_path: Path) -> None:
    slope = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 1]], [[0, 1, 2]], process=False)
    assert slope.vertex_normals is not None
    scene = trimesh.Scene()
    scene.add_geometry(slope, transform=np.diag([1.0, 4.0, 1.0, 1.0]))
    (tmp_path / "slope.glb").write_bytes(trimesh.exchange.gltf.export_glb(scene, include_normals=True))
    (mesh,) = load_model(tmp_path / "slope.glb")
    assert np.allclose(mesh.positions.max(axis=0), [1, 4, 1])
    assert np.allclose(mesh.normals, np.array([0, -1, 4]) / np.sqrt(17), atol=1e-6)


def test_parts_of_one_name_are_numbered_and_always_in_one_order(tmp_path: Path) -> None:
    primitive = {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2}
    path = gltf(
        tmp_path,
        "a.gltf",
        nodes=[{"mesh": 0}, {"mesh": 0, "translation": [9, 0, 0]}],
        scenes=[{"nodes": [1, 0]}],
        meshes=[{"name": "car", "primitives": [primitive, {**primitive, "material": 0}]}],
    )
    parts = load_parts(path)
    assert [part.mesh.name for part in parts] == ["car", "car-2", "car-3", "car-4"]
    assert [part.material for part in parts] == ["", "paint", "", "paint"]
    assert [part.mesh.positions[:, 0].max() for part in parts] == [1, 1, 10, 10]


def test_kd_and_vertex_colours_of_obj_and_ply_are_srgb(tmp_path: Path) -> None:
    (tmp_path / "m.mtl").write_text("newmtl red\nKd 0.5 0.25 0\n")
    (tmp_path / "m.obj").write_text("mtllib m.mtl\no door\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (part,) = load_parts(tmp_path / "m.obj")
    assert (part.mesh.name, part.material) == ("door", "red")
    assert np.allclose(diffuse(part.mesh).color, [linear(0.5), linear(0.25), 0])

    triangle = trimesh.Trimesh(np.eye(3), [[0, 1, 2]], vertex_colors=[[128, 0, 0, 255]] * 3, process=False)
    triangle.export(tmp_path / "m.ply")
    (mesh,) = load_model(tmp_path / "m.ply")
    assert mesh.name == "m" and mesh.colors is not None and diffuse(mesh).color == (1.0, 1.0, 1.0)
    assert np.allclose(mesh.colors, [linear(128 / 255), 0, 0], atol=1e-6)


def test_face_colours_stay_on_their_faces(tmp_path: Path) -> None:
    square = trimesh.Trimesh(CORNERS, [[0, 2, 1], [1, 2, 3]], face_colors=[[255, 0, 0, 255], [0, 0, 255, 255]])
    square.export(tmp_path / "m.ply")
    (mesh,) = load_model(tmp_path / "m.ply")
    assert mesh.colors is not None
    for face, shade in zip(mesh.faces, [(1, 0, 0), (0, 0, 1)], strict=True):
        assert np.allclose(mesh.colors[face], shade)
    assert np.allclose(mesh.normals, [0, 0, 1])


def test_units_and_place_of_an_stl_file(tmp_path: Path) -> None:
    trimesh.creation.box((100, 200, 300)).export(tmp_path / "box.stl")
    (mesh,) = load_model(tmp_path / "box.stl", scale=0.001)
    assert mesh.name == "box" and len(mesh.faces) == 12
    assert np.allclose(np.ptp(mesh.positions, axis=0), [0.1, 0.2, 0.3], atol=1e-6)
    # A box stays sharp: each corner has its face's normal.
    corners = mesh.positions[mesh.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    assert np.allclose(mesh.normals[mesh.faces], normal[:, None], atol=1e-5)


def test_a_model_in_map_coordinates_alone_is_as_sharp_as_one_at_the_origin(tmp_path: Path) -> None:
    box = trimesh.creation.box((1.0, 2.0, 3.0))
    box.export(tmp_path / "near.obj")
    box.apply_translation((5e5, 120.0, 4e6))
    box.export(tmp_path / "far.obj", digits=10)
    scenes = [open_scene(tmp_path / f"{name}.obj")[0] for name in ("near", "far")]
    assert [mesh.name for mesh in scenes[1].meshes][:3] == ["mirror", "mirror-plate", "ground"]
    for near, far in zip(*(scene.meshes[:3] for scene in scenes), strict=True):
        assert far.positions == pytest.approx(near.positions, abs=1e-5)
    assert np.ptp(scenes[1].meshes[3].positions, axis=0) == pytest.approx([1.0, 2.0, 3.0], abs=1e-5)
    assert np.abs(load_model(tmp_path / "far.obj")[0].positions).max() > 1e6


def test_a_part_of_a_scene_file_that_is_far_away_is_named_with_the_remedy(tmp_path: Path) -> None:
    trimesh.creation.box((1.0, 2.0, 3.0)).apply_translation((5e5, 120.0, 4e6)).export(tmp_path / "tower.obj")
    text = '[[model]]\nfile = "tower.obj"\n[eye]\nposition = [500000, 120, 3999990]\ntarget = [500000, 120, 4000000]\n'
    (tmp_path / "town.toml").write_text(text)
    with pytest.raises(AnamorphError, match=r"town\.toml: part 'tower': is 3 m large and 4e\+06 m .*translate"):
        open_scene(tmp_path / "town.toml")


def test_old_text_encodings_are_read(tmp_path: Path) -> None:
    text = "# häuschen\no tür\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    for encoding in ("utf-8", "utf-8-sig", "utf-16", "latin-1"):
        (tmp_path / "m.obj").write_bytes(text.encode(encoding))
        assert [mesh.name for mesh in load_model(tmp_path / "m.obj")] == ["tür"]


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian"])
def test_a_ply_header_in_an_old_encoding_is_read_and_its_numbers_kept(tmp_path: Path, form: str) -> None:
    data = ply(tmp_path).read_bytes()
    if form != "ascii":
        data = trimesh.exchange.ply.export_ply(trimesh.creation.box())
    header = b"ply\nformat " + form.encode() + b" 1.0\n"
    assert data.startswith(header)
    (tmp_path / "m.ply").write_bytes(header + "comment Gehäuse\n".encode("latin-1") + data[len(header) :])
    (mesh,) = load_model(tmp_path / "m.ply")
    assert np.abs(mesh.positions).max() == (1.0 if form == "ascii" else 0.5)


def test_a_text_stl_in_an_old_encoding_is_read_and_a_binary_one_may_be_called_solid(tmp_path: Path) -> None:
    box = trimesh.creation.box()
    text = box.export(file_type="stl_ascii").replace("solid", "solid Gehäuse", 1).encode("latin-1")
    binary = b"solid G\xe4" + box.export(file_type="stl")[8:]
    for data in (text, binary):
        (tmp_path / "m.stl").write_bytes(data)
        (mesh,) = load_model(tmp_path / "m.stl")
        assert len(mesh.faces) == 12


def test_zero_normals_in_a_file_are_replaced(tmp_path: Path) -> None:
    lines = "v -1 1 0\nv 1 1 0\nv -1 -1 0\nvn 0 0 0\nvn 0 0 2\nf 1//1 3//2 2//2\n"
    (tmp_path / "m.obj").write_text(lines)
    (mesh,) = load_model(tmp_path / "m.obj")
    assert np.allclose(mesh.normals, [0, 0, 1])


def test_normals_against_the_winding_are_negated(tmp_path: Path) -> None:
    """The winding says which side is outside."""
    (tmp_path / "m.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 -1\nf 1//1 2//1 3//1\n")
    (mesh,) = load_model(tmp_path / "m.obj")
    assert np.allclose(mesh.normals, [0, 0, 1])


def test_degenerate_triangles_are_dropped(tmp_path: Path) -> None:
    (tmp_path / "m.obj").write_text("v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 4\nf 1 1 4\n")
    (mesh,) = load_model(tmp_path / "m.obj")
    assert len(mesh.faces) == 1 and len(mesh.positions) == 3


def spherical(rings: int, sectors: int) -> tuple[np.ndarray, np.ndarray]:
    sphere = trimesh.creation.uv_sphere(count=[rings, sectors])
    return np.asarray(sphere.vertices), np.asarray(sphere.faces)


def test_computed_normals_are_smooth_on_a_sphere_even_as_triangle_soup() -> None:
    vertices, faces = spherical(24, 24)
    soup = vertices[faces].reshape(-1, 3)
    source, triangles, normals = creased(soup, np.arange(len(soup)).reshape(-1, 3))
    assert np.einsum("nk,nk->n", normals, soup[source]).min() > np.cos(np.radians(1.5))
    assert np.array_equal(soup[source][triangles], soup.reshape(-1, 3, 3))


def test_the_crease_decides_between_smooth_and_sharp() -> None:
    bend = np.radians(30)
    vertices = np.array([[0, 0, 0], [0, 1, 0], [1, 0, 0], [-np.cos(bend), 0, -np.sin(bend)]])
    faces = np.array([[0, 2, 1], [0, 1, 3]])
    assert len(creased(vertices, faces, crease=40)[2]) == 4
    _, triangles, normals = creased(vertices, faces, crease=20)
    assert len(normals) == 6
    assert np.allclose(normals[triangles[0]], [0, 0, 1])


coordinate = st.sampled_from([0.0, 1.0, -1.0, 0.5, 1e-7])
soup = st.lists(st.tuples(*[coordinate] * 9), min_size=1, max_size=12)


@given(soup)
def test_computed_normals_are_units_whatever_the_triangles(triangles: list[tuple[float, ...]]) -> None:
    positions = np.array(triangles).reshape(-1, 3)
    faces = np.arange(len(positions)).reshape(-1, 3)
    faces = faces[has_area(positions, faces)]
    source, copies, normals = creased(positions, faces)
    assert np.allclose(np.linalg.norm(normals, axis=1), 1.0) or not len(normals)
    assert np.array_equal(source[copies], faces)


def damaged(folder: Path) -> dict[str, tuple[Path, str]]:
    """Every kind of file that cannot be shown, and what the message must say."""

    def file(name: str, data: bytes | str) -> Path:
        (folder / name).write_bytes(data.encode() if isinstance(data, str) else data)
        return folder / name

    whole = glb(folder).read_bytes()
    header = json.loads(gltf(folder, "whole.gltf").read_text())
    triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    properties = "".join(f"property float {name}\n" for name in "xyz")
    points = f"ply\nformat ascii 1.0\nelement vertex 1\n{properties}end_header\n0 0 0\n"
    broken_image = [{"uri": "data:image/png;base64," + base64.b64encode(b"no image").decode()}]
    return {
        "missing": (folder / "none.glb", "no such model file"),
        "folder": (folder, "is no known model"),
        "suffix": (file("a.gltff", ""), "did you mean '.gltf'"),
        "cut off": (file("a.glb", whole[: len(whole) // 2]), "cut off"),
        "empty glb": (file("b.glb", b""), "damaged or not glTF"),
        "garbage glb": (file("c.glb", bytes(range(256))), "damaged or not glTF"),
        "no json": (file("a.gltf", "{"), "damaged or not glTF"),
        "version 1": (file("b.gltf", '{"asset": {"version": "1.0"}}'), "another version"),
        "no buffer": (gltf(folder, "c.gltf", buffers=[{"byteLength": 9, "uri": "lost.bin"}]), "'lost.bin'"),
        "no image": (gltf(folder, "d.gltf", images=[{"uri": "lost%20one.png"}]), "'lost%20one.png'"),
        "image": (gltf(folder, "e.gltf", images=broken_image), "image of material 'paint'"),
        "draco": (gltf(folder, "f.gltf", extensionsRequired=["KHR_draco_mesh_compression"]), "without compression"),
        "index": (gltf(folder, "g.gltf", nodes=[{"mesh": 7}]), "header is damaged"),
        "faces": (
            gltf(
                folder,
                "h.gltf",
                accessors=[*header["accessors"][:2], {**header["accessors"][3], "count": 3, "type": "SCALAR"}],
            ),
            "a face names vertex 65535, but there are 4",
        ),
        "infinite": (gltf(folder, "i.gltf", nodes=[{"mesh": 0, "scale": [1e300, 1, 1]}]), "infinite"),
        "no faces": (file("a.obj", "v 0 0 0\n"), "no triangles"),
        "empty obj": (file("b.obj", ""), "no triangles"),
        "no vertex": (file("c.obj", "v 0 0 0\nf 1 2 3\n"), "damaged"),
        "flat": (file("d.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"), "no triangles with an area"),
        "nan": (file("e.obj", triangle.replace("v 1", "v nan")), "vertex 1 has a NaN"),
        "no mtl": (file("f.obj", "mtllib lost.mtl\n" + triangle), "'lost.mtl'"),
        "no texture": (
            file("g.obj", OBJ.replace("square.mtl", file("g.mtl", "newmtl paint\nmap_Kd lost.png\n").name)),
            "'lost.png'",
        ),
        "bad texture": (
            file(
                "h.obj",
                OBJ.replace("square.mtl", file("h.mtl", f"newmtl paint\nmap_Kd {file('x.png', 'x').name}\n").name),
            ),
            "x.png: is not an image",
        ),
        "half texture": (
            file(
                "i.obj", OBJ.replace("square.mtl", file("i.mtl", f"newmtl paint\nmap_Kd {half_image(folder)}\n").name)
            ),
            "half.png: this image is damaged",
        ),
        "points": (file("a.ply", points), "no triangles"),
        "cut ply": (file("b.ply", trimesh.creation.box().export(file_type="ply")[:400]), "damaged or no PLY"),
        "ply texture": (file("d.ply", ply(folder).read_text().replace("four", "lost")), "'lost.png'"),
        "garbage ply": (file("c.ply", b"\x00\x01"), "damaged or no PLY"),
        "empty stl": (file("a.stl", b""), "a.stl"),
        "garbage stl": (file("b.stl", b"\x00" * 90), "b.stl"),
    }


def half_image(folder: Path) -> str:
    Image.effect_noise((64, 64), 50).save(folder / "full.png")
    (folder / "half.png").write_bytes((folder / "full.png").read_bytes()[:1000])
    return "half.png"


KINDS = """missing|folder|suffix|cut off|empty glb|garbage glb|no json|version 1|no buffer|no image|image|draco|index
faces|infinite|no faces|empty obj|no vertex|flat|nan|no mtl|no texture|bad texture|half texture|points|cut ply
ply texture|garbage ply|empty stl|garbage stl""".replace("\n", "|").split("|")


@pytest.mark.parametrize("kind", KINDS)
def test_a_damaged_file_gives_one_line_and_no_noise(
    tmp_path: Path, kind: str, capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    path, words = damaged(tmp_path)[kind]
    caplog.clear()
    capfd.readouterr()
    with pytest.raises(AnamorphError) as caught:
        load_model(path)
    message = str(caught.value)
    assert message.startswith(str(tmp_path)) and words in message and "\n" not in message and len(message) < 400
    assert capfd.readouterr() == ("", "") and not caplog.records
    assert logging.getLogger("trimesh").level == logging.NOTSET


def test_every_kind_of_damage_is_tried(tmp_path: Path) -> None:
    assert list(damaged(tmp_path)) == KINDS


@pytest.mark.parametrize("scale", [0.0, -1.0, float("nan"), float("inf")])
def test_a_scale_that_is_none_is_refused(tmp_path: Path, scale: float) -> None:
    with pytest.raises(AnamorphError, match="scale"):
        load_model(obj(tmp_path), scale)


def test_a_glb_header_survives_being_taken_apart(tmp_path: Path) -> None:
    whole = glb(tmp_path).read_bytes()
    length = struct.unpack("<I", whole[12:16])[0]
    json_chunk = json.loads(whole[20 : 20 + length])
    assert [mesh.name for mesh in load_model(tmp_path / "square.glb")] == [json_chunk["nodes"][-1]["name"]]


@needs_samples
@pytest.mark.parametrize(
    ("name", "parts", "triangles", "extents", "textures"),
    [
        ("glTF2/BoxTextured-glTF-Binary/BoxTextured.glb", 1, 12, (1, 1, 1), 1),
        ("glTF2/BoxTextured-glTF/BoxTextured.gltf", 1, 12, (1, 1, 1), 1),
        ("glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb", 115, 110336, (743.384, 273.013, 268), 0),
        ("OBJ/spider.obj", 19, 1312, (150.592, 79.738, 193.382), 19),
        ("OBJ/regr01.obj", 55, 2706, (1636.285, 1172.127, 337.509), 0),
        ("PLY/Wuson.ply", 1, 3732, (0.91995, 1.51582, 3.24439), 0),
        ("STL/Spider_binary.stl", 1, 1312, (6.22979, 8, 3.29866), 0),
        ("PLY/cube_uv.ply", 1, 12, (2, 2, 2), 0),
        ("glTF2/textureTransform/TextureTransformTest.gltf", 12, 24, (3.2, 2.191268, 0.01), 12),
        ("STL/Spider_ascii.stl", 1, 1312, (6.22979, 8, 3.29866), 0),
    ],
)
def test_models_that_others_made(
    name: str, parts: int, triangles: int, extents: tuple[float, ...], textures: int
) -> None:
    meshes = load_model(SAMPLES / name)
    positions = np.concatenate([mesh.positions for mesh in meshes])
    assert len(meshes) == parts and len({mesh.name for mesh in meshes}) == parts
    assert sum(len(mesh.faces) for mesh in meshes) == triangles
    assert np.allclose(np.ptp(positions, axis=0), extents, rtol=1e-4)
    assert sum(diffuse(mesh).texture is not None for mesh in meshes) == textures
    for mesh in meshes:
        assert np.allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-5)


@needs_samples
def test_the_same_model_in_two_formats_has_one_shape() -> None:
    triangles = []
    for name in ("OBJ/WusonOBJ.obj", "STL/Wuson.stl", "PLY/Wuson.ply"):
        (mesh,) = load_model(SAMPLES / name)
        triangles.append(np.sort(np.round(mesh.positions[mesh.faces].mean(axis=1), 3), axis=0))
    assert np.allclose(triangles[0], triangles[1], atol=2e-3) and np.allclose(triangles[1], triangles[2], atol=2e-3)
