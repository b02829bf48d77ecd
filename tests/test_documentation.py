"""What the pages say is true: programs and commands run, links and images are there, names are those of the code."""

from __future__ import annotations

import ast
import dataclasses
import importlib
import inspect
import re
import runpy
import shlex
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import trimesh
from viewer_hand import Hand

from anamorph import gallery
from anamorph.bench.thesis.printed import configurations
from anamorph.cli import commands as cli
from anamorph.measure.figures import ROWS
from anamorph.methods import METHODS
from anamorph.methods.registry import OWN
from anamorph.projection import camera_projection
from anamorph.scene.camera import Camera
from anamorph.viewer.backends import choice as backends
from anamorph.viewer.starting import Start

ROOT = Path(__file__).resolve().parents[1]
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/*.md")])
IMAGES = sorted(path for path in (ROOT / "docs" / "images").rglob("*") if path.is_file())
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))

SMALL = ("--size", "64x48")
"""Given last, so that it replaces the size in the text: fewer pixels take less time and understand the same words."""

VIEWS = "[view]\n" + 2 * "[[view.views]]\nposition = [0.4, 1.25, 0.3]\ntarget = [-0.6, 1.0, -0.45]\n"
"""What a scene file has to keep for a path through two views."""


def blocks(language: str) -> list[tuple[str, str]]:
    """Every fenced block in a language: where it stands, and its text."""
    found = []
    for page in PAGES:
        text = page.read_text()
        for block in re.finditer(rf"^```{language}\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
            line = text.count("\n", 0, block.start()) + 1
            found.append((f"{page.relative_to(ROOT)}:{line}", block[1]))
    return found


PROGRAMS = blocks("python")
COMMANDS = [
    pytest.param(line, id=f"{place} {line}")
    for place, text in blocks("sh")
    for line in text.splitlines()
    if not line.startswith("#")
]


MAKE_ONCE = cache(gallery.make)


@pytest.fixture(autouse=True)
def scenes_made_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Making a scene takes seconds, and it is the same scene every time."""
    monkeypatch.setattr(gallery, "make", MAKE_ONCE)


@pytest.fixture(autouse=True)
def viewers_are_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    """A viewer stays until its user has seen enough: here, a few frames."""

    def show(beginning: Start, *chosen: object, **named: object) -> None:
        assert not beginning.message
        Hand(beginning, (320, 240)).close()

    monkeypatch.setattr(backends, "show", show)


@pytest.mark.parametrize(("place", "program"), PROGRAMS, ids=[place for place, _ in PROGRAMS])
def test_a_program_in_a_page_runs_by_itself(place, program, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(compile(program, place, "exec"), {"__name__": "__main__"})
    saved = re.findall(r'\.save\("([^"]+)"\)', program)
    assert all((tmp_path / name).stat().st_size for name in saved)


@pytest.mark.parametrize("line", COMMANDS)
def test_a_command_in_a_page_works(line, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    program, *words = shlex.split(line)
    if program == "./run":
        assert re.search(rf"^{words[0]}\)$", (ROOT / "run").read_text(), re.MULTILINE)
        return
    assert program == "anamorph"
    for word in words:
        if word.endswith(".glb"):
            trimesh.creation.box((1.0, 2.0, 3.0)).export(word)
        if word.endswith(".toml"):
            Path(word).write_text('builtin = "car-mirror"\nname = "car-mirror"\n' + VIEWS)
    small = SMALL if words[0] in ("render", "compare", "turntable") else ()
    small = (*small, "--frames", "2") if words[0] == "turntable" else small
    assert cli.main([*words, *small]) == 0, capsys.readouterr().err
    outputs = re.findall(r"(?:-o|--json|--html) (\S+)|=(\S+\.npy)", line)
    assert all(Path(first or second).stat().st_size for first, second in outputs)


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.name)
def test_an_example_is_short_and_runs(example, tmp_path, monkeypatch):
    assert len(example.read_text().splitlines()) < 60
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(example), run_name="__main__")
    assert list(tmp_path.iterdir())


def links(page: Path) -> list[str]:
    text = re.sub(r"^```.*?^```$", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)
    return [link for link in re.findall(r"\]\(([^)\s]+)\)", text) if not link.startswith("https://")]


def headings(page: Path) -> set[str]:
    """The names under which a page's headings can be linked to."""
    titles = re.findall(r"^#+ (.+)$", page.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.name)
def test_every_link_leads_somewhere(page):
    for link in links(page):
        path, _, heading = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        assert target.exists(), f"{page.name}: {link}"
        assert target.is_relative_to(ROOT), f"{page.name}: {link}"
        assert not heading or heading in headings(target), f"{page.name}: {link}"


def test_every_image_is_shown_and_all_are_small():
    shown = {(page.parent / link).resolve() for page in PAGES for link in links(page)}
    assert set(IMAGES) <= shown
    sizes = {image: image.stat().st_size for image in IMAGES}
    assert max(sizes.values()) < 250_000
    for folder in {image.parent for image in IMAGES}:
        assert sum(size for image, size in sizes.items() if image.parent == folder) < 1_200_000


PAPERS = {
    "pvrr": (range(3, 17), "figure-{:02}.webp"),
    "threeray": (range(1, 7), "figure-{}.webp"),
    "virtual": ((4, 6, 7, 8), "figure-{}.webp"),
}
"""Pages of figures of papers: which figures, and the names of their images."""


@pytest.mark.parametrize("page", PAPERS)
def test_the_papers_figures_are_all_there_each_with_its_section_and_module(page):
    text, (numbers, image) = (ROOT / "docs" / f"{page}.md").read_text(), PAPERS[page]
    parts = {int(number): part for number, part in re.findall(r"^## Figure (\d+):(.*?)(?=^## |\Z)", text, re.M | re.S)}
    assert sorted(parts) == list(numbers)
    for number, part in parts.items():
        assert f"(images/{page}/{image.format(number)})" in part
        assert re.search(r"^Sections? \d", part, re.M) and "(../src/anamorph/" in part


@pytest.fixture
def figures(monkeypatch):
    """The modules beside the pages that draw their figures."""
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    return importlib.import_module("figures.diagram")


def test_a_diagrams_rods_reach_from_end_to_end_at_their_radius(figures):
    ends = np.array([[[0.0, 0.0, 0.0], [0.0, 2.0, 0.0]], [[1.0, 1.0, 1.0], [4.0, 5.0, 1.0]]])
    mesh = figures.rods(ends, 0.1, (1.0, 0.0, 0.0), "rods")
    points = mesh.positions.reshape(2, 2, -1, 3)
    assert np.linalg.norm(points - ends[:, :, None], axis=-1) == pytest.approx(0.1, abs=1e-6)
    along = ends[:, 1] - ends[:, 0]
    assert np.einsum("nesi,ni->nes", points - ends[:, :, None], along) == pytest.approx(0.0, abs=1e-5)
    a, b, c = np.moveaxis(mesh.positions[mesh.faces], 1, 0)
    outward = np.einsum("fi,fi->f", np.cross(b - a, c - a), mesh.normals[mesh.faces].mean(axis=1))
    assert (outward > 0.0).all()


def test_a_diagrams_view_volume_is_that_of_the_projection(figures):
    camera = Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0), field_of_view=60.0)
    projection = camera_projection(camera, (200, 100))
    near, far = figures.volume(projection, 5.0)
    assert np.linalg.norm(far - near, axis=1) == pytest.approx(5.0)
    for corners in (near, far):
        x, y, _, w = projection.clip @ np.column_stack([corners, np.ones(4)]).T
        assert np.abs([x / w, y / w]) == pytest.approx(1.0, abs=1e-6)
    assert (far[:, 2] < near[:, 2]).all(), "the camera looks along -z"


def test_the_lens_of_the_figure_of_dispersion_takes_the_place_of_its_scenes_lens(figures):
    scene, words = importlib.import_module("figures.refraction").chromatic()
    names = [mesh.name for mesh in scene.meshes]
    assert len(set(names)) == len(names) and sum(name.startswith("lens/") for name in names) == 4
    assert "1.600, 1.606, 1.620" in words


@pytest.mark.parametrize("page", PAPERS)
def test_the_script_knows_every_figure_of_the_page(figures, page):
    known = runpy.run_path(str(ROOT / "docs" / f"make_{page}.py"))["FIGURES"]
    assert set(PAPERS[page][0]) <= set(known)
    # Others are ours, and are shown on the page.
    text = (ROOT / "docs" / f"{page}.md").read_text()
    assert all(f"(images/{page}/{PAPERS[page][1].format(number)})" in text for number in known)


def test_the_images_of_surface_cameras_are_those_that_the_script_makes(figures):
    known = runpy.run_path(str(ROOT / "docs" / "make_surface_cameras.py"))["FIGURES"]
    text = (ROOT / "docs" / "surface-cameras.md").read_text()
    assert sorted(re.findall(r"\(images/surface-cameras/([\w-]+)\.webp\)", text)) == sorted(known)


def test_the_tables_of_converging_rays_say_where_they_are_exact():
    text = (ROOT / "docs" / "surface-cameras.md").read_text()
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in text.splitlines() if line.startswith("| ")]
    mirrors = {row[0]: row[1:] for row in rows if len(row) == 5}
    assert all(float(error) <= 0.01 for error in mirrors["at the center"])
    assert float(mirrors["R/40 aside"][0]) > 0.1
    maps = [row for row in rows if len(row) == 7 and row[1] == "`inward`"]
    assert len(maps) == 3 and all(float(row[2]) <= 0.01 for row in maps)


@pytest.fixture
def thesis(figures):
    """The script that draws the figures of the thesis on trilinear projection."""
    return runpy.run_path(str(ROOT / "docs" / "make_trilinear.py"))


def test_the_theses_figures_are_all_there(thesis):
    text = (ROOT / "docs" / "trilinear.md").read_text()
    wanted = ["3.2", *(f"4.{k}" for k in range(1, 11)), "5.1", "6.4", "6.7", "6.9", "7.4", "7.5", "7.6"]
    assert list(thesis["FIGURES"]) == wanted
    for figure in wanted:
        path = thesis["image"](figure).relative_to(ROOT / "docs")
        assert f"({path})" in text
        assert (ROOT / "docs" / path).exists()


def test_the_table_of_trilinear_projection_says_that_it_is_exact():
    lines = section(ROOT / "docs" / "trilinear.md", "The figures").split("### How near")[1].splitlines()
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines if re.match(r"\| \d", line)]
    assert len(rows) == 23
    for name, _, triangles, p95, other, flip, straight, original in rows:
        assert p95 == "< 0.0001" or float(p95) <= 0.01, name
        assert int(triangles) >= 1 and float(other) == 0.0
        assert flip == "< 0.0001" or float(flip) < 0.3 * float(straight)
        assert (original != "") == name.startswith("7.")


def test_a_row_of_the_table_is_renewed_by_its_first_cell_alone(thesis):
    page = "text\n| 6.4 | old |\n| 6.7 | kept |\n"
    assert thesis["renewed"](page, ["| 6.4 | new |"]) == "text\n| 6.4 | new |\n| 6.7 | kept |\n"
    with pytest.raises(SystemExit, match=r"no row for 9\.9"):
        thesis["renewed"](page, ["| 9.9 | new |"])


def test_the_drawn_examples_have_the_shapes_of_their_labels_and_the_printed_numbers(figures):
    examples = importlib.import_module("figures.configurations")
    for label in [*examples.FIGURES.values(), "2,3"]:
        found = examples.example(label)
        shapes = found.shapes()
        assert sorted(len(shape) for shape in shapes) == sorted(int(count) for count in label.split(","))
        assert label == "2,3" or min(shape.t.min() for shape in shapes) > 0.0
        if label == "9":
            assert min((shapes[0].u.min(), shapes[0].v.min(), (1.0 - shapes[0].u - shapes[0].v).min())) > 0.0
            continue
        printed = configurations()[label]
        drawn = np.column_stack([found.corners, found.origins, found.directions])
        assert (np.array_equal(printed, drawn)) == (label not in ("4,5", "6,3"))
        assert np.abs(drawn[:, 3:] - printed[:, 3:]).max() <= 0.005
        assert np.allclose(drawn[:, :3], printed[:, :3], rtol=0.005)


def section(page: Path, title: str) -> str:
    return page.read_text().split(f"\n## {title}\n")[1].split("\n## ")[0]


def test_the_table_of_methods_names_them_all_with_their_modules_and_options():
    rows = [line.split("|")[1:-1] for line in section(ROOT / "README.md", "Methods").splitlines() if line[:3] == "| `"]
    assert sorted(row[0].strip(" `") for row in rows) == sorted(OWN)
    for row in rows:
        method = METHODS[row[0].strip(" `")]
        module = inspect.getsourcefile(method.open)
        assert module and (ROOT / links_in(row[1])[0]).samefile(module)
        shader = ROOT / links_in(row[2])[0]
        # What is found is coloured by the one pass of all methods, which stands beside the device.
        rooms = Path(module).parent, Path(module).parents[2] / "gpu", Path(module).parents[1] / "pervertex"
        assert shader.suffix == ".wgsl" and shader.parent in rooms[: 3 if method.name == "auto" else 2]
        assert re.findall(r"`(\w+)`", row[4]) == [field.name for field in dataclasses.fields(method.options)]


def links_in(cell: str) -> list[str]:
    return re.findall(r"\]\(([^)\s]+)\)", cell)


def test_the_table_of_figures_has_every_measure_and_its_competitor():
    table = section(ROOT / "README.md", "How far from the truth")
    labels = [line.split("|")[1].replace("`", "").strip() for line in table.splitlines() if line.startswith("|")][2:]
    assert len(labels) == len(ROWS)
    assert all(label.startswith(row.label) for label, row in zip(labels, ROWS, strict=True))
    assert "`raytrace`" in next(line for line in table.splitlines() if line.startswith("| |"))


def test_functions_are_where_the_pages_say():
    told = [
        (name.split("."), (page.parent / path).resolve())
        for page in PAGES
        for name, path in re.findall(r"`([\w.]+)` in\s+\[`[^`]+`\]\(([^)]+\.py)\)", page.read_text())
    ]
    assert len(told) >= 8
    for names, path in told:
        scope: ast.AST = ast.parse(path.read_text())
        for name in names:
            defined = {node.name: node for node in ast.walk(scope) if isinstance(node, (ast.FunctionDef, ast.ClassDef))}
            values = {target.id for node in ast.walk(scope) for target in assigned(node)}
            assert name in defined or name in values, f"{'.'.join(names)} is not in {path.name}"
            scope = defined.get(name, scope)


def assigned(node: ast.AST) -> list[ast.Name]:
    targets = [node.target] if isinstance(node, ast.AnnAssign) else getattr(node, "targets", [])
    return [target for target in targets if isinstance(target, ast.Name)]
