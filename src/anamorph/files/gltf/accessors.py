"""The numbers of a glTF file: accessors, dense and sparse, as arrays.

Format: glTF 2.0 specification, section 3.6.2 (accessors), and KHR_mesh_quantization, which allows integers where the
core has floats.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from anamorph.base.limits import MOST_NUMBERS
from anamorph.files.gltf.container import Container

COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
UNSIGNED = (5121, 5123, 5125)
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


def numbers(container: Container, number: object, what: str, *kinds: str) -> np.ndarray:
    """The elements of an accessor, (N, width) float64; integers that stand for fractions are these fractions.

    Parameters
    ----------
    number : int
        Which accessor.
    what : str
        What it is used for, for messages.
    *kinds : str
        The types of which it must be one, as "VEC3".
    """
    entry, values = _elements(container, number, what, kinds)
    if entry.get("normalized") is True and values.dtype.kind in "iu":
        return np.maximum(values / np.iinfo(values.dtype).max, -1.0)
    return values.astype(float)


def whole_numbers(container: Container, number: object, what: str, kind: str) -> np.ndarray:
    """The elements of an accessor of unsigned integers, (N, width) int64."""
    component = container.entry("accessors", number).get("componentType")
    if component not in UNSIGNED:
        container.wrong(f"accessor {number}, {what}: its componentType is {component!r:.60}, no unsigned integer's")
    return _elements(container, number, what, (kind,))[1].astype(np.int64)


def _elements(
    container: Container, number: object, what: str, kinds: tuple[str, ...]
) -> tuple[dict[str, Any], np.ndarray]:
    entry, where = container.entry("accessors", number), f"accessor {number}, {what}"
    kind, count = entry.get("type"), container.whole(entry, "count", where)
    if kind not in kinds:
        container.wrong(f"{where}: is of type {kind!r:.60}, and must be {' or '.join(kinds)}")
    component, width = entry.get("componentType"), WIDTHS[kind]
    if component not in COMPONENTS:
        container.wrong(f"{where}: its componentType is {component!r:.60} (known: {', '.join(map(str, COMPONENTS))})")
    if count * width > MOST_NUMBERS:
        container.wrong(f"{where}: has {count} elements, more than {MOST_NUMBERS // width}")
    form = np.dtype(COMPONENTS[component])
    if "bufferView" in entry:
        values = _packed(container, entry, where, count, width, form)
    else:
        values = np.zeros((count, width), form)
    if "sparse" in entry:
        values = _replaced(container, entry["sparse"], where, values)
    return entry, values


def _packed(
    container: Container, entry: dict[str, Any], where: str, count: int, width: int, form: np.dtype
) -> np.ndarray:
    """The elements that lie in a buffer view, side by side or a stride apart."""
    data, start = container.view(entry["bufferView"]), container.whole(entry, "byteOffset", where, 0)
    size = width * form.itemsize
    stride = container.whole(container.entry("bufferViews", entry["bufferView"]), "byteStride", where, size)
    if stride < size:
        container.wrong(f"{where}: byteStride is {stride}, less than an element's {size} bytes")
    if count and start + (count - 1) * stride + size > len(data):
        container.wrong(f"{where}: has {count} elements of {size} bytes, more than its {len(data) - start} bytes hold")
    return np.ndarray((count, width), form, data, start if count else 0, (stride, form.itemsize)).copy()


def _replaced(container: Container, sparse: Any, where: str, values: np.ndarray) -> np.ndarray:
    """The elements with those put in that a sparse accessor names."""
    if not isinstance(sparse, dict) or not all(isinstance(sparse.get(key), dict) for key in ("indices", "values")):
        container.wrong(f"{where}: its sparse part is damaged")
    count, where = container.whole(sparse, "count", where), f"{where}, sparse"
    component = sparse["indices"].get("componentType")
    if component not in UNSIGNED:
        container.wrong(f"{where}: the componentType of its indices is {component!r:.60}, no unsigned integer's")
    form = np.dtype(COMPONENTS[component])
    places = _packed(container, sparse["indices"], where, count, 1, form)[:, 0].astype(np.int64)
    if count and places.max() >= len(values):
        container.wrong(f"{where}: names element {places.max()}, and there are {len(values)}")
    values[places] = _packed(container, sparse["values"], where, count, values.shape[1], values.dtype)
    return values
