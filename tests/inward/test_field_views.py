"""Points of convergence, and the views from them: closed forms, in float64."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from camera_rays import centers, rays_at, unit
from hypothesis import given, settings
from hypothesis import strategies as st

from anamorph import cameras
from anamorph.base.errors import AnamorphError
from anamorph.inward import converging, toward_one_point
from anamorph.inward.field_views import CORNERS, FieldView, field_views
from anamorph.projection import Projection
from anamorph.raymesh import RayMesh, RayStatus
from anamorph.scene.camera import Camera

ASKEW = Camera((1.0, 2.0, 3.0), (-0.5, 0.25, -1.0), (0.2, 1.0, 0.1), 55.0)
SIZE = (48, 32)

CAMERAS: dict[str, Callable[[], RayMesh]] = {
    "anti-perspective": lambda: cameras.anti_perspective(ASKEW, SIZE, 3.0),
    "reversed perspective": lambda: cameras.perspective(ASKEW, SIZE, -1.5),
    "part of a sphere": lambda: sphere_part(0.6),
    "sphere": lambda: cameras.inward_sphere((1.0, 2.0, 3.0), 2.5, SIZE),
}
every_camera = pytest.mark.parametrize("name", CAMERAS)


def sphere_part(half: float) -> RayMesh:
    """Rays from a part of a sphere about (1, 2, 3) to its center."""
    longitude, latitude = np.meshgrid(np.linspace(-half, half, 5), np.linspace(half, -half, 4))
    out = np.stack(
        [np.sin(longitude) * np.cos(latitude), np.sin(latitude), np.cos(longitude) * np.cos(latitude)], axis=-1
    )
    return cameras.from_grid(2.5 * out + [1.0, 2.0, 3.0], -2.5 * out, SIZE)


def texels(view: FieldView, projection: Projection, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where points are in a view, (N, 2), and whether its depth keeps them, (N,)."""
    clip = np.column_stack([points, np.ones(len(points))]) @ projection.clip.T
    places = clip[:, :2] / clip[:, 3:]
    kept = (clip[:, 3] > 0.0) & (clip[:, 2] >= 0.0) & (clip[:, 2] <= clip[:, 3])
    width, height = view.size
    return np.stack([(places[:, 0] + 1.0) * width, (1.0 - places[:, 1]) * height], axis=-1) / 2.0, kept


@every_camera
def test_rays_converge_in_their_point(name: str) -> None:
    mesh = CAMERAS[name]()
    rays = converging(mesh)
    origins, directions, _ = rays_at(mesh, centers(SIZE))
    across = np.cross(rays.point - origins, unit(directions))
    assert np.abs(across).max() < 1e-9 and (np.sum((rays.point - origins) * directions, axis=1) > 0.0).all()
    assert rays.reach == pytest.approx(np.linalg.norm(mesh.origins - rays.point, axis=1).max())


@every_camera
def test_a_point_of_a_ray_lies_where_the_ray_is_looked_up(name: str) -> None:
    """Before the point of convergence in the near field, beyond it in the far field, and nowhere in both."""
    mesh = CAMERAS[name]()
    rays = converging(mesh)
    views = field_views(rays, SIZE)
    origins, directions, _ = rays_at(mesh, centers(SIZE))
    arrows = rays.point - origins
    lookups = np.array([view.lookup() for view in views])
    ahead = np.einsum("vi,ni->nv", lookups[:, 2], unit(directions))
    chosen = ahead.argmax(axis=1)
    assert len(views) == (4 if name == "sphere" else 1)
    # The least cosine, at the corners of a tetrahedron's face.
    assert ahead.max(axis=1).min() > 1.0 / 3.0 - 1e-9
    for number, view in enumerate(views):
        own = chosen == number
        homogeneous = unit(directions[own]) @ lookups[number].T
        places = homogeneous[:, :2] / homogeneous[:, 2:]
        assert (places > 0.0).all() and (places < view.size).all()
        near, far = view.projections(rays.point)
        for share in (1e-9, 0.3, 0.999, 0.99999, 1.00001, 1.001, 4.0, 1e4):
            points = origins[own] + share * arrows[own]
            for projection, inside in ((near, share < 1.0), (far, share > 1.0)):
                found, kept = texels(view, projection, points)
                assert kept.all() if inside else not kept.any()
                if inside:
                    assert found == pytest.approx(places, abs=1e-5 / abs(1.0 - share) * 1e-3 + 1e-6)


@pytest.mark.parametrize("name", ["anti-perspective", "reversed perspective"])
def test_the_texels_of_a_plane_camera_are_its_pixels(name: str) -> None:
    mesh = CAMERAS[name]()
    (view,) = field_views(converging(mesh), SIZE)
    assert view.size == SIZE
    _, directions, _ = rays_at(mesh, centers(SIZE))
    places = directions @ view.lookup().T
    assert places[:, :2] / places[:, 2:] == pytest.approx(centers(SIZE), abs=1e-7)


@settings(max_examples=20)
@given(shift=st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5)))
def test_a_shifted_plane_camera_keeps_its_pixels(shift: tuple[float, float]) -> None:
    rays = converging(CAMERAS["anti-perspective"]())
    moved = replace(rays, places=rays.places - rays.places[..., 2:] * [*shift, 0.0])
    (view,) = field_views(moved, SIZE)
    _, directions, _ = rays_at(CAMERAS["anti-perspective"](), centers(SIZE) + shift)
    places = directions @ view.lookup().T
    assert places[:, :2] / places[:, 2:] == pytest.approx(centers(SIZE), abs=1e-7)


def test_four_views_see_all_around() -> None:
    directions = np.random.default_rng(1).normal(size=(5000, 3))
    (view, *_) = views = field_views(converging(CAMERAS["sphere"]()), SIZE, texels=100)
    assert view.size[0] == 100 and len({each.size for each in views}) == 1
    assert np.array([each.frame.axes[2] for each in views]) == pytest.approx(CORNERS)
    for each in views:
        right, up, forward = each.frame.axes
        assert np.cross(right, up) == pytest.approx(-forward)
    lookups = np.array([each.lookup() for each in views])
    homogeneous = np.einsum("vij,nj->nvi", lookups, directions)
    best = homogeneous[np.arange(5000), homogeneous[..., 2].argmax(axis=1)]
    places = best[:, :2] / best[:, 2:]
    assert (places > 0.5).all() and (places < np.array(view.size) - 0.5).all()


def test_a_mirrors_rays_are_bent_to_their_nearest_point() -> None:
    mesh = CAMERAS["anti-perspective"]()
    bent = mesh.directions + np.random.default_rng(2).normal(0.0, 1e-3, (4, 3))
    status = np.array([0, RayStatus.BACK_FACING, 0, 0], np.uint8)
    rays = toward_one_point(replace(mesh, directions=bent, status=status))
    assert len(rays.faces) == 1 and (rays.status[rays.faces] == RayStatus.OK).all()
    found = converging(rays)
    assert found.point == pytest.approx(converging(mesh).point, abs=0.05)


FAN = np.array([[-1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, -1.0, 0.0], [1.0, -1.0, 0.0]]).reshape(2, 2, 3)
AHEAD = np.broadcast_to([0.0, 0.0, -1.0], FAN.shape)


@pytest.mark.parametrize(
    ("mesh", "words"),
    [
        (cameras.orthographic(ASKEW, SIZE), r"parallel|run apart|pass"),
        (cameras.pinhole(ASKEW, SIZE), "run apart"),
        (cameras.perspective(ASKEW, SIZE, 0.5), "run apart"),
        (cameras.pushbroom(ASKEW, SIZE), "pass .* metres"),
        (cameras.from_grid(FAN, AHEAD - 0.5 * FAN + 0.01 * FAN[:, ::-1, [1, 0, 2]], SIZE), "pass .* metres"),
        (cameras.from_grid(FAN, (AHEAD - 0.5 * FAN) * [[[1.0], [2.0]], [[1.0], [1.0]]], SIZE), "between corners"),
    ],
)
def test_rays_that_do_not_converge_are_refused_in_one_line(mesh: RayMesh, words: str) -> None:
    with pytest.raises(AnamorphError, match=words) as told:
        converging(mesh)
    assert str(told.value).startswith("inward: ") and "\n" not in str(told.value)


def test_images_behind_the_eye_and_backs_of_mirrors_are_refused() -> None:
    mesh = CAMERAS["anti-perspective"]()
    behind = mesh.image * [[1], [1], [1], [-1.0]]
    with pytest.raises(AnamorphError, match="behind the eye"):
        converging(replace(mesh, image=behind))
    with pytest.raises(AnamorphError, match="no whole face"):
        toward_one_point(replace(mesh, status=np.full(4, RayStatus.BACK_FACING, np.uint8)))
