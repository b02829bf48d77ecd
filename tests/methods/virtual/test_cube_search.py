"""The paper's search on cube maps, in float64 and on the device."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from reflectors import BALL, EYE, small_things
from scenes import CAMERA, drawn, flat_mirror, open_view, scene_with, spherical_mirror, surroundings

from anamorph.base.errors import AnamorphError
from anamorph.frame import Status
from anamorph.gallery import make
from anamorph.gallery.flat_mirror import plane_mirror
from anamorph.gallery.spheres import mirror_ball
from anamorph.gpu.buffers import storage_buffer
from anamorph.gpu.device import get_device
from anamorph.gpu.drawing import submit
from anamorph.methods.virtual.cube_search import bisector, lookup, search
from anamorph.methods.virtual.device_search import DeviceSearch, packed_points
from anamorph.methods.virtual.reflector_maps import FlatReflector, ReflectorMaps, reflector_maps, texel_directions
from anamorph.rays.caster import Caster
from anamorph.reflections.searching import MirrorSearch
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Scene, Sky

PLAIN = replace(BALL, surface=None, parameters=None)


def inside_out(mesh):
    return replace(mesh, faces=mesh.faces[:, ::-1], normals=-mesh.normals)


def scattered(random: np.random.Generator, count: int, nearest: float = 1.0) -> np.ndarray:
    """Points around the ball, so far from it and farther."""
    way = random.normal(size=(count, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    return np.array([0.1, 0.0, 0.2]) + way * (1.0 + nearest * np.exp(random.uniform(0.0, 2.0, count)))[:, None]


def exact(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Which points the ball shows, and where."""
    found = MirrorSearch.of(BALL, EYE).find(points)
    places = np.full_like(points, np.nan)
    places[found.point] = found.position
    return ~np.isnan(places[:, 0]), places


@pytest.mark.parametrize("mesh", [BALL, PLAIN, inside_out(BALL)], ids=["exact", "plain", "concave"])
def test_maps_show_the_surface_in_each_texels_direction(mesh):
    maps = reflector_maps((mesh,), 16)
    assert maps.size == 16 and maps.outside == (mesh.normals[0] @ mesh.positions[0] > 0.0)
    units = texel_directions(16) / np.linalg.norm(texel_directions(16), axis=-1, keepdims=True)
    assert np.abs(maps.center - [0.1, 0.0, 0.2]).max() < 1e-6
    off = 1e-6 if mesh.surface is not None else 0.02
    assert np.abs(maps.positions - units).max() < off
    assert np.abs(maps.normals - (units if maps.outside else -units)).max() < 2.0 * off


def test_lookups_go_on_from_face_to_face():
    maps = reflector_maps((BALL,), 32)
    random = np.random.default_rng(3)
    for _ in range(200):
        place = random.permutation([1.0, 1.0, random.uniform(-1.0, 1.0)]) * random.choice([-1.0, 1.0], 3)
        sides = [tuple(place * (1.0 + 1e-9 * random.uniform(-1.0, 1.0, 3))) for _ in range(6)]
        found = np.array([lookup(maps.positions, each) for each in sides])
        assert np.ptp(found, axis=0).max() < 1e-3
        assert np.abs(found[0] - place / np.linalg.norm(place)).max() < 2e-3


def test_far_points_are_found_where_the_ball_shows_them():
    points = scattered(np.random.default_rng(1), 2000)
    shown, places = exact(points)
    assert shown.sum() > 500
    far = {}
    for iterations in (3, 9, 40):
        found = search(reflector_maps((BALL,), 256), EYE, points[shown], iterations)
        far[iterations] = np.percentile(np.linalg.norm(found[:, :3] - places[shown], axis=1), 95)
        assert (found[:, 11] == 0.0).all()
        assert np.abs(found[:, 9] - path(found[:, :3], points[shown])).max() < 1e-9
    assert far[40] < 1e-4 < far[9] < 0.01 < far[3]
    # The error says how far the bisector is from the normal.
    b = np.array([bisector(tuple(EYE), tuple(p), tuple(v)) for p, v in zip(found[:, :3], points[shown], strict=True)])
    assert np.abs(0.5 * (1.0 - np.einsum("ni,ni->n", b, found[:, 3:6])) - found[:, 10]).max() < 1e-12


def path(places: np.ndarray, points: np.ndarray) -> np.ndarray:
    return np.linalg.norm(places - EYE, axis=1) + np.linalg.norm(points - places, axis=1)


def test_hidden_points_are_mirrored_where_the_way_to_them_enters():
    center = np.array([0.1, 0.0, 0.2])
    points = scattered(np.random.default_rng(2), 2000)
    way = points - EYE
    share = np.clip(-(way @ (EYE - center)) / (way**2).sum(axis=1), 0.0, 1.0)
    hidden = np.linalg.norm(EYE + share[:, None] * way - center, axis=1) < 0.99
    assert hidden.sum() > 50
    found = search(reflector_maps((BALL,), 128), EYE, points[hidden], 40)
    assert (found[:, 11] == 1.0).all()
    unit = way[hidden] / np.linalg.norm(way[hidden], axis=1, keepdims=True)
    ahead = ((center - EYE) * unit).sum(axis=1)
    entered = EYE + (ahead - np.sqrt(1.0 - ((center - EYE) ** 2).sum() + ahead**2))[:, None] * unit
    assert np.percentile(np.linalg.norm(found[:, :3] - entered, axis=1), 90) < 1e-3
    normal = entered - center
    image = points[hidden] - 2.0 * ((points[hidden] - entered) * normal).sum(axis=1, keepdims=True) * normal
    assert np.percentile(np.linalg.norm(found[:, 6:9] - image, axis=1), 90) < 3e-3
    inside = search(reflector_maps((BALL,), 128), EYE, center + 0.9 * unit[:20], 9)
    assert (inside[:, 11] == 2.0).all()
    device = on_device(reflector_maps((BALL,), 128), EYE, np.concatenate([points[hidden], center + 0.9 * unit]), 40)
    assert (np.sign(device["length"]) == np.repeat([-1.0, 0.0], hidden.sum())).all()


def test_what_a_long_body_hides_is_told_by_the_way_through_it():
    """A kettle's middle is not where a way passes it most closely."""
    kettle = next(mesh for mesh in make("kitchen").meshes if mesh.name == "kettle")
    long = replace(
        kettle, positions=kettle.positions * [3.0, 0.6, 1.0], normals=kettle.normals, surface=None, parameters=None
    )
    slopes = long.normals / [3.0, 0.6, 1.0]
    long = replace(long, normals=(slopes / np.linalg.norm(slopes, axis=1, keepdims=True)).astype(np.float32))
    maps = reflector_maps((long,), 128)
    eye = maps.center + np.array([0.5, 0.3, 0.9])
    points = maps.center + np.random.default_rng(5).normal(size=(4000, 3)) * [0.8, 0.3, 0.8]
    way = points - eye
    length = np.linalg.norm(way, axis=1)
    hits = Caster(flatten(Scene("long", (long,), CAMERA))).cast(np.tile(eye, (len(points), 1)), way / length[:, None])
    met = (hits.triangle >= 0) & (hits.distance < length)
    assert 100 < met.sum() < 3000
    told = search(maps, eye, points, 0)[:, 11]
    assert ((told > 0.0) != met).mean() < 2e-3
    device = on_device(maps, eye, points, 0)
    assert ((device["length"] <= 0.0) != met).mean() < 2e-3


def test_maps_of_a_nurbs_body_hold_the_exact_surface():
    kettle = next(mesh for mesh in make("kitchen").meshes if mesh.name == "kettle")
    maps = reflector_maps((kettle,), 16)
    points, normals = (maps.center + maps.positions).reshape(-1, 3), maps.normals.reshape(-1, 3)
    near = kettle.parameters[np.linalg.norm(points[:, None] - kettle.positions, axis=2).argmin(axis=1)]
    places = kettle.surface.parameters(points, near)
    assert np.percentile(np.linalg.norm(kettle.surface.position(places) - points, axis=1), 99) < 1e-7
    assert np.percentile(np.linalg.norm(kettle.surface.normal(places) - normals, axis=1), 99) < 1e-5


def test_the_device_finds_what_the_twin_finds_in_a_bowl():
    maps = reflector_maps((inside_out(BALL),), 128)
    eye = maps.center + np.array([0.1, 0.2, 0.3])
    points = maps.center + 0.4 * np.random.default_rng(7).normal(size=(500, 3))
    found, twin = on_device(maps, eye, points, 9), search(maps, eye, points, 9)
    apart = np.linalg.norm(found["place"] - twin[:, :3], axis=1)
    assert np.median(apart) < 1e-4 and (found["length"] > 0.0).all()


def test_of_a_reflector_in_front_of_the_eye_what_is_straight_ahead_is_in_the_middle():
    """The eye, the point and the ball's middle in one line, also from inside."""
    center = np.array([0.1, 0.0, 0.2])
    ahead = np.array([0.0, 0.6, 0.8])
    outside = search(reflector_maps((BALL,), 64), center + 3.0 * ahead, center + np.outer([5.0, 1.5], ahead), 30)
    assert np.abs(outside[:, :3] - (center + ahead)).max() < 1e-3 and outside[:, 10].max() < 1e-6
    inside = search(reflector_maps((inside_out(BALL),), 64), center - 0.2 * ahead, (center - 0.1 * ahead)[None], 30)
    assert np.abs(np.abs((inside[:, :3] - center) @ ahead) - 1.0).max() < 1e-3


@pytest.mark.parametrize("where", ["on the ball", "in its middle", "at the eye", "grazing"])
def test_where_there_is_no_good_answer_there_is_a_number(where):
    center = np.array([0.1, 0.0, 0.2])
    points = {
        "on the ball": center + np.eye(3),
        "in its middle": center[None],
        "at the eye": EYE[None],
        "grazing": center + np.array([[0.0, 1.0, 0.25], [0.0, 1.0 + 1e-9, 0.0], [1.0, 0.0, -5.0]]),
    }[where]
    found = search(reflector_maps((BALL,), 64), EYE, points, 9)
    assert np.isfinite(found).all()


def on_device(maps: ReflectorMaps | FlatReflector, eye: np.ndarray, points: np.ndarray, iterations: int) -> np.ndarray:
    device = DeviceSearch(maps, storage_buffer(packed_points(points)), len(points))
    encoder = get_device().create_command_encoder()
    device.record(encoder, eye, iterations)
    submit(encoder)
    return device.found()


@pytest.mark.parametrize("mesh", [BALL, PLAIN], ids=["exact", "plain"])
def test_the_device_finds_what_the_twin_finds(mesh):
    maps = reflector_maps((mesh,), 64)
    points = scattered(np.random.default_rng(4), 3000)
    for iterations in (0, 2, 9):
        found, twin = on_device(maps, EYE, points, iterations), search(maps, EYE, points, iterations)
        assert (np.sign(found["length"]) == np.choose(twin[:, 11].astype(int), [1.0, -1.0, 0.0])).mean() > 0.999
        apart = np.linalg.norm(found["place"] - twin[:, :3], axis=1)
        assert np.median(apart) < 1e-6 and np.percentile(apart, 95) < 1e-4
        near = apart < 1e-5
        assert np.abs(found["behind"] - twin[:, 6:9])[near].max() < 1e-3
        assert np.abs(np.abs(found["length"]) - twin[:, 9])[near].max() < 1e-4
        assert np.abs(found["error"] - twin[:, 10])[near].max() < 1e-4


def test_a_search_from_the_last_places_keeps_up_with_an_eye_that_moves():
    maps, points = reflector_maps((BALL,), 128), scattered(np.random.default_rng(6), 3000)
    device = DeviceSearch(maps, storage_buffer(packed_points(points)), len(points), again=True)
    last = None
    for step in range(12):
        eye = EYE + step * np.array([0.02, 0.005, 0.01])
        encoder = get_device().create_command_encoder()
        device.record(encoder, eye, 2)
        submit(encoder)
        last = search(maps, eye, points, 2, last)
    best, cold = search(maps, eye, points, 60), search(maps, eye, points, 2)
    shown = best[:, 11] == 0.0
    away = {
        name: np.linalg.norm(each[shown, :3] - best[shown, :3], axis=1)
        for name, each in (("again", last), ("cold", cold))
    }
    assert shown.sum() > 1000
    for share in (50, 90):
        assert np.percentile(away["again"], share) < 0.4 * np.percentile(away["cold"], share)
    apart = np.linalg.norm(device.found()["place"] - last[:, :3], axis=1)
    assert np.median(apart) < 1e-5 and np.percentile(apart, 95) < 1e-3
    # What was hidden and now is shown starts as if it were new.
    other = EYE * (1.0, 1.0, -1.0)
    changed = (search(maps, other, points, 2, last)[:, 11] == 0.0) != shown
    fresh = search(maps, other, points, 2)
    np.testing.assert_array_equal(search(maps, other, points, 2, last)[changed], fresh[changed])
    assert changed.sum() > 100


def test_a_plane_is_mirrored_on_the_device():
    maps = reflector_maps((plane_mirror("flat", (-1.0, -1.0, 1.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0)),), 8)
    assert isinstance(maps, FlatReflector)
    points = np.array([[0.2, 0.3, 3.0], [0.5, -0.1, 1.5], [0.0, 0.0, -2.0]])
    found = on_device(maps, EYE, points, 9)
    images = points * [1.0, 1.0, -1.0] + [0.0, 0.0, 2.0]
    assert np.abs(found["behind"] - images).max() < 1e-5
    assert (np.sign(found["length"]) == [1.0, 1.0, -1.0]).all()
    assert np.abs(np.abs(found["length"]) - np.linalg.norm(images - EYE, axis=1)).max() < 1e-5
    assert np.abs(found["place"][:2, 2] - 1.0).max() < 1e-6


@pytest.mark.parametrize(
    ("meshes", "said"),
    [
        (lambda: tuple(m for m in make("torus").meshes if m.specular), "not inside|not all of it is seen"),
        (lambda: (replace(spherical_mirror(), surface=None, parameters=None),), "is open"),
        (lambda: tuple(m for m in make("saddle").meshes if m.specular), "is open"),
        (
            lambda: (replace(BALL, normals=np.where(BALL.positions[:, :1] > 0.1, BALL.normals, -BALL.normals)),),
            "its front",
        ),
        (lambda: (dented(),), "neither convex nor concave"),
    ],
    ids=["torus", "open", "saddle", "both sides", "dented"],
)
def test_bodies_without_maps_are_refused_in_one_line(meshes, said):
    with pytest.raises(AnamorphError, match=f"({said}).*leave search=cubemap out") as error:
        reflector_maps(meshes(), 16)
    assert "\n" not in str(error.value)


def dented():
    """A ball with a flat dent that bends in."""
    positions = PLAIN.positions.copy()
    positions[:, 1] = np.where(positions[:, 1] > 0.6, 1.2 - positions[:, 1], positions[:, 1])
    return replace(PLAIN, positions=positions)


def test_finely_cut_things_are_seen_where_rays_see_them():
    scene = Scene("things", (mirror_ball("ball", (0.0, 0.5, 0.0), 0.15), *small_things()), CAMERA, sky=Sky())
    reference, frame = (
        drawn(scene, "raytrace", (320, 240)),
        drawn(scene, "virtual:search=cubemap,iterations=30", (320, 240)),
    )
    specular = reference.specular == 1
    things = specular & (reference.object_id > 0)
    assert things.sum() > 300
    assert (frame.object_id == reference.object_id)[specular].mean() > 0.995
    assert (frame.status[specular] == Status.PROJECTED).all()
    both = things & (frame.object_id == reference.object_id)
    assert np.median(np.linalg.norm(frame.position - reference.position, axis=-1)[both]) < 2e-3


def test_a_flat_mirror_is_exact_in_any_search():
    scene = scene_with(flat_mirror())
    reference, frame = drawn(scene, "raytrace"), drawn(scene, "virtual:search=cubemap")
    specular = reference.specular == 1
    assert (frame.object_id == reference.object_id)[specular].mean() > 0.998
    both = specular & (reference.object_id > 0) & (frame.object_id == reference.object_id)
    assert np.percentile(np.linalg.norm(frame.position - reference.position, axis=-1)[both], 99) < 1e-3


def test_what_stands_before_a_mirror_and_lenses_are_there_in_the_papers_search():
    scene = scene_with(mirror_ball("ball", (0.0, 0.5, 0.0), 0.15))
    reference, frame = drawn(scene, "raytrace"), drawn(scene, "virtual:search=cubemap")
    assert (frame.specular == reference.specular).mean() > 0.9998
    lens = make("magnifier")
    reference, frame = drawn(lens, "raytrace"), drawn(lens, "virtual:search=cubemap")
    assert (frame.status[reference.specular > 0] == reference.status[reference.specular > 0]).mean() > 0.99


def test_what_moves_is_searched_again():
    meshes = (mirror_ball("ball", (0.0, 0.5, 0.0), 0.15), *small_things(), *surroundings()[:1])
    scene = Scene("things", meshes, CAMERA, sky=Sky())
    moved = tuple(
        replace(mesh, positions=mesh.positions + np.float32([0.05, 0.1, 0.0])) if mesh.name == "thing" else mesh
        for mesh in meshes
    )
    session = open_view(scene, "virtual:search=cubemap")
    session.draw(CAMERA)
    geometry = flatten(replace(scene, meshes=moved))
    session.deform(geometry.positions, geometry.normals)
    session.draw(CAMERA)
    other = drawn(replace(scene, meshes=moved), "virtual:search=cubemap")
    assert (session.frame().color == other.color).mean() > 0.999


@pytest.mark.parametrize("option", ["iterations=16", "face=16", "start=last"])
def test_options_of_the_papers_search_are_refused_without_it(option):
    name = option.split("=")[0]
    with pytest.raises(AnamorphError, match=f"{name} is for the paper's search; leave it out, or give search=cubemap"):
        drawn(scene_with(flat_mirror()), f"virtual:{option}")
    with pytest.raises(AnamorphError, match="adaptive grids are divided anew"):
        drawn(scene_with(flat_mirror()), "virtual:search=cubemap,grid=adaptive,start=last")
