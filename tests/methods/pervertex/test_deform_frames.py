"""Starting from directions alone: no ray is cast, whatever moves, and the image is right."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scenes import drawn, open_view

from anamorph.gallery import make
from anamorph.gallery.deforming import deformed
from anamorph.measure.errors import measure
from anamorph.rays.caster import Caster
from anamorph.scene.geometry import flatten

SIZE = (200, 150)
DIRECTION = "pervertex:start=direction,refine=3"
TIMES = (0.7, 1.9)


@pytest.fixture
def no_rays(monkeypatch):
    """Makes casting any ray, or following anything that moves with a tree, an error."""

    def forbid() -> None:
        def refused(*_):
            raise AssertionError("a ray was cast")

        for name in ("cast", "moved"):
            monkeypatch.setattr(Caster, name, refused)

    return forbid


@pytest.mark.parametrize("name", ["car-mirror", "flat-mirror"])
def test_without_vertex_rays_the_image_is_right_to_a_pixel(name, no_rays):
    scene = make(name)
    reference = drawn(scene, "raytrace", SIZE)
    session = open_view(scene, DIRECTION, SIZE)
    no_rays()
    session.draw(scene.camera)
    errors = measure(reference, session.frame(seen=True))
    assert errors.pixels.median <= 0.01
    assert errors.pixels.p95 <= 1.0
    assert errors.other_object_percent <= 1.0


@pytest.fixture(scope="module")
def moving():
    """The frames of one session at two times, without rays, and the scenes at these times."""
    scene = make("deforming")
    first = flatten(scene).first_vertex
    scenes = []
    for time in TIMES:
        positions, normals = deformed(time)
        parts = (slice(start, stop) for start, stop in pairwise(first))
        meshes = tuple(
            replace(mesh, positions=positions[own].copy(), normals=normals[own].copy())
            for mesh, own in zip(scene.meshes, parts, strict=True)
        )
        scenes.append(replace(scene, meshes=meshes))
    return scene, scenes


def test_a_scene_that_moves_is_followed_without_a_ray(moving, no_rays):
    scene, scenes = moving
    truths = [drawn(each, "raytrace", SIZE) for each in scenes]
    fresh = [drawn(each, DIRECTION, SIZE) for each in scenes]
    session = open_view(scene, DIRECTION, SIZE)
    session.draw(scene.camera)
    no_rays()
    for time, reference, other in zip(TIMES, truths, fresh, strict=True):
        session.deform(*deformed(time))
        session.draw(scene.camera)
        frame = session.frame(seen=True)
        errors = measure(reference, frame)
        assert errors.pixels.p95 <= 1.0
        assert errors.other_object_percent <= 1.0
        assert np.array_equal(frame.color, other.color)
        assert np.array_equal(frame.position, other.position)
        assert np.array_equal(frame.object_id, other.object_id)
    assert not np.array_equal(fresh[0].color, fresh[1].color)
