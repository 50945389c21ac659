"""Externally Guided Motion: a computer says, by UDP, where the joints or the tool centre point go."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from virtualrobot_apps.languages.core.motion import POLL_SECONDS, STOP_SECONDS
from virtualrobot_apps.languages.rapid.faults import RapidFault, RapidStopped
from virtualrobot_apps.languages.rapid.frames import matrix_of
from virtualrobot_apps.languages.rapid.guided import (
    JOINT_RANGE,
    POSE_RANGES,
    SAMPLE,
    EgmProcess,
    GuidedMotion,
    Terms,
)
from virtualrobot_apps.languages.rapid.placed import TOOL
from virtualrobot_apps.languages.rapid.predefined import NUMBERS
from virtualrobot_apps.languages.rapid.table import function, instruction

if TYPE_CHECKING:
    from virtualrobot.geometry import Matrix

    from virtualrobot_apps.emulators.body import Twin
    from virtualrobot_apps.languages.rapid.task import RapidTask

_ID = "var egmident EGMid"
_JOINTS, _AXES = [f"J{number}" for number in range(1, 7)], ["X", "Y", "Z", "Rx", "Ry", "Rz"]
_TOOL = rf"{_ID} \pers tooldata Tool \pers wobjdata WObj"
_LIMITS = r"\num LpFilter \num SampleRate \num MaxPosDeviation \num MaxSpeedDeviation"
_TIMES = r"\num CondTime \num RampInTime \num RampOutTime \num PosCorrGain"
_STREAMS = "StreamStart TLoad DataToSensor DataFromSensor"
_STOPS = {"stop", "hold"}
"""Flags of a task that have its robot stand."""


def _ranges(names: Sequence[str]) -> str:
    return " ".join(rf"\egm_minmax {name}" for name in names)


def _switches(names: Sequence[str]) -> str:
    return " ".join(rf"\switch {name}" for name in names)


def _process(holder: list[EgmProcess | None], index: int) -> EgmProcess:
    """Return the process of an egmident."""
    found = holder[index]
    if found is None:
        raise RapidFault("ERR_ARGVALERR", "this egmident has no process yet; EGMGetId gives it one")
    return found


@instruction("EGMGetId", _ID)
def _get_id(task: RapidTask, holder: list[EgmProcess | None], index: int) -> None:
    """Gives an egmident a process of its own, which is not connected."""
    holder[index] = EgmProcess()


@instruction("EGMReset", _ID)
def _reset(task: RapidTask, holder: list[EgmProcess | None], index: int) -> None:
    """Ends the connection of a process, and its motion; harmless where it has none."""
    if holder[index] is not None:
        if _process(holder, index).runs:
            _process(holder, index).ends = 0.0
        holder[index] = EgmProcess()


@function("EGMGetState", _ID, "egmstate")
def _get_state(task: RapidTask, holder: list[EgmProcess | None], index: int) -> float:
    """State of a process: EGM_STATE_DISCONNECTED, EGM_STATE_CONNECTED or EGM_STATE_RUNNING."""
    found = holder[index]
    state = "DISCONNECTED" if found is None or found.to is None else "RUNNING" if found.runs else "CONNECTED"
    return float(NUMBERS[f"EGM_STATE_{state}"])


@instruction(
    "EGMSetupUC",
    rf"mecunit MecUnit, {_ID}, string ExtConfigName, string UCDevice \switch Joint | switch Pose \num CommTimeout",
    lacking="PathCorr APTR LATR",
)
def _setup(
    task: RapidTask,
    unit: str,
    holder: list[EgmProcess | None],
    index: int,
    configuration: str,
    device: str,
    joints: bool | None,
    pose: bool | None,
    silence: float | None,
) -> None:
    """Connects a process to a UDP device, for the task's robot, whatever unit and configuration are named."""
    world = task.own_world
    if task.passing is not None or (world is not None and not world.can_be_guided):
        raise RapidStopped("EGM needs the computer that guides, which is not there where a program is only tried")
    process = _process(holder, index)
    if not joints and not pose:
        raise RapidFault("ERR_ARGVALERR", r"EGMSetupUC needs \Joint or \Pose")
    to = task.egm.get(device.removesuffix(":").lower())
    if to is None:
        known = f"; there are: {', '.join(sorted(task.egm))}" if task.egm else ""
        raise RapidStopped(
            f"there is no UDP device {device!r}: name it by --egm {device.removesuffix(':')}=HOST:PORT{known}"
        )
    process.to, process.poses, process.terms = to, bool(pose), None
    process.silence = 1.0 if silence is None else silence
    if not process.silence > 0.0:
        raise RapidFault("ERR_ARGVALERR", f"CommTimeout is a time above 0 s, not {silence:g}")


def _agree(
    task: RapidTask,
    holder: list[EgmProcess | None],
    index: int,
    *given: Any,  # noqa: ANN401 as `_TOOL`, then frames, then ranges, then `_LIMITS`
    poses: bool,
) -> None:
    """Keep what EGMActJoint or EGMActPose says."""
    process = _process(holder, index)
    tool, tool_at, wobj, wobj_at, *frames, low_pass, sample, farthest, fastest = given
    frames, ranges = frames[:-6], frames[-6:]
    if process.to is None or process.poses is not poses:
        raise RapidFault(
            "ERR_ARGVALERR", rf"EGMSetupUC has not connected this process with \{'Pose' if poses else 'Joint'}"
        )
    milliseconds = 4.0 if sample is None else sample
    if milliseconds < 4.0 or milliseconds % 4.0:
        raise RapidFault("ERR_ARGVALERR", f"SampleRate is 4, 8, 12 ... ms, not {milliseconds:g}")
    for name, value in (("MaxPosDeviation", farthest), ("MaxSpeedDeviation", fastest)):
        if value is not None and not value > 0.0:
            raise RapidFault("ERR_ARGVALERR", f"{name} is above 0, not {value:g}")
    task.finish()
    task.world.use_tool(TOOL if tool is None else tool[tool_at])
    wobj_frame = task.world.frame(None if wobj is None else wobj[wobj_at])
    correction, sensor = np.eye(4), wobj_frame
    if poses:
        correction, sensor = (_frame(wobj_frame, *frames[at : at + 2]) for at in (0, 2))
    usual = POSE_RANGES if poses else (JOINT_RANGE,) * 6
    process.terms = Terms(
        [one if value is None else (value[0], value[1]) for value, one in zip(ranges, usual, strict=True)],
        sensor,
        correction,
        SAMPLE * milliseconds / 4.0,
        low_pass or 0.0,
        math.radians(1000.0 if farthest is None else farthest),
        math.radians(1.0 if fastest is None else fastest),
    )


def _frame(base_t_wobj: Matrix, pose: list[Any], kind: float) -> Matrix:
    """Return a frame that is given in another one, in the base's, 4x4."""
    if kind == NUMBERS["EGM_FRAME_WOBJ"]:
        return base_t_wobj @ matrix_of(pose)
    if kind in (NUMBERS["EGM_FRAME_BASE"], NUMBERS["EGM_FRAME_WORLD"]):
        return matrix_of(pose)
    raise RapidFault("ERR_ARGVALERR", "a frame of EGM is in that of the base, the world or the work object here")


@instruction("EGMActJoint", rf"{_TOOL} {_ranges(_JOINTS)} {_LIMITS}", lacking=f"{_STREAMS} J7")
def _act_joint(task: RapidTask, *given: Any) -> None:  # noqa: ANN401 see _agree
    """Says how joints are guided: by which differences (degrees) they have converged, how far and fast they may go."""
    _agree(task, *given, poses=False)


@instruction(
    "EGMActPose",
    rf"{_TOOL}, pose CorrFrame, egmframetype CorrFrType, pose SensorFrame, egmframetype SensorFrType "
    rf"{_ranges(_AXES)} {_LIMITS}",
    lacking=_STREAMS,
)
def _act_pose(task: RapidTask, *given: Any) -> None:  # noqa: ANN401 see _agree
    """Says how a pose is guided, in which frames, and by which differences (mm, degrees) it has converged."""
    _agree(task, *given, poses=True)


@instruction("EGMRunJoint", rf"{_ID}, egmstopmode Mode {_switches(_JOINTS)} {_TIMES}", lacking="NoWaitCond J7 Offset")
def _run_joint(task: RapidTask, holder: list[EgmProcess | None], index: int, mode: float, *given: Any) -> None:  # noqa: ANN401
    """Lets a computer guide joints until they have been where it asks for a time, 1 s, or EGMStop ends it."""
    _run(task, _process(holder, index), mode, given[:6], *given[6:], poses=False)


@instruction("EGMRunPose", rf"{_ID}, egmstopmode Mode {_switches(_AXES)} {_TIMES}", lacking="NoWaitCond Offset")
def _run_pose(task: RapidTask, holder: list[EgmProcess | None], index: int, mode: float, *given: Any) -> None:  # noqa: ANN401
    """Lets a computer guide the tool centre point as EGMRunJoint does joints; axes that are left out stay."""
    _run(task, _process(holder, index), mode, given[:6], *given[6:], poses=True)


def _run(
    task: RapidTask,
    process: EgmProcess,
    mode: float,
    switches: Sequence[bool | None],
    condition: float | None,
    ramp_in: float | None,
    ramp_out: float | None,
    gain: float | None,
    *,
    poses: bool,
) -> None:
    """Be guided, in the thread of the program, which serves its interrupts between two cycles."""
    axes = [bool(one) for one in switches]
    if process.to is None or process.terms is None or process.poses is not poses:
        raise RapidFault(
            "ERR_ARGVALERR", f"EGMAct{'Pose' if poses else 'Joint'} has not said yet how this process guides"
        )
    if not any(axes) or (poses and len(set(axes[3:])) > 1):
        raise RapidFault("ERR_ARGVALERR", "EGM guides an axis or several, and of Rx, Ry and Rz all or none here")
    if gain is not None and not gain > 0.0:
        raise RapidFault("ERR_ARGVALERR", f"PosCorrGain is above 0 here, not {gain:g}: speeds alone are no guide yet")
    if gain is not None and gain != 1.0:
        task.world.note(f"{task.place()}: PosCorrGain counts as 1, and is {gain:g}")
    if task.world.group is not None:
        raise RapidStopped("EGM can't be used between SyncMoveOn and SyncMoveOff")
    body = task.world.follower()
    try:
        motion = GuidedMotion(
            body,
            process.to,
            process.terms,
            axes,
            poses=poses,
            ramp=1.0 if ramp_in is None else ramp_in,
            speeds=task.world.velocities,
        )
    except OSError as error:
        body.close()
        raise RapidStopped(f"{process.to[0]}:{process.to[1]} can't be spoken to: {error}") from error
    longest, back = 1.0 if condition is None else condition, 1.0 if ramp_out is None else ramp_out
    process.runs, process.ends = True, None
    try:
        _follow(
            task,
            motion,
            body,
            lambda: process.ends is not None or (motion.convergence_met and motion.met >= longest),
            process.silence,
        )
        if process.ends is None:
            process.ends = _end(mode, back)
        if process.ends:
            motion.go_back(process.ends)
            _follow(task, motion, body, lambda: motion.back, math.inf)
    finally:
        process.runs = False
        motion.close()
        _come_to_rest(task, body)


def _end(mode: float, seconds: float) -> float:
    """Return how a motion ends: back in so many seconds, or 0 at once."""
    return max(seconds, SAMPLE) if mode == NUMBERS["EGM_STOP_RAMP_DOWN"] else 0.0


def _follow(task: RapidTask, motion: GuidedMotion, body: Twin, over: Callable[[], bool], silence: float) -> None:
    """Do cycles until it is over; raises what the computer does wrong."""
    due = time.monotonic()
    while True:
        motion.cycle()
        if motion.refused:
            raise RapidStopped(f"EGM stops: {motion.refused}")
        if motion.silence > silence:
            raise RapidFault("ERR_UDPUC_COMM", f"the computer has not answered for {silence:g} s")
        if over():
            return
        due = max(due + motion.period, time.monotonic() - motion.period)
        task.rest(max(0.0, due - time.monotonic()))
        if task.flags:
            stands = not _STOPS.isdisjoint(task.flags)
            if stands:
                body.halt()
                _come_to_rest(task, body)
            task.poll()
            if stands:
                motion.begin_here()


def _come_to_rest(task: RapidTask, body: Twin) -> None:
    """Wait until a robot stands that follows nothing."""
    end = time.monotonic() + STOP_SECONDS
    while not body.rests and time.monotonic() < end:
        task.rest(POLL_SECONDS)


@instruction("EGMStop", rf"{_ID}, egmstopmode Mode \num RampOutTime")
def _stop(task: RapidTask, holder: list[EgmProcess | None], index: int, mode: float, ramp_out: float | None) -> None:
    """Ends a motion that is guided, from a trap: where it is, or (EGM_STOP_RAMP_DOWN) back where it began."""
    process = _process(holder, index)
    if process.runs:
        process.ends = _end(mode, 1.0 if ramp_out is None else ramp_out)
