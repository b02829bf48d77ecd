"""A lens of another power or index, where it stands: its back is bent, and its front moves where the edge would vanish.

The powers are those of `Prescription`: F'v = F1 / (1 - (t / n) F1) + F2, with F = (n - 1) curvature for each face. A
lens in a scene does not know its prescription; they are read from its exact surfaces.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import KDTree

from anamorph.base.errors import AnamorphError
from anamorph.editing.bending import STEEPEST, on_surface, own_curvatures, recurved
from anamorph.lenses.lens import drop
from anamorph.scene.model import Glass, Mesh
from anamorph.scene.pose import WORLD_UP, box_middle, mean_normal, upright_axes
from anamorph.surfaces.base import Surface
from anamorph.surfaces.plane import Plane
from anamorph.surfaces.sag import SagSurface
from anamorph.surfaces.similarity import Similarity
from anamorph.surfaces.sphere import Sphere, round_surface

LEAST_EDGE = 5e-4
"""Metres: a lens that has as much at its edge keeps it."""

CENTRED = 1e-5
"""Metres: how near to the axis the apex of a toroid or an asphere is."""

CLOSE = 1e-7
"""Metres: how near to its thickness a lens is ground."""

STRONGEST = 20.0
"""Dioptres: what a control grinds a lens to, at most."""

COMFORTABLE = 0.75
"""The share of the radius that a control lets the back's edge reach from its axis."""

USUAL = (1.3, 2.0)
"""Indices of what lenses are made of, from water to the densest glass."""

MOST_FOCUSED = 0.95
"""How much of the way to its front's focus a lens may be thick."""

LEAST_BENDING = 1e-3
"""How far an index must be from that of air for its glass to have a power."""

Grindable = Plane | Sphere | SagSurface


@dataclass(frozen=True, eq=False)
class Optics:
    """A lens as its axis finds it.

    Parameters
    ----------
    axes : (3, 3) float64
        Rows: right, up, and the axis, from the back to the front.
    vertex : (3,) float64
        Where the axis meets the back, metres.
    behind : (3,) float64
        The back's unit normal there, out of the glass.
    thickness : float
        Along the axis, metres.
    front, back : tuple of float
        Curvatures at the axis, 1/m, positive where a face bulges out of the glass; two where it is a toroid.
    index : float
    """

    axes: np.ndarray
    vertex: np.ndarray
    behind: np.ndarray
    thickness: float
    front: tuple[float, ...]
    back: tuple[float, ...]
    index: float

    @property
    def power(self) -> float:
        """Back vertex power, dioptres, in the meridian of the toroid's circle of turning if there is one."""
        return _arriving(self.front[0], self.thickness, self.index) + (self.index - 1.0) * self.back[0]


def optics_of(front: Mesh, back: Mesh) -> Optics | None:
    """What two faces do on their axis; None where that is no matter of curvatures."""
    outward = mean_normal((front,))
    if outward is None or not isinstance(front.material, Glass):
        return None
    if not isinstance(front.surface, Grindable) or not isinstance(back.surface, Grindable):
        return None
    middle = box_middle((front,), upright_axes(outward, WORLD_UP))
    at = drop(front.surface, middle[None], outward)
    apex, axis = front.surface.position(at)[0], front.surface.normals_toward(at, outward[None])[0]
    # From a vertex near the axis, where no other side of the back's sphere is nearer.
    heights = (np.asarray(back.positions, float) - apex) @ axis
    aside = np.linalg.norm(back.positions - apex - np.outer(heights, axis), axis=1)
    below = drop(back.surface, (apex + heights[aside.argmin()] * axis)[None], axis)
    if not (_centred(front.surface, at) and _centred(back.surface, below)):
        return None
    vertex, behind = back.surface.position(below)[0], back.surface.normals_toward(below, -axis[None])[0]
    optics = Optics(
        axes=upright_axes(axis, WORLD_UP),
        vertex=vertex,
        behind=behind,
        thickness=float((apex - vertex) @ axis),
        front=tuple(front.side * curvature for curvature in own_curvatures(front.surface)),
        back=tuple(back.side * curvature for curvature in own_curvatures(back.surface)),
        index=front.material.index,
    )
    # Where the front focuses light inside the glass, no back has a power.
    return optics if optics.thickness / optics.index * (optics.index - 1.0) * optics.front[0] < MOST_FOCUSED else None


def _centred(surface: Grindable, parameters: np.ndarray) -> bool:
    """Whether the point at parameters (1, 2) may count as the surface's apex, where its curvature is known."""
    return isinstance(surface, Plane | Sphere) or float(np.abs(parameters).max()) <= CENTRED


def power_limits(front: Mesh, back: Mesh) -> tuple[float, float] | None:
    """The weakest and the strongest power, dioptres, that the back of a lens can sensibly be bent to."""
    optics = optics_of(front, back)
    if optics is None or abs(optics.index - 1.0) < LEAST_BENDING:
        return None
    span = abs(optics.index - 1.0) * COMFORTABLE / _reach(back, optics)
    at_front = optics.power - (optics.index - 1.0) * optics.back[0]
    low, high = max(at_front - span, -STRONGEST), min(at_front + span, STRONGEST)
    return min(low, optics.power), max(high, optics.power)


def index_limits(front: Mesh, back: Mesh) -> tuple[float, float]:
    """The least and the greatest index, of those that lenses are made of, with which the back can keep the power."""
    optics = optics_of(front, back)
    if optics is None:
        return USUAL
    steepest = max(COMFORTABLE / _reach(back, optics), *map(abs, optics.back))
    low = high = optics.index
    for step in (-1, 1):
        for index in np.arange(1, 100) * 0.01 * step + round(optics.index, 2):
            if not USUAL[0] - 1e-9 <= index <= USUAL[1] + 1e-9:
                break
            if not _is_reached(optics, float(index), steepest):
                break
            low, high = min(low, float(index)), max(high, float(index))
    return low, high


def _is_reached(optics: Optics, index: float, steepest: float) -> bool:
    try:
        return max(map(abs, _back_curvatures(optics, optics.power, index, optics.thickness))) <= steepest
    except AnamorphError:
        return False


def ground(lens: Sequence[Mesh], power: float | None = None, index: float | None = None) -> tuple[Mesh, ...]:
    """A lens of another power or index.

    The back is bent about the point where the axis meets it, so that cylinder and prism stay. The front stays, but
    where the edge would get thinner than half a millimetre, or than it is, it moves away from the back.

    Parameters
    ----------
    lens : two or three of Mesh
        The front and the back, with exact surfaces, and the edge if there is one.
    power : float, optional
        Back vertex power, dioptres; by default it stays.
    index : float, optional
        Refractive index of the glass; by default it stays.

    Returns
    -------
    tuple of Mesh
        As given; those that nothing is changed of are the very same. Where a face is neither a plane nor a sphere,
        toroid or asphere, shapes stay and only the index changes.
    """
    front, back, *edge = lens
    name, optics = front.name.rpartition("/")[0], optics_of(front, back)
    if optics is None:
        if power is not None:
            raise AnamorphError(
                f"lens '{name}': has no exact radii on its axis, or focuses light inside; leave power out"
            )
        return _of_index(lens, index)
    new_index = optics.index if index is None else index
    new_power = optics.power if power is None else power
    if new_index == optics.index and abs(new_power - optics.power) <= 1e-12 * abs(optics.power):
        return tuple(lens)
    if abs(new_index - 1.0) < LEAST_BENDING:
        raise AnamorphError(f"lens '{name}': glass of index {new_index:g} has no power; give an index above 1")
    try:
        new_front, new_back = _faces(front, back, optics, new_power, new_index)
    except AnamorphError as error:
        raise AnamorphError(f"lens '{name}': power {new_power:.4g} D with index {new_index:g}: {error}") from None
    edges = (_follow(mesh, (front, back), (new_front, new_back)) for mesh in edge)
    return _of_index((new_front, new_back, *edges), index)


def _faces(front: Mesh, back: Mesh, optics: Optics, power: float, index: float) -> tuple[Mesh, Mesh]:
    assert isinstance(front.surface, Grindable)
    across, axis, turn = _across(back, optics), optics.axes[2], _prism_turn(optics, index)
    points = optics.vertex + across @ optics.axes[:2]
    above = points + optics.thickness * axis
    ends = [front.surface.position(drop(front.surface, above, axis)) @ axis, back.exact_positions() @ axis]
    wanted = min(LEAST_EDGE, float((ends[0] - ends[1]).min()))
    thickness, reach = optics.thickness, _reach(back, optics)
    for _ in range(30):
        surface = _back(back, optics, _back_curvatures(optics, power, index, thickness), turn, reach)
        parameters = drop(surface, points, axis)
        away, points = thickness - optics.thickness, surface.position(parameters)
        least = float((ends[0] + away - points @ axis).min())
        thicker = max(optics.thickness, thickness + wanted - least)
        if abs(thicker - thickness) <= CLOSE:
            break
        thickness = thicker
    if not least > 0.0:
        raise AnamorphError("its faces cross; give a weaker one")
    moved = front.moved(Similarity.shift(away * axis)) if away > 0.0 else front
    return moved, on_surface(back, surface, parameters, -axis)


def _back(back: Mesh, optics: Optics, curvatures: tuple[float, ...], turn: np.ndarray, reach: float) -> Surface:
    """The back's surface with other curvatures, turned about its vertex by a matrix (3, 3)."""
    steepest = max(map(abs, curvatures))
    if steepest * reach > STEEPEST:
        raise AnamorphError(
            f"its back needs a radius of {1e3 / steepest:.1f} mm, and its edge is {1e3 * reach:.1f} mm from its axis; "
            "give a weaker one"
        )
    if isinstance(back.surface, Plane | Sphere):
        return round_surface(optics.vertex, upright_axes(turn @ optics.behind, WORLD_UP), curvatures[0])
    assert isinstance(back.surface, SagSurface)
    side = back.side
    other = recurved(back.surface, tuple(side * curvature for curvature in curvatures), optics.vertex)
    return other.moved(Similarity.turn_about(optics.vertex, turn))


def _back_curvatures(optics: Optics, power: float, index: float, thickness: float) -> tuple[float, ...]:
    """What the back of a lens needs, 1/m, for another power, index and thickness, with the same cylinder."""
    first = (power - _arriving(optics.front[0], thickness, index)) / (index - 1.0)
    as_strong = (optics.index - 1.0) / (index - 1.0)
    return tuple(first + as_strong * (curvature - optics.back[0]) for curvature in optics.back)


def _arriving(curvature: float, thickness: float, index: float) -> float:
    """The vergence at the back, dioptres, of parallel light that a front of a curvature (1/m) has bent."""
    power = (index - 1.0) * curvature
    reduced = 1.0 - thickness / index * power
    if reduced <= 0.0:
        raise AnamorphError("its front focuses light inside the glass; give a lower index")
    return power / reduced


def _prism_turn(optics: Optics, index: float) -> np.ndarray:
    """How the back turns about its vertex so that the prism stays what it was: (3, 3)."""
    axis = optics.axes[2]
    across = np.cross(-axis, optics.behind)
    sine = float(np.linalg.norm(across))
    if index == optics.index or min(index, optics.index) <= 1.0 or sine < 1e-9 or optics.index * sine >= 1.0:
        return np.eye(3)
    deviation = np.arcsin(optics.index * sine) - np.arcsin(sine)
    angle = np.arctan2(np.sin(deviation), index - np.cos(deviation)) - np.arcsin(sine)
    x, y, z = across / sine
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


def _across(back: Mesh, optics: Optics) -> np.ndarray:
    """Where the back's vertices are across the axis, (V, 2) float64, metres."""
    return (back.exact_positions() - optics.vertex) @ optics.axes[:2].T


def _reach(back: Mesh, optics: Optics) -> float:
    """How far from the axis the back goes, metres."""
    return float(np.linalg.norm(_across(back, optics), axis=1).max())


def _follow(mesh: Mesh, before: Sequence[Mesh], after: Sequence[Mesh]) -> Mesh:
    """A mesh whose vertices go where those of the faces go that they coincide with."""
    old, new = (np.concatenate([face.positions for face in faces]) for faces in (before, after))
    size = float(np.ptp(old, axis=0).max())
    distance, nearest = KDTree(old).query(mesh.positions)
    return replace(mesh, positions=np.where(distance[:, None] <= 1e-6 * size, new[nearest], mesh.positions))


def _of_index(meshes: Sequence[Mesh], index: float | None) -> tuple[Mesh, ...]:
    return tuple(
        replace(mesh, material=replace(mesh.material, index=index))
        if isinstance(mesh.material, Glass) and index not in (None, mesh.material.index)
        else mesh
        for mesh in meshes
    )
