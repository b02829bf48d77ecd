"""How wrong what one half shows is: its errors against the reference, and the false-colour images that show them.

These are 8-bit sRGB. The reference, or the image, stays behind them in a grey that none of their colours comes near.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.frame import Frame, Status
from anamorph.measure.errors import ErrorMaps, error_maps, geometry_statistics
from anamorph.measure.heatmap import MILLIRADIANS, PIXELS, Scale, faint, heat_colors, opaque, packed
from anamorph.measure.status import status_shares
from anamorph.viewer.facts import Figures

Color = tuple[int, int, int]

SCALES: Mapping[str, Scale] = {scale.unit: scale for scale in (MILLIRADIANS, PIXELS)}
"""Of the false-colour image of errors, by `State.unit`."""

OTHER_OBJECT: Color = (255, 0, 255)
SILHOUETTE: Color = (0, 0, 0)

ERROR_COLORS: Mapping[str, Color] = {"sees another object": OTHER_OBJECT, "at a silhouette": SILHOUETTE}
"""What has a colour of its own among the errors, for their legend."""

STATUS_COLORS: dict[Status, Color] = {
    Status.DIRECT: (225, 225, 225),
    Status.WARPED: (30, 70, 220),
    Status.PROVED: (245, 190, 40),
    Status.TRACED: (240, 115, 105),
    Status.SKY: (86, 180, 233),
    Status.TOTAL_REFLECTION: (140, 20, 10),
    Status.OUTSIDE: (0, 0, 0),
    Status.PROJECTED: (120, 25, 150),
    Status.DOUBTFUL: (225, 60, 0),
}
"""Of statuses; the colour-blind, too, tell them apart. Direct pixels show the image, in about this grey."""


@dataclass(frozen=True, eq=False)
class Measured:
    """What one half shows, held against the reference.

    Parameters
    ----------
    frame, reference : Frame
        With their seen buffers.
    maps : ErrorMaps
    figures : Figures
    """

    frame: Frame
    reference: Frame
    maps: ErrorMaps
    figures: Figures


def measure_half(reference: Frame, frame: Frame) -> Measured:
    """Hold `frame` against `reference`; both need their seen buffers, and `reference` its last rays."""
    maps = error_maps(reference, frame)
    errors = geometry_statistics(maps)
    shares = status_shares(frame, maps.specular)
    figures = Figures(errors.angular_mrad, errors.pixels, errors.other_object_percent, shares)
    return Measured(frame, reference, maps, figures)


def error_colors(measured: Measured, unit: str) -> np.ndarray:
    """The error of each pixel over the reference in faint grey, (H, W, 4) uint8, in "mrad" or "px": see
    `scale_ticks`."""
    maps = measured.maps
    colors = heat_colors(maps, measured.reference.color, _scale(unit))
    for marked, color in ((maps.silhouette, SILHOUETTE), (maps.other_object, OTHER_OBJECT)):
        np.copyto(packed(colors), opaque(np.array(color, np.uint8)), where=marked)
    return colors


def status_colors(frame: Frame) -> np.ndarray:
    """How each pixel got its value, (H, W, 4) uint8, in `STATUS_COLORS`; what is seen directly shows the image."""
    if frame.status is None or frame.specular is None:
        raise AnamorphError("frame: has no 'status' buffer; draw it with seen=True")
    colors = faint(frame.color)
    bent = frame.status != Status.DIRECT
    if not frame.ray_mesh:
        # The sky beside a mirror is seen directly, and has a status of its own.
        bent &= (frame.specular != 0) | (frame.status != Status.SKY)
    np.copyto(packed(colors), _packed_status_colors()[frame.status], where=bent)
    return colors


def scale_ticks(unit: str) -> tuple[tuple[float, str], ...]:
    """Of the scale of errors: places from 0, its lowest end, to 1, and their labels."""
    ticks = _scale(unit).ticks
    return tuple((number / (len(ticks) - 1), f"{tick:g}") for number, tick in enumerate(ticks))


def _scale(unit: str) -> Scale:
    if unit not in SCALES:
        raise AnamorphError(f"unit: is {unit!r}; give {' or '.join(SCALES)}")
    return SCALES[unit]


@cache
def _packed_status_colors() -> np.ndarray:
    """Packed, by status."""
    colors = np.zeros((256, 3), np.uint8)
    for status, color in STATUS_COLORS.items():
        colors[status] = color
    return opaque(colors)
