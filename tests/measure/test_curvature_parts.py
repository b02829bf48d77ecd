"""Mirrors parted by how they curve."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import flat_mirror, spherical_mirror

from anamorph.gallery import make
from anamorph.gallery.spheres import mirror_ball
from anamorph.gallery.torus import AXIS, MAJOR, MIDDLE, MINOR
from anamorph.measure.curvature_parts import Form, curvature_parts

BALL = mirror_ball("ball", (1.0, 2.0, 3.0), 0.5, rows=24, columns=36)


def plain(mesh):
    return replace(mesh, surface=None, parameters=None)


@pytest.mark.parametrize("exact", [True, False], ids=["exact", "plain"])
@pytest.mark.parametrize(
    ("mesh", "form"),
    [
        (flat_mirror(), Form.FLAT),
        (spherical_mirror(), Form.CONVEX),
        (spherical_mirror(-1.4), Form.CONCAVE),
        (BALL, Form.CONVEX),
    ],
    ids=["flat", "convex", "concave", "ball"],
)
def test_what_curves_one_way_is_one_part(mesh, form, exact):
    parts = curvature_parts(mesh if exact else plain(mesh))
    assert (parts.form == form).all() and (parts.part == 0).all()


@pytest.mark.parametrize("exact", [True, False], ids=["exact", "plain"])
def test_a_ring_is_convex_outside_and_a_saddle_inside(exact):
    mesh = next(mesh for mesh in make("torus").meshes if mesh.specular)
    mesh = mesh if exact else plain(mesh)
    parts = curvature_parts(mesh)
    assert {int(form) for form in np.unique(parts.form)} == {Form.CONVEX, Form.SADDLE}
    offset = np.asarray(mesh.positions, float)[mesh.faces].mean(axis=1) - MIDDLE
    away = np.linalg.norm(offset - np.outer(offset @ AXIS, AXIS), axis=1)
    clear = np.abs(away - MAJOR) > 0.2 * MINOR
    assert ((parts.form == Form.CONVEX) == (away > MAJOR))[clear].all()
    if exact:
        assert len(np.unique(parts.part)) == 2


def test_a_saddle_and_a_cylinder_are_what_they_are_called():
    forms = [set(curvature_parts(mesh).form.tolist()) for mesh in make("saddle").meshes if mesh.specular]
    assert {Form.SADDLE} in forms and any(form in ({Form.CONVEX}, {Form.CONCAVE}) for form in forms)


def test_the_parts_of_a_form_that_do_not_touch_are_several():
    two = replace(
        plain(BALL),
        positions=np.concatenate([BALL.positions, BALL.positions + np.array([5.0, 0.0, 0.0])]),
        normals=np.concatenate([BALL.normals, BALL.normals]),
        faces=np.concatenate([BALL.faces, BALL.faces + len(BALL.positions)]),
    )
    parts = curvature_parts(two)
    count = len(BALL.faces)
    assert len(np.unique(parts.part)) == 2 and parts.part[0] != parts.part[-1]
    assert len(np.unique(parts.part[:count])) == len(np.unique(parts.part[count:])) == 1


def test_triangles_that_share_a_corner_only_are_two_parts():
    flat = plain(flat_mirror())
    # What they share comes last in the order of places, where edges that end there stand together.
    positions = np.array([[2, 0, 0], [0, 1, 0], [0, 0, 0], [1, -0.5, 0], [1, -1, 0]], np.float32)
    faces = np.array([[0, 1, 2], [0, 3, 4]], np.int32)
    two = replace(flat, positions=positions, faces=faces, normals=np.tile(np.float32([0, 0, 1]), (5, 1)))
    assert len(np.unique(curvature_parts(two).part)) == 2


def test_the_mirror_is_parted_whatever_its_size():
    for scale in (1e-3, 1e3):
        small = replace(plain(BALL), positions=BALL.positions * scale)
        assert (curvature_parts(small).form == Form.CONVEX).all()
