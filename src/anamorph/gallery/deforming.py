"""A convex mirror over a rolling sea, with flags, floats and balloons near and far: all but the mirror keeps moving."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from PIL import Image, ImageDraw

from anamorph.gallery.solids import Solid, cylinder, globe, grid, join, lattice
from anamorph.gallery.swell import deform
from anamorph.gallery.textures import Rgb, mottled, texture
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import Geometry, flatten
from anamorph.scene.model import AmbientLight, Diffuse, DirectionalLight, Mesh, Mirror, Scene, Sky, Texture
from anamorph.surfaces.sphere import Sphere

SEA = (246, 420)
"""Rings and sectors of the sea's grid."""

FINEST, SHORE = 12.0, 600.0
"""Metres: the rings lie evenly within the one radius and in proportion beyond it; the other is the last one's."""

FLAG_SIZE, FLAG_CELLS, THICKNESS = (1.7, 1.15), (26, 18), 0.012
MAST_HEIGHT, MAST_RADIUS = 3.6, 0.035
BEARING = 20.0
"""Of the wind, in degrees from +x towards +z."""

BALL_CELLS = (20, 32)
PATTERN = 128
"""Texels along an edge of a flag's or a ball's texture."""

MIDDLE = (0.0, 2.9, 0.0)
RADIUS, REACH, RINGS, SECTORS = 3.6, 0.32, 10, 40
"""The mirror's radius of curvature (m), the angle to its edge (radians), and its cells."""

EYE, LOOK = (1.3, 2.45, 5.2), (-0.25, 2.65, 0.0)
CLEAR = 2.3
"""Metres around the eye, and on its way to the mirror, where nothing floats."""

BEHIND = -8.0
"""What floats, floats on the side of this z that the mirror looks at."""

RED, BLUE, GREEN, YELLOW, WHITE, BLACK, ORANGE = (
    (198, 32, 38), (28, 70, 160), (24, 130, 74), (244, 190, 40), (240, 238, 230), (30, 30, 34), (236, 112, 26),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Rest:
    """The scene at rest, and how far from its flagpole each vertex is."""

    scene: Scene
    geometry: Geometry
    reach: np.ndarray


def deforming() -> Scene:
    """The built-in scene `deforming`, at time 0."""
    rest = _rest()
    positions, normals = deformed(0.0)
    meshes = []
    for index, mesh in enumerate(rest.scene.meshes):
        own = slice(*rest.geometry.first_vertex[index : index + 2])
        meshes.append(replace(mesh, positions=positions[own].copy(), normals=normals[own].copy()))
    return replace(rest.scene, meshes=tuple(meshes))


def deformed(time: float) -> tuple[np.ndarray, np.ndarray]:
    """Positions and unit normals, each (V, 3) float32, of all vertices of the scene at `time` seconds.

    They are numbered as `geometry.flatten` does; the mirror's stay.
    """
    rest = _rest()
    still = int(rest.geometry.first_vertex[1])
    wind = np.array([np.cos(np.radians(BEARING)), np.sin(np.radians(BEARING))])
    before, upright = rest.geometry.positions, rest.geometry.normals
    positions, normals = np.empty_like(before), np.empty_like(upright)
    positions[:still], normals[:still] = before[:still], upright[:still]
    deform(before[still:], upright[still:], rest.reach[still:], wind, time, positions[still:], normals[still:])
    return positions, normals


@cache
def _rest() -> _Rest:
    groups = [_sea(), *_flags(), *_balls()]
    meshes = (_mirror(), *(mesh for mesh, _ in groups))
    scene = Scene(
        name="deforming",
        meshes=meshes,
        camera=Camera(position=EYE, target=LOOK, field_of_view=31.0),
        lights=(
            DirectionalLight(toward=(0.48, 0.64, 0.6), color=(0.95, 0.89, 0.78)),
            AmbientLight(sky=(0.44, 0.50, 0.60), ground=(0.16, 0.22, 0.24)),
        ),
        sky=Sky(zenith=(0.14, 0.34, 0.74), horizon=(0.78, 0.84, 0.88), nadir=(0.10, 0.20, 0.24)),
    )
    reach = np.concatenate([np.full(len(meshes[0].positions), -1.0), *(reach for _, reach in groups)])
    return _Rest(scene, flatten(scene), reach.astype(np.float32))


def _mirror() -> Mesh:
    """A round piece of a sphere that looks along +z."""
    sphere = Sphere(center=np.subtract(MIDDLE, (0.0, 0.0, RADIUS)), radius=RADIUS)
    angle, turn = _polar(np.linspace(0.0, REACH, RINGS + 1)[1:], SECTORS)
    x, y, z = np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), np.cos(angle)
    parameters = np.stack([np.arctan2(x, z), np.arcsin(y)], axis=-1)
    return Mesh.exact("mirror", sphere, parameters, _disc(RINGS, SECTORS), Mirror(reflectance=0.92))


def _polar(radii: np.ndarray, sectors: int) -> tuple[np.ndarray, np.ndarray]:
    """Radius and angle of the vertices of a disc: its middle, then ring by ring."""
    turns = 2.0 * np.pi * np.arange(sectors) / sectors
    return np.append(0.0, np.repeat(radii, sectors)), np.append(0.0, np.tile(turns, len(radii)))


def _disc(rings: int, sectors: int) -> np.ndarray:
    """Faces of such a disc, counter-clockwise where its angles are."""
    inner = np.arange(sectors)
    fan = np.stack([np.zeros(sectors, int), inner + 1, (inner + 1) % sectors + 1], axis=-1)
    return np.concatenate([fan, 1 + lattice(rings, sectors, closed=True)[:, ::-1]])


def _sea() -> tuple[Mesh, np.ndarray]:
    rings, sectors = SEA
    steps = np.arcsinh(SHORE / FINEST) * np.arange(1, rings + 1) / rings
    radius, turn = _polar(FINEST * np.sinh(steps), sectors)
    x, z = radius * np.cos(turn), -radius * np.sin(turn)
    water = Diffuse(color=(1, 1, 1), texture=texture(mottled((512, 512), (26, 98, 112), 17, (5, 16, 48), 9.0)))
    shape = Solid(
        positions=np.stack([x, np.zeros_like(x), z], axis=-1),
        normals=np.tile([0.0, 1.0, 0.0], (len(x), 1)),
        texcoords=np.stack([x, z], axis=-1) / 7.0,
        colors=np.ones((len(x), 3)),
        faces=_disc(rings, sectors),
    )
    return shape.mesh("sea", water), np.full(len(x), -1.0)


def _flags() -> list[tuple[Mesh, np.ndarray]]:
    """One mesh for all the masts, and one for the flags of each pattern."""
    places = _places(32, (3.4, 36.0), 0.4)
    masts = join([cylinder(MAST_RADIUS, MAST_HEIGHT, 12).moved(x, 0.0, z) for x, z in places])
    # A flag has two sides, because shading knows only fronts.
    length, height = FLAG_SIZE
    front = grid((0, 0, THICKNESS), (length, 0, 0), (0, height, 0), FLAG_CELLS)
    back = grid((length, 0, 0), (-length, 0, 0), (0, height, 0), FLAG_CELLS, (1, 0, 0, 1))
    cloth = join([front, back])
    reach, hung = cloth.positions[:, 0], cloth.turned(-BEARING).moved(0.0, MAST_HEIGHT - height, 0.0)
    found = [(masts.mesh("masts", Diffuse(color=(0.86, 0.85, 0.82))), np.full(len(masts.positions), -1.0))]
    for number, pattern in enumerate(_flag_patterns()):
        own = [hung.moved(x, 0.0, z) for x, z in places[number :: len(_flag_patterns())]]
        material = Diffuse(color=(1, 1, 1), texture=pattern)
        found.append((join(own).mesh(f"flags-{number}", material), np.tile(reach, len(own))))
    return found


def _balls() -> list[tuple[Mesh, np.ndarray]]:
    """Balls that swim, and balloons above them, by pattern."""
    angles, faces = globe(*BALL_CELLS)
    unit = Sphere(center=np.zeros(3), radius=1.0).position(angles)
    texcoords = np.stack([angles[:, 0] / (2.0 * np.pi) + 0.5, 0.5 - angles[:, 1] / np.pi], axis=-1)
    generator = np.random.default_rng(3)
    groups: list[list[Solid]] = [[], [], []]
    for number, (x, z) in enumerate(_places(26, (2.6, 26.0), 2.1)):
        flies = number % 2 == 1
        size = generator.uniform(0.32, 0.5) * (1.5 if flies else 1.0)
        height = generator.uniform(1.4, 3.0) + 0.22 * np.hypot(x, z) if flies else 0.4 * size
        ball = Solid(unit * size, unit, texcoords, np.ones_like(unit), faces)
        turned = ball.turned(generator.uniform(0, 70), 2).turned(generator.uniform(0, 360))
        groups[number % 3].append(turned.moved(x, height, z))
    found = []
    for number, (shapes, pattern) in enumerate(zip(groups, _ball_patterns(), strict=True)):
        whole = join(shapes)
        material = Diffuse(color=(1, 1, 1), texture=pattern)
        found.append((whole.mesh(f"balls-{number}", material), np.full(len(whole.positions), -1.0)))
    return found


def _places(count: int, radii: tuple[float, float], start: float) -> list[tuple[float, float]]:
    """Places (x, z) on the water, outward by the golden angle: not far behind the mirror nor before the eye."""
    eye, middle = np.array([EYE[0], EYE[2]]), np.array([MIDDLE[0], MIDDLE[2]])
    found: list[tuple[float, float]] = []
    nearest, farthest = radii
    turn = start
    while len(found) < count:
        turn += np.pi * (3.0 - np.sqrt(5.0))
        radius = nearest * (farthest / nearest) ** (len(found) / (count - 1))
        place = radius * np.array([np.sin(turn), np.cos(turn)])
        share = np.clip((place - middle) @ (eye - middle) / ((eye - middle) @ (eye - middle)), 0.0, 1.0)
        if place[1] > BEHIND and np.linalg.norm(place - middle - share * (eye - middle)) > CLEAR:
            found.append((float(place[0]), float(place[1])))
    return found


def _stripes(colors: Sequence[Rgb], upright: bool) -> Texture:
    row, column = np.indices((PATTERN, PATTERN)) * len(colors) // PATTERN
    return texture(Image.fromarray(np.array(colors, np.uint8)[column if upright else row]))


def _painted(ground: Rgb, color: Rgb, kind: str, *outline: tuple[float, float]) -> Texture:
    """A plain ground with an ellipse or a polygon through points from 0 to 1."""
    image = Image.new("RGB", (PATTERN, PATTERN), ground)
    getattr(ImageDraw.Draw(image), kind)([(x * PATTERN, y * PATTERN) for x, y in outline], fill=color)
    return texture(image)


@cache
def _flag_patterns() -> tuple[Texture, ...]:
    return (
        _stripes((RED, WHITE, RED, WHITE, RED, WHITE), upright=False),
        _stripes((BLUE, YELLOW, BLUE), upright=True),
        _painted(WHITE, RED, "ellipse", (0.28, 0.18), (0.72, 0.82)),
        _painted(YELLOW, BLACK, "polygon", (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)),
        _painted(GREEN, WHITE, "polygon", (0.5, 0.1), (0.9, 0.5), (0.5, 0.9), (0.1, 0.5)),
    )


def _ball_patterns() -> tuple[Texture, ...]:
    return (
        _stripes((RED, WHITE) * 4, upright=True),
        _stripes((YELLOW, BLUE, WHITE, GREEN) * 2, upright=True),
        _stripes((ORANGE, ORANGE, WHITE, ORANGE, ORANGE), upright=False),
    )
