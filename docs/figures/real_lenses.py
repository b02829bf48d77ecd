"""One scene by every model of a real camera's lens, for real-cameras.md."""

from __future__ import annotations

from figures.panels import Panel

import anamorph as an
from anamorph import cameras
from anamorph.base.output import to_pixels
from anamorph.cameras import Intrinsics
from anamorph.gallery.cube import cube_scene
from anamorph.raymesh import RayMesh

SQUARE, WIDE = (310, 310), (630, 315)
EYE = an.Camera((1.6, 2.0, 2.6), (0.0, 0.4, 0.0))
METHOD = "trilinear:antialias=4"


def models() -> list[list[Panel]]:
    """The cube and its board as each model shows them, from one place."""

    def middle(focal: float) -> Intrinsics:
        return Intrinsics(focal, focal, SQUARE[0] / 2, SQUARE[1] / 2)

    squares: dict[str, cameras.LensModel] = {
        "pinhole": cameras.DistortedPinhole(middle(140.0)),
        "5 coefficients": cameras.DistortedPinhole(middle(140.0), (-0.22, 0.03, 0.002, -0.001, 0.0)),
        "folds: holes": cameras.DistortedPinhole(middle(110.0), (-0.3, 0.0, 0.0, 0.0)),
        "Kannala-Brandt": cameras.kannala_brandt(middle(100.0), (-0.01, 0.003, -0.002, 0.0005), 180.0),
        "equidistant, 220°": cameras.Fisheye(middle(80.0), field_of_view=220.0),
        "equisolid": cameras.Fisheye(middle(100.0), "equisolid", field_of_view=200.0),
        "stereographic": cameras.Fisheye(middle(70.0), "stereographic"),
        "f-theta": cameras.f_theta((155.0, 155.0), (110.0, 0.0, -6.0), 160.0),
        "dome master": cameras.dome_master(SQUARE),
        "double sphere": cameras.DoubleSphere(middle(100.0), -0.2, 0.58),
        "unified": cameras.UnifiedOmnidirectional(middle(170.0), 1.2),
    }
    shown = [_shown(cameras.real_camera(each, EYE, SQUARE, holes=True), SQUARE, name) for name, each in squares.items()]
    long = [
        _shown(cameras.real_camera(cameras.Equirectangular(WIDE), EYE, WIDE), WIDE, "equirectangular"),
        _shown(cameras.real_camera(cameras.Cylindrical((630, 250)), EYE, (630, 250)), (630, 250), "cylindrical"),
        _shown(cameras.cube_strip(EYE, 158), (948, 158), "cube strip"),
    ]
    return [shown[0:3], shown[3:6], shown[6:9], shown[9:11], *[[each] for each in long]]


def _shown(rays: RayMesh, size: tuple[int, int], words: str) -> Panel:
    return Panel(to_pixels(an.render(cube_scene(), METHOD, rays, size).color), words)
