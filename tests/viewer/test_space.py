"""What the viewer draws into space: where wires, hits, viewpoints and view volumes stand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import CAMERA, CENTER, SIZE, flat_mirror, scene_with, sky_scene, spherical_mirror

from anamorph import gallery
from anamorph.base.steps import drain
from anamorph.gallery.flat_mirror import plane_mirror
from anamorph.gallery.solids import box
from anamorph.methods import Specification
from anamorph.methods.pervertex import Options, seen_bodies
from anamorph.methods.tracing import PathTracer
from anamorph.methods.tracing.launch import GivenRays
from anamorph.raymesh import RayStatus
from anamorph.reflections.reflection_points import ReflectionStatus
from anamorph.scene.camera import Camera
from anamorph.scene.model import Diffuse, Glass, Mirror, Scene
from anamorph.viewer.facts import Inspection, Reflection, Reflections, Stop
from anamorph.viewer.marks import NO_MARKS, dot_marks, joined, line_marks
from anamorph.viewer.space import (
    MOST_HITS,
    MOST_RAYS,
    PreparedScene,
    eye_marks,
    frustum,
    hit_marks,
    path_marks,
    space_marks,
    viewpoint_marks,
    viewpoint_of,
    wireframe_marks,
)
from anamorph.viewer.state import Drawing, Half, State
from anamorph.viewer.wireframe import wireframe_of

OPTIONS = Options()
ASIDE = Camera((1.5, 1.8, 2.5), (0.0, 0.5, 0.0))


def seen_in(scene: Scene, camera: Camera | None = None, options: Options = OPTIONS):
    space = PreparedScene(scene)
    return space, seen_bodies(space.bodies, space.surroundings, camera or scene.camera, SIZE, options)


def state_of(scene: Scene, *drawings: Drawing, method: str = "pervertex", observer: Camera | None = None) -> State:
    return State(
        scene.camera,
        Half(Specification.parse(method)),
        Half(Specification.parse("raytrace")),
        drawings=frozenset(drawings),
        observer=observer,
    )


def finite(marks) -> bool:
    arrays = (*vars(marks.segments).values(), *vars(marks.dots).values())
    return all(np.isfinite(array).all() and array.dtype == np.float32 for array in arrays)


def test_marks_join_in_their_order_and_nothing_is_some():
    red, blue = (1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 0.5)
    lines = line_marks([[[0, 0, 0], [1, 0, 0]]], red, 2.0)
    both = joined([lines, dot_marks([[0, 1, 0], [0, 2, 0]], blue, 3.0), line_marks([[[0, 0, 0], [0, 0, 1]]], blue)])
    assert both.segments.ends[:, 1].tolist() == [[1, 0, 0], [0, 0, 1]]
    assert both.segments.colors.tolist() == [list(red), list(blue)] and both.segments.widths.tolist() == [2.0, 1.0]
    assert both.dots.ends[:, 0].tolist() == [[0, 1, 0], [0, 2, 0]] and (0.5 * both.dots.widths).tolist() == [3.0, 3.0]
    assert len(joined([]).segments.ends) == len(NO_MARKS.dots.ends[:, 0]) == 0


def test_a_flat_mirrors_viewpoint_is_the_eyes_mirror_image():
    space, (seen,) = seen_in(scene_with(flat_mirror()))
    (plan,) = seen.plans
    image = np.array(CAMERA.position) * [1.0, 1.0, -1.0]
    assert viewpoint_of(plan, space.surroundings.diagonal) == pytest.approx(image, abs=1e-6)
    marks = viewpoint_marks(seen, space.surroundings.diagonal)
    assert marks.dots.ends[:, 0] == pytest.approx(image[None], abs=1e-6)
    # Every line runs from its vertex through the viewpoint, and a little further.
    starts, ends = np.moveaxis(marks.segments.ends.astype(float), 1, 0)
    assert ends == pytest.approx(starts + 1.1 * (image - starts), abs=1e-5)


def test_a_hits_mirror_image_stands_behind_its_crossing_of_wires():
    scene = scene_with(flat_mirror())
    _, (seen,) = seen_in(scene)
    met = np.isfinite(seen.distances)
    assert met.sum() >= 2
    images = seen.hits[met] * [1.0, 1.0, -1.0]
    corners = seen.body_rays.side.optics.positions[met]
    shown, crossing = (CAMERA.image(points, SIZE) for points in (images, corners))
    assert shown[:, :2] / shown[:, 2:] == pytest.approx(crossing[:, :2] / crossing[:, 2:], abs=1e-3)
    # And each stands on something: on the floor, or on a side of a box.
    lows = np.array([mesh.positions.min(axis=0) for mesh in scene.meshes[1:]])
    highs = np.array([mesh.positions.max(axis=0) for mesh in scene.meshes[1:]])
    inside = ((seen.hits[met][:, None] > lows - 1e-4) & (seen.hits[met][:, None] < highs + 1e-4)).all(axis=2)
    assert inside.any(axis=1).all()


@pytest.mark.parametrize("radius", [1.4, -1.4])
@pytest.mark.parametrize("distance", [0.4, 1.0])
def test_a_small_spherical_mirrors_viewpoint_is_the_paraxial_image(radius, distance):
    eye = Camera(np.add(CENTER, (0.0, 0.0, distance)).tolist(), CENTER.tolist(), field_of_view=4.0)
    space, (seen,) = seen_in(scene_with(spherical_mirror(radius, 4, (0.005, 0.005)), camera=eye))
    (plan,) = seen.plans
    # 1 / image = 1 / distance + 2 / radius, behind the mirror.
    image = 1.0 / (1.0 / distance + 2.0 / radius)
    assert viewpoint_of(plan, space.surroundings.diagonal) == pytest.approx(
        CENTER - [0.0, 0.0, image], rel=2e-3, abs=2e-3
    )


@pytest.mark.parametrize("distance", [0.7, 0.6998])
def test_a_viewpoint_at_infinity_or_nearly_so_is_no_dot_and_leaves_parallel_lines(distance):
    # From the focus of a concave mirror rays run on as parallels.
    eye = Camera(np.add(CENTER, (0.0, 0.0, distance)).tolist(), CENTER.tolist(), field_of_view=4.0)
    space, (seen,) = seen_in(scene_with(spherical_mirror(-1.4, 4, (0.001, 0.001)), camera=eye))
    assert viewpoint_of(seen.plans[0], space.surroundings.diagonal) is None
    marks = viewpoint_marks(seen, space.surroundings.diagonal)
    assert len(marks.dots.ends[:, 0]) == 0 and finite(marks)
    ways = np.diff(marks.segments.ends, axis=1)[:, 0]
    assert ways == pytest.approx(np.tile([0.0, 0.0, -space.surroundings.diagonal], (len(ways), 1)), rel=1e-2, abs=0.05)


def test_hits_are_where_the_traced_paths_of_the_vertices_end():
    scene = scene_with(spherical_mirror())
    space, (seen,) = seen_in(scene)
    vertices = seen.body_rays.side.optics.positions
    eye = np.tile(np.array(CAMERA.position), (len(vertices), 1))
    records = drain(
        PathTracer(scene, space.geometry, space.surroundings.caster).tracing(GivenRays(eye, vertices - eye))
    ).astype(float)
    ends = records[:, :3] + records[:, 11:12] * records[:, 4:7]
    bent = (records.astype(np.float32).view(np.uint32)[:, 7] >> 24) == 1
    known = bent & np.isfinite(seen.distances) & (seen.body_rays.rays.status == RayStatus.OK)
    known &= np.isfinite(ends).all(axis=1)
    assert known.sum() > 30
    assert np.median(np.linalg.norm(ends[known] - seen.hits[known], axis=1)) < 1e-4
    marks = hit_marks(seen, space.surroundings.diagonal)
    among = np.abs(marks.dots.ends[:, 0][:, None] - seen.hits[None]).max(axis=2).min(axis=1)
    assert among.max() < 1e-5
    assert len(marks.dots.ends[:, 0]) == np.isfinite(seen.distances).sum()


def test_rays_into_the_sky_have_no_ball_but_go_some_way():
    space, (seen,) = seen_in(sky_scene(spherical_mirror()))
    marks = hit_marks(seen, space.surroundings.diagonal, CAMERA)
    assert len(marks.dots.ends[:, 0]) == 0 and finite(marks)
    assert len(marks.segments.ends) == 2 * len(seen.hits)
    lengths = np.linalg.norm(np.diff(marks.segments.ends, axis=1), axis=2).ravel()
    assert lengths[: len(seen.hits)] == pytest.approx(space.surroundings.diagonal, rel=1e-5)


def inside_of(points: np.ndarray, near: np.ndarray, far: np.ndarray) -> np.ndarray:
    """By how much the worst of a frustum's six planes is before each point, metres: positive is inside."""
    middle = np.concatenate([near, far]).mean(axis=0)
    quads = [near, far, *(np.stack([near[i], near[i - 1], far[i - 1], far[i]]) for i in range(4))]
    heights = []
    for quad in quads:
        normal = np.cross(quad[2] - quad[0], quad[3] - quad[1])
        normal /= np.linalg.norm(normal) * np.sign(normal @ (middle - quad.mean(axis=0)))
        heights.append((points - quad.mean(axis=0)) @ normal)
    return np.min(heights, axis=0)


@pytest.mark.parametrize("make", [flat_mirror, spherical_mirror, lambda: spherical_mirror(-0.5)])
@pytest.mark.parametrize("wide", ["patches", "cube"])
def test_the_view_volumes_embrace_the_hits(make, wide):
    space, (seen,) = seen_in(scene_with(make()), options=replace(OPTIONS, field=30.0, wide=wide))
    for plan in seen.plans:
        met = np.isfinite(plan.distances) & (plan.lookups[0, :, 3] > 0.0)
        volumes = [frustum(each, plan, space.surroundings.diagonal) for each in plan.projections]
        assert all(np.isfinite(corners).all() for volume in volumes for corners in volume)
        depth = np.max([inside_of(plan.hits[met], *volume) for volume in volumes], axis=0)
        # Between a near part and a far one nothing is drawn where the lines cross.
        assert (depth > -1e-4 * space.surroundings.diagonal).mean() > (0.9 if len(volumes) == 2 else 0.999)


def test_a_view_volume_begins_at_its_near_plane_and_ends_before_the_lines_cross():
    space, (seen,) = seen_in(scene_with(spherical_mirror(-0.5)))
    (plan,) = seen.plans
    crossing = viewpoint_of(plan, space.surroundings.diagonal)
    before = plan.projections[-1]
    near, far = frustum(before, plan, space.surroundings.diagonal)
    clip = np.column_stack([near, np.ones(4)]) @ before.clip.T
    assert clip[:, 2] / clip[:, 3] == pytest.approx(1.0, abs=1e-6)
    assert np.abs(clip[:, :2] / clip[:, 3:]) == pytest.approx(1.0, abs=1e-6)
    assert np.linalg.norm(far - far.mean(axis=0), axis=1).max() < np.linalg.norm(near - near.mean(axis=0), axis=1).max()
    assert (far[:, 2] <= crossing[2] + 1e-3).all()


def test_every_edge_is_a_wire_once():
    assert len(wireframe_of(scene_with(flat_mirror())).ends) == 5
    assert len(wireframe_of(scene_with(spherical_mirror(count=6))).ends) == 6 * 7 * 2 + 36
    assert len(wireframe_of(Scene("none", (box((0, 0, 0), (1, 1, 1)).mesh("box", Diffuse()),), CAMERA)).ends) == 0
    # Two meshes of one mirror have their common edge once; each of 2 x 2 vertices has 5.
    halves = (
        plane_mirror("wall/left", (-1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
        plane_mirror("wall/right", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
    )
    wireframe = wireframe_of(scene_with(*halves))
    ends = {tuple(sorted(map(tuple, pair))) for pair in wireframe.ends.tolist()}
    assert len(wireframe.ends) == len(ends) == 9
    # A closed body: V - E + F = 2, with corners of a box six-fold.
    solid = box((0, 0, 0), (1, 1, 1)).mesh("box", Mirror())
    assert len(wireframe_of(Scene("box", (solid,), CAMERA)).ends) == 8 + 12 - 2


def test_wires_are_fainter_from_behind_and_where_they_are_short():
    wireframe = wireframe_of(scene_with(flat_mirror()))
    front, behind = Camera((0.0, 0.5, 1.0), (0.0, 0.5, 0.0)), Camera((0.0, 0.5, -1.0), (0.0, 0.5, 0.0))
    alpha = wireframe_marks(wireframe, front, (800, 600)).segments.colors[:, 3]
    assert wireframe_marks(wireframe, behind, (800, 600)).segments.colors[:, 3] == pytest.approx(0.3 * alpha)
    away = wireframe_marks(wireframe, replace(front, position=(0.0, 0.5, 60.0)), (800, 600)).segments.colors[:, 3]
    assert (away < alpha).all() and (away > 0.0).all()


def test_the_eyes_image_stands_before_it_and_has_its_shape():
    marks = eye_marks(CAMERA, (200, 100), 0.5)
    image = marks.segments.ends[:4, 1].astype(float)
    assert (image - CAMERA.position) @ CAMERA.axes()[2] == pytest.approx(0.5, rel=1e-5)
    assert CAMERA.image(image, (200, 100))[:, :2] / 0.5 == pytest.approx(
        np.array([[0, 0], [200, 0], [200, 100], [0, 100]]), abs=1e-3
    )
    assert marks.dots.ends[:, 0] == pytest.approx(np.array([CAMERA.position]), rel=1e-6)


@pytest.mark.parametrize("stops", [0, 1, 2, 3, 10])
def test_a_path_has_a_leg_between_its_stops_and_a_colour_for_each_stage(stops):
    path = tuple(Stop(str(number), (float(number), 0.0, 0.0)) for number in range(stops))
    marks = path_marks(
        Inspection((0, 0), Specification.parse("raytrace"), "sky", None, None, "sky", path, "sky", None, None, False)
    )
    legs = max(stops - 1, 0)
    assert len(marks.segments.ends) == legs and len(marks.dots.ends[:, 0]) == (stops if legs else 0)
    assert marks.segments.ends[:, 1, 0].tolist() == list(range(1, legs + 1))
    assert len(np.unique(marks.segments.colors, axis=0)) == min(legs, 2)
    assert len(np.unique(marks.dots.colors, axis=0)) == min(len(marks.dots.colors), 3)


def test_all_that_the_state_asks_for_is_drawn_and_nothing_else():
    scene = scene_with(spherical_mirror())
    space = PreparedScene(scene)
    assert len(space_marks(space, state_of(scene), CAMERA, SIZE).segments.ends) == 0
    assert "surroundings" not in vars(space), "nothing is prepared that is not drawn"
    sizes = {}
    found = Reflection("mirror", ((0.0, 0.5, 0.0),), (1.0, 2.0), 3.0, 1, False)
    shown = Reflections((0.0, 0.5, 1.0), CAMERA.position, ReflectionStatus.FOUND, (found,))
    for drawing in Drawing:
        reflections = shown if drawing is Drawing.REFLECTIONS else None
        marks = space_marks(space, state_of(scene, drawing), CAMERA, SIZE, None, reflections)
        sizes[drawing] = len(marks.segments.ends)
        assert finite(marks) and sizes[drawing] > 0
    together = space_marks(space, state_of(scene, *Drawing), CAMERA, SIZE, None, shown)
    assert len(together.segments.ends) == sum(sizes.values())
    # From outside there are the eye and its rays as well.
    outside = space_marks(space, state_of(scene, *Drawing, observer=ASIDE), CAMERA, SIZE, None, shown)
    assert finite(outside) and len(outside.segments.ends) == sum(sizes.values()) + sizes[Drawing.HITS] + 8
    path = (Stop("eye", CAMERA.position), Stop("floor", (0.0, 0.0, 0.0)))
    inspection = Inspection(
        (0, 0), Specification.parse("raytrace"), "floor", (0, 0, 0), 1.0, "direct", path, "floor", None, None, False
    )
    assert len(space_marks(space, state_of(scene), CAMERA, SIZE, inspection).segments.ends) == 1


def test_the_maps_are_those_of_the_methods_own_options():
    scene = gallery.make("torus")
    space = PreparedScene(scene)
    few, many, cube = (
        len(space_marks(space, state_of(scene, Drawing.VOLUME, method=method), scene.camera, SIZE).segments.ends)
        for method in ("environment", "pervertex:field=60", "pervertex:wide=cube")
    )
    assert cube < few < many


@pytest.mark.parametrize("name", ["spheres", "spectacles-plus", "magnifier", "saddle", "curvature-series", "room"])
def test_built_in_scenes_are_drawn_with_finite_numbers_and_not_too_many_rays(name):
    scene = gallery.make(name)
    space = PreparedScene(scene)
    marks = space_marks(space, state_of(scene, *Drawing, observer=ASIDE), scene.camera, (320, 240))
    assert finite(marks)
    assert len(marks.dots.ends[:, 0]) <= len(space.bodies) * (MOST_HITS + 2 * MOST_RAYS)
    assert np.abs(marks.segments.ends).max() < 50.0 * space.surroundings.diagonal


def test_glass_that_is_no_lens_has_wires_alone():
    solid = box((-0.1, 0.4, -0.1), (0.1, 0.6, 0.1)).mesh("glass", Glass())
    scene = scene_with(solid)
    marks = space_marks(PreparedScene(scene), state_of(scene, *Drawing), CAMERA, SIZE)
    assert len(marks.segments.ends) == 18 and len(marks.dots.ends[:, 0]) == 0
