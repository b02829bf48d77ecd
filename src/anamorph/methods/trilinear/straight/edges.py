"""Straight edges as the device draws them: all that the rest of the method takes from this room."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.methods.trilinear.straight.bulk import straight_pieces

STRAIGHT_CORNER = np.dtype([("place", "f4", 2), ("weights", "f4", 2), ("t", "f4"), ("owner", "u4"), ("seen", "u4")])
"""`StraightCorner` of straight.wgsl."""


@dataclass(frozen=True)
class StraightEdges:
    """How straight edges are drawn: see the method's options."""

    tessellate: int
    slices: int
    scene_clip: bool

    def pieces(
        self,
        image: np.ndarray,
        origins: np.ndarray,
        directions: np.ndarray,
        corners: np.ndarray,
        pairs: np.ndarray,
        words: np.ndarray,
    ) -> np.ndarray:
        """What `straight_pieces` finds, (T, 3) of `STRAIGHT_CORNER`; `words` (P, 2): each pair's `owner` and `seen`."""
        found = straight_pieces(
            image, origins, directions, corners, pairs,
            tessellate=self.tessellate, slices=self.slices, scene_clip=self.scene_clip,
        )  # fmt: skip
        records = np.zeros((len(found.pair), 3), STRAIGHT_CORNER)
        records["place"], records["weights"], records["t"] = found.place, found.weights, found.t
        records["owner"], records["seen"] = words[found.pair].T[..., None]
        return records
