"""What each option of a method may be, said once, at the option: checks, messages and the viewer's controls read it."""

from __future__ import annotations

import dataclasses
import inspect
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from anamorph.base.errors import AnamorphError

LIMITS = "limits"


@dataclass(frozen=True)
class Limits:
    """What an option may be.

    Parameters
    ----------
    choices : tuple
        The only values there are; none where there are others.
    low, high : float or None
        The least and the greatest number; None where there is none but what is finite.
    unit : str
        Of numbers, in the plural: "pixels".
    """

    choices: tuple[Any, ...] = ()
    low: float | None = None
    high: float | None = None
    unit: str = ""


def option(
    default: Any, choices: Sequence[Any] = (), low: float | None = None, high: float | None = None, unit: str = ""
) -> Any:
    """A field of a method's options that says what it may be: see `Limits`."""
    return dataclasses.field(default=default, metadata={LIMITS: Limits(tuple(choices), low, high, unit)})


def limits_of(field: dataclasses.Field[Any]) -> Limits:
    """What a field may be: anything of its type, unless `option` made it."""
    limits: Limits = field.metadata.get(LIMITS, Limits())
    return limits


def check_options(method: str, options: Any) -> None:
    """Refuse what is beyond an option's limits.

    Parameters
    ----------
    method : str
        What to call it in messages.
    options : dataclass
        With fields that `option` made.
    """
    for field in dataclasses.fields(options):
        limits, value = limits_of(field), getattr(options, field.name)
        wanted = None
        if limits.choices and value not in limits.choices:
            *others, last = map(str, limits.choices)
            wanted = f"{', '.join(others)} or {last}"
        low = -float("inf") if limits.low is None else limits.low
        high = float("inf") if limits.high is None else limits.high
        # Infinity keeps to no limit that is left out.
        if isinstance(value, int | float) and not (low <= value <= high and abs(value) < float("inf")):
            count = f"a number of {limits.unit}" if limits.unit else "a number"
            least = f" from {low:g}" if limits.low is not None else ""
            wanted = f"{count}{least}" + (f" to {high:g}" if limits.high is not None else "")
        if wanted:
            raise AnamorphError(f"{method}: {field.name} is {value!r}; give {wanted}")


def summaries(options: type) -> dict[str, str]:
    """What the docstring of a dataclass says of each of its fields, under "Parameters"."""
    _, _, section = inspect.cleandoc(options.__doc__ or "").partition("Parameters\n----------\n")
    found: dict[str, str] = {}
    for entry in re.split(r"\n(?=\S)", section):
        names, _, text = entry.partition("\n")
        for name in names.partition(":")[0].split(","):
            found[name.strip()] = " ".join(text.split())
    return found
