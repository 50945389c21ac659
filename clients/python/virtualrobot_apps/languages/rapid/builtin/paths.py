"""Paths: stopped, put aside and taken up again, searches along lines, and what is done at places of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from virtualrobot_apps.languages.rapid.builtin.motion import move_ends
from virtualrobot_apps.languages.rapid.faults import RapidFault, RapidStopped
from virtualrobot_apps.languages.rapid.table import function, instruction
from virtualrobot_apps.languages.rapid.triggered import Trigger, arc, joints, line

if TYPE_CHECKING:
    from virtualrobot_apps.languages.rapid.task import RapidTask


@instruction("StopMove", r"\switch Quick \switch AllMotionTasks")
def _stop_move(task: RapidTask, quick: bool | None, all_tasks: bool | None) -> None:
    """Brakes the robot on its path; moves that come wait for StartMove."""
    task.world.queue.stop()


@instruction("StartMove", r"\switch AllMotionTasks")
def _start_move(task: RapidTask, all_tasks: bool | None) -> None:
    """Lets the robot go on after StopMove."""
    task.world.start()


@instruction("StopMoveReset", r"\switch AllMotionTasks")
def _stop_move_reset(task: RapidTask, all_tasks: bool | None) -> None:
    """Lets the robot go on as StartMove does."""
    task.world.start()


@function("IsStopMoveAct", r"\switch FromMoveTask | switch FromNonMoveTask", "bool")
def _is_stop_move_act(task: RapidTask, own: bool | None, other: bool | None) -> bool:
    """TRUE between StopMove and StartMove."""
    return task.world.queue.stopped


@instruction("StorePath", lacking="KeepSync")
def _store_path(task: RapidTask) -> None:
    """Puts the path aside, where it was stopped or else at the end of the move that is made, so that others go."""
    task.world.store_path()


@instruction("RestoPath")
def _resto_path(task: RapidTask) -> None:
    """Takes the path up again that was put aside; one that was stopped goes on by StartMove."""
    task.world.restore_path()


@instruction("ClearPath")
def _clear_path(task: RapidTask) -> None:
    """Leaves out the moves that are not done, of a robot that was stopped."""
    if not task.world.queue.stopped:
        raise RapidStopped("ClearPath needs a StopMove before it")
    task.world.clear_path()


# Searches.

_FLANKS = r"\switch Flanks | switch PosFlank | switch NegFlank | switch HighLevel | switch LowLevel"
_HEAD = rf"\switch Stop | switch PStop | switch SStop, signaldi Signal {_FLANKS}, var robtarget SearchPoint"
_TAIL = r"robtarget ToPoint, speeddata Speed \num V, pers tooldata Tool \pers wobjdata WObj"


def _search(
    task: RapidTask,
    via: list[Any] | None,
    stop: bool | None,
    path_stop: bool | None,
    soft_stop: bool | None,
    signal: str,
    both: bool | None,
    up: bool | None,
    down: bool | None,
    high: bool | None,
    low: bool | None,
    holder: list[Any],
    index: int,
    target: list[Any],
    *ends: Any,  # noqa: ANN401 see move_ends
) -> None:
    """Search along a line, or an arc through `via`."""
    speed, v, tool, at, *wobj = ends
    speed, _, wobj = move_ends(task, speed, v, None, [True, 0.0], None, tool, at, *wobj)
    now = task.signal_value(signal)
    if both:
        wanted = 1.0 - now
    else:
        wanted = 0.0 if down or low else 1.0
        if now == wanted and not high and not low:
            raise RapidFault("ERR_SIGSUPSEARCH", f"the signal {signal!r} is {now:g} as the search begins")
    stops = bool(stop or path_stop or soft_stop)
    found = task.world.search(via, target, (signal, wanted), speed, wobj, not stops)
    if found is None:
        raise RapidFault("ERR_WHLSEARCH", f"the signal {signal!r} did not become {wanted:g} on the way")
    holder[index][:] = found


@instruction("SearchL", f"{_HEAD}, {_TAIL}", lacking="Sup T Corr TLoad")
def _search_l(task: RapidTask, *given: Any) -> None:  # noqa: ANN401 see _search
    """Moves along a line, keeps the place where a signal changes, and stops there with Stop, PStop or SStop.

    Without these the robot brakes there and then goes on to the end.
    """
    _search(task, None, *given)


@instruction("SearchC", f"{_HEAD}, robtarget CirPoint, {_TAIL}", lacking="Sup T Corr TLoad")
def _search_c(task: RapidTask, *given: Any) -> None:  # noqa: ANN401 see _search
    """Moves along an arc as MoveC does, and keeps the place where a signal changes as SearchL does."""
    before, via, after = given[:11], given[11], given[12:]
    _search(task, via, *before, *after)


# Triggers.

_OUTPUT = r"\signaldo DOp | signalgo GOp | signalao AOp"


def _trigger(
    distance: float,
    from_start: bool | None,
    time: bool | None,
    lag: float,
    delay: float,
    signal: str | None,
    value: float,
    flag: list[Any] | None,
    flag_index: int,
) -> Trigger:
    if distance < 0.0:
        what = "time of a trigger is 0 s" if time else "distance of a trigger is 0 mm"
        raise RapidFault("ERR_ARGVALERR", f"the {what} or more, not {distance:g}")
    inhibit = None if flag is None else (flag, flag_index)
    if time:
        return Trigger(0.0, False, distance, delay, signal, value, inhibit)
    return Trigger(distance, bool(from_start), lag, delay, signal, value, inhibit)


def _output(*signals: str | None) -> str:
    signal = next((one for one in signals if one), None)
    if signal is None:
        raise RapidFault("ERR_ARGVALERR", r"a trigger needs \DOp, \GOp or \AOp")
    return signal


@instruction(
    "TriggIO",
    rf"inout triggdata TriggData, num Distance \switch Start | switch Time {_OUTPUT}, num SetValue \num DODelay "
    r"\pers bool Inhib",
    lacking="ProcID InhibSetValue",
)
def _trigg_io(
    task: RapidTask,
    holder: list[Any],
    index: int,
    distance: float,
    start: bool | None,
    time: bool | None,
    *more: Any,  # noqa: ANN401
) -> None:
    """Describes that a signal is set at a distance (mm) or time (s) before the end of a way, or behind its start.

    It is set to 0 where the flag Inhib is TRUE as the place is passed, by the program's own thread.
    """
    *signals, value, delay, flag, at = more
    holder[index] = _trigger(distance, start, time, 0.0, delay or 0.0, _output(*signals), value, flag, at)


@instruction(
    "TriggEquip",
    rf"inout triggdata TriggData, num Distance \switch Start, num EquipLag {_OUTPUT}, num SetValue \pers bool Inhib",
    lacking="ProcID InhibSetValue",
)
def _trigg_equip(
    task: RapidTask,
    holder: list[Any],
    index: int,
    distance: float,
    start: bool | None,
    lag: float,
    *more: Any,  # noqa: ANN401 signals and their value
) -> None:
    """Describes the same, EquipLag seconds earlier, or at the programmed speed later where it is below 0."""
    *signals, value, flag, at = more
    holder[index] = _trigger(distance, start, None, lag, 0.0, _output(*signals), value, flag, at)


@instruction(
    "TriggInt",
    r"inout triggdata TriggData, num Distance \switch Start | switch Time, var intnum Interrupt \pers bool Inhib",
)
def _trigg_int(
    task: RapidTask,
    holder: list[Any],
    index: int,
    distance: float,
    start: bool | None,
    time: bool | None,
    interrupt: list[float],
    at: int,
    flag: list[Any] | None,
    flag_at: int,
) -> None:
    """Describes that an interrupt comes at a distance (mm) or time (s) before the end of a way, or behind its start."""
    holder[index] = _trigger(distance, start, time, 0.0, 0.0, None, interrupt[at], flag, flag_at)


_TRIGGERS = r"triggdata Trigg_1 " + " ".join(rf"\triggdata T{number}" for number in range(2, 9))
_ENDS = rf"speeddata Speed, {_TRIGGERS}, zonedata Zone, pers tooldata Tool \pers wobjdata WObj"
_LACKING = "Conc ID T Inpos Corr TLoad"


@dataclass(frozen=True, slots=True)
class _Ends:
    """Last arguments of a move with triggers."""

    speed: list[float]
    triggers: list[Trigger]
    zone: list[Any]
    wobj: list[Any] | None


def _ends(task: RapidTask, speed: list[float], *more: Any) -> _Ends:  # noqa: ANN401 as `_ENDS`
    triggers, (zone, *rest) = more[:8], more[8:]
    if triggers[0] is None:
        raise RapidFault("ERR_ARGVALERR", "a trigger is not described yet: use TriggIO, TriggEquip or TriggInt first")
    speed, zone, wobj = move_ends(task, speed, None, None, zone, None, *rest)
    return _Ends(speed, [one for one in triggers if one is not None], zone, wobj)


@instruction("TriggL", f"robtarget ToPoint, {_ENDS}", lacking=_LACKING)
def _trigg_l(task: RapidTask, target: list[Any], *more: Any) -> None:  # noqa: ANN401 as `_ENDS`
    """Moves along a line, and does what up to eight triggers describe at their places."""
    ends = _ends(task, *more)
    line(task, target, ends.speed, ends.triggers, ends.zone, ends.wobj)


@instruction("TriggJ", f"robtarget ToPoint, {_ENDS}", lacking=_LACKING)
def _trigg_j(task: RapidTask, target: list[Any], *more: Any) -> None:  # noqa: ANN401 as `_ENDS`
    """Moves all joints evenly, and does what triggers describe, their distances along the tool's way."""
    ends = _ends(task, *more)
    joints(task, target, ends.speed, ends.triggers, ends.zone, ends.wobj)


@instruction("TriggC", f"robtarget CirPoint, robtarget ToPoint, {_ENDS}", lacking=_LACKING)
def _trigg_c(task: RapidTask, via: list[Any], target: list[Any], *more: Any) -> None:  # noqa: ANN401 as `_ENDS`
    """Moves along an arc, and does what triggers describe, their distances along it."""
    ends = _ends(task, *more)
    arc(task, via, target, ends.speed, ends.triggers, ends.zone, ends.wobj)
