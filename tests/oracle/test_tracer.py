"""The second tracer against closed forms, and that it shares nothing with what it judges."""

from __future__ import annotations

import ast
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from oracle import meshes, parts
from oracle.mirror_families import wavy_meshes
from oracle.scene import GLASS, MIRROR, Camera, Mesh, Part, Scene, Shape, Trim
from oracle.tracer import LIMIT, TOTAL, Seen, Tracer
from oracle.triangles import meet_triangle

ALONE = (
    "scene", "vectors", "quadrics", "sags", "trims", "shapes", "triangles", "tracer", "subrays", "judging", "meshes",
    "parts", "surroundings", "mirror_families",
)  # fmt: skip
"""The modules that stand without the package."""

NOTHING = Mesh(np.zeros((3, 3)), np.tile([0.0, 0.0, 1.0], (3, 1)), np.array([[0, 1, 2]]))
CAMERA = Camera((0.0, 0.0, 1.0), (0.0, 0.0, 0.0), 40.0)


def body(material: str, kind: str, numbers=(), origin=(0.0, 0.0, 0.0), axes=None, side=1.0, index=1.0, trim=None):
    shape = Shape(kind, np.array(origin), np.eye(3) if axes is None else axes, numbers, side)
    return Part(kind, NOTHING, material, index, shape, trim or Trim())


def seen_by(origins, directions, *bodies: Part, bounces: int = 8) -> Seen:
    directions = np.atleast_2d(np.asarray(directions, float))
    rays = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    return Tracer(Scene("test", bodies, CAMERA), bounces).trace(origins, rays)


@pytest.mark.parametrize("module", ALONE)
def test_it_imports_neither_the_package_nor_embree(module):
    tree = ast.parse((Path(__file__).parent / f"{module}.py").read_text())
    names = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    names |= {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    names |= {
        f"oracle.{alias.name}"
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.module == "oracle"
        for alias in node.names
    }
    assert {name.split(".")[0] for name in names} & {"anamorph", "embreex", "embree", "trimesh"} == set()
    own = {name.removeprefix("oracle.") for name in names if name.startswith("oracle.")}
    assert own <= set(ALONE)


def test_a_flat_mirror_shows_the_mirrored_point():
    for mirror in (body(MIRROR, "plane"), parts.wall("mirror", (0, 0, 0), (5, 0, 0), (0, 5, 0), MIRROR)):
        wall = parts.wall("wall", (0.0, 0.0, 3.0), (-9.0, 0.0, 0.0), (0.0, 9.0, 0.0))
        way = np.array([0.3, -0.2, -1.0])
        seen = seen_by([0.1, 0.2, 1.0], way, mirror, wall)
        # As if it went straight on to the wall's image, 4 m down.
        straight = np.array([0.1, 0.2, 1.0]) + 4.0 * way
        np.testing.assert_allclose(seen.position[0], straight * [1, 1, -1], atol=1e-14)
        assert (seen.object_id[0], seen.specular[0], seen.bounces[0]) == (2, 1, 1)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_sphere_turns_a_parallel_ray_by_twice_its_angle(side):
    angle, radius = 0.4, 0.7
    ball = body(MIRROR, "sphere", (radius,), side=side)
    start = [radius * math.sin(angle), 0.0, 3.0 if side > 0.0 else 0.0]
    seen = seen_by(start, [0.0, 0.0, -1.0], ball, bounces=1)
    turned = [math.sin(2.0 * angle), 0.0, math.cos(2.0 * angle)]
    np.testing.assert_allclose(seen.direction[0], np.array(turned) * [side, 1.0, 1.0], atol=1e-14)
    place = np.array([math.sin(angle), 0.0, side * math.cos(angle)]) * radius
    np.testing.assert_allclose(seen.origin[0], place, atol=1e-14)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_a_ray_in_a_hollow_ball_goes_round_by_equal_steps_at_any_scale(scale):
    """However flat it runs along the wall: nothing is too near to be met."""
    for grazing in (0.5, 1e-2, 1e-4):
        ball = body(MIRROR, "sphere", (scale,), side=-1.0)
        # From the middle of a chord that meets the wall at this angle.
        seen = seen_by([-scale * math.cos(grazing), 0.0, 0.0], [0.0, 0.0, -1.0], ball)
        assert seen.bounces[0] == 8 and seen.flags[0] & LIMIT
        angle = math.atan2(seen.direction[0, 0], -seen.direction[0, 2])
        expected = math.remainder(16.0 * grazing, 2.0 * math.pi)
        assert angle == pytest.approx(expected, rel=1e-15 / grazing**2 + 1e-13)


def test_a_slab_shifts_a_ray_as_snell_says():
    thickness, index, angle = 0.03, 1.6, 0.8
    back_axes = np.diag([1.0, -1.0, -1.0])
    front = body(GLASS, "plane", index=index)
    back = body(GLASS, "plane", origin=(0.0, 0.0, -thickness), axes=back_axes, index=index)
    wall = parts.wall("wall", (0.0, 0.0, -1.0), (9.0, 0.0, 0.0), (0.0, 9.0, 0.0))
    seen = seen_by([0.0, 0.0, 1.0], [math.sin(angle), 0.0, -math.cos(angle)], front, back, wall)
    inside = math.asin(math.sin(angle) / index)
    across = (2.0 - thickness) * math.tan(angle) + thickness * math.tan(inside)
    np.testing.assert_allclose(seen.position[0], [across, 0.0, -1.0], atol=1e-14)
    assert seen.bounces[0] == 2 and seen.specular[0] == 1 and seen.last[0] == 2 and not seen.flags[0]


def test_a_prism_at_least_deviation():
    index, apex = 1.5, math.radians(50.0)
    turn = 2.0 * math.asin(index * math.sin(0.5 * apex)) - apex
    normals = [np.array([math.sin(0.5 * apex), 0.0, side * math.cos(0.5 * apex)]) for side in (1.0, -1.0)]
    faces = [body(GLASS, "plane", origin=(-1.0, 0, 0), axes=parts.axes_toward(n), index=index) for n in normals]
    # The glass lies at x < -1; the ray crosses it symmetrically.
    way = np.array([math.sin(0.5 * turn), 0.0, -math.cos(0.5 * turn)])
    entry = np.array([-2.0, 0.0, math.tan(0.5 * apex)])
    seen = seen_by(entry - way, way, *faces)
    assert seen.bounces[0] == 2
    deviation = math.acos(np.clip(seen.direction[0] @ way, -1.0, 1.0))
    assert deviation == pytest.approx(turn, abs=1e-7)


def test_light_beyond_the_critical_angle_stays_inside():
    glass = body(GLASS, "plane", index=1.5)
    inside = math.asin(1.0 / 1.5)
    for angle, total in ((inside - 1e-6, False), (inside + 1e-6, True)):
        seen = seen_by([0.0, 0.0, -1.0], [math.sin(angle), 0.0, math.cos(angle)], glass)
        assert bool(seen.flags[0] & TOTAL) == total
        assert (seen.direction[0, 2] < 0.0) == total


def test_a_thick_lens_has_the_lens_makers_back_focus():
    index, front, back, thickness = 1.6, 12.0, 5.0, 0.006
    made = parts.lens("lens", np.zeros(3), (0.0, 0.0, -1.0), 2 * (front,), 2 * (back,), thickness, 0.02, index)
    height = 1e-6
    # Light from the front runs along +z, and leaves by the back.
    seen = seen_by([0.0, height, -1.0], [0.0, 0.0, 1.0], *made)
    first, second = (index - 1.0) * front, (index - 1.0) * back
    power = first + second - thickness / index * first * second
    focus = (1.0 - thickness / index * first) / power
    crossing = seen.origin[0, 2] - seen.origin[0, 1] * seen.direction[0, 2] / seen.direction[0, 1]
    assert seen.bounces[0] == 2
    assert crossing - 0.5 * thickness == pytest.approx(focus, rel=1e-8)


def test_a_cone_reflects_by_its_slope():
    narrowing = -0.5
    cone = body(MIRROR, "cone", (0.4, narrowing), trim=Trim(low=0.0, high=0.5))
    seen = seen_by([2.0, 0.0, 0.2], [-1.0, 0.0, 0.0], cone)
    assert seen.origin[0] == pytest.approx([0.3, 0.0, 0.2])
    lean = 2.0 * math.atan(-narrowing)
    assert seen.direction[0] == pytest.approx([math.cos(lean), 0.0, math.sin(lean)])
    # Above its end, and beyond its apex, there is nothing.
    assert not seen_by([2.0, 0.0, 0.6], [-1.0, 0.0, 0.0], cone).specular[0]


LIKE = {
    "round toroid": (("toroid", (0.8, 0.8), 0.0), ("sphere", (1.25,), -1.25)),
    "round asphere": (("asphere", (0.8, 0.0), 0.0), ("sphere", (1.25,), -1.25)),
    "concave asphere": (("asphere", (-0.8, 0.0), 0.0), ("sphere", (1.25,), 1.25)),
    "long toroid": (("toroid", (0.8, 0.0), 0.0), ("cylinder", (1.25,), -1.25)),
    "flat asphere": (("asphere", (0.0, 0.0), 0.0), ("plane", (), 0.0)),
}


@pytest.mark.parametrize("case", LIKE)
def test_shapes_that_are_the_same_show_the_same(case):
    """By two ways to meet them, one of closed form and one of steps along the ray."""
    random = np.random.default_rng(3)
    trim = Trim(radius=0.5, low=-0.3, high=0.3)
    both = []
    for kind, numbers, height in LIKE[case]:
        # A cylinder's axis lies along the toroid's up.
        axes = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]) if kind == "cylinder" else np.eye(3)
        side = -1.0 if height > 0.0 else 1.0
        both.append(body(MIRROR, kind, numbers, (0.0, 0.0, height), axes, side, trim=trim))
    origins = np.column_stack([random.uniform(-1.0, 1.0, (4000, 2)), random.uniform(0.2, 1.0, 4000)])
    ways = np.column_stack([random.uniform(-0.5, 0.5, (4000, 2)), np.zeros(4000)]) - origins
    seen = [seen_by(origins, ways, one) for one in both]
    assert (seen[0].specular > 0).mean() > 0.2
    # Within rounding of the trim's border one may be met and the other not.
    alike = seen[0].bounces == seen[1].bounces
    assert alike.mean() > 0.999
    np.testing.assert_allclose(seen[0].direction[alike], seen[1].direction[alike], atol=1e-9)


def test_a_fine_mesh_shows_what_its_cylinder_does():
    around = parts.tube("tube", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.3, 0.3), 1.0, 720, 4)
    exact = body(MIRROR, "cylinder", (0.3,), trim=Trim(low=0.0, high=1.0))
    ways = np.column_stack([np.full(99, -1.0), np.linspace(-0.25, 0.25, 99), np.full(99, 0.1)])
    seen = [seen_by([1.0, 0.0, 0.4], ways, one) for one in (around, exact)]
    assert (seen[1].specular > 0).sum() > 50
    np.testing.assert_allclose(seen[0].direction, seen[1].direction, atol=2e-3)


def test_the_back_of_a_mirror_ends_a_path():
    seen = seen_by([0.0, 0.0, -1.0], [0.0, 0.0, 1.0], body(MIRROR, "plane"))
    assert (seen.object_id[0], seen.specular[0], seen.bounces[0]) == (1, 0, 0)


def test_the_tree_finds_what_a_search_of_all_triangles_does():
    random = np.random.default_rng(5)
    corners = random.uniform(-1.0, 1.0, (400, 1, 3)) + 0.2 * random.normal(size=(400, 3, 3))
    normals = np.tile([0.0, 0.0, 1.0], (1200, 1))
    soup = [Part(str(i), Mesh(corners[i], normals[:3], np.array([[0, 1, 2]]))) for i in range(400)]
    origins, ways = random.uniform(-2.0, 2.0, (500, 3)), random.normal(size=(500, 3))
    # Along an axis a ray never leaves a box by two of its sides.
    ways[:60] = np.eye(3)[random.integers(3, size=60)]
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    found = Tracer(Scene("soup", tuple(soup), CAMERA)).trace(origins, ways).object_id
    for origin, way, number in zip(origins, ways, found, strict=True):
        distances = []
        for part in soup:
            a, b, c = part.mesh.positions
            distances.append(meet_triangle(np.stack([a, b - a, c - a]), tuple(origin), tuple(way))[0])
        hits = np.where(np.array(distances) > 0.0, distances, np.inf)
        assert number == (0 if np.isinf(hits.min()) else hits.argmin() + 1)


def test_a_scene_moved_and_scaled_shows_the_same():
    scene = wavy_meshes(np.random.default_rng(1))
    # Without float32 between: the boxes' and the mirror's corners go along exactly.
    scene = replace(scene, parts=scene.parts[:12])
    points = np.random.default_rng(2).uniform(0.0, 64.0, (4000, 2))
    seen = [Tracer(each).look(each.camera, points, (64, 64)) for each in (scene, scene.moved(2.0**20))]
    assert (seen[0].object_id == seen[1].object_id).all() and (seen[0].specular > 0).mean() > 0.2
    np.testing.assert_allclose(seen[0].direction, seen[1].direction, atol=1e-12)


def test_the_edge_of_a_lens_is_round_and_meets_its_faces():
    front, back, edge = parts.lens("lens", np.ones(3), (0.2, 0.1, -1.0), (4.0, 3.0), (-2.0, -1.0), 0.02, 0.05, 1.5, 3)
    axes = front.trim.axes
    count = len(edge.finer.positions) // 2
    for part, rim in ((front, edge.finer.positions[:count]), (back, edge.finer.positions[count:])):
        across = (rim - front.trim.origin) @ axes[:2].T
        # Rounded to float32.
        assert np.abs(np.linalg.norm(across, axis=1) - 0.05).max() < 2e-7
        local = (rim - part.shape.origin) @ part.shape.axes.T
        assert np.abs(local[:, 2] - meshes.heights(part.shape, local[:, :2])[0]).max() < 2e-7
    assert len(edge.mesh.positions) == 36
