"""glTF files: numbers, shapes, places and looks are those of the specification, and what is not read is said."""

from __future__ import annotations

import base64
import io
import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from anamorph.base.errors import AnamorphError
from anamorph.base.notes import AnamorphNote
from anamorph.files.gltf.primitives import TRIANGLE_FAN, TRIANGLE_STRIP, faces_of
from anamorph.files.models import load_model, load_parts
from anamorph.files.opening import open_scene
from anamorph.scene.model import Diffuse, Glass, Material, Mesh, Mirror

SQUARE = np.array([[-1, 0, 0], [1, 0, 0], [1, 2, 0], [-1, 2, 0]], "<f4")
CORNERS = np.array([0, 1, 2, 0, 2, 3], "<u2")
KINDS = {(): "SCALAR", (2,): "VEC2", (3,): "VEC3", (4,): "VEC4", (4, 4): "MAT4"}
CODES = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}


def packed(*arrays: np.ndarray) -> dict[str, Any]:
    """Buffer, views and accessors that hold arrays, each under its place in the list."""
    data, views, accessors = b"", [], []
    for number, array in enumerate(arrays):
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes})
        code = CODES[array.dtype.str[1:]]
        accessors.append(
            {"bufferView": number, "componentType": code, "count": len(array), "type": KINDS[array.shape[1:]]}
        )
        data += array.tobytes() + bytes(-array.nbytes % 4)
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    return {"buffers": [{"byteLength": len(data), "uri": uri}], "bufferViews": views, "accessors": accessors}


def header(*arrays: np.ndarray, **changes: Any) -> dict[str, Any]:
    """A glTF header with one node, whose mesh has the first array as positions and the second as indices."""
    primitive = {"attributes": {"POSITION": 0}, "indices": 1}
    plain: dict[str, Any] = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "q"}],
        "meshes": [{"primitives": [primitive]}],
        **packed(*arrays),
    }
    return {**plain, **changes}


def written(folder: Path, content: dict[str, Any]) -> Path:
    (folder / "m.gltf").write_text(json.dumps(content))
    return folder / "m.gltf"


def one(folder: Path, content: dict[str, Any]) -> Mesh:
    (mesh,) = load_model(written(folder, content))
    return mesh


def corners(mesh: Mesh) -> list[tuple[float, ...]]:
    return sorted(tuple(row) for row in np.round(mesh.positions, 6).tolist())


def sorted_rows(rows: np.ndarray) -> list[tuple[float, ...]]:
    return sorted(tuple(row) for row in np.asarray(rows, float).tolist())


def test_a_sparse_accessor_replaces_what_it_names(tmp_path: Path) -> None:
    content = header(SQUARE, CORNERS, np.array([1, 2], "<u2"), np.array([[2, 0, 0], [2, 2, 0]], "<f4"))
    content["accessors"][0]["sparse"] = {
        "count": 2,
        "indices": {"bufferView": 2, "componentType": 5123},
        "values": {"bufferView": 3},
    }
    assert corners(one(tmp_path, content)) == [(-1, 0, 0), (-1, 2, 0), (2, 0, 0), (2, 2, 0)]


def test_a_sparse_accessor_without_a_view_replaces_zeros(tmp_path: Path) -> None:
    content = header(SQUARE, CORNERS, np.array([1, 2, 3], "u1"), SQUARE[1:])
    del content["accessors"][0]["bufferView"]
    content["accessors"][0]["sparse"] = {
        "count": 3,
        "indices": {"bufferView": 2, "componentType": 5121},
        "values": {"bufferView": 3},
    }
    assert corners(one(tmp_path, content)) == [(-1, 2, 0), (0, 0, 0), (1, 0, 0), (1, 2, 0)]


def test_elements_a_stride_apart_and_integers_that_stand_for_fractions(tmp_path: Path) -> None:
    rows = np.zeros((4, 4), "<i2")
    rows[:, :3] = np.array([[-32767, 0, 0], [32767, 0, 0], [32767, 16384, 0], [-32768, 16384, 0]])
    content = header(SQUARE, CORNERS, rows)
    content["bufferViews"][2]["byteStride"] = 8
    content["accessors"][0] = {
        "bufferView": 2, "componentType": 5122, "count": 4, "type": "VEC3", "normalized": True,
    }  # fmt: skip
    half = 16384 / 32767
    assert np.allclose(corners(one(tmp_path, content)), [(-1, 0, 0), (-1, half, 0), (1, 0, 0), (1, half, 0)], atol=1e-6)


AROUND = np.array([[0, 0, 0], [1, 0, 0], [0.5, 1, 0], [-0.5, 1, 0], [-1, 0, 0]], "<f4")


def test_a_fan_beside_triangles_fills_its_polygon(tmp_path: Path) -> None:
    fan = {"attributes": {"POSITION": 2}, "mode": TRIANGLE_FAN}
    meshes = [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}, fan]}]
    square, disc = load_model(written(tmp_path, header(SQUARE, CORNERS, AROUND, meshes=meshes)))
    assert [area(mesh) for mesh in (square, disc)] == pytest.approx([4.0, 1.5])
    assert np.allclose(disc.normals, [0, 0, 1])


def area(mesh: Mesh) -> float:
    return float(trimesh.Trimesh(mesh.positions, mesh.faces, process=False).area)


@pytest.mark.parametrize("indexed", [False, True])
def test_a_strip_is_wound_as_its_first_triangle(tmp_path: Path, indexed: bool) -> None:
    zigzag = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 2, 0], [1, 2, 0]], "<f4")
    order = np.array([5, 4, 3, 2, 1, 0], "u1")
    strip = {"attributes": {"POSITION": 0}, "mode": TRIANGLE_STRIP, **({"indices": 1} if indexed else {})}
    mesh = one(tmp_path, header(zigzag, order, meshes=[{"primitives": [strip]}]))
    assert len(mesh.faces) == 4 and area(mesh) == pytest.approx(2.0)
    assert np.allclose(mesh.normals, [0, 0, 1])


@given(st.sampled_from([TRIANGLE_STRIP, TRIANGLE_FAN]), st.integers(0, 12))
def test_strips_and_fans_share_each_inner_edge_in_opposite_directions(mode: int, count: int) -> None:
    faces = faces_of(mode, np.arange(count))
    assert faces.shape == (max(count - 2, 0), 3)
    edges = [(int(a), int(b)) for face in faces for a, b in zip(face, np.roll(face, -1), strict=True)]
    assert len(set(edges)) == len(edges)
    assert sum((b, a) in edges for a, b in edges) == 2 * max(count - 3, 0)


@pytest.mark.parametrize("missing", [{"scenes": []}, {"scenes": None}])
def test_a_file_without_a_scene_shows_all_that_it_holds(tmp_path: Path, missing: dict[str, Any]) -> None:
    nodes = [{"mesh": 0, "translation": [0, 0, 5]}, {"children": [0], "translation": [1, 0, 0]}, {"mesh": 0}]
    content = header(SQUARE, CORNERS, nodes=nodes, **missing)
    if missing["scenes"] is None:
        del content["scenes"]
    moved, plain = load_model(written(tmp_path, content))
    assert corners(moved) == sorted_rows(np.add(SQUARE, (1, 0, 5))) and corners(plain) == sorted_rows(SQUARE)


def test_of_several_scenes_the_files_own_is_shown_and_said(tmp_path: Path) -> None:
    nodes = [{"mesh": 0, "name": "first"}, {"mesh": 0, "name": "second"}]
    content = header(SQUARE, CORNERS, nodes=nodes, scenes=[{"nodes": [0]}, {"nodes": [1]}], scene=1)
    with pytest.warns(AnamorphNote, match=r"m\.gltf: has 2 scenes, of which number 1 is shown"):
        assert one(tmp_path, content).name == "second"


def test_hidden_nodes_are_not_shown(tmp_path: Path) -> None:
    hidden = {"children": [1], "extensions": {"KHR_node_visibility": {"visible": False}}}
    nodes = [{"mesh": 0, "name": "shown"}, {"mesh": 0}, hidden]
    assert one(tmp_path, header(SQUARE, CORNERS, nodes=nodes, scenes=[{"nodes": [0, 2]}])).name == "shown"


MOVED = np.array([[0, 0, 0], [0, 0, 0], [0, 2, 0], [0, 2, 0]], "<f4")


@pytest.mark.parametrize(
    ("mesh_weights", "node_weights", "top"),
    [([1.0], None, 4.0), (None, [0.5], 3.0), ([1.0], [0.0], 2.0), (None, None, 2)],
)
def test_morph_weights_are_applied(tmp_path: Path, mesh_weights: Any, node_weights: Any, top: float) -> None:
    primitive = {"attributes": {"POSITION": 0}, "indices": 1, "targets": [{"POSITION": 2}]}
    mesh = {"primitives": [primitive], **({"weights": mesh_weights} if mesh_weights else {})}
    node = {"mesh": 0, **({"weights": node_weights} if node_weights else {})}
    shown = one(tmp_path, header(SQUARE, CORNERS, MOVED, meshes=[mesh], nodes=[node]))
    assert shown.positions[:, 1].max() == pytest.approx(top)


def skinned(joints: np.ndarray, shares: np.ndarray, inverse: np.ndarray, nodes: list[dict[str, Any]]) -> dict[str, Any]:
    attributes = {"POSITION": 0, "NORMAL": 2, "JOINTS_0": 3, "WEIGHTS_0": 4}
    normals = np.tile(np.array([0, 0, 1], "<f4"), (4, 1))
    return header(
        SQUARE, CORNERS, normals, joints, shares, inverse,
        nodes=nodes,
        meshes=[{"primitives": [{"attributes": attributes, "indices": 1}]}],
        skins=[{"joints": list(range(1, len(nodes))), "inverseBindMatrices": 5}],
        scenes=[{"nodes": list(range(len(nodes)))}],
    )  # fmt: skip


FIRST = np.zeros((4, 4), "u1")
WHOLE = np.tile(np.array([1, 0, 0, 0], "<f4"), (4, 1))


@pytest.mark.parametrize("node", [{"scale": [100, 100, 100]}, {"translation": [5, 0, 0]}])
def test_where_the_node_of_a_skinned_mesh_stands_does_not_count(tmp_path: Path, node: dict[str, Any]) -> None:
    content = skinned(FIRST, WHOLE, np.eye(4, dtype="<f4")[None], [{"mesh": 0, "skin": 0, **node}, {}])
    assert corners(one(tmp_path, content)) == sorted_rows(SQUARE)


def test_joints_blend_by_their_weights_and_carry_normals(tmp_path: Path) -> None:
    """The second joint turns by a quarter about x, and the upper corners hang on both."""
    turned = {"rotation": [2**-0.5, 0, 0, 2**-0.5], "translation": [0, 0, 4]}
    joints = np.array([[1, 0, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 1, 0, 0]], "u1")
    shares = np.array([[1, 0, 0, 0], [1, 0, 0, 0], [3, 1, 0, 0], [3, 1, 0, 0]], "<f4")
    inverse = np.stack([np.eye(4), np.eye(4)]).astype("<f4")
    inverse[1, 3, :3] = (0, 0, -1)
    mesh = one(tmp_path, skinned(joints, shares, inverse, [{"mesh": 0, "skin": 0}, {}, turned]))
    # (x, y, z) -> (x, -(z - 1), y + 4) by the second joint: (x, 1, 4) below, and a quarter of (x, 1, 6) above.
    assert np.allclose(corners(mesh), [(-1, 1, 4), (-1, 1.75, 1.5), (1, 1, 4), (1, 1.75, 1.5)], atol=1e-6)
    lower = np.isclose(mesh.positions[:, 1], 1.0)
    assert np.allclose(np.abs(mesh.normals[lower]), [0, 1, 0], atol=1e-6)


def test_normals_of_what_a_joint_stretches_stay_perpendicular(tmp_path: Path) -> None:
    content = skinned(FIRST, WHOLE, np.eye(4, dtype="<f4")[None], [{"mesh": 0, "skin": 0}, {"scale": [1, 2, 1]}])
    sloped = np.tile(np.array([0, 0.6, 0.8], "<f4"), (4, 1))
    content["buffers"].append(packed(sloped)["buffers"][0])
    content["bufferViews"][2] = {"buffer": 1, "byteLength": sloped.nbytes}
    assert np.allclose(one(tmp_path, content).normals, np.array([0, 0.3, 0.8]) / np.hypot(0.3, 0.8), atol=1e-6)


def test_a_vertex_without_weights_follows_its_first_joint(tmp_path: Path) -> None:
    content = skinned(
        FIRST, 0 * WHOLE, np.eye(4, dtype="<f4")[None], [{"mesh": 0, "skin": 0}, {"translation": [0, 0, 3]}]
    )
    assert corners(one(tmp_path, content)) == sorted_rows(np.add(SQUARE, (0, 0, 3)))


def test_a_joint_that_mirrors_keeps_the_outside_outside(tmp_path: Path) -> None:
    content = skinned(FIRST, WHOLE, np.eye(4, dtype="<f4")[None], [{"mesh": 0, "skin": 0}, {"scale": [-1, 1, 1]}])
    mesh = one(tmp_path, content)
    sides = mesh.positions[mesh.faces]
    assert np.allclose(mesh.normals, [0, 0, 1])
    assert (np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0])[:, 2] > 0).all()


def test_points_and_lines_beside_triangles_are_said_to_be_left_out(tmp_path: Path) -> None:
    meshes = [
        {"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}, {"attributes": {"POSITION": 0}, "mode": 1}]}
    ]
    with pytest.warns(AnamorphNote, match=r"m\.gltf: part 'q': its points and lines are left out"):
        assert len(one(tmp_path, header(SQUARE, CORNERS, meshes=meshes)).faces) == 2


def png() -> str:
    file = io.BytesIO()
    Image.fromarray(np.full((2, 2, 3), 90, np.uint8)).save(file, "PNG")
    return "data:image/png;base64," + base64.b64encode(file.getvalue()).decode()


def looking(material: dict[str, Any], texcoords: bool = True, **changes: Any) -> dict[str, Any]:
    """The square with texture coordinates from -1 to 2, and a material."""
    attributes = {"POSITION": 0, **({"TEXCOORD_0": 2} if texcoords else {})}
    uv = np.array([[-1, 2], [2, 2], [2, -1], [-1, -1]], "<f4")
    content = header(SQUARE, CORNERS, uv, materials=[{"name": "m", **material}], **changes)
    content["meshes"] = [{"primitives": [{"attributes": attributes, "indices": 1, "material": 0}]}]
    return content


TEXTURED = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}


@pytest.mark.parametrize(
    ("sampler", "wraps"),
    [
        ({}, ("repeat", "repeat")),
        ({"wrapS": 33071, "wrapT": 33071}, ("clamp", "clamp")),
        ({"wrapS": 33648, "wrapT": 33648}, ("mirror", "mirror")),
        ({"wrapS": 33648, "wrapT": 10497}, ("mirror", "repeat")),
    ],
)
def test_a_sampler_says_what_lies_beyond_an_images_edges(tmp_path: Path, sampler: Any, wraps: Any) -> None:
    textures = [{"source": 0, "sampler": 0}]
    mesh = one(tmp_path, looking(TEXTURED, images=[{"uri": png()}], textures=textures, samplers=[sampler]))
    assert isinstance(mesh.material, Diffuse) and mesh.material.texture is not None
    assert mesh.material.texture.wraps == wraps


def test_an_image_of_the_scene_file_finds_the_models_texture_coordinates(tmp_path: Path) -> None:
    written(tmp_path, looking({}))
    Image.fromarray(np.full((2, 2, 3), 90, np.uint8)).save(tmp_path / "paint.png")
    (tmp_path / "s.toml").write_text(
        "[eye]\nposition = [0, 1, 4]\ntarget = [0, 1, 0]\n"
        '[[model]]\nfile = "m.gltf"\ndiffuse = { image = "paint.png" }\n'
    )
    (mesh,) = open_scene(tmp_path / "s.toml")[0].meshes
    assert isinstance(mesh.material, Diffuse) and mesh.material.texture is not None
    assert mesh.texcoords is not None and sorted_rows(mesh.texcoords) == [(-1, -1), (-1, 2), (2, -1), (2, 2)]


def shine(
    metal: float | None, roughness: float | None, color: tuple[float, ...] = (0.8, 0.6, 0.4, 1.0)
) -> dict[str, Any]:
    factors = {"metallicFactor": metal, "roughnessFactor": roughness, "baseColorFactor": color}
    return {"pbrMetallicRoughness": {key: value for key, value in factors.items() if value is not None}}


@pytest.mark.parametrize(
    ("material", "expected", "said"),
    [
        (shine(1.0, 0.0), Mirror((1.0, 0.75, 0.5), 0.8), None),
        (shine(None, 0.0), Mirror((1.0, 0.75, 0.5), 0.8), None),
        (shine(1.0, 0.3), Mirror((1.0, 0.75, 0.5), 0.8), "the roughness of mirrors"),
        (shine(1.0, 0.5), Diffuse((0.8, 0.6, 0.4)), "metals that are rough"),
        (shine(0.0, 0.0), Diffuse((0.8, 0.6, 0.4)), None),
        # The older kind of material counts where both stand.
        (
            {
                **shine(1.0, 0.0),
                "extensions": {"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [0.25, 0.5, 1.0]}},
            },
            Diffuse((0.25, 0.5, 1.0)),
            None,
        ),
        # What a file says that says nothing: metal, wholly rough.
        (shine(None, None), Diffuse((0.8, 0.6, 0.4)), None),
        (shine(1.0, 0.0, (0.0, 0.0, 0.0, 1.0)), Mirror((1.0, 1.0, 1.0), 0.0), None),
    ],
)
def test_polished_metals_become_mirrors(tmp_path: Path, material: Any, expected: Material, said: str | None) -> None:
    assert seen(tmp_path, looking(material), said) == described(expected)


def seen(folder: Path, content: dict[str, Any], said: str | None) -> tuple[Any, ...]:
    """What a file's only part looks like, after the note that it must bring."""
    with warnings.catch_warnings(record=True) as notes:
        warnings.simplefilter("always")
        mesh = one(folder, content)
    assert [str(each.message) for each in notes if said is None] == []
    assert said is None or [said in str(each.message) for each in notes] == [True]
    return described(mesh.material)


def described(material: Material) -> tuple[Any, ...]:
    match material:
        case Mirror(tint=tint, reflectance=share):
            return "mirror", *np.round((*tint, share), 9)
        case Glass(tint=tint, index=index, abbe=abbe):
            return "glass", *np.round((*tint, index, abbe or 0.0), 9)
        case Diffuse(color=color):
            return "diffuse", *np.round(color, 9)


def clear(**extensions: Any) -> dict[str, Any]:
    given = {"KHR_materials_transmission": {"transmissionFactor": 1.0}}
    given |= {f"KHR_materials_{name}": values for name, values in extensions.items()}
    return {**shine(0.0, 0.0), "extensions": given}


TINT = (0.8, 0.6, 0.4)


@pytest.mark.parametrize(
    ("material", "expected", "said"),
    [
        (clear(volume={"thicknessFactor": 0.1}), Glass(1.5, TINT), None),
        (clear(volume={"thicknessFactor": 0.1}, ior={"ior": 1.7}), Glass(1.7, TINT), None),
        (clear(volume={"thicknessFactor": 0.1}, dispersion={"dispersion": 0.5}), Glass(1.5, TINT, 40.0), None),
        (clear(ior={"ior": 1.7}), Glass(1.0, TINT), "light goes straight through it"),
        (
            {**clear(volume={"thicknessFactor": 0.1}), **shine(0.0, 0.2)},
            Glass(1.5, TINT),
            "the roughness of glass",
        ),
    ],
)
def test_what_lets_light_through_becomes_glass(tmp_path: Path, material: Any, expected: Material, said: Any) -> None:
    assert seen(tmp_path, looking(material), said) == described(expected)


def test_a_closed_body_of_glass_bends_light_without_a_volume_of_its_own(tmp_path: Path) -> None:
    box = trimesh.creation.box()
    soup = box.vertices[box.faces].reshape(-1, 3).astype("<f4")
    content = header(soup, np.arange(len(soup), dtype="<u2"), materials=[clear(ior={"ior": 1.4})])
    content["meshes"] = [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}]
    assert seen(tmp_path, content, None) == described(Glass(1.4, TINT))


def test_an_image_without_coordinates_is_said_to_be_left_out(tmp_path: Path) -> None:
    content = looking(TEXTURED, texcoords=False, images=[{"uri": png()}], textures=[{"source": 0}])
    assert seen(tmp_path, content, "part 'q': has no TEXCOORD_0; its image is left out") == ("diffuse", 1, 1, 1)


def test_an_image_on_a_mirror_is_said_to_be_left_out(tmp_path: Path) -> None:
    polished = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "roughnessFactor": 0.0}}
    content = looking(polished, images=[{"uri": png()}], textures=[{"source": 0}])
    assert seen(tmp_path, content, "left out: images of mirrors (material 'm')") == ("mirror", 1, 1, 1, 1)


def changed(*keys: Any, to: Any) -> dict[str, Any]:
    """The textured square, with one entry of its header replaced, or removed where `to` is None."""
    content = looking(TEXTURED, images=[{"uri": png()}], textures=[{"source": 0, "sampler": 0}], samplers=[{}])
    inner: Any = content
    for key in keys[:-1]:
        inner = inner[key]
    if to is None:
        del inner[keys[-1]]
    else:
        inner[keys[-1]] = to
    return content


PRIMITIVE = ("meshes", 0, "primitives", 0)
SPARSE = {"count": 1, "indices": {"bufferView": 1, "componentType": 5123}, "values": {"bufferView": 0}}
WRONG = {
    "kind of positions": (changed("accessors", 0, "type", to="VEC2"), "is of type 'VEC2', and must be VEC3"),
    "matrix as positions": (changed("accessors", 0, "type", to="MAT4"), "is of type 'MAT4', and must be VEC3"),
    "unknown kind": (changed("accessors", 0, "type", to=["VEC3"]), "is of type"),
    "floats as indices": (changed("accessors", 1, "componentType", to=5126), "componentType is 5126, no unsigned"),
    "signed indices": (changed("accessors", 1, "componentType", to=5122), "componentType is 5122, no unsigned"),
    "component": (changed("accessors", 0, "componentType", to=5124), "componentType is 5124"),
    "too many elements": (changed("accessors", 0, "count", to=5), "accessor 0, POSITION of mesh 0: has 5 elements"),
    "too few texcoords": (changed("accessors", 2, "count", to=3), "TEXCOORD_0 has 3 elements, and POSITION 4"),
    "no multiple of three": (changed("accessors", 1, "count", to=5), "5 corners of triangles"),
    "negative count": (changed("accessors", 0, "count", to=-1), "count is -1"),
    "text as count": (changed("accessors", 0, "count", to="4"), "count is '4'"),
    "bomb": (
        changed("accessors", 0, to={"componentType": 5126, "count": 10**9, "type": "VEC3"}),
        "elements, more than",
    ),
    "offset": (changed("accessors", 0, "byteOffset", to=10**12), "more than its"),
    "stride": (changed("bufferViews", 0, "byteStride", to=2), "byteStride is 2"),
    "view": (changed("bufferViews", 0, "byteLength", to=10**6), "ends at byte"),
    "buffer": (changed("buffers", 0, "byteLength", to=10**6), "its header says 1000000"),
    "base64": (changed("buffers", 0, "uri", to="data:;base64,A"), "base64"),
    "no buffer view": (changed("accessors", 0, "bufferView", to=9), "names 9 of bufferViews"),
    "sparse index": (
        changed(
            "accessors",
            2,
            "sparse",
            to={**SPARSE, "indices": {"bufferView": 2, "byteOffset": 2, "componentType": 5123}},
        ),
        "sparse: names element 49024, and there are 4",
    ),
    "sparse part": (changed("accessors", 2, "sparse", to=[]), "its sparse part is damaged"),
    "no accessor": (changed(*PRIMITIVE, "indices", to=9), "names 9 of accessors"),
    "mode": (changed(*PRIMITIVE, "mode", to=7), "mode is 7"),
    "weights": (changed("meshes", 0, "weights", to=[1.0]), "1 morph weights for 0 targets"),
    "rotation": (changed("nodes", 0, "rotation", to=[0, 0, 0, 0]), "node 0: its rotation is 0"),
    "scale": (changed("nodes", 0, "scale", to=[1, 1]), "its scale is [1, 1], and must be 3 numbers"),
    "matrix": (changed("nodes", 0, "matrix", to="unit"), "its matrix is 'unit'"),
    "cycle": (changed("nodes", to=[{"mesh": 0}, {"children": [2]}, {"children": [1]}]), "among its own descendants"),
    "two parents": (changed("nodes", to=[{"mesh": 0}, {"children": [0]}, {"children": [0]}]), "node 0 has two parents"),
    "scene": (changed("scene", to=4), "names 4 of scenes"),
    "wrap": (changed("samplers", 0, "wrapS", to=1), "wrapS of its sampler is 1"),
    "image": (changed("textures", 0, "source", to=3), "names 3 of images"),
    "no source": (
        changed("textures", 0, to={"extensions": {"KHR_texture_basisu": {"source": 0}}}),
        "KHR_texture_basisu",
    ),
    "ior": (changed("materials", 0, to=clear(ior={"ior": 0.5})), "ior is 0.5"),
    "color": (changed("materials", 0, to=shine(0.0, 1.0, (-1.0, 0.0, 0.0))), "baseColorFactor"),
    "list as header": (changed("materials", to={"a": 1}), "glTF header is damaged"),
    "no mesh": (changed("nodes", 0, "mesh", to=4), "names 4 of meshes"),
}


@pytest.mark.parametrize("kind", WRONG)
def test_what_is_wrong_is_said_in_one_line(tmp_path: Path, kind: str) -> None:
    content, words = WRONG[kind]
    with pytest.raises(AnamorphError) as caught:
        load_model(written(tmp_path, content))
    message = str(caught.value)
    assert message.startswith(str(tmp_path / "m.gltf")) and words in message, message
    assert "\n" not in message and len(message) < 400


def test_the_plain_square_of_these_tests_is_right(tmp_path: Path) -> None:
    (part,) = load_parts(written(tmp_path, changed("asset", to={"version": "2.0"})))
    assert corners(part.mesh) == sorted_rows(SQUARE) and part.material == "m"
