"""A saloon car, lofted through cross-sections: own car, parked cars and traffic."""

from __future__ import annotations

import numpy as np

from anamorph.gallery.solids import Solid, box, creased, grid, join, lathe, lattice
from anamorph.scene.model import Color

HALF_WIDTH = 0.88
WHEELS = (-1.36, 1.26)
WHEEL_RADIUS = 0.32
GLASS: Color = (0.035, 0.045, 0.055)
TYRE: Color = (0.02, 0.02, 0.022)
RIM: Color = (0.5, 0.5, 0.52)
TRIM: Color = (0.025, 0.025, 0.028)

# From the nose (-z) to the tail: z, half width at the waist, heights of floor, waist and roof, half width of the roof.
STATIONS = np.array(
    [
        [-2.18, 0.62, 0.30, 0.56, 0.60, 0.50],
        [-2.10, 0.78, 0.22, 0.66, 0.71, 0.62],
        [-1.85, 0.85, 0.19, 0.73, 0.78, 0.68],
        [-1.36, 0.88, 0.19, 0.82, 0.87, 0.70],
        [-0.92, 0.88, 0.19, 0.88, 0.93, 0.72],
        [-0.18, 0.88, 0.19, 0.90, 1.38, 0.58],
        [0.10, 0.88, 0.19, 0.905, 1.43, 0.59],
        [0.18, 0.88, 0.19, 0.91, 1.435, 0.59],
        [0.86, 0.88, 0.19, 0.93, 1.41, 0.58],
        [0.96, 0.88, 0.19, 0.93, 1.39, 0.58],
        [1.52, 0.87, 0.19, 0.95, 1.00, 0.70],
        [2.02, 0.84, 0.22, 0.94, 0.985, 0.68],
        [2.16, 0.78, 0.30, 0.88, 0.92, 0.64],
        [2.18, 0.74, 0.36, 0.80, 0.83, 0.62],
    ]
)
CABIN = (4, 10)
PILLAR = 6


def section(station: np.ndarray) -> np.ndarray:
    """Half a cross-section, (9, 2): x and y from the middle of the floor up to the middle of the roof."""
    _, wide, floor, waist, roof, top = station
    return np.array(
        [
            [0.0, floor],
            [wide - 0.06, floor],
            [wide, floor + 0.12],
            [wide, waist - 0.14],
            [wide - 0.03, waist - 0.03],
            [wide - 0.08, waist],
            [top + 0.035, roof - 0.06],
            [top - 0.06, roof - 0.012],
            [0.0, roof + 0.015],
        ]
    )


def body(paint: Color, driven: bool) -> Solid:
    """The painted shell with its windows; where it is `driven` from, the windscreen and the front windows are open."""
    half = np.array([section(station) for station in STATIONS])
    count, size = half.shape[:2]
    z = np.broadcast_to(STATIONS[:, :1, None], (count, size, 1))
    right = np.concatenate([half, z], axis=-1)
    left = right[:, -2:0:-1] * (-1, 1, 1)
    rings = np.concatenate([right, left], axis=1)
    nose, tail = rings[:1].copy(), rings[-1:].copy()
    nose[..., :2], tail[..., :2] = (0.0, 0.45), (0.0, 0.6)
    skin = np.concatenate([nose, rings, tail])

    around = rings.shape[1]
    faces = lattice(len(skin), around, closed=True)
    row, column = np.divmod(np.arange(len(faces)) // 2, around)
    row, column = row - 1, np.minimum(column, around - 1 - column)
    in_cabin = (row >= CABIN[0]) & (row < CABIN[1])
    screens = ((row == CABIN[0]) | (row == CABIN[1] - 1)) & (column >= 6)
    glass = screens | (in_cabin & (column == 5) & (row != PILLAR))
    height = skin.reshape(-1, 3)[faces][..., 1]
    colors = np.broadcast_to(np.asarray(paint, float), (len(faces), 3, 3)).copy()
    colors[glass] = np.asarray(GLASS) * (1.0 + 6.0 * np.clip(height[glass] - 0.9, 0.0, 0.5)[..., None])
    colors[column <= 1] = TRIM
    colors *= np.clip(0.45 + 1.1 * (height - 0.15), 0.45, 1.0)[..., None]
    seen = (column > 0) if not driven else ~(glass & (row < PILLAR))
    return creased(skin.reshape(-1, 3), faces[seen], 32.0, colors=colors[seen])


def wheel(fine: bool) -> Solid:
    """A wheel whose axle is the x axis, its outer side at x = 0."""
    segments = 24 if fine else 10
    tread = [(WHEEL_RADIUS, -0.17), (WHEEL_RADIUS, -0.02), (0.22, 0.0)]
    parts = [lathe(tread, segments, 20.0).painted(TYRE)]
    if fine:
        spoke = box((-0.03, -0.03, 0.03), (0.03, -0.005, 0.215), "+y+x-x").painted(RIM)
        parts += [lathe([(0.22, 0.0), (0.21, -0.03), (0.0, -0.03)], segments).painted((0.06, 0.06, 0.065))]
        parts += [spoke.turned(72.0 * i) for i in range(5)]
        parts += [lathe([(0.055, -0.03), (0.055, 0.002), (0.0, 0.006)], 10).painted(RIM)]
    else:
        parts += [lathe([(0.22, 0.0), (0.0, -0.03)], segments).painted(RIM)]
    return join(parts).turned(-90.0, axis=2)


def arch(side: int, z: float, fine: bool) -> Solid:
    """The dark of a wheel arch: a disc just outside the body's flat side."""
    disc = lathe([(0.39, 0.006), (0.0, 0.006)], 32 if fine else 14).painted((0.012, 0.012, 0.014))
    return disc.turned(-90.0 * side, axis=2).moved(side * HALF_WIDTH, WHEEL_RADIUS, z)


def lamps() -> list[Solid]:
    """Grille, head lamps and rear lamps."""
    parts = [
        box((-0.40, 0.38, -2.20), (0.40, 0.54, -2.10), "+x-x+y-z").painted((0.02, 0.02, 0.022)),
        box((-0.36, 0.445, -2.21), (0.36, 0.465, -2.205), "-z").painted(RIM),
    ]
    for side in (-1, 1):
        low, high = sorted((side * 0.44, side * 0.70))
        parts.append(box((low, 0.50, -2.185), (high, 0.62, -2.0), "+x-x+y-z").painted((0.55, 0.58, 0.60)))
        parts.append(box((low + 0.05, 0.525, -2.192), (high - 0.05, 0.595, -2.17), "-z").painted((1.0, 1.0, 0.95)))
        low, high = sorted((side * 0.48, side * 0.75))
        parts.append(box((low, 0.66, 2.1), (high, 0.80, 2.195), "+x-x+y+z").painted((0.55, 0.02, 0.015)))
        parts.append(box((low, 0.67, 2.1), (low + 0.09, 0.71, 2.202), "+z").painted((0.8, 0.35, 0.03)))
    return parts


def handles() -> list[Solid]:
    """The handles of the four doors."""
    out = HALF_WIDTH + 0.004
    places = [(side * out, z) for side in (-1, 1) for z in (0.0, 0.9)]
    return [box((x - 0.014, 0.72, z - 0.09), (x + 0.014, 0.745, z + 0.09)).painted(TRIM) for x, z in places]


def saloon(paint: Color, own: bool = False) -> Solid:
    """A whole car on its wheels, its nose to -z, its middle over the origin.

    One's own car is finer, and open where its driver looks out.
    """
    parts = [body(paint, driven=own), *lamps()]
    for z in WHEELS:
        parts += [arch(1, z, False), arch(-1, z, own)]
        parts.append(wheel(False).moved(HALF_WIDTH + 0.02, WHEEL_RADIUS, z))
        parts.append(wheel(own).turned(180.0).moved(-HALF_WIDTH - 0.02, WHEEL_RADIUS, z))
    if own:
        parts += handles()
    else:
        ear = box((-0.09, -0.06, -0.05), (0.09, 0.06, 0.05)).painted(paint)
        parts += [ear.moved(side * 0.95, 0.98, -0.6) for side in (-1, 1)]
    return join(parts)


def number_plates(index: int) -> Solid:
    """The plates in front and behind: number `index` of the plates' texture."""
    part = (0.0, index / 4, 1.0, (index + 1) / 4)
    front = grid((0.26, 0.30, -2.225), (-0.52, 0, 0), (0, 0.13, 0), image=part)
    back = grid((-0.26, 0.50, 2.205), (0.52, 0, 0), (0, 0.13, 0), image=part)
    return join([front, back])
