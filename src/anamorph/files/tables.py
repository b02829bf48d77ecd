"""TOML tables that know the lines they stand on, so that a mistake is named by file, line and key."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from anamorph.base.errors import AnamorphError, nearest
from anamorph.base.limits import LONGEST_KEY, SCENE_BYTES
from anamorph.files.key_lines import Keys, key_lines
from anamorph.files.reading import is_file, read

Vector = tuple[float, float, float]

LARGEST = float(np.finfo(float).max)


@dataclass(frozen=True, eq=False)
class Table:
    """A table of a TOML file: its values by key, and the lines of all keys in the file.

    Each method that reads a value raises AnamorphError where its type is another.
    """

    path: Path
    keys: Keys
    values: dict[str, Any]
    lines: dict[Keys, int]

    def wrong(self, key: str | None, what: str) -> NoReturn:
        """Raise an error at `key`, or at the table itself."""
        keys = self.keys if key is None else (*self.keys, key)
        while keys and keys not in self.lines:
            keys = keys[:-1]
        line = f", line {self.lines[keys]}" if keys else ""
        raise AnamorphError(f"{self.path}{line}: {what}")

    def only(self, *known: str) -> None:
        """Refuse every other key."""
        for key in self.values:
            if key not in known:
                self.wrong(key, f"unknown key '{key}'{nearest(key, known)} (known: {', '.join(known)})")

    def required(self, key: str) -> None:
        """Refuse a table without `key`."""
        if key not in self.values:
            title = ".".join(str(part) for part in self.keys if isinstance(part, str)) or "the file"
            self.wrong(None, f"{title} needs the key '{key}'")

    def text(self, key: str, default: str = "") -> str:
        """A string."""
        value = self.values.get(key, default)
        return value if isinstance(value, str) else self._mistaken(key, "text in quotes")

    def number(self, key: str, default: float, least: float = -np.inf, most: float = np.inf) -> float:
        """A finite number."""
        value = self.values.get(key, default)
        if not _is_number(value):
            self._mistaken(key, "a number")
        if not least <= value <= most:
            bounds = f"from {least:g} to {most:g}" if np.isfinite(most) else f"of at least {least:g}"
            self._mistaken(key, f"a number {bounds}")
        return float(value)

    def vector(self, key: str, default: Vector) -> Vector:
        """Three finite numbers."""
        value = self.values.get(key, default)
        if not isinstance(value, list | tuple) or len(value) != 3 or not all(_is_number(entry) for entry in value):
            self._mistaken(key, "three numbers, as [0.0, 1.0, 0.0]")
        return (float(value[0]), float(value[1]), float(value[2]))

    def color(self, key: str, default: Vector) -> Vector:
        """Three numbers of at least 0."""
        value = self.vector(key, default)
        return value if min(value) >= 0 else self._mistaken(key, "three numbers of at least 0")

    def size(self, key: str, default: tuple[int, int]) -> tuple[int, int]:
        """Two whole numbers of at least 1."""
        value = self.values.get(key, default)
        whole = isinstance(value, list | tuple) and all(type(entry) is int and entry > 0 for entry in value)
        if not whole or len(value) != 2:
            self._mistaken(key, "two whole numbers of pixels, as [1024, 768]")
        return (value[0], value[1])

    def flag(self, key: str, default: bool = False) -> bool:
        """True or false."""
        value = self.values.get(key, default)
        return value if isinstance(value, bool) else self._mistaken(key, "true or false")

    def whole(self, key: str, default: int, least: int, most: int) -> int:
        """A whole number."""
        value = self.values.get(key, default)
        if type(value) is not int or not least <= value <= most:
            self._mistaken(key, f"a whole number from {least} to {most}")
        return value

    def words(self, key: str, known: Iterable[str]) -> list[str]:
        """A list of some words, which may be missing."""
        value, known = self.values.get(key, []), tuple(known)
        if not isinstance(value, list) or not all(isinstance(word, str) for word in value):
            self._mistaken(key, f"a list of words (known: {', '.join(known)})")
        for word in value:
            if word not in known:
                self.wrong(key, f"{key} has '{word}'{nearest(word, known)} (known: {', '.join(known)})")
        return value

    def table(self, key: str) -> Table | None:
        """A table inside this one, or None."""
        if key not in self.values:
            return None
        if not isinstance(self.values[key], dict):
            self._mistaken(key, f"a table, as [{key}]")
        return Table(self.path, (*self.keys, key), self.values[key], self.lines)

    def tables(self, key: str) -> list[Table]:
        """An array of tables, which may be missing."""
        entries = self.values.get(key, [])
        if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
            self._mistaken(key, f"tables, each under [[{key}]]")
        return [Table(self.path, (*self.keys, key, i), entry, self.lines) for i, entry in enumerate(entries)]

    def choice(self, key: str, known: Iterable[str], default: str | None = None) -> str:
        """One of some words; needed unless there is a default."""
        known = tuple(known)
        if default is None:
            self.required(key)
        value = self.text(key, default or "")
        if value not in known:
            self.wrong(key, f"{key} is '{value}'{nearest(value, known)} (known: {', '.join(known)})")
        return value

    def file(self, key: str) -> Path:
        """A file, named relative to the folder of this one."""
        self.required(key)
        path = self.path.parent / self.text(key)
        if not is_file(path):
            self.wrong(key, f"{key} names '{self.text(key):.80}', which is not in {self.path.parent}; check the name")
        return path

    def _mistaken(self, key: str, wanted: str) -> NoReturn:
        shown = repr(self.values.get(key))
        self.wrong(key, f"{key} is {shown if len(shown) < 60 else shown[:56] + ' ...'}; give {wanted}")


def _is_number(value: object) -> bool:
    # Whole numbers of any length are TOML: those beyond a float's range are as little use as infinity.
    return isinstance(value, int | float) and not isinstance(value, bool) and -LARGEST <= value <= LARGEST


_LONG_KEY = re.compile(r"""(?<![\w.-])(?:(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+)""" + f"{{{LONGEST_KEY}}}")
"""So many names with dots between them; possessive, so that no text takes long to be looked through."""


def read_tables(path: Path) -> Table:
    """The top table of a TOML file."""
    data = read(path, "scene file", SCENE_BYTES)
    try:
        text = data.decode("utf-8-sig")
        if _LONG_KEY.search(text):
            raise AnamorphError(f"{path}: has a key of more than {LONGEST_KEY} names; write it in tables")
        values = tomllib.loads(text)
    except UnicodeDecodeError:
        raise AnamorphError(f"{path}: is not text in UTF-8; save it as such") from None
    except AnamorphError:
        raise
    except (ValueError, RecursionError) as error:
        # A whole number of thousands of digits is valid, and no Python number.
        told = "a number has too many digits" if "digits" in str(error) else error
        raise AnamorphError(f"{path}: is not TOML: {told}") from None
    return Table(path, (), values, key_lines(text))
