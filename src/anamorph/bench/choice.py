"""What `auto` chooses between, measured: searching maps of surfaces, and tracing.

From the same run come the costs that its choice would be made by: those of `Costs` that come closest to the times.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from rich.table import Table
from scipy.optimize import nnls

from anamorph import gallery
from anamorph.base.progress import Report
from anamorph.base.steps import drain
from anamorph.frame import View
from anamorph.gpu.device import adapter_name
from anamorph.measure.figures import number
from anamorph.measure.frame_times import eye_path, timing_rounds
from anamorph.measure.table import headed
from anamorph.methods import Specification
from anamorph.methods.auto import AutoDrawing, Costs, Options
from anamorph.methods.stage import Stage

WAYS = {"search": "pervertex:tolerance=0.5", "trace": "raytrace", "auto": "auto"}
"""What is timed, side by side."""


def choice_table(
    size: tuple[int, int],
    frames: int = 9,
    report: Report = lambda done, total, what: None,
    names: Sequence[str] = gallery.names(),
) -> tuple[Table, Costs]:
    """Time built-in scenes, all within half a pixel of each other, and fit the costs.

    How much longer searching takes than tracing is a sum of what the costs count; they are found by non-negative least
    squares, of shares of the slower one's time.
    """
    width, height = size
    table = headed(
        f"auto and what it chooses between, {width} x {height}: medians, in ms",
        f"{adapter_name()}; {frames} frames, the eye moving",
        "scene", *WAYS, "auto over the faster",
    )  # fmt: skip
    terms, differences, slower = [], [], list[float]()
    for done, name in enumerate(names):
        report(done, len(names), f"timing {name}")
        scene = gallery.make(name)
        view = View(scene, scene.camera, size)
        sessions = {way: Specification.parse(method).open(view) for way, method in WAYS.items()}
        timings = drain(timing_rounds(sessions, eye_path(scene, frames), frames))
        medians = [timings[way].median for way in WAYS]
        table.add_row(name, *map(number, medians), number(medians[2] / min(medians[:2])))
        bodies = AutoDrawing(Stage(view), Options(), None).expected(scene.camera)
        terms.append(
            [
                sum(body.looks for body in bodies),
                sum(body.patches * body.triangles for body in bodies),
                sum(body.patches for body in bodies),
                sum((body.left - 1.0) * body.rays for body in bodies),
            ]
        )
        differences.append(1e6 * (medians[0] - medians[1]))
        slower.append(1e6 * max(medians[:2]))
    matrix = np.array(terms, float) / np.array(slower)[:, None]
    scale = np.maximum(np.abs(matrix).max(axis=0), np.finfo(float).tiny)
    found, _ = nnls(matrix / scale, np.array(differences) / slower)
    return table, Costs(*(found / scale).tolist())
