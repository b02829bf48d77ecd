"""Rays through lenses: thin-lens formulae, exact paths, reversibility, and an answer for every ray that has no way."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from light import snell, through

from anamorph import gallery
from anamorph.base.errors import AnamorphError
from anamorph.base.steps import drain
from anamorph.lenses.lens import Lens, lens_between
from anamorph.lenses.making import make_lens
from anamorph.lenses.prescription import Prescription
from anamorph.methods.tracing.launch import eye_rays
from anamorph.methods.tracing.paths import PathTracer
from anamorph.optics.dispersion import line_indices
from anamorph.optics.refraction import refracted_rays, refractor
from anamorph.raymesh import RayMesh, RayStatus
from anamorph.rays.caster import Caster
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Diffuse, Glass, Mesh, Scene
from anamorph.surfaces.even_asphere import EvenAsphere
from anamorph.surfaces.plane import Plane

SIZE = (640, 480)
OUTWARD = np.array([0.0, 0.0, -1.0])
UP = np.array([0.0, 1.0, 0.0])
AXES = np.array([[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]])


def lens_of(prescription: Prescription, vertices: int = 127) -> Lens:
    """Its back vertex at the origin; the world is along -z."""
    return make_lens(prescription, (0.0, 0.0, 0.0), (0.0, 0.0, -1.0), vertices=vertices)


def seen(lens: Lens, eye, index: float | None = None) -> RayMesh:
    x, y, z = eye
    camera = Camera((x, y, z), (0.0, 0.0, 0.0), field_of_view=50.0)
    return refracted_rays(refractor(lens.back, lens.front), camera.eye(SIZE), index)


def slab(thickness: float, radius: float, index: float, tilt: float = 0.0, vertices: int = 271) -> Lens:
    """Two planes; the far one is tilted about the x axis by `tilt` radians."""
    far = Plane(thickness * OUTWARD, AXES[0], np.cos(tilt) * UP + np.sin(tilt) * OUTWARD)
    return lens_between(far, Plane(np.zeros(3), AXES[0], UP), np.zeros(3), AXES, radius, Glass(index), "slab", vertices)


def angle(one, other):
    """Between unit vectors, radians, (N,)."""
    return 2.0 * np.arcsin(0.5 * np.linalg.norm(one - other, axis=-1))


def incident(lens: Lens, eye) -> np.ndarray:
    offset = refractor(lens.back, lens.front).positions - np.asarray(eye)
    return offset / np.linalg.norm(offset, axis=1, keepdims=True)


@pytest.mark.parametrize("power", [-5.0, -1.0, 1.0, 2.0, 5.0])
@pytest.mark.parametrize("distance", [0.05, 0.3, 1.0])
def test_a_thin_lens_images_the_eye_where_the_formula_says_and_magnifies_as_it_says(power, distance):
    lens = lens_of(Prescription(power, base_curve=power / 2.0, centre_thickness=0.02, diameter=2.0))
    rays = seen(lens, (0.0, 0.0, distance))
    off_axis = np.hypot(*lens.back.positions.T[:2]) > 0.0
    directions, origins = rays.unit_directions()[off_axis], rays.origins[off_axis]
    # Backward, the rays meet in the eye's image, at 1/b = 1/a - F before the lens.
    slope = np.hypot(*directions.T[:2]) * np.sign(np.sum(directions[:, :2] * origins[:, :2], axis=1))
    image = np.hypot(*origins.T[:2]) / slope * -directions[:, 2]
    np.testing.assert_allclose(1.0 / image, 1.0 / distance - power, rtol=5e-3, atol=5e-3 * abs(power))
    # A plane `far` behind the lens: where the eye's straight ray would have met it, and where this one does.
    far = 0.4
    met = origins[:, :2] + (far + origins[:, 2:]) / -directions[:, 2:] * directions[:, :2]
    straight = lens.back.positions[off_axis, :2] * (distance + far) / distance
    factor = np.sum(met * straight, axis=1) / np.sum(straight**2, axis=1)
    expected = (1.0 + far * (1.0 / distance - power)) * distance / (distance + far)
    np.testing.assert_allclose(factor, expected, atol=5e-3)


@pytest.mark.parametrize("power", [-6.0, -1.0, 2.0, 4.0])
def test_off_the_axis_a_lens_is_a_prism_by_prentices_rule(power):
    lens = lens_of(Prescription(power, base_curve=max(power, 0.0), centre_thickness=0.6, diameter=16.0))
    rays = seen(lens, (0.0, 0.0, 1000.0))
    away = np.hypot(*lens.back.positions.T[:2].astype(float))
    within = (away > 1e-4) & (away < 5e-3) & (rays.status == RayStatus.OK)
    assert within.sum() > 20
    prism = 100.0 * np.tan(angle(rays.unit_directions(), OUTWARD))
    np.testing.assert_allclose(prism[within], 100.0 * away[within] * abs(power), rtol=5e-3)
    inward = -np.sum(rays.directions[within, :2] * lens.back.positions[within, :2], axis=1)
    assert (np.sign(inward) == np.sign(power)).all()


@pytest.mark.parametrize("base", [0.0, 90.0, 180.0, 300.0])
def test_a_prism_bends_the_look_toward_its_base(base):
    lens = lens_of(Prescription(0.0, prism=3.0, base=base, base_curve=0.0, centre_thickness=3.0, diameter=20.0))
    rays = seen(lens, (0.0, 0.0, 1000.0))
    # Seen by the wearer, 0 degrees is to the left: they look at the lens from behind.
    toward = np.cos(np.radians(base)) * AXES[0] + np.sin(np.radians(base)) * UP
    shift = rays.unit_directions() - OUTWARD
    np.testing.assert_allclose(shift @ toward, 0.03, rtol=5e-3)


@pytest.mark.parametrize("prescription", [
    Prescription(-6.0, vertex_distance=15.0, centre_thickness=1.0, base_curve=2.0, diameter=2.0),
    Prescription(6.0, vertex_distance=15.0, centre_thickness=7.0, base_curve=10.0, diameter=2.0),
    Prescription(3.0, vertex_distance=27.0, centre_thickness=5.0, base_curve=8.0, index=1.74, diameter=2.0),
])  # fmt: skip
def test_spectacle_magnification_is_shape_factor_times_power_factor(prescription):
    rays = seen(lens := lens_of(prescription), (0.0, 0.0, 1e-3 * prescription.vertex_distance))
    reduced = 1e-3 * prescription.centre_thickness / prescription.index * prescription.front_power
    expected = 1.0 / (1.0 - reduced) / (1.0 - 1e-3 * prescription.vertex_distance * prescription.sphere)
    first_ring = slice(1, 7)
    eyes = incident(lens, (0.0, 0.0, 1e-3 * prescription.vertex_distance))[first_ring]
    magnification = angle(eyes, OUTWARD) / angle(rays.unit_directions()[first_ring], OUTWARD)
    np.testing.assert_allclose(magnification, expected, rtol=2e-4)
    if prescription.sphere == -6.0:
        assert expected == pytest.approx(0.917 / (1.0 - 1e-3 / 1.5 * 2.0), abs=1e-3)


@pytest.mark.parametrize(("index", "abbe"), [(1.498, 58.0), (1.586, 30.0), (1.74, 33.0)])
@pytest.mark.parametrize("power", [-6.0, 3.0])
def test_transverse_colour_is_prism_over_abbe_number(index, abbe, power):
    prescription = Prescription(
        power, index=index, abbe=abbe, base_curve=max(power, 0.0), centre_thickness=1.0, diameter=20.0
    )
    lens = lens_of(prescription)
    camera = Camera((0.0, 0.0, 1000.0), (0.0, 0.0, 0.0))
    prepared = refractor(lens.back, lens.front)
    red, green, blue = (refracted_rays(prepared, camera.eye(SIZE), line) for line in line_indices(index, abbe))
    away = np.hypot(*lens.back.positions.T[:2].astype(float))
    within = (away > 1e-4) & (away < 8e-3)
    spread = 100.0 * angle(red.unit_directions(), blue.unit_directions())[within]
    np.testing.assert_allclose(spread, 100.0 * away[within] * abs(power) / abbe, rtol=0.03)
    # Blue is bent most, and green lies between.
    deviations = [angle(rays.unit_directions()[within], OUTWARD) for rays in (red, green, blue)]
    assert (deviations[0] < deviations[1]).all() and (deviations[1] < deviations[2]).all()


def test_indices_of_lines_are_as_far_apart_as_the_abbe_number_says():
    red, green, blue = line_indices(1.523, 58.9)
    assert green == 1.523 and 0.523 / (blue - red) == pytest.approx(58.9)
    # The crown glass BK7: 1.51432, 1.51680, 1.52238.
    np.testing.assert_allclose(line_indices(1.5168, 64.17), (1.51432, 1.5168, 1.52238), atol=1e-4)
    assert line_indices(1.6, None) == (1.6, 1.6, 1.6)
    with pytest.raises(AnamorphError, match=r"^glass: Abbe number is -1; give [^\n]*$"):
        line_indices(1.5, -1.0)


LENSES = {
    "minus": Prescription(-8.0, centre_thickness=1.0, base_curve=2.0),
    "toric": Prescription(-3.0, 2.5, 35.0, 4.0, 120.0, index=1.67, centre_thickness=5.0),
    "plus": Prescription(5.0, -1.0, 80.0, centre_thickness=8.0),
    "flat": Prescription(2.0, base_curve=0.0, centre_thickness=4.0),
}


@pytest.mark.parametrize("name", LENSES)
@pytest.mark.parametrize("eye", [(0.0, 0.0, 0.015), (0.02, -0.01, 0.06), (-0.3, 0.2, 0.5)])
def test_rays_take_the_way_that_light_takes_step_by_step_and_back(name, eye):
    lens, index = lens_of(LENSES[name]), LENSES[name].index
    rays = seen(lens, eye)
    ok = rays.status == RayStatus.OK
    assert ok.sum() > 30
    way = incident(lens, eye)
    starts = refractor(lens.back, lens.front).positions - 0.004 * way
    ends, directions = through(lens, starts[ok], way[ok], index, from_back=True, reach=0.008)
    np.testing.assert_allclose(rays.origins[ok], ends, atol=1e-12)
    np.testing.assert_allclose(rays.unit_directions()[ok], directions, atol=1e-12)
    # And back: from outside, reversed, to the vertex and into the eye.
    back, into_eye = through(lens, ends + 0.004 * directions, -directions, index, reach=0.008)
    np.testing.assert_allclose(back, refractor(lens.back, lens.front).positions[ok], atol=1e-11)
    np.testing.assert_allclose(into_eye, -way[ok], atol=1e-11)


def test_directions_are_as_long_as_the_eyes_distance_and_the_image_is_the_cameras():
    lens, eye = lens_of(LENSES["minus"]), (0.01, 0.0, 0.06)
    rays, positions = seen(lens, eye), refractor(lens.back, lens.front).positions
    np.testing.assert_allclose(np.linalg.norm(rays.directions, axis=1), np.linalg.norm(positions - eye, axis=1))
    camera = Camera(eye, (0.0, 0.0, 0.0), field_of_view=50.0)
    pixels = rays.image[:, :2] / rays.image[:, 2:]
    np.testing.assert_allclose(camera.directions(pixels, SIZE), incident(lens, eye), atol=1e-12)
    np.testing.assert_array_equal(rays.faces, lens.back.faces)


def test_from_the_other_side_the_front_is_the_near_face():
    lens = lens_of(LENSES["plus"])
    rays = refracted_rays(refractor(lens.front, lens.back), Camera((0.0, 0.0, -0.4), (0.0, 0.0, 0.0)).eye(SIZE))
    ok = rays.status == RayStatus.OK
    assert ok.all()
    positions = refractor(lens.front, lens.back).positions
    way = positions - [0.0, 0.0, -0.4]
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    ends, directions = through(lens, positions - 0.004 * way, way, 1.5, reach=0.008)
    np.testing.assert_allclose(rays.origins, ends, atol=1e-12)
    np.testing.assert_allclose(rays.unit_directions(), directions, atol=1e-12)


@settings(max_examples=40)
@given(st.floats(0.001, 0.02), st.floats(0.005, 0.04), st.sampled_from([1.3, 1.5, 2.0]), st.floats(0.01, 0.5))
def test_of_a_slab_rays_leave_by_the_edge_where_they_are_beyond_the_radius(thickness, radius, index, distance):
    lens = slab(thickness, radius, index)
    rays = seen(lens, (0.0, 0.0, distance))
    away = np.hypot(*lens.back.positions.T[:2].astype(float))
    inside = away / np.hypot(away, distance) / index
    reached = away + thickness * inside / np.sqrt(1.0 - inside**2)
    clear = np.abs(reached - radius) > 1e-6 * radius
    expected = np.where(reached > radius, RayStatus.LEFT_BY_EDGE, RayStatus.OK)
    np.testing.assert_array_equal(rays.status[clear], expected[clear])
    # On a slab every ray goes on as it came, also beyond the edge, so that neighbours interpolate to the same.
    np.testing.assert_allclose(rays.unit_directions(), incident(lens, (0.0, 0.0, distance)), atol=1e-6)
    np.testing.assert_allclose(np.hypot(*rays.origins.T[:2]), reached, atol=1e-7)


def test_beyond_the_critical_angle_reflection_is_total():
    # The eye's rays meet the near face squarely; asin(1 / 1.5) is 41.8 degrees.
    for degrees, status in ((41.5, RayStatus.OK), (42.1, RayStatus.TOTAL_REFLECTION)):
        tilt = np.radians(degrees)
        rays = seen(slab(0.02, 0.01, 1.5, tilt), (0.0, 0.0, 1000.0))
        clear = np.hypot(*rays.origins.T[:2]) < 0.0099
        assert (rays.status[clear] == status).all() and clear.sum() > 100
    # What is given there is the ray that stays in the glass.
    normal = np.cos(tilt) * OUTWARD - np.sin(tilt) * UP
    reflected = OUTWARD - 2.0 * (OUTWARD @ normal) * normal
    np.testing.assert_allclose(rays.unit_directions()[clear], np.tile(reflected, (clear.sum(), 1)), atol=1e-4)


def test_from_behind_the_near_face_every_vertex_is_back_facing():
    lens = slab(0.005, 0.02, 1.5)
    rays = seen(lens, (0.0, 0.0, -0.5))
    assert (rays.status == RayStatus.BACK_FACING).all()
    assert np.isfinite(rays.directions).all() and (np.linalg.norm(rays.directions, axis=1) > 0.0).all()


def test_a_ray_that_misses_even_the_far_surface_leaves_by_the_edge():
    # A concave front of 25 mm radius, and an eye so close that rays run outward in the thick edge, past that sphere.
    lens = lens_of(Prescription(-20.0, base_curve=-20.0, diameter=40.0))
    rays = seen(lens, (0.0, 0.0, 0.01))
    assert set(rays.status) == {RayStatus.OK, RayStatus.LEFT_BY_EDGE, RayStatus.TOTAL_REFLECTION}
    stayed = np.linalg.norm(rays.origins - refractor(lens.back, lens.front).positions, axis=1) == 0.0
    assert stayed.any() and (rays.status[stayed] == RayStatus.LEFT_BY_EDGE).all()
    assert np.isfinite(rays.directions).all() and np.isfinite(rays.origins).all()
    assert (np.linalg.norm(rays.directions, axis=1) > 0.0).all()


def wall(distance: float) -> Mesh:
    corners = np.array([[-9, -9, -distance], [9, -9, -distance], [9, 9, -distance], [-9, 9, -distance]], np.float32)
    return Mesh("wall", corners, np.array([[0, 1, 2], [0, 2, 3]], np.int32), np.tile([0, 0, 1], (4, 1)).astype("f4"))


def aspheric() -> Lens:
    return lens_between(
        EvenAsphere(0.008 * OUTWARD, 18.0, -1.2, (900.0,), AXES),
        EvenAsphere(np.zeros(3), 4.0, 0.0, (), AXES * [[-1.0], [1.0], [-1.0]]),
        np.zeros(3), AXES, 0.018, Glass(1.5),
    )  # fmt: skip


@pytest.mark.parametrize("name", [*LENSES, "aspheric"])
def test_the_ray_tracer_follows_light_through_the_exact_faces(name):
    lens = aspheric() if name == "aspheric" else lens_of(LENSES[name])
    index = 1.5 if name == "aspheric" else LENSES[name].index
    eye, size = (0.004, -0.002, 0.06), (64, 48)
    camera = Camera(eye, (0.0, 0.0, 0.0), field_of_view=30.0)
    scene = Scene("lens", (*lens.meshes, wall(3.0)), camera)
    geometry = flatten(scene)
    records = drain(PathTracer(scene, geometry, Caster(geometry)).tracing(eye_rays(camera, size)))
    words = records.view(np.uint32)
    at_wall = (words[:, 3] >= geometry.first_face[3]) & (words[:, 7] >> 24 == 2)
    assert at_wall.mean() > 0.3
    assert ((words[:, 7] & 0xFFFF)[at_wall] == 2).all(), "the eye sees the back first"
    pixels = np.stack(np.meshgrid(np.arange(64) + 0.5, np.arange(48) + 0.5), axis=-1).reshape(-1, 2)
    way = camera.directions(pixels, size)[at_wall]
    plane = np.asarray(eye) + way * (-0.06 / way[:, 2:])
    ends, directions = through(lens, plane - 0.02 * way, way, index, from_back=True, reach=0.04)
    # Single precision, in records and in Embree.
    np.testing.assert_allclose(records[at_wall, :3], ends, atol=1e-8)
    np.testing.assert_allclose(records[at_wall, 4:7], directions, atol=2e-7)


@pytest.mark.parametrize(
    ("name", "distance", "power", "shape"),
    [
        ("spectacles-minus", 0.060, -6.0, 1.0 / (1.0 - 1.4e-3 / 1.6 * 3.0)),
        ("spectacles-plus", 0.070, 6.0, 1.0 / (1.0 - 9e-3 / 1.6 * 12.0)),
        ("magnifier", 0.76, 10.0, 1.0),
    ],
)
def test_built_in_lenses_reduce_magnify_and_reverse_as_the_formulae_say(name, distance, power, shape):
    scene = gallery.make(name)
    front, back = scene.meshes[:2]
    prepared = refractor(back, front)
    rays = refracted_rays(prepared, scene.camera.eye(SIZE))
    axis, first_ring, far = scene.camera.axes()[2], slice(1, 7), 3.0
    offset = prepared.positions[first_ring] - scene.camera.position
    # How far aside a thing is seen, and how far aside it is.
    direction = rays.unit_directions()[first_ring]
    place = rays.origins[first_ring] + far / (direction @ axis)[:, None] * direction - scene.camera.position
    aside = [vectors / (vectors @ axis)[:, None] - axis for vectors in (offset, place)]
    factor = np.sum(aside[0] * aside[1], axis=1) / np.sum(aside[1] ** 2, axis=1)
    expected = shape * (distance + far) / distance / (1.0 + far * (1.0 / distance - power))
    np.testing.assert_allclose(factor, expected, rtol=0.03)
    assert (name == "spectacles-plus") == (expected > 1.0) and (name == "magnifier") == (expected < 0.0)


def test_what_is_no_lens_is_refused_in_one_line():
    lens = lens_of(LENSES["minus"])
    for near, far, words in (
        (lens.edge, lens.front, "is not of glass"),
        (replace(lens.back, material=Glass(1.7)), lens.front, "two indices"),
        (replace(lens.back, surface=None), lens.front, "no exact surface"),
        (lens.back, replace(lens.front, material=Diffuse()), "is not of glass"),
    ):
        with pytest.raises(AnamorphError, match=rf"^lens [^\n]*{words}[^\n]*; [^\n]*$"):
            refractor(near, far)
    whole = gallery.make("spheres").meshes[0]
    closed = replace(whole, material=Glass(1.5), faces=np.array([[0, 1, 2], [0, 2, 1]], np.int32))
    with pytest.raises(AnamorphError, match=r"^lens face [^\n]* no border; [^\n]*$"):
        refractor(closed, closed)


def test_snells_law_by_angles_is_that_of_the_laws():
    directions = np.array([[0.0, 0.0, -1.0], [0.6, 0.0, -0.8]])
    np.testing.assert_allclose(snell(directions, np.array([[0.0, 0.0, 1.0]] * 2), 1 / 1.5)[1, 0], 0.4)
