"""`raytrace` and the second tracer see the same in random scenes of every family, and in those that once failed."""

from __future__ import annotations

import numpy as np
import pytest

from anamorph import Status
from oracle import found
from oracle.conversion import package_scene, shown_by
from oracle.families import AGREEING, FAMILIES, make
from oracle.found import FOUND
from oracle.judging import judge
from oracle.scene import Scene
from oracle.tracer import Tracer

SIZE = (96, 72)

RADIANS = 1e-5


def agrees(scene: Scene) -> None:
    judged = judge(Tracer(scene), scene.camera, shown_by(scene, "raytrace", SIZE))
    assert judged.plain.sum() > 200
    assert not judged.other.any() and not judged.wrong.any(), judged.wrong_by_status()
    assert judged.angles.max() < RADIANS
    # Of few pixels one may lie on the border that the mesh and its surface do not share exactly.
    assert judged.missed.sum() <= max(1, 0.001 * judged.silhouette.sum())


@pytest.mark.parametrize(("family", "seed"), AGREEING)
def test_the_reference_sees_what_the_tracer_does(family, seed):
    agrees(make(family, seed))


@pytest.mark.parametrize("name", found.AGREEING)
def test_the_reference_is_right_where_a_method_once_failed(name):
    agrees(FOUND[name]())


SEARCHED = "pervertex:tolerance=0.5"

COMPLETE = (SEARCHED, "virtual")
"""What traces all that it does not prove."""

UNSURE = {Status.DOUBTFUL, Status.TRACED}

ONCE_LOST = ["concave-cap", "inside-ball", "worn-minus-7", "wavy-mesh", "concave-asphere", "plus-3-at-330-mm"]
"""Scenes in which maps of colours lost objects and said that they had not."""


def is_honest(scene: Scene, method: str) -> None:
    """No pixel is wrong away from silhouettes and says that it is proved, and few are at silhouettes."""
    judged = judge(Tracer(scene), scene.camera, shown_by(scene, method, SIZE))
    assert judged.plain.sum() > 200
    assert set(judged.wrong_by_status()) <= UNSURE, judged.wrong_by_status()
    if method in COMPLETE:
        assert not judged.wrong.any()
        assert judged.missed.sum() <= max(1, 0.005 * judged.silhouette.sum())


@pytest.mark.parametrize("method", COMPLETE)
@pytest.mark.parametrize(("family", "seed"), AGREEING)
def test_what_is_proved_is_there(family, seed, method):
    is_honest(make(family, seed), method)


@pytest.mark.parametrize("method", COMPLETE)
@pytest.mark.parametrize("name", ONCE_LOST)
def test_nothing_is_lost_that_was_lost_once(name, method):
    is_honest(FOUND[name](), method)


@pytest.mark.parametrize("name", ONCE_LOST[:2])
def test_without_a_tolerance_what_may_be_wrong_is_doubtful(name):
    is_honest(FOUND[name](), "pervertex")


@pytest.mark.parametrize("family", ["convex-cap", "toroid"])
def test_the_reference_sees_a_mesh_as_a_mesh(family):
    """Without its exact surface the same mesh is what there is."""
    agrees(make(family, 0).meshed())


@pytest.mark.parametrize("family", FAMILIES)
def test_a_family_makes_the_same_scene_of_the_same_seed(family):
    first, second = make(family, 5), make(family, 5)
    assert [part.name for part in first.parts] == [part.name for part in second.parts]
    for one, other in zip(first.parts, second.parts, strict=True):
        assert (one.mesh.positions == other.mesh.positions).all()
    assert first.camera == second.camera
    third = make(family, 6)
    pairs = zip(first.parts, third.parts, strict=False)
    assert not all(np.array_equal(one.mesh.positions, other.mesh.positions) for one, other in pairs)


@pytest.mark.parametrize("name", FOUND)
def test_a_scene_that_was_found_can_be_drawn(name):
    scene = FOUND[name]()
    assert len({part.name for part in scene.parts}) == len(scene.parts)
    assert any(mesh.specular for mesh in package_scene(scene).meshes)


def test_the_judgement_finds_what_a_map_of_few_texels_shows():
    scene = make("convex-cap", 1)
    judged = judge(Tracer(scene), scene.camera, shown_by(scene, "environment:face=64", SIZE))
    assert judged.wrong[judged.plain].mean() > 0.3
    assert set(judged.wrong_by_status()) <= set(Status)
