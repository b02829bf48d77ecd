"""What lies beyond the edges of an image, by every method, against a float64 twin of the three ways to go on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import CAMERA, drawn, flat_mirror

from anamorph.base.errors import AnamorphError
from anamorph.base.srgb import decode_srgb
from anamorph.frame import Frame
from anamorph.gallery.solids import grid
from anamorph.methods import METHODS
from anamorph.scene.camera import Camera
from anamorph.scene.checks import check_scene
from anamorph.scene.model import AmbientLight, Diffuse, Mesh, Mirror, Scene, Texture, Wrap

WHITE_LIGHT = (AmbientLight((1.0, 1.0, 1.0), (1.0, 1.0, 1.0)),)
TEXELS = 8
PIXELS = np.random.default_rng(11).integers(30, 226, (TEXELS, TEXELS, 4), dtype=np.uint8)
SIZE = (96, 72)


def coordinates(points: np.ndarray) -> np.ndarray:
    """Texture coordinates of points on the wall, from -1 to 2 over its two metres."""
    return np.stack([0.5 + 1.5 * points[..., 0], 0.5 - 1.5 * (points[..., 1] - 0.5)], axis=-1)


def wall(wraps: tuple[Wrap, Wrap], height: float = 0.5) -> Mesh:
    """Two metres square, behind the eye, facing the mirror."""
    shape = grid((1.0, height - 1.0, 1.5), (-2.0, 0.0, 0.0), (0.0, 2.0, 0.0))
    mesh = shape.mesh("wall", Diffuse((1.0, 1.0, 1.0), Texture(PIXELS, wraps)))
    return replace(mesh, texcoords=coordinates(mesh.positions.astype(float)).astype(np.float32))


def texel(index: np.ndarray, wrap: Wrap) -> np.ndarray:
    """Which texel stands at a whole number, from the definitions in the glTF and OpenGL specifications."""
    if wrap == "clamp":
        return np.clip(index, 0, TEXELS - 1)
    if wrap == "repeat":
        return index % TEXELS
    folded = index % (2 * TEXELS)
    return np.minimum(folded, 2 * TEXELS - 1 - folded)


def twin(points: np.ndarray, wraps: tuple[Wrap, Wrap]) -> np.ndarray:
    """Linear colours (..., 3) of points on the wall, blended between the four texels around each."""
    place = coordinates(points) * TEXELS - 0.5
    corner = np.floor(place).astype(int)
    share = place - corner
    linear = decode_srgb(PIXELS[..., :3] / 255.0)
    total = np.zeros((*place.shape[:-1], 3))
    for right in (0, 1):
        for below in (0, 1):
            weight = np.abs(1 - right - share[..., 0]) * np.abs(1 - below - share[..., 1])
            column, row = texel(corner[..., 0] + right, wraps[0]), texel(corner[..., 1] + below, wraps[1])
            total += weight[..., None] * linear[row, column]
    return total


WRAPS: list[tuple[Wrap, Wrap]] = [
    ("repeat", "repeat"), ("clamp", "clamp"), ("mirror", "mirror"), ("repeat", "clamp"), ("mirror", "repeat"),
    ("clamp", "mirror"),
]  # fmt: skip


@pytest.mark.parametrize("wraps", WRAPS)
def test_an_image_goes_on_as_it_says(wraps: tuple[Wrap, Wrap]) -> None:
    """Seen directly, magnified, over three copies of the image each way."""
    camera = Camera((0.0, 0.5, -1.3), (0.0, 0.5, 1.5), field_of_view=38.0)
    frame = drawn(Scene("wall", (wall(wraps),), camera, WHITE_LIGHT), "raytrace", (192, 144))
    on = frame.object_id == 1
    reached = coordinates(frame.position[on])
    assert reached.min() < -0.9 and reached.max() > 1.9
    assert frame.color[on] == pytest.approx(twin(frame.position[on].astype(float), wraps), abs=6e-3)


def in_mirror(method: str, wraps: tuple[Wrap, Wrap]) -> Frame:
    mirror = replace(flat_mirror(), material=Mirror(reflectance=1.0))
    return drawn(Scene("wall", (mirror, wall(wraps)), CAMERA, WHITE_LIGHT), method, SIZE)


@pytest.mark.parametrize("method", [*METHODS, "pervertex:map=image,bounces=1"])
def test_every_method_shows_it_in_a_mirror(method: str) -> None:
    frame = in_mirror(method, ("clamp", "mirror"))
    on = (frame.object_id == 2) & (frame.specular == 1)
    reached = coordinates(frame.position[on])
    assert on.sum() > 1000 and reached[:, 0].min() < -0.2 and reached[:, 1].max() > 1.2
    error = np.abs(frame.color[on] - twin(frame.position[on].astype(float), ("clamp", "mirror"))).max(axis=-1)
    # A map of colours blends between its texels.
    assert np.quantile(error, 0.9) < 0.02


def test_a_far_image_that_ends_tends_to_its_edge() -> None:
    """Minified: no level of the image is blended with its far edge."""
    pixels = np.full((64, 64, 4), 255, np.uint8)
    pixels[:, 32:, :3] = 0
    mesh = wall(("clamp", "clamp"))
    mesh = replace(mesh, material=Diffuse((1.0, 1.0, 1.0), Texture(pixels, ("clamp", "clamp"))))
    camera = Camera((0.0, 0.5, -60.0), (0.0, 0.5, 1.5), field_of_view=1.6)
    frame = drawn(Scene("wall", (mesh,), camera, WHITE_LIGHT), "raytrace", (40, 40))
    on = frame.object_id == 1
    u = coordinates(frame.position)[..., 0]
    assert frame.color[on & (u < 0.2)] == pytest.approx(1.0, abs=2e-3)
    assert frame.color[on & (u > 0.8)] == pytest.approx(0.0, abs=2e-3)


def test_a_way_to_go_on_that_is_none_is_refused() -> None:
    wrong: tuple[Wrap, Wrap] = ("repeat", "border")  # type: ignore[assignment]
    with pytest.raises(AnamorphError, match=r"part 'wall': wraps of its image are .*'border'"):
        check_scene(Scene("wall", (wall(wrong),), CAMERA))
