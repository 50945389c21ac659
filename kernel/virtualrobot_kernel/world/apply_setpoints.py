"""Commands about motions that follow setpoints: start one, give it a setpoint, close its stream."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion import setpoint_motion, tool_setpoints
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.online import Coupling
from virtualrobot_kernel.motion.setpoint_motion import SetpointMotion
from virtualrobot_kernel.world.actuators import actuators_of
from virtualrobot_kernel.world.apply_motions import replaced, running_motion
from virtualrobot_kernel.world.change import Change, Forward, joint_limits, joint_places, refuse_while_moving
from virtualrobot_kernel.world.commands import EndSetpoints, SetSetpoint, StartSetpointMotion
from virtualrobot_kernel.world.crafts import refuse_base
from virtualrobot_kernel.world.measured import commanded
from virtualrobot_kernel.world.motored import refuse_unmotored
from virtualrobot_kernel.world.preconditions import check
from virtualrobot_kernel.world.state import Motion
from virtualrobot_kernel.world.structure import Node, Structure
from virtualrobot_kernel.world.tcp import refuse_limited


def start_setpoint_motion(change: Change, command: StartSetpointMotion, forward: Forward) -> Change:
    """Start a motion that follows setpoints; refused when the joints move, or have limits that cannot be kept."""
    structure, state = change.structure, change.state
    node = structure.robot(command.robot)[0]
    check(command.preconditions, structure, state)
    names = command.joint_names
    if not names or len(set(names)) != len(names):
        raise KernelError(f"setpoints of {node.name!r} need joints, each once, not {list(names)}", robot=node.name)
    limits, couplings = _limits(structure, node, names)
    joints = tuple((node.uid, name) for name in names)
    refuse_base(structure, joints)
    refuse_unmotored(structure, state, joints)
    refuse_while_moving(change, node, set(joints))
    if command.lead is None:  # which is made for the limit
        refuse_limited(structure, state, [node.uid])
    q_index, v_index, rated = joint_places(structure, joints)
    here = commanded(structure, state)[0][q_index]
    if command.lead is None:
        running = setpoint_motion.start(command.mode, limits, here, command.timeout, couplings)
    else:
        running = tool_setpoints.start(command.mode, command.lead, limits, here, command.timeout, couplings)
    id = f"motion-{state.motion_count + 1}"
    motion = Motion(
        id=id,
        robots=structure.with_holders([node.uid]),
        joints=joints,
        q_index=q_index,
        v_index=v_index,
        rated=rated,
        running=running,
        start_tick=state.tick,
    )
    state = replace(state, motions=(*state.motions, motion), motion_count=state.motion_count + 1)
    return replace(change, state=state, created=(*change.created, id))


def set_setpoint(change: Change, command: SetSetpoint, forward: Forward) -> Change:
    """Give a motion its newest setpoint; refused when it is not possible, and for motions that have ended."""
    motion = running_motion(change.state, command.id)
    return replaced(change, replace(motion, running=_setpoint_motion(motion).set(command.values)))


def end_setpoints(change: Change, command: EndSetpoints, forward: Forward) -> Change:
    """Close a motion's stream of setpoints: it ends at its newest setpoint, or at standstill."""
    motion = running_motion(change.state, command.id)
    return replaced(change, replace(motion, running=_setpoint_motion(motion).close()))


def _setpoint_motion(motion: Motion) -> SetpointMotion:
    if not isinstance(motion.running, SetpointMotion):
        raise KernelError(
            f"the motion {motion.id!r} was planned and follows no setpoints",
            reason=Reason.WRONG_STATE,
            motion=motion.id,
        )
    return motion.running


def _limits(structure: Structure, node: Node, names: tuple[str, ...]) -> tuple[JointLimits, list[Coupling]]:
    """Return the limits of joints, and of the actuators that move one of them, and those of the other actuators."""
    limits, couplings = joint_limits(structure, node, names), []
    least, most = limits.lower.copy(), limits.upper.copy()
    for actuator in actuators_of(node):
        terms = tuple((names.index(joint), ratio) for joint, ratio in actuator.terms if joint in names)
        lower, upper = actuator.lower - actuator.offset, actuator.upper - actuator.offset
        if not terms or not np.isfinite([lower, upper]).any():
            continue
        if len(terms) < len(actuator.terms):
            joints = " and ".join(repr(joint) for joint, _ in actuator.terms)
            raise KernelError(
                f"the actuator {actuator.name!r} of {node.name!r} moves {joints} together and has limits; give "
                "setpoints for all of them",
                robot=node.name,
                actuator=actuator.name,
            )
        if len(terms) == 1:
            column, ratio = terms[0]
            ends = sorted((lower / ratio, upper / ratio))
            least[column], most[column] = max(least[column], ends[0]), min(most[column], ends[1])
        else:
            couplings.append(Coupling(actuator.name, terms, lower, upper))
    return replace(limits, lower=least, upper=most), couplings
