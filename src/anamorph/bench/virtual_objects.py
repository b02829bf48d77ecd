"""What Estalella et al. 2005 measured, again: frames of a kitchen by their search and its grids, beside traced ones.

Beside it: how right `virtual` is on reflectors of all kinds, and what a frame costs in which one object moves.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from rich.table import Table
from rich.text import Text

from anamorph.base.errors import AnamorphError
from anamorph.base.progress import Report
from anamorph.files.scene_file import DEFAULT_SIZE
from anamorph.frame import Frame, View
from anamorph.gallery import make
from anamorph.gpu.device import adapter_name
from anamorph.measure.errors import measure
from anamorph.measure.figures import number
from anamorph.measure.frame_times import WARM_UP, eye_path
from anamorph.measure.table import headed
from anamorph.methods import Session, Specification
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Scene

Size = tuple[int, int]

PAPER = "virtual:search=cubemap"

PRINTED = {
    PAPER: "1.3",
    f"{PAPER},grid=regular,share=0.041": "16.3",
    f"{PAPER},grid=regular,share=0.055": "13.6",
    f"{PAPER},grid=regular": "10.1",
    f"{PAPER},grid=regular,share=0.143": "8.3",
}
"""Frames a second that the paper prints for its kitchen (section 7), by what draws ours."""

KITCHEN = ("raytrace", "environment", *PRINTED, f"{PAPER},grid=adaptive,iterations=60", "virtual")

REFLECTORS = ("room", "car-mirror", "torus", "curvature-series", "saddle", "spheres", "kitchen")

MOVING = (("kitchen", "fruit"), ("car-mirror", "car-0"))
"""Scenes in which one object moves, and which."""

STEP = 0.002
"""How far it moves in a frame, metres."""


@dataclass(frozen=True)
class Cost:
    """Milliseconds of a frame: on the clock, and of all cores together."""

    clock: float
    cores: float


def costs_of(draws: dict[str, Callable[[int], None]], frames: int, report: Report, what: str) -> dict[str, Cost]:
    """Time what draws frames by their numbers; all take turns."""
    spent: dict[str, list[tuple[float, float]]] = {name: [] for name in draws}
    for turn in range(-WARM_UP, frames):
        for name, draw in draws.items():
            start = time.perf_counter(), time.process_time()
            draw(turn)
            if turn >= 0:
                spent[name].append((time.perf_counter() - start[0], time.process_time() - start[1]))
        report(turn + WARM_UP + 1, frames + WARM_UP, what)
    medians = {name: 1000.0 * np.median(times, axis=0) for name, times in spent.items()}
    return {name: Cost(float(clock), float(cores)) for name, (clock, cores) in medians.items()}


def _sessions(scene: Scene, size: Size, methods: Iterable[str]) -> dict[str, Session]:
    return {name: Specification.parse(name).open(View(scene, scene.camera, size)) for name in methods}


def _looking(session: Session, cameras: list[Camera]) -> Callable[[int], None]:
    def draw(turn: int) -> None:
        session.draw(cameras[turn % len(cameras)])
        session.wait()

    return draw


def kitchen_table(methods: Sequence[str], size: Size, frames: int, report: Report) -> Table:
    """Frames of `kitchen`: their rate beside the printed one, and what is wrong with them."""
    scene = make("kitchen")
    sessions = _sessions(scene, size, dict.fromkeys((*KITCHEN, *methods)))
    cameras = eye_path(scene, frames)
    costs = costs_of({name: _looking(each, cameras) for name, each in sessions.items()}, frames, report, "kitchen")
    table = headed(
        f"kitchen, {size[0]} x {size[1]}",
        f"{adapter_name()}; the eye moves before each of {frames} frames; errors against surface truth, away from "
        "silhouettes; printed: of a kitchen of 2005, on a GeForce 6800",
        "", "ms", "ms of all cores", "frames/s", "printed", "searches", "median px", "p95 px", "other object %", "FLIP",
    )  # fmt: skip
    reference = _frame(sessions["raytrace"], scene)
    for name, session in sessions.items():
        frame = _frame(session, scene)
        errors = measure(reference, frame)
        table.add_row(
            Text(name), number(costs[name].clock), number(costs[name].cores), f"{1000.0 / costs[name].clock:.1f}",
            PRINTED.get(name, ""), f"{frame.figures.get('searches', 0.0):.0f}", number(errors.pixels.median),
            number(errors.pixels.p95), number(errors.other_object_percent), number(errors.flip),
        )  # fmt: skip
    return table


def _frame(session: Session, scene: Scene) -> Frame:
    session.draw(scene.camera)
    return session.frame(seen=True)


def reflectors_table(methods: Sequence[str], size: Size, frames: int, report: Report) -> Table:
    """How right `virtual` is on reflectors of all kinds, and what it costs beside tracing."""
    table = headed(
        f"reflectors of all kinds, {size[0]} x {size[1]}",
        f"{adapter_name()}; errors against surface truth, away from silhouettes",
        "", "ms, raytrace", "ms", "ms of all cores, raytrace", "ms of all cores",
        "traced %", "p95 px", "other object %", "FLIP",
    )  # fmt: skip
    for name in REFLECTORS:
        scene = make(name)
        cameras = eye_path(scene, frames)
        sessions = _sessions(scene, size, dict.fromkeys(("raytrace", "virtual", *methods)))
        costs = costs_of({each: _looking(own, cameras) for each, own in sessions.items()}, frames, report, name)
        reference = _frame(sessions["raytrace"], scene)
        for method in list(sessions)[1:]:
            frame = _frame(sessions[method], scene)
            errors = measure(reference, frame)
            mirrored = float(np.count_nonzero(np.asarray(reference.specular)))
            traced = 100.0 * frame.figures["traced"] / max(mirrored, 1.0)
            table.add_row(
                Text(f"{name}, {method}"), number(costs["raytrace"].clock), number(costs[method].clock),
                number(costs["raytrace"].cores), number(costs[method].cores), number(traced),
                number(errors.pixels.p95), number(errors.other_object_percent), number(errors.flip),
            )  # fmt: skip
    return table


def moving_table(methods: Sequence[str], size: Size, frames: int, report: Report) -> Table:
    """What a frame costs in which the eye moves, or one object."""
    table = headed(
        f"what moves, {size[0]} x {size[1]}",
        f"{adapter_name()}; milliseconds of a frame, of all cores together",
        "", "the eye moves", "one object moves",
    )  # fmt: skip
    for name, part in MOVING:
        scene = make(name)
        cameras = eye_path(scene, frames)
        for method, session in _sessions(scene, size, dict.fromkeys(("raytrace", "virtual", *methods))).items():
            looked = costs_of({"": _looking(session, cameras)}, frames, report, f"{name}: the eye")
            moved = costs_of({"": _moving(session, scene, part)}, frames, report, f"{name}: {part}")
            table.add_row(Text(f"{name}, {method}; {part}"), number(looked[""].cores), number(moved[""].cores))
    return table


def _moving(session: Session, scene: Scene, part: str) -> Callable[[int], None]:
    geometry = flatten(scene)
    mesh = [each.name for each in scene.meshes].index(part)
    step = np.where(geometry.vertex_object[:, None] == mesh + 1, [STEP, 0.0, 0.0], 0.0).astype(np.float32)

    def draw(turn: int) -> None:
        session.deform(geometry.positions + np.float32(turn % 2 + 1) * step, geometry.normals)
        session.draw(scene.camera)
        session.wait()

    return draw


PARTS = {"kitchen": kitchen_table, "reflectors": reflectors_table, "moving": moving_table}


def virtual_tables(
    methods: Sequence[str] = (),
    size: Size = DEFAULT_SIZE,
    frames: int = 12,
    parts: Sequence[str] = (),
    report: Report = lambda done, total, what: None,
) -> list[Table]:
    """Measure some parts, or all, with other methods beside.

    Raises
    ------
    AnamorphError
        There is no such part.
    """
    for part in parts:
        if part not in PARTS:
            raise AnamorphError(f"part '{part}' is none of {', '.join(PARTS)}; choose one of these")
    return [PARTS[part](methods, size, frames, report) for part in parts or PARTS]
