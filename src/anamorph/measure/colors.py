"""How different two images look: RMSE, FLIP and Vallance's relative error, over some of their pixels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from flip_evaluator import evaluate

from anamorph.base.srgb import encode_srgb


@dataclass(frozen=True)
class ColorErrors:
    """Differences of colour over the counted pixels; None where there are none to count.

    Parameters
    ----------
    rmse : float or None
        Root mean square difference of linear RGB, clipped to the display's 0 to 1.
    flip : float or None
        Mean LDR-FLIP, 0 (equal) to 1, of the sRGB images at 67 pixels per degree: P. Andersson et al.,
        "FLIP: A Difference Evaluator for Alternating Images", 2020.
    relative_error : float or None
        Mean absolute RGB difference over the mean RGB of the reference, both linear and clipped: Vallance 2005. None
        also where the reference is black.
    """

    rmse: float | None
    flip: float | None
    relative_error: float | None


def color_errors(reference: np.ndarray, color: np.ndarray, counted: np.ndarray) -> ColorErrors:
    """Compare linear colours (H, W, 3) over the pixels where `counted` (H, W) is true."""
    if not counted.any():
        return ColorErrors(None, None, None)
    right, shown = (np.clip(np.asarray(image, float), 0.0, 1.0)[counted] for image in (reference, color))
    difference = shown - right
    brightness = float(right.mean())
    return ColorErrors(
        rmse=float(np.sqrt(np.mean(difference**2))),
        flip=float(flip_map(reference, color)[counted].mean()),
        relative_error=float(np.abs(difference).mean() / brightness) if brightness > 0.0 else None,
    )


def flip_map(reference: np.ndarray, color: np.ndarray) -> np.ndarray:
    """LDR-FLIP of each pixel, (H, W) float32, between linear images (H, W, 3).

    The whole images go in, because FLIP filters each pixel with its surroundings.
    """
    reference, test = (np.ascontiguousarray(encode_srgb(image)) for image in (reference, color))
    return evaluate(reference, test, "LDR", inputsRGB=True, applyMagma=False, computeMeanError=False)[0][..., 0]
