"""All families of random scenes, by name, and the scenes on which the tests compare the package with the tracer."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from oracle import hard_families, lens_families, mirror_families
from oracle.scene import Scene

FAMILIES: dict[str, Callable[[np.random.Generator], Scene]] = {
    "ball": mirror_families.balls,
    "convex-cap": mirror_families.convex_caps,
    "concave-cap": mirror_families.concave_caps,
    "inside-ball": mirror_families.inside_balls,
    "toroid": mirror_families.toroids,
    "asphere": mirror_families.aspheres,
    "wavy-mesh": mirror_families.wavy_meshes,
    "cylinder": mirror_families.cylinders,
    "cone": mirror_families.cones,
    "two-balls": mirror_families.two_balls,
    "facing-pair": mirror_families.facing_pairs,
    "wall-mirror": mirror_families.wall_mirrors,
    "spherical-lens": lens_families.spherical_lenses,
    "toric-lens": lens_families.toric_lenses,
    "worn-lens": lens_families.worn_lenses,
    "lens-near-focus": lens_families.lenses_near_focus,
    "near-mirror": hard_families.near_mirrors,
    "near-things": hard_families.near_things,
    "touching-things": hard_families.touching_things,
    "coarse-ball": hard_families.coarse_balls,
    "coarse-cap": hard_families.coarse_caps,
    "meshed-ball": hard_families.meshed_balls,
    "knife-lens": hard_families.knife_lenses,
    "micrometres": hard_families.small_families,
    "kilometres": hard_families.large_families,
    "far-away": hard_families.far_families,
    "large-ground": hard_families.large_grounds,
}


def make(family: str, seed: int) -> Scene:
    """One scene of a family: the same for the same seed, whatever other families there are."""
    return FAMILIES[family](np.random.default_rng([seed, *family.encode()]))


AGREEING = [
    ("ball", 0),
    ("convex-cap", 1),
    ("concave-cap", 2),
    ("inside-ball", 2),
    ("toroid", 1),
    ("asphere", 2),
    ("wavy-mesh", 1),
    ("cylinder", 0),
    ("two-balls", 2),
    ("facing-pair", 1),
    ("wall-mirror", 3),
    ("toric-lens", 2),
    ("worn-lens", 2),
    ("near-mirror", 3),
    ("touching-things", 0),
    ("meshed-ball", 1),
    ("micrometres", 2),
    ("kilometres", 0),
    ("coarse-ball", 2),
    ("coarse-cap", 2),
    ("coarse-cap", 4),
    ("spherical-lens", 1),
    ("lens-near-focus", 1),
    ("large-ground", 3),
    ("far-away", 1),
]
"""Families and seeds on which the tests hold `raytrace` to the tracer."""
