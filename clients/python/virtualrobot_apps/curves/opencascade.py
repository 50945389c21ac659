"""Curves of IGES and STEP, as Open CASCADE reads them; run as a process, which writes them as JSON.

The process is one of its own since broken files can crash it, and since it prints at will.
"""

# The library makes its names as it is imported:
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

STEP = (".step", ".stp")
IGES_CURVES = (100, 102, 104, 110, 112, 126)
"""Types of the entities of IGES that are curves: arc, composite, conic, line, and both splines."""


def main(file: str, output: str) -> None:
    """Write the curves of a file: of each its name and pieces (k, 4), as `Curve` has them, in mm."""
    reader = _reader(file)
    found = [{"name": name, "pieces": _pieces(edge)} for name, edge in _edges(reader)]
    Path(output).write_text(json.dumps([one for one in found if one["pieces"]]), encoding="utf-8")


def _reader(file: str) -> Any:  # noqa: ANN401 a class of a library without types
    """Return a reader that has read a file; ends the process with words about a broken one."""
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.IGESControl import IGESControl_Reader
    from OCP.STEPControl import STEPControl_Reader

    reader = STEPControl_Reader() if file.lower().endswith(STEP) else IGESControl_Reader()
    if reader.ReadFile(file) != IFSelect_ReturnStatus.IFSelect_RetDone:
        sys.exit("it is of another kind, or broken")
    checks = reader.WS().ModelCheckList(True)
    checks.Start()
    while checks.More():
        if checks.Value().HasFailed():
            sys.exit(f"entity {checks.Number()}: {checks.Value().CFail(1)}")
        checks.Next()
    for number in range(1, reader.NbRootsForTransfer() + 1):
        entity = reader.RootForTransfer(number)
        done = reader.TransferOneRoot(number)
        kind = entity.TypeNumber() if hasattr(entity, "TypeNumber") else 0
        if not done and kind in IGES_CURVES:
            sys.exit(f"the curve {_name(entity) or number}, of type {kind}, has no length, or wrong numbers")
    return reader


def _edges(reader: Any) -> Iterator[tuple[str, Any]]:  # noqa: ANN401
    """Yield each edge once, with its name in the file, or else that of what it is part of."""
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    transfer, seen = reader.WS().TransferReader(), dict[int, list[Any]]()
    for number in range(1, reader.NbShapes() + 1):
        shape = reader.Shape(number)
        whole = _name(transfer.EntityFromShapeResult(shape, -1))
        explorer = TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_EDGE)
        while explorer.More():
            edge = TopoDS.Edge(explorer.Current())
            same = seen.setdefault(hash(edge), [])
            if not any(edge.IsSame(one) for one in same):
                same.append(edge)
                yield _name(transfer.EntityFromShapeResult(edge, -1)) or whole, edge
            explorer.Next()


def _name(entity: Any) -> str:  # noqa: ANN401
    """Return what a file calls an entity, or nothing."""
    if hasattr(entity, "NameValue"):
        text = entity.NameValue()
    else:
        text = entity.Name() if hasattr(entity, "Name") else None
    return "" if text is None else text.ToCString().strip().removesuffix("(0)")  # no subscript of IGES


def _pieces(edge: Any) -> list[list[list[float]]]:  # noqa: ANN401
    """Return the rational Bézier pieces of an edge; none of one that is a point."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.Geom import Geom_TrimmedCurve
    from OCP.GeomConvert import GeomConvert, GeomConvert_BSplineCurveToBezierCurve
    from OCP.TopAbs import TopAbs_Orientation

    if BRep_Tool.Degenerated_s(edge):
        return []
    curve, ends = BRep_Tool.Curve_s(edge, 0.0, 1.0), BRepAdaptor_Curve(edge)
    part = Geom_TrimmedCurve(curve, ends.FirstParameter(), ends.LastParameter())
    splitter = GeomConvert_BSplineCurveToBezierCurve(GeomConvert.CurveToBSplineCurve_s(part))
    found = []
    for number in range(1, splitter.NbArcs() + 1):
        bezier = splitter.Arc(number)
        rows = []
        for place in range(1, bezier.NbPoles() + 1):
            pole, weight = bezier.Pole(place), bezier.Weight(place)
            rows.append([weight * pole.X(), weight * pole.Y(), weight * pole.Z(), weight])
        found.append(rows)
    if edge.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
        found = [rows[::-1] for rows in reversed(found)]
    return found


if __name__ == "__main__":
    main(*sys.argv[1:])
