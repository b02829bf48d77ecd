"""The command `anamorph turntable`: a video of the eye going round what it looks at, or from view to view."""

from __future__ import annotations

from pathlib import Path

from anamorph.base.errors import AnamorphError
from anamorph.base.progress import progress_bar
from anamorph.base.steps import drain
from anamorph.base.video import check_video
from anamorph.files.opening import open_source
from anamorph.files.scene_file import Settings
from anamorph.files.source import Source
from anamorph.files.view_file import views_of
from anamorph.methods import Specification
from anamorph.scene.camera import Camera
from anamorph.viewer.remembered import LEAST
from anamorph.viewer.turntable import FRAMES, RATE, between, orbit, turntable


def save_turntable(
    source: Source,
    output: Path,
    method: Specification | None = None,
    size: tuple[int, int] | None = None,
    frames: int | None = None,
    swing: float | None = None,
    path: bool = False,
    samples: int = 1,
    rate: float = RATE,
) -> str:
    """Save it with a progress bar; returns what to report of it.

    With `path`, the eye goes through the views that the viewer remembered and the scene file keeps. Other parameters
    as for `orbit`, `between`, `turntable` and `open_source`.
    """
    check_video(output, size or (1, 1))
    if path and swing is not None:
        raise AnamorphError(f"swing is {swing:g}, and a path has none; leave out one of both")
    with progress_bar(f"opening {source.name}") as report:
        scene, settings = open_source(source)
        if path:
            cameras = _path(source.name, settings, frames)
        else:
            cameras = orbit(scene.camera, FRAMES if frames is None else frames, swing)
        specification = method or Specification.parse(settings.method)
        steps = turntable(output, scene, specification, cameras, size or settings.size, samples, rate)
        return drain(steps, lambda step: report(step.done, step.total, step.what))


def _path(source: str | Path, settings: Settings, frames: int | None) -> list[Camera]:
    views = views_of(settings.view)
    if len(views) < LEAST:
        kept = f"keeps {len(views)} view{'s' * (len(views) != 1)}, and a path needs {LEAST}"
        raise AnamorphError(f"{source}: {kept}; remember them in the viewer (K), and give the scene file saved there")
    return between(views, frames)
