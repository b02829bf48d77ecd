"""What libraries log and warn about of their own: kept off the user's terminal, unless nothing else reports it."""

from __future__ import annotations

import logging
import warnings

from anamorph.base.notes import print_notes


def silence_libraries() -> None:
    """Silence what libraries log and warn about themselves.

    What matters to a user arrives as an AnamorphError, or as a note.
    """
    logging.disable(logging.CRITICAL)
    warnings.simplefilter("ignore")
    print_notes()


def show_errors_of_libraries(*loggers: str) -> None:
    """Let libraries log errors after all, and `loggers` also warnings.

    A program that runs until its user ends it needs this: nobody else reports an error in a callback.
    """
    logging.root.setLevel(logging.ERROR)
    for name in loggers:
        logging.getLogger(name).setLevel(logging.WARNING)
    logging.disable(logging.NOTSET)
