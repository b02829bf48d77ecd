"""The aspheric door mirror that is shipped as aspheric-door-mirror.step, and the program that writes it.

A left-hand mirror as its driver sees it: x to the right (towards the car), y up, z out of the glass, metres:

    z = sqrt(R^2 - x^2 - y^2) - R - a max(0, -s - x)^3

a sphere of radius R up to the line x = -s, and beyond it curved ever more strongly along x. Position, normal and
curvature are continuous at the line. Write the file anew with: python tests/door_mirror.py FILE
"""

# pyright: reportMissingImports=false
from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

import anamorph

RADIUS = 1.4
SEAM = 0.035
CUBIC = 6.0
SIZE = (0.19, 0.13)
CORNER = 0.022
NAME = "glass"
FILE = Path(anamorph.__file__).parent / "gallery" / "assets" / "aspheric-door-mirror.step"

DEGREE = 5
PIECES = (4, 3, 4)
"""B-spline pieces along x outside the seam and inside it, and along y."""


def height(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """z of the glass, metres."""
    return np.sqrt(RADIUS**2 - x**2 - y**2) - RADIUS - CUBIC * np.maximum(0.0, -SEAM - x) ** 3


def normal(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Unit normals, (N, 3)."""
    depth = np.sqrt(RADIUS**2 - x**2 - y**2)
    slope_x = -x / depth + 3.0 * CUBIC * np.maximum(0.0, -SEAM - x) ** 2
    slope_y = -y / depth
    upward = np.stack([-slope_x, -slope_y, np.ones_like(x)], axis=-1)
    return upward / np.linalg.norm(upward, axis=-1, keepdims=True)


def spline() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The glass as a B-spline surface of degree 5 over its box: poles (P, Q, 3) in metres, and knots along x and y.

    The seam is a knot that leaves two continuous derivatives, as the formula does: the spline follows its jump.
    """
    wide, high = SIZE[0] / 2.0, SIZE[1] / 2.0
    outer = np.linspace(-wide, -SEAM, PIECES[0] + 1)[1:-1]
    inner = np.linspace(-SEAM, wide, PIECES[1] + 1)[1:-1]
    knots_x = np.concatenate([[-wide] * 6, outer, [-SEAM] * 3, inner, [wide] * 6])
    knots_y = np.concatenate([[-high] * 6, np.linspace(-high, high, PIECES[2] + 1)[1:-1], [high] * 6])
    # At the averages of neighbouring knots interpolation is well posed, and there the poles' own x and y lie.
    x, y = (_averages(knots) for knots in (knots_x, knots_y))
    at_x, at_y = np.meshgrid(x, y, indexing="ij")
    along_x: BSpline = make_interp_spline(x, height(at_x, at_y), DEGREE, t=knots_x)
    along_y: BSpline = make_interp_spline(y, along_x.c.T, DEGREE, t=knots_y)
    return np.stack([at_x, at_y, along_y.c.T], axis=-1), knots_x, knots_y


def _averages(knots: np.ndarray) -> np.ndarray:
    means = np.convolve(knots, np.ones(DEGREE) / DEGREE, "valid")[1:-1]
    return np.clip(means, knots[0], knots[-1])


def write(path: str | Path) -> None:
    """Write the STEP file, in millimetres, with rounded corners. Needs OpenCASCADE (the extra `cad`)."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeWire
    from OCP.BRepLib import BRepLib
    from OCP.collections import Array1_double, Array1_int, Array2_gp_Pnt
    from OCP.Geom import Geom_BSplineSurface
    from OCP.gp import gp_Pnt
    from OCP.Message import Message
    from OCP.STEPControl import STEPControl_AsIs, STEPControl_Writer
    from OCP.StepShape import StepShape_Face
    from OCP.TCollection import TCollection_HAsciiString

    Message.DefaultMessenger_s().ChangePrinters().Clear()
    poles, *knots = spline()
    array = Array2_gp_Pnt(1, poles.shape[0], 1, poles.shape[1])
    for (i, j), _ in np.ndenumerate(poles[..., 0]):
        array.SetValue(i + 1, j + 1, gp_Pnt(*(1000.0 * poles[i, j]).tolist()))
    values, counts = [], []
    for sequence in knots:
        places, times = np.unique(1000.0 * sequence, return_counts=True)
        value, count = Array1_double(1, len(places)), Array1_int(1, len(places))
        for number, (place, time) in enumerate(zip(places.tolist(), times.tolist(), strict=True), start=1):
            value.SetValue(number, place)
            count.SetValue(number, time)
        values.append(value)
        counts.append(count)
    surface = Geom_BSplineSurface(array, *values, *counts, DEGREE, DEGREE)
    wire = BRepBuilderAPI_MakeWire()
    for curve, first, last in _outline():
        wire.Add(BRepBuilderAPI_MakeEdge(curve, surface, first, last).Edge())
    face = BRepBuilderAPI_MakeFace(surface, wire.Wire(), True).Face()
    BRepLib.BuildCurves3d_s(face)
    writer = STEPControl_Writer()
    writer.Transfer(face, STEPControl_AsIs)
    model = writer.Model()
    for number in range(1, model.NbEntities() + 1):
        entity = model.Value(number)
        if isinstance(entity, StepShape_Face):
            entity.SetName(TCollection_HAsciiString(NAME))
    writer.Write(str(path))


def _outline() -> list[tuple[object, float, float]]:
    """Curves in (u, v), which are x and y in millimetres, around the glass: four sides and four rounded corners."""
    from OCP.Geom2d import Geom2d_Circle, Geom2d_Line
    from OCP.gp import gp_Ax2d, gp_Circ2d, gp_Dir2d, gp_Pnt2d

    wide, high, corner = 500.0 * SIZE[0], 500.0 * SIZE[1], 1000.0 * CORNER
    curves: list[tuple[object, float, float]] = []
    ways = ((wide, high, 0, 1), (-wide, high, -1, 0), (-wide, -high, 0, -1), (wide, -high, 1, 0))
    for turn, (x, y, along_x, along_y) in enumerate(ways):
        length = 2.0 * (abs(along_x) * (wide - corner) + abs(along_y) * (high - corner))
        middle = gp_Pnt2d(x - np.sign(x) * corner, y - np.sign(y) * corner)
        start = gp_Pnt2d(
            x if along_y else middle.X() - along_x * length, y if along_x else middle.Y() - along_y * length
        )
        curves.append((Geom2d_Line(start, gp_Dir2d(along_x, along_y)), 0.0, length))
        circle = gp_Circ2d(gp_Ax2d(middle, gp_Dir2d(1.0, 0.0)), corner, True)
        curves.append((Geom2d_Circle(circle), turn * np.pi / 2.0, (turn + 1) * np.pi / 2.0))
    return curves


if __name__ == "__main__":
    write(sys.argv[1] if len(sys.argv) > 1 else FILE)
