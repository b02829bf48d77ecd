"""A method of another package: the example that docs/methods.md leads to, found by its entry point and drawn."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from scenes import CAMERA, spherical_mirror

from anamorph.base.errors import AnamorphError
from anamorph.gallery.solids import grid
from anamorph.methods.registry import GROUP, OWN, Registry
from anamorph.scene.model import Diffuse, Scene

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "parallax_cube_map"
PROJECT = tomllib.loads((EXAMPLE / "pyproject.toml").read_text())
SIZE = (160, 120)
RADIUS = 1.4
CELLS = 8
LOW, HIGH = np.array([-1.5, 0.0, -1.0]), np.array([1.2, 1.9, 2.0])
"""The box that the scene is, around a mirror in the middle of it."""


def installed(directory: Path, name: str, entries: dict[str, str]) -> None:
    """What an installer leaves of a package beside its modules."""
    folder = directory / f"{name.replace('-', '_')}-0.1.0.dist-info"
    folder.mkdir(parents=True)
    (folder / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 0.1.0\n")
    lines = [f"{method} = {value}" for method, value in entries.items()]
    (folder / "entry_points.txt").write_text("\n".join([f"[{GROUP}]", *lines, ""]))


def run(directory: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Another Python that finds the example installed in `directory`."""
    installed(directory, PROJECT["project"]["name"], PROJECT["project"]["entry-points"][GROUP])
    paths = [str(directory), str(EXAMPLE), *sys.path]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))}
    return subprocess.run([sys.executable, *arguments], env=environment, capture_output=True, text=True, check=False)


def boxed() -> Scene:
    """A convex mirror in a closed box, each of whose walls is an object."""
    x, y, z = np.diag(HIGH - LOW)
    places = [(LOW, y, z), (LOW, z, x), (LOW, x, y), (HIGH, -z, -y), (HIGH, -x, -z), (HIGH, -y, -x)]
    colors = np.random.default_rng(3).uniform(0.1, 0.9, (6, 3)).tolist()
    walls = [
        grid(tuple(corner.tolist()), tuple(along.tolist()), tuple(up.tolist())).mesh(
            f"wall-{number}", Diffuse(color=color)
        )
        for number, ((corner, along, up), color) in enumerate(zip(places, colors, strict=True))
    ]
    return Scene("box", (spherical_mirror(RADIUS, CELLS), *walls), CAMERA)


DRAWING = """
import sys, json, numpy as np
sys.path[:0] = sys.argv[2:]
from test_outside_method import SIZE, boxed
import anamorph as an
from anamorph.measure.errors import measure
scene = boxed()
truth, *frames = (an.render(scene, method, size=SIZE, seen=True) for method in ("raytrace", "parallax", "environment"))
told = {"methods": list(an.METHODS)}
for name, frame in zip(("parallax", "environment"), frames):
    errors = measure(truth, frame)
    inside = errors.maps.specular & ~errors.maps.silhouette
    told[name] = [float(np.percentile(errors.maps.angular[inside], share)) for share in (50, 95, 100)]
    told[name + " other"] = float((frame.object_id != truth.object_id)[inside].mean())
    told[name + " color"] = float(np.abs(frame.color - truth.color)[inside].max())
json.dump(told, open(sys.argv[1], "w"))
"""


@pytest.fixture(scope="module")
def told(tmp_path_factory) -> dict:
    directory = tmp_path_factory.mktemp("site")
    here = [str(Path(__file__).parent), str(Path(__file__).parents[1])]
    done = run(directory, "-c", DRAWING, str(directory / "told.json"), *here)
    assert done.returncode == 0, done.stderr
    return json.loads((directory / "told.json").read_text())


def bound() -> float:
    """The greatest angle, radians, by which the mirror's mesh alone can mislead a method that is exact for each ray.

    A fragment lies on a triangle, up to its circumradius squared over 2 R below the sphere. Its interpolated normal is
    the sphere's own normal above it, because on a sphere normals are as linear as places. So all that is wrong is
    where on the sphere the eye's ray is thought to meet it: at an angle of incidence a, s = depth / cos(a) too far.
    That turns the normal by s sin(a) / R and the reflected ray by twice that, and moves its origin by s sin(2 a) beside
    the ray, which at the distance D of the nearest wall is an angle of s sin(2 a) / D.
    """
    mesh = spherical_mirror(RADIUS, CELLS)
    corners = np.asarray(mesh.positions, float)[mesh.faces]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    depth = (np.prod(sides, axis=1) / (4.0 * area)).max() ** 2 / (2.0 * RADIUS)
    nearest = min((mesh.positions - LOW).min(), (HIGH - mesh.positions).min())
    looks = np.asarray(mesh.positions, float) - CAMERA.position
    cosine = -np.einsum("ij,ij->i", looks, mesh.normals) / np.linalg.norm(looks, axis=1)
    angle = np.arccos(cosine.min())
    too_far = depth / np.cos(angle)
    return 2.0 * too_far * np.sin(angle) / RADIUS + too_far * np.sin(2.0 * angle) / nearest


def test_it_is_found_by_its_entry_point(told):
    assert told["methods"] == [*OWN, "parallax"]


def test_in_a_box_it_is_exact_up_to_the_mesh_of_the_mirror(told):
    assert told["parallax"][2] <= 1000.0 * bound() < 2.0
    assert told["parallax other"] == 0.0


def test_it_beats_a_plain_cube_map_where_the_scene_is_a_box(told):
    assert told["parallax"][1] < 0.02 * told["environment"][1]
    assert told["parallax color"] < 0.02 < told["environment color"]


def test_the_command_line_finds_it(tmp_path):
    done = run(tmp_path, "-m", "anamorph", "info")
    assert "threeray, virtual, parallax" in done.stdout, done.stderr
    done = run(tmp_path / "again", "-m", "anamorph", "render", "car-mirror", "-m", "parallax:face=10", "-o", "a.png")
    assert done.returncode == 2 and "parallax: face is 10; give a number of texels" in done.stderr


def test_the_package_itself_may_be_imported_first(tmp_path):
    done = run(
        tmp_path, "-c", "import parallax_cube_map as p, anamorph as an; assert an.METHODS['parallax'] is p.METHOD"
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("module", "said"),
    [
        ("raise OSError('no such\\ndriver')", "OSError: no such driver"),
        ("import does_not_exist", "does_not_exist"),
        ("", "METHOD"),
        ("METHOD = 3", "is not a Method of that name"),
        ("from anamorph.methods.raytrace import METHOD", "is not a Method of that name"),
    ],
)
def test_a_broken_package_is_told_only_to_who_asks_for_its_method(tmp_path, monkeypatch, module, said):
    name = f"broken_{abs(hash(module))}"
    (tmp_path / f"{name}.py").write_text(module)
    installed(tmp_path, "broken-package", {"broken": f"{name}:METHOD"})
    monkeypatch.syspath_prepend(tmp_path)
    methods = Registry()
    assert list(methods) == list(OWN) and methods["pervertex"].name == "pervertex"
    with pytest.raises(AnamorphError, match="method broken: ") as caught:
        methods["broken"]
    assert "broken-package" in str(caught.value) and said in str(caught.value) and "\n" not in str(caught.value)
    assert "unknown" not in methods


@pytest.mark.parametrize("name", ["parallax", "pervertex"])
def test_a_name_that_two_packages_claim_is_refused(tmp_path, monkeypatch, name):
    monkeypatch.syspath_prepend(EXAMPLE)
    monkeypatch.syspath_prepend(tmp_path)
    for package in ("one", "other")[: 2 if name == "parallax" else 1]:
        installed(tmp_path, package, {name: "parallax_cube_map:METHOD"})
    methods = Registry()
    with pytest.raises(AnamorphError, match=f"method {name}: .*one.* both bring it") as caught:
        methods[name]
    assert "\n" not in str(caught.value)
    assert name not in list(methods) and "raytrace" in list(methods)
