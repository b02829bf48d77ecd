"""How wrong a frame is: its errors against the truth, as figures and pixel by pixel.

Only pixels that look at a specular surface in the truth, and have a last ray there, count. Those within one pixel of a silhouette in the truth
are counted apart, because there a shift of any size shows another object.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.errors import AnamorphError
from anamorph.frame import Frame
from anamorph.measure.angles import angles_between, normalized, picture_distances, ray_footprints, seen_directions
from anamorph.measure.colors import color_errors


@dataclass(frozen=True)
class Statistics:
    """Of one error over the counted pixels; None where there are none."""

    median: float | None
    p95: float | None
    max: float | None


@dataclass(frozen=True, eq=False)
class ErrorMaps:
    """The errors of every pixel, zero where the truth looks at no specular surface.

    Parameters
    ----------
    angular : (H, W) float64
        Milliradians.
    pixels : (H, W) float64
    specular, silhouette, other_object : (H, W) bool
        Pixels that look at a specular surface; of these, those at a silhouette; of the rest, those that see
        another object.
    """

    angular: np.ndarray
    pixels: np.ndarray
    specular: np.ndarray
    silhouette: np.ndarray
    other_object: np.ndarray


@dataclass(frozen=True, eq=False)
class Errors:
    """What is wrong with a frame, over the pixels that look at a specular surface in the truth.

    Parameters
    ----------
    angular_mrad : Statistics
        Angle, at the truth's last specular point, between the truth's last ray and what the frame sees; away from
        silhouettes, milliradians.
    pixels : Statistics
        How far one must move in the picture for the truth to see the same; away from silhouettes.
    other_object_percent : float or None
        Share of the pixels away from silhouettes that see another object.
    silhouette_percent : float or None
        Share of the pixels that are at a silhouette.
    rmse, flip, relative_error : float or None
        Differences of colour, silhouettes included: see `ColorErrors`.
    maps : ErrorMaps
    """

    angular_mrad: Statistics
    pixels: Statistics
    other_object_percent: float | None
    silhouette_percent: float | None
    rmse: float | None
    flip: float | None
    relative_error: float | None
    maps: ErrorMaps


def measure(truth: Frame, frame: Frame) -> Errors:
    """Errors of `frame` against `truth`, which must carry its last rays; both need their seen buffers."""
    _check(truth, frame)
    specular = (truth.specular != 0) & (np.linalg.norm(truth.ray_direction, axis=-1) > 0.0)
    silhouette = specular & silhouettes(truth.object_id, truth.specular)
    inside = specular & ~silhouette
    other_object = inside & ((frame.object_id != truth.object_id) | (frame.specular == 0))
    angular, pixels = _geometry(truth, frame, specular)
    colors = color_errors(truth.color, frame.color, specular)
    return Errors(
        angular_mrad=_statistics(angular[inside]),
        pixels=_statistics(pixels[inside]),
        other_object_percent=_percent(other_object, inside),
        silhouette_percent=_percent(silhouette, specular),
        rmse=colors.rmse,
        flip=colors.flip,
        relative_error=colors.relative_error,
        maps=ErrorMaps(angular, pixels, specular, silhouette, other_object),
    )


def silhouettes(*labels: np.ndarray) -> np.ndarray:
    """Pixels, (H, W) bool, with one of their eight neighbours different in any of the label pictures (H, W)."""
    found = np.zeros(labels[0].shape, bool)
    height, width = found.shape
    for label in labels:
        padded = np.pad(label, 1, mode="edge")
        for row in range(3):
            for column in range(3):
                found |= padded[row : row + height, column : column + width] != label
    return found


def _geometry(truth: Frame, frame: Frame, specular: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angular errors in milliradians and errors in pixels, (H, W) each."""
    origin, direction = np.asarray(truth.ray_origin, float), np.asarray(truth.ray_direction, float)
    direction = normalized(direction)
    toward = seen_directions(origin[specular], frame.position[specular], frame.object_id[specular])
    angular = np.zeros(specular.shape)
    angular[specular] = 1000.0 * angles_between(direction[specular], toward)

    along = np.einsum("ij,ij->i", frame.position[specular] - origin[specular], direction[specular])
    sky_or_behind = (frame.object_id[specular] == 0) | (along <= 0.0)
    distances = np.full(specular.shape, np.inf)
    distances[specular] = np.where(sky_or_behind, np.inf, along)
    footprints = ray_footprints(origin, direction, truth.specular, distances)
    pixels = np.zeros(specular.shape)
    pixels[specular] = picture_distances(
        origin[specular],
        direction[specular],
        toward,
        distances[specular],
        footprints[specular],
        limit=float(np.hypot(*specular.shape)),
    )
    return angular, pixels


def _statistics(values: np.ndarray) -> Statistics:
    if not len(values):
        return Statistics(None, None, None)
    median, p95 = np.percentile(values, [50.0, 95.0])
    return Statistics(float(median), float(p95), float(values.max()))


def _percent(part: np.ndarray, whole: np.ndarray) -> float | None:
    return 100.0 * float(np.count_nonzero(part)) / np.count_nonzero(whole) if whole.any() else None


def _check(truth: Frame, frame: Frame) -> None:
    needed = {"truth": ("color", "position", "object_id", "specular", "ray_origin", "ray_direction")}
    needed["frame"] = ("color", "position", "object_id", "specular")
    for name, given in (("truth", truth), ("frame", frame)):
        for field in needed[name]:
            buffer = getattr(given, field)
            if buffer is None:
                raise AnamorphError(f"{name}: has no '{field}' buffer; draw it with seen=True")
            if buffer.dtype.kind == "f" and not np.isfinite(buffer).all():
                raise AnamorphError(f"{name}: '{field}' holds values that are not finite; it cannot be measured")
    if truth.color.shape != frame.color.shape:
        raise AnamorphError(
            f"truth and frame differ in size: {truth.color.shape} and {frame.color.shape}; draw both at one size"
        )
