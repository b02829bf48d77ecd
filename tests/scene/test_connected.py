"""Which mirror meshes are one body."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import CAMERA, flat_mirror, part_of_mesh, spherical_mirror, surroundings

from anamorph import gallery
from anamorph.scene.connected import connected_mirrors
from anamorph.scene.model import Diffuse, Scene


def scene_of(*meshes):
    return Scene("test", meshes, CAMERA)


@settings(max_examples=30)
@given(st.data())
def test_the_parts_of_one_surface_are_one_body_in_any_order(data):
    """Strips of a mirror, and of another that stands apart, among diffuse meshes."""
    count = data.draw(st.integers(2, 5))
    mirrors = [
        spherical_mirror(),
        replace(spherical_mirror(), positions=spherical_mirror().positions + np.float32(1.0)),
    ]
    strips = {
        (number, strip): part_of_mesh(mirror, faces, f"{number}-{strip}")
        for number, mirror in enumerate(mirrors)
        for strip, faces in enumerate(np.array_split(np.arange(len(mirror.faces)), count))
    }
    diffuse = {("diffuse", number): mesh for number, mesh in enumerate(surroundings()[:3])}
    order = data.draw(st.permutations([*strips, *diffuse]))
    found = connected_mirrors(scene_of(*({**strips, **diffuse}[key] for key in order)))
    assert sorted(found) == sorted(
        tuple(place for place, key in enumerate(order) if key[0] == number) for number in (0, 1)
    )


def triangle(*corners, name=None):
    return replace(
        flat_mirror(),
        name=name or str(corners),
        positions=np.array(corners, np.float32),
        normals=np.tile(np.float32([0, 0, 1]), (len(corners), 1)),
        faces=np.array([[0, 1, 2]] if len(corners) == 3 else [[0, 1, 2], [3, 2, 1]], np.int32),
        surface=None,
        parameters=None,
    )


def test_meshes_that_share_one_point_alone_are_two_bodies():
    """An edge is two; a place that one mesh has twice is one."""
    first = triangle((0, 0, 0), (1, 0, 0), (0, 1, 0))
    touching = triangle((1, 0, 0), (2, 0, 0), (1, -1, 0))
    joined = triangle((1, 0, 0), (1, 1, 0), (0, 1, 0))
    twice = triangle((1, 0, 0), (1, 0, 0), (2, 0, 0), (3, 1, 0))
    assert connected_mirrors(scene_of(first, touching)) == [(0,), (1,)]
    assert connected_mirrors(scene_of(first, twice)) == [(0,), (1,)]
    assert connected_mirrors(scene_of(first, joined)) == [(0, 1)]
    # By way of a third.
    assert connected_mirrors(scene_of(touching, joined, first, replace(flat_mirror()))) == [(0,), (1, 2), (3,)]


def test_diffuse_meshes_join_nothing():
    first = triangle((0, 0, 0), (1, 0, 0), (0, 1, 0))
    between = replace(triangle((1, 0, 0), (1, 1, 0), (0, 1, 0)), material=Diffuse())
    last = triangle((1, 0, 0), (2, 0, 0), (1, 1, 0))
    assert connected_mirrors(scene_of(first, between, last)) == [(0,), (2,)]
    assert connected_mirrors(scene_of(between)) == []


def test_meshes_of_one_name_that_touch_are_one_body():
    first = triangle((0, 0, 0), (1, 0, 0), (0, 1, 0), name="pot/body")
    spout = triangle((0.5, 0.2, 0), (2, 0.2, 0), (2, 0.5, 0), name="pot/spout")
    beside = triangle((5, 0, 0), (6, 0, 0), (6, 1, 0), name="pot/other")
    other = replace(spout, name="pan/spout")
    assert connected_mirrors(scene_of(first, spout, beside)) == [(0, 1), (2,)]
    assert connected_mirrors(scene_of(first, other)) == [(0,), (1,)]


def test_the_teapot_is_one_body():
    scene = gallery.make("room")
    assert connected_mirrors(scene) == [tuple(i for i, mesh in enumerate(scene.meshes) if mesh.specular)]
