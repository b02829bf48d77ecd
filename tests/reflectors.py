"""A mirror ball before an eye, and things around another: what the tests of the paper's search look at."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from anamorph.gallery.spheres import mirror_ball
from anamorph.scene.model import Diffuse, Mesh

EYE = np.array([0.3, 0.2, 4.0])

BALL = mirror_ball("ball", (0.1, 0.0, 0.2), 1.0, rows=24, columns=36)


def small_things() -> tuple[Mesh, Mesh]:
    """Finely cut things around a small ball, so that straight edges show them well."""
    ball = mirror_ball("thing", (0.45, 0.55, 0.5), 0.12, rows=24, columns=36)
    other = mirror_ball("other", (-0.35, 0.75, 0.4), 0.1, rows=24, columns=36)
    plain = [replace(each, surface=None, parameters=None) for each in (ball, other)]
    return replace(plain[0], material=Diffuse((0.8, 0.2, 0.1))), replace(plain[1], material=Diffuse((0.1, 0.3, 0.8)))
