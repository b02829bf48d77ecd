"""Keeping libraries' own messages off the user's terminal."""

from __future__ import annotations

import logging
import warnings


def hush() -> None:
    """Silence what libraries log and warn about themselves; what matters to a user arrives as an AnamorphError."""
    logging.disable(logging.CRITICAL)
    warnings.simplefilter("ignore")


def heed(*loggers: str) -> None:
    """Let libraries log errors after all, and these also warnings: what runs until its user ends it has no better way.

    Nobody else tells of an error in a callback.
    """
    logging.root.setLevel(logging.ERROR)
    for name in loggers:
        logging.getLogger(name).setLevel(logging.WARNING)
    logging.disable(logging.NOTSET)
