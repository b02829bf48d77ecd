"""What Python packs for the device lies where shaders read it, and numbers that both languages say are the same."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scenes import flat_mirror, sky_scene
from wgsl import bound, constants, declared, layout_of, rooms, texts

from anamorph.base.steps import drain
from anamorph.frame import Status
from anamorph.gpu.buffers import MOST_LIGHTS, OBJECT, VERTEX
from anamorph.inward import field_maps, raster
from anamorph.methods.pervertex import finding, level, looking, silhouettes, surface_maps
from anamorph.methods.pervertex.overlay import BALL_VERTICES
from anamorph.methods.threeray import splat_records
from anamorph.methods.tracing.bounces import DIFFUSE, MIRROR
from anamorph.methods.tracing.launch import GivenRays
from anamorph.methods.tracing.packing import packed
from anamorph.methods.tracing.paths import PathTracer
from anamorph.methods.trilinear import ray_records
from anamorph.methods.trilinear.straight import edges
from anamorph.methods.virtual import (
    cube_search,
    device_search,
    grid_search,
    meeting_rays,
    reflector_maps,
    tile_tree,
    triangle_records,
)
from anamorph.optics import exact_sides
from anamorph.projection import UNIFORM_BYTES, camera_projection
from anamorph.raymesh import RayStatus
from anamorph.rays.caster import Caster
from anamorph.raytriangle import on_device, solve
from anamorph.scene.geometry import flatten
from anamorph.surfaces import device_numbers
from anamorph.viewer.lines import CANVAS_BYTES, STROKE_FLOATS

EVERYWHERE = declared(texts("gpu"))
"""Structures of the shaders that all others may stand on."""

RECORDS = [
    (
        "gpu",
        "StoredVertex",
        VERTEX,
        {"position": "x", "normal": "normal_x", "texcoord": "u", "color": "color_red_green"},
    ),
    ("gpu", "Object", OBJECT, {"padding": "padding_0"}),
    ("optics", "ExactSide", exact_sides.EXACT_SIDE, {}),
    ("raytriangle", "RayTriangle", on_device.RAY_TRIANGLE, {"vectors": "center", "padding": None}),
    ("raytriangle", "Projections", on_device.FOUND, {}),
    ("methods/pervertex", "LookingTriangle", looking.LOOKING, {}),
    ("methods/threeray", "ThreeRayCamera", splat_records.CAMERA, {}),
    ("methods/threeray", "ScenePoint", splat_records.POINT, {}),
    ("methods/threeray", "Projected", splat_records.PROJECTED, {}),
    ("methods/threeray", "Owner", splat_records.OWNER, {}),
    ("methods/virtual", "SceneTriangle", triangle_records.SCENE_TRIANGLE, {}),
    ("methods/virtual", "TileRays", tile_tree.TILE_RAYS, {}),
    ("methods/virtual", "GridVertex", grid_search.GRID_VERTEX, {}),
    ("methods/virtual", "Search", device_search.SEARCH, {"padding": None}),
    ("methods/virtual", "MapTexel", device_search.MAP_TEXEL, {"padding_0": None, "padding_1": None}),
    ("methods/virtual", "Reflected", cube_search.REFLECTED, {}),
    ("inward", "Convergence", field_maps.CONVERGENCE, {}),
    ("inward", "RayCorner", raster.RAY_CORNER, {}),
    ("inward", "Lookup", raster.LOOKUP, {}),
    ("methods/trilinear", "RayTriangle", ray_records.RAY_TRIANGLE, {"padding": None}),
    ("methods/trilinear", "Lens", ray_records.LENS, {"padding": None}),
    ("methods/trilinear/straight", "StraightCorner", edges.STRAIGHT_CORNER, {"place": "x", "weights": "second"}),
]
"""Room, structure, its dtype, and what members are called in the shader where a field has another name, or none."""

SIZES = [
    ("gpu", "Projection", UNIFORM_BYTES),
    ("gpu", "Lighting", 16 * (5 + 2 * MOST_LIGHTS)),
    ("methods/pervertex", "PatchMaps", finding.MOST_VIEWS * UNIFORM_BYTES),
    ("methods/pervertex", "WarpMaps", level.MOST_VIEWS * UNIFORM_BYTES),
    ("methods/pervertex", "WarpedTriangle", 4 * 4),
    ("methods/pervertex", "Silhouette", 4 * silhouettes.WORDS),
    ("methods/tracing", "TracedPath", 2 * 4 * 4),
    ("raytriangle", "Two", 4 * 2 * 4),
    ("raytriangle", "Block", 4 * 3),
    ("viewer", "Stroke", 4 * STROKE_FLOATS),
    ("viewer", "Canvas", CANVAS_BYTES),
]
"""Room, structure, and the bytes of what Python packs by hand for it."""


def structure(room, name):
    return layout_of(name, EVERYWHERE | declared(texts(room)))


def words_of(dtype):
    """The offset and the kind of every 32-bit number; integers of 16 bits are two to a number."""
    words = {}
    for field, offset, *_ in dtype.fields.values():
        kind = field.base.kind
        words |= {offset + byte: kind for byte in range(0, field.itemsize, 4)}
    return words


@pytest.mark.parametrize(("room", "name", "dtype", "renamed"), RECORDS, ids=[f"{r} {n}" for r, n, *_ in RECORDS])
def test_records_lie_in_the_device_as_in_python(room, name, dtype, renamed):
    layout = structure(room, name)
    assert layout.stride == dtype.itemsize
    packed = words_of(dtype)
    assert {offset: packed.get(offset) for offset, _ in layout.words} == dict(layout.words)
    for field in dtype.names:
        member = renamed.get(field, field)
        assert member is None or layout.members[member] == dtype.fields[field][1], field


@pytest.mark.parametrize(("room", "name", "size"), SIZES, ids=[f"{room} {name}" for room, name, _ in SIZES])
def test_what_is_packed_by_hand_is_as_large_as_what_is_read(room, name, size):
    assert structure(room, name).size == size


def test_every_structure_of_a_buffer_is_held_to_python():
    held = {(room, name) for room, name, *_ in [*RECORDS, *SIZES]}
    for room in rooms():
        own = declared(texts(room))
        for name in set(bound(texts(room))) & (EVERYWHERE | own).keys():
            assert (room if name in own else "gpu", name) in held, f"{room}: {name}"


def test_a_projection_is_packed_member_by_member():
    camera = flat_mirror_scene().camera
    projection = camera_projection(camera, (160, 120))
    packed, members = projection.uniform((160, 120), (3, 4)), structure("gpu", "Projection").members

    def member(name, count):
        return packed[members[name] // 4 :][:count]

    assert pytest.approx(projection.clip, rel=1e-6) == member("clip", 16).reshape(4, 4).T
    assert pytest.approx(np.linalg.inv(projection.clip), rel=1e-5) == member("unclip", 16).reshape(4, 4).T
    for name in ("base", "right", "up", "eye"):
        assert member(name, 3) == pytest.approx(getattr(projection, name), rel=1e-6)
    assert member("size", 4).tolist() == [160, 120, 3, 4]
    assert members["base"] == 4 * level.CLIP_WORDS


def flat_mirror_scene():
    return sky_scene(flat_mirror())


def test_the_end_of_a_path_is_packed_member_by_member():
    scene = flat_mirror_scene()
    geometry = flatten(scene)
    tracer = PathTracer(scene, geometry, Caster(geometry), max_bounces=0)
    record = drain(tracer.tracing(GivenRays(np.array([[0.05, 0.5, 2.0]]), np.array([[0.0, 0.0, -3.0]]))))[0]
    members = {name: offset // 4 for name, offset in structure("gpu", "PathEnd").members.items()}

    def member(name, count=1):
        return record[members[name] :][:count]

    assert member("origin", 3) == pytest.approx([0.05, 0.5, 2.0])
    assert member("direction", 3) == pytest.approx([0.0, 0.0, -1.0])
    assert member("throughput", 3) == pytest.approx([1.0, 1.0, 1.0])
    assert record[11] == pytest.approx(2.0)
    triangle = int(member("triangle").view(np.int32)[0])
    first, second = packed(record[None])[:, 0]
    assert first.tolist() == [*member("origin", 3).view(np.uint32), triangle + 1], "shaders count triangles from 1"
    assert second[2] == member("flags").view(np.uint32)[0]
    a, b, c = geometry.positions[geometry.faces[triangle]].astype(float)
    second, third = record[12:14]
    assert (1.0 - second - third) * a + second * b + third * c == pytest.approx([0.05, 0.5, 0.0], abs=1e-6)
    # Looked at and left at once: the mirror is the first specular object, and the bounce limit the end.
    flags = int(member("flags").view(np.uint32)[0])
    assert (flags & 0xFFFF, flags >> 16 & 0xFF) == (1, Status.OUTSIDE)


def test_the_numbers_of_statuses_are_those_of_the_shaders():
    said = {
        name.removeprefix("STATUS_"): number for name, number in constants(texts("gpu")).items() if "STATUS_" in name
    }
    assert said == {name: Status[name] for name in said}
    assert {status.name for status in Status} - said.keys() == {"TRACED"}, "only traced paths tell that"


def test_what_becomes_of_a_bent_ray_has_the_numbers_of_its_status():
    said = {name.removeprefix("RAY_"): n for name, n in constants(texts("optics")).items() if name.startswith("RAY_")}
    assert said.pop("MISSED") not in list(RayStatus), "only the device tells that"
    assert said == {name: RayStatus[name] for name in said} and len(said) == 3


@pytest.mark.parametrize("name", ["UNKNOWN_SURFACE", "ROUND", "TOROID", "ASPHERE", "PATCH"])
def test_the_kinds_of_exact_surfaces_have_the_numbers_of_the_shaders(name):
    assert constants(texts("surfaces"))[name] == getattr(device_numbers, name)


def test_object_and_status_share_a_number_as_the_session_takes_it_apart():
    (shift,) = re.findall(r"return specular \| \(status << (\d+)u\);", texts("gpu"))
    assert int(shift) == 16, "session.py and records of paths keep the object in the low 16 bits"
    assert set(re.findall(r"\.flags >> (\d+)u", texts("gpu"))) == {shift}
    assert set(re.findall(r"status << (\d+)u", texts("methods/pervertex"))) == {shift}
    assert set(re.findall(r"end\.flags & (0x[0F]+)u", texts("gpu"))) == {"0xFFFFFF"}, (
        "without the bounces above the status"
    )


@pytest.mark.parametrize(
    ("room", "name", "value"),
    [
        ("gpu", "DIFFUSE", DIFFUSE), ("gpu", "MIRROR", MIRROR),
        ("methods/pervertex", "SMOOTH", level.SMOOTH), ("methods/pervertex", "THREE_COLORS", level.THREE_COLORS),
        ("methods/pervertex", "MEETS_ITSELF", looking.MEETS_ITSELF),
        ("methods/pervertex", "WITHOUT_MAP", looking.WITHOUT_MAP),
        ("methods/pervertex", "LEVELS", surface_maps.LEVELS), ("methods/tracing", "STATUS_DOUBTFUL", Status.DOUBTFUL),
        ("methods/virtual", "TRACED", meeting_rays.TRACED), ("methods/virtual", "BORDER", reflector_maps.BORDER),
        *(
            ("methods/virtual", name, getattr(cube_search, name))
            for name in ("DIFFERENT", "ALIKE", "LARGEST_STEP", "LEAST_STEP", "FIRST_STEP", "AGAIN_STEP", "CUTS")
        ),
        ("methods/trilinear", "SPECULAR", ray_records.SPECULAR), ("raytriangle", "OUTERMOST", solve.OUTERMOST),
    ],
)  # fmt: skip
def test_constants_of_both_languages_are_the_same(room, name, value):
    assert constants(texts(room))[name] == value


def test_arrays_and_counts_are_as_long_as_python_takes_them_for():
    said = constants(texts("methods/pervertex"))
    assert 6 * said["SLICES"] * said["STACKS"] == BALL_VERTICES
    assert dict(EVERYWHERE["Lighting"])["lights"] == f"array<Light, {MOST_LIGHTS}>"
    maps = {"WarpMaps": level.MOST_VIEWS, "PatchMaps": finding.MOST_VIEWS}
    for name, views in maps.items():
        assert dict(declared(texts("methods/pervertex"))[name])["views"] == f"array<Projection, {views}>"
