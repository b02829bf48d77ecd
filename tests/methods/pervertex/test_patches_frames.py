"""Frames of mirrors that are divided into patches: nothing left out, nothing torn, and nothing from another map."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scenes import SIZE, drawn, open_view, scene_with, spherical_mirror

from anamorph.frame import Frame, Status
from anamorph.gallery import make
from anamorph.measure.angles import angles_between, normalized
from anamorph.measure.errors import measure, silhouettes

BALL = scene_with(spherical_mirror(radius=0.25, count=24, half=(0.2, 0.2)))
"""A mirror whose rays spread by more than one map shows."""


@cache
def ball(specification: str) -> Frame:
    return drawn(BALL, specification, (200, 150))


@pytest.mark.parametrize("name", ["spheres", "torus"])
def test_closed_reflectors_are_shown_whole(name):
    scene = make(name)
    reference, frame = (
        drawn(scene, method, SIZE) for method in ("raytrace:bounces=1", "pervertex:map=image,bounces=1")
    )
    inner = (reference.specular > 0) & ~silhouettes(reference.object_id, reference.specular)
    ends = np.isin(reference.object_id, np.unique(reference.specular[reference.specular > 0]))
    assert (inner & ~ends).sum() > 200
    assert (frame.status[inner & ~ends] == Status.OUTSIDE).mean() <= 0.005


def patches(field: str) -> int:
    """How many maps the ball gets."""
    session = open_view(BALL, f"pervertex:map=image{field}", (200, 150))
    session.draw(BALL.camera)
    return len(session.diagnostics()["seen"].draws)


def test_the_ball_is_divided_the_more_the_smaller_the_field():
    assert patches(",field=150") <= patches("") < patches(",field=50")
    assert patches("") > 1


@pytest.mark.parametrize("field", [40, 70, 140])
def test_the_size_of_patches_does_not_change_the_image(field):
    """More than a pixel at most where the truth, too, jumps from pixel to pixel."""
    reference, frame, other = ball("raytrace"), ball("pervertex"), ball(f"pervertex:field={field}")
    errors = measure(reference, frame).maps, measure(reference, other).maps
    inner = errors[0].specular & ~errors[0].silhouette & (frame.status != Status.OUTSIDE)
    inner &= other.status != Status.OUTSIDE
    assert inner.sum() > 2000
    assert (frame.object_id == other.object_id)[inner].mean() >= 0.99
    assert np.percentile(errors[1].pixels[inner], 95) <= 0.1
    assert np.percentile(np.abs(frame.color - other.color)[inner], 90) <= 0.05


def test_the_seen_directions_do_not_jump_at_the_borders_of_patches():
    """From pixel to pixel the seen point moves by as much as in the truth, across borders as elsewhere."""
    reference, frame = ball("raytrace"), ball("pervertex:map=image,field=50")
    origin = reference.ray_origin.astype(float)

    def directions(seen: Frame) -> np.ndarray:
        points = seen.position.astype(float)
        return normalized(np.where((seen.object_id > 0)[..., None], points - origin, points))

    inner = (reference.specular > 0) & ~silhouettes(reference.object_id, reference.specular)
    inner &= (frame.object_id == reference.object_id) & (frame.status != Status.OUTSIDE)
    jumps = []
    for axis in (0, 1):
        both = inner & np.roll(inner, -1, axis)
        true, shown = (
            angles_between(way[both], np.roll(way, -1, axis)[both])
            for way in (directions(reference), directions(frame))
        )
        jumps.append(np.abs(true - shown) / np.maximum(true, 1e-3))
    jumps = np.concatenate(jumps)
    assert len(jumps) > 4000
    assert np.median(jumps) <= 0.05
    assert np.percentile(jumps, 99) <= 1.0


def test_no_colour_comes_in_from_a_neighbouring_map():
    plain, smooth = ball("pervertex:map=image,field=50"), ball("pervertex:map=image,field=50,antialias=4")
    steady = plain.specular > 0
    for row, column in ((0, 1), (1, 0), (1, 1), (1, -1), (0, 2), (2, 0)):
        for step in (-1, 1):
            moved = np.roll(plain.color, (step * row, step * column), (0, 1))
            steady &= np.abs(moved - plain.color).max(axis=-1) < 0.03
    steady &= ~silhouettes(plain.object_id, plain.specular)
    assert steady.sum() > 1000
    difference = np.abs(smooth.color - plain.color)[steady].max(axis=-1)
    assert np.percentile(difference, 99) <= 0.04
    assert difference.max() <= 0.4
