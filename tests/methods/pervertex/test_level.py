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


@pytest.mark.parametrize("abbe", [None, 40.0])
def test_a_lens_hands_on_the_rays_of_green_light(abbe):
    scene = Scene("lens", lens_of(Prescription(-2.0), abbe=abbe, vertices=60).meshes, CAMERA)
    (body,) = bodies_of(scene, flatten(scene))
    body_rays = rays_of(body, CAMERA.eye(SIZE))
    status = np.resize([RayStatus.TOTAL_REFLECTION, RayStatus.LEFT_BY_EDGE, RayStatus.OK], len(body_rays.rays.status))
    body_rays = replace(body_rays, rays=replace(body_rays.rays, status=status))
    faces = np.array([3, 1, 4])
    rays = corner_rays(body_rays, faces)
    assert rays.shape == (3, 3, 2, 4)
    corners = body_rays.rays.faces[faces]
    assert rays[:, :, 0, :3].tolist() == body_rays.rays.origins[corners].tolist()
    assert rays[:, :, 0, 3].tolist() == body_rays.rays.transmittance[corners].tolist()
    assert rays[:, :, 1, :3].tolist() == body_rays.rays.directions[corners].tolist()
    assert (rays[:, :, 1, 3] == (status[corners] == RayStatus.TOTAL_REFLECTION)).all()
