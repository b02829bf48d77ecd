"""The one error a user is meant to read, and the hint that many of its lines end with."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class AnamorphError(ValueError):
    """Something the user can mend: one line that names the file, the field and the remedy.

    The command line prints it on stderr and exits with code 2. Names of files and keys may hold anything, also codes
    that a terminal obeys: these are shown, and not sent.
    """

    def __init__(self, message: str) -> None:
        super().__init__(shown(message))


def shown(text: str) -> str:
    """A text in which no letter does anything: line breaks and other control characters are written as escapes."""
    return "".join(letter if letter.isprintable() else repr(letter)[1:-1] for letter in text)


def nearest(word: str, known: Iterable[str]) -> str:
    """'; did you mean ...?' with the known word nearest to `word`, or nothing."""
    names = {name.lower(): name for name in known}
    found = difflib.get_close_matches(word.lower(), names, n=1, cutoff=0.5)
    return f"; did you mean '{names[found[0]]}'?" if found else ""
