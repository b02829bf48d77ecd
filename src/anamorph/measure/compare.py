"""Methods beside the reference on one scene: images, errors and times from one run."""

from __future__ import annotations

import json
from collections.abc import Generator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from anamorph.base.progress import Report
from anamorph.base.steps import Step, drain, mapped
from anamorph.base.versions import versions
from anamorph.files.scene_file import DEFAULT_SIZE
from anamorph.frame import Frame, View
from anamorph.gpu.device import adapter_name
from anamorph.measure.errors import Errors, measure
from anamorph.measure.frame_times import Timing, eye_path, timing_rounds
from anamorph.measure.status import status_shares
from anamorph.methods import Session, Specification
from anamorph.scene.model import Scene

COMPETITOR = "raytrace"
"""What every time is compared with, in the same run, on the same pixels and with the same shading."""

PLAIN = "environment"
"""Draws a scene that has no mirror as it is, one pass and nothing besides."""


@dataclass(frozen=True, eq=False)
class MethodResult:
    """What one method, with its options, made of the scene."""

    name: str
    frame: Frame
    errors: Errors
    timing: Timing


@dataclass(frozen=True, eq=False)
class Comparison:
    """Methods measured against one reference.

    Parameters
    ----------
    scene : str
    size : (width, height)
    adapter : str
        The graphics adapter that drew.
    versions : dict of str to str
    command : str
        What was run, for whoever wants to run it again; may be empty.
    reference : str
        The method that the errors are measured against.
    reference_frame : Frame
    methods : tuple of MethodResult
        The competitor among them.
    without_mirrors : Timing, optional
        Of the scene without its specular meshes, timed in turn with the methods; None where no mesh is left.
    """

    scene: str
    size: tuple[int, int]
    adapter: str
    versions: dict[str, str]
    command: str
    reference: str
    reference_frame: Frame
    methods: tuple[MethodResult, ...]
    without_mirrors: Timing | None = None

    @property
    def competitor(self) -> MethodResult | None:
        """The ray tracer, whose time stands beside every other."""
        return next((result for result in self.methods if result.name == COMPETITOR), None)

    def to_dict(self) -> dict[str, Any]:
        """The figures as plain data, under the keys that others rely on; None where nothing can be measured."""
        return {
            "scene": self.scene,
            "size": list(self.size),
            "adapter": self.adapter,
            "versions": self.versions,
            "command": self.command,
            "reference": self.reference,
            "without_mirrors_ms": asdict(self.without_mirrors) if self.without_mirrors else None,
            "methods": {
                result.name: {
                    "frame_ms": asdict(result.timing),
                    "angular_mrad": asdict(result.errors.angular_mrad),
                    "pixels": asdict(result.errors.pixels),
                    "other_object_percent": result.errors.other_object_percent,
                    "silhouette_percent": result.errors.silhouette_percent,
                    "rmse": result.errors.rmse,
                    "flip": result.errors.flip,
                    "relative_error": result.errors.relative_error,
                    "status_percent": status_shares(result.frame, result.errors.maps.specular),
                    "figures": dict(result.frame.figures),
                }
                for result in self.methods
            },
        }

    def to_json(self) -> str:
        """`to_dict` as indented JSON."""
        return json.dumps(self.to_dict(), indent=2, allow_nan=False) + "\n"


def compare(
    scene: Scene,
    methods: Sequence[str | Specification],
    size: tuple[int, int] = DEFAULT_SIZE,
    reference: str | Specification = COMPETITOR,
    frames: int = 30,
    command: str = "",
    report: Report | None = None,
) -> Comparison:
    """Draw a scene by each method, measure it against the reference, and time it.

    Parameters
    ----------
    scene : Scene
        Seen by its own camera.
    methods : sequence of str or Specification
        Each "NAME" or "NAME:option=value,...", parsed or not. The competitor, `raytrace`, is always added.
    size : (width, height)
    reference : str or Specification
        The method that is right: `raytrace` bends rays at the exact surface.
    frames : int
        How many frames are timed, at least; all methods take turns.
    command : str
        Kept in the result.
    report : callable, optional
        Hears how far the work is.

    Returns
    -------
    Comparison
    """
    steps = comparison_steps(scene, methods, size, reference, frames, command)
    return drain(steps, lambda step: report(*step) if report else None)


def comparison_steps(
    scene: Scene,
    methods: Sequence[str | Specification],
    size: tuple[int, int] = DEFAULT_SIZE,
    reference: str | Specification = COMPETITOR,
    frames: int = 30,
    command: str = "",
) -> Generator[Step, None, Comparison]:
    """The same step by step, for whoever has more to do meanwhile; parameters as for `compare`.

    What is drawn elsewhere between two steps must have finished before the next, or it would count as a method's time.
    """
    right = Specification.parse(reference)
    chosen = {str(each): each for each in map(Specification.parse, (*methods, COMPETITOR, right))}
    names = tuple(dict.fromkeys(str(Specification.parse(each)) for each in (*methods, COMPETITOR)))
    total = 2 * len(names) + 1
    view = View(scene, scene.camera, size)

    sessions: dict[str, Session] = {}
    for name, specification in chosen.items():
        yield 0, total, f"opening {name}"
        sessions[name] = specification.open(view)
    yield 0, total, f"truth by {right}"
    reference_frame = _frame(sessions[str(right)], view)
    drawn: dict[str, tuple[Frame, Errors]] = {}
    for step, name in enumerate(names, start=1):
        yield step, total, f"errors of {name}"
        frame = reference_frame if name == str(right) else _frame(sessions[name], view)
        drawn[name] = frame, measure(reference_frame, frame)

    # Under a name that no method has.
    timed = {name: sessions[name] for name in names} | _without_mirrors(view)

    def as_step(timed_so_far: tuple[int, int]) -> Step:
        done, rounds = timed_so_far
        step = len(names) + 1 + len(names) * done // rounds
        return step, total, f"frame times, round {done} of {rounds}"

    timings = yield from mapped(timing_rounds(timed, eye_path(scene, frames), frames), as_step)
    return Comparison(
        scene=scene.name,
        size=size,
        adapter=adapter_name(),
        versions=versions(),
        command=command,
        reference=str(right),
        reference_frame=reference_frame,
        methods=tuple(MethodResult(name, *drawn[name], timings[name]) for name in names),
        without_mirrors=timings.get(""),
    )


def _without_mirrors(view: View) -> dict[str, Session]:
    """A session that draws the view without its specular meshes, or none where no mesh is left."""
    left = replace(view.scene, meshes=tuple(mesh for mesh in view.scene.meshes if not mesh.specular))
    if not left.meshes:
        return {}
    return {"": Specification.parse(PLAIN).open(replace(view, scene=left))}


def _frame(session: Session, view: View) -> Frame:
    session.draw(view.camera)
    return session.frame(seen=True)
