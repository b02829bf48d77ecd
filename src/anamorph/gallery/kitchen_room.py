"""The kitchen itself: tiled walls, cupboards, a window, shelves with jars, the table and its chairs."""

from __future__ import annotations

import numpy as np

from anamorph.gallery.crockery import bottle, cup, jar, plate, tiles
from anamorph.gallery.room import landscape
from anamorph.gallery.solids import Solid, box, cylinder, grid, join, lathe
from anamorph.gallery.textures import checkerboard, planks
from anamorph.scene.model import Color, Diffuse, Mesh, Texture

WIDTH, HEIGHT, DEPTH = 3.8, 2.5, 3.4

TABLE = 0.74
"""Height of the table's top, metres."""

COUNTER = 0.90


def kitchen_room() -> list[Mesh]:
    """All that does not stand on the table."""
    return [*shell(), *window(), *cupboards(), *shelf(), table(), chairs(), lamp()]


def white(image: Texture | None = None) -> Diffuse:
    return Diffuse(color=(1.0, 1.0, 1.0), texture=image)


def shell() -> list[Mesh]:
    """Floor, ceiling and walls, tiled up to a rail, seen from inside."""
    x, z, rail = WIDTH / 2, DEPTH / 2, 1.5
    floor = grid((-x, 0, z), (WIDTH, 0, 0), (0, 0, -DEPTH), (24, 20), (0, 0, WIDTH / 0.8, DEPTH / 0.8))
    ceiling = grid((-x, HEIGHT, -z), (WIDTH, 0, 0), (0, 0, DEPTH), (12, 12))
    corners = [
        ((-x, 0, -z), (WIDTH, 0, 0)), ((x, 0, z), (-WIDTH, 0, 0)),
        ((-x, 0, z), (0, 0, -DEPTH)), ((x, 0, -z), (0, 0, DEPTH)),
    ]  # fmt: skip
    tiled, plain = [], []
    for corner, right in corners:
        length = abs(right[0]) + abs(right[2])
        tiled.append(grid(corner, right, (0, rail, 0), (20, 10), (0, 0, length / 0.6, rail / 0.6)))
        above = (corner[0], rail, corner[2])
        plain.append(grid(above, right, (0, HEIGHT - rail, 0), (12, 6)))
    rails = [
        box((-x, rail, -z), (x, rail + 0.03, -z + 0.02), divisions=(16, 1)),
        box((-x, rail, z - 0.02), (x, rail + 0.03, z), divisions=(16, 1)),
        box((-x, rail, -z), (-x + 0.02, rail + 0.03, z), divisions=(16, 1)),
        box((x - 0.02, rail, -z), (x, rail + 0.03, z), divisions=(16, 1)),
    ]
    board = checkerboard(256, 4, (206, 200, 186), (92, 60, 50))
    return [
        floor.mesh("floor", white(board)),
        ceiling.mesh("ceiling", Diffuse(color=(0.82, 0.81, 0.78))),
        join(tiled).mesh("tiles", white(tiles())),
        join(plain).mesh("walls", Diffuse(color=(0.74, 0.70, 0.58))),
        join(rails).mesh("rail", Diffuse(color=(0.24, 0.34, 0.42))),
    ]


def window() -> list[Mesh]:
    """A bright view on the left wall, in a white frame with a cross, and pots on its sill."""
    x = -WIDTH / 2
    low, high, near, far = 1.05, 2.1, 0.7, -0.5
    view = grid((x + 0.03, low, near), (0, 0, far - near), (0, high - low, 0), (8, 8))
    bars = [
        box((x, low - 0.07, far - 0.07), (x + 0.07, low, near + 0.07), divisions=(8, 1)),
        box((x, high, far - 0.07), (x + 0.07, high + 0.07, near + 0.07), divisions=(8, 1)),
        box((x, low, far - 0.07), (x + 0.07, high, far), divisions=(1, 8)),
        box((x, low, near), (x + 0.07, high, near + 0.07), divisions=(1, 8)),
        box((x + 0.032, low, 0.085), (x + 0.06, high, 0.125), divisions=(1, 8)),
        box((x + 0.032, 1.62, far), (x + 0.055, 1.66, near), divisions=(8, 1)),
        box((x, low - 0.1, far - 0.1), (x + 0.2, low - 0.07, near + 0.1), divisions=(8, 1)),
    ]
    pot = lathe(
        [(0.0, 0.0), (0.05, 0.0), (0.065, 0.09), (0.07, 0.09), (0.07, 0.11), (0.055, 0.11), (0.05, 0.1), (0.0, 0.1)],
        36,
        40.0,
    )
    pots = [pot.painted((0.62, 0.28, 0.16)).moved(x + 0.12, low - 0.07, z) for z in (-0.25, 0.45)]
    generator = np.random.default_rng(91)
    herbs = []
    for z in (-0.25, 0.45):
        for _ in range(60):
            a, tall, lean = generator.uniform(0.0, 360.0), generator.uniform(0.08, 0.2), generator.uniform(5.0, 40.0)
            blade = lathe([(0.0, 0.0), (0.008, 0.45 * tall), (0.0, tall)], 6, 80.0).turned(lean, 2).turned(a)
            herbs.append(
                blade.painted((0.16, float(generator.uniform(0.30, 0.45)), 0.10)).moved(x + 0.12, low + 0.03, z)
            )
    return [
        view.mesh("window/view", Diffuse(color=(2.4, 2.4, 2.4), texture=landscape())),
        join(bars).mesh("window/frame", Diffuse(color=(0.86, 0.86, 0.83))),
        join([*pots, *herbs]).mesh("herbs", white()),
    ]


def cupboards() -> list[Mesh]:
    """Cupboards along the back and right walls, under a worktop, and others that hang above."""
    x, z, deep = WIDTH / 2, DEPTH / 2, 0.58
    fronts: list[Solid] = []
    for number in range(6):
        left = -x + number * WIDTH / 6
        fronts += panel((left, 0.1, -z + deep), WIDTH / 6, COUNTER - 0.14, "z")
    for number in range(4):
        near = -z + deep + 0.1 + number * 0.62
        fronts += panel((x - deep, 0.1, near), 0.62, COUNTER - 0.14, "x")
    for number in range(3):
        fronts += panel((-0.2 + number * 0.6, 1.62, -z + 0.33), 0.6, 0.62, "z")
    bodies = [
        box((-x, 0.0, -z), (x, COUNTER - 0.04, -z + deep), "+y+z", divisions=(12, 6)),
        box((x - deep, 0.0, -z), (x, COUNTER - 0.04, 1.5), "-x+y+z", divisions=(12, 6)),
        box((-0.2, 1.6, -z), (1.6, 2.26, -z + 0.33), divisions=(9, 4)),
    ]
    tops = [
        box((-x, COUNTER - 0.04, -z), (x, COUNTER, -z + deep + 0.03), "+y+z-y", divisions=(24, 6)),
        box((x - deep - 0.03, COUNTER - 0.04, -z + deep), (x, COUNTER, 1.5), "-x+y+z-y", divisions=(6, 24)),
    ]
    return [
        join(bodies).mesh("cupboards", Diffuse(color=(0.20, 0.28, 0.30))),
        join(fronts).mesh("cupboard-doors", white()),
        join(tops).mesh("worktop", white(planks(512, 8, (156, 112, 70), 93))),
    ]


def panel(corner: tuple[float, float, float], wide: float, tall: float, toward: str) -> list[Solid]:
    """A door with a frame, a field and a knob, which looks along z, or against x."""
    edge, frame, field = 0.012, (0.34, 0.46, 0.46), (0.42, 0.54, 0.53)
    right, top = wide - edge, tall - 0.07
    bars = [
        box((edge, 0.0, 0.0), (right, 0.07, 0.022), divisions=(8, 1)),
        box((edge, top, 0.0), (right, tall, 0.022), divisions=(8, 1)),
        box((edge, 0.07, 0.0), (edge + 0.07, top, 0.022), divisions=(1, 8)),
        box((right - 0.07, 0.07, 0.0), (right, top, 0.022), divisions=(1, 8)),
    ]
    inner = box((edge + 0.07, 0.07, 0.0), (wide - edge - 0.07, tall - 0.07, 0.008), "+z", divisions=(4, 6))
    knob = lathe([(0.0, 0.0), (0.008, 0.0), (0.006, 0.012), (0.014, 0.02), (0.010, 0.03), (0.0, 0.032)], 20, 50.0)
    knob = knob.turned(90.0, 0).moved(wide - edge - 0.035, tall - 0.12, 0.022).painted((0.72, 0.56, 0.24))
    parts = [*(bar.painted(frame) for bar in bars), inner.painted(field), knob]
    if toward == "x":
        parts = [part.turned(-90.0) for part in parts]
    return [part.moved(*corner) for part in parts]


def shelf() -> list[Mesh]:
    """A board on the back wall and what stands on it and on the worktop."""
    z = -DEPTH / 2
    board = [box((-1.7, y, z), (-0.4, y + 0.03, z + 0.22), divisions=(16, 1)) for y in (1.55, 1.95)]
    colors: tuple[Color, ...] = (
        (0.66, 0.22, 0.10), (0.80, 0.64, 0.20), (0.26, 0.42, 0.18),
        (0.14, 0.28, 0.48), (0.56, 0.40, 0.24), (0.72, 0.70, 0.64),
    )  # fmt: skip
    things = []
    for number in range(7):
        color = colors[number % len(colors)]
        things.append(
            jar(0.16 + 0.03 * (number % 3), 0.055, color, (0.46, 0.30, 0.16)).moved(
                -1.6 + 0.18 * number, 1.58, z + 0.11
            )
        )
    things += [
        bottle(0.30, 0.04, colors[(2 * number) % 6]).moved(-1.6 + 0.16 * number, 1.98, z + 0.11) for number in range(4)
    ]
    for number in range(8):
        things.append(plate(0.11).moved(-0.72, 1.98 + 0.012 * number, z + 0.12))
    things += [
        cup(colors[number]).moved(1.0 + 0.14 * number, COUNTER, z + 0.2 + 0.05 * (number % 2)) for number in range(4)
    ]
    things += [
        bottle(0.27, 0.036, (0.30, 0.36, 0.10)).moved(0.2, COUNTER, z + 0.2),
        bottle(0.22, 0.032, (0.42, 0.24, 0.08)).moved(0.3, COUNTER, z + 0.26),
    ]
    return [
        join(board).mesh("shelf", Diffuse(color=(0.34, 0.20, 0.11))),
        join(things).mesh("stores", white()),
    ]


def table() -> Mesh:
    """A table of oak."""
    low, high = (-0.85, TABLE - 0.04, -0.55), (0.85, TABLE, 0.75)
    parts = [box(low, high, "+y", (0, 0, 2, 1), (64, 48)), box(low, high, "+x-x-y+z-z", (0, 0, 2, 0.1), (40, 1))]
    parts += [
        box((x, 0, z), (x + 0.07, TABLE - 0.04, z + 0.07), "+x-x+z-z", divisions=(1, 6))
        for x in (-0.8, 0.73)
        for z in (-0.5, 0.63)
    ]
    apron = (-0.74, TABLE - 0.12), (0.74, TABLE - 0.04)
    parts += [box((*apron[0], z), (*apron[1], z + 0.02), "+z-z", divisions=(24, 1)) for z in (-0.46, 0.64)]
    return join(parts).mesh("table", white(planks(512, 6, (172, 122, 72), 94)))


def chairs() -> Mesh:
    """Four chairs with turned legs."""
    leg = lathe(
        [(0.0, 0.0), (0.013, 0.0), (0.018, 0.1), (0.015, 0.16), (0.02, 0.3), (0.014, 0.36), (0.019, 0.44), (0.0, 0.44)],
        20,
        50.0,
    )
    seat = box((-0.2, 0.44, -0.2), (0.2, 0.47, 0.2), divisions=(4, 4))
    heights = np.linspace(0.46, 0.92, 9)
    bar = lathe([(0.0, 0.46), *((0.011, float(height)) for height in heights), (0.0, 0.92)], 16)
    bars = [bar.moved(x, 0.0, -0.18) for x in (-0.18, -0.09, 0.0, 0.09, 0.18)]
    rail = box((-0.2, 0.90, -0.2), (0.2, 0.99, -0.16), divisions=(8, 2))
    chair = join([seat, rail, *bars, *(leg.moved(x, 0.0, z) for x in (-0.17, 0.17) for z in (-0.17, 0.17))])
    painted = chair.painted((0.50, 0.16, 0.12))
    places = ((0.0, -0.4, -0.72), (180.0, 0.35, 0.98), (90.0, -1.08, 0.1), (0.0, 0.42, -0.72))
    return join([painted.turned(degrees).moved(x, 0.0, z) for degrees, x, z in places]).mesh("chairs", white())


def lamp() -> Mesh:
    """A lamp that hangs over the table."""
    shade = lathe(
        [(0.03, 0.16), (0.05, 0.15), (0.16, 0.03), (0.19, 0.0), (0.185, 0.0), (0.15, 0.035), (0.03, 0.15)], 64, 50.0
    )
    cord = cylinder(0.004, HEIGHT - 2.0 - 0.15, 8).moved(0.0, 0.15, 0.0)
    return (
        join([shade.painted((0.75, 0.22, 0.14)), cord.painted((0.1, 0.1, 0.1))])
        .moved(0.0, 1.95, 0.0)
        .mesh("lamp", white())
    )
