"""In which unit a model is written, and which way its axes point: words of a user's, as numbers."""

from __future__ import annotations

import re

import numpy as np

from anamorph.base.errors import AnamorphError, nearest

UNITS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "km": 1e3, "in": 0.0254, "ft": 0.3048}
"""Metres in each unit."""

WAYS = {"right": (0, 1), "left": (0, -1), "up": (1, 1), "down": (1, -1), "back": (2, 1), "forward": (2, -1)}
"""Which axis of the world each word is along, and which way: y is up, and a camera looks forward along -z."""

AXIS = re.compile(r"\s*([xyz])\s+([a-z]+)\s*", re.IGNORECASE)


def metres_in(units: str) -> float:
    """Metres in a unit, as "mm"; 1 for ""."""
    if units and units not in UNITS:
        raise AnamorphError(f"units is '{units:.40}'{nearest(units, UNITS)} (known: {', '.join(UNITS)})")
    return UNITS.get(units, 1.0)


def turn_of(axes: str) -> np.ndarray:
    """The rotation (3, 3) that takes a model's axes to where the words say, as "x back, z up"; none for "".

    Of one axis that is named, the third one stays: "z up" is a quarter turn about x. Of two, the third follows.

    Raises
    ------
    AnamorphError
        The words are no axes, two of them point the same way, or three make a left-handed frame.
    """
    if not axes.strip():
        return np.eye(3)

    def wrong(why: str) -> AnamorphError:
        return AnamorphError(f"axes is '{axes:.60}', and {why}; give two of x, y and z, as 'x back, z up'")

    turn = np.zeros((3, 3))
    for words in axes.split(","):
        found = AXIS.fullmatch(words)
        if not found or found[2].lower() not in WAYS:
            raise wrong(f"'{words.strip():.20}' is no axis with {', '.join(WAYS)}")
        column = "xyz".index(found[1].lower())
        along, sign = WAYS[found[2].lower()]
        if turn[:, column].any() or turn[along].any():
            raise wrong(f"'{words.strip()}' comes after another of that axis or way")
        turn[along, column] = sign
    missing = np.flatnonzero(~turn.any(axis=0))
    if len(missing) == 2:
        (row,), (named,) = np.nonzero(turn)
        if row == named and turn[row, named] < 0.0:
            raise wrong("one axis alone does not say about which other it turns")
        # The way that the named axis takes, or else any other, is free for the third.
        missing = np.array([row if row != named else (row + 1) % 3])
        stays = 3 - named - missing[0]
        turn[stays, stays] = 1.0
    if len(missing) == 1:
        (last,) = missing
        turn[:, last] = np.cross(turn[:, (last + 1) % 3], turn[:, (last + 2) % 3])
    if np.linalg.det(turn) < 0.0:
        raise wrong("that is a left-handed frame, which would show the model mirrored")
    return turn
