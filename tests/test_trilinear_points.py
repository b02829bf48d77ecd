"""Points projected into ray triangles, against exact arithmetic, with degenerate ray triangles drawn on purpose.

What "none is missed" means: the roots of the cubic of the very float64 numbers given are counted and enclosed in rational
arithmetic (Sturm). A root must be found if its ray's weights are at most 1e5; beyond, at about 1e6, no float64 t leads
to the point within 1e-9, and the root may be real but not valid. Found is found to 2e-5 in t, in lengths of t's unit,
which is what a triple root leaves of 1e-15; that the ray passes through the point is asserted to 1e-9 always. There may
be more roots than in truth only where the point moved by 1e-9 of the size has them.
"""

from __future__ import annotations

import os
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from anamorph.errors import AnamorphError
from anamorph.trilinear import project_points

KINDS = [
    "any", "parallel", "one plane", "together", "focus", "slit", "two alike", "thin", "far", "small", "crossing",
    "across",
]  # fmt: skip
EXAMPLES = int(os.environ.get("TRILINEAR_EXAMPLES", "120"))
NEARLY = [0.0, 1e-16, 1e-14, 1e-13, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2]


def ray_triangle(kind, nearly, random):
    """Three rays of a kind, missing it by about `nearly`."""
    p, n, other = random.uniform(-1, 1, (3, 3, 3))
    if kind == "parallel":
        n = random.uniform(0.5, 2, (3, 1)) ** random.integers(0, 2) * n[0] + nearly * other
    elif kind == "one plane":
        n[2] = 0.3 * n[0] - 0.8 * n[1]
        n += nearly * other
    elif kind == "together":
        p = p[0] + nearly * other
    elif kind == "focus":
        p = p[0] - random.choice([-3.0, 0.7, 40.0]) * n + nearly * other
    elif kind == "slit":
        line, t = np.outer(random.uniform(-1, 1, 3), p[0]), random.choice([-2.0, 0.0, 0.5, 9.0])
        p = p[1] + line - t * n + nearly * other
    elif kind == "two alike":
        p[1], n[1] = p[0] + nearly * other[0], n[0] + nearly * other[1]
    elif kind == "thin":
        p[2] = 0.5 * (p[0] + p[1]) + nearly * other[0]
    elif kind == "far":
        p = 0.01 * p + 1000.0
    elif kind == "small":
        p, n = 1e-5 * p, n[0] + 1e-5 * n
    elif kind == "crossing":
        n = p[[1, 2, 0]] - p + nearly * other
    elif kind == "across":
        n = np.cross(p - p.mean(axis=0), other[0]) + nearly * other
    return p, n


def points_for(p, n, nearly, random):
    """Points on rays, on caustics (double roots), near them, at the origins, and anywhere; (N, 3)."""
    found = list(p.mean(axis=0) + random.uniform(-3, 3, (2, 3)))
    for _ in range(3):
        w = random.dirichlet([1, 1, 1]) if random.random() < 0.7 else np.array([-0.7, 0.4, 1.3])
        found.append(w @ p + random.choice([0.0, 0.3, 2.0, 50.0]) * (w @ n))
        # Along a ray, the caustic is where the parametric triangle holds the ray's own direction.
        values = [np.dot(np.cross(*((p + t * n)[1:] - (p + t * n)[0])), w @ n) for t in (-1.0, 0.0, 1.0)]
        square, slope = 0.5 * (values[0] + values[2]) - values[1], 0.5 * (values[2] - values[0])
        for t in np.roots([square, slope, values[1]]) if square else []:
            if abs(t.imag) == 0.0 and abs(t) < 1e4:
                found.append(w @ p + t.real * (w @ n) + random.choice([0.0, nearly]) * random.uniform(-1, 1, 3))
    found.append(p[0])
    return np.array(found)


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
    return sum(a != b for a, b in zip(signs, signs[1:], strict=False))


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


def aspect(p, n, t):
    """Twice the area of the parametric triangle over the square of its longest side."""
    a, b, c = p + t * n
    longest = max(np.linalg.norm(side) for side in (b - a, c - b, a - c))
    return np.linalg.norm(np.cross(b - a, c - a)) / max(longest**2, 1e-300)


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
        worst = max(worst, np.linalg.norm(off) / max(size_of(p, points[k]), 1e-300))
    return worst


@settings(max_examples=EXAMPLES, deadline=None, phases=(Phase.explicit, Phase.generate))
@given(st.sampled_from(KINDS), st.sampled_from(NEARLY), st.integers(0, 2**32 - 1))
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
            if reach <= 1e5 and aspect(p, n * unit, float(root)) >= 1e-5:
                there = [one_root(cubic, pe, ne, size_of(p, s), root, float(t)) for t in found]
                assert any(there), (
                    k,
                    float(root),
                    result.t[k] / unit,
                    [*map(float, weights)],
                    result.real[k],
                    result.valid[k],
                )
