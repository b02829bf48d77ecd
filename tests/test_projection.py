"""Projections against plain geometry in float64."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from anamorph.projection import (
    CROSSING,
    UNIFORM_BYTES,
    MapFrame,
    camera_projection,
    far_projection,
    map_frame,
    map_projection,
    pinhole_projection,
)
from anamorph.scene.camera import Camera

SIZE = (160, 90)
CAMERA = Camera(position=(1.0, 2.0, 3.0), target=(-0.5, 1.0, -2.0), up=(0.1, 1.0, 0.0), field_of_view=50.0)
SEEDS = st.integers(0, 2**32 - 1)


def clip(projection, points):
    return np.column_stack([points, np.ones(len(points))]) @ projection.clip.T


def to_pixels(projection, points, size):
    x, y, _, w = clip(projection, points).T
    return np.stack([(x / w + 1.0) / 2.0 * size[0], (1.0 - y / w) / 2.0 * size[1]], axis=-1)


@pytest.mark.parametrize("shift", [(0.0, 0.0), (0.25, -0.375)])
def test_points_along_a_pixels_direction_project_to_that_pixel(shift):
    generator = np.random.default_rng(1)
    pixels = generator.uniform((0, 0), SIZE, (200, 2))
    points = CAMERA.position + generator.uniform(0.5, 500.0, (200, 1)) * CAMERA.directions(pixels + shift, SIZE)
    assert to_pixels(camera_projection(CAMERA, SIZE, shift), points, SIZE) == pytest.approx(pixels, abs=1e-9)


@pytest.mark.parametrize("shift", [(0.0, 0.0), (0.5, 0.25)])
def test_base_right_and_up_look_where_the_pixels_do(shift):
    projection = camera_projection(CAMERA, SIZE, shift)
    pixels = np.random.default_rng(2).uniform((0, 0), SIZE, (50, 2))
    x, y = pixels[:, 0] / SIZE[0] * 2.0 - 1.0, 1.0 - pixels[:, 1] / SIZE[1] * 2.0
    looks = projection.base + x[:, None] * projection.right + y[:, None] * projection.up
    looks /= np.linalg.norm(looks, axis=1, keepdims=True)
    assert looks == pytest.approx(CAMERA.directions(pixels + shift, SIZE), abs=1e-12)
    assert projection.eye == pytest.approx(np.array(CAMERA.position))


def test_depth_is_one_on_the_near_plane_and_falls_to_zero_far_away():
    forward = CAMERA.axes()[2]
    near = 1e-6 * np.linalg.norm(np.subtract(CAMERA.target, CAMERA.position))
    distances = np.geomspace(near, 1e7 * near, 30)
    _, _, z, w = clip(camera_projection(CAMERA, SIZE), CAMERA.position + distances[:, None] * forward).T
    depth = z / w
    assert depth[0] == pytest.approx(1.0)
    assert (np.diff(depth) < 0.0).all()
    assert 0.0 < depth[-1] < 2e-7
    assert w == pytest.approx(distances)


def test_a_pinhole_may_look_askew():
    eye, base = np.array([1.0, -2.0, 0.5]), np.array([0.2, 0.1, 3.0])
    right, up = np.array([1.0, 0.2, 0.0]), np.array([-0.1, 0.8, 0.3])
    projection = pinhole_projection(eye, base, right, up, near=0.1)
    x, y = np.random.default_rng(3).uniform(-1, 1, (2, 40))
    points = eye + np.linspace(0.2, 90.0, 40)[:, None] * (base + x[:, None] * right + y[:, None] * up)
    u, v, z, w = clip(projection, points).T
    assert np.stack([u / w, v / w]) == pytest.approx(np.stack([x, y]), abs=1e-12)
    assert (z == pytest.approx(0.1)) and (w == pytest.approx(np.linspace(0.2, 90.0, 40)))


def test_the_uniform_is_what_the_shader_reads():
    projection = camera_projection(CAMERA, SIZE)
    words = projection.uniform(SIZE)
    assert words.dtype == np.float32 and words.nbytes == UNIFORM_BYTES
    columns = words[:16].reshape(4, 4)
    assert pytest.approx(projection.clip, rel=1e-6) == columns.T
    assert words[16:32].reshape(4, 4).T @ projection.clip == pytest.approx(np.eye(4), abs=1e-4)
    assert words[35] == pytest.approx(2.0 * np.tan(np.radians(25.0)) / SIZE[1], rel=1e-6)
    assert words[48:50] == pytest.approx(SIZE)


def random_axes(generator):
    axes = np.linalg.qr(generator.normal(size=(3, 3)))[0]
    axes[2] = np.cross(axes[0], axes[1])
    return axes


@settings(max_examples=60)
@given(SEEDS, st.sampled_from([0.5, 1.0, 30.0, 1e4]))
def test_a_map_sees_points_where_the_line_to_the_viewpoint_crosses_its_plane(seed, distance):
    generator = np.random.default_rng(seed)
    axes, center = random_axes(generator), generator.normal(size=3)
    viewpoint = center - distance * (axes[2] + 0.4 * generator.uniform(-1, 1, 2) @ axes[:2])
    frame = map_frame(np.append(viewpoint, 1.0) * generator.uniform(0.1, 3.0), center, axes)
    points = center + generator.uniform((-2, -2, 0.0), (2, 2, 9), (20, 3)) @ axes
    # The geometric crossing, with no use of homogeneous coordinates.
    lines = points - viewpoint
    crossing = viewpoint + (((center - viewpoint) @ axes[2]) / (lines @ axes[2]))[:, None] * lines
    projected = frame.project(points)
    places = projected[:, :2] / projected[:, 2:]
    assert places == pytest.approx((crossing - center) @ axes[:2].T, rel=1e-9, abs=1e-9 * max(1.0, distance))
    assert np.column_stack([points, np.ones(20)]) @ frame.matrix().T == pytest.approx(projected, rel=1e-9, abs=1e-9)


@settings(max_examples=40)
@given(SEEDS, st.floats(1.0, 12.0))
def test_a_map_changes_continuously_into_the_parallel_projection(seed, power):
    generator = np.random.default_rng(seed)
    axes, center = random_axes(generator), generator.normal(size=3)
    toward = axes[2] + 0.5 * generator.uniform(-1, 1, 2) @ axes[:2]
    points = center + generator.uniform(-3, 3, (10, 3))
    parallel = map_frame(np.append(-toward, 0.0), center, axes)
    distant = map_frame(np.append(center - 10.0**power * toward, 1.0), center, axes)
    assert parallel.convergence == 0.0
    assert distant.project(points) == pytest.approx(parallel.project(points), abs=10.0 ** (1 - power) + 1e-9)


@st.composite
def maps(draw):
    """A map's frame, bounds and askew near plane, in front of a box that it sees some of."""
    generator = np.random.default_rng(draw(SEEDS))
    convergence = draw(st.sampled_from([0.0, 1e-6, 0.2, 3.0]))
    slope = generator.uniform(-0.5, 0.5, 2)
    axes, center = random_axes(generator), generator.normal(size=3)
    frame = MapFrame(center, axes, slope, convergence)
    low = generator.uniform(-1.0, 0.0, 2)
    bounds = np.stack([low, low + generator.uniform(0.05, 2.0, 2)])
    normal = axes[2] + draw(st.sampled_from([0.0, 0.5, 3.0])) * generator.uniform(-1, 1, 2) @ axes[:2]
    normal /= np.linalg.norm(normal)
    near_plane = np.append(normal, -(normal @ center) + generator.uniform(0.0, 0.2))
    # The viewpoint, finite or not, is behind the plane.
    viewpoint = convergence * center + slope @ axes[:2] - axes[2]
    assume(near_plane @ np.append(viewpoint, convergence) < 0.0)
    half = generator.uniform(0.5, 20.0, 3)
    middle = center + generator.uniform(-1, 1, 3) * half
    corners = middle + half * np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3), axis=-1).reshape(-1, 3)
    return generator, frame, bounds, near_plane, corners


@settings(max_examples=80)
@given(maps())
def test_lines_through_the_viewpoint_keep_their_place_in_the_map(drawn):
    generator, frame, bounds, near_plane, corners = drawn
    projection = map_projection(frame, bounds, near_plane, corners)
    x, y = generator.uniform(-1, 1, (2, 30))
    places = bounds.mean(axis=0) + np.stack([x, y], axis=-1) * np.ptp(bounds, axis=0) / 2.0
    looks = projection.base + x[:, None] * projection.right + y[:, None] * projection.up
    points = frame.center + places @ frame.axes[:2] + generator.uniform(0, 30, (30, 1)) * looks
    u, v, _, w = clip(projection, points).T
    assert (w > 0.0).all()
    assert np.stack([u / w, v / w]) == pytest.approx(np.stack([x, y]), abs=1e-9)


@settings(max_examples=80)
@given(maps())
def test_unclip_undoes_clip_and_the_near_plane_has_depth_one(drawn):
    generator, frame, bounds, near_plane, corners = drawn
    projection = map_projection(frame, bounds, near_plane, corners)
    points = generator.uniform(corners.min(axis=0), corners.max(axis=0), (30, 3))
    back = clip(projection, points) @ np.linalg.inv(projection.clip).T
    assert back[:, :3] / back[:, 3:] == pytest.approx(points, abs=1e-6)
    on_plane = points - (points @ near_plane[:3] + near_plane[3])[:, None] * near_plane[:3]
    _, _, z, w = clip(projection, on_plane).T
    assert z == pytest.approx(w, abs=1e-9 * np.abs(projection.clip).max() * 50.0)


@settings(max_examples=300)
@given(maps())
def test_nothing_of_the_scene_inside_the_view_volume_is_cut_off(drawn):
    generator, frame, bounds, near_plane, corners = drawn
    projection = map_projection(frame, bounds, near_plane, corners)
    points = generator.uniform(corners.min(axis=0), corners.max(axis=0), (400, 3))
    points = np.concatenate([points, corners])
    x, y, z, w = clip(projection, points).T
    ahead = points @ near_plane[:3] + near_plane[3] > 1e-9
    inside = ahead & (w > 1e-9) & (np.abs(x) <= w) & (np.abs(y) <= w)
    assert (z[inside] <= w[inside]).all()
    assert (z[inside] >= -1e-9 * np.abs(projection.clip).max() * 50.0).all()


def test_depth_falls_along_every_line_of_sight():
    frame = MapFrame(np.zeros(3), np.eye(3), np.array([0.2, 0.0]), 0.5)
    near_plane = np.array([0.3, 0.0, 1.0, 0.1]) / np.sqrt(1.09)
    corners = np.stack(np.meshgrid([-9.0, 9.0], [-9.0, 9.0], [-1.0, 9.0]), axis=-1).reshape(-1, 3)
    projection = map_projection(frame, np.array([[-1.0, -1.0], [1.0, 1.0]]), near_plane, corners)
    for x, y in [(-1.0, 0.5), (0.0, 0.0), (0.9, -0.9)]:
        look = projection.base + x * projection.right + y * projection.up
        points = np.array([x, y, 0.0]) + np.linspace(0.5, 9.0, 50)[:, None] * look
        _, _, z, w = clip(projection, points).T
        assert (np.diff(z / w) < 0.0).all()


@st.composite
def converging(draw):
    """A map of lines that cross before its image plane, the near plane between them askew, and a box around both."""
    generator = np.random.default_rng(draw(SEEDS))
    convergence = -draw(st.sampled_from([1e-3, 0.2, 1.0, 5.0]))
    axes, center = random_axes(generator), generator.normal(size=3)
    frame = MapFrame(center, axes, generator.uniform(-0.5, 0.5, 2), convergence)
    low = generator.uniform(-1.0, 0.0, 2)
    bounds = np.stack([low, low + generator.uniform(0.05, 2.0, 2)])
    normal = axes[2] + draw(st.sampled_from([0.0, 0.5])) * generator.uniform(-1, 1, 2) @ axes[:2]
    normal /= np.linalg.norm(normal)
    near_plane = np.append(normal, -(normal @ center))
    crossing = center + (axes[2] - frame.slope @ axes[:2]) / -convergence
    assume(normal @ crossing + near_plane[3] > 0.1 / -convergence)
    size = draw(st.sampled_from([3.0, 30.0])) / -convergence
    corners = center + size * np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3), axis=-1).reshape(-1, 3)
    return generator, frame, bounds, near_plane, corners


def lines_of(generator, frame, bounds, projection, count=20):
    """Places (count, 2) from -1 to 1, and where their lines cross the image plane, and how they run, to height 1."""
    places = generator.uniform(-1, 1, (count, 2))
    starts = bounds.mean(axis=0) + places * np.ptp(bounds, axis=0) / 2.0
    looks = projection.base + places[:, :1] * projection.right + places[:, 1:] * projection.up
    return places, frame.center + starts @ frame.axes[:2], looks


@settings(max_examples=80)
@given(converging())
def test_before_and_beyond_their_crossing_lines_keep_one_place(drawn):
    generator, frame, bounds, near_plane, corners = drawn
    near = map_projection(frame, bounds, near_plane, corners)
    far = far_projection(frame, bounds)
    places, starts, looks = lines_of(generator, frame, bounds, near)
    for name in ("base", "right", "up", "eye"):
        assert getattr(near, name).tolist() == getattr(far, name).tolist()
    for projection, low, high in ((near, 0.0, 0.99), (far, 1.01, 30.0)):
        heights = generator.uniform(low, high, (len(places), 1)) / -frame.convergence
        u, v, _, w = clip(projection, starts + heights * looks).T
        assert (w > 0.0).all()
        assert np.stack([u / w, v / w], axis=-1) == pytest.approx(places, abs=1e-7)
        # The other map sees nothing of this part.
        other = far if projection is near else near
        assert (clip(other, starts + heights * looks)[:, 3] < 0.0).all()
    # What is infinitely far along the lines stands at the same places: the sky beyond the crossing.
    u, v, z, w = (np.column_stack([looks, np.zeros(len(looks))]) @ far.clip.T).T
    assert (w > 0.0).all() and z == pytest.approx(0.0)
    assert np.stack([u / w, v / w], axis=-1) == pytest.approx(places, abs=1e-7)


@settings(max_examples=80)
@given(converging())
def test_along_lines_that_cross_what_is_nearer_to_the_mirror_is_in_front(drawn):
    generator, frame, bounds, near_plane, corners = drawn
    near, far = map_projection(frame, bounds, near_plane, corners), far_projection(frame, bounds)
    _, starts, looks = lines_of(generator, frame, bounds, near)
    crossing = 1.0 / -frame.convergence
    for start, look in zip(starts, looks, strict=True):
        _, _, z, w = clip(near, start + np.linspace(0.0, (1.0 - CROSSING) * crossing, 40)[:, None] * look).T
        assert (np.diff(z / w) < 0.0).all()
        _, _, z, w = clip(far, start + crossing * np.geomspace(1.0 + CROSSING, 1e6, 40)[:, None] * look).T
        assert (np.diff(z / w) < 0.0).all()
        assert z[0] / w[0] == pytest.approx(1.0) and 0.0 < z[-1] / w[-1] < 1e-8


@settings(max_examples=80)
@given(converging())
def test_only_at_the_crossing_itself_is_something_cut_off(drawn):
    generator, frame, bounds, near_plane, corners = drawn
    near, far = map_projection(frame, bounds, near_plane, corners), far_projection(frame, bounds)
    points = generator.uniform(corners.min(axis=0), corners.max(axis=0), (400, 3))
    weight = frame.project(points)[:, 2]
    ahead = points @ near_plane[:3] + near_plane[3] > 1e-9 * np.abs(corners).max()
    for projection, part in ((near, ahead & (weight > CROSSING)), (far, weight < -CROSSING)):
        x, y, z, w = clip(projection, points).T
        inside = part & (np.abs(x) <= w) & (np.abs(y) <= w)
        assert (z[inside] <= w[inside] * (1.0 + 1e-9)).all()
        assert (z[inside] >= 0.0).all()


@settings(max_examples=60)
@given(SEEDS, st.floats(2.0, 12.0), st.sampled_from([1.0, -1.0]))
def test_a_map_changes_continuously_from_spreading_to_converging_lines(seed, power, sign):
    generator = np.random.default_rng(seed)
    axes, center = random_axes(generator), generator.normal(size=3)
    slope, low = generator.uniform(-0.5, 0.5, 2), generator.uniform(-1.0, 0.0, 2)
    bounds = np.stack([low, low + generator.uniform(0.2, 2.0, 2)])
    near_plane = np.append(axes[2], -axes[2] @ center + 0.1)
    corners = center + 5.0 * np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3), axis=-1).reshape(-1, 3)
    points = center + generator.uniform((-2, -2, 0.0), (2, 2, 5), (20, 3)) @ axes
    parallel, almost = (
        clip(map_projection(MapFrame(center, axes, slope, k), bounds, near_plane, corners), points)
        for k in (0.0, sign * 10.0**-power)
    )
    assert almost / almost[:, 3:] == pytest.approx(parallel / parallel[:, 3:], abs=1e3 * 10.0**-power + 1e-9)
