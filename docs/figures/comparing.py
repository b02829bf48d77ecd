"""Frames by projection beside frames by tracing, and what they differ by, as a row of the page's table."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from figures.panels import Panel

import anamorph as an
from anamorph.base.output import to_pixels
from anamorph.measure.colors import color_errors
from anamorph.measure.errors import Errors, counted, measure
from anamorph.raymesh import RayMesh

Drawn = tuple[list[list[Panel]], list[str]]
"""A figure's panels, and the rows that it adds to the table."""

EXACT = "trilinear"
STRAIGHT = "trilinear:edges=straight"
SAME_RAYS = "raytrace:truth=raymesh,bounces=1"
"""A ray for every pixel, but the ray mesh's own; through a ray mesh as a camera `raytrace` takes these anyway."""


@dataclass(frozen=True, eq=False)
class Compared:
    """Three frames of one ray mesh.

    Parameters
    ----------
    traced, exact, straight : Frame
    errors : Errors
        Of `exact`, against `traced`.
    straight_flip : float
        Of `straight`, against `traced`.
    original : Errors, optional
        Of `exact`, against rays that are bent at every pixel.
    """

    traced: an.Frame
    exact: an.Frame
    straight: an.Frame
    errors: Errors
    straight_flip: float
    original: Errors | None


def compared(
    scene: an.Scene, camera: RayMesh | None, size: tuple[int, int], original: an.Frame | None = None
) -> Compared:
    """Draw a scene through a ray mesh, or its mirrors, by a ray for each pixel, and by both kinds of edges."""
    traced, exact, straight = (
        an.render(scene, camera=camera, method=method, size=size, seen=True)
        for method in ("raytrace" if camera else SAME_RAYS, EXACT, STRAIGHT)
    )
    against = measure(original, exact) if original else None
    return Compared(traced, exact, straight, measure(traced, exact), flip(traced, straight), against)


def flip(reference: an.Frame, frame: an.Frame) -> float:
    """The mean over all pixels that have a ray."""
    found = color_errors(reference.color, frame.color, counted(reference)).flip
    assert found is not None
    return found


def pixels(frame: an.Frame) -> np.ndarray:
    """A frame as 8-bit pixels; white where there is no ray."""
    assert frame.status is not None
    outside = (frame.status == an.Status.OUTSIDE)[..., None] & frame.ray_mesh
    return np.where(outside, 255, to_pixels(frame.color)).astype(np.uint8)


def p95_of_things(reference: an.Frame, errors: Errors) -> float:
    """The 95th percentile of errors in pixels where a thing is seen, away from silhouettes.

    Not of the sky: through parallel rays it has one colour in many pixels, and its place in the image is no measure.
    """
    assert reference.object_id is not None
    things = errors.maps.specular & ~errors.maps.silhouette & (reference.object_id > 0)
    return float(np.percentile(errors.maps.pixels[things], 95.0))


def in_words(reference: an.Frame, errors: Errors) -> str:
    """Both figures of a frame against its reference."""
    return f"p95 {number(p95_of_things(reference, errors))} px, FLIP {number(errors.flip)}"


def number(value: float | None) -> str:
    """In two digits, or in whole ones; nothing where there is none."""
    if value is None or value == 0.0:
        return "" if value is None else "0"
    return "< 0.0001" if value < 1e-4 else f"{value:.2g}" if value < 99.5 else f"{value:.0f}"


def table_row(name: str, triangles: int, found: Compared) -> str:
    """A row of the page's table, of a figure with so many ray triangles."""
    height, width = found.exact.color.shape[:2]
    errors = found.errors
    cells = [
        name,
        f"{width} x {height}",
        str(triangles),
        number(p95_of_things(found.traced, errors)),
        number(errors.other_object_percent),
        number(errors.flip),
        number(found.straight_flip),
        number(found.original.flip if found.original else None),
    ]
    return "| " + " | ".join(cells) + " |"
