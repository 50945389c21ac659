// What a person leads by setpoints, and how fast: a craft, the tool of an arm, or joints.
import { signal } from "@preact/signals";
import { JogFrame, SetpointMode } from "../generated/virtualrobot/v1/motion_pb";
import { JointType } from "../generated/virtualrobot/v1/nodes_pb";
import { jogSpeed } from "./jog";
import type { Led, Parts } from "./setpoints";
import { robots, states } from "./world";

/** Greatest speeds of jogs: m/s and rad/s, of tools and of joints. */
export const MOVING = 0.25, TURNING = 0.8;

/** Greatest speed (m/s) and turning rate (rad/s) of crafts, as somebody has set them. */
export const speedLimit = signal(0.3);
export const turnLimit = signal(0.6);

/** By how much a tool that is led may be faster than its stream's greatest speed, as the kernel has it. */
const BEYOND = 0.02;

export const FRAMES: Readonly<Record<string, JogFrame>> = { base: JogFrame.BASE, tool: JogFrame.TOOL, world: JogFrame.NODE };

/** Leads a craft: parts are ahead, to the left, and turning to the left. */
export function craftOf(robot: string): Led {
  return {
    target: { robot, mode: SetpointMode.TWIST },
    setpoint: ([ahead, left, turn]) => [ahead * speedLimit.value, left * speedLimit.value, turn * turnLimit.value],
  };
}

/** Leads the tool centre point: parts are along x, y, z, then about them; `frame` has a name of FRAMES or is a node's, and `node` is one whatever its name. */
export function toolOf(robot: string, frame: string, node = ""): Led {
  const limit = states.peek().get(robot)?.tcpSpeedLimit || Infinity;
  const speed = Math.min(MOVING, limit / (1 + BEYOND));
  const where = !node && FRAMES[frame] ? { frame: FRAMES[frame] } : { frame: JogFrame.NODE, node: node || frame };
  return {
    target: { robot, mode: SetpointMode.TOOL_TWIST, ...where, maxVelocityMetersPerSecond: speed, maxRotationVelocityRadiansPerSecond: TURNING },
    setpoint: (parts) => [...within(parts.slice(0, 3), jogSpeed.value * speed), ...within(parts.slice(3), jogSpeed.value * TURNING)],
  };
}

/** Leads joints by their velocities: a part for each. */
export function jointsOf(robot: string, names: readonly string[]): Led {
  const joints = new Map((robots.peek().get(robot)?.joints ?? []).map((joint) => [joint.name, joint]));
  const most = names.map((name) => {
    const { type, limits } = joints.get(name) ?? {};
    return Math.min(type === JointType.PRISMATIC ? MOVING : TURNING, limits?.velocity || Infinity);
  });
  return {
    target: { robot, mode: SetpointMode.VELOCITY, jointNames: [...names] },
    setpoint: (parts) => parts.map((part, place) => part * jogSpeed.value * most[place]),
  };
}

/** Returns parts of a speed as a vector that is no longer than it. */
function within(parts: Parts, speed: number): number[] {
  const length = Math.max(1, Math.hypot(...parts));
  return parts.map((part) => (part * speed) / length);
}
