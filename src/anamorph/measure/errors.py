"""How wrong a frame is: its errors against the reference, as figures and pixel by pixel.

Only pixels that have a last ray in the reference, and look at a specular surface there or through a ray mesh, count.
Those within one pixel of a silhouette in the reference are counted apart, because there a shift of any size shows
another object.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.frame import Frame
from anamorph.measure.colors import ColorErrors, color_errors
from anamorph.measure.pixel_errors import NOTHING, pixel_errors


@dataclass(frozen=True)
class Statistics:
    """Of one error over the counted pixels; None where there are none."""

    median: float | None
    p95: float | None
    max: float | None


@dataclass(frozen=True, eq=False)
class ErrorMaps:
    """The errors of every pixel, zero for those that do not count.

    Parameters
    ----------
    angular : (H, W) float64
        Milliradians.
    pixels : (H, W) float64
    specular, silhouette, other_object : (H, W) bool
        Pixels that count; of these, those at a silhouette; of the rest, those that see another object, or nothing.
    """

    angular: np.ndarray
    pixels: np.ndarray
    specular: np.ndarray
    silhouette: np.ndarray
    other_object: np.ndarray


@dataclass(frozen=True)
class GeometryErrors:
    """The errors of what is seen, whatever its colours, over the pixels that count: see `counted`.

    Parameters
    ----------
    angular_mrad : Statistics
        Angle, where the reference's last ray begins, between that ray and what the frame sees; away from silhouettes,
        milliradians.
    pixels : Statistics
        How far one must move in the image for the reference to see the same; away from silhouettes.
    other_object_percent : float or None
        Share of the pixels away from silhouettes that see another object.
    silhouette_percent : float or None
        Share of the pixels that are at a silhouette.
    """

    angular_mrad: Statistics
    pixels: Statistics
    other_object_percent: float | None
    silhouette_percent: float | None


@dataclass(frozen=True, eq=False)
class Errors(ColorErrors, GeometryErrors):
    """What is wrong with a frame: what is seen, and how it looks, silhouettes included; and `maps` of the former."""

    maps: ErrorMaps


def counted(reference: Frame) -> np.ndarray:
    """The pixels of the reference, (H, W) bool, that have a last ray, from a specular surface or through a ray mesh."""
    bent = (_buffer("reference", reference, "specular") != 0) | reference.ray_mesh
    return bent & _any(_buffer("reference", reference, "ray_direction"))


def measure(reference: Frame, frame: Frame) -> Errors:
    """Errors of `frame` against `reference`, which must carry its last rays; both need their seen buffers."""
    maps = error_maps(reference, frame)
    colors = color_errors(_buffer("reference", reference, "color"), _buffer("frame", frame, "color"), maps.specular)
    return Errors(**vars(geometry_statistics(maps)), **vars(colors), maps=maps)


def error_maps(reference: Frame, frame: Frame) -> ErrorMaps:
    """What `measure` finds of each pixel, without its colours: some thirty times as fast."""
    if reference.color.shape != frame.color.shape:
        raise AnamorphError(
            f"reference {reference.color.shape} and frame {frame.color.shape} differ in size; draw both at one size"
        )
    surface, true_object = _buffer("reference", reference, "specular"), _buffer("reference", reference, "object_id")
    object_id, looks_at = _buffer("frame", frame, "object_id"), _buffer("frame", frame, "specular")
    position = _buffer("frame", frame, "position")
    specular = counted(reference)
    # Pixels that do not count border on those that do, as another surface does.
    through = np.where(specular, surface.astype(np.int64), NOTHING)
    silhouette = specular & silhouettes(true_object, through)
    misses = (looks_at == 0) & (surface != 0)
    # The sky, too, is seen in some direction.
    shows_nothing = (object_id == 0) & ~_any(position)
    other_object = specular & ~silhouette & ((object_id != true_object) | misses | shows_nothing)
    origin, direction = _buffer("reference", reference, "ray_origin"), _buffer("reference", reference, "ray_direction")
    angular, pixels = pixel_errors(origin, direction, through, position, object_id)
    return ErrorMaps(angular, pixels, specular, silhouette, other_object)


def geometry_statistics(maps: ErrorMaps) -> GeometryErrors:
    """Of all pixels that count, away from silhouettes and at them."""
    inside = maps.specular & ~maps.silhouette
    return GeometryErrors(
        angular_mrad=statistics(maps.angular[inside]),
        pixels=statistics(maps.pixels[inside]),
        other_object_percent=_percent(maps.other_object, inside),
        silhouette_percent=_percent(maps.silhouette, maps.specular),
    )


def silhouettes(*labels: np.ndarray) -> np.ndarray:
    """Pixels, (H, W) bool, with one of their eight neighbours different in any of the label images (H, W)."""
    found = np.zeros(labels[0].shape[:2], bool)
    before, after, every = slice(None, -1), slice(1, None), slice(None)
    for label in labels:
        for here, there in (
            ((every, before), (every, after)),
            ((before, every), (after, every)),
            ((before, before), (after, after)),
            ((before, after), (after, before)),
        ):
            differs = label[here] != label[there]
            found[here] |= differs
            found[there] |= differs
    return found


def _any(vectors: np.ndarray) -> np.ndarray:
    """Which of the vectors (H, W, 3) are not zero."""
    return (vectors[..., 0] != 0.0) | (vectors[..., 1] != 0.0) | (vectors[..., 2] != 0.0)


def statistics(values: np.ndarray) -> Statistics:
    """Of the values (N,)."""
    if not len(values):
        return Statistics(None, None, None)
    median, p95 = np.percentile(values, [50.0, 95.0])
    return Statistics(float(median), float(p95), float(values.max()))


def _percent(part: np.ndarray, whole: np.ndarray) -> float | None:
    return 100.0 * int(np.count_nonzero(part)) / int(np.count_nonzero(whole)) if whole.any() else None


def _buffer(name: str, frame: Frame, field: str) -> np.ndarray:
    """One buffer of a frame that must be there, and finite."""
    buffer = getattr(frame, field)
    if buffer is None:
        raise AnamorphError(f"{name}: has no '{field}' buffer; draw it with seen=True")
    if buffer.dtype.kind == "f" and not np.isfinite(buffer).all():
        raise AnamorphError(f"{name}: '{field}' holds values that are not finite; it cannot be measured")
    return buffer
