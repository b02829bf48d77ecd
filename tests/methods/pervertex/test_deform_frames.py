"""Maps of surfaces of what moves: they follow it, cast no ray where no mirror may see itself, and are right."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scenes import drawn, open_view

from anamorph.frame import Status
from anamorph.gallery import make
from anamorph.gallery.deforming import deformed
from anamorph.measure.errors import measure
from anamorph.rays.caster import Caster
from anamorph.scene.geometry import flatten

SIZE = (200, 150)
TIMES = (0.7, 1.9)


@pytest.fixture
def no_rays(monkeypatch):
    """Makes casting any ray an error."""

    def forbid() -> None:
        def refused(*_):
            raise AssertionError("a ray was cast")

        monkeypatch.setattr(Caster, "cast", refused)

    return forbid


def check(reference, frame):
    """Hold a frame to the truth: places everywhere, and objects where they are not doubtful."""
    errors = measure(reference, frame)
    assert errors.pixels.median <= 0.01
    assert errors.pixels.p95 <= 1.0
    doubtful = (frame.status == Status.DOUBTFUL) & errors.maps.specular
    assert doubtful.sum() <= 0.5 * errors.maps.specular.sum()
    counted = errors.maps.specular & ~errors.maps.silhouette & ~doubtful
    assert (errors.maps.other_object & counted).sum() <= 0.001 * counted.sum()


@pytest.mark.parametrize("name", ["car-mirror", "flat-mirror"])
def test_no_ray_is_cast_and_the_image_is_right(name, no_rays):
    scene = make(name)
    reference = drawn(scene, "raytrace", SIZE)
    session = open_view(scene, "pervertex", SIZE)
    no_rays()
    session.draw(scene.camera)
    check(reference, session.frame(seen=True))


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
    fresh = [drawn(each, "pervertex", SIZE) for each in scenes]
    session = open_view(scene, "pervertex", SIZE)
    session.draw(scene.camera)
    no_rays()
    for time, reference, other in zip(TIMES, truths, fresh, strict=True):
        session.deform(*deformed(time))
        session.draw(scene.camera)
        frame = session.frame(seen=True)
        check(reference, frame)
        assert np.array_equal(frame.color, other.color)
        assert np.array_equal(frame.position, other.position)
        assert np.array_equal(frame.object_id, other.object_id)
    assert not np.array_equal(fresh[0].color, fresh[1].color)
