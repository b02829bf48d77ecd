"""The nodes of a glTF file: which are shown, where they stand, and how the joints of a skin move what hangs on them.

Format: glTF 2.0 specification, sections 3.5 (scenes and nodes) and 3.7.3 (skins), and KHR_node_visibility. Nothing
moves: animations are passed over, and joints are where their nodes put them.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from anamorph.base.notes import note
from anamorph.files.gltf.accessors import numbers
from anamorph.files.gltf.container import Container, extension


def world_matrices(container: Container) -> list[np.ndarray]:
    """Where each node stands: (4, 4) float64, from its own coordinates to the world's."""
    nodes = container.header.get("nodes", [])
    parents = _parents(container)
    matrices = [np.eye(4)] * len(nodes)
    waiting, done = [number for number, parent in enumerate(parents) if parent is None], 0
    while waiting:
        number = waiting.pop()
        node, parent, done = container.entry("nodes", number), parents[number], done + 1
        own = _matrix(container, node, f"node {number}")
        with np.errstate(all="ignore"):
            matrices[number] = own if parent is None else matrices[parent] @ own
        waiting += node.get("children", [])
    if done < len(nodes):
        container.wrong("its glTF header is damaged (a node is among its own descendants)")
    return matrices


def shown_nodes(container: Container) -> list[int]:
    """The nodes of the file's scene, in the order of their numbers; where it has no scene, all of them."""
    scenes, parents = container.header.get("scenes", []), _parents(container)
    if scenes:
        chosen = container.header.get("scene", 0)
        waiting = list(container.entry("scenes", chosen).get("nodes", []))
        if len(scenes) > 1:
            note(f"{container.path}: has {len(scenes)} scenes, of which number {chosen} is shown")
    else:
        waiting = [number for number, parent in enumerate(parents) if parent is None]
    found: set[int] = set()
    while waiting:
        number = waiting.pop()
        node = container.entry("nodes", number)
        if number not in found and extension(node, "KHR_node_visibility").get("visible", True):
            found.add(number)
            waiting += node.get("children", [])
    return sorted(found)


def joint_matrices(container: Container, number: object, world: list[np.ndarray]) -> np.ndarray:
    """What each joint of a skin does to the vertices that hang on it, (J, 4, 4)."""
    skin, where = container.entry("skins", number), f"skin {number}"
    joints = skin.get("joints", [])
    placed = [world[joint] for joint in joints if container.entry("nodes", joint) is not None]
    if not placed:
        container.wrong(f"{where}: has no joints")
    if "inverseBindMatrices" not in skin:
        return np.stack(placed)
    inverse = numbers(container, skin["inverseBindMatrices"], f"inverse bind matrices of {where}", "MAT4")
    if len(inverse) < len(placed):
        container.wrong(f"{where}: has {len(inverse)} inverse bind matrices for {len(placed)} joints")
    return np.stack(placed) @ inverse[: len(placed)].reshape(-1, 4, 4).transpose(0, 2, 1)


def _parents(container: Container) -> list[int | None]:
    parents: list[int | None] = [None] * len(container.header.get("nodes", []))
    for number, _ in enumerate(parents):
        for child in container.entry("nodes", number).get("children", []):
            container.entry("nodes", child)
            if parents[child] is not None:
                container.wrong(f"its glTF header is damaged (node {child} has two parents)")
            parents[child] = number
    return parents


def _matrix(container: Container, node: dict[str, Any], where: str) -> np.ndarray:
    """From the coordinates of a node to its parent's; glTF writes matrices column by column."""
    if "matrix" in node:
        return _vector(container, node, "matrix", 16, where).reshape(4, 4).T
    x, y, z, w = _vector(container, node, "rotation", 4, where, (0.0, 0.0, 0.0, 1.0))
    length = x * x + y * y + z * z + w * w
    if length == 0.0:
        container.wrong(f"{where}: its rotation is 0, which turns nothing")
    turned = np.array([
        [w * w + x * x - y * y - z * z, 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), w * w - x * x + y * y - z * z, 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), w * w - x * x - y * y + z * z],
    ])  # fmt: skip
    matrix = np.eye(4)
    with np.errstate(all="ignore"):
        matrix[:3, :3] = turned / length * _vector(container, node, "scale", 3, where, (1.0, 1.0, 1.0))
    matrix[:3, 3] = _vector(container, node, "translation", 3, where, (0.0, 0.0, 0.0))
    return matrix


def _vector(
    container: Container, node: dict[str, Any], key: str, length: int, where: str, default: tuple[float, ...] = ()
) -> np.ndarray:
    values = node.get(key, default)
    plain = isinstance(values, list | tuple) and all(type(value) in (int, float) for value in values)
    if not plain or len(values) != length:
        container.wrong(f"{where}: its {key} is {values!r:.60}, and must be {length} numbers")
    return np.array(values, float)
