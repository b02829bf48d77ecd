"""The scene's triangles: those that stand still, and those of objects that have moved."""

from __future__ import annotations

import numpy as np

from anamorph.gpu.buffers import storage_buffer
from anamorph.gpu.device import get_device
from anamorph.methods.virtual.triangle_records import SCENE_TRIANGLE, surfaces_of, triangles_of
from anamorph.methods.virtual.triangle_tree import triangle_tree
from anamorph.scene.geometry import Geometry
from anamorph.scene.model import Scene


class MovingScene:
    """A scene of which some objects move.

    Attributes
    ----------
    buffers : (triangles, surfaces)
        As met.wgsl reads them.
    still, moving : TriangleTree
    """

    def __init__(self, scene: Scene, geometry: Geometry) -> None:
        self._scene, self._geometry = scene, geometry
        self._moves = np.zeros(len(scene.meshes) + 1, bool)
        self.buffers = storage_buffer(triangles_of(geometry, scene)), storage_buffer(surfaces_of(scene))
        self._part()

    def _part(self) -> None:
        corners, moves = _corners(self._geometry), self._moves[self._geometry.face_object]
        self.still, self.moving = (triangle_tree(corners, np.flatnonzero(each)) for each in (~moves, moves))

    def moved(self, geometry: Geometry) -> bool:
        """Follow the vertices; whether others stand still now than before."""
        changed = (geometry.positions != self._geometry.positions).any(axis=1)
        moves = self._moves.copy()
        moves[np.unique(geometry.vertex_object[changed])] = True
        self._geometry = geometry
        records = triangles_of(geometry, self._scene)
        for number in np.flatnonzero(moves):
            first, last = geometry.first_face[number - 1 : number + 1].tolist()
            get_device().queue.write_buffer(
                self.buffers[0], first * SCENE_TRIANGLE.itemsize, np.ascontiguousarray(records[first:last])
            )
        if (moves == self._moves).all():
            self.moving = self.moving.moved(_corners(geometry))
            return False
        self._moves = moves
        self._part()
        return True


def _corners(geometry: Geometry) -> np.ndarray:
    return np.asarray(geometry.positions, float)[geometry.faces]
