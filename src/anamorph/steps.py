"""Long work in steps: generators that yield how far they are, and return what they made.

Whoever drives one can do something else between two steps, and ends it by closing it.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import Any, TypeVar

Step = tuple[int, int, str]
"""The steps done, their number, and what is being done now."""

Result = TypeVar("Result")


def drain(steps: Generator[tuple[Any, ...], None, Result], tell: Callable[..., object]) -> Result:
    """What a generator returns in the end; `tell` is told what it yields on the way."""
    while True:
        try:
            step = next(steps)
        except StopIteration as end:
            return end.value
        tell(*step)
