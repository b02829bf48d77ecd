"""The command `anamorph`: reads its arguments, calls the package, prints.

Modules that draw are imported by the commands that need them, so that help and errors of usage come at once.
"""

from __future__ import annotations

import argparse
import os
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from anamorph.base.errors import AnamorphError
from anamorph.base.logs import show_errors_of_libraries, silence_libraries
from anamorph.base.output import IMAGES, check_directory, check_output, save_array, save_text
from anamorph.base.progress import progress_bar
from anamorph.base.versions import versions
from anamorph.cli.arguments import make_parser
from anamorph.files.source_words import source_of

if TYPE_CHECKING:
    from anamorph.methods import Specification

NOTEWORTHY = 0.005
"""The share of an image's mirrors without an answer that is reported to a user."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return the exit code: 0, 2 for what the user can mend, 130 when interrupted."""
    silence_libraries()
    given = list(sys.argv[1:] if argv is None else argv)
    try:
        arguments = make_parser().parse_args(given)
        arguments.command_line = shlex.join(["anamorph", *given])
        COMMANDS[arguments.run](arguments)
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
    check_output(arguments.output, IMAGES)
    files = {name: path for name, path in arguments.seen if path is not None}
    layers = [name for name, path in arguments.seen if path is None]
    if layers and arguments.output.suffix.lower() != ".exr":
        raise AnamorphError(f"--seen {layers[0]}: give it a file, as {layers[0]}=FILE.npy, or write an .exr image")
    for path in files.values():
        check_output(path, (".npy",))
    _check_distinct(arguments.output, *files.values())
    from anamorph.files.opening import open_source
    from anamorph.frame import View
    from anamorph.measure.status import gaps, status_shares
    from anamorph.methods import Specification
    from anamorph.rendering import draw_frame

    what = f"rendering {arguments.scene}"
    with progress_bar(what) as report:
        scene, settings = open_source(source_of(arguments))
        size = arguments.size or settings.size
        view = View(scene, scene.camera, size, samples=arguments.samples)
        specification = arguments.method or Specification.parse(settings.method)
        if arguments.tolerance is not None:
            if not hasattr(specification.options, "tolerance"):
                name = specification.method.name
                raise AnamorphError(f"--tolerance: {name} has none; leave it out, or give -m pervertex")
            specification = specification.with_options(tolerance=arguments.tolerance)

        def drawn(done: int, total: int) -> None:
            report(done, total, f"{what}, image {done} of {total}" if total > 1 else what)

        frame = draw_frame(view, specification, True, drawn)
    frame.save(arguments.output, layers)
    for name, path in files.items():
        save_array(path, getattr(frame, name))
    if frame.specular is not None:
        shares = {"doubtful": 0.0, **status_shares(frame, frame.specular > 0)}
        shown = ", ".join(f"{status} {share:.1f} %" for status, share in shares.items())
        print(f"pixels of mirrors and lenses: {shown}")
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
    from anamorph.files.opening import open_source
    from anamorph.measure.compare import compare
    from anamorph.measure.page import comparison_page
    from anamorph.measure.table import comparison_table, print_table
    from anamorph.methods import METHODS, Specification

    with progress_bar(f"opening {arguments.scene}") as report:
        scene, settings = open_source(source_of(arguments))
        size = arguments.size or settings.size
        able = [name for name, method in METHODS.items() if method.refracts or not scene.refracts]
        methods = arguments.method or [Specification.parse(name) for name in able]
        if arguments.tolerance is not None:
            methods = [
                each.with_options(tolerance=arguments.tolerance) if hasattr(each.options, "tolerance") else each
                for each in methods
            ]
        comparison = compare(scene, methods, size, command=arguments.command_line, report=report)
    if arguments.json:
        save_text(arguments.json, comparison.to_json())
    if arguments.html:
        save_text(arguments.html, comparison_page(comparison))
    print_table(comparison_table(comparison))


def _view(arguments: argparse.Namespace) -> None:
    from anamorph.viewer.backends.choice import show
    from anamorph.viewer.starting import start_of

    with progress_bar(f"opening {arguments.scene}"):
        start = start_of(source_of(arguments), arguments.method)
    show_errors_of_libraries("uvicorn")
    show(start, arguments.backend, arguments.port, arguments.size)


def _turntable(arguments: argparse.Namespace) -> None:
    from anamorph.cli.turntable import save_turntable

    summary = save_turntable(
        source_of(arguments),
        arguments.output,
        arguments.method,
        arguments.size,
        arguments.frames,
        arguments.swing,
        arguments.path,
        arguments.samples,
    )
    print(summary)


def _export(arguments: argparse.Namespace) -> None:
    from anamorph.files.gltf.exporting import SUFFIXES, save_gltf
    from anamorph.files.opening import open_source

    check_output(arguments.output, SUFFIXES)
    with progress_bar(f"opening {arguments.scene}"):
        scene, _ = open_source(source_of(arguments))
    save_gltf(arguments.output, scene)
    print(f"{len(scene.meshes)} parts, as triangles; sky and ambient light have no place in glTF")


def _reflections(arguments: argparse.Namespace) -> None:
    from anamorph.base.vectors import tuple_of
    from anamorph.cli.reflected_point import point_table
    from anamorph.measure.table import print_table

    table = point_table(
        source_of(arguments),
        tuple_of(arguments.point),
        arguments.output,
        arguments.method,
        arguments.size,
    )
    print_table(table)


def _bench_deforming(arguments: argparse.Namespace) -> None:
    from anamorph.bench.deforming import DEFAULT, deforming_table, time_deforming
    from anamorph.files.scene_file import DEFAULT_SIZE
    from anamorph.measure.table import print_table

    with progress_bar("timing deforming") as report:
        size = arguments.size or DEFAULT_SIZE
        times = time_deforming(arguments.method or DEFAULT, size, arguments.frames, report)
    print_table(deforming_table(times))


def _bench_choice(arguments: argparse.Namespace) -> None:
    from anamorph.bench.choice import choice_table
    from anamorph.files.scene_file import DEFAULT_SIZE
    from anamorph.measure.table import print_table

    with progress_bar("timing auto") as report:
        table, costs = choice_table(arguments.size or DEFAULT_SIZE, report=report)
    print_table(table)
    print(f"fitted costs: {costs}")


def _bench_editing(arguments: argparse.Namespace) -> None:
    from anamorph.bench.editing import SIZE, editing_table
    from anamorph.measure.table import print_table

    with progress_bar("timing steps of a slider") as report:
        table = editing_table(arguments.method or (), arguments.size or SIZE, arguments.steps, report)
    print_table(table)


def _bench_trilinear(arguments: argparse.Namespace) -> None:
    from anamorph.bench.thesis.benchmark import FULL, PARTS, QUICK, measure_thesis, write_results
    from anamorph.bench.thesis.plots import INSTALL, can_plot
    from anamorph.bench.thesis.summary import exact_over_straight, summary_tables
    from anamorph.measure.table import print_table

    check_directory(arguments.output)
    with progress_bar("timing trilinear projection") as report:
        extent = QUICK if arguments.quick else FULL
        results = measure_thesis(arguments.method or (), extent, arguments.part or PARTS, report)
    written = write_results(results, arguments.output)
    for table in summary_tables(results):
        print_table(table)
    if said := exact_over_straight(results):
        print(said)
    print(f"{len(written)} files are in {arguments.output}")
    if not can_plot():
        print(f"anamorph: note: no plots without matplotlib; pip install '{INSTALL}'", file=sys.stderr)


def _bench_threeray(arguments: argparse.Namespace) -> None:
    from anamorph.bench.hybrid.hybrid_tables import six_scene_tables, write_six_scenes
    from anamorph.bench.hybrid.six_scenes import FULL, PARTS, QUICK, measure_six_scenes
    from anamorph.measure.table import print_table

    check_directory(arguments.output)
    with progress_bar("timing three-ray cameras") as report:
        amount = QUICK if arguments.quick else FULL
        results = measure_six_scenes(arguments.method or (), amount, arguments.part or PARTS, report)
    written = write_six_scenes(results, arguments.output)
    for table in six_scene_tables(results):
        print_table(table)
    print(f"{len(written)} files are in {arguments.output}")


def _bench_virtual(arguments: argparse.Namespace) -> None:
    from anamorph.bench.virtual_objects import virtual_tables
    from anamorph.files.scene_file import DEFAULT_SIZE
    from anamorph.measure.table import print_table

    methods = [str(method) for method in arguments.method or ()]
    with progress_bar("timing virtual objects") as report:
        size = arguments.size or DEFAULT_SIZE
        tables = virtual_tables(methods, size, arguments.frames, arguments.part or (), report)
    for table in tables:
        print_table(table)


def _scenes(arguments: argparse.Namespace) -> None:
    from anamorph.gallery import SCENES

    for scene in SCENES.values():
        print(f"{scene.name:16} {scene.summary}")


def _info(arguments: argparse.Namespace) -> None:
    from anamorph.gpu.device import adapter_name
    from anamorph.methods import METHODS
    from anamorph.methods.auto import costs_here

    costs = costs_here()
    choice = "searches every mirror and lens" if costs is None else str(costs)
    facts = {"adapter": adapter_name(), **versions(), "methods": ", ".join(METHODS), "auto": choice}
    for name, value in facts.items():
        print(f"{name:12} {value}")


def _demo(arguments: argparse.Namespace) -> None:
    from anamorph.cli.demo import make_demo
    from anamorph.measure.table import comparison_table, print_table

    with progress_bar("starting") as report:
        comparison = make_demo(arguments.output, arguments.command_line, report)
    print_table(comparison_table(comparison))
    print(f"Images and the page are in {arguments.output}; open {arguments.output / 'index.html'}")


def _remedy(specification: Specification, ended: bool) -> str:
    """What to ask for where pixels got no answer: more bounces if most paths `ended`, or tracing."""
    from anamorph.methods.pervertex import MAXIMUM_BOUNCES

    method, options = specification.method, specification.options
    if method.name == "auto" or (method.name == "pervertex" and options.tolerance > 0.0):
        return f"-m raytrace:bounces={2 * MAXIMUM_BOUNCES}"
    if method.name != "pervertex":
        return f"-m {method.name}:bounces={min(2 * max(options.bounces, 1), 255)}"
    if options.map == "surfaces":
        return "-m auto"
    if ended and options.bounces < MAXIMUM_BOUNCES:
        more = f"-m pervertex:map=image,bounces={MAXIMUM_BOUNCES}"
        return f"more bounces than {options.bounces}, as {more}, or -m auto"
    return "-m auto"


def _check_distinct(*paths: Path) -> None:
    places = [path.resolve() for path in paths]
    for path in paths:
        if places.count(path.resolve()) > 1:
            raise AnamorphError(f"{path}: is asked for twice; give every output its own name")


COMMANDS = {
    "render": _render,
    "compare": _compare,
    "view": _view,
    "turntable": _turntable,
    "export": _export,
    "reflections": _reflections,
    "bench choice": _bench_choice,
    "bench deforming": _bench_deforming,
    "bench editing": _bench_editing,
    "bench threeray": _bench_threeray,
    "bench trilinear": _bench_trilinear,
    "bench virtual": _bench_virtual,
    "scenes": _scenes,
    "info": _info,
    "demo": _demo,
}
"""What runs, by the name that the arguments give it."""
