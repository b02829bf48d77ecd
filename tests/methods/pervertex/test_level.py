"""What the shaders get of a lens's rays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from lens_scenes import CAMERA, SIZE, lens_of

from anamorph.lenses.prescription import Prescription
from anamorph.methods.pervertex.level import corner_rays
from anamorph.optics.ray_meshes import bodies_of, rays_of
from anamorph.raymesh import RayStatus
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Scene


@pytest.mark.parametrize(("abbe", "colors"), [(None, 1), (40.0, 3)])
def test_a_lens_hands_on_the_rays_of_each_colour(abbe, colors):
    scene = Scene("lens", lens_of(Prescription(-2.0), abbe=abbe, vertices=60).meshes, CAMERA)
    (body,) = bodies_of(scene, flatten(scene))
    body_rays = rays_of(body, CAMERA.eye(SIZE))
    status = np.resize([RayStatus.TOTAL_REFLECTION, RayStatus.LEFT_BY_EDGE, RayStatus.OK], len(body_rays.rays.status))
    body_rays = replace(body_rays, rays=replace(body_rays.rays, status=status))
    faces = np.array([3, 1, 4])
    rays = corner_rays(body_rays, faces)
    assert rays.shape == (3, 3, colors, 2, 4)
    for number, each in enumerate((body_rays.rays, *body_rays.others)):
        corners = each.faces[faces]
        assert rays[:, :, number, 0, :3].tolist() == each.origins[corners].tolist()
        assert rays[:, :, number, 0, 3].tolist() == each.transmittance[corners].tolist()
        assert rays[:, :, number, 1, :3].tolist() == each.directions[corners].tolist()
        assert (rays[:, :, number, 1, 3] == (each.status[corners] == RayStatus.TOTAL_REFLECTION)).all()
