"""Execution of RAPID: tasks, start, stop, program pointer."""

from __future__ import annotations

from virtualrobot_apps.emulators.abb.answers import Item
from virtualrobot_apps.emulators.abb.controller import Controller, Unit
from virtualrobot_apps.emulators.abb.refused import unknown
from virtualrobot_apps.emulators.abb.table import Call, resource

STOP_MODES = ("stop", "qstop")


def execution_state(controller: Controller) -> str:
    """Return running or stopped."""
    return "running" if controller.running else "stopped"


@resource("GET", "/rw/rapid/execution")
def _execution(call: Call) -> list[Item]:
    """`ctrlexecstate` (running, stopped) and `cycle` (once, forever)."""
    values = {"ctrlexecstate": execution_state(call.controller), "cycle": call.controller.cycle}
    return [Item("rap-execution", "execution", values)]


@resource("POST", "/rw/rapid/execution", "start")
def _start(call: Call) -> None:
    """Runs main of all active tasks, or goes on; `cycle` is once, forever or asis, `execmode` is continue."""
    mode = call.form.get("execmode", "continue")
    if mode != "continue":
        raise unknown("execution mode", mode, ("continue",))
    call.controller.start(call.form.get("cycle", "asis"))


@resource("POST", "/rw/rapid/execution", "stop")
def _stop(call: Call) -> None:
    """Stops all tasks on their paths; `stopmode` is stop or qstop."""
    mode = call.form.get("stopmode", "stop")
    if mode not in STOP_MODES:
        raise unknown("stop mode", mode, STOP_MODES)
    call.controller.stop()


@resource("POST", "/rw/rapid/execution", "resetpp")
def _reset_pointer(call: Call) -> None:
    """Sets the program pointer of all tasks to main; variables get their first values, persistents stay."""
    call.controller.reset_pointer()


@resource("POST", "/rw/rapid/execution", "setcycle", second="/rw/rapid/execution/cycle")
def _set_cycle(call: Call) -> None:
    """Says how often main is run: `cycle` is once or forever."""
    call.controller.set_cycle(call.needs("cycle"))


@resource("GET", "/rw/rapid/tasks")
def _tasks(call: Call) -> list[Item]:
    """All tasks, each with its state, whether it is active and whether it moves a robot."""
    return [_task_item(call, unit, "rap-task-li") for unit in call.controller.units.values()]


@resource("GET", "/rw/rapid/tasks/{task}")
def _task(call: Call) -> list[Item]:
    """A task, as in the list."""
    return [_task_item(call, call.controller.unit(call.path["task"]), "rap-task")]


@resource("POST", "/rw/rapid/tasks/{task}", "activate", second="/rw/rapid/tasks/activate")
def _activate(call: Call) -> None:
    """Has the task run when the controller starts."""
    call.controller.activate(call.name("task"), True)


@resource("POST", "/rw/rapid/tasks/{task}", "deactivate", second="/rw/rapid/tasks/deactivate")
def _deactivate(call: Call) -> None:
    """Has the task stand still when the controller starts."""
    call.controller.activate(call.name("task"), False)


@resource("GET", "/rw/rapid/tasks/{task}/pcp")
def _pointer(call: Call) -> list[Item]:
    """Module, routine and line of the program pointer; nothing where it is nowhere."""
    found = call.controller.pointer(call.path["task"])
    if found is None:
        return []
    module, routine, line = found
    values = {"modulename": module, "routinename": routine}
    values |= {"beginposition": f"{line},1", "endposition": f"{line},1"}
    return [Item("pcp-info", "progpointer", values)]


def _task_item(call: Call, unit: Unit, kind: str) -> Item:
    values = {
        "name": unit.name,
        "type": "normal" if call.second else "norm",
        "taskstate": "linked" if unit.modules else "initiated",
        "excstate": call.controller.state_of(unit),
        "active": "On" if unit.active else "Off",
        "motiontask": "TRUE",
    }
    return Item(kind, unit.name, values, f"tasks/{unit.name}")
