"""States of robots, signals, motions and the clock in a snapshot: to messages."""

from __future__ import annotations

from collections.abc import Iterable

from virtualrobot.v1 import geometry_pb2, kernel_pb2, motion_pb2, robot_pb2
from virtualrobot_sdk.poses import quaternion

from virtualrobot_kernel.messages.codecs import EnumTable
from virtualrobot_kernel.messages.table import Table
from virtualrobot_kernel.messages.values import pose_message, vector_message
from virtualrobot_kernel.motion.running_motion import Phase
from virtualrobot_kernel.motion.step_events import StepEvent, StepEventKind
from virtualrobot_kernel.physics.exerted import Exerted
from virtualrobot_kernel.planning.robots import tcp_frame
from virtualrobot_kernel.world.actuators import actuator_positions
from virtualrobot_kernel.world.clock import Clock, Mode, Recorded
from virtualrobot_kernel.world.state import Deviation, DeviationKind, EndCause, Motion, Search, Selection, Snapshot
from virtualrobot_kernel.world.structure import Kind, Node
from virtualrobot_kernel.world.widths import width_of

CAUSES = EnumTable(EndCause, motion_pb2.EndCause)
DEVIATIONS = EnumTable(DeviationKind, motion_pb2.DeviationKind)
PHASES = EnumTable(Phase, motion_pb2.MotionPhase)
STEP_EVENTS = EnumTable(StepEventKind, motion_pb2.ProgramStepEventKind)
MODES = EnumTable(Mode, kernel_pb2.ClockMode)
CLOCK = Table(Clock, kernel_pb2.Clock, mode=MODES, recorded=Table(Recorded, kernel_pb2.Recorded))


def robot_states(snapshot: Snapshot, nodes: Iterable[Node], exerted: Exerted) -> list[robot_pb2.RobotState]:
    """Return the states of some robots, with what their motors exerted."""
    return [_robot_state(snapshot, node, exerted) for node in nodes]


def _robot_state(snapshot: Snapshot, node: Node, exerted: Exerted) -> robot_pb2.RobotState:
    structure, state = snapshot.structure, snapshot.state
    robot = structure.robots[node.uid]
    selection = state.selections.get(node.uid, Selection())
    frame = tcp_frame(snapshot, node)
    x, y, z, w = quaternion(frame[:3, :3])
    commanded = state.commanded.get(node.uid) or state.motored.get(node.uid)
    tools = structure.tools_of(node.uid)
    widths = ((tool.name, width_of(structure, tool, state.q)) for tool in tools)
    return robot_pb2.RobotState(
        name=node.name,
        positions=state.q[robot.q_slice].tolist(),
        velocities=state.v[robot.v_slice].tolist(),
        efforts=exerted.of(snapshot, node.uid) if node.uid in state.motored else (),
        commanded_positions=commanded.q.tolist() if commanded else (),
        commanded_velocities=commanded.v.tolist() if commanded else (),
        tool=structure.nodes[selection.tool].name if selection.tool else "",
        tool_center_point=selection.tool_center_point,
        tool_states={tool.name: state.tool_states.get(tool.uid, "") for tool in tools},
        tool_widths={name: width for name, width in widths if width is not None},
        speed_factor=state.speed_factors.get(node.uid, 1.0),
        tcp_speed_limit=state.tcp_speed_limits.get(node.uid, 0.0),
        actuator_positions=actuator_positions(structure, node, state.q),
        motion_ids=[motion.id for motion in state.motions if node.uid in motion.robots],
        world_t_tcp=geometry_pb2.Pose(
            position=vector_message(frame[:3, 3].tolist()), orientation=geometry_pb2.Quaternion(x=x, y=y, z=z, w=w)
        ),
    )


def robots_named(snapshot: Snapshot, names: Iterable[str]) -> list[Node]:
    """Return the robots of these names, or all; raise UnknownNameError."""
    structure = snapshot.structure
    chosen = [structure.node(name, Kind.ROBOT) for name in names]
    return chosen or [structure.nodes[uid] for uid in structure.robots]


def motion_message(snapshot: Snapshot, motion: Motion) -> motion_pb2.Motion:
    """Return a motion as a message."""
    nodes = snapshot.structure.nodes
    return motion_pb2.Motion(
        id=motion.id,
        robots=[nodes[uid].name for uid in motion.robots if uid in nodes],
        phase=PHASES.write(motion.phase),
        progress=motion.running.progress,
        planned_duration_seconds=motion.running.duration,
        start_time_seconds=motion.start_tick * snapshot.tick_seconds,
        end_reason=motion.cancellation.reason if motion.cancellation else "",
        end_cause=CAUSES.write(motion.cancellation.cause) if motion.cancellation else None,
        # After the last step it is still at that one.
        step=min(motion.running.steps_done, max(0, motion.step_count - 1)),
        step_count=motion.step_count,
        step_path=motion.step_path,
        search=_search_message(snapshot, motion.search) if motion.search else None,
        deviations=[_deviation_message(snapshot, one) for one in motion.deviations],
    )


def add_step_events(
    response: motion_pb2.WatchMotionStepsResponse, snapshot: Snapshot, events: Iterable[StepEvent]
) -> None:
    """Add what has become of steps with the tick of a snapshot."""
    for event in events:
        response.events.add(
            kind=STEP_EVENTS.write(event.kind),
            step=event.step,
            step_path=event.path,
            tick=snapshot.state.tick,
            simulation_time_seconds=snapshot.simulation_time,
        )


def _deviation_message(snapshot: Snapshot, deviation: Deviation) -> motion_pb2.JointDeviation:
    uid, joint = deviation.joint
    node = snapshot.structure.nodes.get(uid)
    return motion_pb2.JointDeviation(
        robot=node.name if node else "",
        joint=joint,
        kind=DEVIATIONS.write(deviation.kind),
        value=deviation.value,
        tolerance=deviation.tolerance,
    )


def _search_message(snapshot: Snapshot, search: Search) -> motion_pb2.SearchResult:
    return motion_pb2.SearchResult(
        found=search.found,
        joint_positions=search.joint_positions,
        world_t_tcp=pose_message(search.world_t_tcp),
        time_seconds=search.tick * snapshot.tick_seconds,
    )
