"""How wrong a frame is: its errors against the truth, as figures and pixel by pixel.

Only pixels that have a last ray in the truth, and look at a specular surface there or through a ray mesh, count. Those
within one pixel of a silhouette in the truth are counted apart, because there a shift of any size shows another object.
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


@dataclass(frozen=True, eq=False)
class Errors:
    """What is wrong with a frame, over the pixels that count: see `counted`.

    Parameters
    ----------
    angular_mrad : Statistics
        Angle, where the truth's last ray begins, between that ray and what the frame sees; away from silhouettes,
        milliradians.
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


def counted(truth: Frame) -> np.ndarray:
    """The pixels of the truth, (H, W) bool, that have a last ray, from a specular surface or through a ray mesh."""
    bent = (_buffer("truth", truth, "specular") != 0) | truth.ray_mesh
    return bent & (np.linalg.norm(_buffer("truth", truth, "ray_direction"), axis=-1) > 0.0)


def measure(truth: Frame, frame: Frame) -> Errors:
    """Errors of `frame` against `truth`, which must carry its last rays; both need their seen buffers."""
    true_color, color = _buffer("truth", truth, "color"), _buffer("frame", frame, "color")
    if true_color.shape != color.shape:
        raise AnamorphError(f"truth {true_color.shape} and frame {color.shape} differ in size; draw both at one size")
    surface, true_object = _buffer("truth", truth, "specular"), _buffer("truth", truth, "object_id")
    object_id, looks_at = _buffer("frame", frame, "object_id"), _buffer("frame", frame, "specular")
    specular = counted(truth)
    # Pixels that do not count border on those that do, as another surface does.
    through = np.where(specular, surface.astype(np.int64), -1)
    silhouette = specular & silhouettes(true_object, through)
    inside = specular & ~silhouette
    misses = (looks_at == 0) & (surface != 0)
    # The sky, too, is seen in some direction.
    shows_nothing = (object_id == 0) & ~_buffer("frame", frame, "position").any(axis=-1)
    other_object = inside & ((object_id != true_object) | misses | shows_nothing)
    angular, pixels = _geometry(truth, frame, specular, through)
    colors = color_errors(true_color, color, specular)
    return Errors(
        angular_mrad=statistics(angular[inside]),
        pixels=statistics(pixels[inside]),
        other_object_percent=_percent(other_object, inside),
        silhouette_percent=_percent(silhouette, specular),
        rmse=colors.rmse,
        flip=colors.flip,
        relative_error=colors.relative_error,
        maps=ErrorMaps(angular, pixels, specular, silhouette, other_object),
    )


def silhouettes(*labels: np.ndarray) -> np.ndarray:
    """Pixels, (H, W) bool, with one of their eight neighbours different in any of the label pictures (H, W)."""
    height, width = labels[0].shape[:2]
    found = np.zeros((height, width), bool)
    for label in labels:
        padded = np.pad(label, 1, mode="edge")
        for row in range(3):
            for column in range(3):
                found |= padded[row : row + height, column : column + width] != label
    return found


def _geometry(truth: Frame, frame: Frame, specular: np.ndarray, through: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angular errors in milliradians and errors in pixels, (H, W) each, of pixels that look `through` surfaces."""
    origin = _buffer("truth", truth, "ray_origin").astype(float)
    direction = normalized(_buffer("truth", truth, "ray_direction").astype(float))
    position, object_id = _buffer("frame", frame, "position")[specular], _buffer("frame", frame, "object_id")[specular]
    toward = seen_directions(origin[specular], position, object_id)
    angular = np.zeros(specular.shape)
    angular[specular] = 1000.0 * angles_between(direction[specular], toward)

    along = np.einsum("ij,ij->i", position - origin[specular], direction[specular])
    distances = np.full(specular.shape, np.inf)
    distances[specular] = np.where((object_id == 0) | (along <= 0.0), np.inf, along)
    footprints = ray_footprints(origin, direction, through, distances)
    pixels = np.zeros(specular.shape)
    pixels[specular] = picture_distances(
        origin[specular],
        direction[specular],
        toward,
        distances[specular],
        footprints[specular],
        limit=float(np.linalg.norm(specular.shape)),
    )
    return angular, pixels


def statistics(values: np.ndarray) -> Statistics:
    """Of the values (N,)."""
    if not len(values):
        return Statistics(None, None, None)
    median, p95 = np.percentile(values, [50.0, 95.0])
    return Statistics(float(median), float(p95), float(values.max()))


def _percent(part: np.ndarray, whole: np.ndarray) -> float | None:
    return 100.0 * float(np.count_nonzero(part)) / np.count_nonzero(whole) if whole.any() else None


def _buffer(name: str, frame: Frame, field: str) -> np.ndarray:
    """One buffer of a frame that must be there, and finite."""
    buffer = getattr(frame, field)
    if buffer is None:
        raise AnamorphError(f"{name}: has no '{field}' buffer; draw it with seen=True")
    if buffer.dtype.kind == "f" and not np.isfinite(buffer).all():
        raise AnamorphError(f"{name}: '{field}' holds values that are not finite; it cannot be measured")
    return buffer
