"""`bounces` counts the specular interfaces that a path meets: a mirror is one, and a lens is two, in every method."""

from __future__ import annotations

from dataclasses import fields
from functools import cache

import numpy as np
import pytest
from lens_scenes import CENTER, MINUS, lens_of, scene_of, walls
from scenes import drawn

from anamorph.frame import Frame, Status
from anamorph.gallery.flat_mirror import plane_mirror
from anamorph.lenses.making import make_lens
from anamorph.measure.errors import silhouettes
from anamorph.methods import METHODS
from anamorph.scene.camera import Camera
from anamorph.scene.model import Scene

SIZE = (160, 120)
COUNTING = [
    # Maps of surfaces end at the second body; what follows is traced under a tolerance.
    "pervertex:map=image" if name == "pervertex" else name
    for name, method in METHODS.items()
    if "bounces" in {field.name for field in fields(method.options)}
]


def lens_before_mirror() -> Scene:
    """A mirror that is seen through a lens."""
    return scene_of(lens_of(MINUS), plane_mirror("mirror", (-0.6, 0.1, -0.1), (1.0, 0.0, 0.5), (0.0, 0.8, 0.0)))


def mirror_before_lens() -> Scene:
    """A lens that is seen in a mirror, and not by itself."""
    mirror = plane_mirror("mirror", (-0.2, 0.35, 0.0), (0.4, 0.0, 0.0), (0.0, 0.3, 0.0))
    lens = make_lens(MINUS, (-0.08, 0.42, 0.28), (-0.3, 0.0, 1.0))
    return Scene(
        "lens", (mirror, *lens.meshes, *walls()), Camera((0.25, 0.65, 0.9), (-0.03, 0.47, 0.0), field_of_view=9)
    )


def mirrors_alone() -> Scene:
    """Two mirrors that see each other."""
    left = plane_mirror("left", (-0.11, 0.4, -0.1), (0.1, 0.0, -0.1), (0.0, 0.2, 0.0))
    right = plane_mirror("right", (0.01, 0.4, -0.2), (0.1, 0.0, 0.1), (0.0, 0.2, 0.0))
    return Scene("mirrors", (left, right, *walls()), Camera((0.02, 0.5, 0.5), tuple(CENTER.tolist()), field_of_view=24))


SCENES = {scene.__name__: scene for scene in (lens_before_mirror, mirror_before_lens, mirrors_alone)}


@cache
def built(scene: str, specification: str) -> Frame:
    return drawn(SCENES[scene](), specification, SIZE)


def limited(method: str, bounces: int) -> str:
    return f"{method}{',' if ':' in method else ':'}bounces={bounces}"


def ended(frame: Frame) -> np.ndarray:
    return frame.status == Status.OUTSIDE


def within(frame: Frame) -> np.ndarray:
    """Pixels of specular surfaces, away from all borders."""
    border = silhouettes(frame.object_id, frame.specular, frame.status)
    return (frame.specular > 0) & ~silhouettes(border.astype(int))


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("bounces", [1, 2, 3])
@pytest.mark.parametrize("method", [name for name in COUNTING if name != "raytrace"])
def test_paths_end_where_those_of_rays_do(method, bounces, scene):
    reference, frame = (built(scene, limited(name, bounces)) for name in ("raytrace", method))
    expected, counted = ended(reference), within(reference)
    if (scene, method) == ("mirror_before_lens", "trilinear"):
        # It follows no path from a mirror into a lens, not even to the lens's edge.
        expected = ended(built(scene, "raytrace:bounces=1"))
    assert counted.sum() > 1500
    # A few paths come back to the lens, which no map and no ray triangle shows.
    assert (ended(frame) == expected)[counted].mean() > 0.99
    assert (frame.specular == reference.specular)[counted].mean() > 0.99


@pytest.mark.parametrize(
    ("scene", "needed"), [("lens_before_mirror", 3), ("mirror_before_lens", 3), ("mirrors_alone", 2)]
)
def test_rays_need_as_many_bounces_as_there_are_interfaces(scene, needed):
    most = built(scene, "raytrace:bounces=8")
    through = within(most) & ~ended(most) & ended(built(scene, f"raytrace:bounces={needed - 1}"))
    assert through.sum() > 300
    # From the mirror some go back through the lens.
    assert ended(built(scene, f"raytrace:bounces={needed}"))[through].mean() < 0.05


@pytest.mark.parametrize("method", [*COUNTING, "raytrace:truth=raymesh"])
def test_a_lens_met_first_is_not_crossed_by_one_bounce(method):
    scene = scene_of(lens_of(MINUS))
    once, twice = (drawn(scene, limited(method, count), SIZE) for count in (1, 2))
    lens = within(twice) & ~ended(twice) & (twice.status != Status.TOTAL_REFLECTION) & (twice.object_id != 3)
    assert lens.sum() > 1500
    assert ended(once)[lens].mean() > 0.999 and (once.specular == twice.specular)[lens].all()
    assert np.isin(once.object_id[lens & ended(once)], [1, 2]).all()


def test_what_methods_follow_by_themselves():
    assert [METHODS[name].options().bounces for name in ("raytrace", "pervertex", "trilinear")] == [8, 3, 2]
