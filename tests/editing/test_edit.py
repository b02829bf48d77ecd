"""Parts turned, moved and bent where they stand: their exact surfaces go with them, and the images stay true."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import SIZE, drawn, flat_mirror, scene_with, spherical_mirror, surroundings

from anamorph import gallery
from anamorph.base.errors import AnamorphError
from anamorph.editing.bending import bend_of, bent
from anamorph.editing.edit import Edit, edit, lens_of, part_pose
from anamorph.gallery.solids import lattice
from anamorph.measure.compare import measure
from anamorph.scene.model import Glass, Mesh, Mirror
from anamorph.scene.parts import part_names, specular_parts
from anamorph.surfaces.base import Surface
from anamorph.surfaces.bezier import BezierPatch
from anamorph.surfaces.even_asphere import EvenAsphere
from anamorph.surfaces.plane import Plane
from anamorph.surfaces.sphere import Sphere
from anamorph.surfaces.toroid import Toroid

AXES = np.array([[0.8, 0.0, -0.6], [0.36, 0.8, 0.48], [0.48, -0.6, 0.64]])
PLACE = np.array([0.3, 1.2, -0.5])
angles = st.one_of(st.sampled_from([0.0, 90.0, -90.0, 180.0, 1e-9]), st.floats(-180.0, 180.0))
lengths = st.one_of(st.just(0.0), st.floats(-2.0, 2.0))
triples = st.tuples(angles, angles, angles)
places = st.tuples(lengths, lengths, lengths)


def on(surface: Surface, half: float = 0.1, count: int = 8, flip: bool = False) -> Mesh:
    """A mirror of count x count cells with (u, v) within `half`; flipped, it faces the other side of its surface."""
    line = np.linspace(-half, half, count + 1)
    uv = np.stack([each.ravel() for each in np.meshgrid(line, line)], axis=-1)
    faces = lattice(count + 1, count + 1)
    normals = surface.normal(uv) * (-1.0 if flip else 1.0)
    return Mesh(
        "mirror", surface.position(uv).astype(np.float32), (faces[:, ::-1] if flip else faces).astype(np.int32),
        normals.astype(np.float32), Mirror(), surface=surface, parameters=uv,
    )  # fmt: skip


SURFACES = [
    Sphere(PLACE, 1.4, AXES),
    Plane(PLACE, AXES[0], AXES[1]),
    Toroid(PLACE, 0.8, -0.5, AXES),
    EvenAsphere(PLACE, 0.9, -0.6, (0.3,), AXES),
]
BALL = next(mesh for mesh in gallery.make("spheres").meshes if mesh.name == "mirror-ball")
KINDS = [(surface, flip) for surface in SURFACES for flip in (False, True)]


def exact(mesh: Mesh) -> None:
    """Vertices and normals are those of the exact surface, wound to the side of the normals."""
    assert mesh.surface is not None and mesh.parameters is not None
    np.testing.assert_allclose(mesh.surface.position(mesh.parameters), mesh.positions, atol=4e-7)
    cosines = np.sum(mesh.surface.normal(mesh.parameters) * mesh.normals, axis=1)
    np.testing.assert_allclose(np.abs(cosines), 1.0, atol=1e-6)
    assert (np.sign(cosines) == np.sign(cosines[0])).all()
    a, b, c = np.moveaxis(mesh.positions[mesh.faces].astype(float), 1, 0)
    area = np.cross(b - a, c - a)
    assert (np.einsum("fk,fck->fc", area, mesh.normals[mesh.faces].astype(float)) > 0.0).all()


def frame_of(*meshes: Mesh):
    return part_pose(meshes, lens_of(meshes))


@settings(max_examples=40)
@given(st.sampled_from(KINDS), triples, places)
def test_a_part_is_turned_about_its_middle_and_moved_along_its_own_axes(kind, turn, move):
    mesh = on(kind[0], flip=kind[1])
    frame = frame_of(mesh)
    (changed,) = edit((mesh,), Edit(turn, move))
    exact(changed)
    before, after = ((each.positions - frame.center) @ frame.axes.T for each in (mesh, changed))
    # Nothing but moved: all distances stay.
    np.testing.assert_allclose(np.linalg.norm(after - move, axis=1), np.linalg.norm(before, axis=1), atol=1e-6)
    swivel, tilt, roll = np.radians(turn)
    x, y, z = before.T
    x, y = x * np.cos(roll) - y * np.sin(roll), x * np.sin(roll) + y * np.cos(roll)
    y, z = y * np.cos(tilt) + z * np.sin(tilt), z * np.cos(tilt) - y * np.sin(tilt)
    z, x = z * np.cos(swivel) - x * np.sin(swivel), z * np.sin(swivel) + x * np.cos(swivel)
    np.testing.assert_allclose(after, np.column_stack([x, y, z]) + move, atol=2e-6)


def test_positive_angles_turn_right_up_and_counter_clockwise_for_the_onlooker():
    # It faces +z, so that the onlooker's right is +x.
    mesh = spherical_mirror()

    def turned(*turn: float) -> np.ndarray:
        return edit((mesh,), Edit(turn))[0].normals.astype(float).mean(axis=0)

    assert turned(20.0, 0.0, 0.0)[0] > 0.3
    assert turned(0.0, 20.0, 0.0)[1] > 0.3
    corner = np.argmax(mesh.positions[:, 0] - 1e-3 * mesh.positions[:, 1])
    rolled = edit((mesh,), Edit((0.0, 0.0, 20.0)))[0].positions
    assert rolled[corner, 1] > mesh.positions[corner, 1] + 0.03


@pytest.mark.parametrize("name", ["car-mirror", "room", "spheres", "spectacles-minus", "magnifier"])
def test_a_part_is_all_that_shares_its_name_and_goes_together(name):
    scene = gallery.make(name)
    parts = specular_parts(scene.meshes)
    expected = {
        "car-mirror": ["mirror"], "room": ["teapot"], "spheres": ["mirror-ball", "mirror-flat"],
        "spectacles-minus": ["lens"], "magnifier": ["lens"],
    }  # fmt: skip
    assert list(parts) == expected[name]
    for own in parts.values():
        meshes = tuple(scene.meshes[i] for i in own)
        moved = edit(meshes, Edit((30.0, 0.0, 0.0), (0.0, 0.1, 0.0)))
        away = [b.positions.astype(float) - a.positions for a, b in zip(meshes, moved, strict=True)]
        # Turned about one upright axis, all rise alike.
        np.testing.assert_allclose(np.concatenate(away) @ frame_of(*meshes).axes[1], 0.1, atol=4e-6)


def test_lenses_in_one_group_are_parts_of_their_own():
    lens = [mesh for mesh in gallery.make("spectacles-plus").meshes if mesh.name.startswith("lens/")]
    meshes = [replace(mesh, name=f"glasses/{side}/{mesh.name[5:]}") for side in ("left", "right") for mesh in lens]
    names = part_names([*meshes, replace(spherical_mirror(), name="glasses/bridge")])
    inner = [replace(mesh, name=f"glasses/left/inlay/{mesh.name[5:]}") for mesh in lens]
    assert part_names([*meshes, *inner])[8:] == ["glasses/left/inlay"] * 4
    assert names == ["glasses/left"] * 4 + ["glasses/right"] * 4 + ["glasses"]


def test_what_nothing_is_changed_of_is_the_very_same():
    mesh = spherical_mirror()
    curvature = bend_of(mesh).curvatures[0]
    same = Edit(curvature=curvature, reflectance=mesh.material.reflectance)
    assert edit((mesh,), Edit())[0] is mesh and edit((mesh,), same)[0] is mesh
    lens = tuple(mesh for mesh in gallery.make("spectacles-plus").meshes if mesh.name.startswith("lens/"))
    stronger = edit(lens, Edit(power=7.0))
    assert stronger[0] is lens[0] and stronger[3] is lens[3] and stronger[1] is not lens[1]


def test_axes_are_those_of_the_part_as_it_was_however_it_is_bent():
    mesh = on(SURFACES[2])
    turn, move, middle = (10.0, 5.0, 0.0), (0.1, 0.0, 0.2), len(mesh.positions) // 2
    rigid, both = edit((mesh,), Edit(turn, move))[0], edit((mesh,), Edit(turn, move, 0.2, 1.0))[0]
    normal = rigid.normals[middle].astype(float)
    # The middle comes forward as the mirror is bent, along its own axis.
    away = both.positions[middle].astype(float) - rigid.positions[middle]
    np.testing.assert_allclose(away, (away @ normal) * normal, atol=3e-7)
    np.testing.assert_allclose(both.normals[middle], normal, atol=1e-6)
    assert np.abs(both.positions - rigid.positions).max() > 1e-3


def rearmost(mesh: Mesh, outward: np.ndarray) -> float:
    return float((mesh.positions.astype(float) @ outward).min())


curvatures = st.one_of(st.sampled_from([0.0, 1e-12, -1e-7, 1e-5, -1.0]), st.floats(-4.0, 4.0))


@settings(max_examples=60)
@given(st.sampled_from(KINDS), curvatures, st.one_of(st.none(), curvatures))
def test_bending_keeps_the_outline_and_what_lies_rearmost_and_gives_the_curvature(kind, curvature, cross):
    mesh = on(kind[0], flip=kind[1])
    cross = cross if isinstance(mesh.surface, Toroid) else None
    changed = bent(mesh, curvature, cross)
    exact(changed)
    # On a flat mirror the vertices that were there come first.
    first = slice(len(mesh.positions))
    middle = len(mesh.positions) // 2
    normal = mesh.surface.normal(np.zeros((1, 2)))[0] * (-1.0 if kind[1] else 1.0)
    assert rearmost(changed, normal) == pytest.approx(rearmost(mesh, normal), abs=4e-7)
    moved = changed.positions[first].astype(float) - mesh.positions
    np.testing.assert_allclose(moved - np.outer(moved @ normal, normal), 0.0, atol=4e-7)
    np.testing.assert_allclose(changed.normals[middle], normal, atol=1e-6)
    bend = bend_of(changed)
    assert bend is not None
    wanted = (curvature,) if cross is None else (curvature, cross)
    np.testing.assert_allclose(bend.curvatures[: len(wanted)], wanted, rtol=1e-9, atol=1e-6)
    # A convex mirror's rim lies behind its middle.
    if isinstance(mesh.surface, Sphere | Plane) and abs(curvature) > 1e-3:
        rim = (changed.positions[0] - changed.positions[middle]) @ normal
        assert np.sign(rim) == -np.sign(curvature)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: f"{type(kind[0]).__name__}-{kind[1]}")
def test_bending_to_the_same_curvature_is_the_identity_and_near_it_is_near(kind):
    mesh = on(kind[0], flip=kind[1])
    before = bend_of(mesh).curvatures
    assert bent(mesh, *before) is mesh and bent(mesh) is mesh
    nearby = bent(mesh, before[0] + 1e-5)
    there = bent(bent(mesh, before[0] + 0.7), *before)
    for changed in (nearby, there):
        np.testing.assert_allclose(changed.positions[: len(mesh.positions)], mesh.positions, atol=6e-7)


@pytest.mark.parametrize("surface", SURFACES[2:], ids=lambda surface: type(surface).__name__)
def test_a_mirror_cut_off_its_axis_keeps_its_own_rearmost_vertex(surface):
    mesh = on(surface)
    uv = np.add(mesh.parameters, (0.2, 0.15))
    mesh = replace(mesh, positions=surface.position(uv), normals=surface.normal(uv), parameters=uv)
    changed = bent(mesh, 0.1)
    exact(changed)
    assert rearmost(changed, surface.axes[2]) == pytest.approx(rearmost(mesh, surface.axes[2]), abs=1e-6)
    assert np.abs(changed.positions - mesh.positions).max() > 1e-3


def test_a_sphere_of_another_radius_is_that_sphere():
    mesh = spherical_mirror(1.4)
    changed = bent(mesh, -0.5)
    assert isinstance(changed.surface, Sphere) and changed.surface.radius == pytest.approx(2.0, rel=1e-12)
    # Concave, it faces its centre, and its middle is as deep as its corners were.
    np.testing.assert_allclose(changed.surface.center, [0.0, 0.5, 2.0 + mesh.positions[0, 2]], atol=1e-6)
    assert isinstance(bent(changed, 0.0).surface, Plane)


balls = st.one_of(st.sampled_from([0.5, 2.0, 1.0]), st.floats(0.05, 20.0))


@settings(max_examples=20)
@given(balls, st.booleans())
def test_a_ball_swells_about_its_centre_seen_from_outside_and_from_inside(factor, inside):
    ball = BALL
    if inside:
        ball = replace(ball, normals=-ball.normals, faces=np.ascontiguousarray(ball.faces[:, ::-1]))
    (own,) = bend_of(ball).curvatures
    assert own == pytest.approx((-1.0 if inside else 1.0) / 0.6)
    assert bend_of(ball).limits == pytest.approx(sorted((own / 2.0, own * 2.0)))
    changed = bent(ball, own * factor)
    assert changed.surface.center is ball.surface.center and changed.normals is ball.normals
    np.testing.assert_allclose(np.linalg.norm(changed.positions - ball.surface.center, axis=1), 0.6 / factor, rtol=1e-6)
    np.testing.assert_allclose(changed.positions, changed.surface.position(changed.parameters), atol=1e-6)
    assert bend_of(changed).curvatures == pytest.approx((own * factor,), rel=1e-12)
    with pytest.raises(AnamorphError, match=rf"it is a ball; give a {'negative' if inside else 'positive'} number"):
        bent(ball, -own)


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("flat-mirror", "mirror"),
        ("facing-mirrors", "mirror-far"),
        ("saddle", "cylinder"),
        ("curvature-series", "mirror-5"),
    ],
)
def test_a_framed_mirror_stays_seen_over_all_of_its_curvatures_and_as_it_swivels(name, part):
    scene = gallery.make(name)
    number = [mesh.name for mesh in scene.meshes].index(part)
    limits = bend_of(scene.meshes[number]).limits
    before = (drawn(scene, "raytrace", (80, 60)).specular == number + 1).sum()
    edits = [Edit(curvature=limit * share) for limit in limits for share in (0.4, 1.0)]
    for by in (*edits, Edit((5.0, 0.0, 0.0)), Edit((-5.0, 0.0, 0.0))):
        changed = list(scene.meshes)
        changed[number] = edit((changed[number],), by)[0]
        seen = (drawn(replace(scene, meshes=tuple(changed)), "raytrace", (80, 60)).specular == number + 1).sum()
        assert seen > 0.85 * before


def test_a_flat_mirror_of_two_triangles_gets_the_vertices_that_its_bending_takes():
    mesh = flat_mirror()
    changed = bent(mesh, 1.0)
    exact(changed)
    assert len(changed.faces) >= 128
    across = changed.positions[:, :2]
    assert across.min(axis=0) == pytest.approx([-0.2, 0.35]) and across.max(axis=0) == pytest.approx([0.2, 0.65])


@pytest.mark.parametrize(
    "mesh", [on(surface, flip=flip) for surface, flip in KINDS] + [spherical_mirror(0.21, half=(0.199, 0.01))]
)
def test_a_mirror_can_be_bent_as_far_as_its_limits_say(mesh):
    bend = bend_of(mesh)
    low, high = bend.limits
    assert low == -high and low <= min(bend.curvatures) and max(bend.curvatures) <= high
    for limit in bend.limits:
        exact(bent(mesh, limit, limit if len(bend.curvatures) > 1 else None))


@pytest.mark.parametrize(
    "by",
    [Edit((8.0, -5.0, 3.0), (0.02, -0.01, 0.03)), Edit(curvature=-0.4), Edit((5.0, 0.0, 0.0), curvature=1.5)],
)
def test_the_image_in_an_edited_mirror_is_still_true(by):
    scene = scene_with(*edit((spherical_mirror(count=12),), by))
    reference = drawn(scene, "raytrace")
    errors = measure(reference, drawn(scene, "pervertex"))
    assert (reference.specular == 1).sum() > 3000
    assert errors.pixels.p95 < 0.6 and errors.other_object_percent < 1.5


def test_a_flat_mirror_that_is_turned_shows_the_scene_mirrored_in_its_new_plane():
    mesh = edit((flat_mirror(),), Edit((7.0, 4.0, 0.0)))[0]
    scene = scene_with(mesh)
    frame = drawn(scene, "pervertex")
    looks = (frame.specular == 1) & (frame.object_id > 0)
    rows, columns = np.nonzero(looks)
    eye = np.asarray(scene.camera.position)
    normal, point = mesh.normals[0].astype(float), mesh.positions[0].astype(float)
    mirrored = eye - 2.0 * ((eye - point) @ normal) * normal
    seen = frame.position[looks] - mirrored
    through = mirrored + seen * (((point - mirrored) @ normal) / (seen @ normal))[:, None]
    image = scene.camera.image(through, SIZE)
    np.testing.assert_allclose(image[:, :2] / image[:, 2:], np.column_stack([columns, rows]) + 0.5, atol=0.05)


def patch() -> Mesh:
    x, y = np.meshgrid(np.arange(4.0), np.arange(4.0), indexing="ij")
    surface = BezierPatch(np.stack([x, y, 0.1 * x * y], axis=-1))
    return replace(on(surface, 0.0, 1), positions=np.eye(3, dtype=np.float32)[[0, 1, 2, 0]])


@pytest.mark.parametrize(
    ("meshes", "by", "words"),
    [
        ((patch(),), Edit(curvature=1.0), "cannot be bent"),
        ((BALL,), Edit(curvature=0.0), "it is a ball; give a positive number"),
        ((BALL,), Edit(added_curvature=1.0), "cannot be bent further"),
        (surroundings()[:1], Edit(added_curvature=1.0), "is no mirror"),
        ((replace(spherical_mirror(), surface=None),), Edit(curvature=1.0), "cannot be bent"),
        ((spherical_mirror(), replace(spherical_mirror(), name="mirror/2")), Edit(curvature=1.0), "is 2 mirrors"),
        (surroundings()[:1], Edit(curvature=1.0), "is 0 mirrors"),
        ((spherical_mirror(),), Edit(cross_curvature=1.0), "no toroid"),
        ((spherical_mirror(),), Edit(curvature=9.0), "out of reach; give a number from -3.8"),
        ((on(SURFACES[2]),), Edit(curvature=12.0), "make it flatter"),
        ((spherical_mirror(),), Edit(power=1.0), "has no power"),
        ((spherical_mirror(),), Edit(index=1.5), "has no index"),
        ((replace(spherical_mirror(), material=Glass()),), Edit(reflectance=0.5), "has no reflectance"),
        ((replace(spherical_mirror(), material=Glass()),), Edit(index=0.0), "from 0.1 to 10"),
        ((replace(spherical_mirror(), material=Glass()),), Edit(power=1.0), "has no power"),
        ((spherical_mirror(),), Edit(reflectance=1.1), "from 0 to 1"),
        ((spherical_mirror(),), Edit((np.nan, 0.0, 0.0)), "turn is .* finite"),
        ((spherical_mirror(),), Edit(move=(0.0, np.inf, 0.0)), "move is .* finite"),
        ((spherical_mirror(),), Edit(curvature=np.nan), "curvature is nan"),
    ],
)  # fmt: skip
def test_what_cannot_be_changed_so_is_one_line(meshes, by, words):
    with pytest.raises(AnamorphError, match=rf"^part '[^\n]*{words}[^\n]*$"):
        edit(meshes, by)


def test_plain_glass_and_mirrors_change_their_materials():
    glass = replace(spherical_mirror(), material=Glass(1.5, (0.9, 1.0, 0.9), 50.0))
    changed = edit((glass,), Edit(index=1.7))[0]
    assert (changed.material.index, changed.material.tint, changed.material.abbe) == (1.7, (0.9, 1.0, 0.9), 50.0)
    assert changed.positions is glass.positions
    assert edit((spherical_mirror(),), Edit(reflectance=0.25))[0].material.reflectance == 0.25
