"""Tasks: points at which they meet, and what a program is told about them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from virtualrobot_apps.languages.rapid.faults import RapidFault, RapidStopped
from virtualrobot_apps.languages.rapid.table import function, instruction

if TYPE_CHECKING:
    from virtualrobot_apps.languages.rapid.task import RapidTask


@instruction("WaitSyncTask", r"\switch InPos, var syncident SyncID, pers tasks TaskList{*} \num TimeOut")
def _wait_sync_task(
    task: RapidTask,
    in_position: bool | None,
    point: list[str],
    index: int,
    tasks: list[list[list[str]]],
    at: int,
    longest: float | None,
) -> None:
    """Waits until all tasks of the list are at the point of this name; after TimeOut (s) it is ERR_WAITSYNCTASK."""
    if in_position:
        task.finish()
    else:
        task.settle()
    task.cell.meet(task, _named(point[index]), [name for (name,) in tasks[at]], longest)


def _named(point: str) -> str:
    """Return the name of a point."""
    if not point:
        raise RapidStopped("this syncident has no name: declare it as a variable, not as part of a record")
    return point


@instruction("SyncMoveOn", r"var syncident SyncID, pers tasks TaskList{*} \num TimeOut")
def _sync_move_on(
    task: RapidTask, point: list[str], index: int, tasks: list[list[list[str]]], at: int, longest: float | None
) -> None:
    """Lets the robots of all tasks of the list move together from now on, when they stand and the tasks have met."""
    if task.world.group is not None:
        raise RapidStopped("SyncMoveOn is done already; SyncMoveOff ends it")
    task.finish()
    group = task.cell.synchronize(task, _named(point[index]), [name for (name,) in tasks[at]], longest)
    task.world.join(task, group, task.name.lower())


@instruction("SyncMoveOff", r"var syncident SyncID \num TimeOut")
def _sync_move_off(task: RapidTask, point: list[str], index: int, longest: float | None) -> None:
    """Lets each robot move alone again, when all stand and their tasks have met."""
    group = task.world.group
    if group is None:
        raise RapidStopped("SyncMoveOff needs a SyncMoveOn before it")
    task.finish()
    task.cell.meet(task, _named(point[index]), sorted(group.names), longest)
    task.world.leave(task)


@instruction("SyncMoveUndo")
def _sync_move_undo(task: RapidTask) -> None:
    """Lets the robot move alone again, whatever the others do, as in an UNDO part; harmless where it does so."""
    if task.has_robot and task.world.group is not None:
        task.world.leave(task)


@function("IsSyncMoveOn", "", "bool")
def _is_sync_move_on(task: RapidTask) -> bool:
    """TRUE where the task's robot moves together with others."""
    return task.has_robot and task.world.group is not None


@function("TasksInSync", "inout tasks TaskList{*}", "num")
def _tasks_in_sync(task: RapidTask, tasks: list[list[list[str]]], at: int) -> float:
    """Number of the tasks whose robots move together, whose names it gives."""
    group = task.world.group if task.has_robot else None
    names = [task.cell.tasks[name].name for name in sorted(group.names)] if group is not None else []
    if len(names) > len(tasks[at]):
        raise RapidFault("ERR_ARGVALERR", f"{len(names)} tasks move together, and the list has {len(tasks[at])}")
    for number, one in enumerate(tasks[at]):
        one[0] = names[number] if number < len(names) else ""
    return float(len(names))


@function("GetTaskName", "", "string", lacking="TaskNo MecTaskNo")
def _get_task_name(task: RapidTask) -> str:
    """Name of the task."""
    return task.name


@function("TaskRunRob", "", "bool")
def _task_run_rob(task: RapidTask) -> bool:
    """TRUE where the task moves a robot."""
    return task.has_robot


@function("TaskRunMec", "", "bool")
def _task_run_mec(task: RapidTask) -> bool:
    """TRUE where the task moves anything, which is a robot here."""
    return task.has_robot
