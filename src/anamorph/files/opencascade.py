"""STEP and IGES through OpenCASCADE, as a program of its own: python opencascade.py FILE prints a pickle of its faces.

It runs apart because OpenCASCADE ends the whole process at some damaged files, and writes to standard output. Each face
is a dictionary of arrays: a NURBS surface, and the curves in (u, v) that trim it. It imports nothing of anamorph.
"""

# pyright: reportMissingImports=false
from __future__ import annotations

import os
import pickle
import sys
from pathlib import Path
from typing import Any

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_NurbsConvert
from OCP.BRepTools import BRepTools
from OCP.collections import IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher as ShapeMap
from OCP.Geom import Geom_BSplineSurface
from OCP.Geom2d import Geom2d_TrimmedCurve
from OCP.Geom2dConvert import Geom2dConvert
from OCP.IFSelect import IFSelect_RetDone
from OCP.IGESControl import IGESControl_Reader
from OCP.Message import Message
from OCP.STEPControl import STEPControl_Reader
from OCP.TopAbs import (
    TopAbs_EDGE,
    TopAbs_FACE,
    TopAbs_FORWARD,
    TopAbs_REVERSED,
    TopAbs_SHELL,
    TopAbs_SOLID,
)
from OCP.TopExp import TopExp, TopExp_Explorer
from OCP.TopoDS import TopoDS

MILLIMETRE = 1e-3
"""OpenCASCADE's tolerances are made for millimetres: it works in them, and the results are turned into metres."""


def read_faces(path: Path) -> list[dict[str, Any]]:
    """The faces of a file, in its order; ends the program with one line where there are none."""
    step = path.suffix.lower() in (".step", ".stp")
    kind = "STEP" if step else "IGES"
    reader = STEPControl_Reader() if step else IGESControl_Reader()
    if reader.ReadFile(str(path)) != IFSelect_RetDone:
        sys.exit(f"is damaged or no {kind} file; export it again")
    if step:
        reader.SetSystemLengthUnit(1.0)
    if not reader.TransferRoots() or not reader.NbShapes():
        sys.exit(f"has no shape that can be read; export it again as {kind} with surfaces or solids")
    whole, known = reader.OneShape(), reader.WS().TransferReader()
    found = _faces(whole)
    if not found:
        sys.exit("has no faces, only curves or points; export surfaces or solids")
    bodies = _bodies(whole, known)
    faces = []
    for face in found:
        entry = _face(TopoDS.Face(face))
        if entry is not None:
            faces.append({"name": _name(known, face), "body": bodies.get(face, ""), **entry})
    if not faces:
        sys.exit("has no face with an area; export surfaces or solids")
    return faces


def _faces(shape: Any) -> list[Any]:
    shapes = ShapeMap()
    TopExp.MapShapes_s(shape, TopAbs_FACE, shapes)
    return [shapes.FindKey(number) for number in range(1, shapes.Extent() + 1)]


def _bodies(whole: Any, known: Any) -> dict[Any, str]:
    """The name of the solid or shell that each face belongs to."""
    bodies: dict[Any, str] = {}
    for kind in (TopAbs_SHELL, TopAbs_SOLID):
        explorer = TopExp_Explorer(whole, kind)
        while explorer.More():
            if name := _name(known, explorer.Current()):
                bodies |= dict.fromkeys(_faces(explorer.Current()), name)
            explorer.Next()
    return bodies


def _name(known: Any, shape: Any) -> str:
    """What a shape is called in the file, "" for nothing."""
    entity = known.EntityFromShapeResult(shape, 1)
    label = None
    if hasattr(entity, "Name"):
        label = entity.Name()
    elif hasattr(entity, "NameValue"):
        label = entity.NameValue()
    name = label.ToCString().strip() if label is not None else ""
    return "" if name.upper() == "NONE" else name


def _face(face: Any) -> dict[str, Any] | None:
    """Surface and trim curves of one face; None for one without an area."""
    # Orientation is taken off, because along with it the two sides of a seam would change places.
    converted = TopoDS.Face(face.Oriented(TopAbs_FORWARD))
    if not isinstance(BRep_Tool.Surface_s(converted), Geom_BSplineSurface):
        converted = TopoDS.Face(BRepBuilderAPI_NurbsConvert(converted).Shape())
    low_u, high_u, low_v, high_v = BRepTools.UVBounds_s(converted)
    surface = BRep_Tool.Surface_s(converted)
    if not isinstance(surface, Geom_BSplineSurface) or not (low_u < high_u and low_v < high_v):
        return None
    surface = surface.Copy()
    periods = [0.0, 0.0]
    if surface.IsUPeriodic() or surface.IsVPeriodic():
        bounds = surface.Bounds()
        periods = [bounds[1] - bounds[0], bounds[3] - bounds[2]]
        u = _part((low_u, high_u), bounds[:2], surface.IsUPeriodic())
        v = _part((low_v, high_v), bounds[2:], surface.IsVPeriodic())
        surface.Segment(*u, *v)
        if surface.IsUPeriodic():
            surface.SetUNotPeriodic()
        if surface.IsVPeriodic():
            surface.SetVNotPeriodic()
    rows, columns = range(1, surface.NbUPoles() + 1), range(1, surface.NbVPoles() + 1)
    poles = [[surface.Pole(i, j).Coord() for j in columns] for i in rows]
    return {
        "poles": MILLIMETRE * np.array(poles),
        "weights": np.array([[surface.Weight(i, j) for j in columns] for i in rows]),
        "knots_u": _over(_knots(surface.NbUKnots(), surface.UKnot, surface.UMultiplicity), low_u + high_u, periods[0]),
        "knots_v": _over(_knots(surface.NbVKnots(), surface.VKnot, surface.VMultiplicity), low_v + high_v, periods[1]),
        "degree_u": surface.UDegree(),
        "degree_v": surface.VDegree(),
        "sign": -1.0 if face.Orientation() == TopAbs_REVERSED else 1.0,
        "curves": _curves(converted.Oriented(TopAbs_FORWARD)),
    }


def _part(wanted: tuple[float, float], whole: tuple[float, float], periodic: bool) -> tuple[float, float]:
    """What of a surface to keep in one direction: where a face goes all around, exactly that, without its roundings."""
    around = wanted[1] - wanted[0] >= (1.0 - 1e-9) * (whole[1] - whole[0])
    return whole if around or not periodic else wanted


def _over(knots: np.ndarray, doubled_middle: float, period: float) -> np.ndarray:
    """Knots moved by whole periods to where the face is: OpenCASCADE may cut the same part a turn away."""
    if not period:
        return knots
    return knots + period * np.round((doubled_middle - knots[0] - knots[-1]) / (2.0 * period))


def _curves(face: Any) -> list[dict[str, Any]]:
    """The edges of a face as B-spline curves in (u, v)."""
    face = TopoDS.Face(face)
    curves = []
    explorer = TopExp_Explorer(face, TopAbs_EDGE)
    while explorer.More():
        edge = TopoDS.Edge(explorer.Current())
        explorer.Next()
        if edge.Orientation() not in (TopAbs_FORWARD, TopAbs_REVERSED):
            continue
        first, last = BRep_Tool.Range_s(edge, face)
        drawn = BRep_Tool.CurveOnSurface_s(edge, face, first, last)
        if drawn is None or not first < last:
            continue
        curve = Geom2dConvert.CurveToBSplineCurve_s(Geom2d_TrimmedCurve(drawn, first, last))
        if curve.IsPeriodic():
            curve.SetNotPeriodic()
        numbers = range(1, curve.NbPoles() + 1)
        curves.append(
            {
                "poles": np.array([curve.Pole(i).Coord() for i in numbers]),
                "weights": np.array([curve.Weight(i) for i in numbers]),
                "knots": _knots(curve.NbKnots(), curve.Knot, curve.Multiplicity),
                "degree": curve.Degree(),
            }
        )
    return curves


def _knots(count: int, knot: Any, multiplicity: Any) -> np.ndarray:
    numbers = range(1, count + 1)
    return np.repeat([knot(i) for i in numbers], [multiplicity(i) for i in numbers])


def main() -> None:
    """Read the file that the command line names; the pickle goes to what was standard output before it is closed."""
    with os.fdopen(os.dup(1), "wb") as answer:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        Message.DefaultMessenger_s().ChangePrinters().Clear()
        try:
            faces = read_faces(Path(sys.argv[1]))
        # What OpenCASCADE raises at a damaged file has many types.
        except Exception as error:
            sys.exit(f"is damaged ({type(error).__name__} in OpenCASCADE); export it again")
        pickle.dump(faces, answer)


if __name__ == "__main__":
    main()
