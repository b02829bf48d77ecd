"""Random exact surfaces of every kind, for the contract test: flat, strongly curved, closed, and with poles."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from curved_surfaces import height_field, sphere_surface, torus_surface
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from anamorph.surfaces.base import Surface
from anamorph.surfaces.bezier import BezierPatch
from anamorph.surfaces.even_asphere import EvenAsphere
from anamorph.surfaces.nurbs import NurbsSurface
from anamorph.surfaces.plane import Plane
from anamorph.surfaces.similarity import Similarity, rotation
from anamorph.surfaces.sphere import Sphere
from anamorph.surfaces.toroid import Toroid


@dataclass(frozen=True, eq=False)
class Instance:
    """A surface with points to look at.

    Parameters
    ----------
    surface : Surface
    low, high : (2,) float64
        The range of (u, v) that is looked at.
    uv : (N, 2) float64
        Where it is smooth, inside.
    special : (M, 2) float64
        On its border, its seam or its poles.
    motion : Similarity
        Some motion.
    """

    surface: Surface
    low: np.ndarray
    high: np.ndarray
    uv: np.ndarray
    special: np.ndarray
    motion: Similarity

    @property
    def size(self) -> float:
        """The longest side of a box around what is looked at, metres."""
        shares = np.stack(np.meshgrid(*[np.linspace(0.0, 1.0, 9)] * 2), axis=-1).reshape(-1, 2)
        return float(np.ptp(self.surface.position(self.low + shares * (self.high - self.low)), axis=0).max())


shares = arrays(float, (6, 2), elements=st.floats(0.02, 0.98))
borders = arrays(float, (4, 2), elements=st.sampled_from([0.0, 0.3, 0.5, 1.0]))
places = arrays(float, 3, elements=st.floats(-2.0, 2.0).map(lambda x: round(x, 3)))
axes = st.tuples(*[st.floats(-180.0, 180.0)] * 3).map(rotation)
lens_curvatures = st.one_of(st.sampled_from([0.0, 1e-9, 12.0, -12.0]), st.floats(-15.0, 15.0))
coefficients = st.lists(st.floats(-200.0, 200.0), max_size=2).map(tuple)
heights = arrays(float, (4, 4, 3), elements=st.floats(-0.3, 0.3).map(lambda x: round(x, 2)))


motions = st.builds(Similarity, st.floats(0.1, 10.0), axes, places)


@st.composite
def instance(draw, surface, low, high):
    """The surface with random parameters between `low` and `high`."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    uv, special = (low + draw(each) * (high - low) for each in (shares, borders))
    return Instance(surface, low, high, uv, special, draw(motions))


@st.composite
def planes(draw):
    turn, lengths = draw(axes), draw(st.tuples(st.floats(0.1, 3.0), st.floats(0.1, 3.0)))
    lean = draw(st.floats(-0.9, 0.9))
    plane = Plane(draw(places), lengths[0] * turn[0], lengths[1] * (turn[1] + lean * turn[0]))
    return draw(instance(plane, [-1.0, -1.0], [2.0, 2.0]))


@st.composite
def spheres(draw):
    sphere = Sphere(draw(places), draw(st.sampled_from([1e-3, 0.2, 1.0, 50.0])), draw(axes))
    return draw(instance(sphere, [-np.pi, -np.pi / 2.0], [np.pi, np.pi / 2.0]))


def reach(*curvatures):
    """How far from its apex a lens surface of these curvatures is looked at, metres."""
    return min(0.5 / max(*map(abs, curvatures), 1e-9), 0.03)


@st.composite
def toroids(draw):
    base, cross = draw(lens_curvatures), draw(lens_curvatures)
    far = reach(base, cross)
    return draw(instance(Toroid(draw(places), base, cross, draw(axes)), [-far, -far], [far, far]))


@st.composite
def aspheres(draw):
    curvature, conic = draw(lens_curvatures), draw(st.floats(-3.0, 0.5))
    far = reach(curvature, 0.0)
    surface = EvenAsphere(draw(places), curvature, conic, draw(coefficients), draw(axes))
    return draw(instance(surface, [-far, -far], [far, far]))


FLAT = np.stack([*np.meshgrid(np.arange(4.0), np.arange(4.0), indexing="ij"), np.zeros((4, 4))], axis=-1)


@st.composite
def bezier_patches(draw):
    control = FLAT + draw(st.sampled_from([0.0, 0.3, 1.0])) * draw(heights)
    # A pole: one side of the patch is a point.
    if draw(st.booleans()):
        control[:, 0] = control[:, 0].mean(axis=0)
    return draw(instance(BezierPatch(draw(places) + control @ draw(axes)), [0.0, 0.0], [1.0, 1.0]))


@st.composite
def nurbs_surfaces(draw):
    sign = draw(st.sampled_from([1.0, -1.0]))
    made = draw(
        st.one_of(
            st.just(sphere_surface(sign=sign)),
            st.floats(0.1, 0.9).map(lambda minor: torus_surface(1.0, minor, sign)),
            st.integers(0, 20).map(height_field),
        )
    )
    low, high = made.domain
    given = draw(instance(made, low, high))
    # At its inner knots a rational circle is smooth, but not its parameter.
    knot = np.round(given.uv)
    uv = np.where(np.abs(given.uv - knot) < 0.02, np.clip(knot, low, high - 0.5) + 0.03, given.uv)
    return replace(given, uv=uv)


SURFACES = {
    Plane: planes(),
    Sphere: spheres(),
    BezierPatch: bezier_patches(),
    NurbsSurface: nurbs_surfaces(),
    Toroid: toroids(),
    EvenAsphere: aspheres(),
}
"""Of every exact surface some to look at, strategies of `Instance`."""
