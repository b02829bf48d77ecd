"""How often an eye sees the vertices of a scene in mirrors, as a false-colour image."""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from functools import partial

import numpy as np
from scipy.spatial import KDTree

from anamorph.base.errors import AnamorphError
from anamorph.frame import Frame
from anamorph.measure.heatmap import faint
from anamorph.scene.camera import Camera
from anamorph.scene.model import Scene
from anamorph.viewer.failures import failure_text
from anamorph.viewer.measured import Color
from anamorph.viewer.point_search import vertex_counts
from anamorph.viewer.worker import Worker

COUNT_COLORS: Mapping[str, Color] = {
    "not seen": (0, 0, 4),
    "once": (87, 16, 110),
    "twice": (188, 55, 84),
    "3 times": (249, 142, 9),
    "4 times or more": (255, 220, 0),
}
"""Of how often a vertex is seen in mirrors: lighter, the more often; the colour-blind, too, tell them apart."""

FAINTEST = 242.0
"""The grey of what is white in a faint image."""

PATIENCE = 0.01
"""Seconds that a step of counting waits for the count."""

Counts = tuple[np.ndarray, ...]


class Counting:
    """Counts for one eye and scene after the other, beside the drawing.

    Attributes
    ----------
    failure : str
        Why there is no count, where it has failed.
    busy : bool
        Whether what was asked for last is still to be counted.
    """

    def __init__(self) -> None:
        self._worker = Worker[Counts]()
        self._counted: object = None
        self.failure = ""

    @property
    def busy(self) -> bool:
        return self._worker.busy

    def counting(self, scene: Scene, eye: Camera, size: tuple[int, int]) -> Generator[None, None, Counts | None]:
        """Wait in steps for what `vertex_counts` returns; None where it fails."""
        key = scene, eye, size
        if self._counted != key:
            self._counted, self.failure = key, ""
        while True:
            try:
                counts = self._worker.get(key, partial(vertex_counts, *key), PATIENCE)
            except Exception as error:
                self.failure = failure_text(error, "counting")
                return None
            if not self._worker.busy:
                return counts
            yield


def count_colors(frame: Frame, scene: Scene, counts: Sequence[np.ndarray]) -> np.ndarray:
    """How often the vertex is seen that is nearest to what each pixel sees, over the image: (H, W, 4) uint8 sRGB.

    Parameters
    ----------
    frame : Frame
        With its seen buffers.
    scene : Scene
    counts : sequence of (V,) int64
        For each mesh of the scene.
    """
    if frame.position is None or frame.object_id is None:
        raise AnamorphError("frame: has no 'position' buffer; draw it with seen=True")
    colors = faint(frame.color)
    for number, (mesh, count) in enumerate(zip(scene.meshes, counts, strict=True), start=1):
        shown = frame.object_id == number
        if mesh.specular or not shown.any():
            continue
        # Where the image is dark, so are the colours, a little: shapes stay to be seen.
        _, nearest = KDTree(np.asarray(mesh.positions, float)).query(frame.position[shown], workers=-1)
        own = np.array(list(COUNT_COLORS.values()))[np.minimum(count[nearest], len(COUNT_COLORS) - 1)]
        colors[shown, :3] = own * (colors[shown, :3] / FAINTEST)
    return colors
