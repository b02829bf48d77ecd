"""Frames of `trilinear:edges=straight`: their pieces, what they come to, and options that are refused."""

from __future__ import annotations

import numpy as np
import pytest
from jittered_rays import jittered
from scenes import drawn, scene_with, spherical_mirror

from anamorph import cameras
from anamorph.base.errors import AnamorphError
from anamorph.bench.thesis.configurations import configuration_scene
from anamorph.bench.thesis.printed import configurations
from anamorph.frame import Frame, Status, View
from anamorph.measure.errors import silhouettes
from anamorph.methods import Specification
from anamorph.methods.trilinear.straight import straight_pieces
from anamorph.raymesh import RayMesh
from anamorph.scene.camera import Camera
from anamorph.scene.model import Diffuse, Mesh, Scene

SIDE = 128
STRAIGHT = "trilinear:edges=straight"
NAMES = tuple(configurations())


def shown(scene: Scene, camera: RayMesh, specification: str, size: tuple[int, int] = (SIDE, SIDE)) -> Frame:
    session = Specification.parse(specification).open(View(scene, camera, size))
    session.draw(camera)
    return session.frame(seen=True)


def rasterised(camera: RayMesh, corners: np.ndarray, size: tuple[int, int], **options) -> tuple[np.ndarray, np.ndarray]:
    """Whether each pixel's middle is in a piece within its ray triangle, and whether that is clear of any border."""
    x, y = np.meshgrid(np.arange(size[0]) + 0.5, np.arange(size[1]) + 0.5)
    middles = np.stack([x.ravel(), y.ravel()], axis=1)
    image, origins, ways = (each[camera.faces] for each in (camera.image, camera.origins, camera.directions))
    count = len(image)
    pairs = np.column_stack([np.repeat(np.arange(count), len(corners)), np.tile(np.arange(len(corners)), count)])
    pieces = straight_pieces(image, origins, ways, corners, pairs, **options)
    covered, doubtful = np.zeros((2, len(middles)), bool)
    for places, pair in zip(pieces.place.astype(float), pieces.pair, strict=True):
        outline = image[pairs[pair, 0]]
        within, near = inside(places, middles)
        own, border = inside(outline[:, :2] / outline[:, 2:], middles)
        covered |= within & own
        doubtful |= near | border
    return covered.reshape(size[::-1]), ~doubtful.reshape(size[::-1])


def inside(corners: np.ndarray, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Whether places (N, 2) are in a triangle (3, 2), and whether they are close to its outline."""
    start, stop = corners, np.roll(corners, -1, axis=0)
    along = stop - start
    offset = places[:, None] - start
    sides = along[:, 0] * offset[..., 1] - along[:, 1] * offset[..., 0]
    length = np.maximum(np.linalg.norm(along, axis=1), 1e-12)
    share = np.clip((offset * along).sum(axis=-1) / length**2, 0.0, 1.0)
    far = np.linalg.norm(offset - share[..., None] * along, axis=-1).min(axis=1)
    return (sides >= 0.0).all(axis=1) | (sides <= 0.0).all(axis=1), far < 2e-3


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("clip", ["scene", "screen"])
@pytest.mark.parametrize("divided", ["", ",slices=3", ",tessellate=4"])
def test_pixels_are_those_of_the_pieces(name, clip, divided):
    scene, camera = configuration_scene(name, SIDE)
    frame = shown(scene, camera, f"{STRAIGHT},clip={clip}{divided}")
    options = {key: int(value) for key, value in (part.split("=") for part in divided.split(",") if part)}
    corners = np.asarray(scene.meshes[0].positions, float)[scene.meshes[0].faces]
    covered, sure = rasterised(camera, corners, (SIDE, SIDE), scene_clip=clip == "scene", **options)
    assert covered.any() and sure.mean() > 0.5
    assert ((frame.object_id == 1) == covered)[sure].all()


def wrong_share(name: str, specification: str) -> float:
    """The share of the exact shape's pixels that are another.

    A pixel whose middle is on a side of the ray triangle is of it; of pieces that end there it may be of none.
    """
    scene, camera = configuration_scene(name, SIDE)
    exact, frame = shown(scene, camera, "trilinear"), shown(scene, camera, specification)
    row, column = np.mgrid[:SIDE, :SIDE] + 0.5
    places = np.stack([column, row, np.ones_like(row)], axis=-1)
    within = np.abs(places @ np.linalg.inv(camera.image[camera.faces[0]])).min(axis=-1) > 1e-6
    other = (frame.object_id > 0) != (exact.object_id > 0)
    return float((other & within).sum() / max(((exact.object_id > 0) & within).sum(), 1))


@pytest.mark.parametrize("way", ["slices", "tessellate"])
@pytest.mark.parametrize("clip", ["scene", "screen"])
def test_divided_more_finely_straight_edges_come_to_the_exact_ones(way, clip):
    errors = [
        np.mean([wrong_share(name, f"{STRAIGHT},clip={clip},{way}={count}") for name in NAMES[::2]])
        for count in (1, 6, 48)
    ]
    assert errors[0] > 0.02
    assert errors[1] < 0.5 * errors[0] and errors[2] <= 0.02


def test_colors_come_to_the_exact_ones_too():
    scene = scene_with(spherical_mirror())
    exact = drawn(scene, "trilinear:bounces=1")
    errors = []
    for count in (1, 8):
        frame = drawn(scene, f"{STRAIGHT},tessellate={count}")
        assert np.isfinite(frame.color).all() and np.isfinite(frame.position).all()
        counted = (frame.object_id == exact.object_id) & (exact.specular > 0) & (exact.object_id > 0)
        assert counted.sum() > 3000
        errors.append(np.abs(frame.position - exact.position)[counted].mean())
    assert errors[1] < 0.1 * errors[0]


def cracked() -> tuple[Scene, RayMesh]:
    """Ray triangles whose rays go where they will, and a scene triangle that is longer than what each of them sees."""
    random = np.random.default_rng(11)
    camera = jittered((SIDE, SIDE), False, random)
    corners = np.float32([[-2.0, -1.6, 2.0], [2.2, -1.0, 2.6], [0.1, 2.4, 1.7]])
    normals = np.tile(np.float32([0.0, 0.0, -1.0]), (3, 1))
    mesh = Mesh("plate", corners, np.array([[0, 1, 2]], np.int32), normals, Diffuse((0.5, 0.5, 0.5)))
    return Scene("plate", (mesh,), Camera((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))), camera


def test_cutting_on_the_screen_leaves_cracks_where_cutting_in_the_scene_leaves_none():
    scene, camera = cracked()
    exact, screen, joined = (
        shown(scene, camera, method).object_id > 0
        for method in ("trilinear", f"{STRAIGHT},clip=screen", f"{STRAIGHT},clip=scene")
    )
    inner = exact & ~silhouettes(exact) & ~silhouettes(silhouettes(exact))
    assert inner.mean() > 0.4
    assert joined[inner].all()
    assert (~screen[inner]).sum() > 500
    assert 5 * (joined != exact).sum() < (screen != exact).sum()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ("edges=curved", "edges is 'curved'; give exact or straight"),
        ("edges=straight,clip=window", "clip is 'window'; give scene or screen"),
        ("antialias=2", "antialias is 2; give 1 or 4"),
        ("edges=straight,tessellate=0", "tessellate is 0; give a number from 1 to 64"),
        ("edges=straight,tessellate=65", "tessellate is 65; give a number from 1 to 64"),
        ("edges=straight,slices=-1", "slices is -1; give a number from 0 to 256"),
        ("edges=straight,slices=257", "slices is 257; give a number from 0 to 256"),
        ("bounces=0", "bounces is 0; give a number from 1 to 8"),
        ("bounces=9", "bounces is 9; give a number from 1 to 8"),
        ("slices=2", "slices is for straight edges; leave it out, or give edges=straight"),
        ("tessellate=2", "tessellate is for straight edges"),
        ("clip=screen", "clip is for straight edges"),
        ("edges=straight,antialias=4", "antialias is for exact edges; leave it out, or give edges=exact"),
    ],
)
def test_options_that_mean_nothing_are_refused_in_one_line(options, said):
    with pytest.raises(AnamorphError, match=r"^trilinear: ") as caught:
        drawn(scene_with(spherical_mirror()), f"trilinear:{options}", (8, 6))
    assert said in str(caught.value) and "\n" not in str(caught.value)


def test_straight_edges_follow_one_mirror():
    scene = scene_with(spherical_mirror())
    frame = drawn(scene, f"{STRAIGHT},bounces=5")
    assert (frame.color == drawn(scene, STRAIGHT).color).all()
    assert set(np.unique(frame.status)) <= {Status.DIRECT, Status.SKY, Status.PROJECTED}
    small = cameras.pinhole(scene.camera, (32, 24))
    assert (shown(scene, small, STRAIGHT, (32, 24)).status != Status.DIRECT).all()
