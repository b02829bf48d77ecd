"""Lenses from prescriptions: closed, of the power that is asked for, the right way round, or refused in one line."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from light import through

from anamorph.base.errors import AnamorphError
from anamorph.lenses.lens import Lens, disc, lens_between, rings_for, thickness
from anamorph.lenses.making import edge_thickness, make_lens, worn_lens
from anamorph.lenses.prescription import Prescription
from anamorph.scene.model import Glass
from anamorph.surfaces.sphere import round_surface

RIGHT, UP, OUTWARD = np.eye(3)
ORIGIN = (0.0, 0.0, 0.0)
AXES = np.eye(3)

prescriptions = st.builds(
    Prescription,
    sphere=st.one_of(st.sampled_from([0.0, -6.0, 6.0, -20.0]), st.floats(-12.0, 10.0)),
    cylinder=st.one_of(st.just(0.0), st.sampled_from([-2.0, 2.0]), st.floats(-4.0, 4.0)),
    axis=st.one_of(st.sampled_from([0.0, 90.0, 180.0]), st.floats(0.0, 180.0)),
    prism=st.one_of(st.just(0.0), st.floats(0.0, 8.0)),
    base=st.floats(0.0, 360.0),
    index=st.sampled_from([1.498, 1.6, 1.74]),
    centre_thickness=st.floats(1.0, 12.0),
    base_curve=st.one_of(st.none(), st.sampled_from([0.0, 4.0, -2.0]), st.floats(0.0, 8.0)),
    diameter=st.floats(10.0, 60.0),
)


def possible(prescription: Prescription) -> bool:
    """Whether its faces cross nowhere: beside a strong prism they may do so well inside the edge."""
    try:
        edge = edge_thickness(prescription)
    except AnamorphError:
        return False
    across = 5e-4 * prescription.diameter * np.linspace(-1.0, 1.0, 41)
    places = np.stack(np.meshgrid(across, across), axis=-1).reshape(-1, 2)
    inside = places[np.linalg.norm(places, axis=1) <= across[-1]]
    front, back = prescription.surfaces(np.zeros(3), AXES)
    return edge > 0.0 and thickness(front, back, np.zeros(3), AXES, inside).min() > 1e-5


def lens_of(prescription: Prescription, vertices: int = 61) -> Lens:
    """Its back vertex at the origin, the world along +z."""
    return make_lens(prescription, ORIGIN, (0.0, 0.0, 1.0), vertices=vertices)


def power_along(prescription: Prescription, degrees: float) -> float:
    """Back vertex power, dioptres, of a principal meridian: parallel light near the axis, followed to the axis."""
    lens, along = lens_of(prescription), np.cos(np.radians(degrees)) * RIGHT + np.sin(np.radians(degrees)) * UP
    height = 1e-5
    ends, directions = through(lens, height * along + 0.05 * OUTWARD, -OUTWARD, prescription.index)
    return float(-(directions @ along)[0] / (ends @ along)[0] / -(directions @ OUTWARD)[0])


@settings(max_examples=40)
@given(prescriptions)
def test_back_vertex_power_is_the_prescriptions(prescription):
    assume(possible(prescription))
    plain = replace(prescription, prism=0.0)
    assume(possible(plain))
    assert power_along(plain, plain.axis) == pytest.approx(plain.sphere, abs=1e-3)
    assert power_along(plain, plain.axis + 90.0) == pytest.approx(plain.sphere + plain.cylinder, abs=1e-3)


@pytest.mark.parametrize(
    ("axis", "strong"), [(90.0, RIGHT), (180.0, UP), (0.0, UP), (45.0, UP - RIGHT), (135.0, UP + RIGHT)]
)
def test_the_cylinder_acts_across_its_axis_seen_by_who_faces_the_wearer(axis, strong):
    # The lens faces +z: who looks at it from there sees +x on the right.
    lens = lens_of(Prescription(0.0, 3.0, axis, base_curve=2.0, diameter=40.0))
    strong = strong / np.linalg.norm(strong)
    weak = np.cross(OUTWARD, strong)
    _, directions = through(lens, 1e-3 * np.stack([strong, weak]) + 0.05 * OUTWARD, -np.stack([OUTWARD] * 2), 1.5)
    assert -directions[0] @ strong == pytest.approx(3e-3, rel=0.01)
    assert np.abs(directions[1] @ AXES[:2].T).max() < 2e-5


@pytest.mark.parametrize("base", [0.0, 90.0, 215.0])
@pytest.mark.parametrize("prism", [0.5, 6.0])
def test_light_along_the_axis_is_deviated_by_the_prism_toward_its_base(prism, base):
    prescription = Prescription(-3.0, 1.5, 30.0, prism, base, centre_thickness=6.0, diameter=40.0)
    toward = np.cos(np.radians(base)) * RIGHT + np.sin(np.radians(base)) * UP
    _, directions = through(lens_of(prescription), 0.05 * OUTWARD, -OUTWARD, prescription.index)
    np.testing.assert_allclose(directions[0] / -directions[0, 2], prism / 100.0 * toward - OUTWARD, atol=1e-12)


def test_the_base_of_a_prism_is_its_thick_side():
    lens = lens_of(Prescription(0.0, prism=5.0, base=90.0, base_curve=0.0, centre_thickness=4.0))
    top, bottom = np.argmax(lens.front.positions[:, 1]), np.argmin(lens.front.positions[:, 1])
    thick = lens.front.positions[:, 2] - lens.back.positions[:, 2]
    assert thick[top] > thick[0] > thick[bottom]
    # 5 cm/m over (n - 1) is the wedge, and 60 mm is the width.
    assert thick[top] - thick[bottom] == pytest.approx(0.06 * 0.05 / 0.5, rel=0.02)


@settings(max_examples=40)
@given(prescriptions, st.integers(7, 700))
@example(Prescription(0.0, base_curve=1e-6, centre_thickness=1.0, diameter=10.0), 7)
def test_a_lens_is_closed_wound_outward_and_on_its_exact_surfaces(prescription, vertices):
    assume(possible(prescription))
    axes = np.array([[0.8, 0.0, -0.6], [0.36, 0.8, 0.48], [0.48, -0.6, 0.64]])
    place = np.array([0.3, 1.2, -0.5])
    lens = make_lens(prescription, tuple(place), tuple(axes[2]), tuple(axes[1]), vertices=vertices)
    points = np.concatenate([mesh.positions for mesh in lens.meshes])
    starts = np.cumsum([0, *(len(mesh.positions) for mesh in lens.meshes)])
    faces = np.concatenate([mesh.faces + start for mesh, start in zip(lens.meshes, starts, strict=False)])
    _, index = np.unique(points, axis=0, return_inverse=True)
    joined = index.reshape(-1)[faces]
    directed = np.concatenate([joined[:, [0, 1]], joined[:, [1, 2]], joined[:, [2, 0]]])
    # Closed and wound one way: each edge is run along once in each direction.
    assert len(np.unique(directed, axis=0)) == len(directed)
    np.testing.assert_array_equal(np.unique(directed, axis=0), np.unique(directed[:, ::-1], axis=0))
    corners = points[faces].astype(float) - place
    assert np.linalg.det(corners).sum() > 0.0
    for mesh in lens.meshes:
        a, b, c = np.moveaxis(mesh.positions[mesh.faces].astype(float), 1, 0)
        area = np.cross(b - a, c - a)
        assert (np.einsum("fk,fck->fc", area, mesh.normals[mesh.faces].astype(float)) > 0.0).all(), mesh.name
    for mesh in lens.meshes[:2]:
        assert mesh.surface is not None and mesh.parameters is not None
        np.testing.assert_allclose(mesh.surface.position(mesh.parameters), mesh.positions, atol=2e-7)
        # The apex is (0, 0), far from where the parameters of a sphere jump.
        np.testing.assert_allclose(mesh.parameters[0], 0.0, atol=1e-9)
        away = mesh.surface.position(mesh.parameters) - place
        border = away[-6 * rings_for(vertices) :] @ axes[:2].T
        # A nearly flat face is part of a sphere of kilometres, whose points are rounded as its radius is.
        rounding = np.spacing(getattr(mesh.surface, "radius", 1.0))
        reach = np.linalg.norm(border, axis=1)
        np.testing.assert_allclose(reach, 5e-4 * prescription.diameter, rtol=1e-9, atol=2.0 * rounding)
        np.testing.assert_allclose(away[0] @ axes[:2].T, 0.0, atol=1e-12 + 2.0 * rounding)
    on_axis = (lens.front.positions[0] - lens.back.positions[0]).astype(float) @ axes[2]
    assert on_axis == pytest.approx(1e-3 * prescription.centre_thickness, abs=3e-7)


def test_edge_thickness_of_two_spheres_is_centre_thickness_less_the_sags():
    prescription = Prescription(-6.0, base_curve=3.0, diameter=60.0, centre_thickness=1.5)
    front, back = 0.5 / 3.0, 0.5 / (6.0 + 3.0 / (1.0 - 1.5e-3 / 1.5 * 3.0))
    sags = [radius - np.sqrt(radius**2 - 0.03**2) for radius in (front, back)]
    assert edge_thickness(prescription) == pytest.approx(1.5 + 1e3 * (sags[1] - sags[0]), abs=1e-9)
    assert edge_thickness(prescription) > prescription.centre_thickness


def test_a_worn_lens_is_at_its_vertex_distance_and_looks_along_the_gaze():
    lens = worn_lens(Prescription(-2.0, vertex_distance=13.0), (1.0, 1.5, 2.0), (0.0, 0.0, -3.0))
    np.testing.assert_allclose(lens.back.positions[0], [1.0, 1.5, 2.0 - 0.013], atol=1e-7)
    np.testing.assert_allclose(lens.front.positions[0], [1.0, 1.5, 2.0 - 0.015], atol=1e-7)
    assert isinstance(lens.front.material, Glass)
    assert (lens.front.material.index, lens.front.material.abbe) == (1.5, 58.0)
    assert [mesh.name for mesh in lens.meshes] == ["lens/front", "lens/back", "lens/edge"]


@given(st.integers(1, 20))
def test_a_disc_covers_the_circle_with_its_border_last(rings):
    points, faces = disc(rings)
    assert len(points) == 1 + 3 * rings * (rings + 1) and len(faces) == 6 * rings**2
    a, b, c = np.moveaxis(points[faces], 1, 0)
    area = 0.5 * np.linalg.det(np.stack([b - a, c - a], axis=-1))
    assert (area > 0.0).all()
    border = np.linalg.norm(points[-6 * rings :], axis=1)
    np.testing.assert_allclose(border, 1.0)
    assert area.sum() == pytest.approx(3 * rings * np.sin(np.pi / (3 * rings)))
    assert rings_for(len(points)) == rings


@pytest.mark.parametrize("wanted", [500, 750, 1000])
def test_the_number_of_vertices_is_about_what_is_asked_for(wanted):
    lens = lens_of(Prescription(-3.0), wanted)
    assert abs(len(lens.front.positions) / wanted - 1.0) < 0.1
    assert len(lens.front.positions) == len(lens.back.positions)


@settings(max_examples=60)
@given(prescriptions)
def test_an_impossible_lens_is_refused_with_a_remedy_that_works(prescription):
    try:
        lens_of(prescription, 7)
    except AnamorphError as error:
        words = str(error)
        assert words.startswith("prescription: ") and "give " in words and "\n" not in words
        if "centre_thickness of at least" in words:
            thick = float(words.split("at least ")[1].split(" mm")[0])
            lens_of(replace(prescription, centre_thickness=thick), 7)
        elif "diameter of at most" in words:
            side = "the front surface" if "the front surface" in words else "the back surface"
            smaller = replace(prescription, diameter=float(words.split("at most ")[1].split(" mm")[0]) - 0.1)
            try:
                edge_thickness(smaller)
            except AnamorphError as other:
                assert side not in str(other)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"sphere": np.nan}, "sphere"),
        ({"sphere": "-4"}, "sphere"),
        ({"cylinder": None}, "cylinder"),
        ({"index": 1.0}, "index"),
        ({"abbe": 0.0}, "abbe"),
        ({"axis": 181.0}, "axis"),
        ({"base": -1.0}, "base"),
        ({"prism": -1.0}, "prism"),
        ({"centre_thickness": 0.0}, "centre_thickness"),
        ({"diameter": -60.0}, "diameter"),
        ({"vertex_distance": -1.0}, "vertex_distance"),
        ({"vertex_distance": 0.0}, "vertex_distance"),
    ],
)
def test_a_prescription_that_makes_no_sense_is_refused_by_field(change, word):
    with pytest.raises(AnamorphError, match=rf"^prescription: {word} is [^\n]*; give [^\n]*$"):
        Prescription(**{"sphere": -1.0, **change})


@pytest.mark.parametrize(
    ("prescription", "words"),
    [
        (Prescription(6.0), "edge thickness is -"),
        (Prescription(-40.0), "the back surface needs a radius"),
        # The prism moves the back's centre aside: across the axis it reaches 22.9 mm to one side, and no further.
        (Prescription(-20.0, prism=4.0, index=1.498, centre_thickness=1.0, diameter=46.0), "the back surface needs"),
        (Prescription(10.0, base_curve=40.0), "the front surface needs a radius"),
        (Prescription(1.0, base_curve=800.0), "focuses light inside the lens"),
    ],
)
def test_what_cannot_be_ground_says_why(prescription, words):
    with pytest.raises(AnamorphError, match=rf"^prescription: [^\n]*{words}[^\n]*give [^\n]*$"):
        lens_of(prescription)


def test_surfaces_that_cross_and_axes_along_the_gaze_are_refused():
    front, back = round_surface(0.001 * OUTWARD, AXES, 10.0), round_surface(np.zeros(3), AXES, 0.0)
    with pytest.raises(AnamorphError, match=r"^lens 'thin': its faces cross [^\n]* thicker or smaller$"):
        lens_between(front, back, np.zeros(3), AXES, 0.03, Glass(), "thin")
    with pytest.raises(AnamorphError, match=r"^lens: outward [^\n]* one direction"):
        make_lens(Prescription(1.0), ORIGIN, (0.0, 2.0, 0.0))
