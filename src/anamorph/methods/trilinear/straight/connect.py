"""In which order projected corners of a scene triangle are joined into outlines.

Source: Vallance 2005, sections 4.1 to 4.3. The plane of the parametric triangle cuts the plane of the scene triangle in
a line, which sweeps as t grows. Whenever it meets a corner of the scene triangle, the two edges at that corner are
toggled: they begin or cease to be crossed. A shape lasts as long as two edges are crossed, and its outline is the two
traces that the crossings leave.

Deviations: an edge is crossed where its two corners lie on different sides, so that a sweep begins and ends rightly
where the line crosses edges at infinite t (rays parallel to one plane). And every line of an outline knows the scene
edge that it follows, which the printed listing takes from its two ends: they may be the same corner.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

FIRST, LAST = -1, -2
"""In place of a corner: where an edge is crossed at t = -infinity, and at t = infinity."""


@dataclass(frozen=True)
class Outline:
    """One shape as indices.

    Parameters
    ----------
    vertices : list of (corner, which)
        A corner of the scene triangle, 0 to 2, and which of its projections; or `FIRST` or `LAST`, and an edge.
    edges : list of int
        The scene edge from each vertex to the next, named by the corner opposite; -1 from infinity to infinity.
    """

    vertices: list[tuple[int, int]]
    edges: list[int]


@dataclass(frozen=True)
class _Trace:
    """What one crossing leaves: vertices, and the edges it followed, the last of which it is on."""

    vertices: list[tuple[int, int]]
    edges: list[int]


def connect(vertices: list[tuple[int, int]], signs: np.ndarray) -> list[Outline]:
    """The outlines of projected corners, given as (corner, which) in ascending order of t.

    Parameters
    ----------
    vertices : list of (corner, which)
    signs : (3,) bool
        On which side of the parametric triangle's plane each corner lies at first.
    """
    outlines = []
    crossed = {edge for edge in range(3) if signs[(edge + 1) % 3] != signs[(edge + 2) % 3]}
    left, right = (_Trace([(FIRST, edge)], [edge]) for edge in crossed) if crossed else (_Trace([], []),) * 2
    for vertex in vertices:
        here = {0, 1, 2} - {vertex[0]}
        if not crossed:
            left, right = _Trace([vertex], [min(here)]), _Trace([], [max(here)])
        elif crossed == here:
            left.vertices.append(vertex)
            outlines.append(_outline(left, right))
        else:
            trace = left if left.edges[-1] in here else right
            trace.vertices.append(vertex)
            trace.edges.append(*(here - crossed))
        crossed = crossed ^ here
    if crossed:
        for trace in (left, right):
            trace.vertices.append((LAST, trace.edges[-1]))
        left.edges.append(-1)
        outlines.append(_outline(left, right))
    return outlines


def _outline(left: _Trace, right: _Trace) -> Outline:
    """Up along one trace and down along the other."""
    closing = [-1] if left.vertices[0][0] == FIRST else []
    return Outline(left.vertices + right.vertices[::-1], left.edges + right.edges[::-1] + closing)
