"""What shaders declare: structures with offsets and sizes by WGSL's rules of alignment, constants and bindings."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import anamorph

PACKAGE = Path(anamorph.__file__).parent

Declarations = dict[str, list[tuple[str, str]]]
"""Of structures by name: the names and types of their members."""

SCALARS = {"f32": "f", "i32": "i", "u32": "u"}


@dataclass(frozen=True)
class Layout:
    """How a type lies in a buffer; everything in bytes.

    Parameters
    ----------
    size, alignment : int
    words : tuple of (int, str)
        The offset of each number, and "f", "i" or "u".
    members : dict of str to int
        The offsets of a structure's members.
    """

    size: int
    alignment: int
    words: tuple[tuple[int, str], ...]
    members: dict[str, int]

    @property
    def stride(self) -> int:
        """From one element of an array to the next."""
        return rounded_up(self.size, self.alignment)


def rounded_up(value: int, alignment: int) -> int:
    return -(-value // alignment) * alignment


def without_comments(text: str) -> str:
    return re.sub(r"//.*", "", text)


def declared(text: str) -> Declarations:
    """The structures that a shader's text declares."""
    found: Declarations = {}
    for name, body in re.findall(r"\bstruct\s+(\w+)\s*\{(.*?)\}", without_comments(text), re.DOTALL):
        members = re.findall(
            r"(?:@\w+(?:\([^)]*\))?\s*)*(\w+)\s*:\s*(\w+(?:<[^;]*?>)?)\s*(?:,(?![^<]*>)|$)", body.strip()
        )
        found[name] = members
    return found


def layout_of(kind: str, structures: Declarations) -> Layout:
    """How a type lies in a buffer, by its name: WGSL, section 14.4.1, "Alignment and Size"."""
    if kind in SCALARS:
        return Layout(4, 4, ((0, SCALARS[kind]),), {})
    if vector := re.fullmatch(r"vec([234])(?:([fiu])|<(\w+)>)", kind):
        count, letter = int(vector[1]), vector[2] or SCALARS[vector[3]]
        return Layout(4 * count, 8 if count == 2 else 16, tuple((4 * word, letter) for word in range(count)), {})
    if matrix := re.fullmatch(r"mat([234])x([234])f", kind):
        return layout_of(f"array<vec{matrix[2]}f, {matrix[1]}>", structures)
    if array := re.fullmatch(r"array<(.+),\s*(\d+)>", kind):
        element, count = layout_of(array[1].strip(), structures), int(array[2])
        words = tuple((element.stride * i + offset, letter) for i in range(count) for offset, letter in element.words)
        return Layout(element.stride * count, element.alignment, words, {})
    end, alignment, words, members = 0, 4, [], {}
    for name, member in structures[kind]:
        inner = layout_of(member, structures)
        members[name] = start = rounded_up(end, inner.alignment)
        words += [(start + offset, letter) for offset, letter in inner.words]
        end, alignment = start + inner.size, max(alignment, inner.alignment)
    return Layout(rounded_up(end, alignment), alignment, tuple(words), members)


def constants(text: str) -> dict[str, float]:
    """The numbers that a shader's text declares as constants."""
    found = re.findall(r"^const\s+(\w+)\s*=\s*([^;(]+);", without_comments(text), re.MULTILINE)
    return {name: float(int(value.rstrip("u"), 0) if "x" in value else value.rstrip("uif")) for name, value in found}


def bound(text: str) -> Iterator[str]:
    """The types of the buffers that a shader's text binds, without the arrays around them."""
    for kind in re.findall(r"\bvar<(?:uniform|storage)[^>]*>\s*\w+\s*:\s*([^;]+);", without_comments(text)):
        array = re.fullmatch(r"array<([^,]+)(?:,\s*\d+)?>", kind.strip())
        yield array[1].strip() if array else kind.strip()


def texts(room: str) -> str:
    """All shaders that lie in a room of the package."""
    return "\n".join(path.read_text("utf-8") for path in sorted((PACKAGE / room).glob("*.wgsl")))


def rooms() -> list[str]:
    """The rooms that have shaders."""
    return sorted({str(path.parent.relative_to(PACKAGE)) for path in PACKAGE.rglob("*.wgsl")})
