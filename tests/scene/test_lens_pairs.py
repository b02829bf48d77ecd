"""The lenses of a scene: two faces of glass with one name, and nothing that only looks like them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import CAMERA, spherical_mirror

from anamorph import gallery
from anamorph.base.errors import AnamorphError
from anamorph.lenses.making import make_lens
from anamorph.lenses.prescription import Prescription
from anamorph.scene.checks import check_contents
from anamorph.scene.lens_pairs import LensPair, SceneGlass, has_one_border, least_edge, scene_glass
from anamorph.scene.model import Diffuse, Glass, Mesh, Scene
from anamorph.surfaces.similarity import Similarity


def lens(name="lens", at=0.0):
    return make_lens(Prescription(-2.0), (at, 0.0, 0.0), (0.0, 0.0, 1.0), name=name, vertices=19)


def found(*meshes) -> SceneGlass:
    return scene_glass(Scene("test", meshes, CAMERA))


@pytest.mark.parametrize("name", ["spectacles-minus", "spectacles-plus", "magnifier"])
def test_built_in_lenses_are_found(name):
    assert scene_glass(gallery.make(name)) == SceneGlass((LensPair("lens", 0, 1, 2),), ())


def test_a_scene_without_glass_has_none():
    assert scene_glass(gallery.make("car-mirror")) == SceneGlass((), ())


@settings(max_examples=20)
@given(st.permutations(range(7)))
def test_two_lenses_are_found_in_any_order(order):
    """Names with slashes of their own, one name the beginning of the other."""
    meshes = (*lens("a").meshes, *lens("a/front", 0.1).meshes, replace(spherical_mirror(), name="mirror"))
    shuffled = [meshes[i] for i in order]
    place = [order.index(i) for i in range(7)]
    pairs = {LensPair("a", *place[:3]), LensPair("a/front", *place[3:6])}
    glass = found(*shuffled)
    assert set(glass.lenses) == pairs and glass.others == ()
    assert [pair.front for pair in glass.lenses] == sorted(pair.front for pair in pairs)


def test_a_lens_needs_no_edge_and_takes_none_of_glass():
    front, back, edge = lens().meshes
    assert found(back, front) == SceneGlass((LensPair("lens", 1, 0, None),), ())
    assert found(front, back, replace(edge, material=Glass(1.5))) == SceneGlass((LensPair("lens", 0, 1, None),), (2,))


FRONT, BACK, EDGE = lens().meshes


@pytest.mark.parametrize(
    "back",
    [
        None,
        replace(BACK, name="lens/rear"),
        replace(BACK, name="other/back"),
        replace(BACK, material=Diffuse()),
        replace(BACK, material=Glass(1.6, abbe=58.0)),
        replace(BACK, material=Glass(1.5, abbe=30.0)),
        replace(BACK, surface=None),
        replace(BACK, parameters=None),
        replace(BACK, faces=np.concatenate([BACK.faces, BACK.faces[:, ::-1]])),
        replace(BACK, faces=BACK.faces[:0]),
        replace(BACK, faces=np.delete(BACK.faces, 0, axis=0)),
    ],
)
def test_what_is_no_pair_is_told_apart(back):
    meshes = (FRONT,) if back is None else (FRONT, back)
    glass = found(*meshes, EDGE)
    assert glass.lenses == ()
    assert glass.others == tuple(i for i, mesh in enumerate(meshes) if isinstance(mesh.material, Glass))


def test_a_name_that_two_meshes_share_is_no_lens():
    assert found(FRONT, BACK, BACK) == SceneGlass((), (0, 1, 2))
    assert found(FRONT, FRONT, BACK) == SceneGlass((), (0, 1, 2))
    assert found(replace(FRONT, name="front"), replace(BACK, name="back")) == SceneGlass((), (0, 1))
    assert found(
        replace(FRONT, name="front"), replace(FRONT, name="/front"), replace(BACK, name="/back")
    ) == SceneGlass((LensPair("", 1, 2, None),), (0,))
    assert found(FRONT, BACK, EDGE, EDGE) == SceneGlass((LensPair("lens", 0, 1, None),), ())


def test_one_border_is_one_closed_line():
    def mesh(*faces):
        count = 1 + max((max(face) for face in faces), default=0)
        return Mesh("m", np.zeros((count, 3), "f4"), np.array(faces, np.int32).reshape(-1, 3), np.zeros((count, 3)))

    assert has_one_border(mesh((0, 1, 2)))
    assert has_one_border(mesh((0, 1, 2), (2, 1, 3)))
    assert not has_one_border(mesh())
    assert not has_one_border(mesh((0, 1, 2), (3, 4, 5))), "two pieces"
    assert not has_one_border(mesh((0, 1, 2), (0, 3, 4))), "they touch in a corner"
    assert not has_one_border(mesh((0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2))), "closed"


@pytest.mark.parametrize(
    ("thickness", "words"),
    [
        (0.0, "lens 'lens': its faces meet in a sharp edge, 0 mm thick at the border; make it thicker or smaller"),
        (-1e-4, "lens 'lens': its faces cross by 0.1 mm at the border; make it thicker or smaller"),
    ],
)
def test_lenses_without_an_edge_between_their_faces_are_refused(thickness, words):
    front, back, edge = lens().meshes
    scene = Scene("test", (front, back, edge), CAMERA)
    assert check_contents(scene).meshes == scene.meshes
    by = Similarity.shift(np.array([0.0, 0.0, thickness - least_edge(front, back)]))
    with pytest.raises(AnamorphError, match=words):
        check_contents(replace(scene, meshes=(front.moved(by), back, edge)))
