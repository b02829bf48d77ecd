"""A furnished room in which a polished Utah teapot stands on a table."""

from __future__ import annotations

import numpy as np
from PIL import Image, ImageDraw

from anamorph.gallery.solids import Solid, box, grid, join, lathe
from anamorph.gallery.teapot import teapot
from anamorph.gallery.textures import Rgb, centered, checkerboard, mottled, noise, planks, texture
from anamorph.scene.camera import Camera
from anamorph.scene.model import (
    AmbientLight,
    Color,
    Diffuse,
    DirectionalLight,
    Mesh,
    Mirror,
    PointLight,
    Scene,
    Texture,
)

WIDTH, HEIGHT, DEPTH = 4.2, 2.6, 4.0
TABLE_HEIGHT = 0.75
PATCH_VERTICES = 9
POT_HEIGHT = 0.16
# x, z and colour; name, x, z, radius and colour.
CUPS: tuple[tuple[float, float, Color], ...] = (
    (0.23, 0.10, (0.10, 0.24, 0.55)),
    (-0.20, 0.16, (0.75, 0.55, 0.12)),
    (-0.12, -0.26, (0.12, 0.42, 0.30)),
)
FRUITS: tuple[tuple[str, float, float, float, Color], ...] = (
    ("orange", 0.12, 0.24, 0.036, (0.85, 0.32, 0.03)),
    ("lemon", 0.04, 0.27, 0.027, (0.88, 0.72, 0.08)),
)
TITLES = ("OPTICS", "CURVES", "ATLAS", "LIGHT", "GLASS", "RAYS", "MAPS", "EUCLID")


def room() -> Scene:
    """The built-in scene `room`."""
    silver = Mirror(tint=(1.0, 0.97, 0.93), reflectance=0.88)
    pot = teapot((0.0, TABLE_HEIGHT + 0.001, 0.0), POT_HEIGHT, 20.0, silver, PATCH_VERTICES)
    toward = np.array([-0.75, 0.45, 0.35])
    return Scene(
        name="room",
        meshes=(*pot, *furniture()),
        camera=Camera(position=(0.30, 1.08, 0.86), target=(0.02, 0.825, 0.0), field_of_view=24.0),
        lights=(
            DirectionalLight(toward=tuple(toward / np.linalg.norm(toward)), color=(0.42, 0.40, 0.36)),
            PointLight(position=(0.3, 1.85, 0.6), color=(0.62, 0.56, 0.48)),
            AmbientLight(sky=(0.42, 0.42, 0.44), ground=(0.30, 0.27, 0.24)),
        ),
    )


def furniture() -> list[Mesh]:
    """All of the room but the pot."""
    return [*shell(), *window(), *table(), *tableware(), *shelf(), *images(), door()]


def white(image: Texture | None = None) -> Diffuse:
    return Diffuse(color=(1.0, 1.0, 1.0), texture=image)


def shell() -> list[Mesh]:
    """Floor, ceiling and papered walls, seen from inside."""
    x, z = WIDTH / 2, DEPTH / 2
    floor = grid((-x, 0, z), (WIDTH, 0, 0), (0, 0, -DEPTH), (4, 4), (0, 0, WIDTH / 1.2, DEPTH / 1.2))
    ceiling = grid((-x, HEIGHT, -z), (WIDTH, 0, 0), (0, 0, DEPTH), (4, 4))
    across, along, up = (0, 0, WIDTH / 0.6, HEIGHT / 0.6), (0, 0, DEPTH / 0.6, HEIGHT / 0.6), (0, HEIGHT, 0)
    walls = [
        grid((-x, 0, -z), (WIDTH, 0, 0), up, (4, 4), across),
        grid((x, 0, z), (-WIDTH, 0, 0), up, (4, 4), across),
        grid((-x, 0, z), (0, 0, -DEPTH), up, (4, 4), along),
        grid((x, 0, -z), (0, 0, DEPTH), up, (4, 4), along),
    ]
    skirting = [
        box((-x, 0, -z), (x, 0.12, -z + 0.02), "+y+z"),
        box((-x, 0, z - 0.02), (x, 0.12, z), "+y-z"),
        box((-x, 0, -z), (-x + 0.02, 0.12, z), "+x+y"),
        box((x - 0.02, 0, -z), (x, 0.12, z), "-x+y"),
    ]
    return [
        floor.mesh("floor", white(planks(512, 8, (150, 104, 62), 41))),
        ceiling.mesh("ceiling", Diffuse(color=(0.80, 0.79, 0.76))),
        join(walls).mesh("walls", white(wallpaper())),
        join(skirting).mesh("skirting", Diffuse(color=(0.72, 0.70, 0.66))),
    ]


def wallpaper() -> Texture:
    """Stripes with small flowers, 0.6 m by 0.6 m."""
    image = mottled((256, 256), (196, 206, 188), 42, (16, 64), 2.0)
    draw = ImageDraw.Draw(image)
    for x in range(0, 256, 64):
        draw.rectangle((x, 0, x + 24, 255), fill=(176, 190, 170))
        for y in range(32 * (x // 64 % 2), 256, 64):
            for angle in np.arange(5) * 2 * np.pi / 5:
                left, top = x + 44 + 6 * np.cos(angle), y + 16 + 6 * np.sin(angle)
                draw.ellipse((left - 4, top - 4, left + 4, top + 4), fill=(186, 96, 84))
            draw.ellipse((x + 41, y + 13, x + 47, y + 19), fill=(236, 214, 120))
    return texture(image)


def window() -> list[Mesh]:
    """A bright view on the left wall, in a white frame with a cross."""
    x = -WIDTH / 2
    low, high, near, far = 0.9, 2.2, 0.75, -0.75
    view = grid((x + 0.01, low, near), (0, 0, far - near), (0, high - low, 0), (2, 2))
    bars = [
        box((x, low - 0.08, far - 0.08), (x + 0.05, low, near + 0.08)),
        box((x, high, far - 0.08), (x + 0.05, high + 0.08, near + 0.08)),
        box((x, low, far - 0.08), (x + 0.05, high, far)),
        box((x, low, near), (x + 0.05, high, near + 0.08)),
        box((x + 0.012, low, -0.03), (x + 0.04, high, 0.03)),
        box((x + 0.012, 1.60, far), (x + 0.035, 1.65, near)),
        box((x, low - 0.12, far - 0.12), (x + 0.16, low - 0.085, near + 0.12)),
    ]
    return [
        view.mesh("window/view", Diffuse(color=(2.4, 2.4, 2.4), texture=landscape())),
        join(bars).mesh("window/frame", Diffuse(color=(0.85, 0.85, 0.82))),
    ]


def landscape() -> Texture:
    """Sky with clouds over hills."""
    size = 512
    row = np.linspace(0, 1, size)[:, None, None]
    sky = np.array([112.0, 160, 226]) * (1 - row) + np.array([214.0, 226, 240]) * row
    cloud = np.clip(noise((size, size), 43, (4, 8, 16, 32)) - 0.5, 0, 1)[..., None]
    image = Image.fromarray((sky * (1 - cloud) + 250 * cloud).astype(np.uint8))
    draw = ImageDraw.Draw(image)
    x = np.arange(0, size + 1, 8)
    ridges: tuple[tuple[float, Rgb], ...] = ((330, (128, 152, 168)), (380, (96, 134, 96)), (440, (74, 116, 58)))
    for number, (base, color) in enumerate(ridges):
        y = base + 22 * np.sin(x / (60.0 - 9 * number) + number) + 9 * np.sin(x / 19.0 + 2 * number)
        points = [*zip(x.tolist(), y.tolist(), strict=True), (size, size), (0, size)]
        draw.polygon(points, fill=color)
    return texture(image)


def table() -> list[Mesh]:
    """A wooden table with a chequered cloth across it."""
    wood = white(planks(512, 4, (112, 70, 42), 44))
    top = TABLE_HEIGHT - 0.006
    parts = [box((-0.75, top - 0.035, -0.5), (0.75, top, 0.5))]
    parts += [
        box((x, 0, z), (x + 0.07, top - 0.035, z + 0.07), "+x-x+z-z") for x in (-0.72, 0.65) for z in (-0.47, 0.40)
    ]
    cloth = grid((-0.3, TABLE_HEIGHT, 0.506), (0.6, 0, 0), (0, 0, -1.012), (24, 40), (0, 0, 3, 5))
    cloth = cloth.shaded(shade(cloth.positions))
    drops = [
        grid((-0.3, top - 0.2, 0.506), (0.6, 0, 0), (0, 0.206, 0), image=(0, 0, 3, 1)),
        grid((0.3, top - 0.2, -0.506), (-0.6, 0, 0), (0, 0.206, 0), image=(0, 0, 3, 1)),
    ]
    gingham = white(checkerboard(128, 4, (232, 228, 216), (150, 44, 40)))
    return [join(parts).mesh("table", wood), join([cloth, *drops]).mesh("table/cloth", gingham)]


def shade(points: np.ndarray) -> np.ndarray:
    """The share of light, (V,), that what stands on the cloth leaves to `points` (V, 3) of it."""
    standing = [(0.0, 0.0, 0.085), *((x, z, 0.03) for x, z, _ in CUPS), *((x, z, 0.5 * r) for _, x, z, r, _ in FRUITS)]
    light = np.ones(len(points))
    for x, z, radius in standing:
        distance = np.hypot(points[:, 0] - x, points[:, 2] - z)
        light *= 1.0 - 0.7 * np.clip(1.6 - distance / radius, 0.0, 1.0)
    return light


def tableware() -> list[Mesh]:
    """Cups, an orange and a lemon around the pot."""
    outside = [(0.0, 0.0), (0.022, 0.0), (0.024, 0.006), (0.036, 0.05), (0.038, 0.062)]
    inside = [(0.034, 0.06), (0.021, 0.012), (0.0, 0.01)]
    saucer = [(0.0, 0.0), (0.03, 0.0), (0.062, 0.012), (0.060, 0.014), (0.03, 0.005), (0.0, 0.004)]
    meshes = []
    for number, (x, z, color) in enumerate(CUPS):
        cup = lathe(outside + inside, 28, 50.0).moved(0.0, 0.006, 0.0).painted(color)
        pair = join([lathe(saucer, 28, 50.0).painted((0.85, 0.84, 0.80)), cup])
        meshes.append(pair.moved(x, TABLE_HEIGHT, z).mesh(f"cup-{number}", white()))
    latitude = np.radians(np.linspace(-90, 90, 13))
    for name, x, z, radius, color in FRUITS:
        fruit = lathe([(radius * np.cos(v), radius * (1 + np.sin(v))) for v in latitude], 24, 60.0)
        meshes.append(fruit.moved(x, TABLE_HEIGHT, z).mesh(name, Diffuse(color=color)))
    return meshes


def shelf() -> list[Mesh]:
    """Boards with rows of books on the wall behind the table."""
    z = -DEPTH / 2
    boards = [box((-1.5, y, z), (0.1, y + 0.03, z + 0.24)) for y in (1.02, 1.42)]
    generator = np.random.default_rng(45)
    books: list[Solid] = []
    for base in (1.05, 1.45):
        x, number = -1.46, 0
        while x < -0.05:
            thick, tall = generator.uniform(0.04, 0.07), generator.uniform(0.22, 0.31)
            cell = int(generator.integers(len(TITLES)))
            spine = (cell / 8, 0.0, (cell + 1) / 8, 1.0)
            plain = (cell / 8 + 0.01, 0.02, cell / 8 + 0.02, 0.03)
            books.append(box((x, base, z + 0.02), (x + thick, base + tall, z + 0.2), "+z", spine))
            books.append(box((x, base, z + 0.02), (x + thick, base + tall, z + 0.2), "+x-x+y", plain))
            x += thick + (0.004 if number % 7 else 0.05)
            number += 1
    return [
        join(boards).mesh("shelf", Diffuse(color=(0.30, 0.17, 0.09))),
        join(books).mesh("books", white(spines())),
    ]


def spines() -> Texture:
    """Eight backs of books side by side, their titles running upward."""
    colors: tuple[Rgb, ...] = (
        (128, 32, 30), (28, 62, 108), (38, 92, 54), (170, 120, 40),
        (82, 44, 98), (36, 100, 110), (140, 70, 34), (54, 54, 60),
    )  # fmt: skip
    image = Image.new("RGB", (512, 256))
    for index, (title, color) in enumerate(zip(TITLES, colors, strict=True)):
        back = Image.new("RGB", (256, 64), color)
        draw = ImageDraw.Draw(back)
        for x in (14, 22, 234, 242):
            draw.line((x, 0, x, 63), fill=(226, 196, 110), width=3)
        centered(draw, (128, 32), title, 38, (240, 224, 176))
        image.paste(back.transpose(Image.Transpose.ROTATE_90), (index * 64, 0))
    return texture(image)


def images() -> list[Mesh]:
    """Framed prints with words on them, on the walls before and behind the eye."""
    z = DEPTH / 2
    print_ = texture(poster())
    front = grid((0.45, 1.12, -z + 0.015), (1.1, 0, 0), (0, 0.55, 0))
    back = grid((0.95, 1.15, z - 0.015), (-1.5, 0, 0), (0, 0.75, 0))
    frames = [
        box((0.41, 1.08, -z), (1.59, 1.71, -z + 0.01), "+x-x+y-y+z"),
        box((-0.60, 1.10, z - 0.01), (1.00, 1.95, z), "+x-x+y-y-z"),
    ]
    return [
        join([front, back]).mesh("images", white(print_)),
        join(frames).mesh("images/frames", Diffuse(color=(0.16, 0.09, 0.05))),
    ]


def poster() -> Image.Image:
    image = Image.new("RGB", (512, 256), (238, 230, 208))
    draw = ImageDraw.Draw(image)
    for ring in range(7):
        tone = (196 - 22 * ring, 88 + 12 * ring, 52 + 20 * ring)
        draw.ellipse((26 + 11 * ring, 40 + 11 * ring, 202 - 11 * ring, 216 - 11 * ring), fill=tone)
    centered(draw, (356, 92), "ANAMORPH", 52, (36, 40, 60))
    centered(draw, (356, 156), "seen in curves", 34, (120, 52, 40))
    return image


def door() -> Mesh:
    """A panelled door in the right wall."""
    x = WIDTH / 2
    parts = [
        box((x - 0.03, 0, -0.55), (x, 2.05, 0.45)).painted((0.62, 0.60, 0.55)),
        box((x - 0.05, 0.03, -0.48), (x - 0.02, 1.98, 0.38)).painted((0.34, 0.20, 0.11)),
        *(
            box((x - 0.06, low, near), (x - 0.04, low + 0.75, near + 0.32)).painted((0.42, 0.26, 0.15))
            for low in (0.15, 1.08)
            for near in (-0.42, 0.0)
        ),
        box((x - 0.10, 0.98, 0.27), (x - 0.045, 1.01, 0.35)).painted((0.70, 0.55, 0.20)),
    ]
    return join(parts).mesh("door", white())
