"""Curvature added to patches and CAD surfaces: the bent mirror is a NURBS surface again, exact to rounding."""

from __future__ import annotations

from dataclasses import replace

import door_mirror
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import CENTER, drawn, scene_with

from anamorph import gallery
from anamorph.base.errors import AnamorphError
from anamorph.editing.arching import arch_of, arched, arched_surface
from anamorph.editing.edit import Edit, edit
from anamorph.gallery.solids import lattice
from anamorph.gallery.torus import torus_surface
from anamorph.measure.compare import measure
from anamorph.scene.model import Diffuse, Mesh, Mirror
from anamorph.scene.pose import Pose
from anamorph.surfaces.bezier import BezierPatch
from anamorph.surfaces.intersection import intersect
from anamorph.surfaces.nurbs import NurbsSurface
from anamorph.viewer.controls import edited, reading, scene_controls

AXES = np.array([[0.8, 0.0, -0.6], [0.36, 0.8, 0.48], [0.48, -0.6, 0.64]])
PLACE = np.array([0.3, 1.2, -0.5])


def glass() -> NurbsSurface:
    """The aspheric door mirror: degree 5, and a knot with two derivatives fewer."""
    poles, knots_x, knots_y = door_mirror.spline()
    return NurbsSurface(poles @ AXES + PLACE, np.ones(poles.shape[:2]), knots_x, knots_y, 5, 5)


def patch(scale: float = 0.1) -> BezierPatch:
    generator = np.random.default_rng(5)
    x, y = np.meshgrid(np.linspace(-1.0, 1.0, 4), np.linspace(-1.0, 1.0, 4), indexing="ij")
    return BezierPatch(scale * np.stack([x, y, generator.uniform(-0.2, 0.2, (4, 4))], axis=-1) @ AXES + PLACE)


def flat() -> NurbsSurface:
    corners = np.array([[[-0.1, -0.08, 0.0], [-0.1, 0.08, 0.0]], [[0.1, -0.08, 0.0], [0.1, 0.08, 0.0]]])
    knots = np.array([0.0, 0.0, 1.0, 1.0])
    return NurbsSurface(corners @ AXES + PLACE, np.full((2, 2), 3.0), knots, knots, 1, 1)


SURFACES = {
    "door mirror": (glass(), (-0.095, -0.065), (0.095, 0.065)),
    "Bezier": (patch(), (0.0, 0.0), (1.0, 1.0)),
    "torus": (torus_surface(tuple(PLACE), AXES, 0.55, 0.19), (0.6, 0.1), (1.7, 0.9)),
    "flat": (flat(), (0.0, 0.0), (1.0, 1.0)),
}
curvatures = st.one_of(st.sampled_from([1e-9, -1e-9, 0.3, -0.3, 50.0]), st.floats(-5.0, 5.0))


def mesh_on(surface, low, high, count: int = 12, name: str = "mirror", flip: bool = False) -> Mesh:
    lines = (np.linspace(first, last, count + 1) for first, last in zip(low, high, strict=True))
    uv = np.stack([each.ravel() for each in np.meshgrid(*lines)], axis=-1)
    faces, sign = lattice(count + 1, count + 1), -1.0 if flip else 1.0
    return Mesh(
        name, surface.position(uv).astype(np.float32), (faces[:, ::-1] if flip else faces).astype(np.int32),
        (sign * surface.normal(uv)).astype(np.float32), Mirror(), surface=surface, parameters=uv,
    )  # fmt: skip


def inside(low, high, count: int = 60) -> np.ndarray:
    uv = np.random.default_rng(1).uniform(low, high, (count, 2))
    return np.concatenate([uv, [low, high, (low[0], high[1])]])


@settings(max_examples=40)
@given(st.sampled_from(sorted(SURFACES)), curvatures)
def test_a_paraboloid_is_added_exactly(name, curvature):
    surface, low, high = SURFACES[name]
    frame = Pose(np.add(PLACE, (0.01, -0.02, 0.015)), AXES[[1, 2, 0]])
    changed = arched_surface(surface, frame, curvature)
    uv = inside(low, high)
    x, y, z = ((surface.position(uv) - frame.center) @ frame.axes.T).T
    wanted = frame.center + np.column_stack([x, y, z - curvature * (x**2 + y**2) / 2.0]) @ frame.axes
    np.testing.assert_allclose(changed.position(uv), wanted, rtol=0.0, atol=2e-14 * (1.0 + abs(curvature)))
    # Tangents go along: (dx, dy, dz - c (x dx + y dy)).
    if isinstance(surface, NurbsSurface):
        for orders in ((1, 0), (0, 1)):
            dx, dy, dz = (surface.derivative(uv, *orders) @ frame.axes.T).T
            tangent = np.column_stack([dx, dy, dz - curvature * (x * dx + y * dy)]) @ frame.axes
            # A derivative magnifies the rounding of the poles by the degree over the least distance of knots.
            knots, degree = ((changed.knots_v, changed.degree_v), (changed.knots_u, changed.degree_u))[orders[0]]
            within = 1e-14 * degree / np.diff(np.unique(knots)).min() * max(1.0, np.abs(tangent).max())
            np.testing.assert_allclose(changed.derivative(uv, *orders), tangent, rtol=0.0, atol=within)
        # A face whose outside is the other side keeps it.
        other = arched_surface(replace(surface, sign=-1.0), frame, curvature)
        np.testing.assert_array_equal(other.normal(uv), -changed.normal(uv))


@settings(max_examples=25)
@given(st.sampled_from(sorted(SURFACES)), st.floats(-1.0, 1.0), st.booleans())
def test_a_mirror_keeps_its_outline_and_its_rearmost_vertex_and_its_surface_stays_exact(name, share, flip):
    mesh = mesh_on(*SURFACES[name], flip=flip)
    arch = arch_of((mesh,))
    curvature = share * arch.limit
    (changed,) = arched((mesh,), curvature)
    assert changed is mesh or share
    np.testing.assert_allclose(changed.surface.position(changed.parameters), changed.positions, atol=2e-7)
    right, up, outward = arch.pose.axes
    for axis in (right, up):
        np.testing.assert_allclose((changed.positions - mesh.positions.astype(float)) @ axis, 0.0, atol=3e-7)
    heights = [each.positions.astype(float) @ outward for each in (mesh, changed)]
    assert heights[0].min() == pytest.approx(heights[1].min(), abs=3e-7)
    # Normals against finite differences of the position, to the side that the mirror faces.
    uv, step = changed.parameters, 1e-5 * (np.subtract(SURFACES[name][2], SURFACES[name][1]))
    tangents = [
        changed.surface.position(uv + step * side) - changed.surface.position(uv - step * side) for side in np.eye(2)
    ]
    normal = np.cross(*tangents) * (-1.0 if flip else 1.0)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    np.testing.assert_allclose(changed.normals, normal, atol=3e-6)
    assert (normal @ outward > 0.0).all()


def test_curvature_is_added_to_the_curvature_in_the_middle():
    door, plane = glass(), flat()
    for surface, middle, own in ((door, [[0.0, 0.0]], 1.0 / door_mirror.RADIUS), (plane, [[0.5, 0.5]], 0.0)):
        frame = Pose(surface.position(np.array(middle))[0], AXES)
        changed = arched_surface(surface, frame, 0.25)
        # To what the spline follows the door mirror's formula.
        np.testing.assert_allclose(changed.curvatures(np.array(middle)), own + 0.25, rtol=1e-4)


def test_a_flat_patch_becomes_the_paraboloid_that_rays_meet_where_algebra_says():
    frame = Pose(PLACE, AXES)
    changed = arched_surface(flat(), frame, 0.8)
    assert (changed.degree_u, changed.degree_v) == (2, 2) and not np.ptp(changed.weights)
    uv = inside((0.1, 0.1), (0.9, 0.9))
    x, y = ((flat().position(uv) - PLACE) @ AXES[:2].T).T
    direction = np.array([0.1, -0.2, -1.0]) / np.linalg.norm([0.1, -0.2, -1.0])
    through = np.column_stack([x, y, -0.4 * (x**2 + y**2)])
    origins = through - 0.7 * direction
    met, normals, ok = intersect(
        changed, origins @ AXES + PLACE, np.broadcast_to(direction @ AXES, (len(x), 3)), uv + 0.01
    )
    assert ok.all()
    np.testing.assert_allclose(met, through @ AXES + PLACE, atol=1e-12)
    slope = np.column_stack([0.8 * x, 0.8 * y, np.ones_like(x)])
    np.testing.assert_allclose(normals, slope / np.linalg.norm(slope, axis=1, keepdims=True) @ AXES, atol=1e-11)


def test_faces_of_one_mirror_are_bent_together_and_stay_joined():
    surface = glass()
    halves = (mesh_on(surface, (-0.095, -0.065), (0.02, 0.065), name="mirror/outer"),
              mesh_on(surface, (0.02, -0.065), (0.095, 0.065), name="mirror/inner"))  # fmt: skip
    outer, inner = edit(halves, Edit(added_curvature=0.6))
    np.testing.assert_array_equal(outer.positions[12::13], inner.positions[::13])
    assert np.abs(outer.positions - halves[0].positions).max() > 1e-3
    whole = arched((mesh_on(surface, (-0.095, -0.065), (0.095, 0.065)),), 0.6)[0]
    corner = (outer.positions[0], whole.positions[0])
    np.testing.assert_allclose(*corner, atol=3e-4)


def test_a_face_of_few_triangles_gets_the_vertices_that_its_bending_takes():
    mesh = mesh_on(flat(), (0.0, 0.0), (1.0, 1.0), count=1)
    (changed,) = arched((mesh,), 2.0)
    assert len(changed.faces) >= 128
    np.testing.assert_allclose(changed.surface.position(changed.parameters), changed.positions, atol=2e-7)


def test_the_control_adds_curvature_and_says_so():
    scene = scene_with(mesh_on(*SURFACES["door mirror"]))
    (control,) = (each for each in scene_controls(scene) if each.key == "mirror/added_curvature")
    assert (control.label, control.unit, control.default) == ("added curvature", "1/m", 0.0)
    assert control.low == -control.high and 3.0 < control.high < 5.0
    told = [reading(control, value) for value in (0.0, 0.5, -0.5)]
    assert told == ["as it was", "more convex", "more concave"]
    assert edited(scene, {control.key: 0.0}) is scene
    by_hand = arched((scene.meshes[0],), 0.5)[0].positions
    np.testing.assert_array_equal(edited(scene, {control.key: 0.5}).meshes[0].positions, by_hand)


@pytest.mark.parametrize("name", ["torus", "room", "spheres", "car-mirror"])
def test_what_looks_all_ways_or_has_a_curvature_of_its_own_gets_no_such_control(name):
    scene = gallery.make(name)
    assert not [control.key for control in scene_controls(scene) if "added" in control.key]
    mirrors = tuple(mesh for mesh in scene.meshes if isinstance(mesh.material, Mirror))
    with pytest.raises(AnamorphError, match=r"^part '[^\n]*cannot be bent further; give a mirror of patches[^\n]*$"):
        arched(mirrors, 0.1)


def test_a_torn_surface_is_one_line():
    knots = np.array([0.0, 0.0, 1.0, 1.0, 2.0, 2.0])
    poles = np.stack(np.meshgrid(np.arange(4.0), np.arange(4.0), [0.0], indexing="ij"), axis=-1)[:, :, 0]
    torn = NurbsSurface(poles, np.ones((4, 4)), knots, knots, 1, 1)
    mesh = mesh_on(torn, (0.0, 0.0), (2.0, 2.0))
    with pytest.raises(AnamorphError, match=r"^[^\n]*torn along a knot[^\n]*$"):
        arched((mesh,), 0.1)
    assert arch_of((replace(mesh, material=Diffuse()),)) is None and arch_of(()) is None


def test_the_image_in_a_cad_mirror_that_is_bent_further_is_still_true():
    poles, knots_x, knots_y = door_mirror.spline()
    surface = NurbsSurface(2.0 * poles + CENTER, np.ones(poles.shape[:2]), knots_x, knots_y, 5, 5)
    mesh = mesh_on(surface, (-0.095, -0.065), (0.095, 0.065), count=14)
    scene = scene_with(*edit((mesh,), Edit((4.0, 0.0, 0.0), added_curvature=-0.9)))
    reference = drawn(scene, "raytrace")
    errors = measure(reference, drawn(scene, "pervertex:tolerance=0.5"))
    assert (reference.specular == 1).sum() > 3000
    assert errors.pixels.p95 < 0.6 and errors.other_object_percent < 1.5
