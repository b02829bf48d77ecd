"""Maps of surfaces: each pixel's own ray, what is proved of it, and what a tolerance has traced."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from error_twin import seen_directions
from scenes import CENTER, SIZE, drawn, flat_mirror, open_view, scene_with, spherical_mirror

from anamorph.base.errors import AnamorphError
from anamorph.frame import Status
from anamorph.gallery import make
from anamorph.gallery.solids import box
from anamorph.gallery.spheres import mirror_ball
from anamorph.measure.angles import angles_between, normalized
from anamorph.measure.errors import measure, silhouettes
from anamorph.scene.model import Diffuse

CURVED = scene_with(spherical_mirror(count=6))


@pytest.fixture(scope="module")
def reference():
    return drawn(CURVED, "raytrace")


def test_own_rays_reach_the_truth(reference):
    warped, frame = (drawn(CURVED, f"pervertex:map={holds}") for holds in ("image", "surfaces"))
    warped, errors = (measure(reference, each) for each in (warped, frame))
    assert errors.pixels.median <= 0.01
    assert errors.pixels.p95 <= 0.05
    assert warped.pixels.p95 >= 10.0 * errors.pixels.p95


def test_a_plain_mesh_bends_rays_at_its_interpolated_normals():
    """Without an exact surface the truth lies on the flat triangles, and so must a pixel's own ray."""
    scene = scene_with(replace(spherical_mirror(count=3), surface=None, parameters=None))
    errors = measure(drawn(scene, "raytrace"), drawn(scene, "pervertex"))
    assert errors.pixels.median <= 0.01
    assert errors.pixels.p95 <= 0.1


@pytest.mark.parametrize(
    ("scene", "specification"),
    [(CURVED, "pervertex"), (CURVED, "pervertex:tolerance=0.5"), (scene_with(flat_mirror()), "pervertex")],
)
def test_own_rays_are_told_and_are_the_truths(scene, specification):
    reference, frame = drawn(scene, "raytrace"), drawn(scene, specification)
    mirror = (reference.specular > 0) & (frame.specular > 0)
    assert mirror.sum() > 2000
    assert np.abs(frame.ray_origin - reference.ray_origin)[mirror].max() < 1e-5
    rays = (each.ray_direction[mirror].astype(float) for each in (reference, frame))
    assert angles_between(*map(normalized, rays)).max() < 1e-4
    # What is seen lies on the ray, and nothing is known to be off it.
    toward = seen_directions(frame.ray_origin[mirror], frame.position[mirror], frame.object_id[mirror])
    assert angles_between(normalized(frame.ray_direction[mirror].astype(float)), toward).max() < 1e-4
    assert not frame.deviation.any()


@pytest.mark.parametrize("specification", ["pervertex:map=image", "environment"])
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


def test_a_flat_mirror_warps_without_deviation():
    frame = drawn(scene_with(flat_mirror()), "pervertex:map=image")
    assert frame.deviation[frame.specular > 0].max() < 1e-5


def test_direct_pixels_and_the_reference_do_not_deviate(reference):
    assert not reference.deviation.any()
    frame = drawn(CURVED, "pervertex:map=image")
    assert not frame.deviation[frame.specular == 0].any()
    assert frame.deviation[frame.specular > 0].any()


BALL = spherical_mirror(radius=0.25, count=24, half=(0.2, 0.2))


def bars():
    """Upright bars close before the mirror: the map and the rays see different things behind them."""
    material = Diffuse(color=(0.9, 0.1, 0.1))
    return [
        box((x, 0.2, 0.15), (x + 0.02, 0.8, 0.17)).mesh(f"bar-{number}", material)
        for number, x in enumerate((-0.25, -0.1, 0.05, 0.4))
    ]


SCENES = {"curved": CURVED, "ball": scene_with(BALL), "bars": scene_with(BALL, *bars())}


@pytest.mark.parametrize("kind", SCENES)
def test_what_is_proved_is_what_the_truth_sees(kind):
    reference, frame = drawn(SCENES[kind], "raytrace"), drawn(SCENES[kind], "pervertex")
    found = np.isin(frame.status, (Status.PROVED, Status.SKY)) & (frame.specular > 0) & (reference.specular > 0)
    assert found.sum() > 1000
    away = found & ~silhouettes(reference.object_id, reference.specular)
    assert (frame.object_id == reference.object_id)[away].all()
    assert measure(reference, frame).maps.pixels[away].max() <= 0.5
    # Pixels that see their object's very border may see it or not.
    assert (frame.object_id == reference.object_id)[found].mean() > 0.998


def test_what_is_found_says_so():
    frame = drawn(CURVED, "pervertex")
    mirror = frame.specular > 0
    assert set(np.unique(frame.status[mirror])) <= {Status.PROVED, Status.SKY, Status.DOUBTFUL}
    assert (frame.status[mirror] != Status.DOUBTFUL).mean() > 0.75
    assert (frame.object_id[frame.status == Status.PROVED] > 0).all()
    assert not (drawn(CURVED, "pervertex:map=image").status == Status.PROVED).any()


@pytest.mark.parametrize("kind", SCENES)
def test_a_tolerance_holds(kind):
    reference, frame = drawn(SCENES[kind], "raytrace"), drawn(SCENES[kind], "pervertex:tolerance=0.5")
    errors = measure(reference, frame)
    counted = errors.maps.specular & ~errors.maps.silhouette
    assert (errors.maps.pixels[counted] <= 0.5).mean() >= 0.999
    assert errors.other_object_percent <= 0.1
    traced = (frame.status[frame.specular > 0] == Status.TRACED).mean()
    assert traced > 0.0 if kind == "bars" else traced < 0.5


@pytest.mark.parametrize("name", ["car-mirror", "spheres"])
def test_what_is_doubtful_is_traced_and_nothing_else(name):
    scene = make(name)
    plain, traced = (drawn(scene, specification) for specification in ("pervertex", "pervertex:tolerance=0.5"))
    doubtful = plain.status == Status.DOUBTFUL
    assert doubtful.any()
    assert not (traced.status == Status.DOUBTFUL).any()
    # A traced path tells by itself when it ends in the sky, or at one mirror too many.
    assert np.isin(traced.status[doubtful], (Status.TRACED, Status.SKY, Status.OUTSIDE)).all()
    for buffer in ("position", "object_id", "status", "ray_origin", "ray_direction"):
        assert (getattr(plain, buffer) == getattr(traced, buffer))[~doubtful].all()


@pytest.mark.parametrize(("radius", "count", "half"), [(0.5, 12, (0.15, 0.12)), (1.4, 6, (0.2, 0.15))])
def test_what_stands_between_is_not_missed(radius, count, half):
    """Thin bars close before the mirror, where the map hardly sees them: who misses one doubts."""
    mirror = spherical_mirror(radius, count, half)
    material = Diffuse(color=(0.9, 0.1, 0.1))
    thin = [box((x, 0.2, 0.06), (x + 0.01, 0.8, 0.07)).mesh(f"bar-{x}", material) for x in (-0.15, -0.08, 0.0, 0.1)]
    scene = scene_with(mirror, *thin)
    reference, blind, plain, traced = (
        drawn(scene, name, (320, 240))
        for name in ("raytrace", "pervertex:map=image", "pervertex", "pervertex:tolerance=0.5")
    )
    maps = measure(reference, blind).maps
    wrong = maps.specular & ~maps.silhouette & (blind.object_id != reference.object_id)
    wrong &= (blind.status != Status.OUTSIDE) & (blind.deviation < 1e-3)
    assert wrong.sum() > 30
    assert (traced.object_id != reference.object_id)[wrong].mean() < 0.02
    missed = wrong & (plain.object_id != reference.object_id)
    assert (plain.status[missed] == Status.DOUBTFUL).mean() > 0.98 if missed.any() else True


def test_a_mirror_in_the_mirror_is_traced():
    scene = make("spheres")
    reference, frame = drawn(scene, "raytrace"), drawn(scene, "pervertex:tolerance=0.5")
    assert measure(reference, drawn(scene, "pervertex:map=image,bounces=1")).other_object_percent > 5.0
    assert measure(reference, frame).other_object_percent < 0.5


def test_what_is_in_a_body_does_not_hide_what_is_before_it():
    ball = scene_with(mirror_ball("ball", tuple(CENTER), 0.2, 24, 32))
    inner = box(tuple(CENTER - 0.08), tuple(CENTER + 0.08)).mesh("inner", Diffuse(color=(1.0, 0.0, 1.0)))
    filled = replace(ball, meshes=(*ball.meshes, inner))
    plain, traced = (drawn(filled, specification) for specification in ("pervertex", "pervertex:tolerance=0.5"))
    number = len(filled.meshes)
    assert not (traced.object_id == number).any()
    assert (plain.status[plain.object_id == number] == Status.DOUBTFUL).all()
    assert measure(drawn(ball, "raytrace"), plain).other_object_percent < 0.5


def test_what_frames_the_mirror_is_seen():
    """A map of colours leaves out the rim; a map of surfaces knows what stands before it."""
    rim = box((-0.25, 0.3, -0.02), (-0.17, 0.7, 0.03)).mesh("rim", Diffuse(color=(0.1, 0.1, 0.1)))
    scene = scene_with(spherical_mirror(count=6), rim)
    reference = drawn(scene, "raytrace", (320, 240))
    warped, traced = (
        measure(reference, drawn(scene, f"pervertex:{option}", (320, 240))) for option in ("map=image", "tolerance=0.5")
    )
    assert warped.other_object_percent > 1.0
    assert traced.other_object_percent < 0.1


@pytest.mark.parametrize("specification", ["pervertex", "pervertex:tolerance=0.5"])
def test_the_image_has_the_reference_s_colours(specification):
    """Two methods that see the same triangle give the same pixel, its texture filtered alike."""
    scene = SCENES["bars"]
    reference, frame = drawn(scene, "raytrace"), drawn(scene, specification)
    same = (frame.object_id == reference.object_id) & (frame.specular > 0) & (reference.specular > 0)
    assert same.sum() > 3000
    close = np.isclose(frame.color[same], reference.color[same], atol=0.02).all(axis=-1)
    assert close.mean() > 0.99


def test_a_shifted_frame_is_traced_with_shifted_rays():
    scene, shift = SCENES["bars"], (0.4, -0.4)
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


@pytest.mark.parametrize("specification", ["pervertex", "pervertex:tolerance=0.5", "pervertex:antialias=4"])
def test_a_frame_is_the_same_however_it_is_come_by(specification):
    """In a new session, and in one that has looked from elsewhere."""
    scene = SCENES["bars"]
    expected = drawn(scene, specification)
    session = open_view(scene, specification)
    session.draw(replace(scene.camera, position=(0.1, 0.6, 1.2)))
    for _ in range(2):
        session.draw(scene.camera)
        frame = session.frame(seen=True)
        for buffer in ("color", "position", "object_id", "specular", "status", "ray_origin", "ray_direction"):
            assert np.array_equal(getattr(frame, buffer), getattr(expected, buffer)), buffer


@pytest.mark.parametrize("specification", ["pervertex", "pervertex:tolerance=0.5"])
def test_four_samples_smooth_edges_and_leave_the_seen_buffers(specification):
    scene, four = SCENES["bars"], f"{specification}{',' if ':' in specification else ':'}antialias=4"
    plain, smooth = drawn(scene, specification), drawn(scene, four)
    difference = np.abs(smooth.color - plain.color).max(axis=-1)
    assert (difference > 0.03).sum() > 50
    inner = ~silhouettes(plain.object_id, plain.specular)
    assert np.percentile(difference[inner], 95) <= 0.1
    for buffer in ("object_id", "specular"):
        assert (getattr(smooth, buffer) == getattr(plain, buffer))[inner].mean() > 0.99


@pytest.mark.parametrize(
    ("specification", "word"),
    [
        ("pervertex:tolerance=-1", "tolerance"),
        ("pervertex:tolerance=nan", "tolerance"),
        ("pervertex:map=colours", "map"),
        ("pervertex:refine=1", "refine"),
        ("pervertex:map=image,tolerance=1", "leave it out, or give map=surfaces$"),
        ("pervertex:overlay=mesh", "leave it out, or give map=image$"),
        ("pervertex:overlay=inconsistency", "leave it out, or give map=image$"),
    ],
)
def test_wrong_options_are_named(specification, word):
    with pytest.raises(AnamorphError, match=word) as caught:
        open_view(CURVED, specification, SIZE)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["car-mirror", "spectacles-minus", "room", "saddle", "torus"])
def test_four_samples_a_pixel_are_those_of_traced_rays_up_to_the_outlines(name):
    """Both have the samples of the image see the same outlines, of what is specular and of what is not."""
    scene = make(name)
    traced, searched = (
        drawn(scene, f"{method}antialias=4", (256, 192)).color for method in ("raytrace:", "pervertex:tolerance=0.5,")
    )
    apart = np.abs(traced - searched).max(axis=-1)
    assert (apart > 0.01).mean() < 1e-3
    assert (apart > 0.2).sum() <= 2
