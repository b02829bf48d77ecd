"""What the overlays mark at vertices: where their rays hit, and whether the maps show it.

Source: Kakimoto et al. 2007, Figures 1 and 16.
"""

from __future__ import annotations

import numpy as np
import wgpu

from anamorph.methods.pervertex.frame_maps import SeenBodies
from anamorph.methods.pervertex.inconsistency import inconsistent_vertices
from anamorph.methods.pervertex.overlay import Overlay
from anamorph.methods.pervertex.surroundings import Surroundings
from anamorph.optics.ray_meshes import Body, Side
from anamorph.scene.camera import Camera

BALL_PIXELS = 18.0
"""Radius of the balls at hits, where nothing magnifies or reduces them."""

CONSISTENT_PIXELS, INCONSISTENT_PIXELS = 1.5, 4.0
"""Radius of the balls on vertices."""

HIT_COLOR = (0.9, 0.03, 0.02)
CONSISTENT_COLOR, INCONSISTENT_COLOR = (0.9, 0.9, 0.9), (0.0, 0.2, 0.9)


class VertexMarks:
    """The marks of every body, drawn with `samples` a pixel.

    Of the overlay "mesh": the wires, and a red ball where each vertex ray hits, which shows in the mirror too. Of
    "inconsistency": a ball on each vertex, blue where the map sees something nearer than the hit, else white.
    """

    def __init__(self, bodies: tuple[Body, ...], overlay: str, samples: int) -> None:
        self._at_hits = overlay == "mesh"
        self._overlays: dict[Side, Overlay] = {
            side: Overlay(side.optics.positions, side.optics.faces, samples) for body in bodies for side in body.sides
        }

    def place(
        self, seen_bodies: SeenBodies | None, camera: Camera, size: tuple[int, int], surroundings: Surroundings
    ) -> None:
        """Put all where a frame from `camera` has it."""
        pixel = 2.0 * np.tan(np.radians(camera.field_of_view) / 2.0) / size[1]
        for seen in () if seen_bodies is None else seen_bodies.seen:
            vertices = seen.body_rays.side.optics.positions
            distances = np.linalg.norm(vertices - camera.position, axis=1)
            if self._at_hits:
                way = distances + seen.distances
                radii = np.where(np.isfinite(way), BALL_PIXELS * pixel * way, 0.0)
                centers, colors = seen.hits, np.broadcast_to(HIT_COLOR, vertices.shape)
            else:
                hidden = inconsistent_vertices(seen, surroundings)
                radii = np.where(hidden, INCONSISTENT_PIXELS, CONSISTENT_PIXELS) * pixel * distances
                centers, colors = vertices, np.where(hidden[:, None], INCONSISTENT_COLOR, CONSISTENT_COLOR)
            self._overlays[seen.body_rays.side].place(centers, radii, colors)

    def draw_in_map(self, seen_bodies: SeenBodies | None, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """Draw what shows in a mirror, into its map."""
        for seen in () if seen_bodies is None or not self._at_hits else seen_bodies.seen:
            self._overlays[seen.body_rays.side].draw_balls(render_pass)

    def draw(self, seen_bodies: SeenBodies | None, render_pass: wgpu.GPURenderPassEncoder) -> None:
        """Draw all, into the image."""
        for seen in () if seen_bodies is None else seen_bodies.seen:
            self._overlays[seen.body_rays.side].draw_balls(render_pass)
            if self._at_hits:
                self._overlays[seen.body_rays.side].draw_wires(render_pass)
