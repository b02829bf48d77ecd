"""What an optician writes down about a lens, and the two surfaces that follow from it."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.surfaces.base import Surface
from anamorph.surfaces.sphere import FLAT, round_surface
from anamorph.surfaces.toroid import Toroid


@dataclass(frozen=True)
class Prescription:
    """A spectacle lens of one power, in the optician's units. docs/lenses.md has the signs.

    Parameters
    ----------
    sphere : float
        Back vertex power in the meridian of the cylinder's axis, dioptres.
    cylinder : float
        What is added to it in the meridian at right angles, dioptres, of either sign.
    axis : float
        Of the cylinder, degrees in TABO notation: counter-clockwise from the right for who faces the wearer.
    prism : float
        At the middle of the lens, prism dioptres: 1 deviates light by 1 cm at 1 m.
    base : float
        The direction to the prism's base, degrees, as for `axis` but all around: 90 is up.
    index : float
        Refractive index for the d line (587.6 nm).
    abbe : float
        Abbe number.
    centre_thickness : float
        Millimetres, on the axis.
    base_curve : float, optional
        Power of the front surface, dioptres, in the lens's own index. By default Vogel's rule: the mean power and
        6 more for plus lenses, half the mean power and 6 more for minus lenses, but never a concave front.
    diameter : float
        Millimetres.
    vertex_distance : float
        From the back vertex to the eye, millimetres.
    """

    sphere: float
    cylinder: float = 0.0
    axis: float = 180.0
    prism: float = 0.0
    base: float = 0.0
    index: float = 1.5
    abbe: float = 58.0
    centre_thickness: float = 2.0
    base_curve: float | None = None
    diameter: float = 60.0
    vertex_distance: float = 14.0

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = getattr(self, entry.name)
            if value is None and entry.name == "base_curve":
                continue
            if not isinstance(value, int | float | np.integer | np.floating) or not np.isfinite(value):
                raise AnamorphError(f"prescription: {entry.name} is {value!r}; give a finite number")
        lengths = ("centre_thickness", "diameter", "vertex_distance")
        for name, unit in (("abbe", ""), *((length, " of millimetres") for length in lengths)):
            if getattr(self, name) <= 0.0:
                raise AnamorphError(f"prescription: {name} is {getattr(self, name):g}; give a positive number{unit}")
        if self.prism < 0.0:
            raise AnamorphError(f"prescription: prism is {self.prism:g}; give 0 or more prism dioptres")
        if not 1.0 < self.index <= 4.0:
            raise AnamorphError(f"prescription: index is {self.index:g}; give one above 1 and up to 4, 1.5 for plastic")
        if not 0.0 <= self.axis <= 180.0:
            raise AnamorphError(f"prescription: axis is {self.axis:g}; give degrees from 0 to 180")
        if not 0.0 <= self.base <= 360.0:
            raise AnamorphError(f"prescription: base is {self.base:g}; give degrees from 0 to 360")

    @property
    def front_power(self) -> float:
        """Power of the front surface, dioptres."""
        if self.base_curve is not None:
            return self.base_curve
        mean = self.sphere + self.cylinder / 2.0
        return max(mean + 6.0 if mean > 0.0 else mean / 2.0 + 6.0, 0.0)

    def back_power(self, power: float) -> float:
        """The surface power, dioptres, that the back needs for a back vertex power: F'v = F1 / (1 - (t/n) F1) + F2."""
        reduced = 1.0 - 1e-3 * self.centre_thickness / self.index * self.front_power
        if reduced <= 0.0:
            raise AnamorphError(
                f"prescription: base_curve {self.front_power:g} D focuses light inside the lens; give a flatter one"
            )
        return power - self.front_power / reduced

    @property
    def back_tilt(self) -> float:
        """By how much the prism tilts the back against the axis, radians."""
        deviation = np.arctan(self.prism / 100.0)
        # Light along the axis meets the front squarely: the tilt of the back alone has to deviate it.
        return float(np.arctan2(np.sin(deviation), self.index - np.cos(deviation)))

    def surfaces(self, back_vertex: np.ndarray, axes: np.ndarray) -> tuple[Surface, Surface]:
        """Front and back of the lens whose back vertex is at `back_vertex` (3,) and whose axes are `axes` (3, 3).

        Rows of `axes`: right and up as seen by who faces the wearer, and outward, from the wearer to them.
        """
        right, up, outward = axes = np.asarray(axes, float)
        per_power = 1.0 / (self.index - 1.0)
        front = round_surface(back_vertex + 1e-3 * self.centre_thickness * outward, axes, self.front_power * per_power)

        base = np.cos(np.radians(self.base)) * right + np.sin(np.radians(self.base)) * up
        behind = -np.cos(self.back_tilt) * outward - np.sin(self.back_tilt) * base
        along = np.cos(np.radians(self.axis)) * right + np.sin(np.radians(self.axis)) * up
        along -= (along @ behind) * behind
        along /= np.linalg.norm(along)
        back_axes = np.stack([along, np.cross(behind, along), behind])
        at_axis, across = (per_power * self.back_power(self.sphere + more) for more in (0.0, self.cylinder))
        if abs(at_axis - across) < FLAT:
            return front, round_surface(back_vertex, back_axes, at_axis)
        return front, Toroid(back_vertex, at_axis, across, back_axes)
