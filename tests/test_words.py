"""One word, one thing: the names of the package, and the words of its glossary."""

from __future__ import annotations

import ast
import fnmatch
import io
import re
import tokenize
from collections import defaultdict
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "src" / "anamorph"
MODULES = sorted(PACKAGE.rglob("*.py"))
PAGES = sorted([ROOT / "README.md", *ROOT.glob("docs/*.md")])
GLOSSARY = ROOT / "docs" / "glossary.md"

SAME_CLASSES = {
    "Options": "each method has its own, and they are never imported together",
}
"""Classes of one name, and why they may have it."""

SAME_MODULES = {
    "choice": "of a backend for the viewer, and what auto chooses between",
    "deforming": "a scene of the gallery, and the benchmark that draws it",
    "errors": "errors that are raised, and errors that are measured",
    "finding": "what most methods are, and what of them is per-vertex drawing's",
    "options": "how a method declares its options, and those of one",
    "opening": "opens files, and is the panel's page for it",
    "textures": "the gallery's images, and the device's textures",
    "turntable": "the command, and what it calls",
    "visibility": "the buffer that methods fill, and the pieces in which trilinear projection finds what is seen",
}
"""Modules of one name in several rooms, and why they may have it."""


@dataclass(frozen=True)
class Replaced:
    """A word that another has replaced in some files: in identifiers, and unless `prose` is false in all text."""

    old: str
    new: str
    files: tuple[str, ...]
    prose: bool = True


VIEWER, MEASURE = "src/anamorph/viewer/*", "src/anamorph/measure/*"

REPLACED = (
    Replaced("layer", "aspect, or false-colour image", (VIEWER, MEASURE, "docs/viewer.md", "docs/measuring.md")),
    Replaced("layers", "aspects, or false-colour images", (VIEWER, MEASURE, "docs/viewer.md", "docs/measuring.md")),
    Replaced("hollow", "concave", (VIEWER, MEASURE, "docs/viewer.md", "docs/measuring.md")),
    Replaced("wires", "wireframe", (VIEWER, "docs/viewer.md")),
    Replaced("report", "snapshot", (VIEWER, "docs/viewer.md")),
    Replaced("room", "space", ("src/anamorph/viewer/panel/*",)),
    Replaced("specs", "methods", (MEASURE,)),
    Replaced("beginning", "start", ("src/anamorph/viewer/backends/*", "src/anamorph/viewer/starting.py")),
    Replaced("tell", "report", (VIEWER, MEASURE), prose=False),
    Replaced("told", "what it is, as failure_text", (VIEWER, MEASURE), prose=False),
)


def test_no_two_public_classes_have_one_name() -> None:
    places = defaultdict(set)
    for module in MODULES:
        for node in ast.walk(ast.parse(module.read_text())):
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                places[node.name].add(module.relative_to(PACKAGE).as_posix())
    assert {name for name, where in places.items() if len(where) > 1} == SAME_CLASSES.keys(), places


def test_no_two_modules_have_one_name() -> None:
    """A method's door is called as the method: its main module may be, too."""
    places = defaultdict(list)
    for module in MODULES:
        if not module.stem.startswith("__"):
            places[module.stem].append(module.relative_to(PACKAGE).as_posix())
    assert {name for name, where in places.items() if len(where) > 1} == SAME_MODULES.keys(), places


@pytest.mark.parametrize("replaced", REPLACED, ids=lambda each: each.old)
def test_a_word_that_was_replaced_is_gone(replaced: Replaced) -> None:
    found = []
    for path in (*MODULES, *PAGES):
        name = path.relative_to(ROOT).as_posix()
        if any(fnmatch.fnmatch(name, each) for each in replaced.files):
            identifiers, prose = words(path)
            found += [f"{name}: {word}" for word in identifiers if replaced.old in parts(word)]
            if replaced.prose:
                found += [name] * bool(re.search(rf"\b{replaced.old}\b", prose, re.IGNORECASE))
    assert not found, f"'{replaced.old}' is said '{replaced.new}': {found}"


@cache
def words(path: Path) -> tuple[frozenset[str], str]:
    """The identifiers of a file, and all its prose: a module's strings and comments, or a page's text."""
    text = path.read_text()
    if path.suffix == ".md":
        return frozenset(), text
    tokens = list(tokenize.generate_tokens(io.StringIO(text).readline))
    names = frozenset(token.string for token in tokens if token.type == tokenize.NAME)
    return names, "\n".join(token.string for token in tokens if token.type in (tokenize.STRING, tokenize.COMMENT))


def parts(identifier: str) -> list[str]:
    """The words of an identifier, small: those of "_SkyImage" are "sky" and "image"."""
    return [part.lower() for part in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", identifier)]


def test_an_identifier_is_read_word_by_word() -> None:
    assert parts("_heat_layer") == ["heat", "layer"]
    assert parts("LayerTexture") == ["layer", "texture"]
    assert parts("GPUBuffer.told2") == ["gpu", "buffer", "told"]
    assert parts("STATUS_NAMES") == ["status", "names"]


def glossary_rows() -> list[list[str]]:
    lines = [line for line in GLOSSARY.read_text().splitlines() if re.match(r"\| (?!word |---)", line)]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def test_every_word_of_the_glossary_has_one_meaning() -> None:
    rows = glossary_rows()
    assert all(len(row) == 3 and row[1].endswith((".", ".)")) for row in rows)
    given = [word for row in rows for word in row[0].split(", ")]
    assert len(given) == len(set(given)) >= 60


def test_what_the_glossary_names_in_the_code_is_there() -> None:
    known = names_of_the_package()
    named = [name for row in glossary_rows() for name in re.findall(r"`([^`]+)`", row[2])]
    assert len(named) >= 40
    assert [name for name in named if name not in known] == []


@cache
def names_of_the_package() -> frozenset[str]:
    """Modules, and what each of them defines: classes with their fields and methods, functions and constants."""
    names = set()
    for module in MODULES:
        dotted = ".".join(module.relative_to(PACKAGE.parent).with_suffix("").parts)
        names.add(dotted.removesuffix(".__init__"))
        for node in ast.parse(module.read_text()).body:
            names |= set(defined(node))
            if isinstance(node, ast.ClassDef):
                names |= {f"{node.name}.{name}" for member in node.body for name in defined(member)}
    return frozenset(names)


def defined(node: ast.stmt) -> list[str]:
    """The names that a statement defines."""
    if isinstance(node, (ast.ClassDef, ast.FunctionDef)):
        return [node.name]
    targets = [node.target] if isinstance(node, ast.AnnAssign) else getattr(node, "targets", [])
    return [target.id for target in targets if isinstance(target, ast.Name)]
