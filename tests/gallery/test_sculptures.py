"""Sculptures are closed, lie on their distance's zero, and have as many triangles as they promise; and their scenes."""

from __future__ import annotations

import numpy as np
import pytest

from anamorph.gallery.animals import bunny, dinosaur, dragon
from anamorph.gallery.beside_teapot import OBJECTS, beside_teapot
from anamorph.gallery.hall import hall
from anamorph.gallery.sculpting import Lump, Sculpture, limb, mirrored, sculpted, surface_net
from anamorph.gallery.statue import statue

EVERY = (statue, dragon, bunny, dinosaur)


def volume(positions, faces):
    a, b, c = np.moveaxis(positions[faces], 1, 0)
    return np.einsum("fi,fi->", a, np.cross(b, c)) / 6.0


@pytest.mark.parametrize("make", EVERY)
def test_a_sculpture_is_closed_has_the_triangles_that_it_promises_and_its_own_size(make):
    sculpture = make()
    solid = sculpted(sculpture, 8000)
    assert len(solid.faces) == pytest.approx(8000, rel=0.05)
    ways = solid.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    assert (np.sort(ways @ (1 << 20, 1)) == np.sort(ways @ (1, 1 << 20))).all(), "every edge is walked both ways"
    assert volume(solid.positions, solid.faces) > 0.02
    assert (solid.positions >= sculpture.low).all() and (solid.positions <= sculpture.high).all()
    cell = np.ptp(solid.positions[solid.faces], axis=1).max() / 2.0
    away = np.abs(sculpture.distance(solid.positions))
    # Thin ends have both their sides in one cube.
    assert np.median(away) < 0.1 * cell and np.percentile(away, 99.0) < cell and away.max() < 3.0 * cell
    assert len(np.unique(np.round(solid.colors, 2), axis=0)) > 2


def test_a_surface_net_of_a_ball_is_a_ball():
    ball = Sculpture(
        (limb([(0.1, 0.2, 0.3, 0.5), (0.1, 0.2, 0.3 + 1e-9, 0.5)], (1.0, 0.0, 0.0)),),
        (-0.4, -0.3, -0.2),
        (0.6, 0.7, 0.8),
        0.01,
    )
    positions, faces = surface_net(ball, 0.02)
    away = positions - (0.1, 0.2, 0.3)
    assert np.linalg.norm(away, axis=1) == pytest.approx(0.5, abs=1e-3)
    assert volume(positions, faces) == pytest.approx(np.pi / 6.0, rel=5e-3)
    normals = sculpted(ball, 4000)
    out = normals.positions - (0.1, 0.2, 0.3)
    assert np.einsum("vi,vi->v", normals.normals, out / np.linalg.norm(out, axis=1, keepdims=True)).min() > 0.99


def test_a_flat_limb_is_thinner_along_its_flatness_and_a_mirrored_one_is_there_twice():
    flat = limb([(0.5, 0.0, 0.0, 0.2), (0.5, 1.0, 0.0, 0.2)], (1.0, 1.0, 1.0), (0.0, 0.0, 1.0))
    inside = (
        mirrored(flat).distance(np.array([[0.5, 0.5, 0.09], [0.5, 0.5, 0.11], [0.69, 0.5, 0.0], [-0.69, 0.5, 0.0]]))
        < 0.0
    )
    assert inside.tolist() == [True, False, True, True]
    assert flat.distance(np.array([[-0.69, 0.5, 0.0]])) > 0.0


def test_a_vertex_has_the_colour_of_the_lump_that_it_is_on():
    red, blue = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
    box = np.array([(-1.0, -1.0, -1.0), (1.0, 1.0, 1.0)])
    lumps = (Lump(lambda points: points[:, 0] - 0.5, red, box), Lump(lambda points: -0.5 - points[:, 0], blue, box))
    colors = Sculpture(lumps, (-1.0, 0.0, 0.0), (1.0, 1.0, 1.0), 0.01).colors(
        np.array([[-1.0, 0, 0], [1.0, 0, 0], [0, 0, 0]])
    )
    assert colors == pytest.approx(np.array([red, blue, (0.5, 0.0, 0.5)]))


def test_the_scenes_have_a_teapot_of_4000_triangles_and_their_object_beside_it():
    for name in OBJECTS:
        scene = beside_teapot(name, 6000)
        pot = [mesh for mesh in scene.meshes if mesh.specular]
        assert sum(len(mesh.faces) for mesh in pot) == pytest.approx(4000, rel=0.02)
        (beside,) = (mesh for mesh in scene.meshes if not mesh.specular)
        assert scene.name == beside.name == name
        assert len(beside.faces) == pytest.approx(6000, rel=0.05)
    whole = beside_teapot("Dinosaur").meshes[-1]
    assert len(whole.faces) == pytest.approx(OBJECTS["Dinosaur"].triangles, rel=0.03)


def test_the_hall_has_its_floor_below_and_its_ceiling_above():
    image = hall().image
    assert image is not None
    top, bottom = (image.pixels[row, :, :3].mean(axis=0) for row in (0, -1))
    assert top.min() > 140.0
    assert bottom[0] > 1.2 * bottom[1] > 1.4 * bottom[2], "boards are brown"
