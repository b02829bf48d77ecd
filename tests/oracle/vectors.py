"""Vectors of three numbers, and how functions of the tracer are compiled."""

from __future__ import annotations

import math
from collections.abc import Callable

import numba

Vector = tuple[float, float, float]

compiled: Callable = numba.njit(cache=True, nogil=True, error_model="numpy")


@compiled
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@compiled
def along(a, length, b):
    """a + length b."""
    return a[0] + length * b[0], a[1] + length * b[1], a[2] + length * b[2]


@compiled
def scaled(length, a):
    return length * a[0], length * a[1], length * a[2]


@compiled
def unit(a):
    return scaled(1.0 / math.sqrt(dot(a, a)), a)


@compiled
def vector(values, start):
    return values[start], values[start + 1], values[start + 2]


@compiled
def into(axes, a):
    """Coordinates of `a` along the rows of `axes`, nine numbers."""
    return dot(vector(axes, 0), a), dot(vector(axes, 3), a), dot(vector(axes, 6), a)


@compiled
def out_of(axes, a):
    return along(along(scaled(a[0], vector(axes, 0)), a[1], vector(axes, 3)), a[2], vector(axes, 6))
