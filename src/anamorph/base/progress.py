"""A bar that shows how far long work is: on a terminal only, and on stderr, so that results can be piped."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from anamorph.base.interrupt import on_interrupt

Report = Callable[[int, int, str], None]
"""Hears the steps done, their number, and what is being done now."""


@contextmanager
def progress_bar(what: str) -> Iterator[Report]:
    """A bar that is gone when the block ends; it moves to and fro until it first hears how far the work is."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda done, total, what: None
        return
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as bar, on_interrupt(bar.stop):
        task = bar.add_task(escape(what), total=None)
        yield lambda done, total, what: bar.update(task, completed=done, total=total, description=escape(what))
