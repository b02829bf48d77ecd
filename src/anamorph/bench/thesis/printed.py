"""The figures as the thesis prints them: times in ms on an 800 MHz Athlon with a GeForce 2 MX."""

from __future__ import annotations

import csv
from functools import cache
from importlib.resources import files

import numpy as np

from anamorph.methods import Specification

RAY_TRACING, TRILINEAR, CLIPPED = "d1-ray-tracing", "d2-trilinear", "d3-trilinear-clipped"
RAY_TRACING_CONFIGURATIONS, TRILINEAR_CONFIGURATIONS = "d4-ray-tracing-configurations", "d5-trilinear-configurations"
TESSELLATION = {"tessellate": "d6-scene-tessellation", "slices": "d7-parametric-slicing"}
"""By the option that does it."""

COMPETITOR = "raytrace"
"""Embree on all the cores, and the same shading."""

# Table C prints the triangles of the (2, 3) example as those of 9, and none of 9's: its cubics have five real roots.
CALLED = {"9": "2,3"}


@cache
def rows(name: str) -> tuple[dict[str, str], ...]:
    """The rows of `assets/NAME.csv`."""
    text = files("anamorph.bench.thesis").joinpath("assets", f"{name}.csv").read_text()
    return tuple(csv.DictReader(text.splitlines()))


@cache
def _by_key(name: str, keys: tuple[str, ...], value: str) -> dict[tuple[str, ...], float]:
    return {tuple(row[key] for key in keys): float(row[value]) for row in rows(name)}


def printed(name: str, value: str = "ms", **key: object) -> float | None:
    """The printed figure of the row with these entries; None where none is printed."""
    table = _by_key(name, tuple(key), value)
    return table.get(tuple(str(entry) for entry in key.values()))


def random_table(method: Specification) -> str:
    """The table whose counterpart a method's times over random triangles are."""
    options = method.options
    if method.method.name == COMPETITOR:
        return RAY_TRACING
    clipped = (getattr(options, "edges", ""), getattr(options, "clip", "")) == ("straight", "scene")
    return CLIPPED if clipped else TRILINEAR


def configurations() -> dict[str, np.ndarray]:
    """The examples of tables C.1 and C.2: by configuration, (3, 9): scene corner, view corner, view direction.

    The row printed 9 is under its right name, 2,3.
    """
    numbers: dict[str, list[list[float]]] = {}
    for row in rows("c-configurations"):
        label, _, *texts = row.values()
        numbers.setdefault(CALLED.get(label, label), []).append([float(text) for text in texts])
    return {label: np.array(lines) for label, lines in numbers.items()}
