"""Maps of pervertex that are drawn only where they are looked up."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scenes import open_view

from anamorph.gallery import make
from anamorph.gpu.targets import read_texture
from anamorph.methods.pervertex.pervertex import PerVertexDrawing

SIZE = (200, 150)


@cache
def scene_of(name):
    return make(name)


def opened(name, specification):
    scene = scene_of(name)
    session = open_view(scene, specification, SIZE)
    session.draw(scene.camera)
    return session


def drawn_texels(session):
    """How many texels of the maps of the first bounce have any colour."""
    return np.count_nonzero(read_texture(session.diagnostics()["levels"][0].atlas.color)[..., 3])


@pytest.mark.parametrize("name", ["car-mirror", "magnifier", "curvature-series", "spheres"])
@pytest.mark.parametrize("options", ["", "resolution=0.2", "resolution=3,projective=false"])
def test_the_image_is_that_of_whole_maps(name, options, monkeypatch):
    """Bit for bit: mirrors and lenses, with one map and two, convex and closed, with mirrors in their maps."""
    bounded = opened(name, f"pervertex:map=image,{options}")
    monkeypatch.setattr(PerVertexDrawing, "leave_out", None)
    whole = opened(name, f"pervertex:map=image,{options}")
    # Of tiny maps the boxes may hold all.
    assert drawn_texels(bounded) < drawn_texels(whole) or options == "resolution=0.2"
    assert np.array_equal(bounded.frame().color, whole.frame().color)


@pytest.mark.parametrize("options", ["antialias=4", "overlay=inconsistency"])
def test_maps_are_whole_where_other_texels_count(options, monkeypatch):
    """Where a map is read beside the places that it is looked up at."""
    session = opened("car-mirror", f"pervertex:map=image,{options}")
    monkeypatch.setattr(PerVertexDrawing, "leave_out", None)
    assert drawn_texels(session) == drawn_texels(opened("car-mirror", f"pervertex:map=image,{options}"))
