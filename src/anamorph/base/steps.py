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
Told = TypeVar("Told")
Result = TypeVar("Result")


def drain(steps: Generator[Yielded, None, Result], tell: Callable[[Yielded], object] = lambda step: None) -> Result:
    """What the work returns in the end; `tell` is told what it yields on the way."""
    while True:
        try:
            step = next(steps)
        except StopIteration as end:
            return end.value
        tell(step)


def retold(steps: Generator[Yielded, None, Result], told: Callable[[Yielded], Told]) -> Generator[Told, None, Result]:
    """The same work in the words of the longer one that it is part of: yields what `told` makes of its steps."""
    with closing(steps):
        while True:
            try:
                step = next(steps)
            except StopIteration as end:
                return end.value
            yield told(step)


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
