"""The figures of a mirror's curvature: closed forms, and what cannot be measured."""

from __future__ import annotations

import door_mirror
import numpy as np
import pytest
from curved_surfaces import mesh_on, wavy

from anamorph.base.errors import AnamorphError
from anamorph.files.cad import CadFace
from anamorph.measure.curvature import mirror_radii, principal_radii
from anamorph.scene.model import Mesh
from anamorph.surfaces.even_asphere import EvenAsphere
from anamorph.surfaces.nurbs import NurbsSurface
from anamorph.surfaces.sphere import Sphere
from anamorph.surfaces.toroid import Toroid

CLAMPED = np.array([0, 0, 0, 1, 1, 1.0])


def bowl(along_x, along_y, tilt=0.0):
    """z = -(x^2 / along_x + y^2 / along_y) / 2 over 0.2 x 0.1, exactly, as a face."""
    ends = np.array([-1.0, 0.0, 1.0])
    # Bezier ordinates of t^2 on -1 to 1.
    square = np.array([1.0, -1.0, 1.0])
    x, y = np.meshgrid(0.1 * ends, 0.05 * ends, indexing="ij")
    z = -0.5 * (0.01 * square[:, None] / along_x + 0.0025 * square[None, :] / along_y)
    poles = np.stack([x, y, z], axis=-1)
    cosine, sine = np.cos(tilt), np.sin(tilt)
    turned = poles @ np.array([[cosine, 0, -sine], [0, 1, 0], [sine, 0, cosine]]).T
    surface = NurbsSurface(turned, np.ones((3, 3)), CLAMPED, CLAMPED, 2, 2)
    return CadFace(1, "glass", "", surface, ())


@pytest.mark.parametrize("tilt", [0.0, 1.0])
@pytest.mark.parametrize("density", [5, 12])
def test_the_radii_in_the_middle_are_those_of_the_formula(tilt, density):
    radii = mirror_radii(bowl(1.4, 1.2, tilt).mesh(density))
    np.testing.assert_allclose(radii.principal[1], [1.2, 1.4], rtol=1e-9)
    aside = 0.2 / 6.0
    # Along a parabola the radius grows as (1 + slope^2)^1.5, across it as (1 + slope^2)^0.5.
    stretch = 1.0 + (aside / 1.4) ** 2
    for point in (0, 2):
        np.testing.assert_allclose(radii.principal[point], [1.2 * stretch**0.5, 1.4 * stretch**1.5], rtol=1e-9)
    assert radii.mean == pytest.approx(radii.point_means.mean(), rel=1e-12)
    assert radii.principal_deviation == pytest.approx(0.1 / 1.3, rel=5e-3)
    assert radii.point_deviation == pytest.approx(abs(radii.point_means[1] - radii.mean) / radii.mean, rel=1e-9)


def test_a_concave_mirror_has_negative_radii():
    mesh = bowl(-1.4, -1.2).mesh(6)
    assert mirror_radii(mesh).mean == pytest.approx(-1.3, rel=5e-3)
    assert (principal_radii(mesh) < 0).all()


def test_the_shipped_mirror_is_spherical_in_its_inner_part_only():
    poles, knots_x, knots_y = door_mirror.spline()
    surface = NurbsSurface(poles, np.ones(poles.shape[:2]), knots_x, knots_y, 5, 5)
    mesh = CadFace(1, "glass", "", surface, ()).mesh(24)
    radii = mirror_radii(mesh)
    np.testing.assert_allclose(radii.point_means, door_mirror.RADIUS, rtol=1e-5)
    assert max(radii.principal_deviation, radii.point_deviation) < 1e-5
    outer = principal_radii(mesh)[surface.position(mesh.parameters)[:, 0] < -0.09]
    assert 0.15 < outer.min() < 0.4 and outer.max() > 1.2


def test_what_has_no_radius_is_refused_in_one_line():
    flat = bowl(np.inf, np.inf).mesh(6)
    assert np.isinf(principal_radii(flat)).all()
    with pytest.raises(AnamorphError, match=r"^mirror 'glass': is flat[^\n]*$"):
        mirror_radii(flat)
    plain = Mesh("plain", flat.positions, flat.faces, flat.normals)
    with pytest.raises(AnamorphError, match=r"^mirror 'plain': has no exact surface[^\n]*$"):
        mirror_radii(plain)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_every_exact_surface_has_its_radii(side):
    """Those of closed forms; a concave mirror is cut from the same surface, with its normals the other way."""
    far = [0.1, 0.06]
    sphere = mesh_on(Sphere(np.zeros(3), 1.4), np.array([-0.08, -0.05]), np.array([0.08, 0.05]), side=side)
    np.testing.assert_allclose(principal_radii(sphere), side * 1.4, rtol=1e-12)
    assert mirror_radii(sphere).mean == pytest.approx(side * 1.4, rel=1e-12)
    assert mirror_radii(sphere).principal_deviation < 1e-12

    apex = [0.0, 0.0, 0.0]
    toroid = mesh_on(Toroid(np.array(apex), 1.0 / 1.4, 1.0 / 1.2), np.negative(far), np.array(far), side=side)
    np.testing.assert_allclose(mirror_radii(toroid).principal[1], [side * 1.2, side * 1.4], rtol=1e-9)
    asphere = mesh_on(EvenAsphere(np.array(apex), 1.0 / 1.4, -1.0), np.negative(far), np.array(far), side=side)
    # A paraboloid, along its slope and across it.
    stretch = 1.0 + (0.2 / 6.0 / 1.4) ** 2
    for point, (across, along) in enumerate([(stretch**0.5, stretch**1.5), (1.0, 1.0), (stretch**0.5, stretch**1.5)]):
        expected = [side * 1.4 * across, side * 1.4 * along]
        np.testing.assert_allclose(mirror_radii(asphere).principal[point], expected, rtol=1e-9)
    patch = mesh_on(wavy(), np.zeros(2), np.ones(2), side=side)
    expected = np.sort(side * wavy().curvatures(patch.parameters))
    np.testing.assert_allclose(np.sort(1.0 / principal_radii(patch)), expected, rtol=1e-12)
