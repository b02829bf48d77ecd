"""How long a frame takes where the whole scene deforms between frames: the built-in scene `deforming`.

Where its vertices are is computed beforehand; what follows from their motion, the upload and the ray tracer's tree, is
part of the frame.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from rich.table import Table
from rich.text import Text

from anamorph.base.progress import Report
from anamorph.files.scene_file import DEFAULT_SIZE
from anamorph.frame import View
from anamorph.gallery.deforming import deformed, deforming
from anamorph.gpu.device import adapter_name
from anamorph.measure.errors import measure
from anamorph.measure.figures import number
from anamorph.measure.frame_times import WARM_UP, Timing, eye_path, timing_of
from anamorph.measure.table import headed
from anamorph.methods import Session, Specification
from anamorph.methods.stage import Stage
from anamorph.scene.camera import Camera

COMPETITORS = ("raytrace", "raytrace:tree=rebuild")
"""The ray tracer with both ways to follow the motion; the faster one is what every time is compared with."""

DEFAULT = ("pervertex",)
"""What is timed against it where nothing is chosen."""

RATE = 30.0
"""Frames of the motion in a second."""


@dataclass(frozen=True)
class Phases:
    """What one method's frames took.

    Parameters
    ----------
    frame : Timing
        The whole.
    deform : Timing
        `Session.deform`: the upload, and for a method that casts rays the refitted or rebuilt tree.
    draw : Timing
        `Session.draw`: what is done before the device has all its work. For the ray tracer, that is the tracing.
    device : Timing
        `Session.wait`: the rest of the device's work.
    p95_pixels : float or None
        Of the last frame, against the ray tracer's: the 95th percentile of the error in the image.
    """

    frame: Timing
    deform: Timing
    draw: Timing
    device: Timing
    p95_pixels: float | None


@dataclass(frozen=True)
class DeformingTimes:
    """Methods timed in turn while the scene deforms; `upload` is that of the vertices alone."""

    size: tuple[int, int]
    adapter: str
    upload: Timing
    methods: dict[str, Phases]

    @property
    def competitor(self) -> str:
        """The faster of the two ray tracers."""
        return min(COMPETITORS, key=lambda name: self.methods[name].frame.median)

    def speed(self, name: str) -> float:
        """How many frames a method draws while the competitor draws one."""
        return self.methods[self.competitor].frame.median / self.methods[name].frame.median


def time_deforming(
    methods: Sequence[str | Specification] = DEFAULT,
    size: tuple[int, int] = DEFAULT_SIZE,
    frames: int = 30,
    report: Report = lambda done, total, what: None,
) -> DeformingTimes:
    """Draw the scene `deforming` by each method and both ray tracers, which take turns frame by frame.

    Parameters
    ----------
    methods : sequence of str or Specification
        Each "NAME" or "NAME:option=value,...", parsed or not.
    size : (width, height)
    frames : int
        How many are timed; scene and eye move from each to the next.
    report : callable
        Hears how far the work is.
    """
    chosen = dict.fromkeys(map(Specification.parse, (*methods, *COMPETITORS)))
    names = tuple(map(str, chosen))
    scene = deforming()
    view = View(scene, scene.camera, size)
    sessions = {str(each): each.open(view) for each in chosen}
    stage = Stage(view)
    moments = [deformed(moment / RATE) for moment in range(frames)]
    cameras = eye_path(scene, frames)

    uploads: list[float] = []
    spent: dict[str, list[tuple[float, ...]]] = {name: [] for name in names}
    for turn in range(-WARM_UP, frames):
        moment, camera = moments[turn % frames], cameras[turn % frames]
        start = time.perf_counter()
        stage.deform(*moment)
        uploads.append(1000.0 * (time.perf_counter() - start))
        for name, session in sessions.items():
            spent[name].append(_frame(session, moment, camera))
        report(turn + WARM_UP + 1, frames + WARM_UP, "timing deforming")
    last = {name: session.frame(seen=True) for name, session in sessions.items()}
    reference = last[COMPETITORS[0]]

    def phases(name: str) -> Phases:
        whole = [sum(parts) for parts in spent[name]]
        frame, deform, draw, device = (timing_of(ms[WARM_UP:]) for ms in (whole, *zip(*spent[name], strict=True)))
        return Phases(frame, deform, draw, device, measure(reference, last[name]).pixels.p95)

    return DeformingTimes(size, adapter_name(), timing_of(uploads[WARM_UP:]), {name: phases(name) for name in names})


def _frame(session: Session, moment: tuple[np.ndarray, np.ndarray], camera: Camera) -> tuple[float, ...]:
    """Draw a frame: milliseconds for deforming the scene, for drawing, and until the device is ready."""
    clock = [time.perf_counter()]
    session.deform(*moment)
    clock.append(time.perf_counter())
    session.draw(camera)
    clock.append(time.perf_counter())
    session.wait()
    clock.append(time.perf_counter())
    return tuple(1000.0 * (stop - start) for start, stop in pairwise(clock))


def deforming_table(times: DeformingTimes) -> Table:
    """Methods as rows, the parts of their frames as columns."""
    width, height = times.size
    table = headed(
        f"deforming, {width} x {height}: medians, in ms",
        f"{times.adapter}; scene and eye move every frame, over {times.upload.n} frames; uploading the vertices, "
        f"part of every deform, takes {number(times.upload.median)} ms",
        "", "frame", "deform", "draw", "device", "as fast as the tracer", "p95 error, px",
    )  # fmt: skip
    for name, phases in times.methods.items():
        parts = (phases.frame, phases.deform, phases.draw, phases.device)
        cells = [number(part.median) for part in parts]
        table.add_row(Text(name), *cells, f"{times.speed(name):.2f} x", number(phases.p95_pixels))
    return table
