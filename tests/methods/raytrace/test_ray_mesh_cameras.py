"""Ray meshes as cameras: the image that the ray tracer makes of their rays, and its errors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import CAMERA, flat_mirror, open_view, scene_with, spherical_mirror, surroundings

import anamorph as an
from anamorph import gallery
from anamorph.base.errors import AnamorphError
from anamorph.base.steps import drain
from anamorph.frame import Status, View
from anamorph.measure.errors import counted, measure
from anamorph.methods import METHODS, Specification
from anamorph.methods.raytrace.pixel_rays import pixel_rays
from anamorph.methods.tracing.launch import GivenRays, eye_rays
from anamorph.methods.tracing.paths import PathTracer
from anamorph.optics.reflection import reflected_rays, reflector
from anamorph.raymesh import RayMesh
from anamorph.rays.caster import Caster
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Scene

SIZE = (80, 60)
QUAD = [[0, 1, 2], [0, 2, 3]]
DIFFUSE = Scene("diffuse", surroundings(), CAMERA)
"""No mirror."""


def ray_mesh(image, origins, directions, faces=QUAD):
    """By hand: places (V, 2) have w = 1."""
    image = np.asarray(image, float)
    if image.shape[1] == 2:
        image = np.column_stack([image, np.ones(len(image))])
    origins, directions = (np.broadcast_to(np.asarray(each, float), (len(image), 3)) for each in (origins, directions))
    return RayMesh(image, origins, directions, np.array(faces, np.int32), np.zeros(len(image), np.uint8))


def corners(size):
    width, height = size
    return np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])


def as_ray_mesh(camera, size, places=None, faces=QUAD):
    """A pinhole as rays that all have the same depth, which is affine in the image."""
    places = corners(size) if places is None else np.asarray(places, float)
    focal = size[1] / (2.0 * np.tan(np.radians(camera.field_of_view) / 2.0))
    across = (places - np.array(size) / 2.0) / focal * [1.0, -1.0]
    return ray_mesh(places, camera.position, np.column_stack([across, np.ones(len(places))]) @ camera.axes(), faces)


def seen_through(mesh, scene=DIFFUSE, size=None, **options):
    return an.render(scene, "raytrace", camera=mesh, size=size, seen=True, **options)


def assert_same(frame, other, share=0.999):
    """But for pixels whose centre is on an edge, which rounding decides."""
    same = frame.object_id == other.object_id
    assert same.mean() > share
    assert np.percentile(np.abs(frame.position - other.position)[same], 99.0) <= 2e-4
    # Where textures are fine, a rasterised and a traced pixel blur them a little differently.
    difference = np.abs(frame.color - other.color).max(axis=-1)
    assert np.percentile(difference, 90.0) <= 1e-3 and np.percentile(difference, 99.0) <= 2e-2
    assert difference.mean() <= 1e-3


@pytest.mark.parametrize("name", ["facing-mirrors", "spectacles-plus", "room", "deforming"])
def test_a_pinhole_as_a_ray_mesh_draws_the_cameras_frame(name):
    scene = gallery.make(name)
    frame = seen_through(as_ray_mesh(scene.camera, SIZE), scene)
    expected = an.render(scene, "raytrace", size=SIZE, seen=True)
    assert_same(frame, expected)
    assert (frame.specular == expected.specular).mean() > 0.999
    bent = (expected.specular > 0) & (frame.specular == expected.specular)
    if bent.any():
        assert np.percentile(np.abs(frame.position[bent] - expected.position[bent]), 99.5) <= 1e-5
        assert np.percentile(np.abs(frame.color[bent] - expected.color[bent]), 99.0) <= 1e-3
    assert set(np.unique(frame.status)) <= {Status.DIRECT, Status.SKY, Status.TRACED, Status.TOTAL_REFLECTION}
    alike = frame.object_id == expected.object_id
    assert frame.ray_direction[alike] == pytest.approx(expected.ray_direction[alike], abs=1e-5)
    assert frame.ray_origin[alike] == pytest.approx(expected.ray_origin[alike], abs=1e-4)


def test_a_projective_image_is_a_plane_in_the_world():
    # A quad across the view, at very different depths: its vertices' rays are linear on it, and not in the image.
    right, up, forward = CAMERA.axes()
    quad = np.asarray(CAMERA.position) + np.array(
        [forward - right + up, 5 * (forward + right + up), 5 * (forward + right - up), forward - right - up]
    )
    image = CAMERA.eye(SIZE).image(quad)
    mesh = ray_mesh(image, CAMERA.position, quad - CAMERA.position)
    frame = seen_through(mesh, size=SIZE)
    assert not (frame.status == Status.OUTSIDE).any()
    assert_same(frame, an.render(DIFFUSE, "raytrace", size=SIZE, seen=True))
    # As if it were affine, it shows something else.
    bent = replace(mesh, image=image / image[:, 2:])
    assert np.abs(seen_through(bent, size=SIZE).color - frame.color).mean() > 1e-3


def test_what_a_mesh_has_behind_the_eye_is_not_seen():
    ground = np.array([[-9.0, 0.0, 9.0], [9.0, 0.0, 9.0], [9.0, 0.0, -9.0], [-9.0, 0.0, -9.0]])
    camera = Camera((0.3, 1.0, 1.0), (0.0, 0.9, -1.0), field_of_view=60.0)
    mesh = ray_mesh(camera.eye(SIZE).image(ground), camera.position, ground - camera.position)
    assert mesh.image[:, 2].min() < 0.0 < mesh.image[:, 2].max()
    scene = replace(DIFFUSE, camera=camera)
    frame, expected = seen_through(mesh, scene, SIZE), an.render(scene, "raytrace", size=SIZE, seen=True)
    x, y = np.meshgrid(np.arange(80) + 0.5, np.arange(60) + 0.5)
    looks = camera.directions(np.stack([x, y], axis=-1), SIZE)
    meets = camera.position - looks / looks[..., 1:2] * camera.position[1]
    on_ground = (looks[..., 1] < 0.0) & (np.abs(meets[..., [0, 2]]) <= 9.0).all(axis=-1)
    assert ((frame.status != Status.OUTSIDE) == on_ground).all() and 0.2 < on_ground.mean() < 0.8
    same = on_ground & (frame.object_id == expected.object_id)
    assert same.sum() > 0.99 * on_ground.sum()
    assert frame.position[same] == pytest.approx(expected.position[same], abs=1e-3)
    with pytest.raises(AnamorphError, match="give the image's size"):
        seen_through(mesh, scene)


def test_a_mirrors_ray_mesh_alone_sees_what_the_mirror_shows():
    scene = scene_with(flat_mirror())
    expected = an.render(scene, "raytrace", size=SIZE, seen=True)
    mirrored = expected.specular == 1
    mesh = reflected_rays(reflector(scene.meshes[0]), CAMERA.eye(SIZE))
    frame = seen_through(mesh, DIFFUSE, SIZE)
    assert ((frame.status != Status.OUTSIDE) == mirrored).all()
    same = mirrored & (frame.object_id + (frame.object_id > 0) == expected.object_id)
    assert same.sum() >= 0.999 * mirrored.sum()
    assert frame.position[same] == pytest.approx(expected.position[same], abs=2e-5)
    assert not frame.specular.any()


def test_pixels_without_a_ray_are_black_and_outside():
    places = [[10.0, 10.0], [50.0, 10.0], [50.0, 40.0], [10.0, 40.0]]
    frame = seen_through(as_ray_mesh(CAMERA, SIZE, places))
    assert frame.color.shape == (40, 50, 3)
    inside = np.zeros((40, 50), bool)
    inside[10:, 10:] = True
    assert ((frame.status != Status.OUTSIDE) == inside).all()
    for buffer in (frame.color, frame.position, frame.object_id, frame.specular, frame.ray_origin, frame.ray_direction):
        assert np.isfinite(buffer).all() and not buffer[~inside].any()
    assert np.linalg.norm(frame.ray_direction[inside], axis=-1) == pytest.approx(1.0, abs=1e-6)
    whole = an.render(DIFFUSE, "raytrace", size=SIZE, seen=True)
    assert frame.position[inside] == pytest.approx(whole.position[:40, :50][inside], abs=1e-5)


def test_a_direction_that_vanishes_between_vertices_is_no_ray():
    up, toward = [0.0, 1.0, 0.0], [0.1, 0.2, -0.3]
    against = -np.array(toward)
    mesh = ray_mesh(corners((9, 6)), up, [toward, against, against, toward])
    origins, directions = pixel_rays(mesh, (9, 6)).reshape(2, 6, 9, 3)
    gone = ~directions.any(axis=-1)
    assert gone[:, 4].all() and gone.sum() == 6 and not origins[gone].any()
    frame = seen_through(mesh)
    assert ((frame.status == Status.OUTSIDE) == gone).all() and not frame.color[gone].any()
    # However small the others are.
    small = replace(mesh, directions=1e-9 * mesh.directions)
    assert (pixel_rays(small, (9, 6))[1].any(axis=-1) == ~gone.ravel()).all()


def test_directions_are_interpolated_as_long_as_they_are():
    mesh = ray_mesh(corners((8, 2)), [1.0, 2.0, 3.0], [[3, 0, 0], [0, 1, 0], [0, 1, 0], [3, 0, 0]])
    origins, directions = pixel_rays(mesh, (8, 2))
    across = (np.tile(np.arange(8), 2) + 0.5) / 8.0
    assert directions == pytest.approx(np.column_stack([3.0 - 3.0 * across, across, np.zeros(16)]), abs=1e-14)
    assert origins == pytest.approx(np.tile([1.0, 2.0, 3.0], (16, 1)))


def test_of_triangles_over_each_other_the_first_is_seen():
    places = [*corners((8, 6)), [2.0, 1.0], [6.0, 1.0], [6.0, 5.0], [2.0, 5.0]]
    origins = np.repeat([[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], 4, axis=0)
    above = ray_mesh(places, origins, [0.0, 0.0, 1.0], [[4, 5, 6], [4, 6, 7], *QUAD])
    expected = np.ones((6, 8))
    expected[1:5, 2:6] = 2.0
    assert pixel_rays(above, (8, 6))[0, :, 0].reshape(6, 8) == pytest.approx(expected)
    below = replace(above, faces=above.faces[[2, 3, 0, 1]])
    assert pixel_rays(below, (8, 6))[0, :, 0] == pytest.approx(1.0)


@st.composite
def triangulations(draw):
    """An image of 12 x 10 pixels: faces split at points inside or on their border, often at pixels' centres."""
    places, faces = [tuple(place) for place in corners((12, 10))], [(0, 1, 2), (0, 2, 3)]
    for _ in range(draw(st.integers(0, 25))):
        a, b, c = faces.pop(draw(st.integers(0, len(faces) - 1)))
        parts = draw(st.tuples(*3 * [st.integers(0, 4) | st.floats(0.0, 1.0)]).filter(any))
        place = np.array(parts) @ np.array([places[a], places[b], places[c]]) / sum(parts)
        if draw(st.booleans()):
            place = np.floor(place) + 0.5
            ends = np.array([places[a], places[b], places[c]]) - place
            sides = ends[:, 0] * np.roll(ends, -1, axis=0)[:, 1] - ends[:, 1] * np.roll(ends, -1, axis=0)[:, 0]
            if min(sides) < 0.0:
                place = np.array(places[a])
        places.append(tuple(place))
        new = len(places) - 1
        faces += [(a, b, new), (b, c, new), (c, a, new)]
    order = draw(st.permutations(range(len(faces))))
    turned = draw(st.lists(st.booleans(), min_size=len(faces), max_size=len(faces)))
    faces = [faces[i][::-1] if turn else faces[i] for i, turn in zip(order, turned, strict=True)]
    weights = draw(st.lists(st.sampled_from([1.0, 1.0, 0.3, 7.0]), min_size=len(places), max_size=len(places)))
    shift = draw(st.tuples(*2 * [st.sampled_from([0.0, 0.25, -0.5, 0.5, 1.0 / 3.0])]))
    return np.array(places), np.array(faces), np.array(weights), shift


@settings(max_examples=150)
@given(triangulations())
def test_no_pixel_inside_is_left_out(drawn):
    places, faces, weights, shift = drawn
    image = np.column_stack([places, np.ones(len(places))]) * weights[:, None]
    # Directions that are their own homogeneous images become the pixels' own places, whatever the triangle.
    mesh = ray_mesh(image, [0.0, 0.0, 0.0], image, faces)
    x, y = np.meshgrid(np.arange(12) + 0.5 + shift[0], np.arange(10) + 0.5 + shift[1])
    directions = pixel_rays(mesh, (12, 10), shift)[1].reshape(10, 12, 3)
    inside = (x >= 0) & (x <= 12) & (y >= 0) & (y <= 10)
    assert (directions.any(axis=-1) == inside).all()
    found = directions[inside]
    assert found[:, :2] / found[:, 2:] == pytest.approx(np.stack([x, y], axis=-1)[inside], abs=1e-5)


def test_samples_average_shifted_rays():
    mesh = as_ray_mesh(CAMERA, SIZE)
    session = Specification.parse("raytrace").open(View(DIFFUSE, mesh, SIZE))
    colors = []
    for shift in [(-0.25, -0.25), (0.25, -0.25), (-0.25, 0.25), (0.25, 0.25)]:
        session.draw(mesh, shift)
        colors.append(session.frame().color)
    frame = seen_through(mesh, samples=2)
    assert frame.color == pytest.approx(np.mean(colors, axis=0), abs=1e-6)
    expected = an.render(DIFFUSE, "raytrace", size=SIZE, samples=2, seen=True)
    assert np.percentile(np.abs(frame.color - expected.color), 98.0) <= 1e-2
    single = seen_through(mesh)
    assert (frame.position == single.position).all() and (frame.color != single.color).any()


def test_a_session_follows_meshes_and_a_deforming_scene():
    mesh, other = as_ray_mesh(CAMERA, SIZE), as_ray_mesh(replace(CAMERA, position=(0.1, 0.8, 0.7)), SIZE)
    scene = scene_with(spherical_mirror())
    session = Specification.parse("raytrace").open(View(scene, mesh, SIZE))
    session.draw(mesh)
    first = session.frame(seen=True)
    session.draw(other)
    assert (session.frame(seen=True).position == seen_through(other, scene).position).all()
    geometry = flatten(scene)
    moved = geometry.positions.copy()
    diffuse = slice(int(geometry.first_vertex[1]), None)
    moved[diffuse] += np.float32([0.05, 0.1, 0.0])
    session.deform(moved, geometry.normals)
    session.draw(mesh)
    frame = session.frame(seen=True)
    meshes = [replace(each, positions=each.positions + np.float32([0.05, 0.1, 0.0])) for each in scene.meshes[1:]]
    expected = seen_through(mesh, replace(scene, meshes=(scene.meshes[0], *meshes)))
    assert (frame.object_id == expected.object_id).mean() > 0.999
    assert np.percentile(np.abs(frame.position - expected.position), 99.0) <= 1e-5
    assert (frame.object_id != first.object_id).mean() > 0.02
    with pytest.raises(AnamorphError, match="another kind"):
        session.draw(CAMERA)
    with pytest.raises(AnamorphError, match="another kind"):
        open_view(scene, "raytrace", SIZE).draw(mesh)


def test_what_lies_behind_the_origins_is_not_seen():
    mesh = as_ray_mesh(CAMERA, SIZE)
    whole = seen_through(mesh)
    far = replace(mesh, origins=mesh.origins + 3.0 * np.asarray(mesh.directions))
    beyond = seen_through(far)
    depth = (whole.position - CAMERA.position) @ CAMERA.axes()[2]
    hidden = (whole.object_id > 0) & (depth < 2.99)
    stays = (whole.object_id > 0) & (depth > 3.01)
    assert hidden.any() and stays.any()
    assert (beyond.object_id[stays] == whole.object_id[stays]).all()
    seen = hidden & (beyond.object_id > 0)
    assert ((beyond.position[seen] - CAMERA.position) @ CAMERA.axes()[2] > 2.99).all()


def test_the_scene_itself_is_not_drawn(monkeypatch):
    monkeypatch.setattr("anamorph.methods.session.draw_scene", None)
    assert seen_through(as_ray_mesh(CAMERA, SIZE)).object_id.any()


def test_given_rays_are_traced_like_the_eyes():
    scene = scene_with(spherical_mirror())
    geometry = flatten(scene)
    tracer = PathTracer(scene, geometry, Caster(geometry))
    x, y = np.meshgrid(np.arange(80) + 0.5, np.arange(60) + 0.5)
    looks = CAMERA.directions(np.stack([x.ravel(), y.ravel()], axis=-1), SIZE)
    looks[7] = 0.0
    records = drain(tracer.tracing(GivenRays(np.tile(CAMERA.position, (4800, 1)), 3.0 * looks)))
    expected = drain(tracer.tracing(eye_rays(CAMERA, SIZE)))
    rest = np.arange(4800) != 7
    assert (records.view(np.uint32)[rest][:, [3, 7]] == expected.view(np.uint32)[rest][:, [3, 7]]).mean() > 0.999
    words = records[7].view(np.uint32)
    assert words[3] == 0xFFFFFFFF and words[7] == Status.OUTSIDE << 16 and np.isinf(records[7, 11])
    assert not records[7, [0, 1, 2, 4, 5, 6, 8, 9, 10]].any()


def test_scenes_without_mirror_and_with_the_eye_behind_one_are_accepted():
    mesh = as_ray_mesh(CAMERA, SIZE)
    behind = Camera((0.0, 0.5, -2.0), (0.0, 0.5, 0.0))
    scene = scene_with(flat_mirror(), camera=behind)
    with pytest.raises(AnamorphError, match="behind the mirror"):
        an.render(scene, "raytrace", size=SIZE)
    assert_same(seen_through(mesh, scene), an.render(scene, "raytrace", camera=CAMERA, size=SIZE, seen=True))


def test_the_size_is_the_least_that_holds_the_image():
    for farthest, size in [((7.2, 3.0), (8, 3)), ((7.0 + 1e-12, 3.0), (7, 3)), ((0.2, 0.1), (1, 1))]:
        mesh = ray_mesh([[-5.0, -5.0], [farthest[0], 0.0], [0.0, farthest[1]], [99.0, 99.0]], 0.0, 1.0, [[0, 1, 2]])
        assert mesh.least_size() == size
    assert seen_through(as_ray_mesh(CAMERA, SIZE)).color.shape == (60, 80, 3)
    assert seen_through(as_ray_mesh(CAMERA, SIZE), size=(20, 90)).color.shape == (90, 20, 3)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"image": np.full((4, 3), np.nan)}, "image have NaN"),
        ({"image": np.ones((4, 2))}, r"image are \(4, 2\)"),
        ({"image": np.ones((4, 3))}, "points or lines"),
        ({"image": [[0, 0, -1], [8, 0, -1], [8, 6, -1], [0, 6, 0]]}, "all its image is behind"),
        ({"image": [[0, 0, 1], [-8, 0, 1], [-8, 6, 1], [0, 6, 1]]}, "top left corner"),
        ({"origins": np.full((4, 3), np.inf)}, "origins have NaN"),
        ({"origins": np.full((4, 3), 1e13)}, "beyond 1e.12"),
        ({"origins": np.zeros((3, 3))}, r"origins are \(3, 3\)"),
        ({"origins": np.full((4, 3), "a")}, "origins are"),
        ({"directions": np.zeros((4, 3))}, "direction of vertex 0 has no length"),
        ({"directions": np.eye(4)[:, :3]}, "direction of vertex 3 has no length"),
        ({"faces": np.array([[0, 1, 4]])}, "vertex 4, but there are 4"),
        ({"faces": np.array([[0, 1, -1]])}, "vertex -1"),
        ({"faces": np.zeros((0, 3), int)}, "at least one"),
        ({"faces": np.zeros((2, 3))}, "faces are"),
        ({"status": np.zeros(3, np.uint8)}, "status has shape"),
    ],
)
def test_a_ray_mesh_that_cannot_be_seen_through_is_refused_in_one_line(changes, words):
    arrays = {name: np.asarray(values) for name, values in changes.items()}
    with pytest.raises(AnamorphError, match=words) as told:
        an.render(DIFFUSE, "raytrace", camera=replace(as_ray_mesh(CAMERA, (8, 6)), **arrays))
    assert str(told.value).startswith("camera: ") and "\n" not in str(told.value)


def test_what_cannot_see_through_a_ray_mesh_says_what_can():
    mesh = as_ray_mesh(CAMERA, SIZE)
    for name in [name for name, method in METHODS.items() if not method.ray_meshes]:
        with pytest.raises(AnamorphError, match=f"camera: {name} cannot see through a ray mesh; give .*raytrace"):
            an.render(DIFFUSE, name, camera=mesh)
    with pytest.raises(AnamorphError, match="needs a pinhole"):
        _ = View(DIFFUSE, mesh, SIZE).pinhole_camera
    with pytest.raises(AnamorphError, match="give truth=surface"):
        seen_through(mesh, truth="raymesh")
    with pytest.raises(AnamorphError, match="size 0x60"):
        seen_through(mesh, size=(0, 60))


def test_all_pixels_with_a_ray_are_measured():
    places = corners(SIZE) * 0.75
    mesh = as_ray_mesh(CAMERA, SIZE, places)
    reference = seen_through(mesh, size=SIZE)
    covered = reference.status != Status.OUTSIDE
    assert reference.ray_mesh and (counted(reference) == covered).all() and not covered.all()
    nothing = measure(reference, reference)
    assert nothing.pixels.max < 0.02 and nothing.other_object_percent == 0.0 and nothing.rmse == 0.0
    assert (nothing.maps.specular == covered).all()
    # The border of the mesh is a silhouette, and so is a box's before the floor.
    assert nothing.maps.silhouette[:45, 59].all() and nothing.maps.silhouette[:44, :58].any()
    assert not nothing.maps.silhouette[~covered].any() and nothing.silhouette_percent < 40.0

    moved = replace(mesh, image=mesh.image + np.array([0.1, 0.0, 0.0]))
    errors = measure(reference, seen_through(moved, size=SIZE))
    assert errors.pixels.median == pytest.approx(0.1, rel=0.02)
    assert errors.other_object_percent == 0.0

    # Where the truth sees something, and be it the sky, a frame that shows nothing is wrong.
    blank = {name: np.zeros_like(getattr(reference, name)) for name in ("position", "object_id")}
    lost = measure(reference, replace(reference, **blank))
    assert lost.other_object_percent == 100.0
    assert lost.angular_mrad.median > 1.0
    sky = covered & (reference.object_id == 0) & ~lost.maps.silhouette
    assert sky.any() and (lost.maps.angular[sky] == pytest.approx(1000.0 * np.pi))


def test_frames_of_a_pinhole_are_measured_as_before():
    scene = scene_with(spherical_mirror())
    reference = an.render(scene, "raytrace", size=SIZE, seen=True)
    assert not reference.ray_mesh and (counted(reference) == (reference.specular == 1)).all()
    through = seen_through(as_ray_mesh(CAMERA, SIZE), scene)
    assert measure(reference, through).pixels.p95 < 0.01
    assert counted(through).all()
