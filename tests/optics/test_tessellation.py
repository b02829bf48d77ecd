"""What cutting the triangles of mirrors and lenses keeps: closed seams, neighbours, a limit, the image."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from curved_surfaces import mesh_on, torus_surface
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import CAMERA, SIZE, drawn, flat_mirror, open_edges, scene_with, spherical_mirror, surroundings

from anamorph.gallery.teapot import teapot
from anamorph.lenses.making import worn_lens
from anamorph.lenses.prescription import Prescription
from anamorph.measure.errors import silhouettes
from anamorph.optics import tessellation
from anamorph.optics.tessellation import OUTLINE, outline_errors, outlined_scene
from anamorph.scene.camera import Camera
from anamorph.scene.model import Diffuse, Mirror, Scene
from anamorph.scene.subdivision import subdivided

POT = Camera((0.2, 0.35, 0.45), (0.0, 0.07, 0.0), field_of_view=30.0)
QUARTER = Camera((0.2, 0.6, 1.4), (0.15, 0.15, 0.0), field_of_view=30.0)


def pot_scene(vertices=5):
    return scene_with(*teapot((0.0, 0.0, 0.0), 0.16, 20.0, Mirror(), vertices), camera=POT)


def pot_of(scene):
    return [mesh for mesh in scene.meshes if mesh.specular]


def quarter():
    """A quarter of a torus, which turns away from its camera somewhere."""
    return mesh_on(torus_surface(0.3, 0.12), (0, 0), (1, 4), (6, 12))


@pytest.mark.parametrize("levels", [1, 2])
def test_a_refined_teapot_has_no_cracks_though_its_patches_differ(levels, monkeypatch):
    monkeypatch.setattr(tessellation, "MOST_CUTS", levels)
    scene = pot_scene()
    refined = pot_of(outlined_scene(scene, POT, (800, 600)))
    grown = {len(new.faces) / len(old.faces) for new, old in zip(refined, pot_of(scene), strict=True)}
    assert len(grown) > 4, "each patch as it needs"
    # Uniformly subdivided patches meet, so the places on their borders are all that may be open.
    finest = [subdivided(patch, levels) for patch in pot_of(scene)]
    border = {end for edge in open_edges(*pot_of(scene), *finest) for end in edge}
    assert {end for edge in open_edges(*refined) for end in edge} <= border


@given(
    st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1),
    st.sampled_from([1.5, 3.0]),
    st.sampled_from([(400, 300), (1600, 1200)]),
)
@settings(max_examples=8)
def test_quarters_of_a_torus_stay_closed_from_everywhere(toward, distance, size):
    quarters = [mesh_on(torus_surface(0.3, 0.12), (i, 0), (i + 1, 4), (6, 12)) for i in range(4)]
    assert not open_edges(*quarters)
    eye = tuple(distance * np.array(toward) / np.linalg.norm(toward))
    camera = Camera(eye, (0.0, 0.0, 0.0), up=(0.1, 1.0, 0.2), field_of_view=20.0)
    refined = outlined_scene(Scene("torus", tuple(quarters), camera), camera, size)
    assert sum(len(mesh.faces) for mesh in refined.meshes) > sum(len(mesh.faces) for mesh in quarters)
    assert not open_edges(*refined.meshes)


def test_only_what_errs_is_cut():
    scene = scene_with(quarter(), camera=QUARTER)
    refined = outlined_scene(scene, QUARTER, (800, 600))
    assert outline_errors(scene.meshes[0], QUARTER, (800, 600)).max() > 5.0
    assert outline_errors(refined.meshes[0], QUARTER, (800, 600)).max() <= OUTLINE
    uniform = scene.meshes[0]
    while outline_errors(uniform, QUARTER, (800, 600)).max() > OUTLINE:
        uniform = subdivided(uniform, 1)
    assert len(refined.meshes[0].faces) < len(uniform.faces)
    assert all(new is old for new, old in zip(refined.meshes[1:], scene.meshes[1:], strict=True))
    assert refined.camera is scene.camera and refined.sky is scene.sky


def test_there_are_never_more_triangles_than_allowed_and_the_worst_come_first(monkeypatch):
    scene = pot_scene()
    free = outlined_scene(scene, POT, (800, 600))
    counts = [sum(len(mesh.faces) for mesh in pot_of(each)) for each in (scene, free)]
    for most in (500, counts[0] + 6, 2000, 3000):
        monkeypatch.setattr(tessellation, "MOST_TRIANGLES", most)
        held = pot_of(outlined_scene(scene, POT, (800, 600)))
        count = sum(len(mesh.faces) for mesh in held)
        assert counts[0] <= count <= max(most, counts[0]) < counts[1]
        # One triangle with all its edges fits: it must be the worst.
        if most == counts[0] + 6:
            worst = np.argmax([outline_errors(mesh, POT, (800, 600)).max() for mesh in pot_of(scene)])
            assert len(held[worst].faces) > len(pot_of(scene)[worst].faces) and count <= most


def test_an_edge_shared_with_a_mesh_that_cannot_follow_stays_whole():
    patch = quarter()
    neighbour = replace(patch, name="back", faces=patch.faces[:, ::-1][:6], material=Diffuse(), surface=None)
    alone = outlined_scene(Scene("one", (patch,), QUARTER), QUARTER, (800, 600))
    beside = outlined_scene(Scene("two", (patch, neighbour), QUARTER), QUARTER, (800, 600))
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
    # Nearly edge on, so that its faces turn away somewhere.
    middle = lens.front.positions.mean(axis=0)
    camera = Camera(tuple(middle + np.array([0.2, 0.0, 0.01])), tuple(middle), field_of_view=20.0)
    refined = outlined_scene(Scene("lens", lens.meshes, camera), camera, (3200, 2400))
    assert max(len(face.faces) for face in refined.meshes[:2]) > len(lens.front.faces)
    assert not open_edges(*refined.meshes)


def test_a_ray_traced_image_stays_what_it_was():
    floor = replace(surroundings()[0], positions=surroundings()[0].positions * np.float32(0.5))
    fine = replace(QUARTER, position=(0.4, 1.2, 2.8))
    scene = Scene("traced", (subdivided(quarter(), 2), floor), fine)
    refined = outlined_scene(scene, fine, (3200, 2400))
    assert len(refined.meshes[0].faces) > len(scene.meshes[0].faces)
    before, after = drawn(scene, "raytrace"), drawn(refined, "raytrace")
    seen = ~silhouettes(before.object_id, before.specular)
    assert (before.specular == after.specular)[seen].all()
    np.testing.assert_allclose(after.position[seen], before.position[seen], atol=1e-4)
    np.testing.assert_allclose(after.color[seen], before.color[seen], atol=1e-3)


def test_scenes_without_exact_surfaces_and_fine_ones_stay_as_they_are():
    plain = replace(spherical_mirror(), surface=None)
    for scene in (scene_with(plain), scene_with(flat_mirror()), Scene("none", surroundings(), CAMERA)):
        refined = outlined_scene(scene, CAMERA, SIZE)
        assert all(new is old for new, old in zip(refined.meshes, scene.meshes, strict=True))
