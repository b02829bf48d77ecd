"""Which mirror meshes of a scene are one mirror: those that touch along a border."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from anamorph.scene.model import Mirror, Scene


def connected_mirrors(scene: Scene) -> list[tuple[int, ...]]:
    """Indices of the mirror meshes, those of one body together.

    These share two vertices or more, or their names agree before the first "/" and the boxes around them touch.
    """
    mirrors = [index for index, mesh in enumerate(scene.meshes) if isinstance(mesh.material, Mirror)]
    if not mirrors:
        return []
    parts = [np.asarray(scene.meshes[index].positions, float) for index in mirrors]
    positions = np.concatenate(parts)
    owner = np.repeat(np.arange(len(mirrors)), [len(part) for part in parts])
    touching = coo_array((np.ones(len(owner)), (owner, welded(positions)))).tocsr()
    touching.data[:] = 1.0
    shared = (touching @ touching.T).toarray() >= 2
    lows, highs = np.stack([part.min(axis=0) for part in parts]), np.stack([part.max(axis=0) for part in parts])
    boxes = ((lows[:, None] <= highs) & (lows <= highs[:, None])).all(axis=2)
    names = np.array([scene.meshes[index].name.split("/")[0] for index in mirrors])
    _, label = connected_components(coo_array(shared | (boxes & (names[:, None] == names))), directed=False)
    return [tuple(mirrors[i] for i in np.flatnonzero(label == each)) for each in range(label.max() + 1)]


def welded(positions: np.ndarray) -> np.ndarray:
    """Numbers of places, (N,), the same for `positions` (N, 3) within a millionth of their extent."""
    grid = 1e-6 * (float(np.ptp(positions, axis=0).max()) or 1.0)
    _, place = np.unique(np.rint(positions / grid).astype(np.int64), axis=0, return_inverse=True)
    return place.ravel()
