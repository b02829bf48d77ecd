"""What converging rays see by raster: the laws of anti-perspective, and the same as tracing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import anamorph as an
from anamorph import cameras
from anamorph.base.errors import AnamorphError
from anamorph.frame import Frame, Status, View
from anamorph.gallery.solids import ball, box, grid, lattice
from anamorph.inward import INWARD, toward_one_point
from anamorph.measure.errors import Errors, measure
from anamorph.methods import Specification
from anamorph.methods.session import Session
from anamorph.optics.reflection import reflected_rays, reflector
from anamorph.raymesh import RayMesh
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Diffuse, Mesh, Mirror, Scene, Sky
from anamorph.surfaces.sphere import Sphere

SIZE = (96, 72)
ALONG = Camera((0.0, 0.0, 0.0), (0.0, 0.0, -2.0), field_of_view=60.0)
"""Its anti-perspective rays leave the plane z = 0 and converge in (0, 0, -2)."""
RAYS = cameras.anti_perspective(ALONG, SIZE)


def quad(name: str, half: float, depth: float, middle: tuple[float, float] = (0.0, 0.0)) -> Mesh:
    """A square across the view, so far from the plane that rays leave."""
    x, y = middle
    return grid((x - half, y - half, -depth), (2 * half, 0, 0), (0, 2 * half, 0), (2, 2)).mesh(name, Diffuse())


def scene_of(*meshes: Mesh, camera: Camera = ALONG) -> Scene:
    return Scene("test", meshes, camera, sky=Sky())


def both(scene: Scene, rays: RayMesh, size: tuple[int, int] = SIZE, **options: object) -> tuple[Frame, Frame]:
    """Drawn, and traced."""
    drawn = an.render(scene, INWARD, camera=rays, size=size, seen=True, **options)
    return drawn, an.render(scene, "raytrace", camera=rays, size=size, seen=True)


def things(reference: Frame, errors: Errors) -> float:
    """The 95th percentile of errors in pixels, away from silhouettes, where something is seen."""
    inside = errors.maps.specular & ~errors.maps.silhouette & (reference.object_id > 0)
    return float(np.percentile(errors.maps.pixels[inside], 95.0))


def side(frame: Frame, number: int) -> float:
    """Of a square, in pixels."""
    return float(np.sqrt((frame.object_id == number).sum()))


def test_what_is_farther_away_is_larger_until_the_rays_converge_and_smaller_beyond() -> None:
    depths = (0.5, 1.0, 1.5, 2.5, 3.0, 4.0)
    sides = [side(an.render(scene_of(quad("one", 0.2, depth)), INWARD, camera=RAYS, seen=True), 1) for depth in depths]
    # In pixels: of the image's half, which is 2 tan 30 degrees at the plane.
    wanted = [36 * 0.4 / (abs(2.0 - depth) * np.tan(np.radians(30.0))) for depth in depths]
    assert sides == pytest.approx(wanted, abs=1.0)
    assert sides[0] < sides[1] < sides[2] and sides[3] > sides[4] > sides[5]


def test_beyond_the_point_of_convergence_all_is_reversed() -> None:
    middles = {}
    for depth in (1.0, 3.0):
        frame = an.render(scene_of(quad("one", 0.1, depth, (0.3, 0.2))), INWARD, camera=RAYS, seen=True)
        rows, columns = np.nonzero(frame.object_id == 1)
        middles[depth] = columns.mean() + 0.5 - 48.0, rows.mean() + 0.5 - 36.0
    assert middles[1.0][0] > 5.0 and middles[1.0][1] < -5.0
    assert middles[3.0] == pytest.approx((-middles[1.0][0], -middles[1.0][1]), abs=1.0)


@pytest.mark.parametrize("depths", [(0.5, 1.5), (1.5, 2.5), (2.5, 3.5), (1.9, 1.95), (0.5, 0.5001), (1.999, 2.001)])
def test_what_rays_meet_first_hides_what_they_meet_later(depths: tuple[float, float]) -> None:
    """In the near field, in the far field, and from one to the other; also little apart."""
    for order in (1, -1):
        meshes = [quad(f"at-{depth}", 3.0, depth) for depth in depths][::order]
        frame = an.render(scene_of(*meshes), INWARD, camera=RAYS, seen=True)
        assert (frame.object_id == (1 if order == 1 else 2)).all()
        assert (frame.status == Status.PROJECTED).all()


def test_without_a_far_field_nothing_is_seen_beyond() -> None:
    scene = scene_of(quad("near", 0.1, 1.0), quad("far", 3.0, 3.0))
    frame = an.render(scene, INWARD, camera=RAYS, seen=True, far=False)
    assert set(np.unique(frame.object_id)) == {0, 1} and (frame.status[frame.object_id == 0] == Status.SKY).all()


def soup(seed: int, count: int, around: np.ndarray, extent: float) -> Mesh:
    """Triangles anywhere, some of them needles."""
    random = np.random.default_rng(seed)
    middle = around + random.uniform(-extent, extent, (count, 1, 3))
    corners = middle + random.normal(0.0, 0.25, (count, 3, 3)) * extent
    corners[::5, 2] = corners[::5, 0] + random.normal(0.0, 0.02, (len(corners[::5]), 3)) * extent
    positions = corners.reshape(-1, 3)
    return Mesh(
        "soup",
        positions,
        np.arange(3 * count).reshape(-1, 3).astype(np.int32),
        np.tile([0.0, 1.0, 0.0], (3 * count, 1)),
    )


@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 2**31), depth=st.sampled_from((1.0, 2.0, 3.0)))
def test_any_triangles_are_seen_as_traced(seed: int, depth: float) -> None:
    """Also where they stand around the point of convergence."""
    meshes = [soup(seed + number, 20, np.array([0.0, 0.0, -depth]), 0.6) for number in range(2)]
    frame, truth = both(scene_of(*(replace(mesh, name=f"soup-{n}") for n, mesh in enumerate(meshes))), RAYS)
    errors = measure(truth, frame)
    assert (errors.pixels.p95 or 0.0) < 0.01
    # A silhouette within an object, before others of its triangles, is none to the measure.
    assert (frame.object_id != truth.object_id).mean() < 0.01


BOX = box((-0.4, -0.5, -0.3), (0.5, 0.4, 0.6)).mesh("box", Diffuse())


def test_four_views_see_a_thing_from_all_around_without_a_hole() -> None:
    rays = cameras.inward_sphere((0.05, 0.0, 0.1), 1.5, (160, 80), rows=16, columns=32, pole=1.0)
    frame, truth = both(scene_of(BOX), rays, (160, 80))
    assert (frame.object_id == 1).all()
    distances = np.linalg.norm(frame.position - truth.position, axis=-1)
    # Away from the box's edges, where one side hides another.
    assert np.percentile(distances, 99.0) < 1e-5 and distances.max() < 0.05
    assert (frame.status == Status.PROJECTED).mean() > 0.99


def test_what_lies_outside_the_sphere_is_not_seen_before_the_point() -> None:
    around = box((-1.8, -1.8, -1.8), (1.8, 1.8, 1.8)).mesh("around", Diffuse())
    rays = cameras.inward_sphere((0.0, 0.0, 0.0), 1.5, (80, 40))
    frame, truth = both(scene_of(BOX, around), rays, (80, 40))
    assert (frame.object_id == truth.object_id).all() and (frame.object_id == 1).all()
    # Without the box the far field shows the room, as from its middle.
    frame, truth = both(scene_of(around), rays, (80, 40))
    assert np.percentile(np.linalg.norm(frame.position - truth.position, axis=-1), 99.0) < 1e-4
    near = an.render(scene_of(around), INWARD, camera=rays, size=(80, 40), seen=True, far=False)
    assert (near.object_id == 0).all()


def test_what_is_wrong_is_doubtful_and_is_traced_where_that_is_wanted() -> None:
    """Few quads of a sphere lie well within it, and what is between hides in the views what their rays see."""
    board = grid((-2.5, -0.75, 2.5), (5, 0, 0), (0, 0, -5), (7, 7)).mesh("board", Diffuse())
    rays = cameras.inward_sphere((0.0, 0.0, 0.0), 2.0, (160, 80), rows=4, columns=6)
    frame, truth = both(scene_of(BOX, board), rays, (160, 80))
    wrong = np.linalg.norm(frame.position - truth.position, axis=-1) > 1e-3
    assert wrong.sum() > 20 and (frame.status[wrong] == Status.DOUBTFUL).all()
    traced, _ = both(scene_of(BOX, board), rays, (160, 80), traced=True)
    assert np.linalg.norm(traced.position - truth.position, axis=-1).max() < 1e-3
    assert not (traced.status == Status.DOUBTFUL).any() and (traced.status == Status.DIRECT).sum() >= wrong.sum()


def concave(half: float, radius: float = 4.0, count: int = 20) -> Mesh:
    """A part of a sphere about the origin, seen from there along -z."""
    sphere, across = Sphere(np.zeros(3), radius), np.linspace(-half, half, count + 1)
    uv = np.stack([each.ravel() for each in np.meshgrid(np.pi + across, across)], axis=-1)
    faces = lattice(count + 1, count + 1)[:, ::-1].astype(np.int32)
    return Mesh("mirror", sphere.position(uv), faces, -sphere.normal(uv), Mirror(), surface=sphere, parameters=uv)


AROUND = (
    grid((-6, -1.5, 6), (12, 0, 0), (0, 0, -9), (6, 6)).mesh("floor", Diffuse()),
    ball(2, 0.5, (0.6, 0.0, 3.0)).mesh("far", Diffuse()),
    ball(2, 0.3, (1.0, -0.5, -2.0)).mesh("near", Diffuse()),
)


def mirrored(camera: Camera, half: float = np.radians(20.0)) -> tuple[Frame, Frame]:
    """Section 4.4: a spherical concave mirror by an anti-perspective view, and traced."""
    mirror = concave(half)
    truth = an.render(Scene("test", (*AROUND, mirror), camera), "raytrace:bounces=1", size=SIZE, seen=True)
    rays = toward_one_point(reflected_rays(reflector(mirror), camera.eye(SIZE)))
    frame = an.render(Scene("test", AROUND, camera), INWARD, camera=rays, size=SIZE, seen=True)
    return replace(frame, specular=truth.specular), truth


def test_an_eye_at_its_center_sees_a_spherical_mirror_exactly() -> None:
    frame, truth = mirrored(Camera((0.0, 0.0, 0.0), (0.1, -0.1, -4.0), field_of_view=40.0))
    errors = measure(truth, frame)
    assert things(truth, errors) < 0.01 and errors.pixels.p95 < 0.01 and errors.other_object_percent == 0.0
    assert {1, 2} <= set(np.unique(truth.object_id[truth.specular > 0]))


def test_elsewhere_the_error_grows_with_the_distance_from_the_center() -> None:
    """Against the paper, which says that any point will do."""
    found = []
    for aside in (0.02, 0.1, 0.4):
        frame, truth = mirrored(Camera((aside, 0.0, 0.0), (0.0, 0.0, -4.0), field_of_view=40.0))
        found.append(things(truth, measure(truth, frame)))
    assert found[0] < found[1] < found[2] and found[2] > 0.5


def test_mirrors_that_rays_meet_are_traced() -> None:
    shiny = replace(ball(3, 0.4, (0.2, 0.1, -1.2)).mesh("shiny", Diffuse()), material=Mirror())
    frame, truth = both(scene_of(quad("wall", 3.0, 3.0), shiny, quad("one", 0.3, 0.4, (0.5, 0.3))), RAYS)
    bent = truth.status == Status.TRACED
    assert bent.any() and (frame.status[bent] == Status.TRACED).mean() > 0.99
    errors = measure(truth, frame)
    assert errors.pixels.p95 < 0.01 and errors.other_object_percent < 0.5


def test_an_image_is_antialiased_as_a_traced_one() -> None:
    scene = scene_of(BOX, quad("wall", 3.0, 3.0))
    rays = cameras.inward_sphere((0.05, 0.0, 0.1), 1.5, SIZE)
    frame = an.render(scene, INWARD, camera=rays, size=SIZE, antialias=4)
    truth = an.render(scene, "raytrace", camera=rays, size=SIZE, antialias=4)
    assert np.abs(frame.color - truth.color).mean() < 2e-4


def opened(scene: Scene, rays: RayMesh) -> Session:
    return INWARD.open(View(scene, rays, SIZE))


def test_a_session_follows_cameras_and_vertices() -> None:
    scene = scene_of(quad("one", 0.2, 1.0), quad("wall", 3.0, 3.0))
    session = opened(scene, RAYS)
    other = cameras.inward_sphere((0.0, 0.0, -1.0), 0.8, SIZE)
    for rays in (RAYS, other, RAYS):
        session.draw(rays)
        frame = session.frame(seen=True)
        alone = an.render(scene, INWARD, camera=rays, size=SIZE, seen=True)
        assert (frame.object_id == alone.object_id).all() and (frame.color == alone.color).all()
    geometry = flatten(scene)
    moved = geometry.positions.copy()
    moved[:9, 2] = -0.5
    session.deform(moved, geometry.normals)
    session.draw(RAYS)
    assert side(session.frame(seen=True), 1) == pytest.approx(36 * 0.4 / (1.5 * np.tan(np.radians(30.0))), abs=1.0)


def test_shifted_images_are_those_that_are_traced() -> None:
    scene = scene_of(quad("one", 0.2, 1.0), quad("wall", 3.0, 3.0))
    for rays in (RAYS, cameras.inward_sphere((0.05, 0.0, -0.9), 0.8, SIZE)):
        frames = []
        for method in (INWARD, Specification.parse("raytrace")):
            session = method.open(View(scene, rays, SIZE))
            session.draw(rays, (0.4, -0.3))
            frames.append(session.frame(seen=True))
        errors = measure(frames[1], frames[0])
        assert errors.pixels.p95 < 0.01 and (frames[0].object_id != frames[1].object_id).mean() < 0.01


def test_mirrors_show_what_has_moved() -> None:
    shiny = replace(ball(3, 0.4, (0.2, 0.1, -1.2)).mesh("shiny", Diffuse()), material=Mirror())
    scene = scene_of(quad("one", 0.6, 0.2, (0.2, 0.1)), shiny)
    session = opened(scene, RAYS)
    session.draw(RAYS)
    before = session.frame(seen=True)
    geometry = flatten(scene)
    moved = geometry.positions.copy()
    moved[:9, 0] += 0.9
    session.deform(moved, geometry.normals)
    session.draw(RAYS)
    frame = session.frame(seen=True)
    now = replace(scene, meshes=(replace(scene.meshes[0], positions=moved[:9]), shiny))
    truth = an.render(now, "raytrace", RAYS, SIZE, seen=True)
    assert (frame.object_id != before.object_id).mean() > 0.05
    assert (frame.object_id == truth.object_id).mean() > 0.99


def test_far_from_the_origin_the_same_is_seen() -> None:
    by = np.array([3e5, -2e5, 4e5])
    meshes = [quad("one", 0.2, 1.0), quad("wall", 3.0, 3.0)]
    far = [replace(mesh, positions=np.asarray(mesh.positions, float) + by) for mesh in meshes]
    near = an.render(scene_of(*meshes), INWARD, camera=RAYS, seen=True)
    frame = an.render(scene_of(*far, camera=ALONG.moved(by)), INWARD, camera=RAYS.moved(by), seen=True)
    assert (frame.object_id == near.object_id).mean() > 0.999
    assert np.abs(frame.position - by - near.position).max() < 1e-3


def test_pixels_without_a_ray_triangle_are_outside() -> None:
    rays = replace(RAYS, faces=RAYS.faces[:1])
    frame, truth = both(scene_of(quad("wall", 3.0, 3.0)), rays)
    assert ((frame.status == Status.OUTSIDE) == (truth.status == Status.OUTSIDE)).mean() > 0.98
    assert (frame.color[frame.status == Status.OUTSIDE] == 0.0).all()


def test_what_it_cannot_see_through_is_refused_in_one_line() -> None:
    scene = scene_of(quad("one", 0.2, 1.0))
    with pytest.raises(AnamorphError, match="sees through ray meshes alone"):
        an.render(scene, INWARD)
    with pytest.raises(AnamorphError, match=r"parallel|run apart|pass"):
        an.render(scene, INWARD, camera=cameras.orthographic(ALONG, SIZE))
    with pytest.raises(AnamorphError, match="antialias"):
        an.render(scene, INWARD, camera=RAYS, antialias=3)
