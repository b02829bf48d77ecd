"""The command line end to end: what a user types, sees and gets."""

from __future__ import annotations

import io
import json
import os
import re
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
import trimesh
import wgpu
from PIL import Image
from rich.console import Console

import anamorph
from anamorph.base import progress
from anamorph.base.srgb import encode_srgb
from anamorph.cli import commands as cli
from anamorph.cli import demo
from anamorph.cli.arguments import make_parser
from anamorph.files.opening import open_scene
from anamorph.gallery import SCENES
from anamorph.measure import compare
from anamorph.measure.frame_times import timing_rounds
from anamorph.methods import METHODS
from anamorph.viewer.point_search import reflections_of

COMMAND = [sys.executable, "-m", "anamorph"]
PATIENCE = 600.0
"""Seconds until a command is taken to hang, on however busy a machine."""

HOME = Path(anamorph.__file__).resolve().parents[1]
"""Where the package that is tested lies, whatever relative path it was found by."""


def environment(**changed: str) -> dict[str, str]:
    """That of a user with no private run-time directory, from whichever directory the command is run."""
    path = os.pathsep.join([str(HOME), *filter(None, [os.environ.get("PYTHONPATH")])])
    kept = {name: value for name, value in os.environ.items() if name != "XDG_RUNTIME_DIR"}
    return kept | {"PYTHONPATH": path} | changed


def run(*arguments: str, directory: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run the command as a user whose output is piped would."""
    return subprocess.run(
        [*COMMAND, *arguments], capture_output=True, text=True, cwd=directory, env=environment(), timeout=PATIENCE
    )


def quiet_success(result: subprocess.CompletedProcess[str]) -> str:
    assert (result.returncode, result.stderr) == (0, "")
    return result.stdout


def one_line_error(result: subprocess.CompletedProcess[str]) -> str:
    assert result.returncode == 2, result.stderr
    assert result.stdout == ""
    assert result.stderr.startswith("anamorph: error: ")
    assert result.stderr.count("\n") == 1
    return result.stderr


def test_render_writes_an_image_and_what_each_pixel_sees(tmp_path):
    seen = [f"{name}={name}.npy" for name in ("position", "object_id", "specular", "status")]
    arguments = ("render", "car-mirror", "-m", "pervertex", "-o", "a.png", "--size", "160x120", "--seen", *seen)
    assert quiet_success(run(*arguments, directory=tmp_path)).startswith("pixels of mirrors and lenses: doubtful ")
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(
        ["a.png", "position.npy", "object_id.npy", "specular.npy", "status.npy"]
    )
    with Image.open(tmp_path / "a.png") as image:
        assert image.size == (160, 120)
        assert np.ptp(np.asarray(image)) > 100
    position, object_id, specular = (np.load(tmp_path / f"{n}.npy") for n in ("position", "object_id", "specular"))
    assert position.shape == (120, 160, 3)
    assert np.isfinite(position).all()
    assert object_id.shape == specular.shape == (120, 160)
    assert (specular != 0).any()


def test_what_each_pixel_sees_may_be_layers_of_an_exr_image(tmp_path):
    files = ("status=status.npy", "position", "object_id")
    options = ("-m", "raytrace", "-o", "a.exr", "--size", "64x48", "--seen", *files)
    quiet_success(run("render", "flat-mirror", *options, directory=tmp_path))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.exr", "status.npy"]
    channels = OpenEXR.File(str(tmp_path / "a.exr"), separate_channels=True).channels()
    assert channels.keys() == {"R", "G", "B", "position.X", "position.Y", "position.Z", "object_id"}
    assert all(channel.pixels.shape == (48, 64) for channel in channels.values())
    seen = channels["object_id"].pixels
    assert seen.dtype == np.uint32 and 0 < seen.max() < 10
    sky = np.stack([channels[f"position.{axis}"].pixels[seen == 0] for axis in "XYZ"])
    assert np.linalg.norm(sky, axis=0) == pytest.approx(1.0, abs=1e-5)


def test_a_scene_is_exported_and_the_file_drawn(tmp_path):
    told = quiet_success(run("export", "flat-mirror", "-o", "a.glb", directory=tmp_path))
    assert told.endswith("parts, as triangles; sky and ambient light have no place in glTF\n")
    quiet_success(run("render", "a.glb", "-o", "a.png", "--size", "32x24", directory=tmp_path))


def test_what_is_left_out_of_a_model_is_told_in_one_line(tmp_path):
    box = trimesh.creation.box()
    material = trimesh.visual.material.PBRMaterial(name="chrome", metallicFactor=1.0, roughnessFactor=0.1)
    box.visual = trimesh.visual.TextureVisuals(material=material, uv=np.zeros((len(box.vertices), 2)))
    trimesh.Scene({"box": box}).export(tmp_path / "box.glb")
    result = run("export", "box.glb", "-o", "a.glb", directory=tmp_path)
    assert result.returncode == 0
    assert result.stderr == "anamorph: note: box.glb: left out: the roughness of mirrors (material 'chrome')\n"


def test_render_shows_a_model_with_no_scene_file_and_keeps_linear_floats(tmp_path):
    trimesh.creation.box((1.0, 2.0, 3.0)).export(tmp_path / "box.glb")
    options = ("-m", "raytrace", "-o", "a.npy", "--size", "64x48", "--samples", "2")
    quiet_success(run("render", "box.glb", *options, directory=tmp_path))
    image = np.load(tmp_path / "a.npy")
    assert image.shape == (48, 64, 3)
    assert image.dtype == np.float32
    assert np.isfinite(image).all()


def test_compare_prints_a_table_and_writes_json_and_a_page(tmp_path):
    method = "pervertex:antialias=4"
    outputs = ("--json", "a.json", "--html", "a.html")
    table = quiet_success(
        run("compare", "spheres", "-m", method, "-m", "environment", "--size", "96x64", *outputs, directory=tmp_path)
    )
    assert method in table
    assert "mrad" in table
    figures = json.loads((tmp_path / "a.json").read_text())
    assert figures["size"] == [96, 64]
    assert list(figures["methods"]) == [method, "environment", "raytrace"]
    assert figures["command"].startswith("anamorph compare spheres -m pervertex:antialias=4")
    assert figures["methods"]["raytrace"]["angular_mrad"]["max"] < 0.01
    assert figures["methods"]["environment"]["angular_mrad"]["median"] > 0.0
    assert all(result["frame_ms"]["n"] >= 30 for result in figures["methods"].values())
    page = (tmp_path / "a.html").read_text()
    assert page.startswith("<!doctype html>")
    assert figures["command"] in page


def test_turntable_writes_a_video_or_a_folder_and_says_which(tmp_path):
    options = ("--size", "48x32", "--frames", "3")
    told = quiet_success(
        run("turntable", "flat-mirror", "-o", "a.webp", "--swing", "10", "--samples", "2", *options, directory=tmp_path)
    )
    assert told == "saved a.webp\n"
    with Image.open(tmp_path / "a.webp") as video:
        assert (video.size, video.n_frames) == ((48, 32), 3)
    told = quiet_success(
        run("turntable", "flat-mirror", "-m", "raytrace", "-o", "a", *options[:2], "--frames", "2", directory=tmp_path)
    )
    assert told == "saved a\n"
    assert sorted(path.name for path in (tmp_path / "a").iterdir()) == ["frame-0001.png", "frame-0002.png"]
    drawn = anamorph.render("flat-mirror", "raytrace", size=(48, 32)).color
    first = np.asarray(Image.open(tmp_path / "a" / "frame-0001.png"))
    assert np.abs(encode_srgb(np.clip(drawn, 0, 1).astype(float)) - first / 255.0).max() < 2.0 / 255.0


def test_reflections_are_printed_and_marked_in_an_image(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    place = ("--point", "-0.2", "1.2", "2")
    options = ("-m", "raytrace", "--size", "160x120")
    assert cli.main(["reflections", "flat-mirror", *place, *options, "-o", "a.png"]) == 0
    printed = capsys.readouterr().out
    scene, size = open_scene("flat-mirror")[0], (160, 120)
    found = reflections_of(scene, scene.camera, size, (-0.2, 1.2, 2.0))
    (only,) = found.found
    assert [f"{value:.2f}" in printed for value in only.pixel] == [True, True]
    assert f"{only.length:.4f}" in printed and "right way round" in printed and "All are found." in printed
    with Image.open(tmp_path / "a.png") as image:
        assert image.size == size
        marked = np.asarray(image).astype(int)
    plain = np.round(255.0 * encode_srgb(np.clip(anamorph.render(scene, "raytrace", size=size).color, 0, 1)))
    changed = np.abs(marked - plain).max(axis=2) > 8
    x, y = map(int, only.pixel)
    assert changed[y, x] and changed.mean() < 0.2
    assert marked[y, x].tolist() == pytest.approx([255, 196, 0], abs=60)


def test_a_view_of_nothing_named_is_that_of_the_first_scene():
    named = make_parser().parse_args(["view"])
    assert named.scene == next(iter(SCENES)) == "car-mirror"
    assert make_parser().parse_args(["view", "room", "--port", "1"]).scene == "room"


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="elsewhere a driver cannot be hidden")
@pytest.mark.parametrize(
    "arguments", [("view", "--backend", "browser"), ("turntable", "flat-mirror", "-o", "a.webm", "--size", "32x24")]
)
def test_without_an_adapter_a_command_that_draws_is_refused_in_one_line(arguments, tmp_path):
    hidden = environment(VK_DRIVER_FILES="/none", VK_ICD_FILENAMES="/none")
    result = subprocess.run(
        [*COMMAND, *arguments], capture_output=True, text=True, cwd=tmp_path, env=hidden, timeout=PATIENCE
    )
    assert "no Vulkan, Metal or DirectX 12 adapter: install" in one_line_error(result)
    assert os.listdir(tmp_path) == []


def test_scenes_are_listed_one_a_line():
    lines = quiet_success(run("scenes")).splitlines()
    assert {"car-mirror", "spheres", "room"} <= {line.split()[0] for line in lines}
    assert all(len(line.split()) > 3 for line in lines)


def test_info_tells_the_adapter_and_every_version():
    facts = dict(line.split(maxsplit=1) for line in quiet_success(run("info")).splitlines())
    assert {"adapter", "anamorph", "wgpu", "embreex", "trimesh", "numpy", "python", "methods"} <= facts.keys()
    assert facts["python"] == ".".join(str(part) for part in sys.version_info[:3])
    assert list(METHODS) == facts["methods"].split(", ")


def test_help_has_examples_and_the_version_is_one_line():
    assert "anamorph render model.glb" in quiet_success(run("--help"))
    assert quiet_success(run("--version")).startswith("anamorph ")


# no scene is called "nowhere": each of these must be found out before the scene is looked for
USAGE = {
    "nothing": ((), "COMMAND"),
    "unknown command": (("paint",), "invalid choice: 'paint'"),
    "no output": (("render", "nowhere"), "-o/--output"),
    "unknown option": (("compare", "nowhere", "--fast"), "--fast"),
    "abbreviated option": (("render", "nowhere", "-o", "a.png", "--sam", "2"), "--sam"),
    "size zero": (("render", "nowhere", "-o", "a.png", "--size", "0x4"), "'0x4' has no pixels"),
    "size of words": (("render", "nowhere", "-o", "a.png", "--size", "big"), "write it like 1024x768"),
    "negative size": (("render", "nowhere", "-o", "a.png", "--size=-3x4"), "'-3x4' is no size"),
    "no samples": (("render", "nowhere", "-o", "a.png", "--samples", "0"), "whole number from 1"),
    "unknown format": (("render", "nowhere", "-o", "a.gif"), "end the name in .png"),
    "no format": (("render", "nowhere", "-o", "a"), "end the name in .png"),
    "no directory": (("render", "nowhere", "-o", "no/a.png"), "no/a.png: there is no directory"),
    "directory in the way": (("render", "nowhere", "-o", "taken.png"), "not a plain file"),
    "unknown buffer": (("render", "nowhere", "-o", "a.png", "--seen", "depth=a.npy"), "'depth=a.npy' is no seen"),
    "buffer without file": (("render", "nowhere", "-o", "a.png", "--seen", "position"), "as position=FILE.npy"),
    "buffer nowhere": (("render", "nowhere", "-o", "a.exr", "--seen", "position="), "write NAME=FILE.npy, or NAME"),
    "buffer as image": (("render", "nowhere", "-o", "a.png", "--seen", "position=a.jpg"), "end the name in .npy"),
    "a turntable of no kind": (("turntable", "nowhere", "-o", "a.mp4"), "end the name in .webm, .webp, or in nothing"),
    "a turntable too large": (("turntable", "nowhere", "-o", "a.webm", "--size", "16384x2"), "at most 16383 pixels"),
    "a turntable without end": (("turntable", "nowhere", "-o", "a.webm", "--frames", "10000"), "up to 9999"),
    "swing of words": (("turntable", "nowhere", "-o", "a.webm", "--swing", "nan"), "'nan' is no swing"),
    "no turntable": (("turntable", "nowhere"), "-o/--output"),
    "two scenes to view": (("view", "nowhere", "elsewhere"), "elsewhere"),
    "one file for two": (("render", "nowhere", "-o", "a.npy", "--seen", "position=a.npy"), "a.npy: is asked for twice"),
    "page over figures": (("compare", "nowhere", "--json", "a", "--html", "a"), "a: is asked for twice"),
    "no point": (("reflections", "nowhere"), "--point"),
    "a point of two": (("reflections", "nowhere", "--point", "1", "2"), "expected 3"),
    "a point nowhere": (("reflections", "nowhere", "--point", "1", "nan", "2"), "'nan' is no coordinate"),
    "marks in floats": (("reflections", "nowhere", "--point", "1", "1", "1", "-o", "a.npy"), "end the name in .png"),
    "marks in light": (("reflections", "nowhere", "--point", "1", "1", "1", "-o", "a.exr"), "end the name in .png"),
    "no export": (("export", "nowhere"), "-o/--output"),
    "export of another kind": (("export", "nowhere", "-o", "a.gltf"), "end the name in .glb"),
    "page nowhere": (("compare", "nowhere", "--html", "no/a.html"), "no/a.html: there is no directory"),
}


@pytest.mark.parametrize(("arguments", "told"), USAGE.values(), ids=USAGE.keys())
def test_wrong_usage_is_one_line_with_the_remedy_before_any_work(arguments, told, tmp_path):
    (tmp_path / "taken.png").mkdir()
    assert told in one_line_error(run(*arguments, directory=tmp_path))
    assert os.listdir(tmp_path) == ["taken.png"]


INPUT = {
    "unknown method": (("render", "spheres", "-m", "magic", "-o", "a.png"), "magic"),
    "unknown method option": (("compare", "spheres", "-m", "pervertex:gloss=1"), "gloss"),
    "wrong value of an option": (("render", "spheres", "-m", "pervertex:antialias=many", "-o", "a.png"), "many"),
    "turntable by no method": (("turntable", "spheres", "-m", "magic", "-o", "a.webm"), "magic"),
    "turntable of no scene": (("turntable", "nowhere", "-o", "a.webm"), "nowhere"),
    "faces of no CAD file": (("turntable", "spheres", "-o", "a.webm", "--faces", "1"), "are for CAD files"),
    "missing file": (("render", "no.glb", "-o", "a.png"), "no.glb"),
    "unknown scene": (("compare", "nowhere"), "nowhere"),
    "damaged file": (("render", "damaged.glb", "-o", "a.png"), "damaged.glb"),
    "size beyond the device": (("render", "spheres", "-o", "a.png", "--size", "999999x2"), "999999x2"),
    "demo under a file": (("demo", "--output", "damaged.glb/x"), "damaged.glb"),
}


@pytest.mark.parametrize(("arguments", "told"), INPUT.values(), ids=INPUT.keys())
def test_bad_input_is_one_line_and_leaves_no_file(arguments, told, tmp_path):
    (tmp_path / "damaged.glb").write_bytes(b"glTF\x02\x00\x00\x00 no more")
    assert told in one_line_error(run(*arguments, directory=tmp_path))
    assert os.listdir(tmp_path) == ["damaged.glb"]


@pytest.mark.parametrize("kind", [wgpu.GPUValidationError, wgpu.GPUInternalError, wgpu.GPUError])
def test_a_failing_device_is_one_line(kind, monkeypatch, capsys):
    def fail(arguments):
        raise kind("Validation Error\n\nCaused by:\n  In Queue::submit\n    Parent device is lost\n")

    monkeypatch.setitem(cli.COMMANDS, "scenes", fail)
    assert cli.main(["scenes"]) == 2
    told = capsys.readouterr()
    assert told.err.startswith("anamorph: error: the graphics device failed (Validation Error Caused by")
    assert "device is lost" in told.err
    assert (told.out, told.err.count("\n")) == ("", 1)


def test_a_fault_of_the_program_is_not_called_one_of_the_device(monkeypatch):
    def fail(arguments):
        raise ZeroDivisionError

    monkeypatch.setitem(cli.COMMANDS, "scenes", fail)
    with pytest.raises(ZeroDivisionError):
        cli.main(["scenes"])


# Signals itself when a module is first looked for, so that the moment is the same on every machine. A library may
# guard its imports against every exception, which swallows an interrupt that is one.
AT_A_MOMENT = """
import os, signal, sys
class Moment:
    def find_spec(name, path=None, target=None):
        if name == {moment!r}:
            signal.raise_signal(signal.SIGINT)
sys.argv = ["anamorph", "render", "flat-mirror", "-o", "a.png", "--size", "64x48"]
sys.meta_path.insert(0, Moment)
from anamorph.__main__ import main
sys.exit(main())
"""


@pytest.mark.parametrize(
    "moment", ["anamorph.cli.commands", "numpy", "rich.progress", "trimesh", "networkx", "wgpu", "numba"]
)
def test_an_interrupt_during_the_imports_is_one_line_and_the_end(moment, tmp_path):
    program = [sys.executable, "-c", AT_A_MOMENT.format(moment=moment)]
    ended = subprocess.run(program, capture_output=True, text=True, cwd=tmp_path, env=environment(), timeout=PATIENCE)
    assert (ended.returncode, ended.stdout) == (130, "")
    assert ended.stderr == "anamorph: error: interrupted; files that are there are whole\n"
    assert os.listdir(tmp_path) == []


# Interrupts while a file is half written, and from within a callback, which cannot pass an exception on.
WHILE_WRITING = """
import ctypes, signal
from anamorph.base.interrupt import leave_on_interrupt
from anamorph.base.output import whole_file
leave_on_interrupt()
with whole_file("a.json") as file:
    file.write(b"half")
    ctypes.CFUNCTYPE(None)(lambda: signal.raise_signal(signal.SIGINT))()
"""


def test_an_interrupt_in_a_callback_while_a_file_is_written_leaves_no_part_of_it(tmp_path):
    program = [sys.executable, "-c", WHILE_WRITING]
    ended = subprocess.run(program, capture_output=True, text=True, cwd=tmp_path, env=environment(), timeout=PATIENCE)
    assert (ended.returncode, ended.stderr.count("\n")) == (130, 1)
    assert os.listdir(tmp_path) == []


def test_a_command_that_is_to_ignore_interrupts_does():
    program = "import signal; from anamorph.base.interrupt import leave_on_interrupt as leave\n" + (
        "signal.signal(signal.SIGINT, signal.SIG_IGN); leave(); signal.raise_signal(signal.SIGINT)"
    )
    assert subprocess.run([sys.executable, "-c", program], env=environment(), timeout=PATIENCE).returncode == 0


# Comes when frames have been drawn and are about to be compared.
MIDWAY = """
import signal, sys
from anamorph.measure import compare
compare.measure = lambda *_: signal.raise_signal(signal.SIGINT)
sys.argv = ["anamorph", "compare", "car-mirror", "--size", "64x48", "--json", "a.json", "--html", "a.html"]
from anamorph.__main__ import main
sys.exit(main())
"""


def test_an_interrupt_says_so_and_leaves_no_part_of_a_file(tmp_path):
    program = [sys.executable, "-c", MIDWAY]
    ended = subprocess.run(program, capture_output=True, text=True, cwd=tmp_path, env=environment(), timeout=PATIENCE)
    assert (ended.returncode, ended.stderr.count("\n")) == (130, 1)
    assert ended.stderr.startswith("anamorph: error: interrupted")
    assert os.listdir(tmp_path) == []


def test_a_reader_who_has_enough_is_no_error():
    buffered = environment(PYTHONUNBUFFERED="")
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen([*COMMAND, "scenes"], env=buffered, text=True, **pipes) as process:
        process.stdout.close()
        error = process.stderr.read()
    assert error == ""
    assert process.returncode == 141


@pytest.mark.parametrize("terminal", [True, False])
def test_progress_is_told_on_a_terminal_only(terminal, monkeypatch):
    told = io.StringIO()
    monkeypatch.setattr(progress, "Console", lambda stderr: Console(file=told, force_terminal=terminal, width=80))
    with progress.progress_bar("opening [a scene]") as tell:
        tell(1, 2, "half of [it]")
    assert ("half of [it]" in told.getvalue()) == terminal
    assert terminal or told.getvalue() == ""


def test_render_tells_how_many_of_its_images_are_drawn(tmp_path, monkeypatch):
    told = []

    @contextmanager
    def bar(what):
        yield lambda *step: told.append(step)

    monkeypatch.setattr(cli, "progress_bar", bar)
    arguments = ["render", "flat-mirror", "-m", "pervertex", "-o", str(tmp_path / "a.png"), "--size", "32x24"]
    assert cli.main([*arguments, "--samples", "2"]) == 0
    assert told == [(n, 4, f"rendering flat-mirror, image {n} of 4") for n in (1, 2, 3, 4)]


def test_the_demo_writes_a_page_figures_and_an_image_by_each_method(tmp_path, monkeypatch):
    monkeypatch.setattr(demo, "SIZE", (96, 72))
    comparison = demo.make_demo(tmp_path / "new" / "place", "anamorph demo", lambda done, total, what: None)
    images = {f"car-mirror-{result.name}.png" for result in comparison.methods}
    assert {path.name for path in (tmp_path / "new" / "place").iterdir()} == {
        "index.html",
        "comparison.json",
        *images,
    }
    assert images == {f"car-mirror-{name}.png" for name in ("pervertex", "environment", "raytrace")}


def test_a_scene_with_glass_is_drawn_by_the_methods_that_can(tmp_path, monkeypatch, capsys):
    def a_few_rounds(sessions, cameras, minimum):
        return timing_rounds(sessions, cameras[:2], 2)

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(compare, "timing_rounds", a_few_rounds)
    assert cli.main(["render", "magnifier", "--size", "48x36", "-o", "lens.png"]) == 0
    assert capsys.readouterr().err == ""
    assert cli.main(["render", "magnifier", "--tolerance", "0.5", "--size", "48x36", "-o", "lens.png"]) == 0
    told = capsys.readouterr()
    assert told.err == "" and "doubtful 0.0 %" in told.out
    assert cli.main(["compare", "magnifier", "--size", "48x36", "--json", "lens.json"]) == 0
    assert capsys.readouterr().err == ""
    methods = list(json.loads((tmp_path / "lens.json").read_text())["methods"])
    assert methods == ["auto", "raytrace", "pervertex", "trilinear", "threeray", "virtual"]


def test_an_image_with_gaps_says_so_and_how_to_fill_them(tmp_path, monkeypatch, capsys):
    def told(*method):
        assert cli.main(["render", "spheres", *method, "--size", "64x48", "-o", "a.png"]) == 0
        return capsys.readouterr().err

    monkeypatch.chdir(tmp_path)
    warped = told("-m", "pervertex:map=image")
    assert warped.count("\n") == 1 and "-m auto" in warped
    assert "one more mirror" in warped and "bounces=8" in warped
    traced = told("-m", "raytrace:bounces=1")
    assert traced.count("\n") == 1 and "raytrace:bounces=2" in traced and "tolerance" not in traced
    assert told("-m", "pervertex:tolerance=0.5") == ""


def test_a_tolerance_for_a_method_that_has_none_is_one_line(tmp_path):
    told = run("render", "spheres", "-m", "raytrace", "--tolerance", "1", "-o", "a.png", directory=tmp_path)
    assert told.returncode == 2 and told.stderr.count("\n") == 1
    assert "--tolerance" in told.stderr and "raytrace" in told.stderr and "pervertex" in told.stderr


def test_a_tolerance_says_how_the_pixels_got_their_value(tmp_path):
    told = run("render", "spheres", "--tolerance", "0.5", "--size", "64x48", "-o", "a.png", directory=tmp_path)
    assert (told.returncode, told.stderr) == (0, "")
    shares = re.fullmatch(r"pixels of mirrors and lenses: ((?:[a-z ]+ \d+\.\d %(?:, )?)+)\n", told.stdout)
    assert shares and "traced" in shares[1] and "outside" not in shares[1]
    assert sum(float(share) for share in re.findall(r"[\d.]+", shares[1])) == pytest.approx(100.0, abs=0.3)
