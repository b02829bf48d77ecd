"""What a user is told of an error, whatever has gone wrong: one line, and the viewer stays open."""

from __future__ import annotations

import logging

import wgpu

from anamorph.base.errors import AnamorphError

LONGEST = 200
"""Letters of what a library says; the rest is in the log."""


def failure_text(error: Exception, what: str) -> str:
    """One line on an error; what no user can mend goes into the log with its place in the code.

    Parameters
    ----------
    error : Exception
        While it is handled.
    what : str
        What has failed, for errors that do not say so themselves.
    """
    if isinstance(error, AnamorphError):
        return str(error)
    said = " ".join(str(error).split())[:LONGEST]
    if isinstance(error, wgpu.GPUError):
        return f"{what}: the graphics device failed ({said}); try a smaller window"
    if isinstance(error, MemoryError):
        return f"{what}: not enough memory; try a smaller window"
    if isinstance(error, OSError):
        return f"{what}: {said}; check the path and its permissions"
    logging.getLogger(__name__).exception(what)
    return f"{what}: failed ({type(error).__name__}: {said}); the log says where"
