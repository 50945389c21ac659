"""Program: its course, its errors, optional arguments and clocks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from virtualrobot_apps.languages.core.pendant import NobodyAnswers, Question
from virtualrobot_apps.languages.rapid.faults import CycleEnded, RapidStopped
from virtualrobot_apps.languages.rapid.predefined import ERROR_NUMBERS
from virtualrobot_apps.languages.rapid.table import function, instruction
from virtualrobot_apps.languages.rapid.values import Clock

if TYPE_CHECKING:
    from virtualrobot_apps.languages.rapid.task import RapidTask


@function("Present", "any OptPar", "bool")
def _present(task: object, value: Any) -> bool:  # noqa: ANN401 any value of RAPID
    """TRUE where an optional argument was given."""
    return value is not None


@instruction("Stop", r"\switch NoRegain \switch AllMoveTasks")
def _stop(task: RapidTask, no_regain: bool | None, all_tasks: bool | None) -> None:
    """Stops the program when the robot stands, until an answer lets it go on; without one it ends there."""
    task.finish()
    told = "stopped: an answer lets the program go on"
    task.write(told)
    try:
        task.pendant.ask(task, Question(told, ("Start",)))
    except NobodyAnswers:
        raise RapidStopped("Stop, and no answer lets the program go on") from None


@instruction("Break")
def _break(task: RapidTask) -> None:
    """Stops the program as Stop does."""
    _stop(task, None, None)


@instruction("ExitCycle")
def _exit_cycle(task: RapidTask) -> None:
    """Ends the round of main, and the robot's path: static tasks and --continuous begin the next one, others end."""
    raise CycleEnded


@instruction("CallByVar", "string Name, num Number")
def _call_by_var(task: RapidTask, name: str, number: float) -> None:
    """Calls the procedure whose name is a word and a number."""
    task.call_late(f"{name}{int(number)}", [])


@instruction("BookErrNo", "inout errnum ErrorName")
def _book_err_no(task: RapidTask, holder: list[float], index: int) -> None:
    """Gives a variable the number of an error that nothing else has, for RAISE."""
    task.booked += 1
    holder[index] = max(ERROR_NUMBERS.values()) + task.booked


@instruction(
    "ErrLog",
    r"num ErrorID \switch W | switch I, errstr Argument1, errstr Argument2, errstr Argument3, errstr Argument4, "
    "errstr Argument5",
)
def _err_log(task: RapidTask, number: float, warning: bool | None, information: bool | None, *lines: str) -> None:
    """Writes a message of its number and five words into the log."""
    task.settle()
    kind = "warning" if warning else "information" if information else "error"
    task.report(kind, number, [line for line in lines if line])


@instruction("ResetRetryCount")
def _reset_retry_count(task: RapidTask) -> None:
    """Counts the repetitions of an error handler anew; here there may be any number of them."""


@function("TestAndSet", "inout bool Object", "bool")
def _test_and_set(task: RapidTask, holder: list[bool], index: int) -> bool:
    """TRUE where a variable was FALSE; it is TRUE then, and no other task comes between."""
    with task.cell.lock:
        was, holder[index] = holder[index], True
    return not was


@instruction("WaitTestAndSet", "inout bool Object")
def _wait_test_and_set(task: RapidTask, holder: list[bool], index: int) -> None:
    """Waits until a variable is FALSE, and makes it TRUE."""
    while not _test_and_set(task, holder, index):
        task.pause(0.01)


@instruction("ClkReset", "var clock Clock")
def _clk_reset(task: RapidTask, holder: list[Clock], index: int) -> None:
    """Sets a clock to 0."""
    task.settle()
    holder[index].reset()


@instruction("ClkStart", "var clock Clock")
def _clk_start(task: RapidTask, holder: list[Clock], index: int) -> None:
    """Starts a clock."""
    task.settle()
    holder[index].start()


@instruction("ClkStop", "var clock Clock")
def _clk_stop(task: RapidTask, holder: list[Clock], index: int) -> None:
    """Stops a clock."""
    task.settle()
    holder[index].stop()


@function("ClkRead", r"var clock Clock \switch HighRes", "num")
def _clk_read(task: RapidTask, holder: list[Clock], index: int, fine: bool | None) -> float:
    """Time of a clock in seconds of the simulation."""
    task.settle()
    return holder[index].read()
