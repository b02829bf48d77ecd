"""A mesh that is moved takes its exact surface along, and stays on it."""

from __future__ import annotations

import numpy as np
import pytest
from curved_surfaces import mesh_on, sphere_surface, wavy

from anamorph.surfaces.similarity import Similarity, rotation
from anamorph.surfaces.toroid import Toroid

BY = Similarity(2.5, rotation((20.0, -50.0, 70.0)), np.array([1.0, 2.0, 3.0]))


@pytest.mark.parametrize(
    ("surface", "low", "high"),
    [
        (Toroid(np.zeros(3), 5.0, 8.0), [-0.05, -0.04], [0.05, 0.04]),
        (sphere_surface(), [0.5, 0.5], [1.5, 1.5]),
        (wavy(), [0.0, 0.0], [1.0, 1.0]),
    ],
    ids=["toroid", "nurbs", "bezier"],
)
def test_a_scaled_mesh_lies_on_its_scaled_surface(surface, low, high):
    mesh = mesh_on(surface, low, high)
    moved = mesh.moved(BY)
    np.testing.assert_allclose(moved.positions, BY.points(mesh.positions), atol=1e-6)
    np.testing.assert_allclose(moved.surface.position(moved.parameters), moved.positions, atol=1e-6)
    np.testing.assert_allclose(moved.surface.normal(moved.parameters), moved.normals, atol=1e-6)
