"""How wrong interpolated normals are, in pixels, and scenes refined until they are right."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from curved_surfaces import mesh_on, sphere_surface, torus_surface, wavy
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import CAMERA, SIZE, drawn, flat_mirror, open_edges, scene_with, spherical_mirror, surroundings

from anamorph.base.errors import AnamorphError
from anamorph.gallery.spheres import mirror_ball
from anamorph.gallery.teapot import teapot
from anamorph.lenses.making import worn_lens
from anamorph.lenses.prescription import Prescription
from anamorph.measure.errors import silhouettes
from anamorph.optics import tessellation
from anamorph.optics.tessellation import normal_errors, refined_scene
from anamorph.scene.camera import Camera
from anamorph.scene.model import Diffuse, Glass, Mirror, Scene
from anamorph.scene.subdivision import subdivided
from anamorph.surfaces.bezier import BezierPatch
from anamorph.surfaces.even_asphere import EvenAsphere
from anamorph.surfaces.toroid import Toroid

AHEAD = Camera((0.0, 0.0, 2.0), (0.0, 0.0, 0.0), field_of_view=20.0)
PIXEL = 2.0 * np.tan(np.radians(10.0)) / 600
POT = replace(AHEAD, position=(0.2, 0.35, 0.45), target=(0.0, 0.07, 0.0), field_of_view=30.0)


def normal_error(mesh, camera, size):
    """What 99% of a mesh's image is better than, in pixels; 0 where it is not seen."""
    errors, areas = normal_errors(mesh, camera, size)
    order = np.argsort(errors)
    covered = np.cumsum(areas[order])
    return float(errors[order][np.searchsorted(covered, 0.99 * covered[-1])])


def tilted(mesh, angle, axis=(1.0, 0.0, 0.0)):
    """The mesh with all its normals turned by a small angle about an axis across them."""
    normals = mesh.normals + angle * np.cross(axis, mesh.normals)
    return replace(mesh, normals=(normals / np.linalg.norm(normals, axis=1, keepdims=True)).astype(np.float32))


def small(material=None, curvature=0.0):
    """A mirror a few centimetres large at the origin, facing +z."""
    mesh = mesh_on(EvenAsphere(np.zeros(3), curvature), (-0.01, -0.01), (0.01, 0.01), (8, 8))
    return mesh if material is None else replace(mesh, material=material)


@pytest.mark.parametrize("angle", [1e-3, -4e-3])
@pytest.mark.parametrize("curvature", [0.0, 1.0, 5.0, -0.25])
def test_a_tilted_normal_turns_the_ray_twice_over_what_a_pixel_turns_it(angle, curvature):
    # A mirror of curvature k at distance D turns the reflected ray by 1 + 2 k D of the eye's own turn; below 1 it
    # counts as 1.
    turn = max(abs(1.0 + 2.0 * curvature * 2.0), 1.0)
    error = normal_error(tilted(small(curvature=curvature), angle), AHEAD, (800, 600))
    assert error == pytest.approx(2.0 * abs(angle) / (turn * PIXEL), rel=0.03)


def test_glass_counts_as_much_as_it_bends():
    for index, side in [(1.5, 1.0), (1.8, 1.0), (1.5, -1.0)]:
        eye = replace(AHEAD, position=(0.0, 0.0, 2.0 * side))
        error = normal_error(tilted(small(Glass(index)), 1e-3), eye, (800, 600))
        assert error == pytest.approx((index - 1.0) * 1e-3 / PIXEL, rel=0.02)


def test_where_a_mirror_bends_but_one_way_an_error_counts_more_the_other_way():
    mesh = mesh_on(Toroid(np.zeros(3), 5.0, 0.0), (-0.01, -0.01), (0.01, 0.01), (8, 8))
    for axis, turn in [((1.0, 0.0, 0.0), 1.0), ((0.0, 1.0, 0.0), 1.0 + 2.0 * 5.0 * 2.0)]:
        error = normal_error(tilted(mesh, 1e-3, axis), AHEAD, (800, 600))
        assert error == pytest.approx(2e-3 / (turn * PIXEL), rel=0.05)


def test_uneven_parameters_are_no_error_of_the_normals():
    # The parameters of a rational sphere run faster in the middle of each quarter than at its ends.
    mesh = mesh_on(sphere_surface(np.zeros(3), 0.2), (0.1, 0.6), (0.5, 0.9), (3, 3))
    middle, outside = mesh.positions.mean(axis=0), mesh.normals.mean(axis=0)
    camera = Camera(tuple(middle + 2.0 * outside), tuple(middle), field_of_view=5.0)
    assert normal_error(mesh, camera, (800, 600)) < 1.0


def test_what_is_smaller_than_a_pixel_is_not_cut():
    patch, camera = gentle()
    scene = scene_with(subdivided(patch, 2), camera=camera)
    assert normal_error(scene.meshes[0], camera, (40, 30)) > 0.01
    assert refined_scene(scene, (40, 30), 0.001).meshes[0] is scene.meshes[0]


def test_areas_are_those_of_the_image_and_what_is_not_seen_has_no_error():
    mesh = tilted(small(), 1e-3)
    errors, areas = normal_errors(mesh, AHEAD, (800, 600))
    assert areas.sum() == pytest.approx((0.02 / 2.0 / PIXEL) ** 2, rel=1e-3)
    assert errors.shape == areas.shape == (len(mesh.faces),)
    behind = replace(AHEAD, position=(0.0, 0.0, -2.0))
    away = replace(AHEAD, target=(0.0, 0.0, 4.0))
    aside = replace(AHEAD, target=(2.0, 0.0, 0.0))
    partly = replace(AHEAD, target=(0.0, 2.0 * np.tan(np.radians(10.0)), 0.0))
    assert normal_error(mesh, partly, (800, 600)) > 0.0
    for camera in (behind, away, aside):
        assert not any(values.any() for values in normal_errors(mesh, camera, (800, 600)))
        assert normal_error(mesh, camera, (800, 600)) == 0.0


def test_what_is_behind_the_eye_is_not_seen():
    ball = mirror_ball("ball", (0.0, 0.0, 0.0), 0.6, 12, 24)
    concave = replace(ball, faces=ball.faces[:, ::-1], normals=-ball.normals, material=Glass())
    camera = Camera((0.0, 0.0, 0.1), (0.3, 0.1, -1.0), field_of_view=60.0)
    errors, areas = normal_errors(concave, camera, (800, 600))
    behind = (concave.positions - camera.position) @ camera.axes()[2] <= 0.0
    assert not areas[behind[concave.faces].any(axis=1)].any() and np.isfinite(errors).all()
    assert 800 * 600 < areas.sum() < 2 * 800 * 600


def test_flat_mirrors_are_right_and_spheres_nearly():
    assert normal_error(flat_mirror(), CAMERA, SIZE) < 1e-3
    assert normal_error(spherical_mirror(), CAMERA, SIZE) < 0.01


@pytest.mark.parametrize("surface", [wavy(), torus_surface(0.3, 0.12)], ids=["patch", "torus"])
def test_the_error_falls_four_times_with_each_level(surface):
    mesh = mesh_on(surface, (0, 0), (1, 1), (8, 8))
    middle = mesh.positions.mean(axis=0)
    outside = mesh.normals.mean(axis=0)
    camera = Camera(tuple(middle + 2.0 * outside), tuple(middle), field_of_view=20.0)
    errors = []
    for _ in range(4):
        errors.append(normal_error(mesh, camera, (800, 600)))
        mesh = subdivided(mesh, 1)
    assert np.array(errors[:-1]) / errors[1:] == pytest.approx(4.0, abs=0.8)


def gentle():
    """A patch that is but little bent, and the camera that looks at it."""
    mesh = mesh_on(BezierPatch(wavy().control * (1.0, 1.0, 0.2)), (0, 0), (1, 1))
    return mesh, Camera((0.15, 0.15, 1.5), (0.15, 0.15, 0.0), field_of_view=20.0)


def pot_scene(vertices=5):
    return scene_with(*teapot((0.0, 0.0, 0.0), 0.16, 20.0, Mirror(), vertices), camera=POT)


def pot_of(scene):
    return [mesh for mesh in scene.meshes if mesh.specular]


@pytest.mark.parametrize("levels", [1, 2])
def test_a_refined_teapot_has_no_cracks_though_its_patches_differ(levels, monkeypatch):
    monkeypatch.setattr(tessellation, "MOST_CUTS", levels)
    scene = pot_scene()
    refined = pot_of(refined_scene(scene, (800, 600), 0.5))
    grown = {len(new.faces) / len(old.faces) for new, old in zip(refined, pot_of(scene), strict=True)}
    assert len(grown) > 4, "each patch as it needs"
    # Uniformly subdivided patches meet, so the places on their borders are all that may be open.
    finest = [subdivided(patch, levels) for patch in pot_of(scene)]
    border = {end for edge in open_edges(*pot_of(scene), *finest) for end in edge}
    assert {end for edge in open_edges(*refined) for end in edge} <= border


@given(
    st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1),
    st.sampled_from([1.5, 3.0]),
    st.sampled_from([0.3, 3.0]),
)
@settings(max_examples=8)
def test_quarters_of_a_torus_stay_closed_from_everywhere(toward, distance, tolerance):
    torus = torus_surface(0.3, 0.12)
    quarters = [mesh_on(torus, (i, 0), (i + 1, 4), (6, 12)) for i in range(4)]
    assert not open_edges(*quarters)
    eye = tuple(distance * np.array(toward) / np.linalg.norm(toward))
    scene = Scene("torus", tuple(quarters), Camera(eye, (0.0, 0.0, 0.0), up=(0.1, 1.0, 0.2), field_of_view=20.0))
    refined = refined_scene(scene, (400, 300), tolerance)
    assert sum(len(mesh.faces) for mesh in refined.meshes) > sum(len(mesh.faces) for mesh in quarters)
    assert not open_edges(*refined.meshes)


def test_refining_brings_the_error_below_the_tolerance():
    patch, camera = gentle()
    scene = scene_with(patch, camera=camera)
    assert normal_error(scene.meshes[0], scene.camera, (800, 600)) > 5.0
    refined = refined_scene(scene, (800, 600), 0.5)
    errors, areas = normal_errors(refined.meshes[0], scene.camera, (800, 600))
    assert errors[areas > 1.0].max() <= 0.5
    uniform = scene.meshes[0]
    for _ in range(4):
        if normal_error(uniform, scene.camera, (800, 600)) > 0.5:
            uniform = subdivided(uniform, 1)
    assert len(refined.meshes[0].faces) < len(uniform.faces)
    assert all(new is old for new, old in zip(refined.meshes[1:], scene.meshes[1:], strict=True))
    assert refined.camera is scene.camera and refined.sky is scene.sky


def test_there_are_never_more_triangles_than_allowed_and_the_worst_come_first(monkeypatch):
    scene = pot_scene()
    free = refined_scene(scene, (800, 600), 0.5)
    counts = [sum(len(mesh.faces) for mesh in pot_of(each)) for each in (scene, free)]
    for most in (500, counts[0] + 6, 2000, 3000):
        monkeypatch.setattr(tessellation, "MOST_TRIANGLES", most)
        held = pot_of(refined_scene(scene, (800, 600), 0.5))
        count = sum(len(mesh.faces) for mesh in held)
        assert counts[0] <= count <= max(most, counts[0]) < counts[1]
        # One triangle with all its edges fits: it must be the worst.
        if most == counts[0] + 6:
            errors = [normal_errors(mesh, POT, (800, 600)) for mesh in pot_of(scene)]
            worst = max(range(len(errors)), key=lambda i: (errors[i][0] * (errors[i][1] > 1.0)).max())
            assert len(held[worst].faces) > len(pot_of(scene)[worst].faces) and count <= most


def test_an_edge_shared_with_a_mesh_that_cannot_follow_stays_whole():
    patch, camera = gentle()
    neighbour = replace(patch, name="back", faces=patch.faces[:, ::-1][:6], material=Diffuse(), surface=None)
    alone = refined_scene(Scene("one", (patch,), camera), (800, 600), 0.5)
    beside = refined_scene(Scene("two", (patch, neighbour), camera), (800, 600), 0.5)
    shared = {edge[::-1] for edge in open_edges(neighbour)} | open_edges(neighbour)

    def edges(mesh):
        start = mesh.positions[mesh.faces].reshape(-1, 3) + 0
        stop = np.roll(mesh.positions[mesh.faces], -1, axis=1).reshape(-1, 3) + 0
        return set(zip(map(tuple, start.tolist()), map(tuple, stop.tolist()), strict=True))

    assert shared & edges(patch) <= edges(beside.meshes[0])
    assert not shared & edges(patch) <= edges(alone.meshes[0])
    assert len(beside.meshes[0].faces) > 2 * len(patch.faces)


def test_a_lens_stays_closed_around_its_edge():
    lens = worn_lens(Prescription(-6.0, cylinder=-3.0, axis=30.0), (0.0, 0.0, 0.0), (0.0, 0.0, -1.0))
    assert not open_edges(*lens.meshes)
    camera = Camera((0.0, 0.0, 0.0), (0.0, 0.0, -1.0), field_of_view=70.0)
    refined = refined_scene(Scene("lens", lens.meshes, camera), (800, 600), 1e-4)
    assert max(len(face.faces) for face in refined.meshes[:2]) > 2 * len(lens.front.faces)
    assert not open_edges(*refined.meshes)


def test_a_ray_traced_image_stays_what_it_was():
    patch, camera = gentle()
    floor = replace(surroundings()[0], positions=surroundings()[0].positions * np.float32(0.5))
    scene = Scene("traced", (patch, floor), camera)
    before, after = drawn(scene, "raytrace"), drawn(refined_scene(scene, SIZE, 0.5), "raytrace")
    seen = ~silhouettes(before.object_id, before.specular)
    assert (before.specular == after.specular)[seen].all()
    np.testing.assert_allclose(after.position[seen], before.position[seen], atol=1e-4)
    np.testing.assert_allclose(after.color[seen], before.color[seen], atol=1e-3)


def test_scenes_without_exact_surfaces_and_fine_ones_stay_as_they_are():
    plain = replace(spherical_mirror(), surface=None)
    for scene in (scene_with(plain), scene_with(flat_mirror()), Scene("none", surroundings(), CAMERA)):
        refined = refined_scene(scene, SIZE, 0.5)
        assert all(new is old for new, old in zip(refined.meshes, scene.meshes, strict=True))


@pytest.mark.parametrize("tolerance", [0.0, -1.0, np.nan, np.inf])
def test_a_tolerance_must_be_a_length(tolerance):
    with pytest.raises(AnamorphError, match=r"^tolerance is [^\n]*positive number of pixels$"):
        refined_scene(scene_with(flat_mirror()), SIZE, tolerance)


def test_a_mesh_without_an_exact_surface_cannot_be_judged():
    with pytest.raises(AnamorphError, match=r"^part 'mirror': has no exact surface [^\n]*$"):
        normal_error(replace(flat_mirror(), surface=None), CAMERA, SIZE)
