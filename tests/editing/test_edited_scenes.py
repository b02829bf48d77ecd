"""Scenes that are edited step by step: they share what stays, and are drawn as if nothing had been there before."""

from __future__ import annotations

import weakref
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import open_view, scene_with, spherical_mirror
from triangle_soup import brute_force, random_rays

from anamorph import gallery
from anamorph.frame import Frame
from anamorph.gallery.solids import box
from anamorph.methods import METHODS
from anamorph.rays.caster import Caster
from anamorph.rays.embree import KEPT, EmbreeTriangles, tree_over
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import APART, BESIDE, SPECULAR, flatten
from anamorph.scene.model import Diffuse, Glass, Mesh, Mirror, Scene
from anamorph.scene.parts import specular_parts
from anamorph.viewer.controls import edited

SIZE = (48, 36)
HOUSING = box((-0.22, 0.33, -0.09), (0.22, 0.67, -0.03)).mesh("mirror/housing", Diffuse(color=(0.1, 0.1, 0.1)))
WITH_HOUSING = scene_with(replace(spherical_mirror(count=4), name="mirror/glass"), HOUSING)
LENS = gallery.make("spectacles-minus")
SPECIFICATIONS = (*METHODS, "raytrace:truth=raymesh", "pervertex:tolerance=0.5")


def drawn_by(scene: Scene, specification: str) -> Frame:
    session = open_view(scene, specification, SIZE)
    session.draw(scene.camera)
    return session.frame(seen=True)


def assert_same(one: Frame, other: Frame) -> None:
    for name in ("color", "position", "object_id", "specular", "status", "deviation"):
        first, second = (np.ascontiguousarray(getattr(frame, name)) for frame in (one, other))
        assert first.tobytes() == second.tobytes(), name


steps = st.fixed_dictionaries(
    {"mirror/swivel": st.sampled_from([0.0, -7.0, 12.0])},
    optional={
        "mirror/tilt": st.floats(-5, 5),
        "mirror/outward": st.floats(-20, 20),
        "mirror/curvature": st.sampled_from([0.0, -0.4, 0.9]),
        "mirror/reflectance": st.floats(0, 1),
    },
)


@pytest.mark.parametrize("specification", SPECIFICATIONS)
@settings(max_examples=4)
@given(st.lists(steps, min_size=1, max_size=3))
def test_a_mirror_edited_step_by_step_is_drawn_as_if_at_once(specification, values):
    for each in values:
        scene = edited(WITH_HOUSING, each)
        after = drawn_by(scene, specification)
    tree_over.cache_clear()
    assert_same(after, drawn_by(scene, specification))


@pytest.mark.parametrize("specification", [name for name in SPECIFICATIONS if name != "environment"])
@settings(max_examples=1)
@given(st.floats(-6, -1), st.sampled_from([-10.0, 4.0]))
def test_a_lens_edited_step_by_step_is_drawn_as_if_at_once(specification, power, tilt):
    (name,) = specular_parts(LENS.meshes)
    for values in ({f"{name}/power": -3.0}, {f"{name}/power": power, f"{name}/tilt": tilt}):
        scene = edited(LENS, values)
        after = drawn_by(scene, specification)
    tree_over.cache_clear()
    assert_same(after, drawn_by(scene, specification))


def test_what_stands_around_keeps_its_tree():
    tree_over.cache_clear()
    Caster(flatten(WITH_HOUSING))
    assert tree_over.cache_info().misses == 3
    for number in range(1, 6):
        Caster(flatten(edited(WITH_HOUSING, {"mirror/swivel": float(number)})))
        # The mirror and its housing have moved, the world has not.
        assert (tree_over.cache_info().misses, tree_over.cache_info().hits) == (3 + 2 * number, number)
    Caster(flatten(edited(WITH_HOUSING, {"mirror/swivel": 5.0, "mirror/curvature": 0.3})))
    assert (tree_over.cache_info().misses, tree_over.cache_info().hits) == (14, 7)


def test_a_session_that_deforms_moves_no_other_scene():
    one, other = (edited(WITH_HOUSING, {"mirror/swivel": angle}) for angle in (3.0, 4.0))
    for specification in ("raytrace", "raytrace:tree=rebuild", "pervertex", "trilinear"):
        before = drawn_by(other, specification)
        session, beside = open_view(one, specification, SIZE), open_view(other, specification, SIZE)
        geometry = flatten(one)
        moving = (geometry.kind[geometry.vertex_object - 1] != SPECULAR)[:, None]
        for _ in range(2):
            session.deform(geometry.positions + moving * np.float32(0.05), geometry.normals)
            session.draw(one.camera)
        beside.draw(other.camera)
        assert_same(before, beside.frame(seen=True))
        assert_same(before, drawn_by(other, specification))


def test_whoever_writes_into_a_mesh_sees_it_where_it_is():
    mesh = replace(WITH_HOUSING.meshes[-1], positions=WITH_HOUSING.meshes[-1].positions.copy())
    scene = replace(WITH_HOUSING, meshes=(*WITH_HOUSING.meshes[:-1], mesh))
    Caster(flatten(scene))
    mesh.positions[:, 1] += 10.0
    above = np.add(mesh.positions.max(axis=0), [-0.01, 5.0, -0.01])
    hits = Caster(flatten(scene)).cast([above], [[0.0, -1.0, 0.0]])
    assert flatten(scene).face_object[hits.triangle[0]] == len(scene.meshes)


def test_no_more_than_the_last_trees_are_kept():
    first = tree_over(EmbreeTriangles(*triangles(0)))
    gone = weakref.ref(first)
    del first
    for seed in range(1, KEPT + 1):
        assert gone() is not None
        tree_over(EmbreeTriangles(*triangles(seed)))
    assert gone() is None


def triangles(seed: int, count: int = 9) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    positions = random.normal(size=(count, 3)).astype(np.float32)
    return positions, random.integers(0, count, (2 * count, 3)).astype(np.int32)


@given(st.integers(0, 9), st.booleans(), st.integers(0, 26), st.integers(0, 31))
def test_triangles_are_equal_to_the_last_bit_or_not_at_all(seed, of_faces, place, bit):
    one, other = triangles(seed), triangles(seed)
    assert EmbreeTriangles(*one) == EmbreeTriangles(*other) and hash(EmbreeTriangles(*one)) == hash(
        EmbreeTriangles(*other)
    )
    other[of_faces].view(np.uint32).reshape(-1)[place] ^= np.uint32(1 << bit)
    assert EmbreeTriangles(*one) != EmbreeTriangles(*other)


def test_zeros_of_other_signs_are_other_places_and_undefined_ones_are_themselves():
    positions, faces = triangles(0)
    signed, undefined = positions.copy(), positions.copy()
    positions[4, 1], signed[4, 1], undefined[4, 1] = 0.0, -0.0, np.nan
    assert EmbreeTriangles(positions, faces) != EmbreeTriangles(signed, faces)
    assert EmbreeTriangles(undefined, faces) == EmbreeTriangles(undefined.copy(), faces)


@pytest.mark.parametrize("cut", [0, 1, 9])
def test_more_or_fewer_triangles_are_others(cut):
    positions, faces = triangles(0)
    assert (EmbreeTriangles(positions, faces) == EmbreeTriangles(positions, faces[cut:])) is (cut == 0)
    assert EmbreeTriangles(positions, faces) != (positions, faces)


KINDS = {SPECULAR: "glass", BESIDE: "frame", APART: "wall"}


@settings(max_examples=60)
@given(st.lists(st.sampled_from([*KINDS]), min_size=1, max_size=7), st.integers(0, 1000), st.booleans())
def test_rays_meet_the_same_triangles_however_these_are_parted(kinds, seed, empty):
    """Meshes of all kinds in any order, also without triangles, and such as share places."""
    random = np.random.default_rng(seed)
    meshes = []
    for number, kind in enumerate(kinds):
        count = 0 if empty and number % 2 else int(random.integers(1, 12))
        middles = random.uniform(-1, 1, (count, 1, 3))
        corners = (middles + random.normal(scale=0.4, size=(count, 3, 3))).reshape(-1, 3).astype(np.float32)
        corners = np.concatenate([[[9.0, 9.0, 9.0]], corners]).astype(np.float32)
        material = random.choice([Mirror(), Glass()]) if kind == SPECULAR else Diffuse()
        part = "wall" if kind == APART else "part"
        faces = 1 + np.arange(3 * count, dtype=np.int32).reshape(-1, 3)
        meshes.append(Mesh(f"{part}/{number}", corners, faces, np.ones_like(corners), material))
    geometry = flatten(Scene("test", tuple(meshes), Camera((0, 0, 1), (0, 0, 0))))
    part = SPECULAR in kinds
    assert geometry.kind.tolist() == [kind if part or kind != BESIDE else APART for kind in kinds]
    origins, directions = random_rays(200, seed=seed)
    hits = Caster(geometry).cast(origins, directions)
    if not len(geometry.faces):
        assert (hits.triangle == -1).all() and np.isinf(hits.distance).all()
        return
    distance, triangle, barycentric = brute_force(geometry, origins, directions)
    same = hits.triangle == triangle
    assert same.mean() >= 0.98
    np.testing.assert_allclose(hits.distance[same], distance[same], rtol=1e-4, atol=1e-5)
    found = same & (triangle >= 0)
    np.testing.assert_allclose(hits.barycentric[found], barycentric[found], atol=5e-3)
    assert not hits.barycentric[hits.triangle < 0].any()


def test_the_wrapper_takes_the_whole_scene(monkeypatch):
    monkeypatch.setenv("ANAMORPH_RAYS", "embreex")
    tree_over.cache_clear()
    Caster(flatten(WITH_HOUSING))
    assert tree_over.cache_info().misses == 0
