"""Where mirrors and lenses end: on circles that they know, or straight, and always on the exact surface."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import flat_mirror, open_edges, open_view, scene_with

from anamorph.base.errors import AnamorphError
from anamorph.gallery.solids import lattice
from anamorph.gallery.spheres import mirror_ball
from anamorph.lenses.lens import disc
from anamorph.lenses.making import lens_axes, worn_lens
from anamorph.lenses.prescription import Prescription
from anamorph.optics import tessellation
from anamorph.optics.borders import lens_borders, mirror_borders
from anamorph.optics.refraction import refractor
from anamorph.optics.tessellation import BORDER, ENLARGED, border_errors, outlined_scene
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import flatten
from anamorph.scene.lens_pairs import border_edges
from anamorph.scene.model import Diffuse, Mesh, Mirror, Scene
from anamorph.scene.triangles import doubled_areas
from anamorph.surfaces.even_asphere import EvenAsphere
from anamorph.surfaces.plane import Plane
from anamorph.surfaces.sphere import Sphere
from anamorph.surfaces.toroid import Toroid

SIZE = (1024, 768)
REACH = 0.3
AXES = lens_axes((0.3, 0.2, 1.0))
MIDDLE = np.array([0.1, 0.4, -0.2])
EYE = Camera(tuple(MIDDLE + 1.5 * AXES[2] + 0.3 * AXES[0]), tuple(MIDDLE), field_of_view=40.0)
"""It sees the whole front of what is made here."""

SPHERE = Sphere(MIDDLE - 0.7 * AXES[2], 0.7, AXES)
SURFACES = {
    "sphere": SPHERE,
    "hollow sphere": Sphere(MIDDLE + 0.7 * AXES[2], 0.7, AXES * [[1.0], [-1.0], [-1.0]]),
    "plane": Plane(MIDDLE, AXES[0], AXES[1]),
    "toroid": Toroid(MIDDLE, 1.4, -0.9, AXES),
    "asphere": EvenAsphere(MIDDLE, 1.2, -0.7, (0.4,), AXES),
}


def on(surface, places, faces, name="mirror"):
    """A mirror on a surface over `places` (N, 2), metres across the axis from its middle."""
    if isinstance(surface, Sphere):
        across = places @ AXES[:2]
        height = np.sqrt(surface.radius**2 - np.sum(places**2, axis=1))[:, None] * surface.axes[2]
        parameters = surface.parameters(surface.center + across + height)
    else:
        parameters = places
    return Mesh.exact(name, surface, parameters, faces, Mirror(), AXES[2])


def cap(surface=SPHERE, rings=2):
    places, faces = disc(rings)
    return on(surface, REACH * places, faces)


def polygon(corners, turn=2.0 * np.pi, surface=SPHERE):
    """A fan over a regular polygon, or with a cut over that part of one which goes around as far as `turn`."""
    whole = turn > 6.0
    angle = np.linspace(0.0, turn, corners + 1)[: corners + (not whole)]
    places = REACH * np.concatenate([[[0.0, 0.0]], np.stack([np.cos(angle), np.sin(angle)], axis=-1)])
    ends = np.arange(corners)
    return on(surface, places, np.stack([np.zeros(corners, int), ends + 1, (ends + 1) % len(angle) + 1], axis=-1))


def annulus():
    """A cap with a round hole."""
    angle = np.arange(24) * np.pi / 12
    around = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    inner, outer = np.arange(24), np.arange(24) + 24
    following = (inner + 1) % 24
    faces = [np.stack([inner, outer, following + 24], -1), np.stack([inner, following + 24, following], -1)]
    return on(SPHERE, np.concatenate([0.12 * around, REACH * around]), np.concatenate(faces))


def refined(*meshes, camera=EYE, size=SIZE):
    return outlined_scene(Scene("test", meshes, camera), camera, size).meshes


def border_of(mesh):
    """Places of border vertices across the axis and along it, (N, 2) and (N,); and the ends of its edges, (E, 2)."""
    edges = border_edges(mesh).T
    local = (mesh.exact_positions() - MIDDLE) @ AXES.T
    return local[:, :2], local[:, 2], edges


@pytest.mark.parametrize("name", SURFACES)
def test_a_round_border_gets_vertices_on_its_circle_and_on_the_surface(name):
    surface, coarse = SURFACES[name], cap(SURFACES[name])
    (fine,) = refined(coarse)
    count = len(coarse.positions)
    assert len(fine.positions) >= count + 84
    assert (fine.positions[:count] == coarse.positions).all() and (fine.parameters[:count] == coarse.parameters).all()
    places, _, edges = border_of(fine)
    radii = np.linalg.norm(places[np.unique(edges)], axis=1)
    assert np.abs(radii - REACH).max() < 1e-9
    assert np.abs(fine.positions - surface.position(surface.parameters(fine.positions))).max() < 1e-9
    normals = surface.normals_toward(fine.parameters, np.tile(AXES[2], (len(fine.positions), 1)))
    assert np.abs(fine.normals - normals).max() < 2e-7


@pytest.mark.parametrize("name", SURFACES)
def test_its_chords_leave_the_circle_by_less_than_the_bound(name):
    """By the closed form of a chord's height, at each chord's own distance."""
    (fine,) = refined(cap(SURFACES[name]))
    places, _, edges = border_of(fine)
    length = np.linalg.norm(places[edges[:, 1]] - places[edges[:, 0]], axis=1)
    height = REACH - np.sqrt(REACH**2 - 0.25 * length**2)
    ends = fine.exact_positions()[edges]
    distance = np.linalg.norm(ends - np.asarray(EYE.position), axis=2).min(axis=1)
    focal = 0.5 * SIZE[1] / np.tan(np.radians(0.5 * EYE.field_of_view))
    assert (height / distance * focal).max() <= BORDER
    assert border_errors(fine, mirror_borders(fine), EYE, SIZE)[0].max() <= BORDER
    # Not finer than need be: a round border of half as many vertices would be too coarse somewhere.
    assert (4.0 * height / distance * focal).max() > BORDER


@pytest.mark.parametrize("corners", [3, 4, 6, 8, 11])
def test_a_polygon_stays_one(corners):
    """Its corners lie on a circle, but its sides are straight in the parameters of the surface."""
    coarse = polygon(corners)
    (fine,) = refined(coarse)
    assert len(fine.positions) > len(coarse.positions)
    places, _, edges = border_of(fine)
    added = np.setdiff1d(np.unique(edges), np.arange(len(coarse.positions)))
    assert np.linalg.norm(places[added], axis=1).max() < REACH * np.cos(0.2 * np.pi / corners)


@pytest.mark.parametrize("name", SURFACES)
@pytest.mark.parametrize("middle", [True, False])
def test_half_a_disc_is_round_and_keeps_its_straight_cut(name, middle):
    """Whether the cut is one edge, whose ends lie on the circle, or more."""
    coarse = polygon(12, np.pi, SURFACES[name])
    if not middle:
        fan = np.stack([np.full(11, 1), np.arange(2, 13), np.arange(3, 14)], axis=-1)
        coarse = replace(coarse, faces=fan.astype(np.int32))
    (fine,) = refined(coarse)
    places, _, edges = border_of(fine)
    border = np.unique(edges)
    straight = np.abs(places[border, 1]) < 1e-9
    round_ = np.abs(np.linalg.norm(places[border], axis=1) - REACH) < 1e-9
    assert (straight | round_).all() and round_.sum() == 12 * 8 + 1
    assert straight.sum() > 2 + middle or name == "plane"


def test_half_a_ball_ends_in_a_great_circle():
    """There the sphere runs along the axis of its border."""
    places, faces = disc(2)
    angle = 0.5 * np.pi * np.linalg.norm(places, axis=1)
    turn = np.arctan2(places[:, 1], places[:, 0])
    directions = np.stack([np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), np.cos(angle)], axis=-1)
    coarse = Mesh.exact("mirror", SPHERE, SPHERE.parameters(SPHERE.center + directions @ AXES), faces, Mirror())
    (fine,) = refined(coarse)
    offsets = fine.exact_positions()[np.unique(border_edges(fine))] - SPHERE.center
    assert len(offsets) > 100
    assert np.abs(offsets @ AXES[2]).max() < 1e-9
    assert np.abs(np.linalg.norm(offsets, axis=1) - SPHERE.radius).max() < 1e-9


def test_a_hole_is_round_too():
    coarse = annulus()
    assert len(mirror_borders(coarse)) == 2
    (fine,) = refined(coarse)
    places, _, edges = border_of(fine)
    radii = np.linalg.norm(places[np.unique(edges)], axis=1)
    inner = radii < 0.2
    assert np.abs(radii[inner] - 0.12).max() < 1e-9 and np.abs(radii[~inner] - REACH).max() < 1e-9
    assert inner.sum() > 24 and (~inner).sum() > 24
    assert (doubled_areas(fine.positions, fine.faces) @ AXES[2] > 0.0).all()


PRESCRIPTIONS = {
    "minus": Prescription(-6.0, index=1.6),
    "plus": Prescription(4.0, centre_thickness=6.0),
    "toric with prism": Prescription(-3.0, cylinder=-2.0, axis=35.0, prism=3.0, base=60.0, centre_thickness=4.0),
}


def worn(prescription, vertices=127):
    """A lens at 12 mm, and the eye that wears it."""
    lens = worn_lens(prescription, (0.1, 0.2, 0.3), (0.2, 0.1, -1.0), vertices=vertices)
    return lens, Camera((0.1, 0.2, 0.3), (0.3, 0.3, -0.7), field_of_view=90.0)


@pytest.mark.parametrize("name", PRESCRIPTIONS)
def test_a_lens_ends_on_its_cylinder_and_stays_closed(name):
    lens, camera = worn(PRESCRIPTIONS[name])
    before = refractor(lens.front, lens.back)
    meshes = refined(*lens.meshes, camera=camera)
    front, back, edge = meshes
    after = refractor(front, back)
    assert len(border_edges(front).T) == len(border_edges(back).T) >= 8 * 36
    np.testing.assert_allclose(after.middle, before.middle, atol=1e-12)
    np.testing.assert_allclose(after.axis, before.axis, atol=1e-12)
    assert after.radius == pytest.approx(before.radius, rel=1e-12)
    borders = []
    for new, old in zip(meshes, lens.meshes, strict=True):
        assert (new.positions[: len(old.positions)] == old.positions).all()
        assert (new.normals[: len(old.normals)] == old.normals).all()
    for face in (front, back):
        border = np.unique(border_edges(face))
        away = face.exact_positions()[border] - after.middle
        away -= np.outer(away @ after.axis, after.axis)
        assert np.abs(np.linalg.norm(away, axis=1) - after.radius).max() < 1e-9
        borders.append(face.positions[border])
        errors, arcs = border_errors(face, lens_borders(front, back, edge), camera, SIZE)
        assert errors.max() <= BORDER / ENLARGED and arcs.sum() == len(border)
    # Each vertex of the edge is one of a face's border, to the last bit, and the other way round.
    own, theirs = ({tuple(each) for each in values.tolist()} for values in (edge.positions, np.concatenate(borders)))
    assert own == theirs and len(own) == len(edge.positions) and len(edge.faces) == len(edge.positions)
    assert not open_edges(*meshes)
    assert np.abs(np.linalg.norm(edge.normals, axis=1) - 1.0).max() < 1e-6
    assert np.abs(edge.normals @ after.axis).max() < 1e-6


def test_a_lens_of_other_trim_stays_as_it_is():
    """Half a lens, whose border is not on one cylinder, and one whose edge is more than a band."""
    lens, camera = worn(PRESCRIPTIONS["minus"])
    place = lens.front.positions[:, 0]
    halves = [
        replace(face, faces=face.faces[(face.positions[face.faces, 0] > place.mean()).all(axis=1)])
        for face in (lens.front, lens.back)
    ]
    assert lens_borders(*halves, None) == ()
    assert [len(mesh.faces) for mesh in refined(*halves, camera=camera)] == [len(half.faces) for half in halves]
    odd = replace(lens.edge, positions=np.concatenate([lens.edge.positions, [[0.0, 0.0, 0.0]]]))
    odd = replace(odd, normals=np.concatenate([odd.normals, [[0.0, 0.0, 1.0]]]))
    assert all(
        new is old
        for new, old in zip(
            refined(lens.front, lens.back, odd, camera=camera), (lens.front, lens.back, odd), strict=True
        )
    )


def test_a_lens_is_cut_all_around_or_not_at_all(monkeypatch):
    lens, camera = worn(PRESCRIPTIONS["plus"])
    faces = len(lens.front.faces) + len(lens.back.faces)
    for most, cut in ((faces + 6 * 71, False), (faces + 6 * 72, True)):
        monkeypatch.setattr(tessellation, "MOST_TRIANGLES", most)
        fine = refined(*lens.meshes, camera=camera)
        assert [len(mesh.faces) for mesh in fine[:2]] == [len(lens.front.faces) + 36 * cut] * 2
        assert not open_edges(*fine)


def test_an_edge_of_colours_keeps_them():
    lens, camera = worn(PRESCRIPTIONS["plus"])
    angle = np.tile(np.arange(36) * np.pi / 18, 2)
    colors = np.stack([0.5 + 0.5 * np.cos(angle), np.zeros(72), np.ones(72)], axis=-1).astype(np.float32)
    edge = replace(lens.edge, colors=colors, texcoords=colors[:, :2])
    fine = refined(lens.front, lens.back, edge, camera=camera)[2]
    assert (fine.colors[:72] == colors).all() and (fine.texcoords == fine.colors[:, :2]).all()
    axes = lens_axes((0.2, 0.1, -1.0))
    away = (fine.positions - fine.positions.mean(axis=0)) @ axes[:2].T
    turn = np.arctan2(away[:, 1], away[:, 0])
    assert np.abs(fine.colors[:, 0] - 0.5 - 0.5 * np.cos(turn)).max() < 0.01


def test_what_ends_nowhere_and_what_ends_well_stays_as_it_is():
    """A ball, whose mesh is open only along its own seam; a flat mirror; what has no exact surface; a far cap."""
    ball = mirror_ball("ball", (0.1, 0.4, -0.2), 0.3, 48, 96)
    plain = replace(cap(), surface=None, parameters=None)
    far = replace(EYE, position=tuple(MIDDLE + 300.0 * AXES[2]))
    for meshes, camera in (((ball, flat_mirror(), plain), EYE), ((cap(),), far)):
        assert all(
            new is old for new, old in zip(refined(*meshes, camera=camera, size=(160, 120)), meshes, strict=True)
        )


@pytest.mark.parametrize("radius", [3.0, 30.0, 1e3, 1e5])
def test_the_sides_of_a_square_are_sections_of_the_sphere_however_flat_that_is(radius):
    """Each side has vertices enough to tell its plane, in which it stays."""
    sphere = Sphere(MIDDLE - radius * AXES[2], radius, AXES)
    ticks = np.linspace(-REACH, REACH, 5)
    places = np.stack(np.meshgrid(ticks, ticks), axis=-1).reshape(-1, 2)
    coarse = on(sphere, places, lattice(5, 5))
    errors = border_errors(coarse, mirror_borders(coarse), EYE, SIZE)[0]
    height = radius - np.sqrt(radius**2 - 0.15**2 / 4.0)
    assert errors.max() < 1.1 * height / 1.2 * 1056.0
    (fine,) = refined(coarse)
    assert (fine is coarse) == (errors.max() <= BORDER)
    across, _, edges = border_of(fine)
    assert np.abs(np.abs(across[np.unique(edges)]).max(axis=1) - REACH).max() < 1e-9


def test_a_border_that_another_mesh_shares_is_left_to_it():
    """A diffuse mesh that ends where the cap does cannot follow the circle."""
    coarse = cap()
    back = Mesh("back", coarse.positions, coarse.faces[:, ::-1], -coarse.normals, Diffuse())
    fine = refined(coarse, back)
    assert fine[0] is coarse and fine[1] is back


def test_the_edge_of_a_refined_lens_does_not_deform():
    lens, camera = worn(PRESCRIPTIONS["minus"])
    scene = scene_with(*lens.meshes, camera=camera)
    session, geometry = open_view(scene, "raytrace", (160, 120)), flatten(scene)
    session.deform(geometry.positions, geometry.normals)
    edge = next(number for number, mesh in enumerate(scene.meshes) if mesh.name.endswith("/edge"))
    moved = geometry.positions.copy()
    moved[geometry.first_vertex[edge]] += 0.001
    with pytest.raises(AnamorphError, match="or a lens's edge"):
        session.deform(moved, geometry.normals)
