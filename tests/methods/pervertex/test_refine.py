"""Refinement and tolerance: a fragment's own ray, its steps through the map, and the tiles that it has traced."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from error_twin import seen_directions
from scenes import drawn, flat_mirror, open_view, scene_with, spherical_mirror

from anamorph.base.errors import AnamorphError
from anamorph.frame import Status
from anamorph.gallery import make
from anamorph.gallery.solids import box
from anamorph.gpu.targets import read_texture
from anamorph.measure.angles import angles_between, normalized
from anamorph.measure.errors import measure
from anamorph.methods.pervertex import pervertex
from anamorph.methods.pervertex.mend import TILE, doubtful_tiles
from anamorph.scene.model import Diffuse

CURVED = scene_with(spherical_mirror(count=6))


@pytest.fixture(scope="module")
def reference():
    return drawn(CURVED, "raytrace")


def test_one_step_reaches_the_truth(reference):
    plain, refined = (measure(reference, drawn(CURVED, f"pervertex:refine={steps}")) for steps in (0, 1))
    assert refined.pixels.median <= 0.01
    assert refined.pixels.p95 <= 0.05
    assert plain.pixels.p95 >= 10.0 * refined.pixels.p95


def test_a_plain_mesh_bends_rays_at_its_interpolated_normals():
    """Without an exact surface the truth lies on the flat triangles, and so must a fragment's own ray."""
    scene = scene_with(replace(spherical_mirror(count=3), surface=None, parameters=None))
    errors = measure(drawn(scene, "raytrace"), drawn(scene, "pervertex:refine=2"))
    assert errors.pixels.median <= 0.01
    assert errors.pixels.p95 <= 0.1


def test_a_flat_mirror_has_nothing_to_refine():
    frame = drawn(scene_with(flat_mirror()), "pervertex:refine=2")
    assert frame.deviation[frame.specular > 0].max() < 1e-5


@pytest.mark.parametrize("specification", ["pervertex", "pervertex:refine=1", "environment"])
def test_the_deviation_is_the_angle_to_the_truths_ray(reference, specification):
    """What a method knows of its error is its error, for its own ray is the truth's."""
    frame = drawn(CURVED, specification)
    mirror = (reference.specular > 0) & (frame.specular > 0) & (frame.status != Status.OUTSIDE)
    origins, rays, points = (
        buffer[mirror].astype(float) for buffer in (reference.ray_origin, reference.ray_direction, frame.position)
    )
    angles = angles_between(normalized(rays), seen_directions(origins, points, frame.object_id[mirror]))
    # An environment map's own rays leave the flat triangles; the truth's leave the sphere.
    bound = 2e-2 if specification == "environment" else 2e-4
    assert np.abs(frame.deviation[mirror] - angles).max() < bound


def test_direct_pixels_and_the_reference_do_not_deviate(reference):
    assert not reference.deviation.any()
    frame = drawn(CURVED, "pervertex")
    assert not frame.deviation[frame.specular == 0].any()
    assert frame.deviation[frame.specular > 0].any()


def test_a_step_that_swings_between_surfaces_keeps_the_best(reference):
    """More steps never deviate more."""
    few, many = (drawn(CURVED, f"pervertex:refine={steps}") for steps in (1, 6))
    assert (many.deviation <= few.deviation + 1e-6).all()


def test_refined_pixels_say_so():
    frame = drawn(CURVED, "pervertex:refine=1")
    assert (frame.status[(frame.specular > 0) & (frame.object_id > 0)] == Status.REFINED).mean() > 0.95
    assert not (drawn(CURVED, "pervertex").status == Status.REFINED).any()


BALL = spherical_mirror(radius=0.25, count=24, half=(0.2, 0.2))


def bars():
    """Upright bars close before the mirror: the map and the rays see different things behind them."""
    material = Diffuse(color=(0.9, 0.1, 0.1))
    return [
        box((x, 0.2, 0.15), (x + 0.02, 0.8, 0.17)).mesh(f"bar-{number}", material)
        for number, x in enumerate((-0.25, -0.1, 0.05, 0.4))
    ]


@pytest.mark.parametrize("kind", ["curved", "bars", "ball"])
def test_a_tolerance_holds(kind):
    scene = {
        "curved": CURVED,
        "ball": scene_with(BALL),
        "bars": scene_with(BALL, *bars()),
    }[kind]
    reference = drawn(scene, "raytrace")
    frame = drawn(scene, "pervertex:tolerance=0.5")
    errors = measure(reference, frame)
    counted = errors.maps.specular & ~errors.maps.silhouette
    assert (errors.maps.pixels[counted] <= 0.5).mean() >= 0.999
    assert errors.other_object_percent <= 0.1
    traced = (frame.status[frame.specular > 0] == Status.TRACED).mean()
    assert traced > 0.0 if kind == "bars" else traced < 0.5


@pytest.mark.parametrize(("radius", "count", "half"), [(0.5, 12, (0.15, 0.12)), (1.4, 6, (0.2, 0.15))])
def test_what_stands_between_is_not_missed(radius, count, half):
    """What the map sees elsewhere does not make a fragment deviate: only looking along its ray finds it."""
    mirror = spherical_mirror(radius, count, half)
    material = Diffuse(color=(0.9, 0.1, 0.1))
    thin = [box((x, 0.2, 0.06), (x + 0.01, 0.8, 0.07)).mesh(f"bar-{x}", material) for x in (-0.15, -0.08, 0.0, 0.1)]
    scene = scene_with(mirror, *thin)
    reference, blind, mended = (
        drawn(scene, name, (320, 240)) for name in ("raytrace", "pervertex:refine=3", "pervertex:tolerance=0.5")
    )
    maps = measure(reference, blind).maps
    wrong = maps.specular & ~maps.silhouette & (blind.object_id != reference.object_id)
    wrong &= (blind.status != Status.OUTSIDE) & (blind.deviation < 1e-3)
    assert wrong.sum() > 40
    assert (mended.object_id != reference.object_id)[wrong].mean() < 0.02


def test_the_error_that_a_fragment_knows_is_the_measured_one(reference, monkeypatch):
    monkeypatch.setattr(pervertex, "REFINEMENTS_BEFORE_TRACING", 0)
    monkeypatch.setattr(pervertex, "refined_scene", lambda scene, size, share: scene)
    session = open_view(CURVED, "pervertex:tolerance=0.001")
    session.draw(CURVED.camera)
    known = read_texture(session.diagnostics()["errors"])
    maps = measure(reference, drawn(CURVED, "pervertex")).maps
    counted = maps.specular & ~maps.silhouette & (known < 1e3)
    assert counted.sum() > 0.8 * maps.specular.sum()
    # Neighbours in a quad share one difference where the measure takes that on both sides.
    assert np.percentile(np.abs(known - maps.pixels)[counted] / np.maximum(maps.pixels[counted], 0.02), 95) < 0.05


def test_a_mirror_in_the_mirror_is_traced():
    scene = make("spheres")
    reference, frame = drawn(scene, "raytrace"), drawn(scene, "pervertex:tolerance=0.5")
    assert measure(reference, drawn(scene, "pervertex:refine=3,bounces=1")).other_object_percent > 5.0
    assert measure(reference, frame).other_object_percent < 0.5


def test_what_frames_the_mirror_is_seen_where_a_tolerance_is_set():
    """The map of a frame without one leaves out the rim; that of a tolerance shows it, and knows what it cuts off."""
    rim = box((-0.25, 0.3, -0.02), (-0.17, 0.7, 0.03)).mesh("rim", Diffuse(color=(0.1, 0.1, 0.1)))
    scene = scene_with(spherical_mirror(count=6), rim)
    reference = drawn(scene, "raytrace", (320, 240))
    refined, mended = (
        measure(reference, drawn(scene, f"pervertex:{option}", (320, 240))) for option in ("refine=3", "tolerance=0.5")
    )
    assert refined.other_object_percent > 1.0
    assert mended.other_object_percent < 0.1


def test_the_mended_image_has_the_reference_s_colours():
    scene = scene_with(BALL, *bars())
    reference, frame = drawn(scene, "raytrace"), drawn(scene, "pervertex:tolerance=0.5")
    traced = frame.status == Status.TRACED
    assert traced.sum() > 50
    close = np.isclose(frame.color[traced], reference.color[traced], atol=0.02).all(axis=-1)
    # A tile knows less of its neighbours' footprints than the whole rectangle: its border filters textures otherwise.
    assert close.mean() > 0.9


def test_doubtful_tiles_hold_every_doubtful_pixel():
    errors = np.zeros((11, 14), np.float32)
    errors[10, 13] = errors[0, 5] = errors[1, 7] = 2.0
    assert doubtful_tiles(errors, 0.5).tolist() == [[4, 0], [12, 8]]
    assert doubtful_tiles(errors, 2.0).tolist() == []
    assert TILE == (4, 4)


def test_a_shifted_frame_is_mended_with_shifted_rays():
    scene, shift = scene_with(BALL, *bars()), (0.4, -0.4)
    frames = []
    for specification in ("raytrace", "pervertex:tolerance=0.5"):
        session = open_view(scene, specification, (320, 240))
        session.draw(scene.camera, shift)
        frames.append(session.frame(seen=True))
    still = drawn(scene, "pervertex:tolerance=0.5", (320, 240))
    traced = (still.status == Status.TRACED) & (frames[1].status == Status.TRACED)
    assert traced.sum() > 50
    reference, shifted = (frame.color[traced] for frame in frames)
    assert np.abs(shifted - reference).mean() < 0.1 * np.abs(still.color[traced] - reference).mean()


@pytest.mark.parametrize(
    ("specification", "word"),
    [
        ("pervertex:refine=-1", "refine"),
        ("pervertex:refine=99", "refine"),
        ("pervertex:tolerance=-1", "tolerance"),
        ("pervertex:tolerance=nan", "tolerance"),
        ("pervertex:tolerance=1,antialias=4", "antialias"),
    ],
)
def test_wrong_options_are_named(specification, word):
    with pytest.raises(AnamorphError, match=word):
        open_view(CURVED, specification)
