"""`auto`: whichever of searching and tracing costs less, and within half a pixel of the reference either way."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import anamorph as an
from anamorph import gallery
from anamorph.cameras import panorama
from anamorph.frame import Status, View
from anamorph.measure.errors import measure
from anamorph.methods import Specification
from anamorph.methods.auto import AutoDrawing, Costs, Options, auto
from anamorph.methods.pervertex import SurfaceDrawing
from anamorph.methods.raytrace import TracedDrawing
from anamorph.methods.stage import Stage

SIZE = (160, 120)

SEARCH = Costs(search=0.0, triangle=0.0, patch=0.0, trace=100.0)
TRACE = Costs(search=1e6, triangle=0.0, patch=0.0, trace=100.0)


def opened(name, costs, monkeypatch):
    scene = gallery.make(name)
    monkeypatch.setattr(auto, "costs_here", lambda: costs)
    return Specification.parse("auto").open(View(scene, scene.camera, SIZE)), scene


@pytest.mark.parametrize(("costs", "kind"), [(SEARCH, SurfaceDrawing), (TRACE, TracedDrawing), (None, SurfaceDrawing)])
def test_what_costs_less_is_taken(costs, kind, monkeypatch):
    session, scene = opened("flat-mirror", costs, monkeypatch)
    session.draw(scene.camera)
    assert type(session.diagnostics()["chosen"]) is kind


@pytest.mark.parametrize("costs", [SEARCH, TRACE], ids=["searched", "traced"])
@pytest.mark.parametrize("name", ["car-mirror", "spectacles-plus", "saddle", "facing-mirrors"])
def test_either_way_every_pixel_is_within_half_a_pixel(name, costs, monkeypatch):
    session, scene = opened(name, costs, monkeypatch)
    session.draw(scene.camera)
    frame = session.frame(seen=True)
    reference = an.render(scene, method="raytrace:dispersion=false", size=SIZE, seen=True)
    maps = measure(reference, frame).maps
    counted = maps.specular & ~maps.silhouette
    assert counted.sum() > 500
    assert not ((maps.pixels > 0.5) | maps.other_object)[counted].any()
    assert not (frame.status == Status.DOUBTFUL).any()


def test_a_closer_eye_may_change_the_way(monkeypatch):
    session, scene = opened("flat-mirror", replace(TRACE, search=20.0, patch=2e5), monkeypatch)
    eye, target = np.array(scene.camera.position), np.array(scene.camera.target)
    chosen = []
    for share in (20.0, 0.0):
        session.draw(replace(scene.camera, position=tuple((eye + share * (eye - target)).tolist())))
        chosen.append(type(session.diagnostics()["chosen"]))
    assert chosen == [TracedDrawing, SurfaceDrawing]


def test_a_ray_mesh_is_traced():
    scene = gallery.make("flat-mirror")
    camera = panorama(scene.camera, (64, 32))
    frame = an.render(scene, method="auto", camera=camera, size=(64, 32))
    assert np.array_equal(frame.color, an.render(scene, method="raytrace", camera=camera, size=(64, 32)).color)


def test_what_is_expected_of_a_mirror_is_its_area_in_the_image():
    scene = gallery.make("car-mirror")
    (expected,) = AutoDrawing(Stage(View(scene, scene.camera, SIZE)), Options(), None).expected(scene.camera)
    shown = (an.render(scene, method="raytrace", size=SIZE, seen=True).specular > 0).sum()
    # The frame hides a little of it.
    assert 1.0 <= expected.pixels / shown < 1.2
    assert (expected.lines, expected.interfaces, expected.patches, expected.bent_in) == (1, 1, 1, False)
    assert expected.maps == 1


@pytest.mark.parametrize(("name", "maps"), [("spectacles-minus", 1), ("magnifier", 2)])
def test_rays_that_converge_are_looked_for_in_two_maps(name, maps):
    scene = gallery.make(name)
    (expected,) = AutoDrawing(Stage(View(scene, scene.camera, SIZE)), Options(), None).expected(scene.camera)
    assert expected.maps == maps


def test_a_lens_has_three_lines_and_two_interfaces():
    scene = gallery.make("spectacles-minus")
    (expected,) = AutoDrawing(Stage(View(scene, scene.camera, SIZE)), Options(), None).expected(scene.camera)
    assert (expected.lines, expected.interfaces) == (3, 2)


def test_a_scene_without_mirrors_is_drawn():
    scene = gallery.make("car-mirror")
    plain = replace(scene, meshes=tuple(mesh for mesh in scene.meshes if not mesh.specular))
    assert np.array_equal(
        an.render(plain, method="auto", size=SIZE).color, an.render(plain, method="raytrace", size=SIZE).color
    )
