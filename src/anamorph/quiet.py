"""Keeping libraries' own messages off the user's terminal."""

from __future__ import annotations

import logging
import warnings


def hush() -> None:
    """Silence what libraries log and warn about themselves; what matters to a user arrives as an AnamorphError."""
    logging.disable(logging.CRITICAL)
    warnings.simplefilter("ignore")
