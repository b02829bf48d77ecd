"""What is not an error, and still must not pass in silence: one line that says what of a file is not shown."""

from __future__ import annotations

import sys
import warnings
from typing import TextIO


class AnamorphNote(UserWarning):
    """One line that names the file, and what of it is left out or read in another way.

    A program filters it as any warning of Python. The command line prints it on stderr.
    """


def note(text: str) -> None:
    """Issue an `AnamorphNote`."""
    warnings.warn(text, AnamorphNote, stacklevel=3)


def print_notes() -> None:
    """Print notes on stderr from here on, as lines of the command line, whatever other warnings do."""
    warnings.filterwarnings("always", category=AnamorphNote)
    warnings.showwarning = _print


def _print(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    print(f"anamorph: note: {' '.join(str(message).split())}", file=file or sys.stderr)
