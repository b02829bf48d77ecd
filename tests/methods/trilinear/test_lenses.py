"""Lenses by `trilinear`, against rays through the same ray meshes and through the exact glass."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from lens_scenes import CENTER, EYE, MINUS, PLUS, defined, lens_of, scene_of, slab, walls
from lens_scenes import SIZE as IMAGE
from scenes import drawn

from anamorph.frame import Frame, Status
from anamorph.gallery import make
from anamorph.measure.errors import measure, silhouettes
from anamorph.scene.camera import Camera
from anamorph.scene.model import Scene, Sky

BUILT_IN = ("spectacles-minus", "spectacles-plus", "magnifier")


@cache
def built_in(name: str, specification: str) -> Frame:
    return drawn(make(name), specification, IMAGE)


def inner(reference: Frame) -> np.ndarray:
    """Pixels that look through glass, away from silhouettes."""
    return (reference.specular > 0) & ~silhouettes(reference.object_id, reference.specular, reference.status)


@pytest.mark.parametrize("name", BUILT_IN)
def test_the_rays_of_the_ray_mesh_see_what_is_drawn(name):
    reference, frame = built_in(name, "raytrace:truth=raymesh"), built_in(name, "trilinear")
    errors = measure(reference, frame)
    # Where a corner's ray leaves the glass by its edge, the tracer bends rays at the exact glass.
    assert errors.pixels.median <= 1e-3 and errors.pixels.max <= 0.03
    assert not errors.maps.other_object.any()
    assert errors.flip <= 0.006
    assert (frame.specular != reference.specular).sum() <= 5
    expected = np.where(reference.status == Status.TRACED, Status.PROJECTED, reference.status)
    assert (frame.status == expected)[inner(reference)].all()


@pytest.mark.parametrize("name", BUILT_IN)
def test_the_exact_glass_is_not_far(name):
    errors = measure(built_in(name, "raytrace"), built_in(name, "trilinear"))
    assert errors.pixels.p95 <= 0.03 and errors.pixels.max <= 0.05
    assert not errors.maps.other_object.any()


def fringed(specification: str, eye=(0.0, 0.5, 0.6)) -> Frame:
    """A strong lens of glass that disperses much, before chequered walls."""
    lens = lens_of(PLUS, abbe=20.0)
    return drawn(scene_of(lens, camera=Camera(eye, (0.0, 0.5, 0.0), field_of_view=10.0)), specification, IMAGE)


def test_red_and_blue_are_drawn_where_their_own_rays_lead():
    reference, frame = fringed("raytrace:truth=raymesh"), fringed("trilinear")
    plain, alone = fringed("trilinear:dispersion=false"), fringed("raytrace:truth=raymesh,dispersion=false")
    counted = inner(reference)
    assert counted.sum() > 3000
    fringes = np.abs(frame.color - plain.color)[counted].mean(axis=0)
    # The green of the d line is the same; the others move apart.
    assert fringes[1] == 0.0 and min(fringes[0], fringes[2]) > 0.005
    for colors, others in ((frame.color, reference.color), (plain.color, alone.color)):
        wrong = np.abs(colors - others)[counted]
        assert (np.median(wrong, axis=0) <= 1e-3).all()
        assert (wrong.mean(axis=0) <= 0.12 * fringes[[0, 2]].min() + 0.004).all()
    for name in ("position", "object_id", "specular", "status"):
        assert (getattr(frame, name) == getattr(plain, name)).all()


def test_glass_without_an_abbe_number_is_drawn_once():
    scene = scene_of(lens_of(PLUS))
    one, other = (drawn(scene, f"trilinear:dispersion={value}", IMAGE) for value in ("true", "false"))
    assert (one.color == other.color).all()


def test_tinted_glass_takes_its_share_of_the_light_at_either_face():
    tint = np.array([0.9, 0.5, 0.3])
    plain, tinted = (
        drawn(scene_of(lens_of(MINUS, tint=color)), "trilinear", IMAGE) for color in ((1.0, 1.0, 1.0), tuple(tint))
    )
    reference = drawn(scene_of(lens_of(MINUS, tint=tuple(tint))), "raytrace:truth=raymesh", IMAGE)
    counted = inner(reference) & (reference.object_id > 3)
    assert counted.sum() > 3000
    share = (tinted.color / plain.color)[counted]
    assert np.abs(share / tint**2 - 1.0).max() <= 5e-3
    assert np.median(np.abs(tinted.color - reference.color)[counted]) <= 1e-3


OBLIQUE = {
    "thick": (PLUS, Camera((0.16, 0.5, 0.44), tuple(CENTER.tolist()), field_of_view=30.0), "pervertex:map=image"),
    "concave": (MINUS, Camera((0.2, 0.5, 0.46), tuple(CENTER.tolist()), field_of_view=30.0), "raytrace:truth=raymesh"),
}
"""Who looks along a lens sees its edge and total reflection. Where a ray mesh is coarse for that, what is the same for
every method that has its rays is what another shows."""


@pytest.mark.parametrize("name", OBLIQUE)
def test_total_reflection_and_the_way_out_by_the_edge_are_told_and_drawn(name):
    prescription, camera, method = OBLIQUE[name]
    scene = scene_of(lens_of(prescription), camera=camera)
    reference, frame = (drawn(scene, each, IMAGE) for each in (method, "trilinear"))
    defined(frame)
    bent = np.isin(reference.status, (Status.TRACED, Status.WARPED))
    expected = np.where(bent, Status.PROJECTED, reference.status)
    assert (frame.status == expected)[inner(reference)].mean() > 0.98
    counted = reference.specular > 0
    total = counted & (reference.status == Status.TOTAL_REFLECTION)
    edge = counted & (reference.object_id == 3) & ~total
    assert min(total.sum(), edge.sum()) > 40
    assert (frame.object_id == 3)[edge].mean() > 0.95 and (frame.object_id == 3)[total].mean() > 0.95
    assert np.percentile(np.abs(frame.color - reference.color)[edge], 90) <= 0.01


def test_what_is_seen_of_an_edge_is_where_the_ray_in_the_glass_meets_it():
    prescription, camera, _ = OBLIQUE["thick"]
    scene = scene_of(lens_of(prescription), camera=camera)
    frame, edge = drawn(scene, "trilinear", IMAGE), scene.meshes[2]
    seen = (frame.specular > 0) & (frame.object_id == 3) & (frame.status == Status.PROJECTED)
    assert seen.sum() > 40
    corners = edge.positions[edge.faces].astype(float)
    axis = np.linalg.svd(edge.normals.astype(float))[2][2]

    def heights(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Along the axis, and from it."""
        offset = points - edge.positions.mean(axis=0)
        along = offset @ axis
        return along, np.linalg.norm(offset - along[..., None] * axis, axis=-1)

    (along, radius), (_, middle) = heights(corners), heights(corners.mean(axis=1))
    places, distances = heights(frame.position[seen].astype(float))
    # The edge has facets; and where a ray triangle reaches from the edge to the far face, rays may miss it by a little.
    within = (places >= along.min() - 1e-5) & (places <= along.max() + 1e-5)
    assert within.mean() > 0.95
    assert (distances <= radius.max() + 1e-6)[within].all() and (distances >= 0.99 * middle.min())[within].all()
    entered = heights(frame.ray_origin[seen].astype(float))[1]
    assert (entered <= radius.max() + 1e-6).all()


def test_behind_a_lens_with_nothing_behind_it_is_the_sky():
    lens = lens_of(PLUS)
    sky = Sky()
    scene = Scene("lens", lens.meshes, Camera(EYE, tuple(CENTER.tolist()), field_of_view=10.0), sky=sky)
    reference, frame = (drawn(scene, method, IMAGE) for method in ("raytrace:truth=raymesh", "trilinear"))
    counted = inner(reference) & (reference.status == Status.SKY)
    assert counted.sum() > 3000
    assert (frame.status == Status.SKY)[counted].all() and not frame.object_id[counted].any()
    assert np.abs(frame.color - reference.color)[counted].max() <= 0.02
    assert np.abs(frame.position - reference.position)[counted].max() <= 1e-3
    defined(frame)


def test_a_flat_slab_of_few_triangles_is_as_its_ray_mesh():
    scene = Scene("slab", (*slab().meshes, *walls()), Camera(EYE, (0.0, 0.5, 0.0), field_of_view=24.0))
    reference, frame = (drawn(scene, method, IMAGE) for method in ("raytrace:truth=raymesh", "trilinear"))
    counted = inner(reference) & (reference.status == Status.TRACED)
    errors = measure(reference, frame)
    assert counted.sum() > 1000
    assert np.median(errors.maps.pixels[counted]) <= 0.01


def test_lenses_seen_from_the_other_side_are_drawn_too():
    lens = lens_of(PLUS)
    away = Camera((0.02, 0.52, 0.1), tuple(CENTER.tolist()), field_of_view=16.0)
    scene = replace(scene_of(lens), camera=away)
    reference, frame = (drawn(scene, method, IMAGE) for method in ("raytrace:truth=raymesh", "trilinear"))
    assert inner(reference).sum() > 1000
    errors = measure(reference, frame)
    assert errors.pixels.median <= 1e-3 and not errors.maps.other_object.any()
    assert (frame.specular == reference.specular).mean() > 0.999
