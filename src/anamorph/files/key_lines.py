"""On which lines the keys of a TOML document stand: the standard reader tells only their values."""

from __future__ import annotations

Keys = tuple[str | int, ...]
"""The way to a value: names of tables and keys, and numbers of entries in arrays of tables."""


def key_lines(text: str) -> dict[Keys, int]:
    """The line, from 1, of every table and of every key that starts a line in a valid TOML document."""
    lines: dict[Keys, int] = {}
    counts: dict[Keys, int] = {}
    table: Keys = ()
    depth, quote = 0, ""
    for number, line in enumerate(text.splitlines(), start=1):
        stripped = line.strip()
        if depth == 0 and not quote and stripped and not stripped.startswith("#"):
            if stripped.startswith("["):
                double = stripped.startswith("[[")
                table = _resolved(_split_key(stripped.lstrip("[ ")), counts, double)
                lines.setdefault(table, number)
                continue
            lines.setdefault((*table, *_split_key(stripped)), number)
        depth, quote = _after(line, depth, quote)
    return lines


def _resolved(names: Keys, counts: dict[Keys, int], double: bool) -> Keys:
    """The keys of a table's heading, with the number of the latest entry after each array of tables."""
    keys: Keys = ()
    for name in names:
        keys = (*keys, name)
        if double and len([part for part in keys if isinstance(part, str)]) == len(names):
            counts[keys] = counts.get(keys, -1) + 1
        if keys in counts:
            keys = (*keys, counts[keys])
    return keys


def _split_key(text: str) -> Keys:
    """The dotted key that `text` starts with."""
    names: list[str] = []
    name, quote = "", ""
    for letter in text:
        if quote:
            quote, name = ("", name) if letter == quote else (quote, name + letter)
        elif letter in "\"'":
            quote = letter
        elif letter == ".":
            names, name = [*names, name], ""
        elif letter in "=]":
            break
        elif not letter.isspace():
            name += letter
    return (*names, name)


def _after(line: str, depth: int, quote: str) -> tuple[int, str]:
    """How many brackets, and which multi-line quote, are open after `line`."""
    at = 0
    while at < len(line):
        triple, letter = line[at : at + 3], line[at]
        if quote:
            if letter == "\\" and quote.startswith('"'):
                at += 2
                continue
            if line.startswith(quote, at):
                at += len(quote)
                quote = ""
                continue
        elif triple in ('"""', "'''"):
            quote = triple
            at += 3
            continue
        elif letter in "\"'":
            quote = letter
        elif letter == "#":
            break
        else:
            depth += (letter in "[{") - (letter in "]}")
        at += 1
    return depth, quote if len(quote) == 3 else ""
