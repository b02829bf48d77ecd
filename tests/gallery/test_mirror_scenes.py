"""The built-in scenes of curved, turned, closed and facing mirrors: that each shows what it is there to show."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from anamorph import gallery
from anamorph.base.errors import AnamorphError
from anamorph.base.steps import drain
from anamorph.frame import Status
from anamorph.gallery.curvature_series import FLATTEST, RADII, SIZE, curved_mirror, one_mirror
from anamorph.gallery.torus import MAJOR, MINOR
from anamorph.methods.tracing.launch import eye_rays
from anamorph.methods.tracing.paths import PathTracer
from anamorph.optics.laws import reflect
from anamorph.rays.caster import Caster
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Mirror
from anamorph.surfaces.intersection import intersect
from anamorph.surfaces.nurbs import NurbsSurface
from anamorph.surfaces.plane import Plane
from anamorph.surfaces.sphere import Sphere
from anamorph.surfaces.toroid import Toroid

NAMES = ("curvature-series", "saddle", "car-windows", "facing-mirrors", "torus")
IMAGE = (160, 120)

tiny = st.builds(lambda share, sign: sign * share * FLATTEST, st.floats(0.0, 3.0), st.sampled_from((-1.0, 1.0)))
curvatures = st.one_of(st.floats(-2.0, 2.0), tiny, st.sampled_from((0.0, FLATTEST, -FLATTEST, 2.0, -2.0)))


@cache
def scene(name):
    return gallery.make(name)


def mesh(name, part):
    return next(mesh for mesh in scene(name).meshes if mesh.name == part)


def traced(view, size=IMAGE):
    """The tracer's records, (H, W, 16), and of each pixel its number of bounces, status and first mirror's name."""
    geometry = flatten(view)
    records = drain(PathTracer(view, geometry, Caster(geometry)).tracing(eye_rays(view.camera, size)))
    flags = records.view(np.uint32)[:, 7].reshape(size[1], size[0])
    names = np.array(["", *(part.name for part in view.meshes)])[flags & 0xFFFF]
    return records.reshape(size[1], size[0], 16), flags >> 24, (flags >> 16) & 0xFF, names


@cache
def paths(name):
    return traced(scene(name))


@pytest.mark.parametrize("name", NAMES)
def test_scenes_stay_small(name):
    assert sum(len(part.faces) for part in scene(name).meshes) < 15_000


@pytest.mark.parametrize(("name", "parts"), [
    ("curvature-series", [f"mirror-{number}" for number in range(1, 10)]),
    ("saddle", ["saddle", "cylinder"]),
    ("car-windows", ["mirror", "coming-front-window", "coming-rear-window"]),
    ("facing-mirrors", ["mirror-far"]),
])  # fmt: skip
def test_mirrors_face_the_eye_and_nothing_hides_their_border_but_what_stands_before_them(name, parts):
    view, geometry = scene(name), flatten(scene(name))
    eye = np.asarray(view.camera.position)
    for part in parts:
        mirror = mesh(name, part)
        assert (np.einsum("vk,vk->v", mirror.normals, eye - mirror.positions) > 0).all(), part
        inside = mirror.positions + 0.02 * (mirror.positions.mean(axis=0) - mirror.positions) - eye
        hit = Caster(geometry).cast(np.tile(eye, (len(inside), 1)), inside).triangle
        first = {view.meshes[number - 1].name.split("/")[-1] for number in geometry.face_object[hit]}
        assert not first & {"bezel", "mount-saddle", "mount-cylinder", f"frame/{part}"}


@given(curvatures, st.floats(0.0, 1e-3), st.sampled_from((-1.0, 1.0)))
def test_where_rays_meet_a_mirror_changes_continuously_with_its_curvature(curvature, step, sign):
    other = float(np.clip(curvature + sign * step, -2.0, 2.0))
    side = np.linspace(-0.45 * SIZE, 0.45 * SIZE, 5)
    flat = np.stack([*map(np.ravel, np.meshgrid(side, side)), np.zeros(25)], axis=-1)
    eye = np.array([0.05, -0.03, 2.6])
    rays = (flat - eye) / np.linalg.norm(flat - eye, axis=1, keepdims=True)
    found = []
    for value in (curvature, other):
        surface = curved_mirror(value).surface
        assert isinstance(surface, Plane if abs(value) < FLATTEST else Sphere)
        positions, normals, ok = intersect(surface, np.tile(eye, (25, 1)), rays, surface.parameters(flat))
        assert ok.all()
        found.append((positions, normals * np.sign(normals[:, 2:])))
    change = abs(curvature - other)
    # The corners' distance from the axis bounds how fast normals turn, and half its square how fast points move.
    assert np.abs(found[0][0] - found[1][0]).max() <= 0.05 * change + 5e-9
    assert np.abs(found[0][1] - found[1][1]).max() <= 0.30 * change + 5e-8


@given(curvatures)
def test_a_curved_mirror_is_a_square_whose_depth_is_that_of_its_sphere(curvature):
    mirror = curved_mirror(curvature, vertices=5)
    x, y, z = mirror.positions.astype(float).T
    np.testing.assert_allclose(np.unique(np.round(x, 6)), np.linspace(-SIZE / 2, SIZE / 2, 5), atol=1e-6)
    # z of the sphere through the apex of center -1 / curvature, without its division.
    np.testing.assert_allclose(curvature * (x**2 + y**2 + z**2) + 2.0 * z, 0.0, atol=1e-7)
    assert (mirror.normals[:, 2] > 0.8).all()


def test_the_walk_through_flat_has_no_jump_in_the_image():
    images = [traced(one_mirror(curvature), (64, 48)) for curvature in (-1.2e-7, -0.8e-7, 0.0, 0.8e-7, 1.2e-7)]
    assert len({tuple(part.name for part in one_mirror(curvature).meshes) for curvature in (-2.0, 0.0, 2.0)}) == 1
    flat, bounces, _, names = images[2]
    looked = names == "mirror-1"
    assert looked.mean() > 0.2 and (bounces[looked] == 1).all()
    for records, _, _, other in images:
        assert (other == names).all()
        np.testing.assert_allclose(
            records[looked][:, [0, 1, 2, 4, 5, 6]], flat[looked][:, [0, 1, 2, 4, 5, 6]], atol=1e-6
        )


@pytest.mark.parametrize("curvature", [5.0, -4.5, np.inf, np.nan])
def test_a_mirror_more_curved_than_its_corners_allow_is_refused(curvature):
    with pytest.raises(AnamorphError, match=r"^curved mirror: curvature is [^\n]*; below 4.42/m [^\n]*$"):
        curved_mirror(curvature)


def test_the_series_is_the_papers_from_convex_over_flat_to_concave():
    assert (0.5, 1.0, 2.0, 6.0, np.inf, -6.0, -2.0, -1.0, -0.5) == RADII
    for number, radius in enumerate(RADII, start=1):
        mirror = mesh("curvature-series", f"mirror-{number}")
        assert len(mirror.positions) == 81
        if np.isinf(radius):
            assert isinstance(mirror.surface, Plane)
            continue
        assert isinstance(mirror.surface, Sphere) and mirror.surface.radius == pytest.approx(abs(radius))
        inward = np.einsum("vk,vk->v", mirror.normals, mirror.surface.center - mirror.positions) > 0
        assert (inward == (radius < 0)).all()


def test_concave_mirrors_show_things_nearer_than_their_convergence_and_a_reversed_room_beyond():
    view = scene("curvature-series")
    records, bounces, _, names = paths("curvature-series")
    rows = np.broadcast_to(np.arange(IMAGE[1])[:, None], names.shape)
    for number, radius in enumerate(RADII, start=1):
        mirror = mesh("curvature-series", f"mirror-{number}")
        once = (names == mirror.name) & (bounces == 1)
        assert once.mean() > 0.01
        distance = records[once][:, 11]
        eye = np.linalg.norm(mirror.positions[40] - np.asarray(view.camera.position))
        inverse = -2.0 / radius - 1.0 / eye
        convergence = 1.0 / inverse if inverse > 0 else np.inf
        far = distance > max(1.0, 0.0 if np.isinf(convergence) else 1.2 * convergence)
        assert far.mean() > 0.15, radius
        assert (radius in (-2.0, -1.0, -0.5)) == np.isfinite(convergence)
        assert (distance < 0.75 * convergence).mean() > 0.04, radius
        height = records[once][:, 1] + distance * records[once][:, 5]
        slope = np.polyfit(rows[once][far], height[far], 1)[0]
        assert (slope > 0) == np.isfinite(convergence), "lower in the image is higher in the room where it is reversed"


def test_saddle_and_cylinder_spread_their_rays_along_their_curved_way_which_is_oblique():
    eye = np.asarray(scene("saddle").camera.position)
    for part, sign, turn in (("saddle", -1.0, 30.0), ("cylinder", 0.0, -25.0)):
        mirror = mesh("saddle", part)
        surface = mirror.surface
        assert isinstance(surface, Toroid)
        assert surface.base_curvature > 0 and np.sign(surface.cross_curvature) == sign
        right, _, outward = np.asarray(surface.axes)
        level = np.cross((0.0, 1.0, 0.0), outward)
        assert np.degrees(np.arctan2(np.dot(np.cross(level, right), outward), level @ right)) == pytest.approx(turn)
        toward = mirror.positions - eye
        rays = reflect(toward / np.linalg.norm(toward, axis=1, keepdims=True), mirror.normals.astype(float))
        _, spread, ways = np.linalg.svd(rays - rays.mean(axis=0))
        assert spread[0] > 1.5 * spread[1]
        # On the image's side the way of the spread is that of the greatest curvature, within what the eye's own
        # nearness adds.
        assert abs(ways[0] @ right) > np.cos(np.radians(15.0))


def test_the_town_is_seen_in_a_window_directly_and_by_way_of_the_door_mirror():
    view = scene("car-windows")
    records, bounces, _, names = paths("car-windows")
    geometry = flatten(view)
    triangle = records.view(np.int32)[..., 3]
    ends = np.array(["sky", *(part.name.split("-")[0] for part in view.meshes)])[
        np.where(triangle < 0, 0, geometry.face_object[triangle])
    ]
    directly = np.char.startswith(names, "coming-") & (bounces == 1)
    assert directly.mean() > 0.08 and (ends[directly] == "house").mean() > 0.5
    mirror = names == "mirror"
    both = mirror & (bounces == 2)
    assert mirror.mean() > 0.15 and both.sum() > 0.03 * mirror.sum()
    assert {"house", "sky"} <= set(ends[both])


def test_panes_stand_clear_of_their_cars_everywhere():
    view = scene("car-windows")
    panes = [part for part in view.meshes if part.name.endswith("-window")]
    assert len(panes) == 4 and all(isinstance(part.material, Mirror) for part in panes)
    geometry = flatten(view)
    for pane in panes:
        # From each vertex inward the car's body is met soon, but not at once.
        start, inward = pane.positions.astype(float), -pane.normals.astype(float)
        hits = Caster(geometry).cast(start + 1e-4 * inward, inward)
        names = {view.meshes[number - 1].name for number in geometry.face_object[hits.triangle]}
        assert names == {pane.name.split("-")[0]}
        assert (hits.distance > 0.004).all() and (hits.distance < 0.05).all()


def test_facing_mirrors_are_followed_four_deep_and_more_but_never_to_the_limit():
    _, bounces, status, names = paths("facing-mirrors")
    assert (bounces >= 4).mean() > 0.04 and bounces.max() >= 7
    assert not (status == Status.OUTSIDE).any()
    assert set(names[bounces >= 2]) == {"mirror-far"}
    near, far = (mesh("facing-mirrors", part).normals[0].astype(float) for part in ("mirror-near", "mirror-far"))
    assert 1.0 < np.degrees(np.arccos(-near @ far)) < 6.0


def test_the_torus_is_closed_of_one_mesh_and_exact():
    ring = mesh("torus", "mirror")
    assert isinstance(ring.surface, NurbsSurface) and ring.parameters is not None
    _, index = np.unique(ring.positions + 0.0, axis=0, return_inverse=True)
    faces = index.reshape(-1)[ring.faces]
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    unique, uses = np.unique(edges, axis=0, return_counts=True)
    assert (uses == 2).all()
    assert index.max() + 1 - len(unique) + len(faces) == 0, "Euler's number of a torus"
    # Every point lies a tube's radius from the ring's middle line, by a formula that knows no splines.
    generator = np.random.default_rng(3)
    points = ring.surface.position(generator.uniform(0.0, 4.0, (200, 2)))
    middle = np.array([0.0, 0.94, 0.0])
    axis = np.array([0.55, 0.16, 0.86]) / np.linalg.norm([0.55, 0.16, 0.86])
    along = (points - middle) @ axis
    across = np.linalg.norm(points - middle - along[:, None] * axis, axis=1)
    np.testing.assert_allclose(np.hypot(across - MAJOR, along), MINOR, atol=1e-12)
    gap = ring.positions[:, 1].min() - mesh("torus", "foot").positions[:, 1].max()
    assert 0.0 < gap < 0.02
    edge = np.linalg.norm(np.diff(ring.positions.reshape(37, 97, 3)[0], axis=0), axis=1)
    assert np.ptp(edge) < 1e-5, "vertices are as far apart everywhere around the ring"


def test_the_torus_reflects_itself_and_every_traced_path_ends():
    _, bounces, status, names = paths("torus")
    ring = names == "mirror"
    assert ring.mean() > 0.12
    assert (bounces[ring] >= 2).mean() > 0.02
    assert not (status == Status.OUTSIDE).any()
