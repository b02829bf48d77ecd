"""Long work in steps: generators that yield how far they are, and return what they made.

Whoever drives one can do something else between two steps, and ends it by closing it.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import closing
from time import perf_counter
from typing import TypeVar

Step = tuple[int, int, str]
"""The steps done, their number, and what is being done now."""

Yielded = TypeVar("Yielded")
Changed = TypeVar("Changed")
Result = TypeVar("Result")


def drain(steps: Generator[Yielded, None, Result], report: Callable[[Yielded], object] = lambda step: None) -> Result:
    """What the work returns in the end; `report` takes what it yields on the way."""
    while True:
        try:
            step = next(steps)
        except StopIteration as end:
            return end.value
        report(step)


def mapped(
    steps: Generator[Yielded, None, Result], change: Callable[[Yielded], Changed]
) -> Generator[Changed, None, Result]:
    """The same work as part of a longer one: yields what `change` makes of its steps."""
    with closing(steps):
        while True:
            try:
                step = next(steps)
            except StopIteration as end:
                return end.value
            yield change(step)


def timed(steps: Generator[Yielded, None, Result]) -> Generator[Yielded, None, tuple[Result, float]]:
    """The same work; returns beside its result the seconds that it took, without what was done between its steps."""
    spent = 0.0
    with closing(steps):
        while True:
            began = perf_counter()
            try:
                step = next(steps)
            except StopIteration as end:
                return end.value, spent + perf_counter() - began
            spent += perf_counter() - began
            yield step
