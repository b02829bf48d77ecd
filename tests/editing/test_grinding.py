"""Lenses of another power and index: light near the axis meets where their power says, and they stay closed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from light import through
from scenes import drawn, scene_with, surroundings

from anamorph import gallery
from anamorph.base.errors import AnamorphError
from anamorph.editing.grinding import LEAST_EDGE, ground, index_limits, optics_of, power_limits
from anamorph.lenses.lens import Lens, lens_between
from anamorph.lenses.making import edge_thickness, make_lens, worn_lens
from anamorph.lenses.prescription import Prescription
from anamorph.measure.compare import measure
from anamorph.scene.lens_pairs import lens_pairs
from anamorph.scene.model import Glass
from anamorph.surfaces.bezier import BezierPatch
from anamorph.surfaces.even_asphere import EvenAsphere

RIGHT, UP, OUTWARD = np.eye(3)
AXES = np.eye(3)
BEHIND = np.stack([-RIGHT, UP, -OUTWARD])
ORIGIN = (0.0, 0.0, 0.0)

prescriptions = st.builds(
    Prescription,
    sphere=st.one_of(st.sampled_from([0.0, -6.0, 6.0]), st.floats(-8.0, 8.0)),
    cylinder=st.one_of(st.just(0.0), st.floats(-3.0, 3.0)),
    axis=st.one_of(st.sampled_from([0.0, 90.0]), st.floats(0.0, 180.0)),
    prism=st.one_of(st.just(0.0), st.floats(0.1, 6.0)),
    base=st.floats(0.0, 360.0),
    index=st.sampled_from([1.498, 1.6, 1.74]),
    centre_thickness=st.floats(1.0, 10.0),
    base_curve=st.sampled_from([0.0, 4.0, 8.0]),
    diameter=st.floats(20.0, 50.0),
)
powers = st.one_of(st.sampled_from([0.0, -4.0, 4.0]), st.floats(-8.0, 8.0))
indices = st.one_of(st.none(), st.sampled_from([1.35, 1.9]), st.floats(1.4, 1.8))


def lens_of(prescription: Prescription) -> Lens:
    """Its back vertex at the origin, the world along +z."""
    try:
        assume(edge_thickness(prescription) > 1e-3)
    except AnamorphError:
        assume(False)
    return make_lens(prescription, ORIGIN, (0.0, 0.0, 1.0), vertices=127)


def changed(lens: Lens, power: float | None = None, index: float | None = None) -> Lens:
    try:
        return Lens(*ground(lens.meshes, power, index))
    except AnamorphError as error:
        assert "give a weaker one" in str(error) or "focuses light inside" in str(error)
        assume(False)
        raise


def power_along(lens: Lens, degrees: float, index: float) -> float:
    """Back vertex power, dioptres, of a principal meridian: parallel light near the axis, followed to the axis."""
    along, height = np.cos(np.radians(degrees)) * RIGHT + np.sin(np.radians(degrees)) * UP, 1e-5
    ends, directions = through(lens, height * along + 0.05 * OUTWARD, -OUTWARD, index)
    return float(-(directions @ along)[0] / (ends @ along)[0] / -(directions @ OUTWARD)[0])


@settings(max_examples=40)
@given(prescriptions)
def test_the_power_of_a_lens_is_read_from_its_surfaces(prescription):
    lens = lens_of(prescription)
    optics = optics_of(lens.front, lens.back)
    assert optics is not None
    assert optics.power == pytest.approx(prescription.sphere, abs=1e-4)
    assert optics.thickness == pytest.approx(1e-3 * prescription.centre_thickness, abs=1e-8)
    weakest, strongest = power_limits(lens.front, lens.back)
    assert weakest <= optics.power <= strongest


@settings(max_examples=60)
@given(prescriptions, powers, indices)
def test_a_ground_lens_has_the_power_that_is_asked_for_and_keeps_its_cylinder(prescription, power, index):
    plain = replace(prescription, prism=0.0)
    lens = changed(lens_of(plain), power, index)
    refractive = plain.index if index is None else index
    assert lens.front.material.index == lens.back.material.index == refractive
    assert lens.front.material.abbe == plain.abbe
    assert power_along(lens, plain.axis, refractive) == pytest.approx(power, abs=2e-3)
    assert power_along(lens, plain.axis + 90.0, refractive) == pytest.approx(power + plain.cylinder, abs=2e-3)


@settings(max_examples=40)
@given(prescriptions, indices)
def test_another_index_alone_keeps_power_and_prism(prescription, index):
    lens = changed(lens_of(prescription), index=index)
    refractive = prescription.index if index is None else index
    optics = optics_of(lens.front, lens.back)
    assert optics.power == pytest.approx(prescription.sphere, abs=1e-4)
    toward = np.cos(np.radians(prescription.base)) * RIGHT + np.sin(np.radians(prescription.base)) * UP
    _, directions = through(lens, 0.05 * OUTWARD, -OUTWARD, refractive)
    deviated = prescription.prism / 100.0 * toward - OUTWARD
    # The front's axis is read from its normals, which are rounded.
    np.testing.assert_allclose(directions[0] / -directions[0, 2], deviated, atol=2e-6)


@settings(max_examples=40)
@given(prescriptions, powers, indices)
def test_a_ground_lens_is_closed_and_on_its_exact_surfaces(prescription, power, index):
    before = lens_of(prescription)
    lens = changed(before, power, index)
    for mesh, old in zip(lens.meshes[:2], before.meshes[:2], strict=True):
        assert mesh.surface is not None and mesh.parameters is not None
        np.testing.assert_allclose(mesh.surface.position(mesh.parameters), mesh.positions, atol=2e-7)
        # Each vertex stays as far across the axis.
        np.testing.assert_allclose(mesh.positions[:, :2], old.positions[:, :2], atol=2e-7)
        a, b, c = np.moveaxis(mesh.positions[mesh.faces].astype(float), 1, 0)
        area = np.cross(b - a, c - a)
        assert (np.einsum("fk,fck->fc", area, mesh.normals[mesh.faces].astype(float)) > 0.0).all()
    points = np.concatenate([mesh.positions for mesh in lens.meshes])
    starts = np.cumsum([0, *(len(mesh.positions) for mesh in lens.meshes)])
    faces = np.concatenate([mesh.faces + start for mesh, start in zip(lens.meshes, starts, strict=False)])
    _, numbers = np.unique(points, axis=0, return_inverse=True)
    joined = numbers.reshape(-1)[faces]
    directed = np.concatenate([joined[:, [0, 1]], joined[:, [1, 2]], joined[:, [2, 0]]])
    np.testing.assert_array_equal(np.unique(directed, axis=0), np.unique(directed[:, ::-1], axis=0))
    # The back vertex stays, and the front moves only where the edge would vanish.
    np.testing.assert_allclose(lens.back.positions[0], 0.0, atol=1e-7)
    thick = (lens.front.positions - lens.back.positions).astype(float)[:, 2]
    was = (before.front.positions - before.back.positions).astype(float)[:, 2]
    assert thick.min() >= min(LEAST_EDGE, was.min()) - 1e-6
    if thick[0] > was[0] + 1e-6:
        assert thick.min() == pytest.approx(min(LEAST_EDGE, was.min()), abs=1e-6)


def test_power_grows_thickness_without_a_jump():
    lens = worn_lens(Prescription(2.0, centre_thickness=4.0), ORIGIN, (0.0, 0.0, 1.0), vertices=127)
    swept = [optics_of(*ground(lens.meshes, power)[:2]).thickness for power in np.arange(2.0, 6.0, 0.05)]
    assert swept[0] == pytest.approx(0.004, abs=1e-8) and swept[-1] > 0.006
    assert np.diff(swept).min() > -2e-7 and np.diff(swept).max() < 1.2e-4


def test_the_thin_lens_power_is_that_of_its_curvatures():
    mesh_free = dict(middle=np.zeros(3), axes=AXES, radius=0.01, glass=Glass(1.5), vertices=61)
    front = EvenAsphere(np.array([0.0, 0.0, 1e-6 + 4e-4]), 4.0, axes=AXES)
    back = EvenAsphere(np.zeros(3), 2.0, axes=BEHIND)
    lens = lens_between(front, back, **mesh_free)
    # 1 / f = (n - 1) (c1 + c2), but for the thickness.
    assert optics_of(lens.front, lens.back).power == pytest.approx(0.5 * 6.0, rel=1e-3)
    flat = ground(lens.meshes, 0.0)
    assert flat[1].surface.curvature == pytest.approx(-4.0, rel=2e-3)
    stronger = ground(lens.meshes, index=1.75)
    assert stronger[1].surface.curvature == pytest.approx(0.0, abs=5e-3)


@pytest.mark.parametrize("name", ["spectacles-minus", "spectacles-plus", "magnifier"])
def test_the_lenses_of_the_built_in_scenes_can_be_ground_to_their_limits(name):
    scene = gallery.make(name)
    pair = lens_pairs(scene.meshes)[0]
    lens = [scene.meshes[number] for number in (pair.front, pair.back, pair.edge)]
    for power in power_limits(*lens[:2]):
        made = ground(lens, power)
        assert optics_of(*made[:2]).power == pytest.approx(power, abs=1e-3)
    assert ground(lens, optics_of(*lens[:2]).power) == tuple(lens)
    assert ground(lens, index=lens[0].material.index) == tuple(lens)
    assert ground(lens[:2], optics_of(*lens[:2]).power - 1.0)[0] is lens[0]


def test_the_image_through_a_ground_lens_is_still_true():
    lens = make_lens(Prescription(-3.0, diameter=50.0), (0.1, 0.57, 0.4), (-0.3, -0.15, -1.0))
    scene = scene_with(*ground(lens.meshes, 2.0, 1.67), camera=replace(scene_with().camera, field_of_view=12.0))
    assert scene.meshes[3:] and len(surroundings()) > 3
    reference = drawn(scene, "raytrace:dispersion=false")
    errors = measure(reference, drawn(scene, "pervertex"))
    assert (reference.specular > 0).sum() > 1000
    assert errors.pixels.p95 < 0.6 and errors.other_object_percent < 2.0


LENS = make_lens(Prescription(3.0, centre_thickness=6.0, diameter=40.0), ORIGIN, (0.0, 0.0, 1.0), vertices=61)
OFF = EvenAsphere(np.array([0.004, 0.0, 0.0]), 2.0, axes=BEHIND)


@pytest.mark.parametrize(
    ("lens", "power", "index", "words"),
    [
        (LENS.meshes, 60.0, None, "its back needs a radius of"),
        (LENS.meshes, -60.0, None, "its back needs a radius of"),
        (LENS.meshes, None, 1.0, "index 1 has no power; give an index above 1"),
        (LENS.meshes, 3.0, 1.0002, "has no power"),
        (LENS.meshes, None, 1.02, "its back needs a radius of"),
        ((LENS.front, replace(LENS.back, surface=OFF)), 1.0, None, "no exact radii"),
        ((replace(LENS.front, surface=BezierPatch(np.ones((4, 4, 3)))), LENS.back), 1.0, None, "no exact radii"),
    ],
)
def test_a_lens_that_cannot_be_made_is_one_line(lens, power, index, words):
    with pytest.raises(AnamorphError, match=rf"^lens 'lens': [^\n]*{words}[^\n]*$"):
        ground(lens, power, index)


def test_a_ball_lens_that_focuses_inside_has_no_power_and_a_thick_one_fewer_indices():
    ball = [EvenAsphere(np.array([0.0, 0.0, z]), 100.0, axes=axes) for z, axes in ((0.02, AXES), (0.0, BEHIND))]

    def lens(index: float) -> Lens:
        return lens_between(ball[0], ball[1], np.zeros(3), AXES, 0.005, Glass(index), vertices=61)

    assert optics_of(lens(2.0).front, lens(2.0).back) is None
    glass = lens(1.5)
    # The back focus of a ball is r (2 - n) / (2 (n - 1)) behind it.
    assert optics_of(glass.front, glass.back).power == pytest.approx(2.0 * 0.5 / (0.01 * 0.5), rel=1e-6)
    low, high = index_limits(glass.front, glass.back)
    assert 1.3 <= low <= 1.5 <= high < 2.0
    for index in (low, high):
        assert optics_of(*ground(glass.meshes, index=index)[:2]).power == pytest.approx(200.0, rel=1e-3)


def test_a_lens_without_radii_changes_its_index_alone():
    faces = (LENS.front, replace(LENS.back, surface=OFF))
    front, back = ground(faces, index=1.7)
    assert front.material.index == back.material.index == 1.7
    assert front.positions is faces[0].positions and back.surface is OFF
