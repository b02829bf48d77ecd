"""The structure that keeps the code readable: who may import whom, and how long a file may be."""

from __future__ import annotations

import ast
import fnmatch
import graphlib
import re
import tomllib
from pathlib import Path

import pytest

from anamorph.methods.registry import OWN

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "src" / "anamorph"
MODULES = sorted(PACKAGE.rglob("*.py"))
TESTS = sorted((ROOT / "tests").rglob("*.py"))

ORDER = (
    "base", "surfaces", "scene", "lenses", "editing", "gallery", "files", "raymesh", "rays", "optics", "cameras",
    "projection", "frame", "gpu", "raytriangle", "methods", "inward", "measure", "reflections", "rendering", "viewer",
    "bench", "cli",
)  # fmt: skip
"""The rooms: each imports only itself and those that stand before it."""

ON_TOP = {"__init__", "__main__"}
"""What may import anything, and what nothing below imports."""

LOWEST = ("base", "surfaces", "scene")

NOT_BELOW = {"argparse", "OCP", "embreex", "wgpu", "rendercanvas", "imgui_bundle", "uvicorn"}
"""The command line, CAD, rays and the viewer: the lowest rooms know nothing of them."""

ACROSS = {("environment", "pervertex"), ("auto", "pervertex"), ("auto", "raytrace")}
"""Methods that import another: planar reflection is a special case of per-vertex reflection, and `auto` is a choice
between methods."""

OTHERS_OWN = {
    "_replace": "of named tuples, public by Python's own word",
    "_fields": "of named tuples, public by Python's own word",
    "_process_events": "rendercanvas: what its event loop calls",
    "_draw_frame": "rendercanvas: who draws on a canvas",
    "_canvas_context": "rendercanvas: whether a canvas has been drawn on",
    "_rfb_draw_requested": "rendercanvas: whether a page is to be sent an image",
    "_rfb_handle_msg": "rendercanvas: what a page says to a widget",
    "_css_width": "rendercanvas: the trait of a widget that pages read",
    "_css_height": "rendercanvas: the trait of a widget that pages read",
    "_css": "anywidget: what a page is styled with",
    "_esm": "anywidget: what a page runs",
}
"""Names with an underscore that tests may touch, of other packages, and why."""

REGISTRIES = re.compile(
    r"https?://[^\s\"'<>)]*(?:pypi|pythonhosted|npmjs|anaconda|crates\.io|debian\.org/debian|/simple\b)"
    r"|--(?:extra-)?index-url[ =]\S|--find-links[ =]\S",
    re.IGNORECASE,
)


def room(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imported_names(source: str) -> set[str]:
    """What a module's source imports, anywhere in it, by dotted names."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return names


def imported_places(source: str) -> set[tuple[str, ...]]:
    """What of this package a module's source imports, anywhere in it, as the parts of its dotted name."""
    return {tuple(name.split(".")[1:]) for name in imported_names(source) if name.startswith("anamorph.")}


def imported_rooms(source: str) -> set[str]:
    """The rooms of this package that a module's source imports."""
    return {place[0] for place in imported_places(source)}


@pytest.mark.parametrize("module", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_a_module_imports_only_rooms_that_stand_before_its_own(module: Path) -> None:
    here = room(module)
    if here not in ON_TOP:
        assert imported_rooms(module.read_text()) <= set(ORDER[: ORDER.index(here) + 1])


def test_every_room_is_placed() -> None:
    assert {room(module) for module in MODULES} == set(ORDER) | ON_TOP


@pytest.mark.parametrize("low", LOWEST)
def test_the_lowest_rooms_know_neither_command_line_nor_cad_nor_viewer(low: str) -> None:
    sources = [path.read_text() for path in (PACKAGE / low).rglob("*.py")]
    assert {name.split(".")[0] for source in sources for name in imported_names(source)} & NOT_BELOW == set()


def test_no_modules_import_each_other_in_a_circle() -> None:
    """Imports inside functions count: they hide a circle, and do not open it."""
    named = {path.relative_to(PACKAGE).with_suffix("").parts: path for path in MODULES if room(path) not in ON_TOP}
    known = {parts[:-1] if parts[-1] == "__init__" else parts: path for parts, path in named.items()}
    graph = {}
    for own, path in known.items():
        places = imported_places(path.read_text())
        found = {place if place in known else place[:-1] for place in places}
        graph[own] = (found & known.keys()) - {own}
    graphlib.TopologicalSorter(graph).prepare()


@pytest.mark.parametrize("method", OWN)
def test_no_method_imports_another(method: str) -> None:
    sources = [path.read_text() for path in (PACKAGE / "methods" / method).rglob("*.py")]
    others = {name for source in sources for name in imported_places(source) if name[0] == "methods"}
    assert {(method, name[1]) for name in others if name[1:] and name[1] in OWN and name[1] != method} <= ACROSS


@pytest.mark.parametrize("name", ["measure", "viewer", "bench", "cli"])
def test_a_room_is_entered_by_its_door(name: str) -> None:
    """What is not a method takes of a method, and of the tracer, only what the room's `__init__.py` offers."""
    rooms = (*OWN, "tracing")
    inside = {("methods", here, path.stem) for here in rooms for path in (PACKAGE / "methods" / here).iterdir()}
    for module in (PACKAGE / name).rglob("*.py"):
        taken = {place[:3] for place in imported_places(module.read_text())} & inside
        assert not taken, f"{module} imports {taken}"


@pytest.mark.parametrize("name", [*OWN, "tracing"])
def test_the_door_of_a_room_names_all_that_is_inside(name: str) -> None:
    door = ast.get_docstring(ast.parse((PACKAGE / "methods" / name / "__init__.py").read_text()))
    inside = {path.stem for path in (PACKAGE / "methods" / name).iterdir() if not path.name.startswith("__")}
    assert door and {stem for stem in inside if not re.search(rf"`{stem}(\.wgsl)?`", door)} == set()


def test_the_guard_sees_every_form_of_import() -> None:
    forms = (
        "import anamorph.gpu.device\nfrom anamorph import measure\ndef f():\n    from anamorph.cli.commands import main"
    )
    assert imported_rooms(forms) == {"gpu", "measure", "cli"}


@pytest.mark.parametrize(("suffix", "longest"), [(".py", 400), (".wgsl", 250)])
def test_files_stay_short_enough_to_read(suffix: str, longest: int) -> None:
    lines = {path.name: len(path.read_text().splitlines()) for path in PACKAGE.rglob(f"*{suffix}")}
    assert {name: count for name, count in lines.items() if count > longest} == {}


@pytest.mark.parametrize("said", ["(1024, 768)\n", "get_close_matches("])
def test_what_several_modules_need_is_said_in_one(said: str) -> None:
    assert len([module.name for module in MODULES if said in module.read_text()]) == 1


def private_names(source: str) -> set[str]:
    """Names with an underscore of which a module's source takes or replaces what is not its own."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Attribute) and not (
            isinstance(node.value, ast.Name) and node.value.id in ("self", "cls")
        ):
            names.add(node.attr)
        elif isinstance(node, ast.ImportFrom):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.Call) and "attr" in ast.unparse(node.func):
            texts = [each.value for each in node.args[:2] if isinstance(each, ast.Constant)]
            names |= {text.rpartition(".")[2] for text in texts if isinstance(text, str)}
    return {name for name in names if re.match(r"_[a-zA-Z]", name)}


@pytest.mark.parametrize("module", TESTS, ids=lambda path: str(path.relative_to(ROOT / "tests")))
def test_no_test_reaches_into_what_is_private(module: Path) -> None:
    assert private_names(module.read_text()) <= OTHERS_OWN.keys()


def test_the_guard_sees_every_way_to_reach_in() -> None:
    ways = (
        "from anamorph.rays import _near\nviewer._job.stop()\nsetattr(viewer, '_drawn', 1)\nself._own = 2\n"
        "monkeypatch.setattr('anamorph.viewer.looking._seen', 3)\nmonkeypatch.setattr(viewer, '_showing', 4)\n"
        "class Own:\n    def __init__(self):\n        self._x = super().__init__()"
    )
    assert private_names(ways) == {"_near", "_job", "_drawn", "_seen", "_showing"}


def test_no_module_uses_relative_imports() -> None:
    for module in MODULES:
        tree = ast.parse(module.read_text())
        relative = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.level]
        assert not relative, f"{module} hides from the guard of the rooms"


def project_files() -> list[Path]:
    ignored = {".git", ".venv", *(line.strip("/\n") for line in (ROOT / ".gitignore").read_text().splitlines())}
    return [
        path
        for path in ROOT.rglob("*")
        if path.is_file()
        and not any(fnmatch.fnmatch(part, name) for part in path.relative_to(ROOT).parts for name in ignored)
    ]


def test_no_file_names_a_package_registry() -> None:
    for path in project_files():
        found = REGISTRIES.search(path.read_text(errors="ignore"))
        assert not found or path == Path(__file__), f"{path}: {found and found[0]}"


def test_the_lock_carries_a_hash_for_every_package_and_names_every_dependency() -> None:
    lock = (ROOT / "requirements.lock").read_text().replace("\\\n", " ")
    entries = dict(re.findall(r"^([a-z0-9-]+)(==.*)$", lock, re.MULTILINE))
    assert all("--hash=sha256:" in entry for entry in entries.values())
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    wanted = project["project"]["dependencies"] + project["dependency-groups"]["dev"]
    assert {re.split(r"[<>=]", line)[0] for line in wanted} <= entries.keys()


def test_shaders_and_page_templates_are_package_data() -> None:
    patterns = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["package-data"]["anamorph"]
    packed = {path for pattern in patterns for path in PACKAGE.glob(pattern)}
    files = (path for path in PACKAGE.rglob("*") if path.is_file() and "__pycache__" not in path.parts)
    others = {path for path in files if path.suffix not in (".py", ".typed")}
    assert others <= packed, "some files would be left out of the wheel"
