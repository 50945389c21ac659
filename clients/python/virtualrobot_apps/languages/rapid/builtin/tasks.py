"""Tasks: points at which they meet, and what a program is told about them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from virtualrobot_apps.languages.rapid.faults import RapidStopped
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
    if not point[index]:
        raise RapidStopped("this syncident has no name: declare it as a variable, not as part of a record")
    task.cell.meet(task, point[index], [name for (name,) in tasks[at]], longest)


@function("IsSyncMoveOn", "", "bool")
def _is_sync_move_on(task: RapidTask) -> bool:
    """FALSE: no task here makes synchronized moves."""
    return False


@function("TasksInSync", "inout tasks TaskList{*}", "num")
def _tasks_in_sync(task: RapidTask, tasks: list[list[list[str]]], at: int) -> float:
    """Number of the tasks that make synchronized moves, whose names it gives: none."""
    for one in tasks[at]:
        one[0] = ""
    return 0.0


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
