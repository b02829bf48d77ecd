"""A method and its options, parsed once: what "name:option=value,option=value" specifies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any

from anamorph.base.errors import AnamorphError, nearest
from anamorph.frame import View
from anamorph.methods.protocol import Method
from anamorph.methods.registry import METHODS
from anamorph.methods.session import Session

WORDS = {bool: "true or false", int: "a whole number", float: "a number", str: "a word"}


@dataclass(frozen=True)
class Specification:
    """A method and its options.

    Parameters
    ----------
    method : Method
    options : dataclass
        Of the type `method.options`.
    """

    method: Method
    options: Any

    @classmethod
    def parse(cls, text: str | Specification) -> Specification:
        """What "name" or "name:option=value,option=value" specifies; of several values for one option the last holds.

        Raises
        ------
        AnamorphError
            An unknown method or option, or a value of the wrong type.
        """
        if isinstance(text, Specification):
            return text
        name, _, rest = text.partition(":")
        if name not in METHODS:
            raise AnamorphError(f"no method {name!r}: methods are {', '.join(METHODS)}{nearest(name, METHODS)}")
        given: dict[str, Any] = {}
        for item in filter(None, rest.split(",")):
            key, equals, value = item.partition("=")
            if not equals:
                raise AnamorphError(f"method {text}: {item!r} is no option; write option=value")
            given[key.strip()] = value.strip()
        return cls(METHODS[name], _options(METHODS[name], given))

    def __str__(self) -> str:
        """The text that specifies it, with the options that differ from their defaults."""
        given = [
            f"{field.name}={str(value).lower() if isinstance(value, bool) else value}"
            for field in fields(self.method.options)
            if (value := getattr(self.options, field.name)) != field.default
        ]
        return f"{self.method.name}:{','.join(given)}" if given else self.method.name

    def with_options(self, **changes: Any) -> Specification:
        """The same method with some options changed, each to a value or its text."""
        return Specification(self.method, _options(self.method, asdict(self.options) | changes))

    def open(self, view: View) -> Session:
        """Start drawing `view`."""
        return self.method.open(view, self.options)


def _options(method: Method, given: Mapping[str, Any]) -> Any:
    defaults = {field.name: field.default for field in fields(method.options)}
    for key in given:
        if key not in defaults:
            raise AnamorphError(f"{method.name}: no option {key!r}; options are {', '.join(defaults)}")
    return method.options(**{key: _converted(method.name, key, value, defaults[key]) for key, value in given.items()})


def _converted(method: str, key: str, value: Any, default: Any) -> Any:
    kind = type(default)
    if kind is bool and isinstance(value, str) and value.lower() in ("true", "false", "yes", "no", "1", "0"):
        return value.lower() in ("true", "yes", "1")
    if isinstance(value, kind) and (kind is bool) == isinstance(value, bool):
        return value
    try:
        if kind is not bool and not isinstance(value, bool):
            converted = kind(value)
            # int() drops fractions without a word.
            if kind is not int or isinstance(value, str) or converted == value:
                return converted
    except (TypeError, ValueError, OverflowError):
        pass
    raise AnamorphError(f"{method}: option {key} is {value!r}; give {WORDS[kind]}")
