"""The command `anamorph`: reads arguments, calls the package, prints.

Modules that draw are imported by the commands that need them, so that help and errors of usage come at once.
"""

from __future__ import annotations

import argparse
import os
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from anamorph.errors import AnamorphError
from anamorph.output import PICTURES, check_directory, check_output, save_array, save_text
from anamorph.progress import progress_bar
from anamorph.quiet import hush
from anamorph.versions import versions

if TYPE_CHECKING:
    from anamorph.scene.cad import FaceChoice

NOTEWORTHY = 0.005
"""The share of a picture's mirrors without an answer that a user is told of."""

MOST_FRAMES = 300
"""Of a benchmark: where every vertex is in each of them is kept ready."""

SEEN = ("position", "object_id", "specular", "status", "deviation")

EXAMPLES = """examples:
  anamorph render car-mirror -o mirror.png
  anamorph render model.glb -m environment -o model.png --size 1920x1080
  anamorph render car-mirror -m pervertex:antialias=4,mipmaps=true -o mirror.webp --seen position=seen.npy
  anamorph render car-mirror --tolerance 0.5 -o sure.png --seen status=status.npy deviation=deviation.npy
  anamorph render mirror.step --scene car-mirror --faces 1 -o mirror.png
  anamorph compare car-mirror -m pervertex -m environment --html report.html --json report.json
  anamorph bench deforming
  anamorph bench trilinear --output times
  anamorph demo
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return the exit code: 0, 2 for what the user can mend, 130 when interrupted."""
    hush()
    given = list(sys.argv[1:] if argv is None else argv)
    try:
        arguments = _parser().parse_args(given)
        arguments.command_line = shlex.join(["anamorph", *given])
        arguments.run(arguments)
        sys.stdout.flush()
    except AnamorphError as error:
        return _fail(str(error), 2)
    except MemoryError:
        return _fail("not enough memory; choose a smaller --size or scene", 2)
    except KeyboardInterrupt:
        return _fail("interrupted; files that are there are whole", 130)
    except BrokenPipeError:
        # whoever read the output has enough; Python must not complain about it again at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except OSError as error:
        return _fail(f"{error.filename or 'system'}: {error.strerror or error}; check the path and its permissions", 2)
    except Exception as error:
        if not _of_device(error):
            raise
        said = " ".join(str(error).split())
        return _fail(f"the graphics device failed ({said[:200]}); try a smaller --size, or another driver", 2)
    return 0


def _of_device(error: Exception) -> bool:
    """Whether the device refused or was lost; wgpu is not imported for the question."""
    wgpu = sys.modules.get("wgpu")
    return wgpu is not None and isinstance(error, (wgpu.GPUError, wgpu.GPUPipelineError))


def _fail(message: str, code: int) -> int:
    print(f"anamorph: error: {' '.join(message.split())}", file=sys.stderr)
    return code


def _render(arguments: argparse.Namespace) -> None:
    check_output(arguments.output, PICTURES)
    for _, path in arguments.seen:
        check_output(path, (".npy",))
    _check_distinct(arguments.output, *(path for _, path in arguments.seen))
    from anamorph.frame import View
    from anamorph.measure.status import gaps, status_shares
    from anamorph.methods import parse, with_option
    from anamorph.rendering import draw_frame
    from anamorph.scene.opening import open_scene

    if arguments.method:
        parse(arguments.method)
    what = f"rendering {arguments.scene}"
    with progress_bar(what) as tell:
        scene, settings = open_scene(arguments.scene, _face_choice(arguments), arguments.mirror_of)
        size = arguments.size or settings.size
        view = View(scene, scene.camera, size, samples=arguments.samples)
        specification = arguments.method or settings.method
        if arguments.tolerance is not None:
            method, options = parse(specification)
            if not hasattr(options, "tolerance"):
                raise AnamorphError(f"--tolerance: {method.name} has none; leave it out, or give -m pervertex")
            specification = with_option(specification, "tolerance", arguments.tolerance)

        def drawn(done: int, total: int) -> None:
            tell(done, total, f"{what}, picture {done} of {total}" if total > 1 else what)

        frame = draw_frame(view, specification, True, drawn)
    frame.save(arguments.output)
    for name, path in arguments.seen:
        save_array(path, getattr(frame, name))
    if arguments.tolerance is not None and frame.specular is not None:
        print(_shares(status_shares(frame, frame.specular > 0)))
    lost, ended = gaps(frame, scene)
    if lost + ended > NOTEWORTHY:
        share = f"{100.0 * (lost + ended):.0f}% of the pixels of mirrors and lenses"
        why = "lead to one more mirror or lens" if ended > lost else "have no place in a map"
        print(
            f"anamorph: note: {share} {why} and show the sky; try {_remedy(specification, ended > lost)}",
            file=sys.stderr,
        )


def _compare(arguments: argparse.Namespace) -> None:
    outputs = [path for path in (arguments.json, arguments.html) if path]
    for path in outputs:
        check_output(path)
    _check_distinct(*outputs)
    from anamorph.measure.compare import compare
    from anamorph.measure.report import report_page
    from anamorph.measure.table import comparison_table, print_table
    from anamorph.methods import METHODS, parse, with_option
    from anamorph.scene.opening import open_scene

    for spec in arguments.method or ():
        parse(spec)
    with progress_bar(f"opening {arguments.scene}") as tell:
        scene, settings = open_scene(arguments.scene, _face_choice(arguments), arguments.mirror_of)
        size = arguments.size or settings.size
        able = [name for name, method in METHODS.items() if method.refracts or not scene.refracts]
        specs = arguments.method or able
        for number, spec in enumerate(specs):
            if arguments.tolerance is not None and hasattr(parse(spec)[0].options, "tolerance"):
                specs[number] = with_option(spec, "tolerance", arguments.tolerance)
        comparison = compare(scene, specs, size, command=arguments.command_line, progress=tell)
    if arguments.json:
        save_text(arguments.json, comparison.to_json())
    if arguments.html:
        save_text(arguments.html, report_page(comparison))
    print_table(comparison_table(comparison))


def _bench_deforming(arguments: argparse.Namespace) -> None:
    from anamorph.measure.deforming import DEFAULT, deforming_table, time_deforming
    from anamorph.measure.table import print_table
    from anamorph.methods import parse
    from anamorph.scene.scenefile import DEFAULT_SIZE

    for spec in arguments.method or ():
        parse(spec)
    what = "timing deforming"
    with progress_bar(what) as tell:
        times = time_deforming(
            arguments.method or DEFAULT,
            arguments.size or DEFAULT_SIZE,
            arguments.frames,
            lambda done, total: tell(done, total, what),
        )
    print_table(deforming_table(times))


def _bench_trilinear(arguments: argparse.Namespace) -> None:
    from anamorph.measure.table import print_table
    from anamorph.measure.thesis.benchmark import FULL, PARTS, QUICK, measure_thesis, write_results
    from anamorph.measure.thesis.plots import INSTALL, can_plot
    from anamorph.measure.thesis.summary import exact_over_straight, summary_tables

    check_directory(arguments.output)
    with progress_bar("timing trilinear projection") as tell:
        extent = QUICK if arguments.quick else FULL
        results = measure_thesis(arguments.method, extent, arguments.part or PARTS, tell)
    written = write_results(results, arguments.output)
    for table in summary_tables(results):
        print_table(table)
    if said := exact_over_straight(results):
        print(said)
    print(f"{len(written)} files are in {arguments.output}")
    if not can_plot():
        print(f"anamorph: note: no plots without matplotlib; pip install '{INSTALL}'", file=sys.stderr)


def _scenes(arguments: argparse.Namespace) -> None:
    from anamorph.scene.builtin import SCENES

    for scene in SCENES.values():
        print(f"{scene.name:16} {scene.summary}")


def _info(arguments: argparse.Namespace) -> None:
    from anamorph.gpu.device import adapter_name
    from anamorph.methods import METHODS

    facts = {"adapter": adapter_name(), **versions(), "methods": ", ".join(METHODS)}
    for name, value in facts.items():
        print(f"{name:12} {value}")


def _demo(arguments: argparse.Namespace) -> None:
    from anamorph.demo import make_demo
    from anamorph.measure.table import comparison_table, print_table

    with progress_bar("starting") as tell:
        comparison = make_demo(arguments.output, arguments.command_line, tell)
    print_table(comparison_table(comparison))
    print(f"Pictures and the page are in {arguments.output}; open {arguments.output / 'index.html'}")


def _face_choice(arguments: argparse.Namespace) -> FaceChoice | None:
    """What the command line says of the faces of a CAD file; None where it says nothing."""
    from anamorph.scene.cad import FaceChoice

    said = {"faces": arguments.faces, "density": arguments.density, "flip": arguments.flip or None}
    said = {name: value for name, value in said.items() if value is not None}
    return FaceChoice(**said) if said else None


def _remedy(specification: str, ended: bool) -> str:
    """What to ask for where pixels got no answer: more bounces if most paths `ended`, or tracing."""
    from anamorph.methods import parse
    from anamorph.methods.pervertex import MAXIMUM_BOUNCES

    method, options = parse(specification)
    if method.name != "pervertex":
        return f"-m {method.name}:bounces={min(2 * max(options.bounces, 1), 255)}"
    if options.tolerance > 0.0:
        return f"-m raytrace:bounces={2 * MAXIMUM_BOUNCES}"
    if ended and options.bounces < MAXIMUM_BOUNCES:
        return f"more bounces than {options.bounces}, as -m pervertex:bounces={MAXIMUM_BOUNCES}, or --tolerance 0.5"
    return "--tolerance 0.5"


def _shares(shares: dict[str, float]) -> str:
    """How the pixels of mirrors and lenses got their value, in one line."""
    told = ", ".join(f"{status} {share:.1f} %" for status, share in shares.items())
    return f"pixels of mirrors and lenses: {told or 'none'}"


def _check_distinct(*paths: Path) -> None:
    places = [path.resolve() for path in paths]
    for path in paths:
        if places.count(path.resolve()) > 1:
            raise AnamorphError(f"{path}: is asked for twice; give every output its own name")


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, like every other error here."""

    def error(self, message: str) -> NoReturn:
        raise AnamorphError(f"{message}; see '{self.prog} --help'")


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


def _samples(text: str) -> int:
    if not (text.isascii() and text.isdigit() and int(text) > 0):
        raise argparse.ArgumentTypeError(f"'{text}' is no number of samples; write a whole number from 1")
    return int(text)


def _frames(text: str) -> int:
    if not (text.isascii() and text.isdigit() and 0 < int(text) <= MOST_FRAMES):
        raise argparse.ArgumentTypeError(f"'{text}' is no number of frames; write a whole number up to {MOST_FRAMES}")
    return int(text)


def _faces(text: str) -> tuple[int | str, ...]:
    entries = [entry.strip() for entry in text.split(",")]
    if not all(entries):
        raise argparse.ArgumentTypeError(f"'{text}' names no faces; write numbers or names with commas, like 1,3")
    return tuple(int(entry) if entry.isascii() and entry.isdigit() else entry for entry in entries)


def _density(text: str) -> int:
    if not (text.isascii() and text.isdigit() and int(text) > 0):
        raise argparse.ArgumentTypeError(f"'{text}' is no density; write a whole number of cells along a face")
    return int(text)


def _seen(text: str) -> tuple[str, Path]:
    name, equals, path = text.partition("=")
    if name not in SEEN or not equals or not path:
        raise argparse.ArgumentTypeError(f"'{text}' is no seen buffer; write NAME=FILE.npy with {', '.join(SEEN)}")
    return name, Path(path)


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="anamorph",
        description="What an eye sees in a curved mirror, and how far from the truth.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version and exit")
    commands = parser.add_subparsers(metavar="COMMAND", required=True, dest="command")

    def command(name: str, run: object, help: str) -> argparse.ArgumentParser:
        added = commands.add_parser(name, help=help, description=help, allow_abbrev=False)
        added.set_defaults(run=run)
        return added

    def cad(added: argparse.ArgumentParser) -> None:
        group = added.add_argument_group("CAD files (.step, .stp, .iges, .igs)")
        group.add_argument(
            "--scene", metavar="SCENE", dest="mirror_of", help="put the CAD mirror where this scene has its own"
        )
        group.add_argument("--faces", metavar="1,3|NAME", type=_faces, help="only these faces, by number or name (all)")
        group.add_argument("--density", metavar="N", type=_density, help="cells along the longer side of a face (24)")
        group.add_argument("--flip", action="store_true", help="the other side of the faces is their outside")

    scene = "a built-in scene, a scene file (.toml) or any model file (.glb, .gltf, .obj, .stl, .ply, .step, .iges)"
    size = "size of the picture in pixels, like 1024x768"
    method = "a method and its options: METHOD[:option=value,...]"

    render = command("render", _render, "render a scene, or a model before a convex mirror, to a picture")
    render.add_argument("scene", metavar="SCENE|MODEL", help=scene)
    render.add_argument("-m", "--method", metavar="METHOD", help=method)
    render.add_argument(
        "-o", "--output", metavar="FILE", type=Path, required=True, help=f"the picture: {', '.join(PICTURES)}"
    )
    render.add_argument("--size", metavar="WxH", type=_size, help=size)
    render.add_argument("--samples", metavar="N", type=_samples, default=1, help="N x N samples a pixel (1)")
    tolerance = "trace what a method's own check finds off by more pixels than this (pervertex)"
    render.add_argument("--tolerance", metavar="PX", type=float, help=tolerance)
    render.add_argument(
        "--seen",
        metavar="NAME=FILE.npy",
        type=_seen,
        nargs="+",
        action="extend",
        default=[],
        help=f"also save what each pixel sees: {', '.join(SEEN)}",
    )

    compare = command("compare", _compare, "measure methods against the ray-traced truth, and time them")
    compare.add_argument("scene", metavar="SCENE", help=scene)
    compare.add_argument("-m", "--method", metavar="METHOD", action="append", help=f"{method}; may be repeated (all)")
    compare.add_argument("--size", metavar="WxH", type=_size, help=size)
    compare.add_argument("--tolerance", metavar="PX", type=float, help=tolerance)
    compare.add_argument("--json", metavar="FILE", type=Path, help="write the figures as JSON")
    compare.add_argument("--html", metavar="FILE", type=Path, help="write one page with pictures, errors and figures")

    bench = commands.add_parser("bench", help="time methods against the ray tracer", allow_abbrev=False)
    benchmarks = bench.add_subparsers(metavar="BENCHMARK", required=True, dest="benchmark")

    def benchmark(name: str, run: object, help: str) -> argparse.ArgumentParser:
        added = benchmarks.add_parser(name, help=help, description=help, allow_abbrev=False)
        added.set_defaults(run=run)
        added.add_argument("-m", "--method", metavar="METHOD", action="append", help=f"{method}; may be repeated")
        return added

    deforming = benchmark("deforming", _bench_deforming, "time methods while a scene of 300,000 triangles deforms")
    deforming.add_argument("--size", metavar="WxH", type=_size, help=size)
    deforming.add_argument("--frames", metavar="N", type=_frames, default=30, help="how many frames are timed (30)")
    trilinear = benchmark("trilinear", _bench_trilinear, "make the measurements of Vallance's thesis again")
    trilinear.add_argument(
        "--output", metavar="DIR", type=Path, default=Path("bench-output"), help="tables and plots (bench-output)"
    )
    trilinear.add_argument("--quick", action="store_true", help="small pictures and scenes: does it work?")
    trilinear.add_argument(
        "--part", metavar="PART", action="append", help="random, clipping, configurations, ...; may be repeated (all)"
    )

    cad(render)
    cad(compare)
    command("scenes", _scenes, "list the built-in scenes")
    command("info", _info, "print the graphics adapter, the versions and the methods")
    demo = command("demo", _demo, "render car-mirror by three methods, with a page that compares them")
    demo.add_argument("--output", metavar="DIR", type=Path, default=Path("demo-output"), help="where to (demo-output)")
    return parser
