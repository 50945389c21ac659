"""Readers of files with curves, by how a file's name ends."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from virtualrobot.errors import InvalidArgumentError, UnknownNameError, WrongStateError

from virtualrobot_apps.curves import opencascade, vda
from virtualrobot_apps.curves.curve import Curve, with_length

VDA = (".vda", ".vdafs")
IGES = (".iges", ".igs")
MAX_SECONDS = 300
"""Time (s) that Open CASCADE gets for a file."""

_NUMBER = re.compile(r"([+-]?(\d+\.?\d*|\.\d+)([EeDd][+-]?\d+)?)?")
_COLORING = re.compile(r"\x1b\[[0-9;]*m")


def read_curves(path: Path, names: Sequence[str] = ()) -> list[Curve]:
    """Return the curves of a CAD file in meters, in the file's order or as `names` has them.

    A name that the file gives twice becomes NAME_2, and a curve without one curve_1 and so on, by its place.

    Raises:
        InvalidArgumentError: for a file that can't be read, without curves, or of another kind; for a curve without
            length.
        UnknownNameError: for a name that no curve of the file has.
        WrongStateError: for IGES and STEP where the package that reads them is not installed.
    """
    kind = path.suffix.lower()
    if kind not in (*VDA, *IGES, *opencascade.STEP):
        known = ", ".join((*VDA, *IGES, *opencascade.STEP))
        raise InvalidArgumentError(f"{path}: curves are read from files whose names end in {known}")
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InvalidArgumentError(f"{path} can't be read: {error.strerror}") from None
    found = vda.read(data.decode("latin-1"), str(path)) if kind in VDA else _by_opencascade(path, data)
    found = _named(found)
    if not found:
        raise InvalidArgumentError(f"{path} has no curves")
    if names:
        by_name = {one.name: one for one in found}
        for name in names:
            if name not in by_name:
                valid = ", ".join(by_name)
                raise UnknownNameError(f"{path} has no curve {name!r}; it has {valid}", metadata={"valid": valid})
        found = [by_name[name] for name in names]
    return [with_length(one) for one in found]


def _named(curves: list[Curve]) -> list[Curve]:
    """Return curves with a name each, none twice."""
    used: set[str] = set()
    found: list[Curve] = []
    for number, curve in enumerate(curves, 1):
        name = base = curve.name or f"curve_{number}"
        count = 1
        while name in used:
            count += 1
            name = f"{base}_{count}"
        used.add(name)
        found.append(Curve(name, curve.pieces, curve.normals))
    return found


def _by_opencascade(path: Path, data: bytes) -> list[Curve]:
    """Return the curves of an IGES or STEP file, read by Open CASCADE in a process of its own."""
    if path.suffix.lower() in IGES:
        _check_iges(str(path), data.decode("latin-1"))
    elif b"END-ISO-10303-21" not in data[-4096:]:
        raise InvalidArgumentError(f"{path} is cut off, or no STEP: it does not end with END-ISO-10303-21")
    if find_spec("OCP") is None:
        raise WrongStateError(f"{path.suffix} needs the package cadquery-ocp-novtk: pip install 'virtualrobot[curves]'")
    with TemporaryDirectory() as folder:
        output = Path(folder) / "curves.json"
        command = [sys.executable, "-m", opencascade.__name__, str(path), str(output)]
        try:
            done = subprocess.run(command, capture_output=True, timeout=MAX_SECONDS, check=False)
        except subprocess.TimeoutExpired:
            raise InvalidArgumentError(f"{path}: Open CASCADE has not read it in {MAX_SECONDS} seconds") from None
        if done.returncode or not output.exists():
            lines = _COLORING.sub("", done.stderr.decode("utf-8", "replace")).split("\n")
            said = next((line.strip(" *") for line in reversed(lines) if line.strip(" *")), "it crashed")
            raise InvalidArgumentError(f"{path}: Open CASCADE can't read it: {said}")
        told = json.loads(output.read_text("utf-8"))
    return [
        Curve(one["name"], tuple(np.array(piece) * [1e-3, 1e-3, 1e-3, 1.0] for piece in one["pieces"])) for one in told
    ]


def _check_iges(file: str, text: str) -> None:
    """Raise InvalidArgumentError for a file of IGES that is cut off, and for a number of a curve that is none.

    Open CASCADE reads another number then, and says nothing. Source: IGES 5.3, 2.2.4: records of 80 columns.
    """
    lines = text.rstrip().splitlines()
    if not lines or lines[-1][72:73] != "T":
        raise InvalidArgumentError(f"{file} is cut off, or no IGES: it does not end with a record T")
    general = next((line for line in lines if line[72:73] == "G"), "")
    if not general.startswith((",,", "1H,,1H;,")):
        return  # it separates its numbers by characters of its own
    kind = ""
    for number, line in enumerate(lines, 1):
        if line[72:73] != "P":
            continue
        fields = line[:64].partition(";")[0].rstrip().rstrip(",").split(",")
        if not kind:
            kind = fields[0].strip()
        wrong = next((one.strip() for one in fields if not _NUMBER.fullmatch(one.strip())), None)
        if wrong is not None and kind in map(str, opencascade.IGES_CURVES):
            raise InvalidArgumentError(f"{file}:{number}: {wrong!r} in an entity of type {kind} is no number")
        if ";" in line[:64]:
            kind = ""
