"""A street of a town along z: road, pavements, houses with shops, trees, lamps and cars."""

from __future__ import annotations

import numpy as np

from anamorph.gallery import town_textures as wear
from anamorph.gallery.car import number_plates, saloon
from anamorph.gallery.solids import Solid, box, creased, cylinder, grid, icosphere, join, lathe, lattice
from anamorph.gallery.textures import leaves
from anamorph.scene.model import Color, Diffuse, Mesh

KERB = wear.ROAD_WIDTH / 2
HOUSES = 8.5
PAVEMENT_HEIGHT = 0.12
SHOP_HEIGHT = 3.2
STOREY = 3.2
MODULE = 6.0
# How a ground's texture lies in the world: u = (x + offset) / width, v = z / length.
Tile = tuple[float, float, float]
ROAD_TILE: Tile = (KERB, wear.ROAD_WIDTH, wear.ROAD_TILE)
SLAB_TILE: Tile = (0.0, 2.0, 2.0)
STREET = (-72.0, 156.0)
ROAD_END = (-144.0, 384.0)
CROSSINGS = (-13.0, 23.0)

# x, z, degrees turned from driving toward -z, paint
CARS: tuple[tuple[float, float, float, Color], ...] = (
    (1.45, 16.5, 0.0, (0.62, 0.63, 0.65)),
    (1.9, 37.0, 0.0, (0.04, 0.10, 0.34)),
    (-1.75, 34.0, 180.0, (0.55, 0.40, 0.05)),
    (-4.35, 15.0, 180.0, (0.05, 0.22, 0.13)),
    (-4.35, 45.0, 178.0, (0.70, 0.69, 0.66)),
    (-4.35, -7.6, 180.0, (0.05, 0.16, 0.42)),
)
TREES = ((-6.2, 20.0), (-6.3, 38.0), (-6.2, 56.0), (-6.2, -11.5), (6.3, 12.0), (6.2, 30.0), (6.2, 48.0), (-6.2, 92.0))
LAMPS = ((-5.9, 29.0), (5.9, 20.0), (-5.9, 65.0), (5.9, 56.0), (-5.9, -3.0))


def town() -> list[Mesh]:
    """Every mesh of the street."""
    return [*ground(), *houses(), *trees(), *lamps(), *cars()]


def road_piece(start: float, end: float) -> Solid:
    """The road between two z, its texture fixed to the world."""
    image = (0.0, start / wear.ROAD_TILE, 1.0, end / wear.ROAD_TILE)
    rows = max(1, round((end - start) / wear.ROAD_TILE))
    return grid((-KERB, 0, end), (wear.ROAD_WIDTH, 0, 0), (0, 0, start - end), (2, rows), image)


def shade(middle: tuple[float, float, float], half_width: float, half_length: float, tile: Tile) -> Solid:
    """A dark patch with soft borders, a little above a ground and of its texture: the sunless place below a thing."""
    across, along = (np.array([-h - 0.25, -h + 0.15, h - 0.15, h + 0.25]) for h in (half_width, half_length))
    x, z = np.meshgrid(across, along[::-1])
    inside = (np.abs(x) < half_width) & (np.abs(z) < half_length)
    positions = np.stack([x.ravel(), np.zeros(16), z.ravel()], axis=-1) + middle
    offset, wide, long = tile
    return Solid(
        positions=positions,
        normals=np.tile((0.0, 1.0, 0.0), (16, 1)),
        texcoords=np.stack([(positions[:, 0] + offset) / wide, positions[:, 2] / long], axis=-1),
        colors=np.where(inside.reshape(-1, 1), 0.16, 1.0) * np.ones(3),
        faces=lattice(4, 4),
    )


def ground() -> list[Mesh]:
    """Road with its crossings, pavements with their kerbs, meadows and hills."""
    asphalt, slabs = Diffuse(texture=wear.road(), color=(1, 1, 1)), Diffuse(texture=wear.pavement(), color=(1, 1, 1))
    ends = [ROAD_END[0], *(end for z in CROSSINGS for end in (z, z + wear.CROSSING_LENGTH)), ROAD_END[1]]
    pieces = [road_piece(start, end) for start, end in zip(ends[::2], ends[1::2], strict=True)]
    stripes = [
        grid((-KERB, 0, z + wear.CROSSING_LENGTH), (2 * KERB, 0, 0), (0, 0, -wear.CROSSING_LENGTH), (2, 1))
        for z in CROSSINGS
    ]
    meshes = [
        join(pieces).mesh("road", asphalt),
        join(stripes).mesh("crossing", Diffuse(texture=wear.crossing(), color=(1, 1, 1))),
    ]
    start, end = STREET
    for side, name in ((-1, "left"), (1, "right")):
        inner, outer = sorted((side * KERB, side * (HOUSES + 0.3)))
        top = grid(
            (inner, PAVEMENT_HEIGHT, end),
            (outer - inner, 0, 0),
            (0, 0, start - end),
            (1, 12),
            (inner / 2, start / 2, outer / 2, end / 2),
        )
        meshes.append(top.mesh(f"pavement-{name}", slabs))
        low, high = sorted((side * KERB, side * (KERB + 0.1)))
        kerb = box((low, -0.02, start), (high, PAVEMENT_HEIGHT, end), "-x+z-z" if side > 0 else "+x+z-z")
        meshes.append(kerb.mesh(f"kerb-{name}", Diffuse(color=(0.42, 0.41, 0.39))))
    meadow = grid((-440, -0.06, 440), (880, 0, 0), (0, 0, -880), (4, 4), (0, 0, 110, 110))
    meshes.append(meadow.mesh("meadow", Diffuse(texture=wear.meadow(), color=(1, 1, 1))))
    return [*meshes, hills()]


def hills() -> Mesh:
    """Distant hills all around the town."""
    count = 36
    angle = np.arange(count) * 2 * np.pi / count
    height = 17 + 7 * np.sin(3 * angle + 1) + 4 * np.sin(7 * angle) + 2 * np.sin(11 * angle + 2)
    around = np.stack([np.cos(angle), np.zeros(count), -np.sin(angle)], axis=-1)
    rings = np.stack([420 * around + np.outer(height, (0, 1, 0)), 395 * around + (0, -1, 0)])
    faces = creased(rings.reshape(-1, 3), _ring_faces(count), 60.0)
    return faces.painted((0.22, 0.30, 0.26)).mesh("hills", Diffuse(color=(1, 1, 1)))


def _ring_faces(count: int) -> np.ndarray:
    one = np.arange(count)
    after = (one + 1) % count
    return np.concatenate([np.stack([one, after, one + count], 1), np.stack([after, after + count, one + count], 1)])


def houses() -> list[Mesh]:
    """Two rows of houses, with lanes between some of them."""
    styles = [
        Diffuse(texture=wear.facade((148, 84, 64), (206, 198, 180), 21, bricks=True), color=(1, 1, 1)),
        Diffuse(texture=wear.facade((214, 198, 160), (236, 232, 220), 22, bricks=False), color=(1, 1, 1)),
        Diffuse(texture=wear.facade((150, 160, 158), (222, 222, 214), 23, bricks=False), color=(1, 1, 1)),
        Diffuse(texture=wear.facade((176, 152, 120), (224, 214, 194), 24, bricks=True), color=(1, 1, 1)),
    ]
    shops = Diffuse(texture=wear.shop_fronts(), color=(1, 1, 1))
    tiles = Diffuse(texture=wear.roof_tiles(), color=(1, 1, 1))
    boards = Diffuse(texture=wear.signs(), color=(1, 1, 1))
    generator = np.random.default_rng(2007)
    meshes: list[Mesh] = []
    shop = 0
    for side, name, seam in ((-1, "left", 3), (1, "right", 1)):
        z, number = STREET[0] + 2.0, 0
        while z < STREET[1] - 20.0:
            modules, storeys = int(generator.integers(2, 4)), int(generator.integers(1, 5))
            style = styles[(number * 3 + seam + int(generator.integers(2))) % len(styles)]
            width = modules * MODULE

            def placed(shape: Solid, z: float = z, width: float = width, side: int = side) -> Solid:
                if side < 0:
                    return shape.turned(90.0).moved(-HOUSES, 0, z + width)
                return shape.turned(-90.0).moved(HOUSES, 0, z)

            part = f"house-{name}-{number}"
            meshes.append(placed(walls(modules, storeys)).mesh(f"{part}/walls", style))
            meshes.append(placed(shop_row(modules, shop)).mesh(f"{part}/shops", shops))
            meshes.append(placed(roof(modules, storeys)).mesh(f"{part}/roof", tiles))
            hung = sign((shop + number) % len(wear.SIGNS)).moved(MODULE * (1 + number % 2), 0, 0)
            meshes.append(placed(hung).mesh(f"{part}/sign", boards))
            shop += modules
            number += 1
            z += width + (4.0 if number % 4 == 3 else 0.0)
    return meshes


def walls(modules: int, storeys: int) -> Solid:
    """The upper storeys of a house whose front faces +z, from x = 0, with its ledges, sides, back and gables."""
    width, depth, foot = modules * MODULE, 10.0, PAVEMENT_HEIGHT + SHOP_HEIGHT
    top = foot + storeys * STOREY
    front = grid((0, foot, 0), (width, 0, 0), (0, top - foot, 0), (modules, storeys), (0, 0, modules, storeys / 2))
    height = front.positions[:, 1]
    parts = [front.shaded(np.where((height < foot + 0.1) | (height > top - 0.1), 0.78, 1.0))]
    plain, trim = (0.44, 0.3, 0.56, 0.7), (0.44, 0.465, 0.56, 0.480)
    parts.append(grid((width, 0, 0), (0, 0, -depth), (0, top, 0), image=plain))
    parts.append(grid((0, 0, -depth), (0, 0, depth), (0, top, 0), image=plain))
    parts.append(grid((width, 0, -depth), (-width, 0, 0), (0, top, 0), image=plain))
    ridge = np.array([[0, top, 0], [0, top + 3.0, -depth / 2], [0, top, -depth]], float)
    corner = np.array([[0.44, 0.7], [0.5, 0.3], [0.56, 0.7]])
    parts.append(creased(ridge, np.array([[0, 1, 2]]), texcoords=corner))
    parts.append(creased(np.add(ridge, (width, 0, 0)), np.array([[0, 2, 1]]), texcoords=corner))
    parts.append(box((0, foot - 0.12, 0), (width, foot + 0.14, 0.16), "+x-x+y-y+z", trim))
    parts.append(box((0, top - 0.48, 0), (width, top - 0.23, 0.39), "+x-x+y-y+z", trim))
    return join(parts)


def shop_row(modules: int, first: int) -> Solid:
    """Shop fronts from the atlas, one a module, on the foot of a house."""
    parts = []
    for i in range(modules):
        cell = (first + i) % len(wear.SHOPS)
        left, top = cell % 2 / 2, cell // 2 / 4
        image = (left, top, left + 0.5, top + 0.25)
        front = grid((i * MODULE, PAVEMENT_HEIGHT, 0), (MODULE, 0, 0), (0, SHOP_HEIGHT, 0), (1, 4), image)
        low = front.positions[:, 1] < PAVEMENT_HEIGHT + 0.1
        parts.append(front.shaded(np.where(low, 0.6, 1.0)))
    return join(parts)


def roof(modules: int, storeys: int) -> Solid:
    """Two slopes over a house; the one to the street stands out beyond its ledge."""
    width, depth, eaves, rise = modules * MODULE, 10.0, 0.4, 3.0
    top = PAVEMENT_HEIGHT + SHOP_HEIGHT + storeys * STOREY + 0.005
    drop = rise / (depth / 2) * eaves
    image = (0.0, 0.0, width / 3, 2.0)
    front = grid((0, top - drop, eaves), (width, 0, 0), (0, rise + drop, -depth / 2 - eaves), image=image)
    back = grid((width, top, -depth), (-width, 0, 0), (0, rise, depth / 2), image=image)
    return join([front, back])


def sign(cell: int) -> Solid:
    """A board of 1.8 m by 0.9 m that stands out from a front, to be read along the street."""
    left, top = cell % 2 / 2, cell // 2 / 4
    image = (left, top, left + 0.5, top + 0.25)
    edge = (left + 0.004, top + 0.004, left + 0.008, top + 0.008)
    low, high = (-0.05, 3.75, 0.25), (0.05, 4.65, 2.05)
    arm = box((-0.02, 4.15, 0.0), (0.02, 4.19, 0.25), "+x-x", edge)
    return join([box(low, high, "+x-x", image), box(low, high, "+y-y+z", edge), arm])


def trees() -> list[Mesh]:
    """Trees on the pavements, each with the shade at its foot."""
    foliage = Diffuse(texture=leaves(), color=(1, 1, 1))
    slabs = Diffuse(texture=wear.pavement(), color=(1, 1, 1))
    generator = np.random.default_rng(4)
    points, faces = icosphere(1)
    meshes = []
    shades = []
    for number, (x, z) in enumerate(TREES):
        tall = generator.uniform(0.9, 1.2)
        trunk = lathe([(0.16, 0.0), (0.11, 1.6), (0.09, 3.2 * tall)], 6).painted((0.16, 0.11, 0.08))
        balls = []
        for middle, radius in (((0.0, 3.6, 0.0), 1.35), ((0.35, 4.6, -0.3), 1.0)):
            bumps = 1 + 0.16 * np.sin(points @ generator.normal(size=(3, 3)) * 3).sum(axis=1, keepdims=True) / 1.5
            ball = points * bumps * radius * (1, 0.9, 1) + np.asarray(middle) * (1, tall, 1)
            light = np.clip(0.62 + 0.30 * points[:, 1] + 0.12 * (ball[:, 1] - 3.6), 0.32, 1.0)
            balls.append(creased(ball, faces, 70.0, leafage(ball[faces]), light[:, None] * np.ones(3)))
        meshes.append(trunk.moved(x, PAVEMENT_HEIGHT, z).mesh(f"tree-{number}/trunk", Diffuse(color=(1, 1, 1))))
        crown = join(balls).turned(generator.uniform(0, 360)).moved(x, PAVEMENT_HEIGHT, z)
        meshes.append(crown.mesh(f"tree-{number}/crown", foliage))
        shades.append(shade((x, PAVEMENT_HEIGHT + 0.008, z), 0.7, 0.7, SLAB_TILE))
    return [*meshes, join(shades).mesh("tree-shade", slabs)]


def leafage(corners: np.ndarray) -> np.ndarray:
    """Texture coordinates (F, 3, 2) in the plane of each triangle (F, 3, 3): foliage shows no seams."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    right = np.cross((0.0, 1.0, 0.0), normal)
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    down = np.cross(right, normal)
    down /= np.linalg.norm(down, axis=1, keepdims=True)
    return np.einsum("fck,fak->fca", corners, np.stack([right, down], axis=1)) / 1.5


def lamps() -> list[Mesh]:
    """Street lamps whose arms reach over the road."""
    meshes = []
    for number, (x, z) in enumerate(LAMPS):
        post = lathe([(0.10, 0.0), (0.09, 0.5), (0.055, 0.55), (0.045, 6.2)], 8)
        arm = cylinder(0.035, 1.5, 6).turned(-80.0, axis=2).moved(0.0, 6.15, 0.0)
        head = box((1.3, 6.36, -0.13), (1.95, 6.46, 0.13))
        steel = join([post, arm, head]).painted((0.06, 0.085, 0.075))
        bulb = box((1.35, 6.34, -0.1), (1.9, 6.36, 0.1), "-y").moved(0, -0.004, 0).painted((0.9, 0.88, 0.8))
        lamp = join([steel, bulb]).turned(180.0 if x > 0 else 0.0).moved(x, PAVEMENT_HEIGHT, z)
        meshes.append(lamp.mesh(f"lamp-{number}", Diffuse(color=(1, 1, 1))))
    return meshes


def car_shade(x: float, z: float) -> Solid:
    """The shade below a car on the road; near the kerb it ends there."""
    return shade((x, 0.008, z), min(0.88, KERB - 0.26 - abs(x)), 2.15, ROAD_TILE)


def cars() -> list[Mesh]:
    """Parked and driving cars, each with its number plates, and the shade below them all."""
    plates = Diffuse(texture=wear.plates(), color=(1, 1, 1))
    meshes = []
    shades = []
    for number, (x, z, turn, paint) in enumerate(CARS):
        meshes.append(saloon(paint).turned(turn).moved(x, 0, z).mesh(f"car-{number}", Diffuse(color=(1, 1, 1))))
        plate = number_plates(number % len(wear.PLATES)).turned(turn).moved(x, 0, z)
        meshes.append(plate.mesh(f"car-{number}/plates", plates))
        shades.append(car_shade(x, z))
    return [*meshes, join(shades).mesh("car-shade", Diffuse(texture=wear.road(), color=(1, 1, 1)))]
