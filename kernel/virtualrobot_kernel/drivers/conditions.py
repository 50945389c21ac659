"""Conditions of EXECUTE: what has to be so before a robot does what its twin does. Pure."""

from __future__ import annotations

from collections.abc import Iterable

from virtualrobot_sdk.drivers import Mode as ControllerMode
from virtualrobot_sdk.drivers.shared import Report, State

from virtualrobot_kernel.drivers.admission import is_guarded
from virtualrobot_kernel.drivers.link import STOPPED, Link
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.state import Snapshot


def check_conditions(
    now: Snapshot,
    clock: Clock,
    robot: str,
    link: Link,
    report: Report,
    played: Iterable[Link],
    stopped: str,
    is_leased: bool,
) -> None:
    """Raise KernelError (WRONG_STATE) that names the first condition that does not hold.

    `played` are the links of other robots that are played; `stopped` is why the cell is, empty where it is not.
    """
    uid = link.twin.uid
    if stopped:
        raise refused(robot, "cell", f"the cell is stopped ({stopped}); release it first")
    if not is_leased:
        raise refused(robot, "lease", "nobody has leased it; lease it first")
    if (other := next((one for one in played if one.asked.lead != link.asked.lead), None)) is not None:
        raise refused(
            robot,
            "lead",
            f"its lead is {link.asked.lead:g} s, and that of {name_of(now, other)!r} {other.asked.lead:g} s, so they "
            "would not be at the same tick together; connect both with one lead",
        )
    if not is_guarded(now, uid):
        raise refused(robot, "guard", "the collision guard is off for it; set its collision mode to GUARD first")
    if clock.mode is not Mode.REALTIME or clock.speed_factor != 1.0:
        raise refused(robot, "clock", "time must follow the wall clock at factor 1; set the clock first")
    motion = next((motion for motion in now.state.motions if uid in motion.robots), None)
    if motion is not None:
        raise refused(robot, "motion", f"it moves in {motion.id!r}; wait for its end or cancel it")
    if report.safety in STOPPED:
        raise refused(robot, "controller", f"the controller has stopped it: {report.safety.value}")
    if report.mode not in (ControllerMode.READY, ControllerMode.RUNNING):
        raise refused(robot, "controller", f"the controller is not ready: it is {report.mode.value}")
    if outside := link.twin.outside_told(report.q):
        raise refused(robot, "limits", f"outside their limits stand {outside}")


def refused(robot: str, aspect: str, why: str) -> KernelError:
    """Return the error of what a robot's driver is not ready for."""
    return KernelError(f"the robot {robot!r}: {why}", reason=Reason.WRONG_STATE, robot=robot, aspect=aspect)


def halted_error(robot: str, link: Link) -> KernelError:
    """Return the error of an order to a robot that follows no more though nobody chose so: its twin would go alone."""
    alone = "or choose SIMULATED to move its twin alone"
    words = link.words
    if link.state is not State.ERROR:
        why = words.text or "its driver was connected again after a fault"
        said = f"it does not follow: {why}; let it follow again with mode EXECUTE, {alone}"
        return refused(robot, "mode", said)
    remedy = (
        "clear that with ResetDriver, then choose its mode"
        if words.clears
        else "see to it at the controller, connect its driver again, then choose its mode"
    )
    return KernelError(
        f"the robot {robot!r}: its driver is in ERROR: {words.text}; {remedy}, {alone}",
        reason=Reason.DRIVER_FAULT,
        robot=robot,
        code=words.code,
        clears=words.clears,
    )


def name_of(now: Snapshot, link: Link) -> str:
    """Return the present name of a link's robot."""
    node = now.structure.nodes.get(link.twin.uid)
    return node.name if node else "a robot that is gone"
