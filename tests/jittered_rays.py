"""A ray mesh whose rays go where they will."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from anamorph import cameras
from anamorph.raymesh import RayMesh


def jittered(size: tuple[int, int], weighted: bool, random: np.random.Generator) -> RayMesh:
    """200 ray triangles that fill an image, whose rays go where they will."""
    x, y = np.meshgrid(np.linspace(0.0, 1.0, 11), np.linspace(0.0, 1.0, 11))
    inside = (x > 0.0) & (x < 1.0) & (y > 0.0) & (y < 1.0)
    places = np.stack([x, y], axis=-1) + inside[..., None] * random.uniform(-0.03, 0.03, (11, 11, 2))
    origins = np.concatenate([places - 0.5, np.zeros((11, 11, 1))], axis=-1) + 0.06 * random.normal(size=(11, 11, 3))
    ways = np.concatenate([places - 0.5, np.ones((11, 11, 1))], axis=-1) + 0.3 * random.normal(size=(11, 11, 3))
    rays = cameras.from_grid(origins, ways * random.uniform(0.5, 2.0, (11, 11, 1)), size)
    weight = random.uniform(0.5, 2.0, (121, 1)) if weighted else np.ones((121, 1))
    return replace(rays, image=np.column_stack([places.reshape(-1, 2) * size, np.ones(121)]) * weight)
