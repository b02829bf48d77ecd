"""Frames of three-ray cameras against the rays of their ray meshes, traced."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import CAMERA, SIZE, drawn, flat_mirror, open_view, scene_with, spherical_mirror, surroundings

from anamorph import cameras
from anamorph.base.errors import AnamorphError
from anamorph.frame import Frame, Status, View
from anamorph.gallery import make
from anamorph.gallery.solids import box
from anamorph.gallery.spheres import mirror_ball
from anamorph.measure.errors import measure
from anamorph.methods import Specification
from anamorph.methods.threeray import meeting
from anamorph.raymesh import RayMesh
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Diffuse, Mesh, Scene, Sky

REFERENCE = "raytrace:truth=raymesh"


def check(reference, frame, least: int = 500) -> None:
    """Nothing is missing, every object is the reference's away from silhouettes, and every place is."""
    specular = reference.specular > 0
    assert specular.sum() >= least
    assert (frame.specular[specular] > 0).mean() > 0.998
    errors = measure(reference, frame)
    assert errors.pixels.p95 <= 0.05
    assert errors.other_object_percent <= 0.05
    both = specular & (frame.specular > 0)
    # A hole would show what stands behind the mirror, or the sky.
    lost = both & (frame.object_id == 0) & (reference.object_id > 0)
    assert lost.sum() <= 1e-3 * both.sum()
    assert not np.isin(frame.status[both], [Status.DOUBTFUL, Status.PROVED]).any()


MIRRORS = {
    "flat": flat_mirror(),
    "convex": spherical_mirror(count=4),
    "concave": spherical_mirror(-1.4, count=4),
    "strongly concave": spherical_mirror(-0.5, count=5),
    "coarse": spherical_mirror(count=1),
    "ball": mirror_ball("ball", (0.0, 0.5, 0.0), 0.15, rows=12, columns=18),
    "plain": replace(spherical_mirror(count=3), surface=None, parameters=None),
}


@pytest.mark.parametrize("name", MIRRORS)
@pytest.mark.parametrize(("options", "few"), [("", meeting.FEW), (":spacing=0.15", 0)])
def test_a_mirror_shows_what_its_interpolated_rays_meet(name, options, few, monkeypatch):
    scene = scene_with(MIRRORS[name])
    monkeypatch.setattr(meeting, "FEW", few)
    check(drawn(scene, REFERENCE), drawn(scene, f"threeray{options}"))


@pytest.mark.parametrize("name", ["room", "torus", "curvature-series", "spheres", "car-mirror", "facing-mirrors"])
def test_built_in_scenes_have_no_hole(name):
    scene, size = make(name), (320, 240)
    reference, frame = drawn(scene, REFERENCE, size), drawn(scene, "threeray", size)
    check(reference, frame)
    assert np.abs(frame.color - reference.color)[reference.specular > 0].mean() < 2e-3


@pytest.mark.parametrize("name", ["flat", "strongly concave", "coarse"])
def test_both_cullings_show_the_same(name, monkeypatch):
    monkeypatch.setattr(meeting, "FEW", 0)
    scene = scene_with(MIRRORS[name])
    bounds, walls = (drawn(scene, f"threeray:culling={culling}", (320, 240)) for culling in ("bounds", "walls"))
    assert (bounds.color == walls.color).all() and (bounds.status == walls.status).all()
    assert 0 < walls.figures["nodes"] < bounds.figures["nodes"]


def test_lenses_send_each_color_its_own_way():
    scene = make("spectacles-minus")
    reference, frame = drawn(scene, REFERENCE, SIZE), drawn(scene, "threeray", SIZE)
    check(reference, frame)
    assert np.abs(frame.color - reference.color)[reference.specular > 0].mean() < 4e-3


@pytest.mark.parametrize("kind", ["pinhole", "orthographic", "detail_and_context"])
def test_a_ray_mesh_as_the_camera(kind):
    scene = scene_with(spherical_mirror(count=3))
    view = View(scene, getattr(cameras, kind)(CAMERA, SIZE), SIZE)
    frames = []
    for method in ("raytrace", "threeray"):
        session = Specification.parse(method).open(view)
        session.draw(view.camera)
        frames.append(session.frame(seen=True))
    reference, frame = frames
    same = reference.object_id == frame.object_id
    assert same.mean() > 0.998
    near = same & (reference.object_id > 0)
    assert near.sum() > 3000
    apart = np.linalg.norm(frame.position - reference.position, axis=-1)[near]
    assert np.percentile(apart, 99) < 1e-3


def test_four_samples_a_pixel_are_those_of_traced_rays():
    scene = scene_with(spherical_mirror(count=4))
    traced, found = (drawn(scene, method).color for method in (f"{REFERENCE},antialias=4", "threeray:antialias=4"))
    apart = np.abs(traced - found).max(axis=-1)
    assert (apart > 0.01).mean() < 2e-3


def test_what_stands_before_a_mirror_hides_it():
    post = box((-0.02, 0.2, 0.25), (0.04, 0.55, 0.3)).mesh("post", Diffuse(color=(0.9, 0.1, 0.1)))
    scene = Scene("post", (spherical_mirror(count=4), *surroundings(), post), CAMERA, sky=Sky())
    reference, frame = drawn(scene, "raytrace"), drawn(scene, "threeray")
    before = (reference.specular == 0) & (reference.object_id == len(scene.meshes))
    assert before.sum() > 200
    assert (frame.specular[before] == 0).mean() > 0.98
    assert (frame.object_id[before] == len(scene.meshes)).mean() > 0.98


def test_a_scene_that_deforms_is_seen_where_it_is():
    scene = scene_with(spherical_mirror(count=4))
    geometry = flatten(scene)
    offset = np.float32([0.2, 0.1, 0.15])
    positions = geometry.positions + np.where(geometry.vertex_object[:, None] > 1, offset, np.float32(0.0))
    session = open_view(scene, "threeray")
    session.draw(scene.camera)
    session.deform(positions, geometry.normals)
    session.draw(scene.camera)
    moved = [mesh if mesh.specular else replace(mesh, positions=mesh.positions + offset) for mesh in scene.meshes]
    check(drawn(replace(scene, meshes=tuple(moved)), REFERENCE), session.frame(seen=True))


def test_the_same_view_gives_the_same_frame():
    scene = scene_with(spherical_mirror(-0.5, count=5))
    one, other = (drawn(scene, "threeray") for _ in range(2))
    assert (one.color == other.color).all() and (one.status == other.status).all()


def test_a_mirror_alone_sees_the_sky():
    frame = drawn(Scene("sky", (spherical_mirror(count=3),), CAMERA, sky=Sky()), "threeray")
    specular = frame.specular > 0
    assert specular.sum() > 500
    assert (frame.status[specular] == Status.SKY).all()


def test_a_scene_without_mirrors_is_drawn_as_it_is():
    scene = Scene("plain", surroundings(), CAMERA, sky=Sky())
    assert (drawn(scene, "threeray").color == drawn(scene, "raytrace").color).all()


def test_a_spacing_that_no_memory_holds_is_refused():
    with pytest.raises(AnamorphError, match="spacing 1e-07 makes more than"):
        open_view(scene_with(flat_mirror()), "threeray:spacing=1e-7")


def test_a_million_vertices_at_one_place_change_nothing():
    scene, count = scene_with(spherical_mirror(count=4)), 999_999
    place, faces = np.float32([[0.0, 1.0, 2.0]]), np.arange(count, dtype=np.int32).reshape(-1, 3)
    normals = np.tile(np.float32([0.0, 1.0, 0.0]), (count, 1))
    heap = Mesh("heap", np.repeat(place, count, axis=0), faces, normals, Diffuse(color=(1.0, 0.0, 0.0)))
    frame, without = drawn(replace(scene, meshes=(*scene.meshes, heap)), "threeray"), drawn(scene, "threeray")
    assert (frame.color == without.color).all() and (frame.status == without.status).all()
    assert frame.figures == without.figures


def test_many_triangles_at_one_place_are_seen_as_one():
    scene, count = scene_with(spherical_mirror(count=4)), 5_000
    place = np.float32([[0.1, 0.4, 0.6], [0.25, 0.4, 0.6], [0.1, 0.6, 0.6]])
    frames = []
    for each in (1, count):
        faces, normals = np.arange(3 * each, dtype=np.int32).reshape(-1, 3), np.tile([[0.0, 0.0, -1.0]], (3 * each, 1))
        pile = Mesh("pile", np.tile(place, (each, 1)), faces, normals, Diffuse(color=(1.0, 0.0, 0.0)))
        frames.append(drawn(replace(scene, meshes=(*scene.meshes, pile)), "threeray"))
    assert (frames[0].object_id[frames[0].specular > 0] == len(scene.meshes) + 1).sum() > 20
    assert (frames[0].color == frames[1].color).all() and (frames[0].object_id == frames[1].object_id).all()


def seen_by(camera: RayMesh, method: str) -> Frame:
    """What a ray mesh sees of a mirror's scene."""
    session = Specification.parse(method).open(View(scene_with(spherical_mirror(count=3)), camera, SIZE))
    session.draw(camera)
    return session.frame(seen=True)


def fan(directions: list[list[float]], faces: list[list[int]]) -> RayMesh:
    """Rays from one eye at the corners of the image, and one at the middle of its upper side."""
    width, height = SIZE
    image = np.array([[0, 0], [width, 0], [width, height], [0, height], [0.5 * width, 0]], float)
    rays = np.array(directions)
    eyes, good = np.tile(CAMERA.position, (len(rays), 1)), np.zeros(len(rays), np.uint8)
    return RayMesh(np.column_stack([image, np.ones(len(image))]), eyes, rays, np.int32(faces), good)


AHEAD = [-0.25, -0.15, -0.9]


def test_a_camera_whose_three_rays_are_one_sees_one_point():
    camera = fan([AHEAD, AHEAD, AHEAD, [-0.5, -0.4, -0.9], AHEAD], [[0, 1, 2], [0, 2, 3]])
    frame, reference = seen_by(camera, "threeray"), seen_by(camera, "raytrace")
    assert np.isfinite(frame.position).all() and np.isfinite(frame.color).all()
    assert (frame.object_id == reference.object_id).mean() > 0.998 and (frame.status != Status.OUTSIDE).all()
    right = np.arange(SIZE[0]) / SIZE[0] > (np.arange(SIZE[1])[:, None] + 1.0) / SIZE[1]
    assert len(np.unique(frame.object_id[right])) == 1
    assert np.ptp(frame.position[right], axis=0).max() < 1e-5


def test_a_camera_without_an_area_in_the_image_sees_nothing():
    spread = [[-0.5, 0.2, -0.9], [0.1, 0.2, -0.9], [0.1, -0.5, -0.9], [-0.5, -0.5, -0.9], [-0.2, 0.2, -0.9]]
    # The first runs along the upper side, the second is a point.
    with_flat = seen_by(fan(spread, [[0, 4, 1], [3, 3, 3], [0, 1, 2], [0, 2, 3]]), "threeray")
    without = seen_by(fan(spread, [[0, 1, 2], [0, 2, 3]]), "threeray")
    assert (with_flat.color == without.color).all() and (with_flat.object_id == without.object_id).all()
    assert len(np.unique(without.object_id)) > 3
