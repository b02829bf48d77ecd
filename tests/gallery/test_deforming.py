"""Scenes that deform: the motion of the built-in one, what sessions make of it, and its benchmark."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import drawn, open_view, scene_with, spherical_mirror

from anamorph import gallery
from anamorph.base.errors import AnamorphError
from anamorph.bench.deforming import COMPETITORS, DEFAULT, DeformingTimes, Phases, deforming_table, time_deforming
from anamorph.cli import commands as cli
from anamorph.gallery.deforming import deformed
from anamorph.gallery.swell import deform
from anamorph.measure.frame_times import Timing
from anamorph.methods import METHODS, Specification
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Mesh, Scene

SPECIFICATIONS = (*METHODS, "pervertex:tolerance=0.5", "pervertex:map=image", "raytrace:tree=rebuild")
WIND = np.array([0.8, 0.6])
SCENE = scene_with(spherical_mirror())


@cache
def deforming() -> Scene:
    return gallery.make("deforming")


def moved(points, normals, reach, time):
    """`deform` of points (N, 3), at which float32 resolves little, and normals."""
    places, turned = np.empty((2, len(points), 3), np.float32)
    arrays = (np.ascontiguousarray(values, np.float32) for values in (points, normals, reach))
    deform(*arrays, WIND, time, places, turned)
    return places.astype(float), turned.astype(float)


directions = st.tuples(*[st.floats(-1, 1)] * 3).map(np.array).filter(lambda d: np.linalg.norm(d) > 0.1)


@settings(max_examples=100)
@given(
    place=st.tuples(st.floats(-45, 45), st.floats(-1, 6), st.floats(-45, 45)).map(np.array),
    normal=directions,
    other=directions,
    reach=st.one_of(st.just(-1.0), st.just(0.0), st.floats(0.05, 2.0)),
    time=st.floats(0, 30),
)
def test_normals_stay_at_right_angles_to_the_surface(place, normal, other, reach, time):
    normal = normal / np.linalg.norm(normal)
    first = np.cross(normal, other)
    if np.linalg.norm(first) < 0.1:
        first = np.cross(normal, np.roll(normal, 1) * [1, -1, 1] + [0.3, 0.2, 0.1])
    first /= np.linalg.norm(first)
    second = np.cross(normal, first)
    step = 0.01
    points = place + step * np.array([first, -first, second, -second, 0 * first])
    along = (points - place) @ [WIND[0], 0.0, WIND[1]]
    # At the pole itself the flag ends: its tangents are taken within.
    reaches = np.full(5, -1.0) if reach < 0 else np.maximum(reach, 0.02) + along
    places, normals = moved(points, np.tile(normal, (5, 1)), reaches, time)
    tangent, cotangent = (places[0] - places[1]) / (2 * step), (places[2] - places[3]) / (2 * step)
    assert np.linalg.norm(normals[4]) == pytest.approx(1.0, abs=1e-5)
    for edge in (tangent, cotangent):
        assert abs(edge @ normals[4]) < 1e-3 * max(np.linalg.norm(edge), 1.0)
    assert np.cross(tangent, cotangent) @ normals[4] > 0.0


def test_flags_hang_on_their_poles_and_swing_further_out():
    points, reach = np.tile([3.0, 3.0, -2.0], (3, 1)), np.array([-1.0, 0.0, 1.5])
    places = np.stack(
        [moved(points, np.tile([0.0, 0.0, 1.0], (3, 1)), reach, time)[0] for time in np.arange(0, 1, 0.1)]
    )
    assert (places[:, 1] == places[:, 0]).all()
    swing = (places[:, 2] - places[:, 0]) @ [-WIND[1], 0.0, WIND[0]]
    assert swing.max() > 0.1 and swing.min() < -0.1


def test_the_scene_has_its_triangles_and_all_but_the_mirrors_move():
    scene = deforming()
    geometry, still = flatten(scene), len(scene.meshes[0].positions)
    specular = [mesh.specular for mesh in scene.meshes]
    assert specular[0] and not any(specular[1:])
    assert len(geometry.faces) - len(scene.meshes[0].faces) == pytest.approx(300_000, rel=0.01)
    start, normals = deformed(0.0)
    assert (geometry.positions == start).all() and (geometry.normals == normals).all()
    assert start.dtype == normals.dtype == np.float32
    travelled = np.zeros(len(start))
    for time in (0.4, 1.1, 2.3):
        positions, normals = deformed(time)
        travelled = np.maximum(travelled, np.linalg.norm(positions - start, axis=1))
        assert (positions[:still] == start[:still]).all()
        assert np.abs(np.linalg.norm(normals, axis=1) - 1.0).max() < 1e-5
    assert travelled[still:].min() > 1e-4


def test_flags_have_two_sides():
    flags = [mesh for mesh in deforming().meshes if mesh.name.startswith("flags")]
    assert len(flags) == 5
    for mesh in flags:
        assert np.linalg.norm(mesh.normals.mean(axis=0)) < 1e-3 < np.abs(mesh.normals).mean()


def test_triangles_of_the_deformed_scene_still_turn_with_their_normals():
    geometry = flatten(deforming())
    still = geometry.first_face[1]
    positions, normals = deformed(2.3)
    a, b, c = np.moveaxis(positions.astype(float)[geometry.faces[still:]], 1, 0)
    area = np.cross(b - a, c - a)
    area /= np.linalg.norm(area, axis=1, keepdims=True)
    mean = normals.astype(float)[geometry.faces[still:]].mean(axis=1)
    assert (np.einsum("fk,fk->f", area, mean) > 0.9).mean() > 0.99


def shaken(scene: Scene, time: float) -> Scene:
    """The scene with everything but its mirrors bent by a wave."""

    def bent(mesh: Mesh) -> Mesh:
        if mesh.specular:
            return mesh
        positions = mesh.positions + np.float32(0.06) * np.sin(3.0 * np.roll(mesh.positions, 1, axis=1) + time)
        normals = mesh.normals + np.float32(0.2) * np.cos(mesh.positions + time)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        return replace(mesh, positions=positions.astype(np.float32), normals=normals.astype(np.float32))

    return replace(scene, meshes=tuple(map(bent, scene.meshes)))


@pytest.mark.parametrize("specification", SPECIFICATIONS)
def test_a_deformed_session_draws_what_a_fresh_one_does(specification):
    session = open_view(SCENE, specification)
    before = drawn(SCENE, specification)
    for time in (0.5, 4.0, 2.0):
        geometry = flatten(shaken(SCENE, time))
        session.deform(geometry.positions, geometry.normals)
        session.draw(SCENE.camera)
    found, fresh = session.frame(seen=True), drawn(shaken(SCENE, 2.0), specification)
    direct = fresh.specular == 0
    assert (found.color[direct] == fresh.color[direct]).mean() > 0.999
    difference = np.abs(found.color - fresh.color).max(axis=-1)[~direct]
    assert np.median(difference) < 1e-3 and (difference > 0.05).mean() < 0.01
    assert (found.object_id == fresh.object_id).mean() > 0.998
    mirrored = np.abs(before.color - fresh.color).max(axis=-1)[~direct]
    assert (mirrored > 0.05).mean() > 0.02, "the motion cannot be seen"


def test_a_session_can_be_put_back():
    geometry, other = flatten(SCENE), flatten(shaken(SCENE, 1.0))
    session = open_view(SCENE, "raytrace")
    session.deform(other.positions, other.normals)
    session.deform(geometry.positions, geometry.normals)
    session.draw(SCENE.camera)
    difference = np.abs(session.frame().color - drawn(SCENE, "raytrace").color)
    assert (difference.max(axis=-1) > 1e-3).mean() < 0.002


def test_what_the_caller_does_with_its_arrays_later_does_not_matter():
    other = flatten(shaken(SCENE, 1.0))
    session = open_view(SCENE, "raytrace")
    positions = other.positions.copy()
    session.deform(positions, other.normals)
    positions[:] = np.nan
    session.draw(SCENE.camera)
    assert np.abs(session.frame().color - drawn(shaken(SCENE, 1.0), "raytrace").color).mean() < 1e-3


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda p, n: (p[:-1], n), "positions have the shape"),
        (lambda p, n: (p, n[:, :2]), "normals have the shape"),
        (lambda p, n: (p * np.nan, n), "positions are not all finite"),
        (lambda p, n: (p, np.full_like(n, np.inf)), "normals are not all finite"),
        (lambda p, n: (p + np.float32(0.1), n), "positions of 'mirror' differ, which is specular"),
        (lambda p, n: (p, n[:, [1, 0, 2]]), "normals of 'mirror' differ, which is specular"),
    ],
)
def test_vertices_that_cannot_be_are_refused_and_nothing_changes(change, words):
    geometry = flatten(SCENE)
    session = open_view(SCENE, "environment:face=64")
    with pytest.raises(AnamorphError, match=words) as caught:
        session.deform(*change(geometry.positions, geometry.normals))
    assert "\n" not in str(caught.value)
    session.draw(SCENE.camera)
    assert (session.frame().color == drawn(SCENE, "environment:face=64").color).all()


def test_an_unknown_way_to_keep_the_tree_is_refused():
    with pytest.raises(AnamorphError, match="tree is 'grow'; give refit or rebuild"):
        open_view(SCENE, "raytrace:tree=grow")


def test_the_methods_agree_on_the_built_in_scene_at_a_later_time():
    """The same moment, by a method that casts a ray for every pixel and one that casts none."""
    frames = []
    for specification in ("raytrace", "pervertex"):
        session = open_view(deforming(), specification)
        session.deform(*deformed(1.7))
        session.draw(deforming().camera)
        frames.append(session.frame(seen=True))
    traced, warped = frames
    mirror = (traced.specular == 1) & (warped.specular == 1)
    assert mirror.mean() > 0.1
    assert (traced.object_id == warped.object_id)[mirror].mean() > 0.97
    assert np.median(np.abs(traced.color - warped.color).max(axis=-1)[mirror]) < 0.01


def test_the_benchmark_takes_turns_and_names_its_competitor():
    times = time_deforming(["environment:face=32"], (40, 30), frames=2)
    assert tuple(times.methods) == ("environment:face=32", *COMPETITORS)
    for phases in times.methods.values():
        assert phases.frame.n == phases.deform.n == times.upload.n == 2
    assert times.methods["raytrace:tree=rebuild"].p95_pixels == pytest.approx(0.0, abs=0.01)
    assert times.methods["environment:face=32"].p95_pixels > 0.1
    assert deforming_table(times).row_count == 3


def test_what_is_timed_by_default_are_methods():
    assert [Specification.parse(specification).method.name for specification in DEFAULT] == ["pervertex"]


@pytest.mark.parametrize("fast", COMPETITORS)
def test_the_faster_ray_tracer_is_the_competitor(fast):
    def phases(median: float) -> Phases:
        part = Timing(median, median, median, 1)
        return Phases(part, part, part, part, None)

    methods = {name: phases(8.0 if name == fast else 12.0) for name in COMPETITORS} | {"pervertex": phases(4.0)}
    times = DeformingTimes((40, 30), "", Timing(1.0, 1.0, 1.0, 1), methods)
    assert times.competitor == fast
    assert times.speed("pervertex") == 2.0 and times.speed(fast) == 1.0


def test_the_benchmark_from_the_command_line(capsys):
    arguments = ["bench", "deforming", "-m", "environment:face=32", "--size", "40x30", "--frames", "2"]
    assert cli.main(arguments) == 0
    printed = capsys.readouterr().out
    assert all(name in printed for name in ("environment:face=32", *COMPETITORS, "deforming, 40 x 30"))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["car-mirror"], "deforming"),
        (["deforming", "--frames", "0"], "'0' is no number of frames"),
        (["deforming", "--frames", "1000"], "up to 300"),
        (["deforming", "-m", "pervertx"], "did you mean 'pervertex'"),
    ],
)
def test_a_wrong_benchmark_is_one_line(arguments, words, capsys):
    assert cli.main(["bench", *arguments]) == 2
    said = capsys.readouterr().err
    assert words in said and said.count("\n") == 1


def test_the_eye_may_move_while_the_scene_does():
    session = open_view(SCENE, "raytrace")
    camera = Camera((-0.2, 0.6, 1.0), SCENE.camera.target, field_of_view=32.0)
    geometry = flatten(shaken(SCENE, 1.0))
    session.draw(SCENE.camera)
    session.deform(geometry.positions, geometry.normals)
    session.draw(camera)
    expected = drawn(shaken(SCENE, 1.0), "raytrace", camera=camera)
    assert np.abs(session.frame().color - expected.color).mean() < 1e-3
