"""The thesis's figures of single triangles, with curved and with straight edges: Figures 4.1 to 4.10 and 5.1."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from figures.comparing import EXACT, STRAIGHT, Drawn, compared, flip, pixels, table_row
from figures.configurations import FIGURES, MISLABELLED, Example, example
from figures.panels import Panel, lined, shrunk
from PIL import Image, ImageDraw

import anamorph as an
from anamorph.base.output import to_pixels
from anamorph.cameras import from_grid
from anamorph.methods.trilinear.straight import project_triangle
from anamorph.raymesh import RayMesh

THIRD = (313, 271)
FINE = 2
"""Pixels drawn for each that is shown, in either direction."""
BORDER = 0.12
"""Around what is seen, as a share of it."""
WHOLE = 0.8
"""What fills this share of the ray triangle is shown with all of that."""
PAPER = (0.80, 0.80, 0.78)
LIGHT = an.AmbientLight((1.0, 1.0, 1.0), (1.0, 1.0, 1.0))
CORNERS = ((235, 40, 30), (30, 170, 50), (40, 70, 240))
"""Of the circles around projections of red, green and blue corners."""
DARK = (30, 34, 40)
PARTS = 5
"""Of each side in Figure 4.9, which makes 25 triangles; and levels of t in Figure 4.10."""
CROSSING = np.array([[-2.2, -0.3, -2.5], [1.6, 1.9, -3.0], [1.9, -1.2, -2.0]])
TWIST = 0.8
BORDER_SEED = 5
"""Of the scene triangle and the directions in Figure 5.1."""
TRIANGLE = np.array([[0.0, np.sqrt(0.75)], [1.0, np.sqrt(0.75)], [0.5, 0.0]])
"""A ray triangle in the image."""


def triangle_scene(name: str, corners: np.ndarray, colors: np.ndarray) -> an.Scene:
    """One triangle with coloured corners and no shading, on paper."""
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    mesh = an.Mesh(
        name,
        corners.astype(np.float32),
        np.array([[0, 1, 2]], np.int32),
        np.tile(normal / np.linalg.norm(normal), (3, 1)).astype(np.float32),
        an.Diffuse((1.0, 1.0, 1.0)),
        colors=colors.astype(np.float32),
    )
    return an.Scene(name, (mesh,), an.Camera((0.0, 0.0, 5.0), (0.0, 0.0, 0.0)), (LIGHT,), an.Sky(PAPER, PAPER, PAPER))


@dataclass(frozen=True, eq=False)
class Single:
    """An example in an image.

    Parameters
    ----------
    example : Example
    scene : Scene
    places : (3, 2) float64
        Where the ray triangle's corners are, pixels; not all of it need be in the image.
    size : (width, height)
    """

    example: Example
    scene: an.Scene
    places: np.ndarray
    size: tuple[int, int]

    @property
    def rays(self) -> RayMesh:
        """The ray triangle as a camera."""
        image = np.column_stack([self.places, np.ones(3)])
        faces, status = np.array([[0, 1, 2]], np.int32), np.zeros(3, np.uint8)
        return RayMesh(image, self.example.origins, self.example.directions, faces, status)

    def draw(self, method: str) -> an.Frame:
        """All buffers."""
        return an.render(self.scene, camera=self.rays, method=method, size=self.size, seen=True)

    def at(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Where rays are in the image as it is shown, (N, 2) pixels."""
        return np.stack([1.0 - u - v, u, v], axis=-1) @ self.places / FINE


def single(label: str) -> Single:
    """An example in an image of `FINE` times the size at which it is shown, close enough to be looked at."""
    shown = example(label)
    scene = triangle_scene(f"({label})", shown.corners, np.eye(3))
    size = (THIRD[0] * FINE, THIRD[1] * FINE)
    found = Single(shown, scene, TRIANGLE * size[0], size)
    items = found.draw("raytrace").object_id
    assert items is not None
    y, x = np.nonzero(items)
    ahead = np.concatenate([found.at(shape.u, shape.v)[shape.t > 0.0] for shape in shown.shapes()]) * FINE
    seen = np.concatenate([np.column_stack([x, y]), ahead[inside(found, ahead)]])
    low, high = seen.min(axis=0), seen.max(axis=0)
    scale = min(np.array(size) / (high - low) / (1.0 + 2.0 * BORDER))
    if scale * WHOLE < 1.0:
        return found
    return Single(shown, scene, (found.places - (low + high) / 2.0) * scale + np.array(size) / 2.0, size)


def inside(shown: Single, places: np.ndarray) -> np.ndarray:
    """Which places of the drawn image are in the ray triangle, (N,) bool."""
    rows = np.column_stack([shown.places, np.ones(3)])
    weights = np.column_stack([places, np.ones(len(places))]) @ np.linalg.inv(rows)
    return np.all(weights >= 0.0, axis=1)


def circled(image: np.ndarray, shown: Single) -> np.ndarray:
    """Drawn pixels as they are shown: with the ray triangle's sides, and a circle around each projected corner."""
    sides = np.stack([shown.places, np.roll(shown.places, -1, axis=0)], axis=1)
    page = Image.fromarray(lined(image, sides, (150, 150, 150), FINE, 1))
    draw = ImageDraw.Draw(page)
    for shape in shown.example.shapes():
        for (x, y), t, weights in zip(shown.at(shape.u, shape.v) * FINE, shape.t, shape.weights, strict=True):
            if t > 0.0:
                for radius, width, color in ((10, 6, DARK), (9, 4, CORNERS[int(weights.argmax())])):
                    draw.ellipse((x - radius, y - radius, x + radius, y + radius), outline=color, width=width)
    return shrunk(np.asarray(page), THIRD)


def with_lines(image: np.ndarray, shown: Single) -> np.ndarray:
    """Pixels with a line for each shape of two vertices, which straight edges draw as nothing."""
    for shape in shown.example.shapes():
        if len(shape) == 2 and (shape.t > 0.0).all():
            steps = np.linspace(0.0, 1.0, 25)[:, None]
            ends = shown.at(shape.u, shape.v) * FINE
            way = ends[0] + steps * (ends[1] - ends[0])
            blend = (shape.weights[0] + (steps[:-1] + 0.02) * (shape.weights[1] - shape.weights[0])).clip(0.0, 1.0)
            for first, last, color in zip(way[:-1], way[1:], to_pixels(blend[None])[0], strict=True):
                red, green, blue = (int(part) for part in color)
                image = lined(image, np.array([[first, last]]), (red, green, blue), FINE, 1)
    return image


def configuration(figure: str) -> Drawn:
    """Figures 4.1 to 4.7: one scene triangle, by tracing, with curved and with straight edges."""
    labels = [FIGURES[figure], *([MISLABELLED] if figure == "4.7" else [])]
    rows, table = [], []
    for label in labels:
        shown = single(label)
        found = compared(shown.scene, shown.rays, shown.size)
        straight = with_lines(pixels(found.straight), shown)
        rows.append(
            [
                Panel(circled(pixels(found.traced), shown), f"({label}): a ray for every pixel"),
                Panel(circled(pixels(found.exact), shown), "projected, exact edges"),
                Panel(circled(straight, shown), f"straight edges, FLIP {found.straight_flip:.3f}"),
            ]
        )
        table.append(table_row(f"{figure}, ({label})", 1, found))
    return rows, table


def shape_lines(shown: Single, parts: int) -> np.ndarray:
    """The straight edges, (N, 2, 2), of all shapes of a scene triangle that is divided along each side."""
    lines = [np.zeros((0, 2, 2))]
    for corners in divided(shown.example.corners, parts):
        for shape in project_triangle(shown.example.origins, shown.example.directions, corners, 0.0):
            places = shown.at(shape.u, shape.v)
            lines.append(np.stack([places, np.roll(places, -1, axis=0)], axis=1))
    return np.concatenate(lines)


def divided(corners: np.ndarray, parts: int) -> np.ndarray:
    """The parts^2 triangles (N, 3, 3) of a triangle (3, 3)."""
    found = []
    for i in range(parts):
        for j in range(parts - i):
            found.append([(i, j), (i + 1, j), (i, j + 1)])
            if i + j < parts - 1:
                found.append([(i + 1, j), (i + 1, j + 1), (i, j + 1)])
    weights = np.array(found, float) / parts
    return corners[0] + weights @ (corners[1:] - corners[0])


def level_lines(shown: Single, levels: int) -> np.ndarray:
    """The lines, (N, 2, 2), at which shapes are cut at so many levels of t between their first and last vertex."""
    lines = [np.zeros((0, 2, 2))]
    for whole in shown.example.shapes():
        for t in np.linspace(max(whole.t.min(), 0.0), whole.t.max(), levels + 2)[1:-1]:
            for shape in shown.example.shapes(t):
                cut = shape.t == t
                lines += [shown.at(shape.u[cut], shape.v[cut])[None]] if cut.sum() == 2 else []
    return np.concatenate(lines)


def straight_error() -> Drawn:
    """Figure 4.8: where straight and curved edges differ."""
    shown = single("4,5")
    exact, straight = shown.draw(EXACT), shown.draw(STRAIGHT)
    assert exact.object_id is not None and straight.object_id is not None
    faint = np.round(0.35 * pixels(exact) + 165.0).astype(np.uint8)
    missing, extra = (exact.object_id > straight.object_id), (exact.object_id < straight.object_id)
    faint[missing], faint[extra] = (40, 70, 200), (215, 40, 30)
    gone, more = (100.0 * wrong.sum() / (exact.object_id > 0).sum() for wrong in (missing, extra))
    return [
        [
            Panel(circled(pixels(exact), shown), "exact edges"),
            Panel(circled(pixels(straight), shown), "straight edges"),
            Panel(circled(faint, shown), f"red: too much, {more:.0f}% of the shapes\nblue: missing, {gone:.1f}%"),
        ]
    ], []


def finer(figure: str) -> Drawn:
    """Figures 4.9 and 4.10: the same with 25 triangles, and with 5 more levels of t."""
    shown = single("4,5")
    way, lines = ("tessellate", shape_lines) if figure == "4.9" else ("slices", level_lines)
    reference = shown.draw("raytrace")
    frames = [shown.draw(f"{STRAIGHT},{way}={number}") for number in (PARTS, 4 * PARTS)]
    flips = [flip(reference, frame) for frame in (shown.draw(STRAIGHT), *frames)]
    drawn = circled(pixels(frames[0]), shown)
    return [
        [
            Panel(
                lined(drawn, lines(shown, PARTS), DARK), f"{way}={PARTS}: FLIP {flips[1]:.3f}, without {flips[0]:.3f}"
            ),
            Panel(circled(pixels(frames[1]), shown), f"{way}={4 * PARTS}: FLIP {flips[2]:.3f}"),
            Panel(circled(pixels(reference), shown), "a ray for every pixel"),
        ]
    ], []


def discontinuity() -> Drawn:
    """Figure 5.1: one scene triangle over the border of two ray triangles, whose pixels are tinted red and blue."""
    size = (THIRD[0] * FINE, THIRD[0] * FINE)
    random = np.random.default_rng(BORDER_SEED)
    origins = np.array([[[-1.0, 1.0, 0.0], [1.0, 1.0, 0.0]], [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0]]])
    directions = np.array([0.0, 0.0, -1.0]) + random.uniform(-TWIST, TWIST, (2, 2, 3))
    rays = from_grid(origins, directions, size)
    scene = triangle_scene("over a border", CROSSING, np.ones((3, 3)))
    y, x = np.mgrid[: size[1], : size[0]]
    tint = np.where((x > y)[..., None], (70, 95, 215), (215, 60, 50))
    panels = []
    for method, words in (
        (f"{STRAIGHT},clip=screen", "clipped on the screen"),
        (f"{STRAIGHT},clip=scene", "clipped in the scene"),
        (EXACT, "exact edges"),
    ):
        frame = an.render(scene, camera=rays, method=method, size=size, seen=True)
        assert frame.object_id is not None
        image = np.where((frame.object_id > 0)[..., None], tint, pixels(frame)).astype(np.uint8)
        image = lined(image, np.array([[(0.0, 0.0), size]]), (110, 110, 110), FINE, 1)
        panels.append(Panel(shrunk(image, (THIRD[0], THIRD[0])), words))
    return [panels], [table_row("5.1", 2, compared(scene, rays, size))]
