"""FMUs of cells: PythonFMU3 packs the plan, the slave and itself."""

from __future__ import annotations

import json
import shutil
import tempfile
from pathlib import Path

from pythonfmu3.builder import FmuBuilder
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.fmi import slave
from virtualrobot_apps.fmi.cell import Plan


def export_cell(plan: Plan, file: Path) -> None:
    """Write a cell as an FMU for co-simulation of FMI 3.0.

    Raises:
        InvalidArgumentError: when the file can't be written.
    """
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "virtualrobot_cell.py"
        source.write_text(Path(slave.__file__).read_text("utf-8"), "utf-8")
        described = Path(folder) / slave.PLAN
        described.write_text(json.dumps(plan.to_plain()), "utf-8")
        made = FmuBuilder.build_FMU(
            source,
            Path(folder) / "made",
            [described],
            needsExecutionTool=True,
            canBeInstantiatedOnlyOncePerProcess=True,
        )
        try:
            shutil.copyfile(made, file)
        except OSError as error:
            raise InvalidArgumentError(f"{file} cannot be written: {error.strerror or error}") from error
