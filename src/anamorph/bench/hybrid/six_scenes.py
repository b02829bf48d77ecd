"""Measuring the paper's six scenes: the trees over their points, whole frames, and frames of other sizes."""

from __future__ import annotations

import csv
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from itertools import count

import numpy as np

from anamorph.base.compiled import cores
from anamorph.base.errors import AnamorphError, nearest
from anamorph.base.progress import Report
from anamorph.bench.crossover import Crossover, crossovers
from anamorph.bench.moving import time_methods
from anamorph.frame import View
from anamorph.gallery.beside_teapot import OBJECTS, beside_teapot
from anamorph.gpu.device import adapter_name
from anamorph.measure.compare import COMPETITOR
from anamorph.measure.frame_times import eye_path
from anamorph.methods import Session, Specification
from anamorph.methods.threeray import make_tree
from anamorph.scene.model import Scene

OURS = Specification.parse("threeray")
PAPERS = OURS.with_options(splat=1, spacing=1.0, detail=False)
"""The paper's own way. All triangles are smaller than the spacing, and make a point each."""
TREES, FRAMES = "table-1", "table-2"
PARTS = ("trees", "frames", "growth")
BUILDS = 3
"""Trees are made so many times, and the least time counts."""


@dataclass(frozen=True)
class Amount:
    """How much is measured: `share` of the objects' triangles, at `size`; growth with some scenes at other sizes."""

    scenes: tuple[str, ...]
    share: float
    size: tuple[int, int]
    growing: tuple[str, ...]
    sizes: tuple[tuple[int, int], ...]
    frames: int


FULL = Amount(
    scenes=tuple(OBJECTS),
    share=1.0,
    size=(1024, 768),
    growing=("Bunny0", "Dinosaur"),
    sizes=((256, 192), (512, 384), (1024, 768), (2048, 1536)),
    frames=10,
)
QUICK = Amount(("Bunny1", "Dinosaur"), 0.1, (96, 72), ("Dinosaur",), ((48, 36), (96, 72)), 1)


@dataclass(frozen=True)
class TreeTime:
    """The tree over a scene's points: table 1. The printed depth is of an eight-way tree, ours of halves."""

    scene: str
    points: int
    ms: float
    depth: float
    points_a_leaf: float
    printed_points: float
    printed_ms: float
    printed_depth: float
    printed_points_a_leaf: float


@dataclass(frozen=True)
class SceneTime:
    """What a frame takes, and what of it are the two phases, milliseconds: table 2.

    `cpu_ms` is the time of all the process's threads, which is what a frame costs where other programs run too.
    None stands where a method has no such phase, or does not tell; projection is all but culling. `valid_percent` is
    the share of projections that are valid. Printed figures stand beside those of `PAPERS`.
    """

    scene: str
    triangles: int
    width: int
    height: int
    cameras: int
    pixels: int
    method: str
    ms: float | None
    least_ms: float | None
    cpu_ms: float | None
    culling_ms: float | None
    projection_ms: float | None
    valid_percent: float | None
    printed_ms: float | None = None
    printed_culling_ms: float | None = None
    printed_projection_ms: float | None = None
    printed_valid_percent: float | None = None
    refusal: str = ""

    @property
    def pixels_a_camera(self) -> float:
        """Of the mirror in the image, which the cameras share."""
        return self.pixels / max(self.cameras, 1)


@dataclass(frozen=True)
class SixScenes:
    """What was measured; parts that were not asked for are empty."""

    adapter: str
    cores: int
    trees: list[TreeTime] = field(default_factory=list)
    frames: list[SceneTime] = field(default_factory=list)
    growth: list[SceneTime] = field(default_factory=list)

    @property
    def crossovers(self) -> list[Crossover]:
        """Along the triangles of an object, at one size, then along pixels a camera, in one scene."""
        lines = crossovers(self.frames, "triangles", ("width", "height"))
        return [*lines, *crossovers(self.growth, "pixels_a_camera", ("scene",))]


@cache
def printed(table: str) -> dict[str, dict[str, float]]:
    """What the paper prints, by scene and column."""
    text = files("anamorph.bench.hybrid").joinpath("assets", f"{table}.csv").read_text()
    return {row.pop("scene"): {name: float(cell) for name, cell in row.items()} for row in csv.DictReader(text.split())}


def measure_six_scenes(
    methods: Sequence[Specification] = (),
    amount: Amount = FULL,
    parts: Sequence[str] = PARTS,
    report: Report = lambda done, total, what: None,
) -> SixScenes:
    """Measure the tracer, `OURS`, `PAPERS` and `methods`."""
    for part in parts:
        if part not in PARTS:
            raise AnamorphError(f"part: there is no {part!r}; parts are {', '.join(PARTS)}{nearest(part, PARTS)}")
    timed = tuple(dict.fromkeys((Specification.parse(COMPETITOR), OURS, PAPERS, *methods)))
    places = {
        "trees": [(name, amount.size) for name in amount.scenes],
        "frames": [(name, amount.size) for name in amount.scenes],
        "growth": [(name, size) for name in amount.growing for size in amount.sizes],
    }
    done, total = count(), sum(len(places[part]) for part in parts)

    def steps(part: str) -> Iterable[tuple[str, tuple[int, int]]]:
        for name, size in places[part] if part in parts else ():
            report(next(done), total, f"{part}: {name}, {size[0]} x {size[1]}")
            yield name, size

    return SixScenes(
        adapter_name(),
        cores(),
        [_tree_time(name, amount.share, size) for name, size in steps("trees")],
        [row for name, size in steps("frames") for row in _scene_times(name, amount, size, timed)],
        [row for name, size in steps("growth") for row in _scene_times(name, amount, size, timed)],
    )


def _triangles(name: str, share: float) -> int:
    return round(share * OBJECTS[name].triangles)


def _tree_time(name: str, share: float, size: tuple[int, int]) -> TreeTime:
    scene = beside_teapot(name, _triangles(name, share))
    surfels = OURS.open(View(scene, scene.camera, size)).diagnostics()["tree"].surfels
    # One tree over all of them, as in the paper.
    owner, spent = np.zeros(surfels.triangle.max() + 1, np.int32), []
    for _ in range(BUILDS):
        start = time.perf_counter()
        tree = make_tree(surfels, owner)
        spent.append(1000.0 * (time.perf_counter() - start))
    leaves = tree.count > 0
    known = printed(TREES)[name]
    return TreeTime(
        name, len(surfels), min(spent), float(depths(tree.size)[leaves].mean()), float(tree.count[leaves].mean()),
        known["points"], known["ms"], known["depth"], known["points_a_leaf"],
    )  # fmt: skip


def depths(size: np.ndarray) -> np.ndarray:
    """How many nodes stand above each of a tree, whose nodes come before those below them, by how many these are."""
    enters = np.zeros(len(size) + 1, np.int64)
    number = np.arange(len(size))
    np.add.at(enters, number + 1, 1)
    np.add.at(enters, number + size, -1)
    return np.cumsum(enters[:-1])


def _scene_times(name: str, amount: Amount, size: tuple[int, int], methods: Sequence[Specification]) -> list[SceneTime]:
    scene = beside_teapot(name, _triangles(name, amount.share))
    triangles = sum(len(mesh.faces) for mesh in scene.meshes if not mesh.specular)
    times = time_methods(scene, None, size, methods, amount.frames)
    frames = {method: session.frame(seen=True) for method, session in times.sessions.items()}
    specular = frames[OURS].specular
    assert specular is not None
    cameras, pixels = round(frames[OURS].figures["cameras"]), int(np.count_nonzero(specular))
    rows = []
    for method in methods:
        timing, said = times.timings.get(method), frames[method].figures if method in frames else {}
        culling = said.get("culling_ms")
        known = printed(FRAMES)[name] if method == PAPERS and size == amount.size else {}
        rows.append(
            SceneTime(
                name, triangles, *size, cameras, pixels, str(method),
                timing.median if timing else None, timing.min if timing else None,
                _processor_time(times.sessions[method], scene, amount.frames) if timing else None,
                culling, timing.median - culling if timing and culling is not None else None, said.get("valid_percent"),
                known.get("ms"), known.get("culling_ms"), known.get("projection_ms"), known.get("valid_percent"),
                times.refusals.get(method, ""),
            )
        )  # fmt: skip
    return rows


def _processor_time(session: Session, scene: Scene, frames: int) -> float:
    """What a frame takes of all cores together, milliseconds."""
    start = time.process_time()
    for camera in eye_path(scene, frames):
        session.draw(camera)
        session.wait()
    return 1000.0 * (time.process_time() - start) / frames
