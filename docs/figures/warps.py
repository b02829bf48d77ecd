"""What per-vertex drawing makes on its way to an image: patches, plans and maps, for figures that show them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import anamorph as an
from anamorph.base.output import to_pixels
from anamorph.frame import View
from anamorph.gpu.device import get_device
from anamorph.gpu.drawing import submit
from anamorph.gpu.targets import read_texture
from anamorph.methods.pervertex import Options
from anamorph.methods.pervertex.atlas import MapKind
from anamorph.methods.pervertex.pervertex import PerVertexDrawing
from anamorph.methods.pervertex.warp import MapPlan
from anamorph.methods.stage import Stage
from anamorph.optics.ray_meshes import BodyRays


@dataclass(frozen=True, eq=False)
class Warp:
    """One patch of a mirror or lens: its plan and its map.

    Parameters
    ----------
    name : str
        Of its body's first mesh.
    body_rays : BodyRays
    faces : (F,) int
        Of the patch, in the ray mesh of its body.
    plan : MapPlan
    map : (H, W, 3) uint8
        The first of its maps.
    """

    name: str
    body_rays: BodyRays
    faces: np.ndarray
    plan: MapPlan
    map: np.ndarray

    def mesh_in_map(self) -> np.ndarray:
        """The patch's edges where its vertices look up the map, (N, 2, 2) in texels from the top left."""
        height, width = self.map.shape[:2]
        lookup = self.plan.lookups[0]
        places = lookup[:, :2] / lookup[:, 2:3] * (width, height)
        corners = np.searchsorted(self.plan.vertices, self.body_rays.rays.faces[self.faces])
        pairs = np.unique(np.sort(corners[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
        return places[pairs[(lookup[pairs, 3] > 0.0).all(axis=1)]]

    def mesh(self, color: tuple[float, float, float], name: str) -> an.Mesh:
        """The patch as a diffuse mesh."""
        optics = self.body_rays.side.optics
        return an.Mesh(
            name,
            optics.positions.astype(np.float32),
            optics.faces[self.faces].astype(np.int32),
            optics.normals.astype(np.float32),
            an.Diffuse(color),
        )


def warps(scene: an.Scene, size: tuple[int, int], options: Options | None = None) -> list[Warp]:
    """Plan and draw the maps of all patches that the scene's camera sees directly."""
    stage = Stage(View(scene, scene.camera, size))
    image = PerVertexDrawing(stage, options or Options()).plan(scene.camera)
    if image is None:
        return []
    atlas = image.level.atlas
    encoder = get_device().create_command_encoder()
    atlas.draw(encoder, stage.buffers, MapKind.COLOR)
    submit(encoder)
    texels = to_pixels(read_texture(atlas.color)[..., :3].astype(np.float32))
    rectangles = iter(projection[-4:].astype(int) for projection in atlas.rectangles.projections)
    found = []
    for seen in image.seen:
        name = scene.meshes[seen.body_rays.body.meshes[0]].name
        for faces, plan in zip(seen.patches, seen.plans, strict=True):
            (width, height, x, y), *_ = [next(rectangles) for _ in plan.projections]
            found.append(Warp(name, seen.body_rays, faces, plan, texels[y : y + height, x : x + width]))
    return found
