"""The images of chapters 6 and 7 at their resolutions: table 8.1, at one sample a pixel and at equal quality."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from anamorph.base.steps import drain
from anamorph.bench.moving import open_sessions, time_methods
from anamorph.bench.thesis.printed import COMPETITOR, rows
from anamorph.cameras import detail_and_context, inward_sphere, multi_perspective, refracting_plane
from anamorph.frame import View
from anamorph.gallery.cube import CAMERA, FRONT, LEFT, cube_scene
from anamorph.gallery.cube_mirrors import cube_in_sphere, cube_in_wavy_mirror
from anamorph.measure.colors import flip_map
from anamorph.methods import Session, Specification
from anamorph.methods.averaging import averaging
from anamorph.raymesh import RayMesh
from anamorph.scene.model import Scene

REFERENCE_SIDE = 4
"""The reference has 16 samples a pixel."""
MOST_SIDE = 3
"""No method gets more than 9 frames to reach equal quality."""
GOAL_SIDE = 2
"""Equal quality is that of the tracer with 4 samples a pixel."""
SPHERE_RADIUS = 2.0
"""Of the sphere around the cube, metres: it clears the corners, which are 0.87 m from the middle."""


@dataclass(frozen=True)
class Case:
    """A row of table 8.1; without `rays`, the scene's own camera looks at a mirror."""

    figure: str
    size: tuple[int, int]
    projections: int
    scene_triangles: int
    scene: Scene
    rays: RayMesh | None


@dataclass(frozen=True)
class CaseTime:
    """What a frame takes, milliseconds, and what equal quality takes.

    `flip` is that of one frame against the mean of 16 shifted ones by the tracer. `frames` is how many shifted frames
    have the FLIP of the tracer's mean of 4: at least 1, between 1, 4 and 9 by interpolation in logarithms, None where 9
    are not enough. `equal_quality_ms` is so many times `ms`.
    """

    figure: str
    width: int
    height: int
    trilinear_projections: int
    scene_triangles: int
    method: str
    ms: float
    least_ms: float
    flip: float
    frames: float | None
    equal_quality_ms: float | None
    printed_ms: float


def cases(scale: float = 1.0) -> list[Case]:
    """All rows of table 8.1, images `scale` times as wide and high."""
    made = []
    for row in rows("table-8-1"):
        size = tuple(max(1, round(scale * int(row[side]))) for side in ("width", "height"))
        scene, rays = _made(row["figure"], (size[0], size[1]), int(row["trilinear_projections"]))
        count = int(row["scene_triangles"])
        made.append(Case(row["figure"], (size[0], size[1]), int(row["trilinear_projections"]), count, scene, rays))
    return made


def _made(figure: str, size: tuple[int, int], projections: int) -> tuple[Scene, RayMesh | None]:
    cube, quads = cube_scene(), round((projections / 2) ** 0.5)
    if figure == "6.4":
        return cube, detail_and_context(CAMERA, size)
    if figure == "6.7":
        return cube, multi_perspective(LEFT, FRONT, size)
    if figure == "6.9":
        alone = replace(cube, meshes=cube.meshes[:1])
        return alone, inward_sphere((0.0, 0.0, 0.0), SPHERE_RADIUS, size, quads, quads)
    if figure == "7.5":
        return cube_in_wavy_mirror(), None
    if figure.startswith("7.4"):
        return cube_in_sphere(quads, exact=False), None
    return cube, refracting_plane(CAMERA, size, quads)


def frames_for(goal: float, flips: Sequence[float]) -> float | None:
    """How many shifted frames have the FLIP `goal`, where `flips` are those of 1, 4, 9 ... frames; at least 1."""
    if flips[-1] > goal:
        return None
    counts = np.arange(1, len(flips) + 1) ** 2
    # FLIP falls with the samples: both run backwards, as interpolation wants ascending values.
    heights = np.log(np.maximum(np.asarray(flips), np.finfo(float).tiny))[::-1]
    return float(np.exp(np.interp(np.log(max(goal, np.finfo(float).tiny)), heights, np.log(counts)[::-1])))


def time_cases(
    chosen: Sequence[Case],
    methods: Sequence[Specification],
    frames: int,
    report: Callable[[str], None] = lambda what: None,
) -> list[CaseTime]:
    """Time every case by the tracer and `methods`.

    Mirrors are traced along the rays of the ray mesh, once: every method has the same rays.
    """
    timed = []
    for case in chosen:
        report(f"figure {case.figure}, {case.size[0]} x {case.size[1]}")
        specifications = {_as_seen(method, case): method for method in (Specification.parse(COMPETITOR), *methods)}
        times = time_methods(case.scene, case.rays, case.size, tuple(specifications), frames)
        view = View(case.scene, case.rays or case.scene.camera, case.size)
        sessions = open_sessions(view, specifications)
        tracer = sessions[next(iter(specifications))]
        reference = drain(averaging(tracer, view.camera, REFERENCE_SIDE))
        goal = _flip(reference, tracer, view, GOAL_SIDE)
        printed = next(row for row in rows("table-8-1") if row["figure"] == case.figure)
        for specification, method in specifications.items():
            timing = times.timings[specification]
            flips = [_flip(reference, sessions[specification], view, 1)]
            while flips[-1] > goal and len(flips) < MOST_SIDE:
                flips.append(_flip(reference, sessions[specification], view, len(flips) + 1))
            needed = frames_for(goal, flips)
            known = float(printed["ray_ms" if str(method) == COMPETITOR else "trilinear_ms"])
            timed.append(
                CaseTime(
                    case.figure, *case.size, case.projections, case.scene_triangles, str(method),
                    timing.median, timing.min, flips[0], needed, needed and needed * timing.median, known,
                )
            )  # fmt: skip
    return timed


def _flip(reference: np.ndarray, session: Session, view: View, side: int) -> float:
    return float(flip_map(reference, drain(averaging(session, view.camera, side))).mean())


def _as_seen(method: Specification, case: Case) -> Specification:
    """The method, for mirrors with the rays of the ray mesh and one bounce where it has such options."""
    if case.rays is not None:
        return method
    for option, value in (("truth", "raymesh"), ("bounces", 1)):
        if hasattr(method.options, option):
            method = method.with_options(**{option: value})
    return method
