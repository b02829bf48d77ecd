"""Silhouettes in maps of surfaces: which edges they are, and that nothing thinner than a texel is missed and proved."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import CAMERA, drawn, flat_mirror, open_view, spherical_mirror, surroundings

from anamorph.frame import Status
from anamorph.gallery import make, names
from anamorph.gallery.solids import box
from anamorph.gallery.spheres import mirror_ball
from anamorph.methods.pervertex.rectangles import SceneMap
from anamorph.methods.pervertex.silhouettes import Edges, edges_of, silhouettes
from anamorph.projection import pinhole_projection
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Diffuse, Mesh, Scene

MAP = (64, 48)


def scene_of(*meshes: Mesh) -> Scene:
    return Scene("test", meshes, Camera(position=(0.0, 0.0, 5.0), target=(0.0, 0.0, 0.0)))


def mesh_of(positions, faces, name: str = "mesh") -> Mesh:
    positions = np.asarray(positions, np.float32)
    return Mesh(
        name, positions, np.asarray(faces, np.int32), np.tile(np.float32([0, 0, 1]), (len(positions), 1)), Diffuse()
    )


def borders(edges: Edges) -> np.ndarray:
    return edges.corners[:, 2] == edges.corners[:, 3]


def test_a_box_has_its_edges_and_the_diagonals_of_its_sides_whatever_vertices_it_has():
    edges = edges_of(flatten(scene_of(box((0, 0, 0), (1, 2, 3)).mesh("box", Diffuse()))))
    assert len(edges.corners) == 18
    assert not borders(edges).any()


def test_a_square_has_four_borders_and_a_diagonal():
    edges = edges_of(flatten(scene_of(mesh_of([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2), (0, 2, 3)]))))
    assert borders(edges).sum() == 4
    assert len(edges.corners) == 5
    (diagonal,) = edges.corners[~borders(edges)]
    assert {diagonal[0], diagonal[1]} == {0, 2}
    assert {diagonal[2], diagonal[3]} == {1, 3}


def test_three_triangles_at_one_edge_have_a_border_each():
    leaves = [(0, 0, 0), (0, 0, 1), (1, 0, 0), (0, 1, 0), (-1, -1, 0)]
    edges = edges_of(flatten(scene_of(mesh_of(leaves, [(0, 1, 2), (0, 1, 3), (0, 1, 4)]))))
    assert len(edges.corners) == 9
    assert borders(edges).all()


def test_meshes_share_no_edge_and_zeros_of_either_sign_are_one_place():
    one = mesh_of([(0.0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)], "one")
    other = mesh_of([(0.0, 0, 0), (1, 0, 0), (0, -1, 0)], [(1, 0, 2)], "other")
    edges = edges_of(flatten(scene_of(one, other)))
    assert borders(edges).all()
    assert edges.first.tolist() == [0, 3, 6]
    folded = mesh_of(
        [(0.0, 0, 0), (1, 0, 0), (0, 1, 0), (-0.0, -0.0, 0), (1, 0, -0.0), (0, -1, 0)], [(0, 1, 2), (4, 3, 5)]
    )
    assert (~borders(edges_of(flatten(scene_of(folded))))).sum() == 1


def eye_map(random: np.random.Generator, meshes: int, near: float) -> tuple[SceneMap, np.ndarray]:
    """A map seen from a random place, and that place."""
    eye = random.normal(size=3)
    eye *= random.uniform(2.0, 4.0) / np.linalg.norm(eye)
    forward = -eye / np.linalg.norm(eye)
    right = np.cross(forward, random.normal(size=3))
    right /= np.linalg.norm(right)
    projection = pinhole_projection(eye, forward, 0.6 * right, 0.5 * np.cross(right, forward), near)
    return SceneMap(projection, MAP, np.ones(meshes, bool)), eye


@pytest.mark.parametrize("seed", range(20))
def test_a_silhouette_has_one_triangle_towards_the_eye_and_one_away_from_it(seed):
    random = np.random.default_rng(seed)
    ball = mirror_ball("ball", (0.1, 0.0, -0.1), 0.7, rows=6, columns=9)
    crate = box((-0.9, -0.4, -0.3), (-0.2, 0.3, 0.6)).mesh("box", Diffuse())
    scene = scene_of(replace(ball, surface=None, parameters=None), crate)
    geometry = flatten(scene)
    edges = edges_of(geometry)
    each, eye = eye_map(random, 2, near=0.01)
    (found,) = silhouettes(edges, geometry.positions, [each])
    a, b, c, d = geometry.positions[edges.corners].astype(float).swapaxes(0, 1)
    first, second = (np.einsum("ij,ij->i", np.cross(b - a, third - a), eye - a) for third in (c, d))
    # The third corners lie on the edge's two sides; both triangles face the eye where these products differ in sign.
    sure = np.minimum(abs(first), abs(second)) > 1e-9
    expected = borders(edges) | (first * second > 0.0)
    assert abs(len(found) - expected.sum()) <= (~sure).sum()
    clip = each.projection.clip
    ends = np.stack([a, b], axis=1)[expected & sure] @ clip[:, :3].T + clip[:, 3]
    ends = ends[..., :3] / ends[..., 3:]
    inside = (abs(ends[..., :2]) < 1.0).all(axis=(1, 2))
    assert inside.sum() > 10
    for start, end in ends[inside]:
        apart = np.abs(found[:, :3] - start).max(axis=1) + np.abs(found[:, 4:7] - end).max(axis=1)
        assert apart.min() < 1e-5


def test_silhouettes_end_at_the_near_plane_and_beside_the_map():
    """A bar that runs from behind the eye far out to the right of what the map sees."""
    scene = scene_of(mesh_of([(0.0, 0.1, 9.0), (300.0, 0.1, -9.0), (300.0, 0.2, -9.0)], [(0, 1, 2)]))
    geometry = flatten(scene)
    projection = pinhole_projection(np.array([0.0, 0.0, 5.0]), -np.eye(3)[2], np.eye(3)[0], np.eye(3)[1], 0.5)
    each = SceneMap(projection, MAP, np.ones(1, bool))
    (found,) = silhouettes(edges_of(geometry), geometry.positions, [each])
    assert (found[:, [2, 6]] <= 1.0 + 1e-6).all()
    assert (abs(found[:, [0, 1, 4, 5]]) <= 1.2).all()
    (hidden,) = silhouettes(edges_of(geometry), geometry.positions, [replace(each, visible=np.zeros(1, bool))])
    assert len(hidden) == 0


def known_and_wrong(scene: Scene, size: tuple[int, int]) -> tuple[int, int]:
    """How many pixels say that they know what they see, and how many of them see another object than traced ones."""
    traced, frame = drawn(scene, "raytrace:dispersion=false", size), drawn(scene, "pervertex", size)
    # At its own outline a body may be seen by one of them alone: both have the pixel's middle on an edge.
    known = np.isin(frame.status, [Status.PROVED, Status.SKY]) & (frame.specular > 0)
    known &= frame.specular == traced.specular
    return int(known.sum()), int((known & (frame.object_id != traced.object_id)).sum())


def thin_things() -> list[Mesh]:
    """Wires before the sky and the boxes, and sheets that lie close on the floor."""
    wires = [box((x, 0.2, 1.2), (x + 0.001, 1.4, 1.201)) for x in np.linspace(-1.0, 1.0, 9)]
    wires += [box((-1.0, y, 1.9), (1.0, y + 0.0007, 1.9007)) for y in np.linspace(0.3, 1.3, 7)]
    sheets = [box((x, 0.001, z), (x + 0.3, 0.002, z + 0.02)) for x in (-0.6, 0.1, 0.5) for z in (1.0, 1.5, 2.1)]
    return [each.mesh(f"thin-{number}", Diffuse()) for number, each in enumerate([*wires, *sheets])]


@pytest.mark.parametrize(
    "mirror",
    [flat_mirror(), spherical_mirror(), spherical_mirror(-1.4), mirror_ball("ball", (0.0, 0.5, 0.0), 0.15)],
    ids=["flat", "convex", "concave", "ball"],
)
def test_nothing_is_proved_that_something_thinner_than_a_texel_hides(mirror):
    scene = Scene("thin", (mirror, *surroundings(), *thin_things()), CAMERA)
    known, wrong = known_and_wrong(scene, (160, 120))
    assert known > 1000
    assert wrong == 0


@pytest.mark.parametrize("name", names())
def test_what_is_known_is_right_on_every_built_in_scene(name):
    known, wrong = known_and_wrong(make(name), (256, 192))
    assert known > 1000
    assert wrong == 0


def test_silhouettes_follow_what_moves():
    scene = Scene("moved", (spherical_mirror(), *surroundings(), *thin_things()), CAMERA)
    session = open_view(scene, "pervertex")
    session.draw(CAMERA)
    maps = session.diagnostics()["maps"]
    geometry = flatten(scene)
    moved = geometry.positions.copy()
    moved[geometry.vertex_object > 1] += np.float32([0.3, 0.0, 0.1])
    session.deform(moved, geometry.normals)
    session.draw(CAMERA)
    again = open_view(replace(scene, meshes=tuple(
        mesh if mesh.specular else replace(mesh, positions=mesh.positions + np.float32([0.3, 0.0, 0.1]))
        for mesh in scene.meshes
    )), "pervertex")  # fmt: skip
    again.draw(CAMERA)
    frame, expected = session.frame(seen=True), again.frame(seen=True)
    assert maps.rectangles.maps
    assert (frame.object_id == expected.object_id).mean() > 0.9999
    assert (frame.status == expected.status).mean() > 0.9999


def test_triangles_that_part_have_a_border_each_from_then_on():
    corners = np.float32([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 0), (1, 0, 0), (0, -1, 0)])
    geometry = flatten(scene_of(mesh_of(corners, [(0, 1, 2), (4, 3, 5)])))
    edges = edges_of(geometry)
    assert (~borders(edges)).sum() == 1
    assert {frozenset(pair) for pair in edges.twins.tolist()} == {frozenset((0, 3)), frozenset((1, 4))}
    together = replace(geometry, positions=geometry.positions + np.float32(1.0))
    assert edges.moved(together) is edges
    apart = geometry.positions.copy()
    apart[3:] -= np.float32([0.0, 0.5, 0.0])
    parted = edges.moved(replace(geometry, positions=apart))
    assert borders(parted).all() and len(parted.corners) == 6
