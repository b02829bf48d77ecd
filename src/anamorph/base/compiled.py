"""Loops compiled to machine code, and the threads that run them on all the cores."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Generator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from functools import cache
from itertools import islice
from pathlib import Path
from typing import Any

import numba

STEP = 0.01
"""Seconds that work in steps goes on for, at most, before it says so."""

AHEAD = 8
"""Pieces a core that work in steps has on their way at once: other work comes after no more than these."""


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile `function` at its first call, to run without Python's lock, and keep the machine code on disk.

    It works on arrays that it is given and can make none: counting references to arrays, with atomic operations on
    every pass to another function, would take most of the time of a loop over rays. Where no directory can be
    written (a read-only install without a home), it is compiled anew in every process.
    """
    return _compiled(function)


def inlined(function: Callable[..., Any]) -> Callable[..., Any]:
    """Like `compiled`, and part of the machine code of its callers.

    For what takes many arrays: handing them on, each in seven parts, takes longer than what is done with them.
    """
    return _compiled(function, forceinline=True)


def _compiled(function: Callable[..., Any], **more: bool) -> Callable[..., Any]:
    options = {"nogil": True, "error_model": "numpy", "_nrt": False, **more}
    try:
        dispatcher: Any = numba.njit(function, cache=True, **options)
        # Numba looks at the function's own file only, and would keep machine code that has old callees built in. The
        # version is compared before the rest is read, which may name types that are no longer where they were.
        kept = dispatcher._cache._cache_file
        kept._version, kept._source_stamp = f"{numba.__version__} {_stamp()}", None
    except (RuntimeError, AttributeError):
        return numba.njit(function, **options)
    return dispatcher


def compiled_modules() -> list[Path]:
    """Every module of this package that has compiled functions."""
    modules = sorted(Path(__file__).parents[1].rglob("*.py"))
    return [module for module in modules if {b"@compiled", b"@inlined"} & set(module.read_bytes().split())]


@cache
def _stamp() -> str:
    """A digest of every module with compiled functions."""
    return hashlib.sha256(b"".join(module.read_bytes() for module in compiled_modules())).hexdigest()


def cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@cache
def _threads() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(cores(), thread_name_prefix="anamorph")


if hasattr(os, "register_at_fork"):
    # A forked child inherits the pool but not its threads.
    os.register_at_fork(after_in_child=_threads.cache_clear)


def over_all_cores(work: Callable[[int, int], None], count: int, grain: int) -> None:
    """Call work(start, stop) for pieces of range(count), `grain` or fewer each, on all the cores.

    One piece runs in the calling thread, because waking another costs more than a small piece itself.
    """
    starts = range(0, count, grain)
    if len(starts) <= 1 or cores() == 1:
        for start in starts:
            work(start, min(start + grain, count))
        return
    pieces = [_threads().submit(work, start, min(start + grain, count)) for start in starts]
    try:
        for piece in pieces:
            piece.result()
    finally:
        # After a failure, nothing that still runs may write into arrays that the caller has given up.
        for piece in pieces:
            piece.cancel()
        wait(pieces)


def steps_over_all_cores(work: Callable[[int, int], None], count: int, grain: int) -> Generator[None, None, None]:
    """Like `over_all_cores`, in steps of a few milliseconds.

    The pieces that have begun go on between two steps; once it is closed, none does.
    """
    starts = range(0, count, grain)
    if len(starts) <= 1 or cores() == 1:
        for start in starts:
            work(start, min(start + grain, count))
            yield
        return
    waiting, going = iter(starts), list[Future[None]]()
    try:
        while True:
            for start in islice(waiting, AHEAD * cores() - len(going)):
                going.append(_threads().submit(work, start, min(start + grain, count)))
            if not going:
                return
            # To wake for each piece would take time from those that run.
            wait(going[: AHEAD * cores() // 2], STEP)
            done = {piece for piece in going if piece.done()}
            for piece in done:
                piece.result()
            going = [piece for piece in going if piece not in done]
            yield
    finally:
        for piece in going:
            piece.cancel()
        wait(going)
