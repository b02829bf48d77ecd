"""Models of real lenses, and the ray meshes made of them, against closed forms and constants of OpenCV."""

from __future__ import annotations

import numpy as np
import pytest

from anamorph import Camera
from anamorph.base.errors import AnamorphError
from anamorph.cameras import (
    Cylindrical,
    DistortedPinhole,
    DoubleSphere,
    Equirectangular,
    Fisheye,
    Intrinsics,
    LensModel,
    UnifiedOmnidirectional,
    cube_strip,
    dome_master,
    f_theta,
    from_function,
    kannala_brandt,
    real_camera,
)
from anamorph.raymesh import RayMesh, RayStatus

SMALL = (160, 120)
EYE = Camera((0.3, 1.0, 2.0), (0.1, 0.4, -1.0))
MIDDLE = Intrinsics(125.0, 127.0, 80.5, 60.25)
TWELVE = (0.3, 0.1, 0.001, -0.0005, 0.01, 0.5, 0.2, 0.03, 0.001, 0.0004, -0.002, 0.0003)

MODELS: dict[str, LensModel] = {
    "pinhole": DistortedPinhole(MIDDLE),
    "four": DistortedPinhole(MIDDLE, (-0.28, 0.07, 0.001, -0.0005)),
    "five": DistortedPinhole(MIDDLE, (-0.28, 0.07, 0.001, -0.0005, 0.01)),
    "eight": DistortedPinhole(MIDDLE, TWELVE[:8]),
    "twelve": DistortedPinhole(MIDDLE, TWELVE),
    "folding": DistortedPinhole(MIDDLE, (-0.9, 0.1, 0.0, 0.0)),
    "kannala-brandt": kannala_brandt(Intrinsics(50.0, 51.0, 80.5, 60.25), (-0.01, 0.003, -0.002, 0.0005)),
    "equidistant": Fisheye(Intrinsics(31.0, 31.0, 80.0, 60.0), field_of_view=220.0),
    "equisolid": Fisheye(Intrinsics(45.0, 45.0, 80.0, 60.0), "equisolid", field_of_view=240.0),
    "stereographic": Fisheye(Intrinsics(45.0, 45.0, 80.0, 60.0), "stereographic"),
    "f-theta": f_theta((80.0, 60.0), (60.0, 0.0, -3.0), 170.0),
    "dome": dome_master((160, 120)),
    "double sphere": DoubleSphere(Intrinsics(55.0, 56.0, 80.5, 60.25), -0.2, 0.58),
    "parabolic": UnifiedOmnidirectional(Intrinsics(90.0, 91.0, 80.5, 60.25), 1.0),
    "omnidirectional": UnifiedOmnidirectional(Intrinsics(95.0, 95.0, 80.5, 60.25), 1.2, (-0.05, 0.01, 0.001, 0.0)),
    "equirectangular": Equirectangular(SMALL),
    "cylindrical": Cylindrical(SMALL, 300.0),
}
OPENCV = {
    "five": [
        (116.645811375, 35.778243761999995),
        (28.428576838867194, 95.54447562114062),
        (86.47197717285157, 108.8934179609375),
    ],
    "twelve": [
        (117.00932233871829, 35.51122857257481),
        (27.477814978488908, 96.14508551936184),
        (86.56355672703141, 109.42167615543629),
    ],
    "kannala-brandt": [
        (94.87975439749547, 50.47176700970308),
        (59.92193284753728, 74.24308566367465),
        (82.87307484924965, 79.61429076987716),
    ],
}
"""Of OpenCV, for the directions of its test."""
WITH_POLES = {"equirectangular"}
"""Models with poles, at which a pixel of the image is no measure."""


def points(count: int = 10_000) -> np.ndarray:
    return np.random.default_rng(5).uniform((0.0, 0.0), SMALL, (count, 2))


@pytest.mark.parametrize("name", MODELS)
def test_pixels_and_rays_are_each_others_inverse(name: str) -> None:
    pixels = np.vstack([points(), MODELS[name].pixels(np.array([[0.0, 0.0, 1.0]]))[0]])
    directions, status = MODELS[name].rays(pixels)
    seen = status == RayStatus.OK
    again, same = MODELS[name].pixels(directions[seen] * 3.0)
    assert seen.mean() > 0.3 and not same.any() and np.isfinite(directions).all()
    np.testing.assert_allclose(again, pixels[seen], rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("name", ["five", "twelve", "omnidirectional"])
def test_derivatives_of_the_distortion_are_those_of_differences(name: str) -> None:
    model = DistortedPinhole(MIDDLE, MODELS[name].coefficients)  # type: ignore[attr-defined]
    plane, step = np.random.default_rng(2).uniform(-0.6, 0.6, (50, 2)), 1e-6
    for axis in (0, 1):
        moved = step * np.eye(2)[axis]
        difference = (model.distort(plane + moved)[0] - model.distort(plane - moved)[0]) / (2.0 * step)
        np.testing.assert_allclose(model.distort(plane)[1][:, :, axis], difference, atol=1e-8)


@pytest.mark.parametrize("name", ["five", "twelve", "kannala-brandt"])
def test_pixels_are_those_of_opencv(name: str) -> None:
    """Constants of `cv2.projectPoints` and `cv2.fisheye.projectPoints` of OpenCV 5.0.0."""
    directions = np.array([(0.3, -0.2, 1.0), (-0.45, 0.3, 1.0), (0.05, 0.4, 1.0)])
    found, status = MODELS[name].pixels(directions)
    assert not status.any()
    np.testing.assert_allclose(found, OPENCV[name], rtol=0.0, atol=1e-9)


def test_a_fold_is_where_the_image_turns_back() -> None:
    """With k1 alone the distance r + k1 r^3 turns at r = 1 / sqrt(-3 k1)."""
    model = DistortedPinhole(Intrinsics(100.0, 100.0, 80.0, 60.0), (-0.9, 0.0, 0.0, 0.0))
    turn = 1.0 / np.sqrt(2.7)
    last = 100.0 * (turn - 0.9 * turn**3)
    around = np.linspace(0.0, 6.0, 40)[:, None]
    ring = np.hstack([np.cos(around), np.sin(around)])
    assert not model.rays(ring * (last - 1e-3) + (80.0, 60.0))[1].any()
    assert (model.rays(ring * (last + 1e-3) + (80.0, 60.0))[1] == RayStatus.FOLDED).all()
    rays = np.hstack([ring * (turn + 1e-6), np.ones_like(around)])
    assert (model.pixels(rays)[1] == RayStatus.FOLDED).all()


def test_a_fisheye_folds_where_its_polynomial_turns_back() -> None:
    """60 a - 8 a^3 turns at a = sqrt(2.5), before pi."""
    model, turn = f_theta((80.0, 60.0), (60.0, 0.0, -8.0)), np.sqrt(2.5)
    last = 60.0 * turn - 8.0 * turn**3
    status = model.rays(np.array([[80.0 + last - 1e-6, 60.0], [80.0 + last + 1e-6, 60.0]]))[1]
    assert status.tolist() == [RayStatus.OK, RayStatus.FOLDED]


def interpolated(mesh: RayMesh, size: tuple[int, int], pixels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The ray mesh's directions at image points, and whether a triangle is there."""
    places, found, there = mesh.places(), np.ones((len(pixels), 3)), np.zeros(len(pixels), bool)
    for corners in mesh.faces:
        (x0, y0), (x1, y1) = places[corners].min(axis=0), places[corners].max(axis=0)
        near = np.flatnonzero((pixels[:, 0] >= x0) & (pixels[:, 0] <= x1) & (pixels[:, 1] >= y0) & (pixels[:, 1] <= y1))
        if len(near):
            edges = np.column_stack([places[corners], np.ones(3)]).T
            weights = np.linalg.solve(edges, np.column_stack([pixels[near], np.ones(len(near))]).T).T
            inside = (weights >= -1e-9).all(axis=1)
            found[near[inside]] = weights[inside] @ mesh.directions[corners]
            there[near[inside]] = True
    return found, there


@pytest.mark.parametrize("name", sorted(MODELS.keys() - WITH_POLES))
def test_interpolated_rays_are_within_a_tenth_of_a_pixel(name: str) -> None:
    mesh = real_camera(MODELS[name], EYE, SMALL, holes=True)
    pixels = points(10_000)
    directions, there = interpolated(mesh, SMALL, pixels)
    own = directions @ (EYE.axes() * np.array([[1.0], [-1.0], [1.0]])).T
    again, status = MODELS[name].pixels(own)
    ok = there & (status == RayStatus.OK)
    assert ok[there].mean() > 0.999
    off = np.linalg.norm(again - pixels, axis=1)[ok]
    assert off.max() <= 0.1
    np.testing.assert_array_equal(mesh.origins, np.broadcast_to(EYE.position, mesh.origins.shape))


def test_a_pinhole_without_distortion_is_exact() -> None:
    mesh = real_camera(MODELS["pinhole"], EYE, SMALL)
    pixels = points(200)
    np.testing.assert_allclose(interpolated(mesh, SMALL, pixels)[0] @ EYE.axes()[2], 1.0, rtol=0.0, atol=1e-12)


def test_a_fisheye_of_220_degrees_has_no_hole() -> None:
    """It fills the image to its corners: they see 110 degrees from the axis."""
    focal = 100.0 / np.radians(110.0)
    mesh = real_camera(Fisheye(Intrinsics(focal, focal, 80.0, 60.0), field_of_view=220.0 + 1e-6), EYE, SMALL)
    assert not mesh.status.any() and len(np.unique(mesh.faces)) == len(mesh.image)
    assert interpolated(mesh, SMALL, points(2000))[1].all()


def test_holes_say_what_they_are() -> None:
    mesh = real_camera(MODELS["folding"], EYE, SMALL, holes=True)
    assert set(mesh.status) == {RayStatus.OK, RayStatus.FOLDED}
    assert not mesh.status[mesh.faces].any()
    dome = real_camera(MODELS["dome"], EYE, SMALL)
    assert set(dome.status) == {RayStatus.OK, RayStatus.OUTSIDE}
    assert not dome.status[dome.faces].any()


def test_a_border_is_cut_where_it_is() -> None:
    pixels = points(4000)
    there = interpolated(real_camera(MODELS["dome"], EYE, SMALL), SMALL, pixels)[1]
    distance = np.linalg.norm(pixels - (80.0, 60.0), axis=1)
    assert there[distance < 59.7].all() and not there[distance > 60.0 + 1e-6].any()


def test_any_function_is_a_camera() -> None:
    """Rays that leave a line, as a pushbroom's do, and turn with it."""

    def function(pixels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        x, y = pixels.T / 100.0
        return np.column_stack([x, 0 * x, 0 * x]), np.column_stack([np.sin(x), 0.5 - y, -np.cos(x)])

    mesh = from_function(function, SMALL, 0.2)
    np.testing.assert_allclose(mesh.origins[:, 0], mesh.places()[:, 0] / 100.0, atol=1e-12)
    assert len(from_function(function, SMALL, 0.02).faces) > len(mesh.faces)


def test_a_cube_strip_has_each_direction_once() -> None:
    mesh = cube_strip(Camera((0.0, 0.0, 0.0), (0.0, 0.0, -1.0)), 10)
    pixels = np.array([(5, 5), (15, 5), (25, 5), (35, 5), (45, 5), (55, 5), (25, 1), (45, 1)], float)
    found = interpolated(mesh, (60, 10), pixels)[0]
    expected = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, -1), (0, 0, 1), (0, 1, 0.8), (0, 0.8, -1)]
    np.testing.assert_allclose(found, expected, atol=1e-12)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Intrinsics(0.0, 100.0, 5.0, 5.0), "focal lengths are 0.0, 100.0"),
        (lambda: Intrinsics(np.nan, 100.0, 5.0, 5.0), "intrinsics"),
        (lambda: DistortedPinhole(MIDDLE, (0.1,) * 14), "14 coefficients"),
        (lambda: kannala_brandt(MIDDLE, (0.1,)), "1 coefficients"),
        (lambda: f_theta((1.0, 1.0), (0.0, 1.0)), "does not grow"),
        (lambda: DoubleSphere(MIDDLE, 0.1, 1.5), "xi, alpha"),
        (lambda: UnifiedOmnidirectional(MIDDLE, -1.0), "xi is -1"),
        (lambda: Fisheye(MIDDLE, "round"), "law is 'round'"),
        (lambda: real_camera(MODELS["five"], EYE, (64, 48)), "outside an image of 64 x 48"),
        (lambda: real_camera(MODELS["cylindrical"], EYE, (64, 48)), "size is 64 x 48"),
        (lambda: real_camera(MODELS["folding"], EYE, SMALL), "folds back in"),
        (lambda: from_function(lambda at: (at, at), SMALL), "the function gives origins"),
        (lambda: from_function(lambda at: (np.zeros((len(at), 3)), turning(at)), SMALL), "too fast"),
    ],
)
def test_bad_input_is_refused_in_one_line(make, said: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(AnamorphError, match=said) as raised:
        make()
    assert "\n" not in str(raised.value)


def turning(at: np.ndarray) -> np.ndarray:
    """Directions that turn by a radian a pixel."""
    return np.column_stack([0.3 * np.cos(at[:, 0]), 0.3 * np.sin(at[:, 0]) + at[:, 1] / 1e3, np.ones(len(at))])
