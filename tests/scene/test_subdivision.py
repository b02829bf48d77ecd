"""Subdivided meshes: on the exact surface, without cracks, whatever their parameters do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from curved_surfaces import mesh_on, sphere_surface, torus_surface, wavy
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import flat_mirror, open_edges, spherical_mirror

from anamorph.base.errors import AnamorphError
from anamorph.gallery.spheres import mirror_ball
from anamorph.gallery.teapot import teapot
from anamorph.scene.model import Mesh, Mirror
from anamorph.scene.subdivision import split, subdivided
from anamorph.scene.triangles import doubled_areas, has_area
from anamorph.surfaces.even_asphere import EvenAsphere
from anamorph.surfaces.sphere import Sphere
from anamorph.surfaces.toroid import Toroid

TILTED = np.array([[0.8, 0.0, -0.6], [0.36, 0.8, 0.48], [0.48, -0.6, 0.64]])


POLE = next(mesh for mesh in teapot((0.0, 0.0, 0.0), 0.16, 20.0, Mirror(), 7) if mesh.name == "teapot/lid-0")
MESHES = {
    "plane": flat_mirror(),
    "sphere": spherical_mirror(),
    "concave sphere": spherical_mirror(-1.4),
    "whole sphere": mirror_ball("ball", (0.3, -0.2, 0.1), 0.6, 6, 9),
    "patch": mesh_on(wavy(), (0, 0), (1, 1)),
    "pole of a patch": POLE,
    "concave patch": mesh_on(wavy(), (0, 0), (1, 1), side=-1.0),
    "whole sphere of NURBS": mesh_on(sphere_surface(), (0, 0), (4, 2), (8, 6)),
    "torus of NURBS": mesh_on(torus_surface(1.0, 0.4), (0, 0), (4, 4), (9, 6)),
    "toroid": mesh_on(Toroid(np.array([0.0, 0.1, 0.2]), 5.0, -2.0, TILTED), (-0.1, -0.1), (0.1, 0.12)),
    "asphere": mesh_on(EvenAsphere(np.zeros(3), 4.0, -1.5, (30.0,), TILTED), (-0.1, -0.1), (0.1, 0.12)),
}
CLOSED = ["whole sphere", "whole sphere of NURBS", "torus of NURBS"]


def off_surface(name, points):
    """The distance of points (N, 3) from the exact surface, by its equation, over the surface's size."""
    surface = MESHES[name].surface
    match name:
        case "plane":
            return points[:, 2]
        case "sphere" | "concave sphere" | "whole sphere":
            return np.linalg.norm(points - surface.center, axis=1) / surface.radius - 1.0
        case "whole sphere of NURBS":
            return np.linalg.norm(points - [0.3, -0.2, 0.5], axis=1) / 1.4 - 1.0
        case "torus of NURBS":
            return np.hypot(np.hypot(points[:, 0], points[:, 1]) - 1.0, points[:, 2]) - 0.4
    return np.zeros(len(points))


@pytest.mark.parametrize("name", MESHES)
def test_every_vertex_is_on_the_surface_with_its_exact_normal_on_the_meshs_side(name):
    mesh = MESHES[name]
    finer = subdivided(mesh, 2)
    count = len(mesh.positions)
    assert len(finer.faces) == 16 * len(mesh.faces)
    for field in ("positions", "normals", "parameters"):
        assert (getattr(finer, field)[:count] == getattr(mesh, field)).all()
        assert getattr(finer, field).dtype == getattr(mesh, field).dtype and np.isfinite(getattr(finer, field)).all()
    exact = mesh.surface.position(finer.parameters)
    assert np.abs(off_surface(name, exact)).max() < 1e-12
    # Rounded to a nanometre first: what is nought but for the last digit is nought from both sides of a border.
    assert (finer.positions[count:] == np.round(exact[count:], 9).astype(finer.positions.dtype)).all()
    side = np.sum(mesh.surface.normal(mesh.parameters) * mesh.normals, axis=1).mean()
    np.testing.assert_allclose(finer.normals, np.sign(side) * mesh.surface.normal(finer.parameters), atol=2e-7)


@pytest.mark.parametrize("name", MESHES)
def test_triangles_keep_their_side_and_stay_where_their_parents_are(name):
    mesh = MESHES[name]
    finer = subdivided(mesh, 1)
    area, around = doubled_areas(finer.positions, finer.faces), finer.normals[finer.faces].mean(axis=1)
    assert (np.sum(area * around, axis=1) > 0.0).all()
    corners = np.asarray(mesh.positions, float)[mesh.faces]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    parts = np.asarray(finer.positions, float)[finer.faces].reshape(-1, 12, 3)
    assert (np.linalg.norm(parts - corners.mean(axis=1)[:, None], axis=2).max(axis=1) < longest).all()


@pytest.mark.parametrize("name", MESHES)
def test_there_are_no_cracks(name):
    mesh = MESHES[name]
    before = len(open_edges(mesh))
    assert (before == 0) == (name in CLOSED)
    for levels in (1, 2):
        finer = subdivided(mesh, levels)
        assert len(open_edges(finer)) == 2**levels * before
        assert has_area(finer.positions, finer.faces).all()


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 0.1, 0.5, 0.9, 1.0]), st.sampled_from(sorted(MESHES)))
@settings(max_examples=40)
def test_any_edges_can_be_cut(seed, share, name):
    mesh = MESHES[name]
    chosen = np.random.default_rng(seed).random(10_000) < share
    places = np.unique(mesh.positions + np.float32(0), axis=0, return_inverse=True)[1].reshape(-1)[mesh.faces]
    cut = chosen[(places + np.roll(places, -1, axis=1)) * 7919 % 10_000]
    finer = split(mesh, cut)
    assert len(finer.faces) == len(mesh.faces) + cut.sum()
    start, stop = mesh.positions[mesh.faces], np.roll(mesh.positions[mesh.faces], -1, axis=1)
    edges = {(tuple(a), tuple(b)) for a, b in zip((start + 0)[cut].tolist(), (stop + 0)[cut].tolist(), strict=True)}
    parent = np.repeat(np.arange(len(mesh.faces)), 1 + cut.sum(axis=1))
    apart = np.linalg.norm(finer.positions[finer.faces].mean(axis=1) - start.mean(axis=1)[parent], axis=1)
    assert (apart <= np.linalg.norm(stop - start, axis=2).max(axis=1)[parent]).all()
    open_before = open_edges(mesh)
    assert len(open_edges(finer)) == len(open_before) + len(open_before & edges)
    area, around = doubled_areas(finer.positions, finer.faces), finer.normals[finer.faces].mean(axis=1)
    assert (np.sum(area * around, axis=1) > 0.0).all()


def test_level_nought_changes_nothing_and_two_levels_are_one_twice():
    mesh = MESHES["patch"]
    assert subdivided(mesh, 0) is mesh
    once, twice = subdivided(subdivided(mesh, 1), 1), subdivided(mesh, 2)
    assert (once.positions == twice.positions).all() and (once.faces == twice.faces).all()


def test_on_a_plane_the_four_parts_are_equal_and_the_middle_one_is_last():
    mesh = flat_mirror()
    parts = np.linalg.norm(doubled_areas(mesh.positions, subdivided(mesh, 0).faces), axis=1)
    finer = subdivided(mesh, 1)
    areas = np.linalg.norm(doubled_areas(finer.positions, finer.faces), axis=1).reshape(-1, 4)
    assert areas == pytest.approx(np.repeat(parts[:, None] / 4.0, 4, axis=1), rel=1e-6)
    middle = finer.positions[finer.faces[3::4]].mean(axis=1)
    assert middle == pytest.approx(mesh.positions[mesh.faces].mean(axis=1), abs=1e-6)


def test_the_area_of_a_ball_comes_four_times_nearer_with_each_level():
    ball = MESHES["whole sphere"]
    missing = []
    for levels in range(4):
        finer = subdivided(ball, levels)
        area = np.linalg.norm(doubled_areas(finer.positions, finer.faces), axis=1).sum() / 2.0
        missing.append(4.0 * np.pi * 0.6**2 - area)
    assert np.array(missing[:-1]) / missing[1:] == pytest.approx(4.0, abs=0.3)


def solid_angles(corners):
    """Of triangles (F, 3, 3) of unit vectors, by the formula of van Oosterom and Strackee (1983)."""
    a, b, c = np.moveaxis(corners, 1, 0)
    one, two, three = (np.sum(x * y, axis=1) for x, y in ((a, b), (b, c), (c, a)))
    return 2.0 * np.arctan2(np.linalg.det(corners), 1.0 + one + two + three)


longitude = st.one_of(st.sampled_from([-np.pi, -np.pi / 2, 0.0, 3.1, np.pi]), st.floats(-np.pi, np.pi))
latitude = st.one_of(st.sampled_from([-np.pi / 2, 0.0, 1.57, np.pi / 2]), st.floats(-np.pi / 2, np.pi / 2))


@given(st.lists(st.tuples(longitude, latitude), min_size=3, max_size=3), st.floats(1e-2, 1e2), st.integers(1, 3))
def test_parts_of_any_triangle_on_a_sphere_cover_it_once(angles, radius, levels):
    sphere = Sphere(np.zeros(3), radius, TILTED)
    uv = np.array(angles)
    corners = sphere.normal(uv)
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1)
    if np.linalg.det(corners) < 0.0:
        uv, corners = uv[::-1], corners[::-1]
    if sides.min() < 1e-2 or sides.max() > 1.9 or np.linalg.det(corners) < 1e-3:
        return
    mesh = Mesh("triangle", corners * radius, np.array([[0, 1, 2]]), corners, Mirror(), surface=sphere, parameters=uv)
    finer = subdivided(mesh, levels)
    parts = solid_angles(sphere.normal(finer.parameters)[finer.faces])
    assert parts.min() > 0.0
    # Positions are rounded to a nanometre, and the next level halves the edges between them.
    assert parts.sum() == pytest.approx(solid_angles(corners[None])[0], rel=1e-6, abs=1e-8 / radius)


def test_an_edge_through_the_middle_of_a_sphere_is_refused():
    sphere = Sphere(np.zeros(3), 1.0)
    uv = np.array([[0.0, 0.0], [np.pi, 0.0], [0.0, 1.0]])
    mesh = Mesh("m", sphere.position(uv), np.array([[0, 1, 2]]), sphere.normal(uv), surface=sphere, parameters=uv)
    with pytest.raises(AnamorphError, match=r"^sphere: [^\n]*more triangles$"):
        subdivided(mesh, 1)


@pytest.mark.parametrize("name", ["whole sphere of NURBS", "torus of NURBS"])
def test_seams_may_be_sewn_up(name):
    mesh = MESHES[name]
    places, first, rows = np.unique(mesh.positions + np.float32(0), axis=0, return_index=True, return_inverse=True)
    sewn = replace(
        mesh,
        positions=places,
        normals=mesh.normals[first],
        parameters=mesh.parameters[first],
        faces=rows.reshape(-1)[mesh.faces].astype(np.int32),
    )
    finer, apart = subdivided(sewn, 2), subdivided(mesh, 2)
    assert not open_edges(finer)
    assert np.abs(off_surface(name, mesh.surface.position(finer.parameters))).max() < 1e-12
    np.testing.assert_allclose(finer.positions[finer.faces], apart.positions[apart.faces], atol=2e-7)


def test_a_pole_leads_nowhere_where_its_neighbours_lie_across_a_seam():
    surface = sphere_surface()
    uv = np.array([[2.0, 2.0], [0.1, 1.5], [3.9, 1.5]])
    for order in ([0, 1, 2], [1, 2, 0], [2, 0, 1]):
        middle = surface.between(uv[None, order], surface.position(uv)[None, order])[0]
        assert min(middle[0], 4.0 - middle[0]) < 1e-9 and middle[1] == pytest.approx(5.0 / 3.0)


def test_neighbouring_patches_of_a_teapot_still_meet():
    pot = teapot((0.0, 0.751, 0.0), 0.16, 20.0, Mirror(), 9)
    before = len(open_edges(*pot))
    assert before < len(open_edges(*pot[:1])) * 8, "most borders are shared"
    assert len(open_edges(*(subdivided(patch, 2) for patch in pot))) == 4 * before


def test_texture_coordinates_and_colours_are_means():
    mesh = MESHES["plane"]
    uv = mesh.parameters.astype(np.float32)
    painted = replace(mesh, texcoords=3.0 * uv - 1.0, colors=np.column_stack([uv, 1.0 - uv[:, 0]]).astype(np.float32))
    finer = subdivided(painted, 3)
    assert finer.texcoords == pytest.approx(3.0 * finer.parameters - 1.0, abs=1e-6)
    assert finer.colors[:, 2] == pytest.approx(1.0 - finer.parameters[:, 0], abs=1e-6)
    assert finer.texcoords.dtype == finer.colors.dtype == np.float32 and finer.material is painted.material
    assert subdivided(mesh, 1).texcoords is None


@pytest.mark.parametrize(
    ("mesh", "levels", "word"),
    [
        (replace(flat_mirror(), surface=None), 1, "no exact surface"),
        (replace(flat_mirror(), parameters=None), 1, "no exact surface"),
        (flat_mirror(), -1, "levels is -1"),
        (flat_mirror(), 9, "levels is 9"),
    ],
)
def test_what_cannot_be_subdivided_is_refused_in_one_line(mesh, levels, word):
    with pytest.raises(AnamorphError, match=rf"^part 'mirror': [^\n]*{word}[^\n]*$"):
        subdivided(mesh, levels)
