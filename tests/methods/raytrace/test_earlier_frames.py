"""A frame is the same whatever was drawn before: no pixel takes an earlier frame's ray for its neighbour's."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from anamorph import gallery
from anamorph.frame import View
from anamorph.methods import Specification

SIZE = (96, 72)


@pytest.mark.parametrize("method", ["raytrace", "raytrace:antialias=4"])
def test_what_was_traced_before_leaves_nothing_around_what_is_traced_now(method):
    scene = gallery.make("flat-mirror")
    eye, target = np.array(scene.camera.position), np.array(scene.camera.target)
    far = replace(scene.camera, position=tuple((eye + 0.8 * (eye - target)).tolist()))
    used, fresh = (Specification.parse(method).open(View(scene, scene.camera, SIZE)) for _ in range(2))
    used.draw(scene.camera)
    for session in (used, fresh):
        session.draw(far)
    assert np.array_equal(used.color(), fresh.color())
