"""The cell as a slave of FMI 3.0: this file stands in each FMU, and PythonFMU3 calls it."""

from __future__ import annotations

import json
import os
from functools import partial
from pathlib import Path
from typing import Any

import virtualrobot
from pythonfmu3 import (
    Boolean,
    Float64,
    Fmi3Causality,
    Fmi3Slave,
    Fmi3Status,
    Fmi3StepResult,
    Fmi3Variability,
    Int64,
    String,
    Unit,
)
from virtualrobot.errors import VirtualRobotError

from virtualrobot_apps.fmi.cell import INPUT, UNITS, Plan, SteppedCell, Variable

PLAN = "plan.json"
_TYPES: dict[str, Any] = {"Float64": Float64, "Boolean": Boolean, "Int64": Int64, "String": String}


class Cell(Fmi3Slave):
    """A cell of a kernel that runs: it connects when the simulation begins, and each step is one call."""

    def __init__(self, **kwargs: Any) -> None:  # noqa: ANN401 PythonFMU3's own
        """Tell the variables; nothing is connected yet."""
        super().__init__(**kwargs)
        self._plan = Plan.from_plain(json.loads((Path(str(self.resources)) / PLAN).read_text("utf-8")))
        self.modelName = self._plan.model
        self.description = "A cell of VirtualRobot; a kernel runs it."
        self._inputs = {one.name: one.start for one in self._plan.variables if one.causality == INPUT}
        self._outputs = {one.name: one.start for one in self._plan.variables if one.causality != INPUT}
        self._client: Any = None
        self._cell: SteppedCell | None = None
        used = sorted({one.unit for one in self._plan.variables if one.unit})
        self.register_units([Unit(name, **UNITS[name]) for name in used])
        self.time = 0.0
        self.register_variable(
            Float64("time", causality=Fmi3Causality.independent, variability=Fmi3Variability.continuous)
        )
        for one in self._plan.variables:
            self._register(one)

    def _register(self, one: Variable) -> None:
        is_input = one.causality == INPUT
        values = self._inputs if is_input else self._outputs
        options: dict[str, Any] = {
            "causality": Fmi3Causality.input if is_input else Fmi3Causality.output,
            "variability": Fmi3Variability.continuous if one.type == "Float64" else Fmi3Variability.discrete,
            "description": one.description or None,
            "getter": partial(values.__getitem__, one.name),
            "setter": partial(values.__setitem__, one.name),
        }
        if one.unit:
            options["unit"] = one.unit
        self.register_variable(_TYPES[one.type](one.name, **options), nested=False)

    def exit_initialization_mode(self) -> None:
        """Connect, and take the clock."""
        address = os.environ.get("VIRTUALROBOT_ADDRESS") or self._plan.address or None
        self._client = virtualrobot.connect(address, name=f"FMU {self._plan.model}", on_progress=None)
        self._cell = SteppedCell(self._client, self._plan)
        self._outputs.update(self._cell.values())

    def do_step(self, current_time: float, step_size: float) -> Fmi3StepResult:
        """Let time go on; what the kernel refuses is logged, and ends the simulation."""
        assert self._cell is not None
        try:
            self._cell.step(current_time + step_size, self._inputs)
        except VirtualRobotError as error:
            self.log(str(error), Fmi3Status.error)
            return Fmi3StepResult(status=Fmi3Status.error)
        self._outputs.update(self._cell.values())
        return Fmi3StepResult(status=Fmi3Status.ok)

    def terminate(self) -> None:
        """Let robots come to rest, and time go on as before."""
        if self._cell is not None:
            self._cell.close()
            self._cell = None
        if self._client is not None:
            self._client.close()
            self._client = None
