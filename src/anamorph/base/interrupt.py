"""Ctrl-C, or a request to end, ends the command at once, from within the handler.

An exception, which is Python's own way, can be swallowed: by `except BaseException` around the imports of a library,
and by every callback from C. Leaving cannot.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

MESSAGE = "anamorph: error: interrupted; files that are there are whole"

ENDING = (signal.SIGINT, signal.SIGTERM)

_endings: list[Callable[[], object]] = []


def leave_on_interrupt() -> None:
    """From now on SIGINT and SIGTERM end the process with one line and code 130 or 143, unless they are ignored."""
    for each in ENDING:
        if signal.getsignal(each) is not signal.SIG_IGN:
            signal.signal(each, _leave)


@contextmanager
def on_interrupt(ending: Callable[[], object]) -> Iterator[None]:
    """While the block runs, call `ending` before an interrupt ends the process."""
    _endings.append(ending)
    try:
        yield
    finally:
        _endings.remove(ending)


def _leave(number: int, _: object) -> None:
    for each in ENDING:
        signal.signal(each, signal.SIG_IGN)
    for ending in reversed(_endings):
        with suppress(Exception):
            ending()
    with suppress(OSError):
        os.write(2, f"{MESSAGE}\n".encode())
    os._exit(128 + number)
