"""The methods: each one answer to what a ray mesh sees."""

from __future__ import annotations

import dataclasses
from typing import Any

from anamorph.base.errors import AnamorphError, nearest
from anamorph.methods import environment, pervertex, raytrace, trilinear
from anamorph.methods.protocol import Method, Session

METHODS: dict[str, Method] = {
    module.METHOD.name: module.METHOD for module in (raytrace, environment, pervertex, trilinear)
}

__all__ = ["METHODS", "Method", "Session", "make_options", "parse", "with_option"]


def parse(specification: str) -> tuple[Method, Any]:
    """The method and its options from "name" or "name:option=value,option=value".

    Raises
    ------
    AnamorphError
        An unknown method or option, or a value of the wrong type.
    """
    name, _, rest = specification.partition(":")
    method = _method(name)
    given: dict[str, Any] = {}
    for item in filter(None, rest.split(",")):
        key, equals, value = item.partition("=")
        if not equals:
            raise AnamorphError(f"method {specification}: {item!r} is no option; write option=value")
        given[key.strip()] = value.strip()
    return method, make_options(method, given)


def with_option(specification: str, key: str, value: object) -> str:
    """`specification` with one more option; the last of several values for one option holds."""
    return f"{specification}{',' if ':' in specification else ':'}{key}={value}"


def make_options(method: Method, given: dict[str, Any]) -> Any:
    """A method's options from a mapping of names to values or their text."""
    fields = {field.name: field.default for field in dataclasses.fields(method.options)}
    for key in given:
        if key not in fields:
            raise AnamorphError(f"{method.name}: no option {key!r}; options are {', '.join(fields)}")
    return method.options(**{key: _convert(method.name, key, value, fields[key]) for key, value in given.items()})


def _method(name: str) -> Method:
    if name in METHODS:
        return METHODS[name]
    raise AnamorphError(f"no method {name!r}: methods are {', '.join(METHODS)}{nearest(name, METHODS)}")


def _convert(method: str, key: str, value: Any, default: Any) -> Any:
    kind = type(default)
    words = {bool: "true or false", int: "a whole number", float: "a number", str: "a word"}
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
    raise AnamorphError(f"{method}: option {key} is {value!r}; give {words[kind]}")
