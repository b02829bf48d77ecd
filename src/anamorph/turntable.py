"""The command `anamorph turntable`: a video of the eye going round what it looks at."""

from __future__ import annotations

from pathlib import Path

from anamorph.methods import parse
from anamorph.progress import progress_bar
from anamorph.scene.cad import FaceChoice
from anamorph.scene.opening import open_scene
from anamorph.steps import drain
from anamorph.video import check_video
from anamorph.viewer.facts import Progress
from anamorph.viewer.turntable import FRAMES, RATE, orbit, turntable


def save_turntable(
    source: str,
    output: Path,
    method: str | None = None,
    size: tuple[int, int] | None = None,
    frames: int = FRAMES,
    swing: float | None = None,
    samples: int = 1,
    rate: float = RATE,
    choice: FaceChoice | None = None,
    mirror_of: str | None = None,
) -> str:
    """Save it with a progress bar; returns what to tell of it. Parameters as for `orbit`, `turntable`, `open_scene`."""
    if method:
        parse(method)
    check_video(output, size or (1, 1))
    with progress_bar(f"opening {source}") as tell:
        scene, settings = open_scene(source, choice, mirror_of)

        def told(step: Progress) -> None:
            tell(step.done, step.total, step.what)

        cameras = orbit(scene.camera, frames, swing)
        specification = method or settings.method
        steps = turntable(output, scene, specification, cameras, size or settings.size, samples, rate)
        return drain(steps, told)
