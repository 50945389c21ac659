"""Pure application of commands: `(world, commands) -> world`, all or none."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.world import (
    apply_cell,
    apply_checkpoint,
    apply_collisions,
    apply_motions,
    apply_nodes,
    apply_records,
    apply_robots,
    apply_sensors,
    apply_setpoints,
    apply_signals,
    apply_tools,
    commands,
    crafts,
    dynamics,
    measured,
    motored,
    physics,
)
from virtualrobot_kernel.world.change import Change, Forward, frozen
from virtualrobot_kernel.world.state import State
from virtualrobot_kernel.world.structure import Structure

HANDLERS: dict[type, Callable[[Change, Any, Forward], Change]] = {
    commands.CreateNodes: apply_nodes.create_nodes,
    commands.UpdateNode: apply_nodes.update_node,
    commands.RemoveNode: apply_nodes.remove_node,
    commands.ClearWorld: apply_nodes.clear_world,
    commands.AttachNode: apply_nodes.attach_node,
    commands.PickPart: apply_robots.pick_part,
    commands.PlacePart: apply_robots.place_part,
    commands.SetJointPositions: apply_robots.set_joint_positions,
    commands.SetKinematics: apply_robots.set_kinematics,
    commands.SetCraft: crafts.set_craft,
    commands.RunSensors: apply_sensors.run_sensors,
    commands.SetRangeComponents: apply_sensors.set_range_components,
    commands.SetAllowedPairs: apply_collisions.set_allowed_pairs,
    commands.SetCollisionSettings: apply_collisions.set_collision_settings,
    commands.SetGroups: apply_robots.set_groups,
    commands.SetPostures: apply_robots.set_postures,
    commands.SelectTool: apply_robots.select_tool,
    commands.MountTool: apply_tools.mount_tool,
    commands.UnmountTool: apply_tools.unmount_tool,
    commands.SetToolState: apply_robots.set_tool_state,
    commands.CreateSignal: apply_signals.create_signal,
    commands.RemoveSignal: apply_signals.remove_signal,
    commands.SetSignal: apply_signals.set_signal,
    commands.SetSpeedFactor: apply_robots.set_speed_factor,
    commands.SetTcpSpeedLimit: apply_robots.set_tcp_speed_limit,
    commands.StartMotion: apply_motions.start_motion,
    commands.AppendMotion: apply_motions.append_motion,
    commands.GoOn: apply_motions.go_on,
    commands.StepMotion: apply_motions.step_motion,
    commands.StartSetpointMotion: apply_setpoints.start_setpoint_motion,
    commands.SetSetpoint: apply_setpoints.set_setpoint,
    commands.EndSetpoints: apply_setpoints.end_setpoints,
    commands.SetMeasuredJoints: measured.set_measured_joints,
    commands.SetDynamics: dynamics.set_dynamics,
    commands.SetJointEfforts: motored.set_joint_efforts,
    commands.SetParts: physics.set_parts,
    commands.SetContacts: physics.set_contacts,
    commands.SetPhysics: physics.set_physics,
    commands.PauseMotion: apply_motions.pause_motion,
    commands.ResumeMotion: apply_motions.resume_motion,
    commands.CancelMotion: apply_motions.cancel_motion,
    commands.StopMotions: apply_motions.stop_motions,
    commands.StopRobots: apply_motions.stop_robots,
    commands.StopCell: apply_cell.stop_cell,
    commands.ReleaseCell: apply_cell.release_cell,
    commands.PlayedTicks: apply_motions.note_played,
    commands.RestartWorld: apply_motions.restart_world,
    commands.RestoreRecords: apply_records.restore_records,
    commands.RestoreWorld: apply_checkpoint.restore_world,
}


def apply(structure: Structure, state: State, batch: Sequence[commands.Command], forward: Forward) -> Change:
    """Return the world after all commands of `batch`; raise KernelError, which names the command, when one is refused.

    The structure's revision grows by one when the batch changes the structure. Nothing that was given is written to.
    The index of the refused command, `command_index` in the error's metadata, counts each node of a CreateNodes.
    """
    change = Change(structure, state)
    first, count = 0, sum(map(_count, batch))
    for command in batch:
        try:
            if type(command) in apply_cell.MOVING:
                apply_cell.refuse_stopped(change.state)
            change = HANDLERS[type(command)](change, command, forward)
        except KernelError as error:
            place = int(error.metadata.pop(apply_nodes.PLACE, "0"))
            if count > 1:
                error.metadata["command_index"] = str(first + place)
            raise
        first += _count(command)
    for array in (change.state.q, change.state.v, change.state.parent_t_node):
        frozen(array)
    if change.structure is not structure:
        change = replace(change, structure=replace(change.structure, revision=structure.revision + 1))
    return change


def _count(command: commands.Command) -> int:
    return len(command.specs) if isinstance(command, commands.CreateNodes) else 1
