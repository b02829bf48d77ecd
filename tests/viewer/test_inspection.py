"""What the viewer tells of one pixel, against closed forms and against the frames of the reference."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scenes import CAMERA, SIZE, drawn, flat_mirror, scene_with, sky_scene

from anamorph import gallery
from anamorph.base.errors import AnamorphError
from anamorph.frame import Frame
from anamorph.gallery.flat_mirror import plane_mirror
from anamorph.gallery.solids import box, grid
from anamorph.measure.errors import measure
from anamorph.scene.camera import Camera
from anamorph.scene.model import Diffuse, Glass, Scene
from anamorph.viewer.facts import Inspection
from anamorph.viewer.inspection import inspect, trace_path
from anamorph.viewer.measured import measure_half
from anamorph.viewer.space import PreparedScene


@cache
def space_of(name: str) -> PreparedScene:
    return PreparedScene(scene_with(flat_mirror()) if name == "test" else gallery.make(name))


@cache
def frame_of(name: str, method: str) -> Frame:
    return drawn(space_of(name).scene, method)


def inspected(name: str, pixel: tuple[int, int], method: str = "pervertex") -> Inspection:
    space = space_of(name)
    return inspect(
        space, space.scene.camera, pixel, method, measure_half(frame_of(name, "raytrace"), frame_of(name, method))
    )


def points(inspection: Inspection) -> np.ndarray:
    return np.array([stop.point for stop in inspection.path])


def through(camera: Camera, pixel: tuple[int, int]) -> np.ndarray:
    return camera.directions(np.add(pixel, 0.5), SIZE)


def test_in_a_flat_mirror_the_path_is_the_straight_line_from_the_mirrored_eye():
    looked = 0
    eye = np.array(CAMERA.position)
    for pixel in [(60, 40), (80, 60), (95, 75), (70, 80)]:
        found = inspected("test", pixel)
        direction = through(CAMERA, pixel)
        at_mirror = eye - eye[2] / direction[2] * direction
        names = [stop.name for stop in found.path]
        assert names[:2] == ["eye", "mirror"] and found.path[0].point == CAMERA.position
        assert points(found)[1] == pytest.approx(at_mirror, abs=1e-6)
        way = points(found)[2] - eye * [1.0, 1.0, -1.0]
        assert way / np.linalg.norm(way) == pytest.approx(direction * [1.0, 1.0, -1.0], abs=1e-6)
        if found.seen == "sky":
            assert found.point is None and found.distance is None
            continue
        looked += 1
        # What the method shows is exact there, and lies as far away as in the mirrored scene.
        assert found.seen == found.reference == names[2]
        assert found.point == pytest.approx(points(found)[2], abs=2e-4)
        assert found.distance == pytest.approx(np.linalg.norm(way), rel=1e-4)
        assert found.status == "proved"
    assert looked >= 2


def test_what_is_seen_directly_has_one_leg():
    frame = frame_of("test", "pervertex")
    rows, columns = np.nonzero((frame.specular == 0) & (frame.object_id == 2))
    pixel = int(columns[-1]), int(rows[-1])
    found = inspected("test", pixel)
    assert [stop.name for stop in found.path] == ["eye", "floor"] == ["eye", found.seen]
    assert found.point == pytest.approx(frame.position[pixel[1], pixel[0]])
    assert found.distance == pytest.approx(np.linalg.norm(np.subtract(found.point, CAMERA.position)))
    assert found.status == "direct" and found.angular_mrad is None and found.pixels is None


def test_a_sky_pixel_goes_as_far_as_the_scene_is_large():
    scene = sky_scene(flat_mirror())
    space = PreparedScene(scene)
    frame = drawn(scene, "raytrace")
    for pixel, names in [((1, 1), ["eye", "sky"]), ((80, 60), ["eye", "mirror", "sky"])]:
        found = inspect(space, CAMERA, pixel, "raytrace", measure_half(frame, frame))
        assert [stop.name for stop in found.path] == names and found.seen == found.reference == "sky"
        assert found.point is None and found.distance is None and found.status == "sky"
        last = points(found)[-1] - points(found)[-2]
        assert np.linalg.norm(last) == pytest.approx(space.surroundings.diagonal, rel=1e-5)
        assert last / np.linalg.norm(last) == pytest.approx(frame.position[pixel[1], pixel[0]], abs=1e-5)


@pytest.mark.parametrize("name", ["test", "car-mirror", "spectacles-minus", "facing-mirrors"])
def test_the_path_ends_where_the_truth_does(name):
    space, frame = space_of(name), frame_of(name, "raytrace")
    scene, ended = space.scene, 0
    random = np.random.default_rng(2)
    for row, column in random.permutation(np.argwhere(frame.specular > 0))[:40]:
        path = trace_path(space, scene.camera, SIZE, (int(column), int(row)))
        assert path[1].name == scene.meshes[frame.specular[row, column] - 1].name
        assert np.isfinite([stop.point for stop in path]).all() and len(path) <= 10
        number, position = frame.object_id[row, column], frame.position[row, column].astype(float)
        end = np.array(path[-1].point)
        if number == 0:
            assert path[-1].name == "sky"
            way = end - path[-2].point
            assert way / np.linalg.norm(way) == pytest.approx(position, abs=1e-5)
            continue
        ended += 1
        assert path[-1].name == scene.meshes[number - 1].name
        assert end == pytest.approx(position, rel=1e-5, abs=1e-6 * space.surroundings.diagonal)
    assert ended > 10


def test_every_bend_of_a_lens_lies_on_its_face():
    found = inspected("spectacles-minus", (80, 60))
    assert [stop.name for stop in found.path[:3]] == ["eye", "lens/back", "lens/front"]
    for stop in found.path[1:3]:
        mesh = next(mesh for mesh in space_of("spectacles-minus").scene.meshes if mesh.name == stop.name)
        uv = mesh.surface.parameters(np.array([stop.point]))
        assert mesh.surface.position(uv)[0] == pytest.approx(np.array(stop.point), abs=1e-6)


def test_a_path_is_followed_into_glass_and_round_a_total_reflection():
    # A ray enters the front of a block, meets its right side at more than the critical angle, and leaves by the back.
    block = box((-0.2, -0.5, -0.5), (0.2, 0.5, 0.5)).mesh("block", Glass(index=1.5))
    wall = grid((-3.0, -3.0, -2.0), (6.0, 0.0, 0.0), (0.0, 6.0, 0.0)).mesh("wall", Diffuse())
    slope = np.tan(np.radians(30.0))
    camera = Camera((-slope, 0.0, 1.5), (0.0, 0.0, 0.5), field_of_view=0.5)
    scene = Scene("block", (block, wall), camera)
    size = (3, 3)
    inside = np.tan(np.arcsin(0.5 / 1.5))
    side = 0.5 - 0.2 / inside
    across = 0.2 - inside * (side + 0.5)
    wanted = [camera.position, (0, 0, 0.5), (0.2, 0, side), (across, 0, -0.5), (across - 1.5 * slope, 0, -2.0)]
    path = trace_path(PreparedScene(scene), camera, size, (1, 1))
    assert [stop.name for stop in path] == ["eye", "block", "block", "block", "wall"]
    assert np.array([stop.point for stop in path]) == pytest.approx(np.array(wanted), abs=1e-5)
    frame = drawn(scene, "raytrace", size)
    assert (
        inspect(PreparedScene(scene), camera, (1, 1), "raytrace", measure_half(frame, frame)).status
        == "total reflection"
    )


def test_a_path_stops_after_eight_bounces():
    mirrors = (
        plane_mirror("front", (-2.0, -2.0, 0.0), (4.0, 0.0, 0.0), (0.0, 4.0, 0.0)),
        plane_mirror("back", (2.0, -2.0, 1.0), (-4.0, 0.0, 0.0), (0.0, 4.0, 0.0)),
    )
    camera = Camera((0.0, 0.0, 0.5), (0.05, 0.0, 0.0), field_of_view=0.5)
    scene = Scene("tunnel", mirrors, camera)
    path = trace_path(PreparedScene(scene), camera, (3, 3), (1, 1))
    # The ninth mirror ends it.
    assert [stop.name for stop in path] == ["eye", *["front", "back"] * 4, "front"]
    turns = np.arange(9)
    wanted = np.column_stack([0.05 + 0.1 * turns, np.zeros(9), turns % 2])
    assert np.array([stop.point for stop in path[1:]]) == pytest.approx(wanted, abs=1e-6)
    frame = drawn(scene, "raytrace", (3, 3))
    found = inspect(PreparedScene(scene), camera, (1, 1), "raytrace", measure_half(frame, frame))
    assert found.status == "outside" and found.seen == found.reference == "front"
    assert found.distance == pytest.approx(np.hypot(8.5, 0.85), rel=1e-5)


def test_errors_are_those_of_the_maps():
    maps = measure(frame_of("car-mirror", "raytrace"), frame_of("car-mirror", "environment")).maps
    row, column = np.argwhere(maps.specular & ~maps.silhouette & (maps.angular > 5.0))[7].tolist()
    found = inspected("car-mirror", (column, row), "environment")
    assert found.angular_mrad == maps.angular[row, column] and found.pixels == maps.pixels[row, column]
    assert not found.silhouette
    row, column = np.argwhere(maps.silhouette)[3].tolist()
    assert inspected("car-mirror", (column, row), "environment").silhouette


def test_what_shows_nothing_says_so():
    frame = frame_of("test", "pervertex")
    empty = replace(frame, object_id=np.zeros_like(frame.object_id), position=np.zeros_like(frame.position))
    found = inspect(space_of("test"), CAMERA, (80, 60), "pervertex", measure_half(frame_of("test", "raytrace"), empty))
    assert found.seen == "nothing" and found.point is None and found.distance is None
    assert found.reference == found.path[-1].name != "nothing"


def test_what_the_method_sees_directly_lies_straight_ahead_whatever_the_truth_does():
    frame = frame_of("test", "pervertex")
    direct = replace(frame, specular=np.zeros_like(frame.specular))
    (column, row), *_ = [(x, y) for y, x in np.argwhere((frame.specular > 0) & (frame.object_id > 0)).tolist()]
    measured = measure_half(frame_of("test", "raytrace"), direct)
    found = inspect(space_of("test"), CAMERA, (column, row), "pervertex", measured)
    assert len(found.path) > 2
    assert found.distance == pytest.approx(np.linalg.norm(np.subtract(frame.position[row, column], CAMERA.position)))


@pytest.mark.parametrize("pixel", [(-1, 0), (0, -1), (SIZE[0], 0), (0, SIZE[1])])
def test_a_pixel_outside_is_refused(pixel):
    with pytest.raises(AnamorphError, match=r"pixel .*outside the image of 160 x 120"):
        inspected("test", pixel)
