"""One step of a slider: a mirror is turned, and the scene, which is large otherwise, is opened and drawn again.

Before the steps that count, two others fill what is kept from one to the next.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from time import perf_counter

import numpy as np
from rich.table import Table
from rich.text import Text

from anamorph import gallery
from anamorph.base.progress import Report
from anamorph.frame import View
from anamorph.gallery.solids import lattice
from anamorph.gpu.device import adapter_name
from anamorph.measure.figures import number
from anamorph.measure.table import headed
from anamorph.methods import METHODS, Specification
from anamorph.scene.model import Mesh, Scene
from anamorph.viewer.controls import edited

COUNTS = (10_000, 100_000, 300_000, 1_000_000)
"""Triangles around the mirror."""

SIZE = (400, 300)
FILLING = 2


def editing_table(
    methods: Sequence[Specification] = (),
    size: tuple[int, int] = SIZE,
    steps: int = 9,
    report: Report = lambda done, total, what: None,
    counts: Sequence[int] = COUNTS,
) -> Table:
    """Time steps of a slider in scenes of `counts` triangles, by `methods` or by all."""
    width, height = size
    table = headed(
        f"one step of a slider, {width} x {height}: medians, in ms",
        f"{adapter_name()}; {steps} steps",
        "triangles", "method", "edit", "open", "first image", "second image", words=0,
    )  # fmt: skip
    table.columns[1].justify = "left"
    chosen = methods or [Specification.parse(name) for name in METHODS]
    cases = [(count, method) for count in counts for method in chosen]
    for done, (count, method) in enumerate(cases):
        report(done, len(cases), "timing steps of a slider")
        scene = hilly(count)
        times = np.array([step(scene, method, size, 0.2 * n) for n in range(steps + FILLING)])
        medians = [number(1000.0 * median) for median in np.median(times[FILLING:], axis=0)]
        table.add_row(f"{sum(len(mesh.faces) for mesh in scene.meshes):,}", Text(str(method)), *medians)
    return table


def step(scene: Scene, method: Specification, size: tuple[int, int], swivel: float) -> list[float]:
    """Seconds that editing, opening and two images took."""
    times = [perf_counter()]
    changed = edited(scene, {"mirror/swivel": swivel})
    times.append(perf_counter())
    session = method.open(View(changed, changed.camera, size))
    times.append(perf_counter())
    for _ in range(2):
        session.draw(changed.camera)
        session.wait()
        times.append(perf_counter())
    return np.diff(times).tolist()


def hilly(count: int, strips: int = 8) -> Scene:
    """The mirror of `car-mirror` over hills of about `count` triangles, in strips."""
    scene = gallery.make("car-mirror")
    columns = int(np.sqrt(count / 2 / strips))
    rows = max(count // (2 * strips * columns), 1)
    hills = []
    for strip in range(strips):
        x, z = np.meshgrid(np.linspace(-60, 60, columns + 1), 20.0 * np.linspace(strip - 1, strip, rows + 1))
        y = 0.4 * np.sin(0.5 * x) * np.cos(0.7 * z) + 0.05 * np.sin(5.0 * x) - 1.0
        slope_x = 0.2 * np.cos(0.5 * x) * np.cos(0.7 * z) + 0.25 * np.cos(5.0 * x)
        normals = np.stack([-slope_x, np.ones_like(x), 0.28 * np.sin(0.5 * x) * np.sin(0.7 * z)], axis=-1)
        normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
        places = np.stack([x, y, z], axis=-1).reshape(-1, 3).astype(np.float32)
        faces = lattice(columns + 1, rows + 1).astype(np.int32)
        normal = normals.reshape(-1, 3).astype(np.float32)
        hills.append(Mesh(f"hills-{strip}", places, faces, normal, colors=np.abs(np.sin(places))))
    return replace(scene, name="hills", meshes=(scene.meshes[0], *hills))
