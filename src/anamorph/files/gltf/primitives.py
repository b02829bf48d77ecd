"""The primitives of glTF meshes as triangles, in the shape that morph weights give them.

Format: glTF 2.0 specification, sections 3.7.2.1 (primitives and their modes) and 3.7.2.2 (morph targets).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from anamorph.files.gltf.accessors import numbers, whole_numbers
from anamorph.files.gltf.container import Container

TRIANGLES, TRIANGLE_STRIP, TRIANGLE_FAN = 4, 5, 6
"""Modes with faces; those below are points and lines."""


@dataclass(frozen=True, eq=False)
class Primitive:
    """Triangles of one material.

    Parameters
    ----------
    faces : (F, 3) int64
    values : dict of (V, width) float64
        The attributes that are understood, by their names in the file: POSITION, NORMAL, TEXCOORD_n, COLOR_0.
    joints : (V, J) int64, optional
        Which joints of a skin move each vertex.
    shares : (V, J) float64, optional
        How much each of them does.
    material : int or None
        Its number in the file.
    """

    faces: np.ndarray
    values: dict[str, np.ndarray]
    joints: np.ndarray | None
    shares: np.ndarray | None
    material: object


def faces_of(mode: int, order: np.ndarray) -> np.ndarray:
    """The triangles (F, 3) that a mode makes of vertices in an order (N,), all wound as the first is."""
    if mode == TRIANGLES:
        return order[: len(order) // 3 * 3].reshape(-1, 3)
    first = np.arange(max(len(order) - 2, 0))
    if mode == TRIANGLE_FAN:
        return np.stack([order[first + 1], order[first + 2], order[np.zeros_like(first)]], axis=1)
    odd = first % 2
    return np.stack([order[first], order[first + 1 + odd], order[first + 2 - odd]], axis=1)


def primitive(container: Container, entry: dict[str, Any], weights: Sequence[float], where: str) -> Primitive | None:
    """What an entry of a mesh's primitives stands for; None for points and lines.

    Parameters
    ----------
    weights : sequence of float
        Of its morph targets; those that are missing are 0.
    where : str
        What to call the mesh in messages.
    """
    mode, attributes = entry.get("mode", TRIANGLES), entry.get("attributes", {})
    if mode not in range(7):
        container.wrong(f"{where}: its mode is {mode!r:.60}, and must be a number from 0 to 6")
    if mode < TRIANGLES or "POSITION" not in attributes:
        return None
    values = _morphed(container, entry, weights, where)
    count = len(values["POSITION"])
    for name, each in values.items():
        if len(each) != count:
            container.wrong(f"{where}: {name} has {len(each)} elements, and POSITION {count}")
    order = np.arange(count)
    if "indices" in entry:
        order = whole_numbers(container, entry["indices"], f"indices of {where}", "SCALAR")[:, 0]
    if mode == TRIANGLES and len(order) % 3:
        container.wrong(f"{where}: has {len(order)} corners of triangles, which is no multiple of 3")
    joints, shares = _joints(container, attributes, count, where)
    return Primitive(faces_of(mode, order), values, joints, shares, entry.get("material"))


def _types(name: str) -> tuple[str, ...]:
    """The types that an attribute may have; none where it is not understood."""
    if name in ("POSITION", "NORMAL"):
        return ("VEC3",)
    if name == "COLOR_0":
        return ("VEC3", "VEC4")
    return ("VEC2",) if name.startswith("TEXCOORD_") else ()


def _morphed(
    container: Container, entry: dict[str, Any], weights: Sequence[float], where: str
) -> dict[str, np.ndarray]:
    """The attributes, with each morph target's displacements added as often as its weight says."""
    values = {
        name: numbers(container, number, f"{name} of {where}", *_types(name))
        for name, number in entry["attributes"].items()
        if _types(name)
    }
    targets = entry.get("targets", [])
    if len(weights) > len(targets):
        container.wrong(f"{where}: has {len(weights)} morph weights for {len(targets)} targets")
    for weight, target in zip(weights, targets, strict=False):
        for name in [name for name in target if weight and name in values]:
            moved = numbers(container, target[name], f"morphed {name} of {where}", *_types(name))
            if moved.shape != values[name].shape:
                container.wrong(f"{where}: a morph target's {name} has {moved.shape}, not {values[name].shape}")
            values[name] = values[name] + weight * moved
    return values


def _joints(
    container: Container, attributes: dict[str, Any], count: int, where: str
) -> tuple[np.ndarray | None, np.ndarray | None]:
    """All sets of joints side by side, and their shares, which add up to 1.

    A vertex that no joint has a share in follows its first one.
    """
    sets = [name.removeprefix("JOINTS_") for name in attributes if name.startswith("JOINTS_")]
    if not sets:
        return None, None
    joints = np.hstack(
        [whole_numbers(container, attributes[f"JOINTS_{each}"], f"joints of {where}", "VEC4") for each in sets]
    )
    shares = np.hstack(
        [numbers(container, attributes.get(f"WEIGHTS_{each}"), f"weights of {where}", "VEC4") for each in sets]
    )
    if len(joints) != count or len(shares) != count:
        container.wrong(f"{where}: has {len(joints)} joints and {len(shares)} weights for {count} vertices")
    total = shares.sum(axis=1, keepdims=True)
    first = np.arange(shares.shape[1]) == 0
    return joints, np.where(total > 0.0, shares / np.where(total > 0.0, total, 1.0), first)
