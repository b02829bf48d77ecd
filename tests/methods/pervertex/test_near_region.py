"""Concave mirrors: what stands before the crossing of the rays is in the image, by both kinds of maps."""

from __future__ import annotations

import numpy as np
import pytest

import anamorph as an
from anamorph.gallery.curvature_series import one_mirror


@pytest.mark.parametrize("holds", ["image", "surfaces"])
def test_what_stands_before_the_crossing_is_seen_upright_in_colour(holds):
    scene = one_mirror(-0.5)
    pawn = 1 + next(number for number, mesh in enumerate(scene.meshes) if mesh.name.endswith("pawn"))
    reference = an.render(scene, method="raytrace", size=(200, 150), seen=True)
    shown = an.render(scene, method="pervertex", size=(200, 150), map=holds).color
    assert reference.specular is not None and reference.object_id is not None
    reflected = (reference.specular > 0) & (reference.object_id == pawn)
    assert reflected.sum() > 30
    wrong = np.abs(shown - reference.color)[reflected].max(axis=1) > 0.1
    assert wrong.mean() < 0.4
