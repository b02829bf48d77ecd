"""Dividing ray meshes into patches: every face in one, each within its cone; and which faces may be seen at all."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plans import planned
from scenes import CAMERA, CENTER, SIZE, flat_mirror, scene_with, spherical_mirror

from anamorph.gallery.solids import box, icosphere
from anamorph.methods.pervertex.division import MOST_PATCHES, divide, longest_extent, seen_faces
from anamorph.optics.reflection import reflected_rays, reflector
from anamorph.raymesh import RayMesh, RayStatus
from anamorph.scene.camera import Camera

SEEDS = st.integers(0, 2**32 - 1)


def ray_mesh(directions, faces, status=None, image=None):
    count = len(directions)
    return RayMesh(
        np.ones((count, 3)) if image is None else np.asarray(image, float),
        np.zeros((count, 3)),
        np.asarray(directions, float),
        np.asarray(faces),
        np.zeros(count, np.uint8) if status is None else np.asarray(status, np.uint8),
    )


@st.composite
def bundles(draw):
    """Rays that spread narrowly, widely, to all sides, or to two opposite ones, with some that turn their backs."""
    generator = np.random.default_rng(draw(SEEDS))
    count, scatter = draw(st.integers(3, 120)), draw(st.sampled_from([0.0, 1e-3, 0.3, 2.0, 1e6]))
    axis = generator.normal(size=3)
    directions = axis / np.linalg.norm(axis) + scatter * generator.normal(size=(count, 3))
    if draw(st.booleans()):
        directions[::2] *= -1.0
    faces = generator.integers(0, count, (draw(st.integers(1, 150)), 3))
    status = generator.choice([RayStatus.OK, RayStatus.BACK_FACING], count, p=[0.8, 0.2])
    return generator, ray_mesh(directions * generator.uniform(0.1, 9.0, (count, 1)), faces, status)


def mean_directions(rays):
    """Each face's, of its vertices that face the eye: written with no use of the product's own."""
    unit, means = rays.directions / np.linalg.norm(rays.directions, axis=1, keepdims=True), []
    for face in rays.faces:
        facing = [vertex for vertex in face if rays.status[vertex] == RayStatus.OK]
        mean = unit[facing or list(face)].sum(axis=0)
        means.append(mean / max(np.linalg.norm(mean), 1e-12))
    return np.array(means)


@given(bundles(), st.sampled_from([10.0, 60.0, 100.0, 150.0]))
def test_every_face_is_in_one_patch_and_every_patch_in_its_cone(drawn, degrees):
    generator, rays = drawn
    faces = np.flatnonzero(generator.uniform(size=len(rays.faces)) < 0.8)
    patches = divide(rays, faces, np.radians(degrees))
    assert sorted(np.concatenate([*patches, []]).astype(int)) == faces.tolist()
    assert all(len(patch) for patch in patches) and len(patches) <= MOST_PATCHES
    means = mean_directions(rays)
    for patch in patches if len(patches) < MOST_PATCHES else ():
        # The cone's axis is a face's own direction, or that of the whole bundle.
        whole = means[patch].sum(axis=0)
        axes = np.stack([*means[patch], whole / (np.linalg.norm(whole) or 1.0)])
        widest = np.degrees(np.arccos(np.clip(means[patch] @ axes.T, -1.0, 1.0))).max(axis=0).min()
        # A face whose directions cancel out has none to be near to.
        assert widest <= 0.5 * degrees + 1.0 or (np.linalg.norm(means[patch], axis=1) < 0.9).any()


WALLS = box((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))


@pytest.mark.parametrize(("directions", "faces"), [icosphere(2), (WALLS.normals.astype(float), WALLS.faces)])
def test_rays_to_all_sides_alike_are_divided_one_way_whatever_the_last_digit(directions, faces):
    patches = divide(ray_mesh(directions, faces), np.arange(len(faces)), np.radians(100.0))
    assert len(patches) > 3
    for last_digit in 1e-15 * np.random.default_rng(1).normal(size=(40, *directions.shape)):
        again = divide(ray_mesh(directions + last_digit, faces), np.arange(len(faces)), np.radians(100.0))
        assert [patch.tolist() for patch in again] == [patch.tolist() for patch in patches]


@pytest.mark.parametrize(
    ("sides", "longest"),
    [((1, 1, 1), (1, 0, 0)), ((1, 2, 2), (0, 1, 0)), ((2, 1, 2), (1, 0, 0)), ((1, 1, 2), (0, 0, 1))],
)
def test_of_equal_extents_one_is_the_longest_whatever_the_last_digit(sides, longest):
    corners = np.stack(np.meshgrid([-1, 1], [-1, 1], [-1, 1]), axis=-1).reshape(-1, 3) * np.array(sides, float)
    for last_digit in 1e-15 * np.random.default_rng(1).normal(size=(40, 8, 3)):
        assert np.abs(longest_extent(corners + last_digit)) == pytest.approx(longest, abs=1e-9)


@given(SEEDS, st.floats(1.0, 150.0))
def test_a_bundle_within_the_cone_is_one_patch(seed, degrees):
    generator = np.random.default_rng(seed)
    axis = generator.normal(size=3)
    axis /= np.linalg.norm(axis)
    # Within half of the half angle about some axis, so that it is within the half angle about the mean as well.
    across = np.cross(generator.normal(size=(60, 3)), axis)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    angle = np.radians(0.245 * degrees) * generator.uniform(size=(60, 1))
    rays = ray_mesh(np.cos(angle) * axis + np.sin(angle) * across, generator.integers(0, 60, (40, 3)))
    (patch,) = divide(rays, np.arange(40), np.radians(degrees))
    assert patch.tolist() == list(range(40))


def test_no_faces_are_no_patches():
    assert divide(ray_mesh(np.eye(3), [[0, 1, 2]]), np.zeros(0, int), 1.0) == []


def test_rays_to_all_sides_need_no_more_cones_than_twice_as_many_of_half_the_width():
    """The whole sphere: its covering by caps of 50 degrees takes at least 6, by caps of 25 at least 21."""
    points, faces = icosphere(3)
    counts = [len(divide(ray_mesh(points, faces), np.arange(len(faces)), np.radians(w))) for w in (100.0, 150.0)]
    assert 6 <= counts[0] <= 21
    assert 3 <= counts[1] <= 9


def test_a_narrow_mirror_is_one_patch_and_a_ball_several():
    assert len(planned(scene_with(flat_mirror())).patches) == 1
    assert len(planned(scene_with(spherical_mirror())).patches) == 1
    ball = spherical_mirror(0.25, 24, (0.24, 0.24))
    found = planned(scene_with(ball))
    assert 2 <= len(found.patches) <= 16
    assert all(plan is not None for plan in found.plans)


def test_patches_show_the_same_at_the_vertices_that_they_share():
    """The image is continuous where patches meet: a vertex' ray hits the same in all the maps that show it."""
    found = planned(scene_with(spherical_mirror(0.25, 24, (0.24, 0.24))))
    hits, shared = {}, 0
    for plan in found.plans:
        for vertex, hit, valid in zip(plan.vertices, plan.hits, plan.lookups[0, :, 3], strict=True):
            if not valid or found.body_rays.rays.status[vertex]:
                continue
            shared += vertex in hits
            assert hit == pytest.approx(hits.setdefault(vertex, hit), rel=1e-4, abs=1e-4)
    assert shared > 10


def image_mesh(places, status=(0, 0, 0)):
    """One face with homogeneous places in an image of 160 x 120."""
    return ray_mesh(np.eye(3), [[0, 1, 2]], status, places)


@pytest.mark.parametrize(
    ("places", "seen"),
    [
        ([(10, 10, 1), (50, 10, 1), (10, 50, 1)], True),
        ([(-9, -9, 1), (400, -9, 1), (-9, 400, 1)], True),
        ([(-9, 10, 1), (-50, 10, 1), (-9, 50, 1)], False),
        ([(170, 10, 1), (190, 10, 1), (161, 50, 1)], False),
        ([(10, -10, 1), (50, -10, 1), (10, -50, 1)], False),
        ([(10, 130, 1), (50, 125, 1), (10, 121, 1)], False),
        ([(-10, -10, -1), (-50, -10, -1), (-10, -50, -1)], False),
        # Two vertices behind the eye: what is before it may be seen.
        ([(10, 10, 1), (-50, -10, -1), (-10, -50, -1)], True),
        # Homogeneous: 20 / 0.1 is to the right of the image.
        ([(20, 1, 0.1), (30, 1, 0.1), (20, 2, 0.1)], False),
    ],
)
def test_what_is_outside_the_image_is_not_seen(places, seen):
    assert (len(seen_faces(image_mesh(places), SIZE)) == 1) is seen


@pytest.mark.parametrize(
    ("status", "seen"),
    [((1, 1, 1), False), ((1, 0, 1), True), ((2, 1, 1), True), ((3, 3, 3), True)],
)
def test_a_face_is_seen_where_some_vertex_faces_the_eye(status, seen):
    inside = [(10, 10, 1), (50, 10, 1), (10, 50, 1)]
    assert (len(seen_faces(image_mesh(inside, status), SIZE)) == 1) is seen


@given(SEEDS, st.floats(0.01, 3.0))
def test_no_face_is_lost_of_which_some_point_is_in_the_image(seed, distance):
    generator = np.random.default_rng(seed)
    mirror = reflector(spherical_mirror(generator.choice([-0.5, 0.5, 1.4])))
    position = CENTER + distance * generator.normal(size=3)
    camera = Camera(
        tuple(position.tolist()), tuple((CENTER + 0.3 * generator.normal(size=3)).tolist()), CAMERA.up, 30.0
    )
    rays = reflected_rays(mirror, camera.eye(SIZE))
    kept = seen_faces(rays, SIZE)
    weights = generator.dirichlet(np.ones(3), 50)
    x, y, w = np.moveaxis(np.einsum("pk,fki->fpi", weights, rays.image[rays.faces]), -1, 0)
    inside = (w > 0.0) & (x >= 0.0) & (x <= SIZE[0] * w) & (y >= 0.0) & (y <= SIZE[1] * w)
    facing = (rays.status[rays.faces] == RayStatus.OK).any(axis=1)
    assert set(np.flatnonzero(inside.any(axis=1) & facing)) <= set(kept.tolist())
