"""Planning a map: each step of the paper against a twin written here, and what the plan promises of every mirror."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from plans import plan_of, planned
from scenes import CAMERA, CENTER, SIZE, flat_mirror, pixels_of, scene_with, spherical_mirror

from anamorph.gallery import make
from anamorph.gallery.solids import box
from anamorph.methods.pervertex import Options
from anamorph.methods.pervertex.warp import aligned, near_normal, plan_map
from anamorph.projection import map_frame
from anamorph.rays.caster import beyond
from anamorph.scene.camera import Camera
from anamorph.scene.model import Diffuse, Mirror, Scene

CURVED = scene_with(spherical_mirror())


def twin(scene, camera):
    """Steps 1 to 3 of the paper in float64: viewpoint, hits, and where the projection plane meets each line to it."""
    mesh, eye = scene.meshes[0], np.array(camera.position)
    normals = mesh.surface.normal(mesh.parameters)
    normals *= np.sign(np.sum(normals * mesh.normals, axis=1, keepdims=True))
    points = mesh.surface.position(mesh.parameters)
    incident = (points - eye) / np.linalg.norm(points - eye, axis=1, keepdims=True)
    reflected = incident - 2.0 * np.sum(incident * normals, axis=1, keepdims=True) * normals
    # 3.2: least squares over the stacked equations of the lines, each as often as there are pixels around its vertex
    x, y = pixels_of(camera, SIZE, points).T
    pixels = np.zeros(len(points))
    for a, b, c in mesh.faces:
        pixels[[a, b, c]] += abs(x[a] * (y[b] - y[c]) + x[b] * (y[c] - y[a]) + x[c] * (y[a] - y[b]))
    across = np.sqrt(pixels)[:, None, None] * (np.eye(3) - reflected[:, :, None] * reflected[:, None, :])
    right_side = np.einsum("nij,nj->ni", across, points).ravel()
    viewpoint = np.linalg.lstsq(across.reshape(-1, 3), right_side, rcond=None)[0]
    forward = pixels @ reflected
    # (3.1): nearest triangle, by Cramer's rule on all of them
    hits = np.full(points.shape, np.nan)
    best = np.full(len(points), np.inf)
    for other in scene.meshes[1:]:
        for a, b, c in np.asarray(other.positions, float)[other.faces]:
            system = np.stack([np.tile(b - a, (len(points), 1)), np.tile(c - a, (len(points), 1)), -reflected], axis=-1)
            solvable = np.abs(np.linalg.det(system)) > 1e-14
            u, v, t = np.full((3, len(points)), np.inf)
            u[solvable], v[solvable], t[solvable] = np.linalg.solve(
                system[solvable], (points - a)[solvable][..., None]
            )[..., 0].T
            found = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 1e-4) & (t < best)
            best[found] = t[found]
            hits[found] = (points + t[:, None] * reflected)[found]
    return points, reflected, viewpoint, forward / np.linalg.norm(forward), hits


def test_the_plan_is_the_papers_steps_in_double_precision():
    body_rays, plan = plan_of(CURVED)
    rays = body_rays.rays
    points, reflected, viewpoint, forward, hits = twin(CURVED, CAMERA)
    assert rays.origins == pytest.approx(points, abs=1e-12)
    assert rays.unit_directions() == pytest.approx(reflected, abs=1e-12)

    seen = np.isfinite(hits[:, 0])
    assert np.isfinite(plan.distances).tolist() == seen.tolist()
    assert plan.hits[seen] == pytest.approx(hits[seen], abs=2e-5)

    projection = plan.projections[0]
    # (3.2) and (3.3): the projection plane of the plan, and the line from the twin's viewpoint to the hit.
    axes = np.stack([projection.right, projection.up])
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    assert np.cross(*axes) == pytest.approx(-forward, abs=1e-9)
    lines = plan.hits - viewpoint
    crossing = viewpoint + (((projection.eye - viewpoint) @ forward) / (lines @ forward))[:, None] * lines
    places = (crossing - projection.eye) @ axes.T

    # (3.4): local coordinates of the image, whose rectangle the map's own base, right and up span.
    distance = (projection.eye - viewpoint) @ forward
    middle = (viewpoint + distance * projection.base - projection.eye) @ axes.T
    half = distance * np.array([np.linalg.norm(projection.right), np.linalg.norm(projection.up)])
    expected = 0.5 + 0.5 * (places - middle) / half * [1.0, -1.0]
    assert plan.lookups[0, :, 3].all()
    assert plan.lookups[0, :, :2] / plan.lookups[0, :, 2:3] == pytest.approx(expected, abs=1e-7)
    assert (plan.lookups[0, :, :2] / plan.lookups[0, :, 2:3] >= 0.0).all()
    assert (plan.lookups[0, :, :2] / plan.lookups[0, :, 2:3] <= 1.0).all()


def test_the_view_volume_is_no_larger_than_the_hits_need():
    _, plan = plan_of(CURVED)
    places = plan.lookups[0, :, :2] / plan.lookups[0, :, 2:3]
    assert places.min(axis=0) == pytest.approx([0.0, 0.0], abs=0.02)
    assert places.max(axis=0) == pytest.approx([1.0, 1.0], abs=0.02)


def test_normals_that_cancel_out_leave_the_near_plane_across_the_view():
    """A corridor of mirrors: its rays agree, its normals do not."""
    frame = map_frame(np.array([0.0, 0.0, 1.0, 1.0]), np.zeros(3), np.diag([1.0, 1.0, -1.0]))
    normals, directions = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]), np.array([[0.0, 0.0, -1.0]] * 2)
    assert near_normal(np.array([0.5, 0.5]), normals, directions, frame).tolist() == [0.0, 0.0, -1.0]


def test_the_maps_resolution_follows_the_pixels_that_it_fills():
    sizes = {}
    for size in [(80, 60), (160, 120), (640, 480)]:
        _, plan = plan_of(CURVED, size=size)
        sizes[size] = np.array(plan.texels[0])
    assert sizes[160, 120] == pytest.approx(2.0 * sizes[80, 60], rel=0.02)
    assert sizes[640, 480] == pytest.approx(4.0 * sizes[160, 120], rel=0.02)
    # A flat mirror's map is the mirror's own image: about as many texels as pixels.
    flat = scene_with(flat_mirror(), camera=Camera((0, 0.5, 0.9), (0, 0.5, 0), field_of_view=32.0))
    _, plan = plan_of(flat)
    corners = pixels_of(flat.camera, SIZE, flat_mirror().positions)
    assert np.array(plan.texels[0]) == pytest.approx(np.ptp(corners, axis=0), rel=0.05)


def in_map(projection, points):
    """Depths (N,), places (N, 2) from 0 to 1 with y down, and clip w (N,), of points in a map."""
    x, y, z, w = (np.column_stack([points, np.ones(len(points))]) @ projection.clip.T).T
    with np.errstate(divide="ignore", invalid="ignore"):
        return z / w, np.stack([0.5 + 0.5 * x / w, 0.5 - 0.5 * y / w], axis=-1), w


def places_of(plan, number=0):
    return plan.lookups[number, :, :2] / plan.lookups[number, :, 2:3]


def concave(radius=-0.5, camera=CAMERA):
    """A concave mirror whose reflected rays cross among the boxes before it."""
    return scene_with(spherical_mirror(radius), camera=camera)


CONCAVE = st.tuples(
    st.sampled_from([-0.35, -0.5, -0.8, -1.4]),
    st.tuples(st.floats(-0.5, 0.5), st.floats(0.3, 1.0), st.floats(0.7, 3.0)),
)


@settings(max_examples=30)
@given(CONCAVE)
def test_hits_before_and_beyond_the_crossing_look_up_their_places_in_their_own_view(drawn):
    radius, position = drawn
    camera = Camera(position, tuple(CENTER.tolist()), field_of_view=32.0)
    scene = concave(radius, camera)
    found = planned(scene)
    for plan in found.plans:
        if plan is None or len(plan.projections) < 2:
            continue
        beyond, before = (in_map(projection, plan.hits) for projection in plan.projections)
        assert ((beyond[2] > 0.0) == (before[2] < 0.0)).all(), "each hit is in one part alone"
        # Near the crossing the scatter of the rays is larger than their fan: then places are kept at its border.
        looked_up = places_of(plan)
        inner = (looked_up > 0.01).all(axis=1) & (looked_up < 0.99).all(axis=1) & (plan.lookups[0, :, 3] > 0.0)
        for depth, places, w in (beyond, before):
            shown = inner & (w > 0.0)
            assert looked_up[shown] == pytest.approx(places[shown], abs=1e-9)
            seen = shown & np.isfinite(plan.distances) & (np.abs(w) > 0.01)
            assert (depth[seen] <= 1.0 + 1e-9).all() and (depth[seen] >= 0.0).all()


def test_a_concave_mirror_has_a_map_for_either_side_of_its_crossing():
    _, plan = plan_of(concave())
    beyond, before = plan.projections
    sides = np.sign(in_map(beyond, plan.hits)[2])
    assert (sides > 0.0).sum() > 20 and plan.lookups[0, :, 3].all()
    viewpoint = plan.viewpoint[:3] / plan.viewpoint[3]
    assert 0.1 < viewpoint[2] < 0.5, "before the mirror, near its focus"
    # What stands between mirror and crossing is seen in the second alone, and what stands behind that in the first.
    for point, shown in (([-0.11, 0.3, 0.28], before), ([-0.2, 0.3, 2.6], beyond)):
        for projection in plan.projections:
            assert (in_map(projection, np.array([point]))[2][0] > 0.0) == (projection is shown)


def before_the_crossing_depth_rises_towards_the_mirror(scene):
    for plan in planned(scene).plans:
        if plan is None or len(plan.projections) < 2:
            continue
        before, crossing = plan.projections[1], plan.viewpoint[:3] / plan.viewpoint[3]
        for x, y in [(-1.0, -1.0), (0.0, 0.0), (0.9, -0.7)]:
            look = before.base + x * before.right + y * before.up
            depth, places, w = in_map(before, crossing - np.linspace(0.01, 1.0, 50)[:, None] * look)
            assert (w > 0.0).all()
            assert places == pytest.approx(np.tile([0.5 + 0.5 * x, 0.5 - 0.5 * y], (50, 1)), abs=1e-6)
            assert (np.diff(depth) > 0.0).all()


@settings(max_examples=60)
@given(
    st.sampled_from([-0.25, -0.35, -0.5, -0.8]),
    st.tuples(st.floats(-0.6, 0.6), st.floats(0.2, 1.0), st.floats(0.2, 3.0)),
)
@example(-0.25, (0.5220869085453218, 0.8526828432972258, 0.207667800476415))
def test_before_its_crossing_what_is_nearer_to_a_concave_mirror_is_in_front(radius, position):
    """Also where the crossing lies within the bowl, lower than its foremost vertex, which hides others."""
    camera = Camera(position, tuple(CENTER.tolist()), field_of_view=32.0)
    before_the_crossing_depth_rises_towards_the_mirror(concave(radius, camera))


@pytest.mark.parametrize("position", [(0.265786, 0.620283, 0.324037), (0.466188, 0.705193, 0.369237)])
@pytest.mark.parametrize("radius", [-0.205, -0.25])
def test_a_bowls_crossing_lies_before_its_near_plane_whatever_stands_behind_it(radius, position):
    bowl = spherical_mirror(radius, 8, (0.2, 0.2))
    shell = replace(bowl, positions=bowl.positions - np.float32([0.0, 0.0, 0.01]), material=Diffuse())
    shell = replace(shell, name="shell", surface=None, parameters=None)
    camera = Camera(position, tuple(CENTER.tolist()), field_of_view=32.0)
    before_the_crossing_depth_rises_towards_the_mirror(scene_with(bowl, shell, camera=camera))


def test_hits_at_the_crossing_do_not_spread_the_map():
    """There the scatter of the rays is larger than their fan: a hit says nothing of its place, and none is lost."""
    mirror = spherical_mirror(-0.8)
    _, plan = plan_of(scene_with(mirror))
    crossing = plan.viewpoint[:3] / plan.viewpoint[3]
    block = box(tuple(crossing - 0.01), tuple(crossing + 0.01)).mesh("block", Diffuse())
    _, blocked = plan_of(scene_with(mirror, block))
    near = np.linalg.norm(blocked.hits - crossing, axis=1) < 0.03
    assert near.sum() > 3
    assert blocked.lookups[0, near, 3].all()
    assert (places_of(blocked) >= 0.0).all() and (places_of(blocked) <= 1.0).all()
    areas = [np.linalg.norm(np.cross(each.projections[0].right, each.projections[0].up)) for each in (plan, blocked)]
    assert areas[1] < 16.0 * areas[0]


def test_nothing_before_the_crossing_needs_no_second_map():
    scene = concave()
    empty = Scene("far", (scene.meshes[0], scene.meshes[3]), CAMERA)
    _, plan = plan_of(empty)
    assert len(plan.projections) == 1
    viewpoint = plan.viewpoint[:3] / plan.viewpoint[3]
    beyond = viewpoint + 2.0 * (viewpoint - CENTER)
    assert in_map(plan.projections[0], beyond[None])[2] > 0.0


@settings(max_examples=40)
@given(st.sampled_from([-0.35, -0.5, -1.4, 0.5, 1.4, 1e3, -1e3]), st.floats(-0.6, 0.6), st.floats(0.5, 3.0))
def test_a_maps_eye_looks_where_the_map_does(radius, aside, distance):
    """The lines of body_rays of the eye that sees other mirrors in a map are those of the map's own pixels."""
    camera = Camera((aside, 0.6, distance), tuple(CENTER.tolist()), field_of_view=32.0)
    plans = planned(scene_with(spherical_mirror(radius), camera=camera)).plans
    size = (300, 200)
    maps = [(each, plan.eye(i, size)) for plan in plans if plan for i, each in enumerate(plan.projections)]
    points = np.random.default_rng(1).uniform((-2, 0, 0), (2, 1, 3), (200, 3))
    for projection, eye in maps:
        _, places, w = in_map(projection, points)
        inside = (w > 1e-3) & (np.abs(places - 0.5) < 0.5).all(axis=1)
        x, y, depth = eye.image(points[inside]).T
        assert np.stack([x / depth, y / depth], axis=-1) == pytest.approx(places[inside] * size, abs=1e-6)
        across, up = 2.0 * places[inside, :1] - 1.0, 1.0 - 2.0 * places[inside, 1:]
        looks = projection.base + across * projection.right + up * projection.up
        looks /= np.linalg.norm(looks, axis=1, keepdims=True)
        offsets = eye.offsets(points[inside])
        offsets /= np.linalg.norm(offsets, axis=1, keepdims=True)
        assert offsets == pytest.approx(looks, abs=1e-6)


def slopes_of(axes, directions):
    return directions @ axes[:2].T / (directions @ axes[2])[:, None]


@st.composite
def bundles(draw):
    """Rays around an axis, `longer` times as wide along a principal direction of their slopes as across it."""
    generator = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    longer, turn = draw(st.sampled_from([1.0, 1.5, 4.0, 50.0])), draw(st.floats(0.0, np.pi))
    axes = np.linalg.qr(generator.normal(size=(3, 3)))[0]
    axes[2] = np.cross(axes[0], axes[1])
    # A rectangle full of rays.
    x, y = np.meshgrid(np.linspace(-1.0, 1.0, 9), np.linspace(-1.0, 1.0, 9))
    local = 0.3 * np.stack([x.ravel(), y.ravel() / longer], axis=-1)
    cosine, sine = np.cos(turn), np.sin(turn)
    slopes = local @ np.array([[cosine, sine], [-sine, cosine]]) + 0.2 * generator.uniform(-1, 1, 2)
    directions = axes[2] + slopes @ axes[:2]
    return axes, directions / np.linalg.norm(directions, axis=1, keepdims=True), longer


@given(bundles())
def test_maps_are_turned_along_their_rays_by_at_most_45_degrees(drawn):
    axes, directions, longer = drawn
    weights = np.full(len(directions), 1.0 / len(directions))
    turned = aligned(axes, directions, weights)
    assert turned @ turned.T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(turned) == pytest.approx(np.linalg.det(axes))
    assert turned[2].tolist() == axes[2].tolist()
    assert turned[0] @ axes[0] >= np.cos(np.radians(45.0)) - 1e-9
    extents = np.ptp(slopes_of(turned, directions), axis=0)
    if longer == 1.0:
        assert turned.tolist() == axes.tolist(), "what is as long as wide is left alone"
    else:
        assert extents.prod() <= 1.001 * 0.36 / longer, "no room is left beside the rectangle of rays"
    assert extents.prod() <= np.ptp(slopes_of(axes, directions), axis=0).prod() + 1e-12


def test_only_rays_that_count_turn_a_map():
    axes = np.eye(3)
    x, y = np.meshgrid(np.linspace(-0.3, 0.3, 7), np.linspace(-0.1, 0.1, 7))
    diagonal = np.stack([x - y, x + y, np.ones_like(x)], axis=-1).reshape(-1, 3) / np.sqrt(2.0)
    stray = np.array([[9.0, 0.0, 1.0], [0.5, -0.5, -1.0]])
    directions = np.concatenate([diagonal, stray])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    weights = np.append(np.full(len(diagonal), 1.0 / len(diagonal)), [0.0, 0.0])
    turned = aligned(axes, directions, weights)
    assert np.abs(turned[0] @ axes[0]) == pytest.approx(np.sqrt(0.5), abs=1e-6)


def test_rays_on_the_diagonal_turn_a_map_one_way_whatever_the_last_digit():
    x, y = np.meshgrid(np.linspace(-0.3, 0.3, 7), np.linspace(-0.1, 0.1, 7))
    directions = np.stack([x - y, x + y, np.full_like(x, np.sqrt(2.0))], axis=-1).reshape(-1, 3)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    weights = np.full(len(directions), 1.0 / len(directions))
    for last_digit in 1e-15 * np.random.default_rng(1).normal(size=(40, *directions.shape)):
        turned = aligned(np.eye(3), directions + last_digit, weights)
        assert turned[0] == pytest.approx(np.sqrt([0.5, 0.5, 0.0]), abs=1e-9)


def test_a_map_is_turned_only_where_that_saves_room():
    """Two triangles' vertices do not weigh alike: their principal direction lies along the diagonal."""
    flat = scene_with(flat_mirror(), camera=Camera((0, 0.5, 0.9), (0, 0.5, 0), field_of_view=32.0))
    texels = [np.prod(plan_of(flat, options=Options(align=align))[1].texels[0]) for align in (False, True)]
    assert texels[1] == pytest.approx(texels[0])
    saddle = make("saddle")
    turned, straight = (
        [plan.used for plan in planned(saddle, options=Options(align=align)).plans] for align in (True, False)
    )
    assert all(one >= other - 1e-9 for one, other in zip(turned, straight, strict=True))
    assert max(np.subtract(turned, straight)) > 0.1


def rim(thickness=0.03):
    """A bar over the mirror's left border, that reaches behind it."""
    return box((-0.25, 0.3, -0.03), (-0.17, 0.7, thickness)).mesh("rim", Diffuse(color=(0.1, 0.1, 0.1)))


def near_plane_distance(plan):
    """How far before the mirror's middle the map begins to see, by its depth, along the mirror's own axis."""
    heights = np.linspace(-0.1, 0.3, 4001)
    points = CENTER + heights[:, None] * [0.0, 0.0, 1.0]
    depth, _, w = in_map(plan.projections[0], points)
    return heights[(depth <= 1.0) & (w > 0.0)].min()


def test_the_map_begins_before_what_frames_the_mirror():
    plain, framed = (plan_of(scene_with(spherical_mirror(), *extra))[1] for extra in ((), (rim(),)))
    assert near_plane_distance(plain) < 0.005
    assert 0.01 < near_plane_distance(framed) <= 0.06


def cast_on(found, origins, directions):
    """What rays hit that leave a surface at their origins."""
    return found.surroundings.caster.cast(origins, directions, beyond(origins, directions))


def test_rays_of_hidden_vertices_pass_what_frames_the_mirror():
    scene = scene_with(spherical_mirror(), rim())
    found = planned(scene)
    number = 2
    hidden = found.occluder == number
    assert hidden.sum() >= 5
    (plan,) = found.plans
    met = cast_on(found, found.body_rays.rays.origins, found.body_rays.rays.unit_directions())
    ends_at_rim = hidden & (found.surroundings.face_object[met.triangle] == number)
    assert ends_at_rim.any(), "else the rim would not be in their way"
    inside = (plan.hits > [-0.26, 0.29, -0.04]).all(axis=1) & (plan.hits < [-0.16, 0.71, 0.04]).all(axis=1)
    assert not inside[ends_at_rim].any()
    assert plan.lookups[0, ends_at_rim, 3].all()


def test_what_stands_free_before_a_mirror_is_seen_in_it():
    bar = box((-0.27, 0.3, 0.05), (-0.15, 0.7, 0.07)).mesh("bar", Diffuse())
    scene = scene_with(spherical_mirror(), bar)
    found = planned(scene)
    number = 2
    assert (found.occluder == number).any(), "it hides vertices"
    (plan,) = found.plans
    assert near_plane_distance(plan) < 0.005, "and frames nothing"
    cast = cast_on(found, found.body_rays.rays.origins, found.body_rays.rays.unit_directions())
    meets = found.surroundings.face_object[cast.triangle] == number
    meets &= cast.triangle >= 0
    assert meets.any()
    assert plan.distances[meets] == pytest.approx(cast.distance[meets], abs=1e-5)


def test_plain_coordinates_have_no_depth():
    _, plan = plan_of(CURVED, options=Options(projective=False))
    assert (plan.lookups[..., 2] == 1.0).all()
    _, projective = plan_of(CURVED)
    assert np.ptp(projective.lookups[..., 2]) > 0.1
    assert places_of(plan) == pytest.approx(places_of(projective), abs=1e-12)


def test_a_mirror_that_turns_its_back_has_no_plan():
    camera = Camera((0.25, 0.65, -0.9), (0.0, 0.5, 0.0), field_of_view=32.0)
    found = planned(scene_with(spherical_mirror()), camera)
    assert not len(found.patches)
    every, occluder = np.arange(len(found.body_rays.rays.faces)), np.zeros(len(found.body_rays.rays.origins), int)
    assert plan_map(found.body_rays, every, occluder, found.surroundings, Options()) is None


def test_rays_to_all_sides_alike_have_no_plan():
    """In the middle of a cube of mirrors all six walls together have no mean direction, and each alone has one."""
    shape = box((-2.0, -2.0, -2.0), (2.0, 2.0, 2.0))
    room = replace(shape, normals=-shape.normals, faces=shape.faces[:, ::-1]).mesh("mirror", Mirror())
    found = planned(scene_with(room), Camera((0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    every, occluder = np.arange(len(room.faces)), np.zeros(len(room.positions), int)
    random = np.random.default_rng(1)
    for _ in range(20):
        last_digit = 1e-15 * random.normal(size=found.body_rays.rays.directions.shape)
        rays = replace(found.body_rays.rays, directions=found.body_rays.rays.directions + last_digit)
        assert plan_map(replace(found.body_rays, rays=rays), every, occluder, found.surroundings, Options()) is None
    assert len(found.plans) >= 2 and all(plan is not None for plan in found.plans)
