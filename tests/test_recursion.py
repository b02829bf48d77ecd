"""Mirrors in mirrors by per-vertex reflection: to every depth what rays see, and nothing of a mirror in itself."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scenes import drawn

from anamorph.frame import Frame
from anamorph.measure.errors import measure, silhouettes
from anamorph.scene.builtin import make

SIZE = (200, 150)


@cache
def built_in(name: str, specification: str) -> Frame:
    return drawn(make(name), specification, SIZE)


def numbers(name: str, *starts: str) -> list[int]:
    return [index + 1 for index, mesh in enumerate(make(name).meshes) if mesh.name.startswith(starts)]


@pytest.mark.parametrize("depth", [1, 2, 4, 6])
def test_facing_mirrors_are_exact_to_every_depth(depth):
    """Where the truth needs no more bounces than the frame has, flat mirrors in flat mirrors are exact."""
    truth, frame = built_in("facing-mirrors", "raytrace:bounces=8"), built_in("facing-mirrors", "pervertex:bounces=8")
    limited = built_in("facing-mirrors", f"pervertex:bounces={depth}")
    shallow = built_in("facing-mirrors", f"raytrace:bounces={depth}")
    complete = (shallow.object_id == truth.object_id) & (shallow.object_id > 0)
    away = (truth.specular > 0) & complete & ~silhouettes(truth.object_id, truth.specular)
    assert away.sum() > 5000
    errors = measure(truth, limited).maps
    same = limited.object_id == truth.object_id
    assert (same & away).sum() >= 0.998 * away.sum()
    assert errors.pixels[away & same].max() <= 0.02
    assert np.percentile(errors.pixels[away & same], 99) <= 1e-3
    assert frame.object_id.max() <= len(make("facing-mirrors").meshes)


def test_what_is_deeper_than_the_limit_shows_the_sky_in_all_buffers():
    few = built_in("facing-mirrors", "pervertex:bounces=2")
    shallow = built_in("facing-mirrors", "raytrace:bounces=2")
    beyond = (shallow.object_id == 0) & (shallow.specular > 0) & ~silhouettes(shallow.object_id, shallow.specular)
    print(beyond.sum(), np.unique(few.object_id[beyond], return_counts=True))
    assert beyond.sum() > 500
    assert (few.object_id[beyond] == 0).mean() > 0.98


def test_each_bounce_shows_more_of_the_tunnel():
    truth = built_in("facing-mirrors", "raytrace:bounces=8")
    wrong = [
        measure(truth, built_in("facing-mirrors", f"pervertex:bounces={depth}")).other_object_percent
        for depth in (1, 2, 4, 6)
    ]
    print(wrong)
    assert wrong[0] > wrong[1] > wrong[2] >= wrong[3]
    assert wrong[3] <= 1.0


def test_the_windows_in_the_mirror_show_the_town():
    truth = built_in("car-windows", "raytrace")
    once = built_in("car-windows", "raytrace:bounces=1")
    windows = (truth.specular > 0) & ~silhouettes(truth.object_id, truth.specular, once.object_id)
    moved = np.linalg.norm(truth.position - once.position, axis=-1) > 1e-3
    windows &= moved
    assert windows.sum() > 100
    frame, blind = (built_in("car-windows", f"pervertex:refine=2,bounces={depth}") for depth in (2, 1))
    errors = measure(truth, frame).maps
    print(windows.sum(), np.percentile(errors.pixels[windows], [50, 95, 100]), (frame.object_id != truth.object_id)[windows].mean())
    assert np.median(errors.pixels[windows]) <= 1.0
    assert (frame.object_id == truth.object_id)[windows].mean() >= 0.9
    print((blind.object_id[windows] == 0).mean())
    assert (blind.object_id[windows] == 0).all()


def test_no_map_shows_its_own_mirror():
    """A convex mirror cannot be seen in itself; its frame is not hidden by it either."""
    for name, mirror in (("car-windows", "mirror"), ("spheres", "mirror-ball")):
        own = numbers(name, mirror)
        frame = built_in(name, "pervertex:refine=2" if name == "car-windows" else "pervertex")
        truth = built_in(name, "raytrace")
        looks = np.isin(frame.specular, own) & np.isin(truth.specular, own)
        assert looks.sum() > 500, (name, [mesh.name for mesh in make(name).meshes])
        assert not (np.isin(frame.object_id, own) & looks).any()
