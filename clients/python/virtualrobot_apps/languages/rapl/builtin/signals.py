"""Inputs and outputs: signals of the world, by number."""

from __future__ import annotations

from typing import TYPE_CHECKING

from virtualrobot_apps.languages.rapl.table import command

if TYPE_CHECKING:
    from virtualrobot_apps.languages.rapl.task import RaplTask


@command("OUTPUT", "signal...", signals="output")
def _output(task: RaplTask, signals: list[tuple[int, bool]]) -> None:
    """Sets outputs on, and those with - off, at once, while the arm moves on."""
    task.set_outputs(signals)


@command("IFSIG", "signal... THEN line", signals="input")
def _if_signal(task: RaplTask, signals: list[tuple[int, bool]], line: int) -> None:
    """Goes on at a line where all these inputs are on, and those with - off."""
    if task.inputs_are(signals):
        task.go_to(line)


@command("WAIT", "signal", signals="input")
def _wait(task: RaplTask, signal: tuple[int, bool]) -> None:
    """Waits until an input is on, with - off, while the arm moves on."""
    task.wait_until(lambda: task.inputs_are([signal]))


@command("AOUT", "number number")
def _analog(task: RaplTask, output: float, value: float) -> None:
    """Sets an analog output, a signal `analog_` and its number, to -5 to 5."""
    task.set_analog(output, value)
