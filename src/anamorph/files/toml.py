"""Values as TOML: the standard library only reads it."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

from anamorph.base.errors import AnamorphError


def toml_text(values: Mapping[str, Any]) -> str:
    """A document whose reader gets back exactly `values`, whose keys must be plain words.

    Mappings become tables, lists of mappings arrays of tables, both after all else; mappings in these are inline.
    """
    plain = {key: value for key, value in values.items() if not _has_heading(value)}
    parts = ["".join(f"{key} = {_value(key, value)}\n" for key, value in plain.items())]
    for key, value in values.items():
        if key in plain:
            continue
        heading, tables = (f"[{key}]", [value]) if isinstance(value, Mapping) else (f"[[{key}]]", value)
        parts += [
            "\n".join([heading, *(f"{name} = {_value(name, entry)}" for name, entry in table.items())]) + "\n"
            for table in tables
        ]
    return "\n".join(filter(None, parts))


def _has_heading(value: Any) -> bool:
    return isinstance(value, Mapping) or (isinstance(value, list) and bool(value) and isinstance(value[0], Mapping))


def _value(key: str, value: Any) -> str:
    match value:
        case bool():
            return "true" if value else "false"
        case str():
            # JSON escapes what TOML does, but for the last control character, and lone surrogates stay.
            try:
                value.encode()
            except UnicodeEncodeError:
                raise AnamorphError(f"{key}: {value!r} is no text in Unicode; give another name") from None
            return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
        case int():
            return str(value)
        case float():
            if not math.isfinite(value):
                raise AnamorphError(f"{key}: is {value}; scene files keep finite numbers only")
            return repr(float(value))
        case Mapping():
            return "{ " + ", ".join(f"{name} = {_value(name, entry)}" for name, entry in value.items()) + " }"
        case Sequence():
            return "[" + ", ".join(_value(key, entry) for entry in value) + "]"
    raise TypeError(f"{key}: a {type(value).__name__} has no form in TOML")
