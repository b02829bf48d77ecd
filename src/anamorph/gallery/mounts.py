"""What mirrors hang in: a bezel around a lattice of vertices."""

from __future__ import annotations

import numpy as np

from anamorph.gallery.solids import Solid, loft
from anamorph.scene.model import Mesh
from anamorph.scene.pose import WORLD_UP, upright_axes


def bezel(mirror: Mesh, rows: int, columns: int, width: float, depth: float, closed: bool = False) -> Solid:
    """A frame `width` metres wide around a mirror, which shows nothing of it, and reaches `depth` behind it.

    Parameters
    ----------
    mirror : Mesh
        A lattice of rows x columns vertices, as `lattice` joins them.
    rows, columns : int
    width, depth : float
        Metres.
    closed : bool
        Whether it has a back. Without one, a mirror that is bent or turned sinks into it and stays seen.
    """
    index = np.arange(rows * columns).reshape(rows, columns)
    around = np.concatenate([index[0, :-1], index[:-1, -1], index[-1, :0:-1], index[:0:-1, 0]])
    border = mirror.positions[around].astype(float)
    outward = mirror.normals.mean(axis=0, dtype=float)
    outward /= np.linalg.norm(outward)
    middle = border.mean(axis=0)
    across = border - middle
    across -= np.outer(across @ outward, outward)
    # As wide at the sides as is asked, and wider at the corners.
    wider = 1.0 + width / np.linalg.norm(across, axis=1).min()
    behind = float(((mirror.positions - middle) @ outward).min()) - depth
    lifted = across * wider + middle + behind * outward
    rings = [
        *([np.broadcast_to(lifted.mean(axis=0), border.shape)] if closed else []),
        lifted,
        border + (wider - 1.0) * across - 0.004 * outward,
        border - 0.0005 * outward,
    ]
    return loft(np.stack(rings), crease=30.0)


def turned_axes(outward: np.ndarray, degrees: float) -> np.ndarray:
    """Rows right, up and `outward` (a unit vector); right is level, then turned counter-clockwise seen from outside."""
    level, upright, _ = upright_axes(outward, WORLD_UP)
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.stack([cosine * level + sine * upright, cosine * upright - sine * level, outward])
