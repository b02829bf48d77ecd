"""Strip cameras: upright lines seen on a way from view to view."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from camera_rays import rays_at, unit

from anamorph import cameras
from anamorph.base.errors import AnamorphError
from anamorph.files.opening import open_scene
from anamorph.files.view_file import views_of
from anamorph.scene.camera import Camera
from anamorph.viewer.turntable import orbit

ASKEW = Camera((1.0, 2.0, 3.0), (-0.5, 0.25, -1.0), (0.2, 1.0, 0.1), 55.0)
SIZE = (48, 32)


def moved_right(by: float) -> Camera:
    return ASKEW.moved(by * ASKEW.axes()[0])


def test_along_a_straight_street_a_strip_is_a_pushbroom() -> None:
    # As wide as the pushbroom's way, which its own camera stands in the middle of.
    height = 2.0
    broom = cameras.pushbroom(ASKEW, SIZE, height)
    points = np.random.default_rng(1).uniform((0, 0), SIZE, (100, 2))
    wanted = rays_at(broom, points)
    for views in ([-1.5, 1.5], [-1.5, -1.0, 0.25, 1.5]):
        origins, directions, _ = rays_at(cameras.strip([moved_right(way) for way in views], SIZE, 3), points)
        assert origins == pytest.approx(wanted[0], abs=1e-9)
        assert unit(directions) == pytest.approx(unit(wanted[1]), abs=1e-9)


def test_who_moves_to_the_left_sees_the_same() -> None:
    views = [moved_right(way) for way in (-1.0, 0.5, 1.0)]
    there, back = (cameras.strip(each, SIZE, 4) for each in (views, views[::-1]))
    points = np.random.default_rng(2).uniform((0, 0), SIZE, (100, 2))
    for one, other in zip(rays_at(there, points)[:2], rays_at(back, points)[:2], strict=True):
        assert one == pytest.approx(other, abs=1e-9)


def test_around_a_thing_each_line_looks_at_its_axis() -> None:
    level = Camera((0.0, 1.0, 3.0), (0.0, 1.0, 0.0), field_of_view=30.0)
    around = orbit(level, 6)
    mesh = cameras.strip([*around, level], (120, 40), 8)
    across = np.linspace(0.0, 120.0, 49)
    origins, directions, _ = rays_at(mesh, np.column_stack([across, np.full(49, 20.0)]))
    assert np.linalg.norm(origins[:, [0, 2]], axis=1) == pytest.approx(np.full(49, 3.0))
    assert unit(directions) == pytest.approx(unit(np.array([0.0, 1.0, 0.0]) - origins))
    turned = np.unwrap(np.arctan2(origins[:, 0], origins[:, 2]))
    # Once around, evenly: to its right, so that the thing is not mirrored.
    assert turned == pytest.approx(np.linspace(0.0, 2.0 * np.pi, 49))
    assert origins[0] == pytest.approx(origins[-1])


def test_a_scene_file_keeps_the_views_of_a_strip(tmp_path: Path) -> None:
    path = tmp_path / "street.toml"
    views = "".join(f"[[view.views]]\nposition = [{x}, 1, 3]\ntarget = [{x}, 1, 0]\n" for x in (-1.0, 0.0, 2.0))
    path.write_text(f'builtin = "spheres"\n[view]\n{views}')
    _, settings = open_scene(path)
    kept = views_of(settings.view)
    assert [view.position[0] for view in kept] == [-1.0, 0.0, 2.0]
    mesh = cameras.strip(kept, SIZE, 1)
    assert mesh.image.reshape(2, 3, 3)[0, :, 0] == pytest.approx([0.0, 16.0, 48.0])
    assert mesh.origins.reshape(2, 3, 3)[0, :, 0] == pytest.approx([-1.0, 0.0, 2.0])


@pytest.mark.parametrize(
    ("views", "words"),
    [
        ([], "goes through 0 views"),
        ([ASKEW], "goes through 1 views"),
        ([ASKEW, ASKEW], "stands still between views 1 and 2"),
        ([moved_right(1.0), ASKEW, ASKEW], "stands still between views 2 and 3"),
        ([ASKEW, replace(ASKEW, target=ASKEW.position)], "number 2 of views"),
    ],
)
def test_what_is_no_way_is_refused_in_one_line(views: list[Camera], words: str) -> None:
    with pytest.raises(AnamorphError, match=words) as told:
        cameras.strip(views, SIZE)
    assert "\n" not in str(told.value)
