"""Cube maps at a body's virtual viewpoint: the plan, the device's way from a direction to a texel, and the frames."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import CENTER, SIZE, drawn, open_view, scene_with, sky_scene, spherical_mirror

from anamorph.base.errors import AnamorphError
from anamorph.frame import Status
from anamorph.gallery import make
from anamorph.gallery.spheres import mirror_ball
from anamorph.measure.angles import angles_between
from anamorph.measure.errors import measure, silhouettes
from anamorph.methods.pervertex import Options
from anamorph.methods.pervertex.bundle import part_of, pixel_weights
from anamorph.methods.pervertex.cube_plan import FORWARD, RIGHT, UP, plan_cube
from anamorph.methods.pervertex.division import seen_faces
from anamorph.methods.pervertex.inconsistency import map_lines
from anamorph.methods.pervertex.surroundings import surroundings_of
from anamorph.optics.ray_meshes import bodies_of, rays_of
from anamorph.raymesh import RayStatus
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Mirror, Sky

BALL = mirror_ball("ball", tuple(CENTER), 0.2, 24, 32)
DOME = spherical_mirror(0.25, 16, (0.13, 0.13))
"""A cap whose rays spread by more than 100 degrees, but not to all sides."""

WIDE = scene_with(BALL)


def plan_of(scene, **options):
    """The first body's ray mesh, its faces and its cube map's plan."""
    geometry = flatten(scene)
    bodies = bodies_of(scene, geometry)
    around = surroundings_of(geometry, bodies)
    body_rays = rays_of(bodies[0], scene.camera.eye(SIZE))
    faces = seen_faces(body_rays.rays, SIZE)
    occluder = np.zeros(len(body_rays.rays.origins), int)
    return body_rays.rays, faces, plan_cube(body_rays, faces, occluder, around, Options(**options))


def locate(plan, directions):
    """The face that each direction (N, 3) meets, and its place (0 to 1, y down) there, by similar triangles, float64.

    The place is NaN on faces that are not drawn.
    """
    largest = np.abs(directions).argmax(axis=1)
    faces = 2 * largest + (np.take_along_axis(directions, largest[:, None], axis=1)[:, 0] <= 0.0)
    places = np.full((len(directions), 2), np.nan)
    for number, face in enumerate(plan.cube):
        projection, here = plan.projections[number], faces == face
        tangents = np.stack([directions[here] @ RIGHT[face], directions[here] @ UP[face]], axis=1)
        tangents /= (directions[here] @ FORWARD[face])[:, None]
        center = np.array([projection.base @ RIGHT[face], projection.base @ UP[face]])
        half = np.array([np.linalg.norm(projection.right), np.linalg.norm(projection.up)])
        places[here] = 0.5 + (tangents - center) / half * [0.5, -0.5]
    return faces, places


@pytest.fixture(scope="module")
def ball():
    return plan_of(WIDE)


@pytest.fixture(scope="module")
def reference():
    return drawn(WIDE, "raytrace")


def test_the_faces_axes_are_right_handed_and_in_the_shaders_order():
    np.testing.assert_array_equal(np.cross(FORWARD, UP), RIGHT)
    for face, forward in enumerate(FORWARD):
        axes = np.stack([RIGHT[face], UP[face], -forward])
        np.testing.assert_array_equal(axes @ axes.T, np.eye(3))
        assert np.linalg.det(axes) == pytest.approx(1.0)
        assert forward[face // 2] == (-1.0) ** face


def test_the_viewpoint_is_the_least_squares_point_of_the_rays_that_are_seen(ball):
    rays, _, plan = ball
    part = part_of(rays, plan.vertices, np.searchsorted(plan.vertices, rays.faces[seen_faces(rays, SIZE)]))
    facing = part.status == RayStatus.OK
    offsets, directions = plan.viewpoint[:3] - part.origins[facing], part.unit_directions()[facing]
    misses = offsets - np.sum(offsets * directions, axis=1, keepdims=True) * directions
    assert np.abs(pixel_weights(part, facing) @ misses).max() < 1e-12
    assert np.linalg.norm(plan.viewpoint[:3] - CENTER) < 0.2 and plan.viewpoint[3] == 1.0
    assert all((projection.eye == plan.viewpoint[:3]).all() for projection in plan.projections)


def test_a_vertex_looks_up_the_direction_to_what_its_ray_hits(ball):
    rays, _, plan = ball
    towards = plan.hits - plan.viewpoint[:3]
    lookups = plan.lookups[0]
    assert (lookups[:, 3] == 1.0).all()
    assert angles_between(towards, lookups[:, :3]).max() < 1e-7
    np.testing.assert_allclose(
        np.linalg.norm(lookups[:, :3], axis=1), np.linalg.norm(rays.directions[plan.vertices], axis=1)
    )


def test_the_lines_of_its_lookups_lead_from_the_near_planes_to_what_the_rays_hit(ball):
    _, _, plan = ball
    starts, lines = map_lines(plan, plan.lookups[0])
    assert angles_between(lines, plan.hits - plan.viewpoint[:3]).max() < 1e-7
    assert angles_between(lines, starts - plan.viewpoint[:3]).max() < 1e-6
    assert (np.linalg.norm(starts - CENTER, axis=1) < np.linalg.norm(plan.hits - CENTER, axis=1)).all()


corner_weights = st.lists(st.sampled_from([0.0, 1e-3, 0.2, 1.0]), min_size=3, max_size=3).filter(sum)


@given(corner_weights, st.sampled_from(["ball", "dome"]))
@settings(max_examples=20)
def test_every_direction_between_the_vertices_has_its_place_in_a_face_that_is_drawn(weights, kind):
    rays, faces, plan = PLANS[kind]
    corners = plan.lookups[0][np.searchsorted(plan.vertices, rays.faces[faces]), :3]
    directions = np.einsum("c,fci->fi", weights, corners)
    number, places = locate(plan, directions)
    assert np.isin(number, plan.cube).all()
    assert (places >= 0.0).all() and (places <= 1.0).all()


PLANS = {"ball": plan_of(WIDE), "dome": plan_of(scene_with(DOME))}

component = st.one_of(st.sampled_from([-1.0, -1e-9, 0.0, 1e-9, 1.0]), st.floats(-1.0, 1.0))


@given(st.tuples(component, component, component).filter(lambda d: np.linalg.norm(d) > 0.1))
@settings(max_examples=60)
def test_projections_put_any_direction_where_similar_triangles_do(direction):
    _, _, plan = PLANS["ball"]
    way = np.array(direction)
    (face,), (place,) = locate(plan, way[None])
    if face not in plan.cube:
        return
    projection = plan.projections[plan.cube.index(face)]
    x, y, z, w = projection.clip[:, :3] @ way
    assert w > 0.0 and z == 0.0
    assert np.array([0.5 + 0.5 * x / w, 0.5 - 0.5 * y / w]) == pytest.approx(place, abs=1e-12)
    # And back: what the shaders take the sky's direction from.
    back = projection.base + x / w * projection.right + y / w * projection.up
    assert angles_between(back[None], way[None])[0] < 1e-7


def test_a_face_reaches_beyond_its_borders_so_that_texels_blend(ball):
    _, _, plan = ball
    whole = [i for i, projection in enumerate(plan.projections) if np.linalg.norm(projection.right) > 1.0]
    assert len(whole) >= 3
    for number in whole:
        face = plan.cube[number]
        x, _, _, w = plan.projections[number].clip[:, :3] @ (FORWARD + RIGHT + 0.2 * UP)[face]
        # Half a texel of a map of 64 lies beyond the border.
        assert 32.0 * (1.0 - x / w) > 0.49


def test_only_faces_and_parts_that_are_looked_up_are_drawn():
    _, _, plan = PLANS["dome"]
    assert 4 in plan.cube and 5 not in plan.cube
    assert len(PLANS["ball"][2].cube) == 6
    areas = [np.prod(texels) for texels in plan.texels]
    assert min(areas) < 0.7 * max(areas)


def test_a_whole_ball_is_close_to_the_truth(reference):
    frame = drawn(WIDE, "pervertex:map=image,wide=cube")
    errors = measure(reference, frame)
    assert errors.pixels.median <= 0.4
    assert errors.pixels.p95 <= 1.5
    assert errors.other_object_percent <= 0.5
    assert not (frame.status == Status.OUTSIDE).any()


def test_a_torus_is_about_as_near_to_the_truth_as_by_patches():
    scene = make("torus")
    reference = drawn(scene, "raytrace")
    patches, cube = (measure(reference, drawn(scene, f"pervertex:map=image,wide={way}")) for way in ("patches", "cube"))
    assert cube.pixels.median <= 1.2 * patches.pixels.median
    assert cube.pixels.p95 <= 1.2 * patches.pixels.p95
    assert cube.other_object_percent <= patches.other_object_percent + 1.0


def off_its_sky(sky, camera):
    """A mirror ball under a sky alone, and how far each pixel's colour is from that of the direction it tells."""
    scene = sky_scene(replace(BALL, material=Mirror(reflectance=1.0)), sky, camera)
    frame = drawn(scene, "pervertex:map=image,wide=cube", (320, 240))
    height = frame.position[..., 1:2]
    share = np.sqrt(np.abs(height))
    expected = (1.0 - share) * sky.horizon + share * np.where(height > 0.0, sky.zenith, sky.nadir)
    return frame, np.abs(frame.color - expected).max(axis=-1)


def test_there_is_no_seam_where_faces_meet():
    """Under a sky that changes slowly, a texel held at its map's border would stand out."""
    sky = Sky(zenith=(0.0, 0.0, 0.0), horizon=(1.0, 0.0, 1.0), nadir=(0.0, 1.0, 0.0))
    frame, error = off_its_sky(sky, Camera((0.1, 0.7, 0.9), tuple(CENTER), field_of_view=32.0))
    # At the silhouette, directions change fast from pixel to pixel.
    size = np.sort(np.abs(frame.position), axis=2)
    looked = (frame.specular > 0) & ~silhouettes(frame.specular)
    border = looked & (size[..., 2] - size[..., 1] < 0.005) & (np.abs(frame.position[..., 1]) > 0.5)
    # At the horizon the sky's own colours have an edge.
    inner = looked & (size[..., 2] - size[..., 1] > 0.1) & (np.abs(frame.position[..., 1]) > 0.1)
    assert border.sum() > 100
    assert np.percentile(error[inner], 99) < 0.01
    # Colours are half floats, with steps of 2 ** -11 below one.
    assert error[border].mean() < 2.0 * max(np.median(error[inner]), 2.0**-12)


def test_the_device_finds_the_direction_that_it_looks_up():
    """By its colour and by the point that it tells: two ways from a direction to a face and its place."""
    sky = Sky(zenith=(0.0, 0.0, 1.0), horizon=(1.0, 1.0, 0.0), nadir=(0.0, 0.2, 0.0))
    frame, error = off_its_sky(sky, WIDE.camera)
    mirror = frame.specular > 0
    assert (frame.status[mirror] == Status.SKY).all()
    assert np.percentile(error[mirror & (np.abs(frame.position[..., 1]) > 0.1)], 99) < 0.01


def test_a_body_that_one_map_can_show_has_no_cube_map():
    scene = scene_with(spherical_mirror())
    patches, cube = (drawn(scene, f"pervertex:map=image,wide={way}") for way in ("patches", "cube"))
    assert (patches.color == cube.color).all() and (patches.position == cube.position).all()


def test_rays_that_do_not_spread_from_a_point_behind_the_body_are_divided():
    bowl = spherical_mirror(-0.25, 12, (0.2, 0.2))
    scene = scene_with(bowl)
    assert plan_of(scene)[2] is None
    patches, cube = (drawn(scene, f"pervertex:map=image,wide={way}") for way in ("patches", "cube"))
    assert (patches.color == cube.color).all()


def test_a_wide_body_has_one_draw_and_a_map_for_each_face_that_it_needs():
    session = open_view(WIDE, "pervertex:map=image,wide=cube")
    session.draw(WIDE.camera)
    held = session.diagnostics()
    (draw,), (level,) = held["seen"].draws, held["levels"]
    assert draw.cube and draw.sides == 1
    assert len(level.views) == len(PLANS["ball"][2].cube)
    assert all(view.sky for view in level.views)


def test_wide_and_narrow_bodies_share_an_image():
    session = open_view(
        scene_with(spherical_mirror(), mirror_ball("ball", (0.0, 0.7, -0.4), 0.15, 12, 16)),
        "pervertex:map=image,wide=cube",
    )
    session.draw(WIDE.camera)
    assert {draw.cube for draw in session.diagnostics()["seen"].draws} == {False, True}


def test_a_cube_map_shows_mirrors_in_mirrors():
    scene = scene_with(BALL, mirror_ball("other", (0.35, 0.5, 0.35), 0.12, 16, 24))
    reference = drawn(scene, "raytrace")
    errors = [measure(reference, drawn(scene, f"pervertex:map=image,wide=cube,bounces={n}")) for n in (1, 2)]
    assert errors[1].other_object_percent < 0.5 * errors[0].other_object_percent


@pytest.mark.parametrize("value", ["moon", "Cube", ""])
def test_another_way_to_draw_wide_bodies_is_refused_by_name(value):
    with pytest.raises(AnamorphError, match=r"^pervertex: wide is [^\n]*patches or cube$"):
        open_view(WIDE, f"pervertex:map=image,wide={value}")
