"""Embree's C interface, called from compiled code on all the cores.

The Python wrapper `embreex` holds the interpreter lock and casts one ray at a time. The library inside its wheel can do
more: this module finds it, describes the few structures it needs by hand (Embree 4, rtcore_ray.h and rtcore_scene.h),
and calls it through its address. Because nothing but `rays.direct_works` checks such a description, nobody should use a
tree from here before that has passed; `rays.Caster` sees to it.
"""

from __future__ import annotations

import ctypes
import importlib.util
import weakref
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from anamorph.base.compiled import compiled, cores

PACKET = 16
MISS = 0xFFFFFFFF
LEAST = 1e-18
"""Embree takes a smaller part of a direction for a positive one of this size; in a packet all rays may then miss."""

KEPT = 4
"""Trees over triangles that stay are kept, those asked for last: a scene has one to three, and an edited one shares the
largest with the scene before."""

# RTCRayHit16 is a structure of arrays: these are the indices of its arrays of 16 words.
# instPrimID ends it in builds with instance arrays; the spare rows leave room whatever the build.
ORIGIN, NEAR, DIRECTION, TIME, FAR, MASK, IDENTITY, RAY_FLAGS = 0, 3, 4, 7, 8, 9, 10, 11
NORMAL, U, V, PRIMITIVE, GEOMETRY, INSTANCE = 12, 15, 16, 17, 18, 19
ROWS = 24

_TRIANGLES, _INDICES, _VERTICES, _UINT3, _FLOAT3 = 0, 0, 1, 0x5003, 0x9003
_DYNAMIC, _ROBUST = 1 << 0, 1 << 2
_LOW, _MEDIUM, _REFIT = 0, 1, 3
_COHERENT = 1 << 16
_ALL_FEATURES = 0xFFFFFFFF
_SIGNATURES = {
    "rtcNewDevice": (ctypes.c_void_p, [ctypes.c_char_p]),
    "rtcGetDeviceProperty": (ctypes.c_ssize_t, [ctypes.c_void_p, ctypes.c_int]),
    "rtcGetDeviceError": (ctypes.c_int, [ctypes.c_void_p]),
    "rtcNewScene": (ctypes.c_void_p, [ctypes.c_void_p]),
    "rtcSetSceneFlags": (None, [ctypes.c_void_p, ctypes.c_int]),
    "rtcSetSceneBuildQuality": (None, [ctypes.c_void_p, ctypes.c_int]),
    "rtcCommitScene": (None, [ctypes.c_void_p]),
    "rtcReleaseScene": (None, [ctypes.c_void_p]),
    "rtcNewGeometry": (ctypes.c_void_p, [ctypes.c_void_p, ctypes.c_int]),
    "rtcSetSharedGeometryBuffer": (
        None,
        [ctypes.c_void_p, ctypes.c_int, ctypes.c_uint, ctypes.c_int, ctypes.c_void_p] + [ctypes.c_size_t] * 3,
    ),
    "rtcSetGeometryBuildQuality": (None, [ctypes.c_void_p, ctypes.c_int]),
    "rtcUpdateGeometryBuffer": (None, [ctypes.c_void_p, ctypes.c_int, ctypes.c_uint]),
    "rtcCommitGeometry": (None, [ctypes.c_void_p]),
    "rtcAttachGeometry": (ctypes.c_uint, [ctypes.c_void_p, ctypes.c_void_p]),
    "rtcReleaseGeometry": (None, [ctypes.c_void_p]),
}


class EmbreeUnavailable(RuntimeError):
    """The library cannot be called directly here; the wrapper has to do."""


@cache
def embree4() -> tuple[ctypes.CDLL, int, int]:
    """The library, its one device, and the address of rtcIntersect16."""
    spec = importlib.util.find_spec("embreex")
    if spec is None or spec.origin is None:
        raise EmbreeUnavailable("embreex is not installed")
    package = Path(spec.origin).parent
    folders = (package.parent / "embreex.libs", package / ".dylibs", package)
    files = sorted(file for folder in folders if folder.is_dir() for file in folder.glob("*embree4*"))
    if not files:
        raise EmbreeUnavailable("no libembree4 inside embreex")
    # The wrapper loads the threading library that libembree4 needs.
    importlib.import_module("embreex.rtcore_scene")
    try:
        library = ctypes.CDLL(str(files[0]))
        for name, (result, arguments) in _SIGNATURES.items():
            function = getattr(library, name)
            function.restype, function.argtypes = result, arguments
        address = ctypes.cast(library.rtcIntersect16, ctypes.c_void_p).value
    except (OSError, AttributeError) as error:
        raise EmbreeUnavailable(str(error)) from error
    # Left to itself the threading library may well build trees on one core.
    device = library.rtcNewDevice(f"threads={cores()}".encode())
    if not device or not address or not 40000 <= library.rtcGetDeviceProperty(device, 0) < 50000:
        raise EmbreeUnavailable("libembree4 does not answer as Embree 4")
    return library, device, address


class Upkeep(Enum):
    """How a tree follows vertices that move.

    NONE: not at all; rays find their way through it soonest. REFIT: its boxes grow and shrink, and it stays the tree
    that it was. REBUILD: it is made anew, in haste.
    """

    NONE = 0
    REFIT = 1
    REBUILD = 2


_QUALITIES = {Upkeep.NONE: (_MEDIUM, _MEDIUM), Upkeep.REFIT: (_LOW, _REFIT), Upkeep.REBUILD: (_LOW, _LOW)}
"""Build qualities of scene and geometry. Only scenes of low quality keep a tree for each geometry, to be refitted."""


class EmbreeTree:
    """Embree's tree over one set of triangles.

    Parameters
    ----------
    positions : (V, 3) float32
    faces : (F, 3) int32
    upkeep : Upkeep
        What `move` will do.

    Attributes
    ----------
    address : int
        Where Embree has it, as long as this is there.
    """

    def __init__(self, positions: np.ndarray, faces: np.ndarray, upkeep: Upkeep = Upkeep.NONE) -> None:
        library, device, _ = embree4()
        self.upkeep = upkeep
        self._geometry: int | None = None
        # Embree reads the last vertex with a 16-byte load.
        self._vertices = np.zeros((len(positions) + 1, 3), np.float32)
        self._vertices[:-1] = positions
        self._faces = np.ascontiguousarray(faces, np.uint32)
        scene = library.rtcNewScene(device)
        self.address: int = scene
        self._release = weakref.finalize(self, library.rtcReleaseScene, scene)
        library.rtcSetSceneFlags(scene, _ROBUST if upkeep is Upkeep.NONE else _ROBUST | _DYNAMIC)
        scene_quality, geometry_quality = _QUALITIES[upkeep]
        library.rtcSetSceneBuildQuality(scene, scene_quality)
        if len(faces):
            self._geometry = geometry = library.rtcNewGeometry(device, _TRIANGLES)
            library.rtcSetGeometryBuildQuality(geometry, geometry_quality)
            for kind, layout, array, count in (
                (_VERTICES, _FLOAT3, self._vertices, len(positions)),
                (_INDICES, _UINT3, self._faces, len(faces)),
            ):
                library.rtcSetSharedGeometryBuffer(geometry, kind, 0, layout, array.ctypes.data, 0, 12, count)
            library.rtcCommitGeometry(geometry)
            library.rtcAttachGeometry(scene, geometry)
            # The scene keeps it as long as it is there itself.
            library.rtcReleaseGeometry(geometry)
        self._commit()

    def move(self, positions: np.ndarray) -> None:
        """Put the vertices at `positions` (V, 3), while no ray is on its way; not for a tree without upkeep."""
        assert self.upkeep is not Upkeep.NONE
        self._vertices[:-1] = positions
        if self._geometry is not None:
            library = embree4()[0]
            library.rtcUpdateGeometryBuffer(self._geometry, _VERTICES, 0)
            library.rtcCommitGeometry(self._geometry)
            self._commit()

    def _commit(self) -> None:
        library, device, _ = embree4()
        library.rtcCommitScene(self.address)
        if library.rtcGetDeviceError(device):
            raise EmbreeUnavailable("Embree could not build its tree")


@dataclass(frozen=True, eq=False)
class EmbreeTriangles:
    """Triangles that are equal to all others with the same numbers, to the last bit; nobody may write into them.

    Parameters
    ----------
    positions : (V, 3) float32
    faces : (F, 3) int32
    """

    positions: np.ndarray
    faces: np.ndarray

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, EmbreeTriangles):
            return NotImplemented
        pairs = (self.positions, other.positions), (self.faces, other.faces)
        return all(np.array_equal(one.view(np.uint32), another.view(np.uint32)) for one, another in pairs)

    def __hash__(self) -> int:
        return hash((self.positions.shape, self.faces.shape))


@lru_cache(KEPT)
def tree_over(triangles: EmbreeTriangles) -> EmbreeTree:
    """A tree without upkeep; that of the same triangles, where it is still there."""
    return EmbreeTree(triangles.positions, triangles.faces, Upkeep.NONE)


class EmbreeForest:
    """Trees that rays meet as one.

    Parameters
    ----------
    trees : sequence of EmbreeTree
        Cast at one after the other: those that hide much, or are small, first.
    numbers : (F,) int32
        How the triangles of all the trees are counted, one tree after the other.
    """

    def __init__(self, trees: Sequence[EmbreeTree], numbers: Sequence[np.ndarray]) -> None:
        self.trees = tuple(trees)
        self._addresses = np.array([tree.address for tree in trees], np.int64)
        self._firsts = np.cumsum([0, *map(len, numbers)])
        self._numbers = np.concatenate([np.zeros(0, np.int32), *numbers])
        self._arguments = {coherent: _query_arguments(coherent) for coherent in (False, True)}

    def cast(
        self,
        origins: np.ndarray,
        directions: np.ndarray,
        near: np.ndarray,
        coherent: bool,
        distance: np.ndarray,
        triangle: np.ndarray,
        barycentric: np.ndarray,
    ) -> None:
        """Fill `distance` (N,), `triangle` (N,) and `barycentric` (N, 2) for rays (N, 3): one core, no lock held."""
        store = np.zeros((ROWS + 2) * PACKET, np.float32)
        call = (embree4()[2], self._arguments[coherent].ctypes.data)
        forest = (self._addresses, self._firsts, self._numbers)
        _cast(store, *call, *forest, origins, directions, near, distance, triangle, barycentric)


def _query_arguments(coherent: bool) -> np.ndarray:
    """RTCIntersectArguments: flags, feature mask, then pointers that stay null; with room to spare."""
    arguments = np.zeros(16, np.uint32)
    arguments[:2] = _COHERENT if coherent else 0, _ALL_FEATURES
    return arguments


def _generate_call(typing: Any, address: Any, valid: Any, scene: Any, packet: Any, arguments: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        pointer = cgutils.voidptr_t
        function = builder.inttoptr(values[0], ir.FunctionType(ir.VoidType(), [pointer] * 4).as_pointer())
        builder.call(function, [builder.inttoptr(value, pointer) for value in values[1:]])
        return context.get_dummy_value()

    return types.void(*[types.intp] * 5), generate


_call: Any = intrinsic(_generate_call)
"""Call the C function at an address with four pointers: _call(address, valid, scene, packet, arguments)."""


@compiled
def _cast(
    store: np.ndarray,
    address: int,
    arguments: int,
    scenes: np.ndarray,
    firsts: np.ndarray,
    numbers: np.ndarray,
    origins: np.ndarray,
    directions: np.ndarray,
    near: np.ndarray,
    distance: np.ndarray,
    triangle: np.ndarray,
    barycentric: np.ndarray,
) -> None:
    count = len(origins)
    # Packets must lie at multiples of 64 bytes: one row of `store` may go lost before.
    skip = (-store.ctypes.data % 64) // 4
    floats = store[skip : skip + (ROWS + 1) * PACKET].reshape((ROWS + 1, PACKET))
    words = floats.view(np.uint32)
    packet = floats.ctypes.data
    valid = packet + ROWS * PACKET * 4
    for start in range(0, count, PACKET):
        lanes = min(PACKET, count - start)
        for lane in range(PACKET):
            words[ROWS, lane] = MISS if lane < lanes else 0
            # Lanes left over repeat the last ray: they are switched off, but hold no garbage.
            ray = start + min(lane, lanes - 1)
            for axis in range(3):
                floats[ORIGIN + axis, lane] = origins[ray, axis]
                part = directions[ray, axis]
                floats[DIRECTION + axis, lane] = 0.0 if abs(part) < LEAST else part
            floats[NEAR, lane] = near[ray]
            floats[FAR, lane] = np.inf
            words[MASK, lane] = MISS
            words[GEOMETRY, lane] = MISS
            words[PRIMITIVE, lane] = MISS
            words[INSTANCE, lane] = MISS
        for lane in range(lanes):
            triangle[start + lane] = -1
        for tree in range(len(scenes)):
            # Only what is nearer than the hits in the trees before changes a ray.
            _call(address, valid, scenes[tree], packet, arguments)
            for lane in range(lanes):
                if words[GEOMETRY, lane] != MISS:
                    triangle[start + lane] = numbers[firsts[tree] + words[PRIMITIVE, lane]]
                    words[GEOMETRY, lane] = MISS
        for lane in range(lanes):
            ray = start + lane
            hit = triangle[ray] >= 0
            distance[ray] = floats[FAR, lane] if hit else np.inf
            barycentric[ray, 0] = floats[U, lane] if hit else 0.0
            barycentric[ray, 1] = floats[V, lane] if hit else 0.0
