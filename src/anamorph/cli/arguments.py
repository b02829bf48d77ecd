"""The command line of `anamorph`: its commands, their options, and the types of these."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from anamorph.base.errors import AnamorphError
from anamorph.base.output import IMAGES, PIXELS
from anamorph.base.versions import versions
from anamorph.base.video import MOST_FRAMES, VIDEOS
from anamorph.files.source_words import Parser, add_model_options

if TYPE_CHECKING:
    from anamorph.methods.specification import Specification

MOST_TIMED = 300
"""Frames of a benchmark: where every vertex is in each of them is kept ready."""

FIRST_SCENE = "car-mirror"
"""What there is to look at for who names nothing."""

SEEN = ("position", "object_id", "specular", "status", "deviation")

EXAMPLES = """examples:
  anamorph render car-mirror -o mirror.png
  anamorph render model.glb -m environment -o model.png --size 1920x1080
  anamorph render car-mirror -m pervertex:antialias=4 -o mirror.webp --seen position=seen.npy
  anamorph render car-mirror --tolerance 0.5 -o sure.png --seen status=status.npy
  anamorph render car-mirror -o mirror.exr --seen position object_id status
  anamorph render mirror.step --scene car-mirror --faces 1 -o mirror.png
  anamorph compare car-mirror -m pervertex -m environment --html report.html --json report.json
  anamorph view
  anamorph view mirror.step --scene car-mirror
  anamorph turntable car-mirror -o mirror.webm --swing 20
  anamorph turntable car-mirror-1.toml --path -o path.webm
  anamorph turntable model.glb -o frames --frames 36 --size 800x600 --samples 2
  anamorph export car-mirror -o mirror.glb
  anamorph reflections torus --point -0.54 0 -4.07 -o seen.png
  anamorph bench deforming
  anamorph bench trilinear --output times
  anamorph bench threeray --part frames
  anamorph demo
"""


class _Version(argparse.Action):
    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        print(f"anamorph {versions()['anamorph']}")
        parser.exit()


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.partition("x")
    if not (width.isascii() and width.isdigit() and height.isascii() and height.isdigit()):
        raise argparse.ArgumentTypeError(f"'{text}' is no size; write it like 1024x768")
    if int(width) < 1 or int(height) < 1:
        raise argparse.ArgumentTypeError(f"'{text}' has no pixels; width and height start at 1")
    return int(width), int(height)


def _method(text: str) -> Specification:
    # What draws is imported only where a method is named.
    from anamorph.methods.specification import Specification

    try:
        return Specification.parse(text)
    except AnamorphError as error:
        raise argparse.ArgumentTypeError(str(error)) from error


def _whole(what: str, limits: str, least: int, most: float) -> Callable[[str], int]:
    """The type of a whole number within limits, which a wrong one is answered with."""

    def parse(text: str) -> int:
        if not (text.isascii() and text.isdigit() and least <= int(text) <= most):
            raise argparse.ArgumentTypeError(f"'{text}' is no {what}; write a whole number {limits}")
        return int(text)

    return parse


_samples = _whole("number of samples", "from 1", 1, math.inf)
_frames = _whole("number of frames", f"up to {MOST_FRAMES}", 1, MOST_FRAMES)
_timed_frames = _whole("number of frames", f"up to {MOST_TIMED}", 1, MOST_TIMED)
_port = _whole("port", "up to 65535, or 0 for a free one", 0, 65535)


def _swing(text: str) -> float:
    try:
        degrees = float(text)
    except ValueError:
        degrees = 0.0
    if not 0.0 < degrees <= 180.0:
        raise argparse.ArgumentTypeError(f"'{text}' is no swing; write more than 0 and at most 180 degrees")
    return degrees


def _metres(text: str) -> float:
    try:
        metres = float(text)
    except ValueError:
        metres = math.nan
    if not math.isfinite(metres):
        raise argparse.ArgumentTypeError(f"'{text}' is no coordinate; write metres, as --point 0.5 1 -2")
    return metres


def _seen(text: str) -> tuple[str, Path | None]:
    name, equals, path = text.partition("=")
    if name not in SEEN or (equals and not path):
        raise argparse.ArgumentTypeError(
            f"'{text}' is no seen buffer; write NAME=FILE.npy, or NAME for a layer of an .exr image, "
            f"with {', '.join(SEEN)}"
        )
    return name, Path(path) if equals else None


def make_parser() -> argparse.ArgumentParser:
    """The parser; what it returns holds in `run` the name of what is to be run."""
    parser = Parser(
        prog="anamorph",
        description="What an eye sees in a curved mirror, and how far from the truth.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version and exit")
    commands = parser.add_subparsers(metavar="COMMAND", required=True, dest="command")

    def command(name: str, help: str) -> argparse.ArgumentParser:
        added = commands.add_parser(name, help=help, description=help, allow_abbrev=False)
        added.set_defaults(run=name)
        return added

    scene = "a built-in scene, a scene file (.toml) or any model file (.glb, .gltf, .obj, .stl, .ply, .step, .iges)"
    size = "size of the image in pixels, like 1024x768"
    method = "a method and its options: METHOD[:option=value,...]"

    render = command("render", "render a scene, or a model before a convex mirror, to an image")
    render.add_argument("scene", metavar="SCENE|MODEL", help=scene)
    render.add_argument("-m", "--method", metavar="METHOD", type=_method, help=method)
    render.add_argument(
        "-o", "--output", metavar="FILE", type=Path, required=True, help=f"the image: {', '.join(IMAGES)}"
    )
    render.add_argument("--size", metavar="WxH", type=_size, help=size)
    render.add_argument("--samples", metavar="N", type=_samples, default=1, help="N x N samples a pixel (1)")
    tolerance = "trace what may be off by more pixels than this (pervertex)"
    render.add_argument("--tolerance", metavar="PX", type=float, help=tolerance)
    render.add_argument(
        "--seen",
        metavar="NAME[=FILE.npy]",
        type=_seen,
        nargs="+",
        action="extend",
        default=[],
        help=f"also save what each pixel sees, in a file or as a layer of an .exr image: {', '.join(SEEN)}",
    )

    compare = command("compare", "measure methods against the ray-traced reference, and time them")
    compare.add_argument("scene", metavar="SCENE", help=scene)
    compare.add_argument(
        "-m", "--method", metavar="METHOD", type=_method, action="append", help=f"{method}; may be repeated (all)"
    )
    compare.add_argument("--size", metavar="WxH", type=_size, help=size)
    compare.add_argument("--tolerance", metavar="PX", type=float, help=tolerance)
    compare.add_argument("--json", metavar="FILE", type=Path, help="write the figures as JSON")
    compare.add_argument("--html", metavar="FILE", type=Path, help="write one page with images, errors and figures")

    view = command("view", "look at a scene, or a model before a convex mirror: turn it, and see how true the image is")
    named = f"{scene} ({FIRST_SCENE})"
    view.add_argument("scene", metavar="SCENE|MODEL", nargs="?", default=FIRST_SCENE, help=named)
    view.add_argument("-m", "--method", metavar="METHOD", type=_method, help=method)
    backends = "a window (desktop), a page on this machine (browser), or the window where one can open (auto)"
    view.add_argument("--backend", choices=("auto", "desktop", "browser"), default="auto", help=f"{backends} (auto)")
    view.add_argument("--port", metavar="N", type=_port, default=0, help="of the page (0: any that is free)")
    view.add_argument("--size", metavar="WxH", type=_size, help="size of the window, like 1280x720")

    turntable = command("turntable", "save a video of the eye going round what it looks at, or through several views")
    turntable.add_argument("scene", metavar="SCENE|MODEL", help=scene)
    turntable.add_argument("-m", "--method", metavar="METHOD", type=_method, help=method)
    videos = f"{', '.join(VIDEOS)}, or without a suffix a folder for numbered PNG images"
    turntable.add_argument("-o", "--output", metavar="FILE|DIR", type=Path, required=True, help=f"the video: {videos}")
    turntable.add_argument("--size", metavar="WxH", type=_size, help=size)
    frames = "how many, 30 a second (120; on a path 60 from one view to the next)"
    turntable.add_argument("--frames", metavar="N", type=_frames, help=frames)
    course = turntable.add_mutually_exclusive_group()
    swing = "go this far to either side and back, not all the way round: behind a mirror there is little to see"
    course.add_argument("--swing", metavar="DEG", type=_swing, help=swing)
    path = "go through the views that were remembered in the viewer, as the scene file that it saved keeps them"
    course.add_argument("--path", action="store_true", help=path)
    turntable.add_argument("--samples", metavar="N", type=_samples, default=1, help="N x N samples a pixel (1)")

    export = command("export", "write a scene as a glTF file, for other programs")
    export.add_argument("scene", metavar="SCENE|MODEL", help=scene)
    export.add_argument("-o", "--output", metavar="FILE.glb", type=Path, required=True, help="the file")

    reflections = command("reflections", "find all places of mirrors that show a point, and mark them in an image")
    reflections.add_argument("scene", metavar="SCENE|MODEL", help=scene)
    place = "the point, metres"
    reflections.add_argument("--point", metavar=("X", "Y", "Z"), type=_metres, nargs=3, required=True, help=place)
    reflections.add_argument("-m", "--method", metavar="METHOD", type=_method, help=method)
    reflections.add_argument(
        "-o", "--output", metavar="FILE", type=Path, help=f"an image with these marks: {', '.join(PIXELS)}"
    )
    reflections.add_argument("--size", metavar="WxH", type=_size, help=size)

    bench = commands.add_parser("bench", help="time methods against the ray tracer", allow_abbrev=False)
    benchmarks = bench.add_subparsers(metavar="BENCHMARK", required=True, dest="benchmark")

    def benchmark(name: str, help: str) -> argparse.ArgumentParser:
        added = benchmarks.add_parser(name, help=help, description=help, allow_abbrev=False)
        added.set_defaults(run=f"bench {name}")
        added.add_argument(
            "-m", "--method", metavar="METHOD", type=_method, action="append", help=f"{method}; may be repeated"
        )
        return added

    about = "time what auto chooses between, and fit the costs that it chooses by"
    choice = benchmarks.add_parser("choice", help=about, description=about, allow_abbrev=False)
    choice.set_defaults(run="bench choice")
    choice.add_argument("--size", metavar="WxH", type=_size, help=size)
    deforming = benchmark("deforming", "time methods while a scene of 300,000 triangles deforms")
    deforming.add_argument("--size", metavar="WxH", type=_size, help=size)
    deforming.add_argument("--frames", metavar="N", type=_timed_frames, default=30, help="how many are timed (30)")
    editing = benchmark("editing", "time a step of a slider in scenes of up to a million triangles")
    editing.add_argument("--size", metavar="WxH", type=_size, help=size)
    editing.add_argument("--steps", metavar="N", type=_timed_frames, default=9, help="how many are timed (9)")
    about = "make the measurements of Estalella et al. again, and those of virtual on all reflectors"
    virtual = benchmark("virtual", about)
    virtual.add_argument("--size", metavar="WxH", type=_size, help=size)
    virtual.add_argument("--frames", metavar="N", type=_timed_frames, default=12, help="how many are timed (12)")
    parts = "kitchen, reflectors or moving; may be repeated (all)"
    virtual.add_argument("--part", metavar="PART", action="append", help=parts)
    papers = {
        "trilinear": ("make the measurements of Vallance's thesis again", "random, clipping, configurations, ..."),
        "threeray": ("make the measurements of Mei, Popescu and Sacks again", "trees, frames or growth"),
    }
    for name, (about, parts) in papers.items():
        again = benchmark(name, about)
        folder = Path("bench-output")
        again.add_argument("--output", metavar="DIR", type=Path, default=folder, help=f"tables and plots ({folder})")
        again.add_argument("--quick", action="store_true", help="small images and scenes: does it work?")
        again.add_argument("--part", metavar="PART", action="append", help=f"{parts}; may be repeated (all)")

    for added in (render, compare, view, turntable, export, reflections):
        add_model_options(added)
    command("scenes", "list the built-in scenes")
    command("info", "print the graphics adapter, the versions, the methods, and what auto chooses by")
    demo = command("demo", "render car-mirror by three methods, with a page that compares them")
    demo.add_argument("--output", metavar="DIR", type=Path, default=Path("demo-output"), help="where to (demo-output)")
    return parser
