"""Concave, flat and bulging mirrors, and saddles: near things before far ones, and no jump from one to the next."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scenes import drawn, open_view

from anamorph.frame import Frame, Status
from anamorph.gallery import make
from anamorph.gallery.curvature_series import one_mirror
from anamorph.measure.errors import measure, silhouettes

SIZE = (200, 150)
METHODS = ("pervertex:map=image", "pervertex:tolerance=0.5")
CURVATURES = (-1.9, -1.5, -1.0, -0.7, -0.4, -0.2, -0.05, -1e-3, -1e-6, 0.0, 1e-6, 1e-3, 0.2, 1.0, 1.9)


@cache
def mirror(curvature: float, specification: str) -> Frame:
    return drawn(one_mirror(curvature), specification, SIZE)


def things() -> list[int]:
    """What stands before the mirror, nearer than its rays converge."""
    names = [mesh.name for mesh in one_mirror(0.0).meshes]
    return [number + 1 for number, name in enumerate(names) if name.endswith(("/pawn", "/die"))]


@pytest.mark.parametrize("curvature", CURVATURES)
def test_errors_are_bounded_from_concave_over_flat_to_bulging(curvature):
    reference = mirror(curvature, "raytrace")
    plain, own_rays = (measure(reference, mirror(curvature, name)) for name in METHODS)
    assert plain.pixels.median <= 0.1
    assert plain.pixels.p95 <= 0.5
    assert plain.other_object_percent <= 0.5
    assert own_rays.pixels.median <= 0.01
    assert own_rays.pixels.p95 <= 0.02
    assert own_rays.other_object_percent <= 0.15
    if abs(curvature) > 1e-2:
        assert own_rays.pixels.p95 < 0.5 * plain.pixels.p95
    for name in METHODS:
        drawn = mirror(curvature, name)
        assert not (drawn.status[drawn.specular > 0] == Status.OUTSIDE).any()


@pytest.mark.parametrize("specification", METHODS)
def test_the_image_does_not_jump_where_the_mirror_is_flat(specification):
    concave, flat, bulging = (mirror(curvature, specification) for curvature in (-1e-6, 0.0, 1e-6))
    for other in (concave, bulging):
        away = ~silhouettes(flat.object_id, flat.specular)
        assert (other.object_id == flat.object_id)[away].all()
        assert np.linalg.norm(other.position - flat.position, axis=-1)[away].max() <= 1e-3
        assert np.percentile(np.abs(other.color - flat.color), 99.5) <= 0.01


@pytest.mark.parametrize("curvature", [-0.7, -1.0, -1.5, -1.9])
@pytest.mark.parametrize("specification", METHODS)
def test_near_things_are_seen_whole_before_far_ones(curvature, specification):
    reference, frame = mirror(curvature, "raytrace"), mirror(curvature, specification)
    near = np.isin(reference.object_id, things()) & (reference.specular > 0)
    shown = np.isin(frame.object_id, things()) & (frame.specular > 0)
    assert near.sum() > 100
    assert shown.sum() == pytest.approx(near.sum(), rel=0.1)
    inner = near & ~silhouettes(reference.object_id, reference.specular)
    assert shown[inner].mean() >= 0.99


@pytest.mark.parametrize("specification", ["raytrace", *METHODS])
def test_the_far_is_reversed_in_a_concave_mirror_and_the_near_is_not(specification):
    """Up the image the room goes down; the pawn does not."""
    frame = mirror(-1.9, specification)
    near = np.isin(frame.object_id, things())
    for part, sign in ((near, 1.0), (~near, -1.0)):
        rows = (frame.specular > 0) & (frame.object_id > 0) & part
        rows &= ~silhouettes(frame.object_id, frame.specular)
        pairs = rows[1:] & rows[:-1] & (frame.object_id[1:] == frame.object_id[:-1])
        rise = (frame.position[:-1, :, 1] - frame.position[1:, :, 1])[pairs]
        assert pairs.sum() > 100
        assert (np.sign(rise[np.abs(rise) > 1e-4]) == sign).mean() > 0.9


@pytest.mark.parametrize("specification", ["pervertex:map=image", "pervertex:map=image,projective=false"])
def test_aligned_maps_use_more_of_their_area_and_are_no_less_exact(specification):
    scene = make("saddle")
    reference = drawn(scene, "raytrace", SIZE)
    used, errors = [], []
    for align in ("true", "false"):
        session = open_view(scene, f"{specification},align={align}", SIZE)
        session.draw(scene.camera)
        plans = [seen.plans for seen in session.diagnostics()["seen"].seen]
        used.append([np.mean([plan.used for plan in each]) for each in plans])
        errors.append(measure(reference, session.frame(seen=True)))
    (saddle, cylinder), (saddle_before, cylinder_before) = used
    assert cylinder > 1.3 * cylinder_before
    # The eye sees the saddle from aside: its rays fill a rectangle hardly better one way than another.
    assert saddle > saddle_before
    assert errors[0].pixels.median <= 1.05 * errors[1].pixels.median
    assert errors[0].other_object_percent <= errors[1].other_object_percent + 0.1
