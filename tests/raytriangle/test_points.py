"""Points projected into ray triangles, against exact arithmetic, with degenerate ray triangles drawn on purpose.

What "none is missed" means: the real roots of the cubic of the very float64 numbers given are counted and enclosed in
rational arithmetic (Sturm's sequences). Each must be found whose ray has weights of at most 1e4, times t in units of
the scene where that is more than 1, and whose parametric triangle is no flatter than 1 to 1e5 and no smaller than 1e-11
of what it comes from. Beyond, no float64 t leads to the point within 1e-9, or many rays do. A double root and its
neighbours count as one root wherever the point stays within 1e-9 of the scene's size of the parametric triangle's plane
from one to the other: that is all that the accuracy asked for can tell apart.
"""

from __future__ import annotations

import itertools
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import Phase, example, given, settings
from hypothesis import strategies as st
from ray_triangles import KINDS, NEARLY, points_for, ray_triangle

from anamorph.base.errors import AnamorphError
from anamorph.raytriangle import project_points
from anamorph.raytriangle.roots import cubic_roots


def exact(array):
    return np.vectorize(Fraction, otypes=[object])(array)


def exact_cross(a, b):
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def exact_cubic(p, n, s):
    """c0 to c3 of det(p + t n - s), from its values at four t (Newton's divided differences)."""
    values = []
    for t in range(4):
        a, b, c = p + t * n - s
        values.append(a @ exact_cross(b, c))
    d1 = [values[i + 1] - values[i] for i in range(3)]
    d2 = [(d1[i + 1] - d1[i]) / 2 for i in range(2)]
    d3 = (d2[1] - d2[0]) / 3
    # v0 + d1 t + d2 t (t - 1) + d3 t (t - 1) (t - 2)
    return [values[0], d1[0] - d2[0] + 2 * d3, d2[0] - 3 * d3, d3]


def value(polynomial, t):
    total = Fraction(0)
    for coefficient in reversed(polynomial):
        total = total * t + coefficient
    return total


def trimmed(polynomial):
    while polynomial and polynomial[-1] == 0:
        polynomial = polynomial[:-1]
    return polynomial


def sturm(polynomial):
    """The Sturm sequence of a polynomial with rational coefficients."""
    chain = [trimmed(polynomial), trimmed([k * c for k, c in enumerate(polynomial)][1:])]
    while len(chain[-1]) > 1:
        rest, by = list(chain[-2]), chain[-1]
        while len(rest) >= len(by):
            factor = rest[-1] / by[-1]
            rest = [r - factor * b for r, b in zip(rest, [Fraction(0)] * (len(rest) - len(by)) + by, strict=True)][:-1]
        rest = trimmed(rest)
        if not rest:
            break
        chain.append([-c for c in rest])
    return [link for link in chain if link]


def changes(chain, t):
    signs = [v > 0 for link in chain if (v := value(link, t)) != 0]
    return sum(a != b for a, b in itertools.pairwise(signs))


def exact_roots(polynomial, reach):
    """The distinct real roots in (-reach, reach], each to 1e-17 of itself or of 1."""
    chain = sturm(polynomial)
    open_ones, roots = [(Fraction(-reach), Fraction(reach))], []
    while open_ones:
        low, high = open_ones.pop()
        count = changes(chain, low) - changes(chain, high)
        if count == 0:
            continue
        if high - low < Fraction(1, 10**17) * max(abs(low), abs(high), Fraction(1)):
            roots += [(low + high) / 2] * count
            continue
        # Far from 0, halve the exponent and not the length.
        middle = (low + high) / 2
        if low < -1 and high > 1:
            middle = Fraction(0)
        elif low >= 0 and high > 4 and high > 16 * max(low, 1):
            middle = Fraction(int(np.sqrt(float(high) * max(float(low), 1.0))))
        elif high <= 0 and low < -4 and -low > 16 * max(-high, 1):
            middle = -Fraction(int(np.sqrt(float(-low) * max(float(-high), 1.0))))
        open_ones += [(low, middle), (middle, high)]
    return sorted(roots)


def exact_weights(p, n, s, t):
    """The weights of the three rays at a root, or None where the parametric triangle has no area."""
    a, b, c = p + t * n
    normal = exact_cross(b - a, c - a)
    area = normal @ normal
    if area == 0:
        return None
    return [normal @ exact_cross(c - b, s - b) / area, normal @ exact_cross(a - c, s - c) / area,
            normal @ exact_cross(b - a, s - a) / area]  # fmt: skip


def is_triangle(p, n, t):
    """Whether the parametric triangle is neither a point nor a line."""
    a, b, c = p + t * n
    longest = max(np.linalg.norm(side) for side in (b - a, c - b, a - c))
    full = np.abs(p - p.mean(axis=0)).max() + abs(t) * np.abs(n).max()
    return longest >= 1e-11 * full and np.linalg.norm(np.cross(b - a, c - a)) >= 1e-5 * longest**2


def one_root(cubic, pe, ne, size, t, other):
    """Whether the point stays within 1e-9 of its size of the parametric triangle's plane from t to `other`."""
    for share in np.linspace(0.0, 1.0, 9):
        at = Fraction(t) + Fraction(share) * (Fraction(other) - Fraction(t))
        a, b, c = pe + at * ne
        normal = np.linalg.norm(exact_cross(b - a, c - a).astype(float))
        if abs(value(cubic, at)) > Fraction(1e-9 * size * normal):
            return False
    return True


def size_of(p, s):
    middle = p.mean(axis=0)
    return max(np.linalg.norm(s - middle), np.linalg.norm(p - middle, axis=1).max())


def largest_miss(p, n, points, result):
    """The distance of each valid ray from its point over the size, evaluated exactly; the greatest."""
    worst = 0.0
    for k, j in np.argwhere(result.valid):
        u, v, t = (Fraction(float(array[k, j])) for array in (result.u, result.v, result.t))
        w = np.array([1 - u - v, u, v])
        off = [float(x) for x in w @ exact(p) + t * (w @ exact(n)) - exact(points[k])]
        worst = max(worst, (np.linalg.norm(off) - 1e-15 * np.abs(p).max()) / max(size_of(p, points[k]), 1e-300))
    return worst


@settings(max_examples=40, phases=(Phase.explicit, Phase.generate))
@given(st.sampled_from(KINDS), st.sampled_from(NEARLY), st.integers(0, 2**32 - 1))
@example("slit", 1e-12, 9225)
@example("slit", 1e-12, 12662017)
@example("focus", 1e-4, 2380764447)
@example("focus", 1e-13, 1543634)
@example("parallel", 1e-12, 3506691144)
@example("together", 1e-16, 484115793)
def test_every_root_is_a_ray_through_the_point_and_none_is_missed(kind, nearly, seed):
    random = np.random.default_rng(seed)
    p, n = ray_triangle(kind, nearly, random)
    points = points_for(p, n, nearly, random)
    result = project_points(p, n, points)
    assert not (result.valid & ~result.real).any()
    assert (result.real[:, :-1] | ~result.real[:, 1:]).all()
    assert (np.diff(result.t, axis=-1)[result.real[:, 1:]] >= 0.0).all()
    assert largest_miss(p, n, points, result) <= 1e-9, "miss"
    longest = np.linalg.norm(n, axis=1).max()
    for k, s in enumerate(points):
        if size_of(p, s) <= 1e-12 * np.abs(p).max():
            continue
        # t in units in which the sizes of the problem are about 1; a power of two, to be exact.
        unit = 2.0 ** np.round(np.log2(size_of(p, s) / longest))
        pe, ne, se = exact(p), exact(n * unit), exact(s)
        cubic = exact_cubic(pe, ne, se)
        scale = np.abs(n * unit).max() + np.abs(p - p.mean(axis=0)).max()
        if max(abs(float(c)) for c in cubic) <= 1e-11 * size_of(p, s) * scale**2:
            continue
        found = result.t[k][result.valid[k]] / unit
        for root in exact_roots(cubic, 10**5):
            weights = exact_weights(pe, ne, se, root)
            reach = max(map(abs, weights)) * max(1, abs(root)) if weights else np.inf
            if reach <= 1e4 and is_triangle(p, n * unit, float(root)):
                there = [one_root(cubic, pe, ne, size_of(p, s), root, float(t)) for t in found]
                assert any(there), (k, float(root), result.t[k] / unit)


def rays(p, n, result):
    """The points (N, 3 roots, 3) to which the roots lead."""
    w = np.stack([1.0 - result.u - result.v, result.u, result.v], axis=-1)
    return w @ p + result.t[..., None] * (w @ n)


def test_a_pinhole_projects_as_a_pinhole_and_its_eye_to_the_middle():
    n = np.array([[-1.0, -1.0, 2.0], [1.0, -1.0, 2.0], [0.0, 2.0, 2.0]])
    eye = np.array([0.1, 0.2, 0.3])
    points = eye + np.array([[0.0, 0.0, 5.0], [0.5, -1.0, -4.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    for back in (0.0, 1.7, -30.0):
        result = project_points(eye - back * n, n, points)
        assert result.real.sum(axis=1).tolist() == [1, 1, 1, 1] and result.valid.sum(axis=1).tolist() == [1, 1, 1, 0]
        assert result.t[:3, 0] == pytest.approx([2.5 + back, -2.0 + back, back], abs=1e-12)
        assert (result.u[0, 0], result.v[0, 0]) == pytest.approx((1 / 3, 1 / 3))
        assert (result.u[2, 0], result.v[2, 0]) == pytest.approx((1 / 3, 1 / 3))
        assert rays(eye - back * n, n, result)[:3, 0] == pytest.approx(points[:3], abs=1e-12)
        assert result.inside[:, 0].tolist() == [True, True, True, False]
        assert result.seen[:, 0].tolist() == [back > -2.5, False, back >= 0.0, False]


def test_parallel_rays_meet_a_point_once_and_rays_along_their_triangle_never():
    p = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    points = np.array([[0.25, 0.5, 3.0], [0.25, 0.5, -3.0], [2.0, 0.0, 1.0]])
    result = project_points(p, np.tile([0.0, 0.0, 2.0], (3, 1)), points)
    assert result.valid.tolist() == result.real.tolist() == [[True, False, False]] * 3
    assert result.t[:, 0] == pytest.approx([1.5, -1.5, 0.5])
    assert result.u[:, 0] == pytest.approx([0.25, 0.25, 2.0]) and result.v[:, 0] == pytest.approx([0.5, 0.5, 0.0])
    assert result.seen[:, 0].tolist() == [True, False, False]
    level = np.array([[1.0, 0.0, 0.0], [1.0, 0.2, 0.0], [0.7, 0.1, 0.0]])
    inside_the_plane = project_points(p, level, np.array([[3.0, 0.2, 0.0], [3.0, 0.2, 1.0]]))
    assert not inside_the_plane.real.any()


def test_rays_parallel_to_one_plane_leave_a_quadratic():
    p = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    n = np.array([[0.0, 0.0, 1.0], [0.0, 0.5, 1.0], [0.0, -0.3, 1.2]])
    points = np.random.default_rng(3).uniform(-3, 3, (200, 3))
    result = project_points(p, n, points)
    assert set(result.real.sum(axis=1)) == {0, 2}
    off = rays(p, n, result) - points[:, None]
    assert np.abs(off[result.valid]).max() < 1e-9 and (result.valid == result.real).all()


def test_many_rays_through_a_slit_are_answered_by_the_one_nearest_to_the_middle():
    # At t = 1 the parametric triangle is the line from (0, 0, 0) to (1, 0, 0), its third corner in the middle.
    p = np.array([[0.0, 0.0, -1.0], [1.0, 0.3, -1.0], [0.5, -0.2, -1.5]])
    n = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.0, 0.0]]) - p
    on, off = project_points(p, n, np.array([[0.5, 0.0, 0.0]])), project_points(p, n, np.array([[0.5, 0.1, 0.3]]))
    aside = project_points(p, n, np.array([[0.25, 0.0, 0.0]]))
    assert (aside.valid & (np.abs(aside.t - 1.0) < 1e-9) & (np.abs(aside.u - 1 / 12) < 1e-9)).sum() == 1
    at_slit = on.valid[0] & (np.abs(on.t[0] - 1.0) < 1e-9)
    assert at_slit.sum() == 1
    assert (on.u[0][at_slit], on.v[0][at_slit]) == (pytest.approx(1 / 3), pytest.approx(1 / 3))
    assert off.real.any() and not (off.real & (np.abs(off.t - 1.0) < 1e-6)).any()
    assert rays(p, n, off)[off.valid] == pytest.approx(np.tile([0.5, 0.1, 0.3], (off.valid.sum(), 1)))


def test_rays_with_no_triangle_between_them_project_nothing():
    p = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    n = np.array([[0.0, 1.0, 1.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]])
    result = project_points(p, n, np.array([[0.0, 1.0, 1.0], [0.3, 0.4, 0.5]]))
    assert not result.real.any() and not result.t.any() and not result.u.any()
    random = np.random.default_rng(8)
    for _ in range(20):
        p, n, alike, points = random.normal(size=(4, 3, 3))
        p[1], n[1] = p[0] + 5e-15 * alike[0], n[0] + 5e-15 * alike[1]
        assert not project_points(p, n, points).real.any()


def test_a_point_on_a_caustic_is_reported_twice_and_beyond_it_not_at_all():
    # Rays of the upper half of a circle's tangents: (t, t^2) is where the ray at u = t touches the parabola.
    p = np.array([[0.0, 0.0, 0.0], [1.0, -1.0, 0.0], [0.0, 0.0, 1.0]])
    n = np.array([[1.0, 0.0, 0.0], [1.0, 2.0, 0.0], [1.0, 0.0, 0.0]])
    # At v = 0: ray(u, 0, t) = (u + t, u (2 t - 1)); with x = u + t, y = u (2 x - 2 u - 1): the greatest y at a given x.
    x = 2.0
    u = (2.0 * x - 1.0) / 4.0
    top = np.array([x, u * (2.0 * x - 2.0 * u - 1.0), 0.0])
    result = project_points(p, n, top + np.array([[0.0, 0.0, 0.0], [0.0, -1e-3, 0.0], [0.0, 1e-3, 0.0]]))
    assert result.valid.sum(axis=1).tolist() == [2, 2, 0]
    assert result.u[0, :2] == pytest.approx([u, u], abs=1e-7)


def test_many_ray_triangles_are_projected_as_one_by_one():
    random = np.random.default_rng(5)
    p, n = random.normal(size=(2, 4, 2, 3, 3))
    shared, own = random.normal(size=(7, 3)), random.normal(size=(4, 2, 7, 3))
    for points in (shared, own):
        together = project_points(p, n, points)
        for i, j in np.ndindex(4, 2):
            alone = project_points(p[i, j], n[i, j], points if points is shared else points[i, j])
            assert (alone.real == together.real[i, j]).all() and (alone.valid == together.valid[i, j]).all()
            assert alone.t == pytest.approx(together.t[i, j], rel=1e-9, abs=1e-12)
            assert alone.u == pytest.approx(together.u[i, j], rel=1e-7, abs=1e-9)


@pytest.mark.parametrize(
    ("p", "n", "points", "said"),
    [
        (np.eye(3), np.zeros((3, 3)), np.zeros((1, 3)), "all three directions are 0"),
        (np.full((3, 3), np.nan), np.eye(3), np.zeros((1, 3)), "finite"),
        (np.eye(3), np.eye(3), np.array([[0.0, np.inf, 0.0]]), "points"),
        (np.eye(3)[:2], np.eye(3)[:2], np.zeros((1, 3)), "three rows"),
    ],
)
def test_what_cannot_be_projected_is_refused_in_one_line(p, n, points, said):
    with pytest.raises(AnamorphError, match=said) as raised:
        project_points(p, n, points)
    assert "\n" not in str(raised.value)


def roots_of(cubic, noise=0.0):
    found = np.zeros(8)
    return found[: cubic_roots(tuple(map(float, cubic)), noise, 1e10, found)]


@settings(max_examples=60, phases=(Phase.explicit, Phase.generate))
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 1e-15]))
def test_cubics_of_every_degree_have_all_their_roots(seed, noise):
    random = np.random.default_rng(seed)
    roots = random.choice([0.0, 0.5, -2.0, 1e-3, 1e4, -1.0, 1.0], 3) * random.choice([1.0, random.normal()], 3)
    for cubic in (np.poly(roots)[::-1], random.normal(size=4), random.normal(size=4) * random.integers(0, 2, 4)):
        exact = (
            [float(root) for root in exact_roots([Fraction(float(c)) for c in cubic], 10**10)] if cubic.any() else []
        )
        found = roots_of(cubic, noise)
        assert (np.diff(found) >= 0.0).all()
        for root in found:
            assert abs(np.polyval(cubic[::-1], root)) <= 1e-14 * np.polyval(np.abs(cubic[::-1]), max(abs(root), 1.0))
        slope = np.polyder(cubic[::-1])
        for root in exact:
            # Of nearly double roots rounding cannot tell whether there are any.
            if abs(np.polyval(slope, root)) > 1e-3 * np.polyval(np.abs(slope), abs(root)):
                assert np.abs(found - root).min() <= 1e-9 * max(abs(root), 1e-6)


def test_roots_that_are_only_touched_count_twice():
    assert roots_of([1.0, -4.0, 4.0, 0.0], 1e-15) == pytest.approx([0.5, 0.5])
    assert roots_of([0.0, 0.0, 3.0, 0.0]) == pytest.approx([0.0, 0.0])
