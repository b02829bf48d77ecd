"""Mirrors in mirrors by per-vertex reflection: to every depth what rays see, and nothing of a mirror in itself."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scenes import drawn

from anamorph.frame import Frame, Status
from anamorph.gallery import make
from anamorph.measure.errors import measure, silhouettes

SIZE = (200, 150)


@cache
def built_in(name: str, specification: str, size: tuple[int, int] = SIZE) -> Frame:
    return drawn(make(name), specification, size)


def numbers(name: str, *starts: str) -> list[int]:
    return [index + 1 for index, mesh in enumerate(make(name).meshes) if mesh.name.startswith(starts)]


@pytest.mark.parametrize(("depth", "alike", "exact"), [(2, 0.9995, 0.985), (6, 0.998, 0.92)])
def test_facing_mirrors_are_right_to_every_depth(depth, alike, exact):
    """Flat mirrors in flat mirrors; a path that meets more of them ends at the next one, for rays and maps alike."""
    reference, frame = (
        built_in("facing-mirrors", f"{name}{depth}") for name in ("raytrace:bounces=", "pervertex:map=image,bounces=")
    )
    errors = measure(reference, frame).maps
    away = errors.specular & ~errors.silhouette
    same = frame.object_id == reference.object_id
    # What differs lies beside an edge: half a texel of the map away from it.
    wide = silhouettes(silhouettes(reference.object_id).astype(int))
    assert same[away & ~wide].mean() >= alike
    # Ends of paths are interpolated between texels, but not over the creases and steps within one object.
    assert (errors.pixels[away & same] <= 0.01).mean() >= exact
    once = (reference.specular > 0) & (
        built_in("facing-mirrors", "raytrace:bounces=1").object_id == reference.object_id
    )
    assert np.percentile(errors.pixels[away & same & once], 95) <= 1e-3
    assert (frame.specular == reference.specular)[away].all()


def test_what_is_deeper_than_the_limit_ends_at_a_mirror():
    mirrors = numbers("facing-mirrors", "mirror")
    reference, frame = (
        built_in("facing-mirrors", f"{name}2") for name in ("raytrace:bounces=", "pervertex:map=image,bounces=")
    )
    beyond = (
        (reference.specular > 0)
        & np.isin(reference.object_id, mirrors)
        & ~silhouettes(reference.object_id, reference.specular)
    )
    assert beyond.sum() > 500
    assert np.isin(frame.object_id[beyond], mirrors).mean() > 0.98
    assert (frame.status[beyond] == Status.OUTSIDE).mean() > 0.98


def test_each_bounce_shows_more_of_the_tunnel():
    reference = built_in("facing-mirrors", "raytrace:bounces=8")
    wrong = [
        measure(reference, built_in("facing-mirrors", f"pervertex:map=image,bounces={depth}")).other_object_percent
        for depth in (1, 2, 4, 6)
    ]
    assert wrong[0] > wrong[1] > wrong[2] >= wrong[3]
    assert wrong[3] <= 1.0


def test_the_windows_in_the_mirror_show_the_town():
    size, mirror = (400, 300), numbers("car-windows", "mirror")
    reference, once = (built_in("car-windows", name, size) for name in ("raytrace", "raytrace:bounces=1"))
    frame, blind = (built_in("car-windows", f"pervertex:map=image,bounces={depth}", size) for depth in (2, 1))
    panes = [index + 1 for index, mesh in enumerate(make("car-windows").meshes) if mesh.name.endswith("-window")]
    windows = np.isin(reference.specular, mirror) & np.isin(once.object_id, panes)
    windows &= ~silhouettes(reference.object_id, reference.specular, once.object_id)
    assert windows.sum() > 1000
    errors = measure(reference, frame).maps
    # The town in a window is seen from the map's viewpoint, and not along the rays.
    assert np.percentile(errors.pixels[windows], 95) <= 1.0
    assert (frame.object_id == reference.object_id)[windows].mean() >= 0.99
    assert np.isin(blind.object_id[windows], panes).all()
    assert (blind.status[windows] == Status.OUTSIDE).all()
    # What the map shows in their place then is the sky: more blue than red, as the town is not.
    town = reference.object_id[windows] > 0
    assert (blind.color[windows][town][:, 2] > blind.color[windows][town][:, 0]).mean() > 0.95


def test_no_map_shows_its_own_mirror():
    """A convex mirror cannot be seen in itself; its frame is not hidden by it either."""
    for name, mirror in (("car-windows", "mirror"), ("spheres", "mirror-ball")):
        own = numbers(name, mirror)
        frame = built_in(name, "pervertex:map=image")
        reference = built_in(name, "raytrace")
        looks = np.isin(frame.specular, own) & np.isin(reference.specular, own)
        assert looks.sum() > 500, (name, [mesh.name for mesh in make(name).meshes])
        # A mirror in it may show it again, for want of bounces.
        looks &= frame.status != Status.OUTSIDE
        assert not (np.isin(frame.object_id, own) & looks).any()
