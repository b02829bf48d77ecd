"""The thesis's examples of one scene triangle in one ray triangle: from table C, and one that it does not print."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from anamorph.bench.thesis.printed import configurations
from anamorph.methods.trilinear.straight import Shape, project_triangle
from anamorph.raytriangle import project_points

SEED = 3
DRAWS = 6000
"""Random triangles among which the (9) example is looked for."""
MARGIN = 0.06
"""Around the vertices of the (9) example, as a share of the ray triangle."""

FIGURES = {
    "4.1": "2,2,2,3", "4.2": "3,3,3", "4.3": "4,2,3", "4.4": "4,5", "4.5": "6,3", "4.6": "2,7", "4.7": "9",
}  # fmt: skip
"""The configuration of each figure."""
MISLABELLED = "2,3"
"""Table C prints its triangles as those of (9)."""


@dataclass(frozen=True, eq=False)
class Example:
    """A scene triangle and the ray triangle that sees it: a row (3,) for each corner, and each ray."""

    corners: np.ndarray
    origins: np.ndarray
    directions: np.ndarray

    def shapes(self, nearest: float = -np.inf) -> tuple[Shape, ...]:
        """The projected triangle."""
        return project_triangle(self.origins, self.directions, self.corners, nearest)


@cache
def example(label: str) -> Example:
    """The example of a configuration, named by the numbers of vertices of its shapes."""
    if label == "9":
        return _nine()
    numbers = configurations()[label]
    wanted = sorted(int(count) for count in label.split(","))
    # The printed digits are those of what was drawn, up to rounding: scene numbers have three, view numbers two places.
    half = np.full(numbers.shape, 0.005)
    half[:, :3] = 0.5 * 10.0 ** (np.floor(np.log10(np.abs(numbers[:, :3]))) - 2.0)
    random = np.random.default_rng(SEED)
    tried = numbers
    while True:
        found = Example(tried[:, :3], tried[:, 3:6], tried[:, 6:9])
        shapes = found.shapes()
        if sorted(len(shape) for shape in shapes) == wanted and _ahead(label, shapes):
            return found
        tried = numbers + half * random.uniform(-1.0, 1.0, numbers.shape)


def _ahead(label: str, shapes: tuple[Shape, ...]) -> bool:
    """Whether no vertex lies behind the origins, from where it would cut a shape; one of (2,3)'s always does."""
    return label == MISLABELLED or min(shape.t.min() for shape in shapes) > 0.0


def _nine() -> Example:
    """Of random triangles with one shape of nine vertices, the one whose vertices are farthest apart.

    The ray triangle is another part of the same rays, begun earlier: so large that it holds all nine vertices.
    """
    random = np.random.default_rng(SEED)
    origins, corners = random.uniform(-1.0, 1.0, (2, DRAWS, 3, 3))
    directions = random.normal(size=(DRAWS, 3, 3))
    directions /= np.linalg.norm(directions, axis=2, keepdims=True)
    real = project_points(origins, directions, corners).real.all(axis=(1, 2))
    best, widest = Example(corners[0], origins[0], directions[0]), 0.0
    for number in np.flatnonzero(real):
        drawn = Example(corners[number], origins[number], directions[number])
        shapes = drawn.shapes()
        if len(shapes) > 1:
            continue
        moved = _holding(drawn, shapes[0])
        places = np.stack([moved.shapes()[0].u, moved.shapes()[0].v], axis=1)
        apart = np.linalg.norm(places[:, None] - places, axis=2) + 9.0 * np.eye(len(places))
        if apart.min() > widest:
            best, widest = moved, float(apart.min())
    return best


def _holding(drawn: Example, shape: Shape) -> Example:
    """The same rays, with the ray triangle and its origins moved so that the shape lies in it and before them."""
    least = np.array([shape.u.min(), shape.v.min()])
    side = (shape.u + shape.v).max() - least.sum()
    least, side = least - MARGIN * side, (1.0 + 3.0 * MARGIN) * side
    u, v = (least[:, None] + side * np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])).reshape(2, 3)
    weights = np.stack([1.0 - u - v, u, v], axis=1)
    directions = weights @ drawn.directions
    start = shape.t.min() - 0.05 * np.ptp(shape.t)
    return Example(drawn.corners, weights @ drawn.origins + start * directions, directions)
