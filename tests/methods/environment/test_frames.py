"""Environment mapping: exact for what is far away and at its own centre, and no more than it claims elsewhere."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import CAMERA, CENTER, SIZE, drawn, flat_mirror, open_view, scene_with, sky_scene, spherical_mirror

from anamorph import gallery
from anamorph.base.errors import AnamorphError
from anamorph.frame import Status
from anamorph.gallery.solids import icosphere
from anamorph.gpu import targets
from anamorph.measure.errors import measure, silhouettes
from anamorph.methods.environment import cube_map
from anamorph.methods.environment.cube_map import FACES, cube_projections
from anamorph.methods.environment.environment import faces_needed
from anamorph.optics.ray_meshes import bodies_of
from anamorph.optics.reflection import reflected_rays, reflector
from anamorph.rays.caster import Caster
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Diffuse, Mesh, Mirror, Scene, Sky, Texture

SEEDS = st.integers(0, 2**32 - 1)


def smooth_sky():
    """An image of slow waves in u and v, so that no filter shows."""
    v, u = (np.indices((128, 256)) + 0.5) / np.array([128, 256])[:, None, None]
    waves = [np.sin(2 * np.pi * u + phase) * np.sin(np.pi * v) for phase in (0.0, 2.0, 4.0)]
    pixels = np.full((128, 256, 4), 255, np.uint8)
    pixels[..., :3] = np.rint(128 + 100 * np.stack(waves, axis=-1))
    return Sky(image=Texture(pixels))


def plain(mesh):
    """The mesh without its exact surface: both methods then use interpolated normals."""
    return replace(mesh, surface=None, parameters=None)


def ball(radius=0.25, subdivisions=4):
    points, faces = icosphere(subdivisions)
    positions = (CENTER + radius * points).astype(np.float32)
    return Mesh("mirror", positions, faces.astype(np.int32), points.astype(np.float32), Mirror(reflectance=1.0))


@pytest.mark.parametrize("mirror", [plain(spherical_mirror()), plain(flat_mirror()), ball()])
@pytest.mark.parametrize("sky", [Sky(), smooth_sky()])
def test_it_is_exact_for_a_scene_at_infinity(mirror, sky):
    scene = sky_scene(mirror, sky)
    reference, frame = drawn(scene, "raytrace"), drawn(scene, "environment:face=1024")
    looks = (reference.specular == 1) & (frame.specular == 1)
    assert looks.sum() > 3000
    assert (frame.status[looks] == Status.SKY).all()
    inside = looks & ~silhouettes(reference.specular)
    assert np.abs(frame.position - reference.position)[inside].max() <= 2e-5
    difference = np.abs(frame.color - reference.color)[inside].max(axis=-1)
    assert np.percentile(difference, 98) <= 5e-3
    assert difference.max() <= 0.05


def test_a_ball_sees_what_is_seen_from_its_centre_in_the_reflected_direction():
    """Every direction, faces and seams alike, against casting in float64; the other mirror is left out."""
    scene = gallery.make("spheres")
    scene = replace(scene, meshes=tuple(mesh for mesh in scene.meshes if mesh.name != "mirror-flat"))
    ball_mesh = scene.meshes[0]
    others = flatten(replace(scene, meshes=scene.meshes[1:]))
    caster = Caster(others)
    covered = set()
    for position in [(0.35, 1.25, 4.2), (0.5, 3.5, -1.0), (-2.5, 0.9, 0.4), (0.3, 0.3, -3.0)]:
        camera = Camera(position, (0.0, 0.62, 0.0), field_of_view=25.0)
        frame = drawn(scene, "environment:face=512", (200, 200), camera)
        looks = frame.specular == 1
        rows, columns = np.nonzero(looks)
        views = camera.directions(np.stack([columns + 0.5, rows + 0.5], axis=-1), (200, 200))
        # The mesh's point and interpolated normal, by casting at it alone.
        geometry = flatten(replace(scene, meshes=(ball_mesh,)))
        hits = Caster(geometry).cast(np.tile(position, (len(views), 1)), views)
        found = hits.triangle >= 0
        corners = geometry.faces[hits.triangle[found]]
        weights = np.column_stack([1.0 - hits.barycentric.sum(axis=1), hits.barycentric])[found]
        normals = np.einsum("ni,nij->nj", weights, geometry.normals[corners].astype(float))
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        incident = views[found]
        reflected = incident - 2.0 * np.sum(incident * normals, axis=1, keepdims=True) * normals
        expected = caster.cast(np.tile([0.0, 0.62, 0.0], (len(reflected), 1)), reflected)
        covered |= set(face_of(reflected).tolist())

        seen, numbers = frame.position[looks][found], frame.object_id[looks][found]
        expected_number = np.where(expected.triangle >= 0, others.face_object[expected.triangle] + 1, 0)
        agree = numbers == expected_number
        assert agree.mean() > 0.97
        sky = agree & (numbers == 0)
        assert np.abs(seen[sky] - reflected[sky]).max() < 5e-4
        solid = agree & (numbers != 0)
        points = np.array([0.0, 0.62, 0.0]) + expected.distance[solid, None] * reflected[solid]
        error = np.linalg.norm(seen[solid] - points, axis=1) / expected.distance[solid]
        assert np.percentile(error, 98) < 1e-3
    assert covered == set(range(6)), "some face of the cube was never looked at"


def test_colours_join_without_seams_between_faces():
    """Under a smooth sky no pixel of a ball differs from its neighbour by more than its neighbourhood does."""
    scene = sky_scene(ball(), smooth_sky(), Camera((0.0, 0.5, 1.2), tuple(CENTER.tolist()), field_of_view=24.0))
    frame, reference = (drawn(scene, name, (240, 240)) for name in ("environment:face=64", "raytrace"))
    inside = (reference.specular == 1) & ~silhouettes(reference.specular)
    assert np.abs(frame.color - reference.color)[inside].max() <= 0.02


def test_faces_are_oriented_as_webgpu_has_them():
    """The corner texel of each face looks where the standard's table says: s to the right, t down."""
    table = [  # major axis, s, t
        ((1, 0, 0), (0, 0, -1), (0, -1, 0)),
        ((-1, 0, 0), (0, 0, 1), (0, -1, 0)),
        ((0, 1, 0), (1, 0, 0), (0, 0, 1)),
        ((0, -1, 0), (1, 0, 0), (0, 0, -1)),
        ((0, 0, 1), (1, 0, 0), (0, -1, 0)),
        ((0, 0, -1), (-1, 0, 0), (0, -1, 0)),
    ]
    for (right, up, forward), projection, (major, s, t) in zip(
        FACES, cube_projections(np.zeros(3), 0.1), table, strict=True
    ):
        assert forward == major
        look = projection.base - projection.right + projection.up
        assert look == pytest.approx(np.array(major, float) - s - t)
        assert (right == s) and (tuple(-np.array(up)) == t)


def face_of(directions):
    axis = np.abs(directions).argmax(axis=-1)
    return 2 * axis + (np.take_along_axis(directions, axis[..., None], -1)[..., 0] < 0)


@settings(max_examples=60)
@given(SEEDS, st.sampled_from([-0.6, 0.5, 1.4, 20.0]), st.sampled_from([1, 3, 8]), st.floats(0.02, 3.0))
def test_the_faces_needed_hold_every_direction_inside_the_triangles(seed, radius, count, distance):
    generator = np.random.default_rng(seed)
    mesh = spherical_mirror(radius, count)
    rotation = np.linalg.qr(generator.normal(size=(3, 3)))[0]
    rotation[2] *= np.linalg.det(rotation)
    mesh = plain(replace(mesh, positions=mesh.positions @ rotation.T, normals=mesh.normals @ rotation.T))
    toward = generator.normal(size=3) * [0.5, 0.5, 0.0] + [0.0, 0.0, 1.0]
    eye = rotation @ (CENTER + distance * toward / np.linalg.norm(toward))
    camera = Camera(tuple(eye.tolist()), tuple((rotation @ CENTER).tolist()), tuple(rotation[:, 1].tolist()))
    rays = reflected_rays(reflector(mesh), camera.eye(SIZE))
    needed = set(faces_needed(rays))
    # What the shader looks up: reflected at interpolated normals, on the triangles that face the eye.
    weights = generator.dirichlet(np.ones(3) * 0.7, 200)
    corners, normals = (np.asarray(each, float)[mesh.faces] for each in (mesh.positions, mesh.normals))
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    front = np.einsum("fi,fi->f", area, eye - corners[:, 0]) > 0.0
    points = np.einsum("wk,fki->fwi", weights, corners[front]).reshape(-1, 3)
    normal = np.einsum("wk,fki->fwi", weights, normals[front]).reshape(-1, 3)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    incident = points - eye
    directions = incident - 2.0 * np.sum(incident * normal, axis=1, keepdims=True) * normal
    assert set(face_of(directions)) <= needed


def test_a_narrow_bundle_needs_few_faces():
    camera = Camera((0.0, 0.5, 2.0), (0.0, 0.5, 0.0))
    assert faces_needed(reflected_rays(reflector(flat_mirror()), camera.eye(SIZE))) == [4]


def test_a_bundle_that_ends_beside_an_edge_needs_the_face_beyond_it():
    for degrees, needed in ((41.0, [4]), (43.0, [0, 4]), (47.0, [0, 4]), (49.0, [0])):
        turn = np.radians(degrees / 2.0)
        toward = np.array([np.sin(turn), 0.0, np.cos(turn)])
        mirror = replace(plain(flat_mirror()), normals=np.tile(toward, (4, 1)).astype(np.float32))
        far = Camera(tuple(np.add(CENTER, (0.0, 0.0, 1e4)).tolist()), tuple(CENTER.tolist()))
        assert faces_needed(reflected_rays(reflector(mirror), far.eye(SIZE))) == needed


def test_cube_faces_share_their_depth_buffer_and_make_their_depths_on_first_use(monkeypatch):
    made = []

    def counted(size, form, *arguments, **named):
        made.append(form)
        return targets.make_texture(size, form, *arguments, **named)

    monkeypatch.setattr(cube_map, "make_texture", counted)
    monkeypatch.setattr(cube_map, "stand_in", lambda: targets.make_texture((1, 1), "rgba32float"))
    made_now = cube_map.CubeMap(np.zeros(3), 8, 0.1)
    assert sorted(made) == ["depth32float", "rgba16float"]
    assert len({id(face.textures[0]) for face in made_now.colors}) == 1
    assert {id(face.textures[0]) for face in made_now.depths} == {id(made_now.depths[3].textures[0])}
    assert made.count("rgba32float") == 1 and made.count("depth32float") == 1


def test_drawn_once_is_drawn_always_while_nothing_moves():
    scene = scene_with(spherical_mirror())
    once, always = drawn(scene, "environment:update=once"), drawn(scene, "environment")
    for name in ("color", "position", "object_id", "specular", "status"):
        assert (getattr(once, name) == getattr(always, name)).all()


def test_drawn_once_has_all_faces_for_an_eye_that_moves_later():
    scene = scene_with(ball())
    session = open_view(scene, "environment:update=once,face=256")
    session.draw(CAMERA)
    moved = Camera((-0.9, 0.4, -0.6), tuple(CENTER.tolist()), field_of_view=40.0)
    session.draw(moved)
    assert (session.frame().color == drawn(scene, "environment:face=256", camera=moved).color).all()


@pytest.mark.parametrize(("update", "frames_with_maps"), [("once", 1), ("always", 3)])
def test_a_static_map_is_drawn_in_the_first_frame_alone(update, frames_with_maps, monkeypatch):
    calls, counts, draw_color = [], [0], cube_map.CubeMap.draw_color
    monkeypatch.setattr(cube_map.CubeMap, "draw_color", lambda *given: (calls.extend(given[-1]), draw_color(*given))[1])
    session = open_view(scene_with(spherical_mirror()), f"environment:update={update},face=64")
    for _ in range(3):
        session.draw(CAMERA)
        counts.append(len(calls))
    assert np.count_nonzero(np.diff(counts)) == frames_with_maps


def test_meshes_of_one_reflector_share_a_map():
    upper, lower = (replace(spherical_mirror(), name=f"pot/{part}") for part in ("upper", "lower"))
    other = replace(flat_mirror(), name="pan")
    scene = Scene("parts", (upper, other, lower, replace(flat_mirror(), name="x", material=Diffuse())), CAMERA)
    assert [body.meshes for body in bodies_of(scene, flatten(scene))] == [(0, 2), (1,)]


def test_planar_is_exact_for_a_flat_mirror_and_refuses_a_curved_one():
    scene = scene_with(flat_mirror())
    errors = measure(drawn(scene, "raytrace"), drawn(scene, "environment:mode=planar"))
    assert errors.pixels.p95 <= 0.05
    for radius in (1.4, -0.5, 50.0):
        with pytest.raises(AnamorphError, match="'mirror' is curved") as caught:
            open_view(scene_with(spherical_mirror(radius)), "environment:mode=planar")
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("specification", "word"),
    [
        ("environment:mode=sphere", "mode"),
        ("environment:update=never", "update"),
        ("environment:face=-1", "face"),
        ("environment:face=5000", "face"),
        ("environment:antialias=3", "antialias"),
        ("environment:mode=planar,face=64", "face is for cube maps"),
        ("environment:mode=planar,update=once", "update is for cube maps"),
    ],
)
def test_wrong_options_are_named(specification, word):
    with pytest.raises(AnamorphError, match=word) as caught:
        open_view(scene_with(spherical_mirror()), specification)
    assert "\n" not in str(caught.value)


def test_antialiasing_changes_edges_alone():
    scene = scene_with(spherical_mirror())
    plain_frame, smooth = drawn(scene, "environment"), drawn(scene, "environment:antialias=4")
    difference = np.abs(plain_frame.color - smooth.color).max(axis=-1)
    edges = silhouettes(plain_frame.object_id, plain_frame.specular)
    assert difference[edges].max() > 0.05
    assert np.percentile(difference[~edges], 90) <= 0.02
