"""Grids around meshes: what is interpolated between their corners, and grids that adapt themselves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from reflectors import BALL, EYE, small_things
from scenes import CAMERA, drawn

from anamorph.base.errors import AnamorphError
from anamorph.gallery.spheres import mirror_ball
from anamorph.gpu.device import get_device
from anamorph.gpu.drawing import submit
from anamorph.methods.virtual import octree
from anamorph.methods.virtual.cube_search import REFLECTED, SHOWN, search
from anamorph.methods.virtual.grid_search import GridKind, GridSearch, within
from anamorph.methods.virtual.mesh_grid import direct, joined, regular_grid
from anamorph.methods.virtual.octree import adapted_grid
from anamorph.methods.virtual.reflector_maps import reflector_maps
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Diffuse, Mesh, Scene, Sky

FORMS = {
    "any": lambda random: random.normal(size=(400, 3)) * [1.0, 0.5, 2.0],
    "flat": lambda random: random.normal(size=(300, 3)) * [1.0, 0.0, 1.0],
    "a line": lambda random: random.normal(size=(200, 1)) * [[0.0, 1.0, 0.0]],
    "one": lambda random: random.normal(size=(1, 3)),
    "all alike": lambda random: np.repeat(random.normal(size=(1, 3)), 50, axis=0),
    "far": lambda random: 1e6 + random.normal(size=(400, 3)),
    "thin": lambda random: random.normal(size=(400, 3)) * [1.0, 1e-9, 1.0],
}


def linear(points: np.ndarray) -> np.ndarray:
    return np.column_stack([points @ [[1.0], [2.0], [-3.0]], points[:, :1] * points[:, 1:2], np.ones(len(points))])


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("share", [0.041, 0.3, 1.0])
def test_what_is_linear_is_interpolated_exactly(form, share):
    vertices = FORMS[form](np.random.default_rng(1))
    grid = regular_grid(vertices, share)
    assert len(grid.points) <= len(vertices) and grid.corners.shape == (len(vertices), 8)
    assert ((grid.places >= 0.0) & (grid.places <= 1.0)).all()
    size = np.abs(vertices).max() + 1.0
    for made in (grid, direct(vertices)):
        # Also what is bilinear in two axes.
        assert np.abs(made.interpolated(linear(made.points)) - linear(vertices)).max() < 1e-9 * size**2


def test_cells_are_near_to_cubes_and_about_as_many_as_asked_for():
    random = np.random.default_rng(2)
    vertices = random.uniform(size=(20_000, 3)) * [4.0, 1.0, 2.0]
    for share in (0.01, 0.05):
        grid = regular_grid(vertices, share)
        sides = np.ptp(grid.points[grid.corners], axis=1)
        assert np.ptp(sides.max(axis=1)) < 1e-9 and sides[0].max() / sides[0].min() < 1.5
        cells = len(np.unique(grid.corners[:, 0]))
        assert 0.6 * share * 20_000 < cells < 1.5 * share * 20_000


def test_only_cells_that_hold_a_vertex_are_kept():
    vertices = np.concatenate([np.random.default_rng(3).normal(size=(500, 3)) * 0.01 + corner for corner in (0.0, 5.0)])
    grid = regular_grid(vertices, 0.2)
    assert set(np.unique(grid.corners)) == set(range(len(grid.points))) and len(grid.points) < 40


@pytest.mark.parametrize("share", [0.0, -0.1, 1.5, np.nan])
def test_a_share_that_cannot_be_is_refused(share):
    with pytest.raises(AnamorphError, match=r"share is .*; give the cells of a grid"):
        regular_grid(np.zeros((3, 3)), share)


def test_vertices_around_what_is_unknown_are_searched_for_themselves():
    vertices = np.random.default_rng(4).uniform(size=(3000, 3))
    grid = regular_grid(vertices, 0.02)
    unknown = np.linalg.norm(grid.points, axis=1) < 0.5
    other = grid.without(unknown, vertices)
    near = unknown[grid.corners].any(axis=1)
    assert 0 < near.sum() < len(vertices)
    assert (other.points[other.corners[near]] == vertices[near, None]).all()
    assert np.abs(other.interpolated(other.points) - vertices).max() < 1e-12
    assert (other.places[near] == 0.0).all()
    assert not (np.linalg.norm(other.points[np.unique(other.corners[~near])], axis=1) < 0.5).any()


def test_grids_that_are_joined_show_what_each_shows():
    parts = [FORMS["any"](np.random.default_rng(seed)) for seed in range(3)]
    grids = [regular_grid(part, 0.2) for part in parts]
    assert np.abs(joined(grids).interpolated(joined(grids).points) - np.concatenate(parts)).max() < 1e-9


MAPS = reflector_maps((BALL,), 256)

CAMERA_HERE = Camera(position=tuple(EYE), target=(0.1, 0.0, 0.2), field_of_view=40.0)


def found(points: np.ndarray) -> np.ndarray:
    return search(MAPS, EYE, points, 60)


def images(rows: np.ndarray) -> np.ndarray:
    x, y, w = CAMERA_HERE.image(rows[:, 6:9], (640, 480)).T
    return np.where((rows[:, 11] < 1.5)[:, None], np.stack([x, y], axis=-1) / w[:, None], np.nan)


@pytest.mark.parametrize("seed", range(4))
def test_adapted_grids_hold_half_a_pixel(seed):
    random = np.random.default_rng(seed)
    middle = random.normal(size=3)
    middle *= random.uniform(1.5, 3.0) / np.linalg.norm(middle)
    vertices = middle + [0.1, 0.0, 0.2] + random.normal(size=(4000, 3)) * 0.15
    adapted = adapted_grid(vertices, found, images)
    exact, shown = images(found(vertices)), adapted.grid.interpolated(adapted.found)
    seen = found(vertices)[:, 11] == SHOWN
    apart = np.linalg.norm(images(shown) - exact, axis=1)[seen]
    assert (apart <= 0.5).mean() >= 0.999 if len(apart) else True
    assert adapted.largest <= octree.ALLOWED
    assert adapted.searches < len(vertices) or adapted.cells < 20


def test_far_things_take_few_searches_and_degenerate_ones_no_error():
    random = np.random.default_rng(9)
    far = adapted_grid(random.normal(size=(5000, 3)) * 0.3 + [3.0, 4.0, 4.0], found, images)
    assert far.searches < 1000 and far.cells > 0
    for form in ("one", "all alike", "a line", "flat"):
        vertices = FORMS[form](random) * 0.2 + [0.0, 2.0, 2.0]
        adapted = adapted_grid(vertices, found, images)
        assert (
            np.nanmax(
                np.linalg.norm(images(adapted.grid.interpolated(adapted.found)) - images(found(vertices)), axis=1)
            )
            <= 0.5
        )


def around(random: np.random.Generator, middle: tuple[float, float, float], spread: float) -> Mesh:
    """A thousand vertices; their triangles mean nothing."""
    points = np.array(middle) + spread * random.normal(size=(999, 3))
    faces = np.arange(999, dtype=np.int32).reshape(-1, 3)
    return Mesh("around", points.astype(np.float32), faces, np.tile(np.float32([0, 0, 1]), (999, 1)), Diffuse())


@pytest.mark.parametrize("kind", ["regular", "adaptive"])
def test_the_device_interpolates_but_across_the_horizon_and_in_the_reflector(kind):
    random = np.random.default_rng(6)
    # Before the ball, across its horizon, and around its surface.
    meshes = [
        around(random, *each) for each in (((0.5, 1.5, 2.5), 0.3), ((1.6, 0.0, -0.6), 0.4), ((0.1, 1.0, 0.4), 0.2))
    ]
    meshes = [replace(mesh, name=f"around-{number}") for number, mesh in enumerate(meshes)]
    geometry = flatten(Scene("grids", (BALL, *meshes), CAMERA_HERE))
    made = GridSearch(MAPS, (0,), geometry, GridKind(kind, 0.1, 30))
    encoder = get_device().create_command_encoder()
    made.record(encoder, CAMERA_HERE, (640, 480))
    submit(encoder)
    own = len(BALL.positions)
    rows = np.frombuffer(get_device().queue.read_buffer(made.reflected), REFLECTED)[own:]
    positions = np.asarray(geometry.positions, float)[own:]
    alone = search(MAPS, EYE, positions, 30)
    signs = np.choose(alone[:, 11].astype(int), [1.0, -1.0, 0.0])
    apart = np.linalg.norm(rows["behind"] - alone[:, 6:9], axis=1)
    assert set(np.unique(signs)) == {-1.0, 0.0, 1.0}
    assert (np.sign(rows["length"]) == signs).mean() > 0.995
    shown = signs > 0.0
    assert np.percentile(apart[shown], 90) < (0.1 if kind == "regular" else 0.02)
    if kind == "regular":
        grids = [regular_grid(each, 0.1) for each in np.split(positions, 3)]
        grids = [
            grid.without(within(MAPS, grid.points), each)
            for grid, each in zip(grids, np.split(positions, 3), strict=True)
        ]
        grid = joined(grids)
        corners = search(MAPS, EYE, grid.points, 30)
        mixed = np.ptp(corners[:, 11][grid.corners], axis=1) > 0.0
        assert 100 < mixed.sum() < len(positions) - 100
        # The search itself is not steady close to the surface.
        assert (apart[mixed] < 1e-2).mean() > 0.9
        interpolated = grid.interpolated(corners)[:, 6:9]
        off = np.linalg.norm(rows["behind"] - interpolated, axis=1)
        whole = ~mixed & (corners[:, 11][grid.corners] == SHOWN).all(axis=1)
        assert (off[whole] < 1e-3).mean() > 0.9
        assert (np.linalg.norm(interpolated - alone[:, 6:9], axis=1)[whole] > 1e-2).any()


@pytest.mark.parametrize("options", ["grid=regular,share=0.3", "grid=adaptive"])
def test_frames_with_grids_are_nearly_those_without(options):
    scene = Scene("things", (mirror_ball("ball", (0.0, 0.5, 0.0), 0.15), *small_things()), CAMERA, sky=Sky())
    whole, gridded = (
        drawn(scene, f"virtual:search=cubemap,iterations=30{each}", (320, 240)) for each in ("", f",{options}")
    )
    assert (whole.object_id == gridded.object_id).mean() > 0.997
    both = (whole.specular == 1) & (whole.object_id > 0) & (whole.object_id == gridded.object_id)
    assert both.sum() > 250
    assert np.median(np.linalg.norm(whole.position - gridded.position, axis=-1)[both]) < 5e-3
    assert 0 < gridded.figures["searches"] < whole.figures["searches"]


def test_a_share_without_a_regular_grid_is_refused():
    scene = Scene("things", (mirror_ball("ball", (0.0, 0.5, 0.0), 0.15), *small_things()), CAMERA, sky=Sky())
    with pytest.raises(AnamorphError, match="share is for regular grids; leave it out, or give grid=regular"):
        drawn(scene, "virtual:search=cubemap,share=0.2")
