"""Refraction points by other ways: in the plane of a ball's center, and from starts all over a face."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from light import snell
from reflected_truth import unique

from anamorph.gallery.lenses import reading_glass
from anamorph.lenses.lens import Lens, disc, lens_between
from anamorph.lenses.making import make_lens, worn_lens
from anamorph.lenses.prescription import Prescription
from anamorph.optics.refraction import refractor, to_far_face
from anamorph.reflections.stationary import NORMAL, ORDER, POSITION
from anamorph.reflections.through_lens import FAR_NORMAL, FAR_POSITION, WORDS, settle_through
from anamorph.scene.camera import Camera
from anamorph.scene.model import Glass, Mesh, Scene
from anamorph.surfaces.bezier import BezierPatch
from anamorph.surfaces.intersection import pack
from anamorph.surfaces.sphere import Sphere

AXES = np.eye(3)
CENTER, RADIUS, RIM = np.zeros(3), 0.1, 0.095
"""Of a ball of glass, metres, and how far from its axis its two faces end."""


@dataclass(frozen=True, eq=False)
class LensTrial:
    """A lens, an eye before it, and whether it sees the back face."""

    lens: Lens
    eye: np.ndarray
    from_back: bool = False

    @property
    def scene(self) -> Scene:
        eye = tuple(self.eye.tolist())
        return Scene("trial", self.lens.meshes, Camera(eye, tuple((self.eye - AXES[2]).tolist())))

    @property
    def faces(self) -> tuple[Mesh, Mesh]:
        """The one that the eye sees, and the other."""
        return (self.lens.back, self.lens.front) if self.from_back else (self.lens.front, self.lens.back)

    @property
    def index(self) -> float:
        material = self.lens.front.material
        assert isinstance(material, Glass)
        return material.index

    @property
    def size(self) -> float:
        return float(np.ptp(self.faces[0].positions, axis=0).max())


def glass_ball(index: float = 1.5, eye: tuple[float, float, float] = (0.03, 0.02, 0.4)) -> LensTrial:
    """A ball whose two faces leave a band around it."""
    plane, faces = disc(12)
    plane = RIM * plane
    height = np.sqrt(RADIUS**2 - np.sum(plane**2, axis=1))
    ball, glass = Sphere(tuple(CENTER.tolist()), RADIUS), Glass(index)
    front, back = (ball.parameters(np.column_stack([plane, side * height])) for side in (1.0, -1.0))
    meshes = (
        Mesh.exact("ball/front", ball, front, faces, glass, AXES[2]),
        Mesh.exact("ball/back", ball, back, faces[:, ::-1], glass, -AXES[2]),
    )
    # A band with as many vertices as the faces have around them says that they are round.
    caps = Sphere((0.0, 0.0, -0.2), 0.25), Sphere((0.0, 0.0, 0.2), 0.25)
    edge = lens_between(*caps, CENTER, AXES, RIM, glass, "ball", vertices=len(plane)).edge
    return LensTrial(Lens(*meshes, edge), np.array(eye))


def biconvex() -> LensTrial:
    faces = Sphere((0.0, 0.0, -0.1), 0.12), Sphere((0.0, 0.0, 0.1), 0.12)
    return LensTrial(lens_between(*faces, CENTER, AXES, 0.05, Glass(1.5)), np.array([0.03, 0.02, 0.3]))


def biconcave() -> LensTrial:
    faces = Sphere((0.0, 0.0, 0.13), 0.12), Sphere((0.0, 0.0, -0.13), 0.12)
    return LensTrial(lens_between(*faces, CENTER, AXES, 0.05, Glass(1.5)), np.array([0.03, 0.02, 0.1]))


def aspheric() -> LensTrial:
    """The reading glass of the gallery, from a third of a metre."""
    lens = reading_glass()
    vertex = lens.back.exact_positions().mean(axis=0)
    outward = lens.front.exact_positions().mean(axis=0) - vertex
    return LensTrial(lens, vertex - 0.3 * outward / np.linalg.norm(outward) + (0.02, 0.01, 0.0), True)


def astigmatic() -> LensTrial:
    """A toric spectacle lens with a prism, before the eye that wears it."""
    worn = Prescription(-3.0, -2.0, 30.0, prism=3.0, base=60.0, index=1.6, abbe=42.0, centre_thickness=2.0)
    return LensTrial(worn_lens(worn, (0.0, 0.0, 0.0), (0.0, 0.0, -1.0)), np.zeros(3), True)


def plus() -> LensTrial:
    strong = Prescription(8.0, 0.0, 0.0, index=1.6, centre_thickness=9.0, diameter=50.0)
    return LensTrial(make_lens(strong, (0.0, 0.0, 0.0), (0.0, 0.0, -1.0)), np.array([0.005, 0.0, 0.25]), True)


def moulded() -> LensTrial:
    """A plane behind a Bezier patch that bulges unevenly."""
    x, y = np.meshgrid(np.linspace(-0.08, 0.08, 4), np.linspace(-0.08, 0.08, 4), indexing="ij")
    height = np.full((4, 4), 0.012)
    height[1:3, 1:3] = [[0.05, 0.034], [0.028, 0.044]]
    front = BezierPatch(np.stack([x, y, height], axis=-1))
    back = Sphere((0.0, 0.0, 3.0), 3.0)
    return LensTrial(lens_between(front, back, CENTER, AXES, 0.05, Glass(1.6)), np.array([0.02, -0.03, 0.5]))


TRIALS = {each.__name__: each for each in (biconvex, biconcave, aspheric, astigmatic, plus, moulded, glass_ball)}


def rays_through(trial: LensTrial, count: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where random rays of the eye enter and leave, (N, 3) each, and their unit directions then: none that graze."""
    random = np.random.default_rng(seed)
    near, far = trial.faces
    triangle, weights = random.integers(len(near.faces), size=count), random.dirichlet((1.0, 1.0, 1.0), count)
    assert near.surface is not None and far.surface is not None
    places = np.einsum("nk,nki->ni", weights, near.exact_positions()[near.faces[triangle]])
    uv = near.surface.parameters(places)
    entries, normals = near.surface.position(uv), near.surface.normals_toward(uv, near.normals[near.faces[triangle, 0]])
    ways = entries - trial.eye
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    inside, exits, far_normals, met = to_far_face(refractor(near, far), entries, normals, ways, trial.index)
    sine = np.linalg.norm(np.cross(inside, far_normals), axis=1)
    middle, axis = refractor(near, far).middle, refractor(near, far).axis
    away = exits - middle
    out = np.linalg.norm(away - np.outer(away @ axis, axis), axis=1)
    good = met & (np.sum(ways * normals, axis=1) < -0.02) & (trial.index * sine < 0.999)
    good &= out < 0.9999 * refractor(near, far).radius
    leaving = snell(inside[good], far.surface.normal(far.surface.parameters(exits[good])), trial.index)
    return entries[good], exits[good], leaving


def points_behind(trial: LensTrial, count: int, seed: int, nearest: float = 1e-3) -> np.ndarray:
    """Points on random rays that leave the lens, from the `nearest` to 300 of its sizes behind it, (N, 3)."""
    _, exits, ways = rays_through(trial, count, seed)
    far = np.exp(np.random.default_rng(seed).uniform(np.log(nearest), np.log(300.0), (len(exits), 1)))
    return exits + trial.size * far * ways


def ball_ray(index: float, distance: float, angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where light of an eye leaves a ball, and its unit direction then, (N, 2) each, in a plane through both centers.

    The eye is `distance` from the center along the first axis, and light enters at `angle` (N,) from there.
    """
    turn = np.arctan2(RADIUS * np.sin(angle), distance - RADIUS * np.cos(angle))
    # Angles of incidence have the sign of the angle.
    outside = angle + turn
    leave = angle + np.pi - 2.0 * np.arcsin(np.sin(outside) / index)
    way = leave + outside
    return RADIUS * np.stack([np.cos(leave), np.sin(leave)], axis=-1), np.stack([np.cos(way), np.sin(way)], axis=-1)


def beside_caustic(index: float, eye: np.ndarray, count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Where rays of an eye enter a ball, and points on them close to where each touches the caustic, (N, 3) each."""
    random = np.random.default_rng(seed)
    distance = float(np.linalg.norm(eye - CENTER))
    angle, step = random.uniform(0.15, 0.9, count) * np.arccos(RADIUS / distance), 1e-5
    (ends, ways), low, high = (ball_ray(index, distance, angle + shift) for shift in (0.0, -step, step))

    def crossed(one: np.ndarray, other: np.ndarray) -> np.ndarray:
        return one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]

    touching = -crossed(high[0] - low[0], ways) / crossed(high[1] - low[1], ways)
    away = 10.0 ** random.uniform(-6.0, -1.0, count) * np.where(random.random(count) < 0.5, 1.0, -1.0)
    flat = ends + (touching * (1.0 + away))[:, None] * ways
    axis = (eye - CENTER) / distance
    aside = np.cross(axis, random.normal(size=(count, 3)))
    aside /= np.linalg.norm(aside, axis=1, keepdims=True)

    def placed(places: np.ndarray) -> np.ndarray:
        return CENTER + places[:, :1] * axis + places[:, 1:] * aside

    entries, leaving = placed(RADIUS * np.stack([np.cos(angle), np.sin(angle)], axis=-1)), placed(ends)
    held = (touching > 0.0) & (entries[:, 2] > 0.0) & (leaving[:, 2] < 0.0)
    held &= np.max([np.hypot(each[:, 0], each[:, 1]) for each in (entries, leaving)], axis=0) < 0.999 * RIM
    return entries[held], placed(flat)[held]


def ball_points(index: float, eye: np.ndarray, points: np.ndarray, count: int = 2000) -> list[np.ndarray]:
    """Of each point all places, (K, 3), by which an eye sees it through a ball: roots of one variable.

    All of the path lies in the plane of eye, point and center. A ray that enters at the angle a from the eye's own
    turns by the refraction; where it leaves, and which way, are angles too.
    """
    found = []
    for point in points:
        first = eye - CENTER
        distance = np.linalg.norm(first)
        axis = first / distance
        aside = (point - CENTER) - (point - CENTER) @ axis * axis
        up = aside / np.linalg.norm(aside)
        x, y = (point - CENTER) @ axis, (point - CENTER) @ up
        widest = np.arccos(RADIUS / distance)

        def missed(
            angle: np.ndarray, distance: float = distance, x: float = x, y: float = y
        ) -> tuple[np.ndarray, np.ndarray]:
            """By how much the ray that enters there passes the point, and how far along it that is."""
            ends, ahead = ball_ray(index, distance, angle)
            to = np.array([x, y]) - ends
            return to[:, 0] * ahead[:, 1] - to[:, 1] * ahead[:, 0], np.sum(to * ahead, axis=1)

        angles = widest * np.sin(np.linspace(-0.5 * np.pi, 0.5 * np.pi, count))[1:-1]
        miss = missed(angles)[0]
        change = np.flatnonzero(np.sign(miss[1:]) != np.sign(miss[:-1]))
        low, high = angles[change], angles[change + 1]
        below = miss[change]
        for _ in range(60):
            middle = 0.5 * (low + high)
            same = np.sign(missed(middle)[0]) == np.sign(below)
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        roots = 0.5 * (low + high)
        roots = roots[missed(roots)[1] > 0.0] if len(roots) else roots
        places = RADIUS * (np.cos(roots)[:, None] * axis + np.sin(roots)[:, None] * up)
        # What enters beyond the rim of the near face does not count, nor what leaves beyond that of the far one.
        way = places - eye
        inside = snell(way / np.linalg.norm(way, axis=1, keepdims=True), places / RADIUS, 1.0 / index)
        ends = places - 2.0 * np.sum(inside * places, axis=1, keepdims=True) * inside
        held = [np.hypot(each[:, 0], each[:, 1]) < RIM for each in (places, ends)]
        found.append(places[held[0] & held[1] & (places[:, 2] > 0.0) & (ends[:, 2] < 0.0)])
    return found


def dense_points(trial: LensTrial, points: np.ndarray, rings: int = 40) -> tuple[np.ndarray, np.ndarray]:
    """What is found from all places of a dense lattice on the near face: which points, and where, (M, 3)."""
    near, far = trial.faces
    assert near.surface is not None and far.surface is not None
    kinds = [pack(each.surface) for each in (near, far)]
    random = np.random.default_rng(1)
    count = 3 * rings * rings
    triangle, weights = random.integers(len(near.faces), size=count), random.dirichlet((1.0, 1.0, 1.0), count)
    entries = np.einsum("nk,nki->ni", weights, near.exact_positions()[near.faces[triangle]])
    uv = near.surface.parameters(entries)
    entries, normals = near.surface.position(uv), near.surface.normals_toward(uv, near.normals[near.faces[triangle, 0]])
    ways = entries - trial.eye
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    lens = refractor(near, far)
    _, exits, _, met = to_far_face(lens, entries, normals, ways, trial.index)
    good = met & (np.sum(ways * normals, axis=1) < 0.0)
    starts = np.concatenate(
        [near.surface.places(uv[good]), far.surface.places(far.surface.parameters(exits[good]))], axis=1
    )
    rows_of = []
    for number, point in enumerate(points):
        rows, ok = np.zeros((len(starts), WORDS)), np.zeros(len(starts), bool)
        settle_through(
            *kinds[0], *kinds[1], trial.index, trial.size, tuple(trial.eye.tolist()),
            np.broadcast_to(point, (len(starts), 3)), starts, np.full(len(starts), trial.size / rings), False,
            0, len(starts), rows, ok,
        )  # fmt: skip
        entry, leave = rows[:, POSITION : POSITION + 3], rows[:, FAR_POSITION : FAR_POSITION + 3]
        for face, normal, outside, inside in (
            (near, rows[:, NORMAL : NORMAL + 3], trial.eye - entry, leave - entry),
            (far, rows[:, FAR_NORMAL : FAR_NORMAL + 3], point - leave, entry - leave),
        ):
            side = np.sign(normal @ np.asarray(face.normals, float).mean(axis=0))
            ok &= (side * np.sum(normal * outside, axis=1) > 0.0) & (side * np.sum(normal * inside, axis=1) < 0.0)
        for place in (entry, leave):
            away = place - lens.middle
            ok &= np.linalg.norm(away - np.outer(away @ lens.axis, lens.axis), axis=1) <= lens.radius * (1.0 + 1e-9)
        rows_of.append(np.column_stack([np.full(ok.sum(), number), entry[ok], rows[ok, ORDER]]))
    rows = np.concatenate(rows_of)
    who, places, _ = unique(rows[:, 0].astype(int), rows[:, 1:4], rows[:, 4].astype(int), 1e-6 * trial.size)
    return who, places
