"""Points projected on the device and drawn as squares: against float64, brute force, and traced rays."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from ray_triangles import KINDS, NEARLY, points_for, ray_triangle, well_placed
from scenes import CAMERA, SIZE, drawn, flat_mirror, open_view, scene_with, spherical_mirror, surroundings

from anamorph import cameras
from anamorph.base.errors import AnamorphError
from anamorph.base.steps import drain
from anamorph.frame import Status, View
from anamorph.gpu.device import get_device
from anamorph.measure.errors import measure
from anamorph.methods import Specification
from anamorph.methods.stage import Stage
from anamorph.methods.threeray import projector as module
from anamorph.methods.threeray.camera_bases import bases_of
from anamorph.methods.threeray.cameras_seen import body_cameras, mesh_cameras
from anamorph.methods.threeray.objects import materials_of
from anamorph.methods.threeray.points_seen import pairs_seen, stand_ins
from anamorph.methods.threeray.projector import SEVERAL, Projector
from anamorph.methods.threeray.splat_records import point_records
from anamorph.methods.threeray.surfel_tree import make_tree
from anamorph.methods.threeray.surfels import Surfels
from anamorph.optics.ray_meshes import bodies_of
from anamorph.raymesh import RayMesh, RayStatus
from anamorph.raytriangle import project_points
from anamorph.raytriangle.camera_frames import frames_of
from anamorph.raytriangle.owners import owners_of, places_of
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Scene, Sky

SMALL = (64, 48)


def surfels_at(points: np.ndarray) -> Surfels:
    count = len(points)
    return Surfels(points, np.zeros((count, 6)), np.zeros(count, np.int32), np.zeros((count, 3, 3)))


def three_rays(random: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Origins and directions (K, 3, 3) of cameras of every kind, and points for all of them."""
    rays, points = [], []
    for kind in KINDS:
        if kind == "far":
            continue
        for nearly in NEARLY:
            rays.append(ray_triangle(kind, nearly, random))
            points.append(points_for(*rays[-1], nearly, random))
    return *np.moveaxis(np.array(rays), 1, 0), np.concatenate(points)


def mesh_of(origins: np.ndarray, directions: np.ndarray) -> RayMesh:
    """A ray mesh of triangles that share no vertex."""
    count = 3 * len(origins)
    image = np.column_stack([np.random.default_rng(1).uniform(0, 99, (count, 2)), np.ones(count)])
    faces, status = np.arange(count).reshape(-1, 3), np.full(count, RayStatus.OK)
    return RayMesh(image, origins.reshape(-1, 3), directions.reshape(-1, 3), faces, status)


def interpolated(corners: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """What is linear in the weights of cameras, (K, N, R, 3), from their corners (K, 3, 3)."""
    return np.einsum("knrw,kwi->knri", np.stack([1.0 - u - v, u, v], axis=-1), corners)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ("splat=1,culling=walls", "culling is for surfels that rays meet; leave it out, or give splat=0"),
        ("detail=false", "detail is for points; leave it out, or give splat=1 or splat=2"),
    ],
)
def test_options_of_the_other_way_are_refused(options, words):
    with pytest.raises(AnamorphError, match=words):
        drawn(scene_with(flat_mirror()), f"threeray:{options}")


def test_all_valid_projections_are_those_of_float64():
    origins, directions, points = three_rays(np.random.default_rng(5))
    scene = scene_with(flat_mirror())
    buffers, materials = open_view(scene, "threeray", SMALL).diagnostics()["buffers"], materials_of(scene)
    projector = Projector(buffers, len(points), points.mean(axis=0))
    projector.place(point_records(surfels_at(points), np.ones(1, np.int64), materials, projector.middle))
    projector.look(mesh_cameras(mesh_of(origins, directions), 1, (0.0, 0.0)), np.arange(len(origins)), materials)
    pairs = np.stack(np.indices((len(origins), len(points))), axis=-1).reshape(-1, 2).astype(np.uint32)
    found = []
    for some in np.array_split(pairs, 20):
        encoder = get_device().create_command_encoder()
        projector.record(encoder, some, SEVERAL)
        get_device().queue.submit([encoder.finish()])
        found.append(projector.projections(SEVERAL * len(some)))
    found = np.concatenate(found).reshape(len(origins), len(points), SEVERAL)
    seen = found["way"] >= 0.0
    twin = project_points(origins, directions, points)
    here, there = (
        np.linalg.norm(interpolated(directions, each["u"], each["v"]), axis=-1) for each in (vars(twin), found)
    )
    device = SimpleNamespace(u=found["u"], v=found["v"], t=found["way"] / there, valid=seen)
    ways = twin.t * here, found["way"]
    for one, other, has, (way, others) in ((twin, device, twin.seen, ways), (device, twin, seen, ways[::-1])):
        placed, within = well_placed(origins, directions, one)
        # Not at the triangle's border or at the rays' origins, nor where rays that miss a focus by 1e-13 spread again.
        inner = np.minimum(np.minimum(one.u, one.v), 1.0 - one.u - one.v) > 1e-6
        asked = has & placed & inner & (one.t > 1e-5) & (one.t < 1e4)
        assert asked.sum() > 3000 and (asked.sum(axis=-1) > 1).sum() > 300
        off = np.maximum(*(np.abs(getattr(one, k)[..., None] - getattr(other, k)[..., None, :]) for k in ("u", "v")))
        apart = np.abs(way[..., None] - others[..., None, :])
        alike = other.valid[..., None, :] & (apart <= 1e-6 * (1.0 + one.t[..., None]))
        assert (np.where(alike, off, np.inf).min(axis=-1)[asked] <= within[asked]).all()
    valid, several = projector.counts()
    assert (valid, several) == (seen.sum(), (seen.sum(axis=-1) > 1).sum())


@pytest.mark.parametrize("kind", ["any", "parallel", "focus", "thin", "crossing", "together", "narrow"])
def test_no_point_that_a_camera_sees_is_left_out(kind):
    random = np.random.default_rng(9)
    rays = [ray_triangle("any" if kind == "narrow" else kind, nearly, random) for nearly in 5 * NEARLY]
    origins, directions = np.moveaxis(np.array(rays), 1, 0)
    if kind == "narrow":
        origins, directions = 0.03 * origins, directions * 0.2 + [0.0, 0.0, 1.0]
    weights = random.dirichlet((1.0, 1.0, 1.0), (len(rays), 200))
    t = random.uniform(0.0, 3.0, (len(rays), 200, 1))
    points = (weights @ origins + t * (weights @ directions)).reshape(-1, 3)
    tree = make_tree(surfels_at(points), np.ones(1, np.int64))
    found = mesh_cameras(mesh_of(origins, directions), 1, (0.0, 0.0))
    bases = bases_of(found, np.arange(len(rays)))
    pairs = drain(pairs_seen(frames_of(origins, directions), bases, tree.nodes, stand_ins(tree), 0.0))
    held = np.zeros((len(rays), len(points)), bool)
    held[pairs[:, 0], pairs[:, 1]] = True
    assert held.sum() == len(pairs)
    assert held[project_points(origins, directions, tree.surfels.center).seen.any(axis=-1)].all()
    if kind == "narrow":
        assert held.mean() < 0.2


@pytest.mark.parametrize("radius", [1.4, -0.5])
@pytest.mark.parametrize("side", [1, 2])
def test_squares_stand_where_float64_projects_points_and_the_nearest_by_its_way_stays(radius, side):
    scene = scene_with(spherical_mirror(radius, count=3))
    session = open_view(scene, f"threeray:splat={side},detail=false,spacing=0.12", SMALL)
    session.draw(scene.camera)
    frame, points = session.frame(seen=True), session.diagnostics()["tree"].surfels
    stage = Stage(View(scene, scene.camera, SMALL))
    found = body_cameras(
        bodies_of(stage.view.scene, stage.geometry), stage.geometry, stage.view.camera.eye(SMALL), 1, (0.0, 0.0)
    )
    depth, owner = np.zeros(SMALL[::-1]), np.zeros(SMALL[::-1], np.int32)
    fronts = np.linalg.det(found.image) < 0.0
    owning = owners_of(places_of(found.image, SMALL), SMALL, fronts, depth, owner)
    # The mirror's own points are within it.
    centers = points.center[stage.geometry.face_object[points.triangle] > 1]
    seen = project_points(found.origins[owning], found.directions[owning], centers)
    k, n, root = np.nonzero(seen.seen & (seen.t >= found.near[owning, None, None]))
    u, v, t = (each[k, n, root] for each in (seen.u, seen.v, seen.t))
    weights, c = np.stack([1.0 - u - v, u, v], axis=-1), owning[k]
    way = t * np.linalg.norm(np.einsum("mw,mwi->mi", weights, found.directions[c]), axis=-1)
    image = np.einsum("mw,mwi->mi", weights, found.image[c])
    first = np.floor(image[:, :2] / image[:, 2:] - 0.5 * side + 1.0).astype(int)
    nearest, expected = np.full(SMALL[::-1], np.inf), np.zeros((*SMALL[::-1], 3))
    for right, down in np.ndindex(side, side):
        column, row = first[:, 0] + right, first[:, 1] + down
        inside = (column >= 0) & (row >= 0) & (column < SMALL[0]) & (row < SMALL[1])
        for m in np.flatnonzero(inside):
            if owner[row[m], column[m]] >= 0 and way[m] < nearest[row[m], column[m]]:
                nearest[row[m], column[m]], expected[row[m], column[m]] = way[m], centers[n[m]]
    owned = (owner >= 0) & (frame.specular > 0)
    got = owned & (frame.status == Status.PROJECTED)
    assert owned.sum() > 100 and got.sum() > 100
    assert (got == np.isfinite(nearest))[owned].mean() > 0.99
    both = got & np.isfinite(nearest)
    apart = np.linalg.norm(frame.position - expected, axis=-1)[both]
    # A place at the border of two pixels may round to either.
    assert (apart < 1e-4).mean() > 0.99
    assert (frame.status[owned & ~got] == Status.SKY).all()


def test_with_detail_ten_times_the_points_are_no_more_to_project():
    scene = scene_with(spherical_mirror(count=4))
    frames = {}
    for detail in ("true", "false"):
        for spacing in (0.063, 0.02):
            frames[detail, spacing] = drawn(scene, f"threeray:splat=1,detail={detail},spacing={spacing}", (32, 24))
    few, many = (frames["true", spacing].figures for spacing in (0.063, 0.02))
    assert many["points"] > 10 * few["points"]
    assert many["pairs"] <= 1.2 * few["pairs"]
    assert frames["false", 0.02].figures["pairs"] > 9 * frames["false", 0.063].figures["pairs"]
    whole, some = (frames[detail, 0.02] for detail in ("false", "true"))
    seen = whole.specular > 0
    assert seen.sum() > 200
    assert ((some.object_id == 0) & (whole.object_id > 0))[seen].mean() < 0.02
    assert (whole.object_id == some.object_id)[seen].mean() > 0.95


@pytest.mark.parametrize("options", ["splat=2", "splat=2,antialias=4"])
def test_dense_points_show_what_traced_rays_see(options):
    scene = scene_with(spherical_mirror(count=4))
    reference = drawn(scene, "raytrace:truth=raymesh", SMALL)
    frame = drawn(scene, f"threeray:{options},spacing=0.03", SMALL)
    assert (frame.specular == reference.specular).all()
    seen = reference.specular > 0
    errors = measure(reference, frame)
    assert errors.other_object_percent < 2.0
    assert not np.isin(frame.status[seen], [Status.PROVED, Status.DOUBTFUL]).any()
    # Squares are off by up to a pixel, also at each edge of the chequered floor; in the mean they are not.
    inside = errors.maps.specular & ~errors.maps.silhouette & (frame.object_id == reference.object_id)
    assert np.abs((frame.color - reference.color)[inside].mean(axis=0)).max() < 0.03


def test_a_ray_mesh_as_the_camera_is_covered_by_squares():
    scene = scene_with(spherical_mirror(count=3))
    view = View(scene, cameras.orthographic(CAMERA, SMALL), SMALL)
    frames = []
    for method in ("raytrace", "threeray:splat=2,spacing=0.02"):
        session = Specification.parse(method).open(view)
        session.draw(view.camera)
        frames.append(session.frame(seen=True))
    reference, frame = frames
    # The mirror's front is where a path ends.
    ended = frame.status == Status.OUTSIDE
    assert (frame.object_id[ended] == 1).all()
    assert (frame.object_id == reference.object_id)[~ended].mean() > 0.9
    near = (frame.object_id == reference.object_id) & (frame.object_id > 1)
    pixel = np.linalg.norm(reference.position[1:] - reference.position[:-1], axis=-1)
    apart = np.linalg.norm(frame.position - reference.position, axis=-1)[near]
    assert np.median(apart) < 2.0 * np.median(pixel[near[1:]])


def test_points_follow_a_scene_that_deforms():
    scene = scene_with(spherical_mirror(count=3))
    offset = np.float32([0.2, 0.1, 0.15])
    session = open_view(scene, "threeray:splat=1", SMALL)
    geometry = flatten(scene)
    session.draw(scene.camera)
    moved = geometry.positions + np.where(geometry.vertex_object[:, None] > 1, offset, np.float32(0.0))
    session.deform(moved, geometry.normals)
    session.draw(scene.camera)
    meshes = [mesh if mesh.specular else replace(mesh, positions=mesh.positions + offset) for mesh in scene.meshes]
    expected, frame = drawn(replace(scene, meshes=tuple(meshes)), "threeray:splat=1", SMALL), session.frame(seen=True)
    assert (expected.object_id == frame.object_id).mean() > 0.99
    assert (session.frame().color == frame.color).all()


def test_the_same_view_gives_the_same_squares():
    scene = scene_with(spherical_mirror(-0.5, count=5))
    one, other = (drawn(scene, "threeray:splat=1", SMALL) for _ in range(2))
    assert (one.color == other.color).all() and (one.status == other.status).all()


def test_a_mirror_alone_and_meshes_without_area_are_holes_that_show_the_sky():
    mirror = spherical_mirror(count=3)
    wire = replace(surroundings()[1], positions=np.zeros_like(surroundings()[1].positions))
    for meshes in ((mirror,), (mirror, wire)):
        frame = drawn(Scene("sky", meshes, CAMERA, sky=Sky()), "threeray:splat=2", SMALL)
        seen = frame.specular > 0
        assert seen.sum() > 100
        assert (frame.status[seen] == Status.SKY).all() and frame.figures["holes_percent"] == 100.0


def test_too_many_points_for_the_device_are_refused(monkeypatch):
    monkeypatch.setattr(module, "most_points", lambda: 1000)
    with pytest.raises(AnamorphError, match="threeray: splat draws at most 1000 points"):
        open_view(scene_with(flat_mirror()), "threeray:splat=1", SIZE)
