"""The search on cube maps as a picture: Figure 4 of the paper on virtual objects."""

from __future__ import annotations

import numpy as np
from figures.panels import HALF, INK, Panel, labelled, lined

from anamorph.gallery import make
from anamorph.methods.virtual.cube_search import lookup, search, toward
from anamorph.methods.virtual.reflector_maps import ReflectorMaps, reflector_maps

SIDE = HALF[0]

POINT = "settings"
"""The mesh whose first vertex is searched for."""

FIELD, FLOW, WAY = (120, 138, 160), (40, 96, 168), (196, 40, 30)

SHOWN = 0.9
"""Half the side of what is shown of a face, where the face's own is 1."""


def field() -> list[list[Panel]]:
    """Figure 4: the field of projected bisector directions on a face of the cube, and the steps of one search."""
    scene = make("kitchen")
    meshes = {mesh.name: mesh for mesh in scene.meshes}
    maps = reflector_maps((meshes["kettle"],), 256)
    assert isinstance(maps, ReflectorMaps)
    eye = np.asarray(scene.camera.position) - maps.center
    point = np.asarray(meshes[POINT].positions[0], float) - maps.center
    sink = search(maps, eye + maps.center, (point + maps.center)[None], 400)[0, :3] - maps.center
    axis = int(np.abs(sink).argmax())
    sign = float(np.sign(sink[axis]))

    def direction(place: np.ndarray) -> np.ndarray:
        found = np.empty(3)
        found[axis], found[(axis + 1) % 3], found[(axis + 2) % 3] = sign, *place
        return found

    def place(found: np.ndarray) -> np.ndarray:
        return np.array([found[(axis + 1) % 3], found[(axis + 2) % 3]]) / abs(found[axis])

    def there(at: np.ndarray) -> np.ndarray:
        return np.array(lookup(maps.positions, tuple(direction(at))))

    def bisecting(at: np.ndarray) -> np.ndarray:
        here = tuple(direction(at))
        p = lookup(maps.positions, here)
        return np.array(toward(maps.positions, maps.normals, 1.0, tuple(eye), tuple(point), False, p, here))

    def moved(at: np.ndarray, share: float) -> np.ndarray:
        return place(there(at) + share * bisecting(at))

    middle = place(sink)
    blank = np.full((SIDE, SIDE, 3), 255, np.uint8)

    def pixels(at: np.ndarray, around: np.ndarray, half: float) -> np.ndarray:
        return (np.asarray(at) - around) * [1.0, -1.0] / half * 0.5 * SIDE + 0.5 * SIDE

    arrows = []
    for s in np.linspace(-SHOWN, SHOWN, 27):
        for t in np.linspace(-SHOWN, SHOWN, 27):
            at = np.array([s, t])
            way = moved(at, 1e-3) - at
            way *= 0.028 / max(float(np.linalg.norm(way)), 1e-12)
            arrows.append([pixels(at - 0.5 * way, np.zeros(2), SHOWN), pixels(at + 0.5 * way, np.zeros(2), SHOWN)])
            side = np.array([-way[1], way[0]])
            arrows.append([arrows[-1][1], pixels(at + 0.2 * way + 0.16 * side, np.zeros(2), SHOWN)])
            arrows.append([arrows[-2][1], pixels(at + 0.2 * way - 0.16 * side, np.zeros(2), SHOWN)])
    flows = []
    for angle in np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False):
        at = 0.95 * SHOWN * np.array([np.cos(angle), np.sin(angle)])
        for _ in range(400):
            other = moved(at, 0.04)
            flows.append([pixels(at, np.zeros(2), SHOWN), pixels(other, np.zeros(2), SHOWN)])
            at = other
    left = lined(lined(blank, np.array(arrows), FIELD), np.array(flows), FLOW, 2)
    x, y = pixels(middle, np.zeros(2), SHOWN)
    left = labelled(left, [("R", (x + 8.0, y - 10.0), "lm")])

    whole = maps.center
    steps = [search(maps, eye + whole, (point + whole)[None], count)[0, :3] - whole for count in range(10)]
    places = np.array([place(each) for each in steps])
    half = 1.25 * np.abs(places - middle).max()
    arrows = []
    for s in np.linspace(-half, half, 21):
        for t in np.linspace(-half, half, 21):
            at = middle + np.array([s, t])
            way = moved(at, 1e-3) - at
            way *= 0.06 * half / max(float(np.linalg.norm(way)), 1e-12)
            arrows.append([pixels(at, middle, half), pixels(at + way, middle, half)])
    right = lined(blank, np.array(arrows), FIELD)
    right = lined(right, np.array([pixels(places[i : i + 2], middle, half) for i in range(len(places) - 1)]), WAY, 2)
    marks = []
    for x, y in pixels(places, middle, half):
        marks += [[[x - 4, y - 4], [x + 4, y + 4]], [[x - 4, y + 4], [x + 4, y - 4]]]
    right = lined(right, np.array(marks), INK, 1)
    shown = [
        (str(number), (float(x) + 7.0, float(y) + 9.0), "lm")
        for number, (x, y) in enumerate(pixels(places[:4], middle, half))
    ]
    right = labelled(right, shown, 15)
    return [
        [
            Panel(left, "the field on one face of the kettle's cube map,\nand where it flows"),
            Panel(right, f"{len(places) - 1} steps of the search, enlarged {SHOWN / half:.0f} times"),
        ]
    ]
