"""What cannot be drawn is refused, with the part's name and the remedy."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from anamorph.base.errors import AnamorphError
from anamorph.scene.camera import Camera
from anamorph.scene.checks import check_scene
from anamorph.scene.model import (
    AmbientLight,
    Diffuse,
    DirectionalLight,
    Glass,
    Mesh,
    Mirror,
    PointLight,
    Scene,
    Sky,
    Texture,
)

POSITIONS = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
SQUARE = Mesh(
    "pane",
    POSITIONS,
    np.array([[0, 1, 2], [0, 2, 3]], np.int32),
    np.tile(np.array([0, 0, 1], np.float32), (4, 1)),
    Mirror(),
)
SCENE = Scene("test", (SQUARE,), Camera((0.2, 0.3, 3.0), (0.0, 0.0, 0.0)))


def test_a_sound_scene_passes_unchanged() -> None:
    checked = check_scene(SCENE)
    assert checked.meshes == SCENE.meshes and checked.camera == SCENE.camera


def test_diffuse_parts_may_be_wound_either_way() -> None:
    board = replace(SQUARE, name="board", normals=-SQUARE.normals, material=Diffuse())
    assert check_scene(replace(SCENE, meshes=(SQUARE, board))).meshes[1] is board


def changed(array: np.ndarray, index: Any, value: float) -> np.ndarray:
    copy = array.copy()
    copy[index] = value
    return copy


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"positions": changed(POSITIONS, (2, 1), np.nan)}, "vertex 2 has a NaN"),
        ({"positions": changed(POSITIONS, (3, 0), -np.inf)}, "vertex 3 has a NaN or infinite"),
        ({"positions": POSITIONS[:, :2]}, "positions have shape"),
        ({"positions": POSITIONS[:0], "normals": POSITIONS[:0]}, "is empty"),
        ({"faces": SQUARE.faces[:0]}, "is empty"),
        ({"faces": np.array([[0, 1, 4]])}, "a face names vertex 4, but there are 4"),
        ({"faces": np.array([[0, 1, -1]])}, "a face names vertex -1"),
        ({"faces": np.array([[0.0, 1.0, 2.0]])}, "integers"),
        ({"faces": np.array([[0, 0, 1], [2, 2, 2]])}, "all its triangles are degenerate"),
        ({"normals": changed(SQUARE.normals, 1, 0.0)}, "vertex 1 has a zero normal"),
        ({"normals": changed(SQUARE.normals, (1, 2), np.nan)}, "normals have NaN"),
        ({"normals": 2 * SQUARE.normals}, "not of length 1"),
        ({"normals": -SQUARE.normals}, "pane': its normals point against its winding at 2 of 2 triangles; negate the"),
        ({"faces": np.array([[0, 1, 2], [0, 3, 2]])}, "at 1 of 2 triangles; negate the normals there, or turn"),
        ({"normals": SQUARE.normals[:3]}, "normals have shape"),
        ({"texcoords": np.full((4, 2), np.inf)}, "texcoords have NaN"),
        ({"colors": np.full((4, 3), np.nan)}, "colors have NaN"),
        ({"colors": np.full((4, 3), 1.5)}, "colors go from 1.5 to 1.5; give linear numbers from 0 to 1"),
        ({"colors": np.full((4, 3), -0.5)}, "colors go from -0.5"),
        ({"positions": POSITIONS + np.float32([0.0, 3e5, 0.0])}, "too far for float32; translate everything"),
        ({"positions": POSITIONS * np.float32(1e10)}, "scale it to metres"),
        ({"material": Mirror(reflectance="shiny")}, "reflectance is shiny"),
        ({"material": Mirror(tint=("a", "b", "c"))}, "tint is"),
        ({"material": Mirror(reflectance=1.5)}, "reflectance is 1.5"),
        ({"material": Mirror(reflectance=float("nan"))}, "reflectance is nan"),
        ({"material": Mirror(tint=(1.0, -1.0, 1.0))}, "tint"),
        ({"material": Mirror(back=(1.0, float("inf"), 1.0))}, "back"),
        ({"material": Glass(index=0.0)}, "index is 0.0"),
        ({"material": Glass(index=float("nan"))}, "index is nan"),
        ({"material": Glass(abbe=0.0)}, "abbe is 0.0"),
        ({"material": Diffuse(color=(float("nan"), 0.0, 0.0))}, "color"),
        ({"material": Diffuse(texture=Texture(np.zeros((2, 2, 4), np.uint8)))}, "no texture coordinates"),
        ({"material": Diffuse(texture=Texture(np.zeros((2, 2, 3), np.uint8)))}, "(H, W, 4) uint8"),
        ({"material": Diffuse(texture=Texture(np.zeros((0, 2, 4), np.uint8)))}, "(H, W, 4) uint8"),
    ],
)
def test_an_unsound_mesh_is_refused(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(AnamorphError) as caught:
        check_scene(replace(SCENE, meshes=(replace(SQUARE, **changes),)))
    assert "part 'pane'" in str(caught.value) and words in str(caught.value)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"meshes": ()}, "no meshes"),
        ({"lights": (PointLight((0.0, float("nan"), 0.0)),)}, "light 1: position"),
        ({"lights": (AmbientLight(), DirectionalLight((0.0, 0.0, 0.0)))}, "light 2: toward"),
        ({"lights": (DirectionalLight((0.0, 1.0, 0.0), (float("inf"), 0.0, 0.0)),)}, "light 1: color"),
        ({"lights": (AmbientLight(ground=(0.0, -1.0, 0.0)),)}, "light 1: ground"),
        ({"sky": Sky(horizon=(float("nan"), 0.0, 0.0))}, "sky: horizon"),
        ({"sky": Sky(image=Texture(np.zeros((2, 2, 4), np.float32)))}, "sky: its image"),
        ({"camera": Camera((0.0, 0.0, float("nan")), (0.0, 0.0, 0.0))}, "eye: position"),
        ({"camera": Camera(("a", "b", "c"), (0.0, 0.0, 3.0))}, "eye: position is ('a', 'b', 'c'); give three"),
        ({"camera": Camera((0.0, (0.0, 1.0), 3.0), (0.0, 0.0, 3.0))}, "eye: position"),
        ({"camera": Camera((0.0, 0.0, 1e30), (0.0, 0.0, 0.0))}, "eye: position is (0.0, 0.0, 1e+30); give no number"),
        ({"camera": Camera((0.0, 0.0, 3.0), (0.0, -1e30, 0.0))}, "eye: target"),
        ({"camera": Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0), field_of_view="wide")}, "field_of_view is wide"),
        ({"lights": (PointLight((0.0, 1e30, 0.0)),)}, "light 1: position"),
        ({"lights": (PointLight(("x", 1.0, 0.0)),)}, "light 1: position"),
        ({"camera": Camera((0.0, 0.0, 3.0), (0.0, 0.0, 3.0))}, "same point"),
        ({"camera": Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0), up=(0.0, 0.0, 2.0))}, "along the view"),
        ({"camera": Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0), field_of_view=180.0)}, "field_of_view"),
        ({"camera": Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0), field_of_view=float("nan"))}, "field_of_view"),
    ],
)
def test_an_unsound_scene_is_refused(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(AnamorphError) as caught:
        check_scene(replace(SCENE, **changes))
    assert "test" in str(caught.value) and words in str(caught.value)


def test_degenerate_triangles_are_dropped_and_the_rest_kept() -> None:
    faces = np.array([[0, 1, 2], [1, 1, 2], [0, 2, 3]])
    (mesh,) = check_scene(replace(SCENE, meshes=(replace(SQUARE, faces=faces),))).meshes
    assert mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3]]


def test_a_vertex_of_no_triangle_may_have_no_normal() -> None:
    mesh = replace(SQUARE, faces=SQUARE.faces[:1], normals=changed(SQUARE.normals, 3, 0.0))
    assert check_scene(replace(SCENE, meshes=(mesh,))).meshes == (mesh,)


def seen_from(eye: tuple[float, float, float], *meshes: Mesh) -> Scene:
    return replace(SCENE, meshes=meshes or (SQUARE,), camera=Camera(eye, (5.0, 5.0, 5.0)))


@given(st.floats(-0.99, 0.99), st.floats(-0.99, 0.99))
def test_an_eye_on_the_mirror_is_refused(x: float, y: float) -> None:
    with pytest.raises(AnamorphError, match="on the mirror 'pane'"):
        check_scene(seen_from((x, y, 0.0)))


@given(st.floats(-9, 9), st.floats(-9, 9), st.floats(-9, -0.01))
def test_an_eye_behind_the_mirror_is_refused(x: float, y: float, z: float) -> None:
    with pytest.raises(AnamorphError, match="behind the mirror 'pane'"):
        check_scene(seen_from((x, y, z)))


@given(st.floats(-9, 9), st.floats(-9, 9), st.floats(0.01, 9))
def test_an_eye_before_the_mirror_is_fine(x: float, y: float, z: float) -> None:
    if (x, y, z) != (5.0, 5.0, 5.0) and np.linalg.norm(np.cross(np.subtract((5, 5, 5), (x, y, z)), (0, 1, 0))) > 1e-3:
        check_scene(seen_from((x, y, z)))


def test_an_eye_in_the_plane_of_a_flat_mirror_sees_nothing_of_it() -> None:
    with pytest.raises(AnamorphError, match="behind the mirror 'pane'"):
        check_scene(seen_from((3.0, 0.0, 0.0)))


def test_one_mirror_that_faces_the_eye_is_enough() -> None:
    back = replace(SQUARE, name="back", faces=SQUARE.faces[:, ::-1], normals=-SQUARE.normals)
    check_scene(seen_from((0.0, 0.0, 3.0), SQUARE, back))
    with pytest.raises(AnamorphError, match="behind the mirror 'back'"):
        check_scene(seen_from((0.0, 0.0, 3.0), back))


def test_glass_and_diffuse_parts_may_be_seen_from_anywhere() -> None:
    for material in (Glass(), Diffuse()):
        check_scene(seen_from((0.0, 0.0, -3.0), replace(SQUARE, material=material)))


def test_no_more_meshes_than_the_seen_buffers_can_number() -> None:
    with pytest.raises(AnamorphError, match="65536 meshes"):
        check_scene(replace(SCENE, meshes=(SQUARE,) * 65536))
