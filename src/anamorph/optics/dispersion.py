"""How the refractive index changes with colour."""

from __future__ import annotations

from anamorph.base.errors import AnamorphError

C_LINE, D_LINE, F_LINE = 656.27, 587.56, 486.13
"""Wavelengths in nm: red (hydrogen), yellow (helium), blue (hydrogen)."""


def line_indices(index: float, abbe: float | None) -> tuple[float, float, float]:
    """Refractive indices for red, green and blue light: at the C, d and F lines.

    The Abbe number V = (n_d - 1) / (n_F - n_C) says how far apart red and blue are; Cauchy's formula n = A + B / λ²
    says where between them green lies.

    Parameters
    ----------
    index : float
        n_d.
    abbe : float or None
        None: no dispersion.

    Returns
    -------
    n_C, n_d, n_F : float
    """
    if abbe is None:
        return index, index, index
    if not abbe > 0.0:
        raise AnamorphError(f"glass: Abbe number is {abbe:g}; give a positive number, 58 for plastic, or leave it out")
    red, green, blue = C_LINE**-2, D_LINE**-2, F_LINE**-2
    strength = (index - 1.0) / abbe / (blue - red)
    first, last = index + strength * (red - green), index + strength * (blue - green)
    if min(first, last) <= 0.0:
        raise AnamorphError(f"glass: Abbe number {abbe:g} leaves some colour no refractive index; give a larger one")
    return first, index, last
