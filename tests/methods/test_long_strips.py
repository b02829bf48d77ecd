"""A mirror from an STL file whose triangles are as long as it is: the table in it is right, or doubtful."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from anamorph.files.opening import open_scene
from anamorph.frame import Status, View
from anamorph.methods import Specification
from anamorph.rendering import draw_frame


@pytest.mark.parametrize("method", ["auto", "pervertex"])
def test_a_cylinder_of_strips_shows_a_table(tmp_path: Path, method: str) -> None:
    trimesh.creation.cylinder(30.0, 150.0, sections=124).export(tmp_path / "cylinder.stl")
    (tmp_path / "table.obj").write_text("v -.3 0 -.3\nv -.3 0 .3\nv .3 0 .3\nv .3 0 -.3\nf 1 2 3 4\n")
    (tmp_path / "s.toml").write_text(
        "[eye]\nposition = [0, 0.3, 0.45]\ntarget = [0, 0.05, 0]\nfield_of_view = 32.0\n"
        '[[model]]\nfile = "cylinder.stl"\nunits = "mm"\naxes = "z up"\ntranslate = [0, 0.075, 0]\nmirror = {}\n'
        '[[model]]\nfile = "table.obj"\n'
    )
    scene, _ = open_scene(tmp_path / "s.toml")
    view = View(scene, scene.camera, (60, 45))
    frame, truth = (draw_frame(view, Specification.parse(name), True) for name in (method, "raytrace"))
    mirror = (truth.specular > 0) & (frame.specular > 0) & (truth.object_id == 2)
    assert mirror.sum() > 100
    off = np.linalg.norm(frame.position - truth.position, axis=-1) > 2e-3
    sure = frame.status != Status.DOUBTFUL
    assert not (mirror & sure & off & (frame.object_id == 2)).any()
    assert (off & mirror).sum() < 0.05 * mirror.sum()
