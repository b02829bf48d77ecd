"""Each pixel's ray through a ray mesh that is the camera: its triangles rasterised at the pixels' centres. Compiled."""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import compiled, cores, over_all_cores
from anamorph.raymesh import RayMesh

GRAIN = 16384
"""Fewer pixels than these are not worth another core."""

SHORTEST = 1e-12
"""Interpolated directions shorter than this share of their triangle's longest are rounding, and no rays."""

THIN = 1e-6
"""Pixels: the weights of a triangle less high than this are all rounding."""


def pixel_rays(
    mesh: RayMesh,
    size: tuple[int, int],
    shift: tuple[float, float] = (0.0, 0.0),
    reused: np.ndarray | None = None,
) -> np.ndarray:
    """Each pixel's ray, interpolated in the ray triangle that covers its centre.

    A centre on the border of a triangle is covered, so that between triangles that share an edge none is left out; of
    several triangles that cover it the first is taken, and one thinner than `THIN` only where there is no other.

    Parameters
    ----------
    mesh : RayMesh
    size : (width, height)
        Of the image, pixels.
    shift : (right, down)
        Moves the rays from the pixels' centres, in pixels.
    reused : (2, width height, 3) float64, optional
        To be filled again, instead of a new array.

    Returns
    -------
    origins and directions : (2, width height, 3) float64
        Row by row. Weights are linear in the mesh's homogeneous image and sum to 1; directions are interpolated as
        they are, and not normalised. Both are zero where there is no ray.
    """
    width, height = size
    image, vertex_origins, vertex_directions = (
        np.asarray(each, float) for each in (mesh.image, mesh.origins, mesh.directions)
    )
    # Before the eye, vertices are where their places say, so that those at one place are so for every pixel.
    divisor = np.where(image[:, 2] > 0.0, image[:, 2], 1.0)
    image = image / divisor[:, None]
    faces, thick = _thick_first(image, np.asarray(mesh.faces, np.int64))
    boxes = _boxes(image[faces], size, shift)
    shortest = SHORTEST**2 * np.einsum("fki,fki->fk", vertex_directions[faces], vertex_directions[faces]).max(axis=1)
    rays = np.empty((2, width * height, 3)) if reused is None else reused

    def work(first: int, stop: int) -> None:
        _interpolate(
            faces,
            thick,
            boxes,
            shortest,
            image,
            divisor,
            vertex_origins,
            vertex_directions,
            *shift,
            width,
            first,
            stop,
            *rays,
        )

    over_all_cores(work, height, max(GRAIN // width, -(-height // (4 * cores())), 1))
    return rays


def _thick_first(image: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, int]:
    """The faces (F, 3) in their order, thin ones last and each with its longest edge first; how many are not thin."""
    places = image[faces, :2]
    edges = np.roll(places, -1, axis=1) - places
    lengths = np.linalg.norm(edges, axis=2)
    area = np.abs(edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0])
    longest = lengths.argmax(axis=1)
    thin = (area < THIN * lengths.max(axis=1)) & (image[faces, 2] > 0.0).all(axis=1)
    turned = np.take_along_axis(faces, (longest[:, None] + np.arange(3)) % 3, axis=1)
    return np.concatenate([faces[~thin], turned[thin]]), int((~thin).sum())


def _boxes(corners: np.ndarray, size: tuple[int, int], shift: tuple[float, float]) -> np.ndarray:
    """Columns and rows (x0, y0, x1, y1) around the centres that triangles (F, 3, 3) may cover, (F, 4), ends left out.

    A triangle that reaches behind the eye may cover the whole image.
    """
    before = corners[..., 2] > 0.0
    places = corners[..., :2] / np.where(before, corners[..., 2], 1.0)[..., None] - 0.5 - np.asarray(shift)
    low = np.clip(np.floor(places.min(axis=1)), 0, size)
    high = np.clip(np.ceil(places.max(axis=1)) + 1.0, 0, size)
    low[~before.all(axis=1)], high[~before.all(axis=1)] = 0, size
    high[~before.any(axis=1)] = 0
    return np.concatenate([low, high], axis=1).astype(np.int64)


@compiled
def _interpolate(
    faces: np.ndarray,
    thick: int,
    boxes: np.ndarray,
    shortest: np.ndarray,
    image: np.ndarray,
    divisor: np.ndarray,
    vertex_origins: np.ndarray,
    vertex_directions: np.ndarray,
    right: float,
    down: float,
    width: int,
    first_row: int,
    stop_row: int,
    origins: np.ndarray,
    directions: np.ndarray,
) -> None:
    """Fill the rays of some rows, the last triangle first, so that the first one stays."""
    origins[first_row * width : stop_row * width] = 0.0
    directions[first_row * width : stop_row * width] = 0.0
    for face in range(len(faces) - 1, -1, -1):
        x0, x1 = boxes[face, 0], boxes[face, 2]
        y0, y1 = max(boxes[face, 1], first_row), min(boxes[face, 3], stop_row)
        a, b, c = faces[face, 0], faces[face, 1], faces[face, 2]
        w_a, w_b, w_c = image[a, 2], image[b, 2], image[c, 2]
        for row in range(y0, y1):
            y = row + 0.5 + down
            y_a, y_b, y_c = image[a, 1] - y * w_a, image[b, 1] - y * w_b, image[c, 1] - y * w_c
            for column in range(x0, x1):
                x = column + 0.5 + right
                # Weights W times the determinant of the corners. As edge functions of the corners seen from the
                # centre they are rounded never to the wrong sign, and opposite on both sides of an edge: no gaps.
                x_a, x_b, x_c = image[a, 0] - x * w_a, image[b, 0] - x * w_b, image[c, 0] - x * w_c
                e_a, e_b, e_c = x_b * y_c - y_b * x_c, x_c * y_a - y_c * x_a, x_a * y_b - y_a * x_b
                determinant = e_a * w_a + e_b * w_b + e_c * w_c
                if determinant < 0.0:
                    e_a, e_b, e_c = -e_a, -e_b, -e_c
                if determinant == 0.0 or min(e_a, e_b, e_c) < 0.0:
                    continue
                if face >= thick:
                    # Where along the longest edge, if it is there at all: here signs are rounding.
                    x_ab, y_ab = x_b - x_a, y_b - y_a
                    square = x_ab * x_ab + y_ab * y_ab
                    e_b = min(max(-(x_a * x_ab + y_a * y_ab) / square, 0.0), 1.0) if square > 0.0 else 0.0
                    e_a, e_c = 1.0 - e_b, 0.0
                    if math.hypot(x_a + e_b * x_ab, y_a + e_b * y_ab) > 2.0 * THIN:
                        continue
                e_a, e_b, e_c = e_a / divisor[a], e_b / divisor[b], e_c / divisor[c]
                pixel, total, square = row * width + column, e_a + e_b + e_c, 0.0
                e_a, e_b, e_c = e_a / total, e_b / total, e_c / total
                for axis in range(3):
                    way = (
                        e_a * vertex_directions[a, axis]
                        + e_b * vertex_directions[b, axis]
                        + e_c * vertex_directions[c, axis]
                    )
                    directions[pixel, axis] = way
                    origins[pixel, axis] = (
                        e_a * vertex_origins[a, axis] + e_b * vertex_origins[b, axis] + e_c * vertex_origins[c, axis]
                    )
                    square += way * way
                if square <= shortest[face]:
                    for axis in range(3):
                        origins[pixel, axis] = directions[pixel, axis] = 0.0
