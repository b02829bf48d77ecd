"""Ray triangles of every kind, degenerate ones on purpose, points in them, and the seven examples of the thesis."""

from __future__ import annotations

import csv
from collections import defaultdict
from pathlib import Path

import numpy as np

from anamorph.bench.thesis import printed

KINDS = [
    "any", "parallel", "one plane", "together", "focus", "slit", "two alike", "thin", "far", "small", "crossing",
    "across",
]  # fmt: skip

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
    """Points on rays, on caustics (double roots), near them, at the origins, and anywhere; (10, 3).

    Each processor draws the same: nothing here is a matter of the last digit, and sums are taken in one order.
    """
    found = list(p.mean(axis=0) + random.uniform(-3, 3, (2, 3)))
    for _ in range(2):
        share = random.uniform(0.02, 1.0, 3)
        w = share / share.sum() if random.random() < 0.7 else np.array([-0.7, 0.4, 1.3])
        origin, along = ((w[:, None] * vectors).sum(axis=0) for vectors in (p, n))
        found.append(origin + random.choice([0.0, 0.3, 2.0, 50.0]) * along)
        # Along a ray, the caustic is where the parametric triangle holds the ray's own direction.
        at = [p + t * n for t in (-1.0, 0.0, 1.0)]
        values = [(np.cross(q[1] - q[0], q[2] - q[0]) * along).sum() for q in at]
        square, slope = 0.5 * (values[0] + values[2]) - values[1], 0.5 * (values[2] - values[0])
        aside = random.choice([0.0, nearly], 2)[:, None] * random.uniform(-1, 1, (2, 3))
        for t, off in zip(quadratic(square, slope, values[1]), aside, strict=True):
            found.append(origin + t * along + off)
    found.append(p[0])
    return np.array(found)


def quadratic(square, slope, constant):
    """The roots of square t^2 + slope t + constant up to 1e4, or where it is nearest to having them."""
    larger = -0.5 * (slope + np.copysign(np.sqrt(max(slope**2 - 4.0 * square * constant, 0.0)), slope))
    ratios = ((larger, square), (constant, larger))
    return [np.clip(over / under, -1e4, 1e4) if under else 0.0 for over, under in ratios]


WITHIN = 1e-3 / 800
PLACED = 1e-4
SMALLEST = 1e-6
LOST = 2.0**-43
"""Of a coordinate, by a few dozen sums and products of two floats."""


def well_placed(p, n, result):
    """Which roots (K, N, 3) are well placed in ray triangles (K, 3, 3), and how near two floats tell their u and v."""
    u, v, t = (array[..., None] for array in (result.u, result.v, result.t))
    p, n = p[:, None, None], n[:, None, None]
    a, b, c = (p[..., k, :] + t * n[..., k, :] for k in range(3))
    along = (1 - u - v) * n[..., 0, :] + u * n[..., 1, :] + v * n[..., 2, :]
    longest = np.max([np.linalg.norm(side, axis=-1) for side in (b - a, c - b, a - c)], axis=0)
    derivative = np.abs(np.sum(along * np.cross(b - a, c - a), axis=-1))
    around = np.abs(p - p.mean(axis=-2, keepdims=True)).max(axis=(-1, -2))
    # Two floats hold 48 bits of a difference from the middle of all.
    full = np.abs(p - p.mean(axis=(0, 1, 2, 3))).max() + np.abs(result.t) * np.abs(n).max(axis=(-1, -2))
    short = np.abs(result.t) * np.linalg.norm(n, axis=-1).max(axis=-1) <= 1e5 * np.maximum(around, 1e-3)
    placed = (derivative >= PLACED * np.linalg.norm(along, axis=-1) * longest**2) & (longest >= SMALLEST * full)
    with np.errstate(divide="ignore", invalid="ignore"):
        told = LOST * full * longest * np.linalg.norm(along, axis=-1) / derivative
    return placed & short & (longest > 0.0), np.maximum(told, WITHIN)


EXAMPLES = Path(printed.__file__).parent / "assets" / "c-configurations.csv"
"""Vallance 2005, tables C.1 and C.2: scene and view triangles of figures 4.1 to 4.7, by their printed labels."""

# The row printed 9 holds the numbers of the (2, 3) example: its cubics have five real roots.
EXACT = {"2,2,2,3": [2, 2, 2, 3], "3,3,3": [3, 3, 3], "4,2,3": [2, 3, 4], "2,7": [2, 7], "9": [2, 3]}

# These two come out otherwise for the printed numbers, and as labelled for some that round to them.
ROUNDED = {"4,5": ([3, 4], [4, 5]), "6,3": ([3, 3, 3], [3, 6])}


def examples():
    rows = defaultdict(list)
    with EXAMPLES.open() as file:
        for row in csv.DictReader(file):
            numbers = [value for key, value in row.items() if key not in ("printed_label", "vertex")]
            rows[row["printed_label"]].append(numbers)
    return rows


def scene(seed, kind="any"):
    random = np.random.default_rng(seed)
    p, n, corners = random.normal(size=(3, 3, 3))
    if kind == "narrow":
        n = [0.0, 0.0, 1.0] + 0.4 * n
    if kind == "one plane":
        n[2] = n[0] - 0.4 * n[1]
    if kind == "pinhole":
        p = p[0] + 0.0 * p
    if kind == "edge on":
        corners = p + random.choice([0.0, 1.0, 3.0]) * n
    if kind == "thin":
        corners[2] = 0.5 * (corners[0] + corners[1])
    return p, n, corners, random
