"""Where an observer starts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import CAMERA, flat_mirror

from anamorph import gallery
from anamorph.gallery.solids import box
from anamorph.rays.caster import Caster
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Diffuse, Scene
from anamorph.viewer.observer import first_observer


@pytest.mark.parametrize("name", [*gallery.names(), "empty"])
def test_an_observer_sees_eye_and_mirror_from_aside_and_above(name):
    scene = Scene("empty", (), CAMERA) if name == "empty" else gallery.make(name)
    observer = first_observer(scene, scene.camera)
    size = (600, 600)
    points = np.array([scene.camera.position, np.add(scene.camera.position, scene.camera.axes()[2] * 1e-3)])
    x, y, depth = observer.image(points, size).T
    assert (depth > 0.0).all() and (np.abs(np.stack([x, y]) / depth - 300.0) < 300.0).all()
    aside = np.subtract(observer.position, observer.target)
    right, up, _ = scene.camera.axes()
    assert up @ aside > 0.0 and abs(right @ aside) > 0.3 * np.linalg.norm(aside)
    specular = [mesh for mesh in scene.meshes if mesh.specular]
    if specular:
        seen = [observer.image(mesh.positions, size) for mesh in specular]
        inside = [(np.abs(each[:, :2] / each[:, 2:] - 300.0) < 300.0).all() and (each[:, 2] > 0).all() for each in seen]
        assert any(inside), "all of the mirror that is looked at"


@pytest.mark.parametrize("name", ["car-mirror", "room", "curvature-series", "facing-mirrors", "saddle", "magnifier"])
def test_neither_walls_nor_ceilings_hide_the_eye(name):
    scene = gallery.make(name)
    observer = first_observer(scene, scene.camera)
    ray = np.subtract(scene.camera.position, observer.position)
    length = np.linalg.norm(ray)
    hits = Caster(flatten(scene)).cast([observer.position], [ray / length])
    assert hits.distance[0] > 0.999 * length


def test_in_a_small_room_an_observer_stays_in_it():
    walls = box((-0.8, 0.0, -0.2), (0.8, 1.2, 1.2)).mesh("room", Diffuse())
    walls = replace(walls, faces=walls.faces[:, ::-1].copy(), normals=-walls.normals)
    free = first_observer(Scene("free", (flat_mirror(),), CAMERA), CAMERA)
    inside = first_observer(Scene("room", (flat_mirror(), walls), CAMERA), CAMERA)
    low, high = walls.positions.min(axis=0), walls.positions.max(axis=0)
    assert (np.array(free.position) > high).any() and free.field_of_view == pytest.approx(45.0)
    assert (np.array(inside.position) > low).all() and (np.array(inside.position) < high).all()
    assert inside.field_of_view > free.field_of_view


def test_an_observer_looks_at_the_mirror_s_face():
    for turn in (-0.9, -0.5, 0.5, 0.9):
        eye = replace(CAMERA, position=(turn, 0.6, 0.3))
        observer = first_observer(Scene("flat", (flat_mirror(),), eye), eye)
        before = np.array(observer.position) - (0.0, 0.5, 0.0)
        assert before[2] > 0.3 * np.linalg.norm(before)
