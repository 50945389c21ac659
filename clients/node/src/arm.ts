/** A robot arm: load it, move it, ask where it is. */

import type { MessageInitShape } from "@bufbuild/protobuf";
import { float64s } from "./arrays.js";
import type { PoseSchema } from "./generated/virtualrobot/v1/geometry_pb.js";
import { DisconnectPolicy, MotionPhase, MotionService } from "./generated/virtualrobot/v1/motion_pb.js";
import type { Motion, MoveSchema } from "./generated/virtualrobot/v1/motion_pb.js";
import { RobotService } from "./generated/virtualrobot/v1/robot_pb.js";
import { SceneService } from "./generated/virtualrobot/v1/scene_pb.js";
import type { Kernel } from "./kernel.js";

/** What does not change while the robot is in the world. */
export interface Arm {
  readonly name: string;
  /** The node that tools are mounted on. */
  readonly flange: string;
  /** In the order in which positions are given. */
  readonly jointNames: readonly string[];
}

/** A pose: meters, and a quaternion x, y, z, w; what is left out is zero, or not turned. */
export type Pose = MessageInitShape<typeof PoseSchema>;
export type Move = MessageInitShape<typeof MoveSchema>;

/** Loads a model file of the kernel's machine. */
export async function loadArm(kernel: Kernel, uri: string, name: string): Promise<Arm> {
  const loaded = await kernel.call(SceneService.method.importModel, { model: { uri, name } });
  const root = given(loaded.created[0], "created node");
  const robot = await kernel.call(RobotService.method.getRobot, { name: root.name });
  return { name: root.name, flange: robot.flange, jointNames: robot.joints.map((joint) => joint.name) };
}

/** Point to point, to joint positions in radians by name; joints that are not named stay where they are. */
export function toJoints(arm: Pick<Arm, "name">, jointPositions: Record<string, number>): Move {
  return {
    robot: arm.name,
    move: { case: "pointToPoint", value: { goal: { case: "joints", value: { jointPositions } } } },
  };
}

/** Point to point, to a pose of the tool centre point in the world. */
export function toPose(arm: Pick<Arm, "name">, referenceTTcp: Pose): Move {
  return {
    robot: arm.name,
    move: { case: "pointToPoint", value: { goal: { case: "pose", value: { referenceTTcp } } } },
  };
}

/** In a straight line, to a pose of the tool centre point in the frame of the node `reference`. */
export function alongLine(arm: Pick<Arm, "name">, referenceTTcp: Pose, reference = "world"): Move {
  return { robot: arm.name, move: { case: "linear", value: { goal: { referenceTTcp, reference } } } };
}

/** Starts moves of one robot, or of several that start and end together. */
export async function start(
  kernel: Kernel,
  moves: readonly Move[],
  onDisconnect = DisconnectPolicy.UNSPECIFIED,
): Promise<Motion> {
  const started = await kernel.call(MotionService.method.startMotion, { spec: { moves: [...moves] }, onDisconnect });
  return given(started.motion, "motion");
}

/** Waits for the end of a motion; throws when it is another one than success. */
export async function ended(kernel: Kernel, motion: Motion): Promise<Motion> {
  for await (const progress of kernel.watch(MotionService.method.watchMotion, { id: motion.id })) {
    motion = given(progress.motion, "motion");
  }
  if (motion.phase !== MotionPhase.SUCCEEDED) {
    throw new Error(`motion ${motion.id} is ${MotionPhase[motion.phase]}: ${motion.endReason}`);
  }
  return motion;
}

/**
 * Moves one robot, or several that start and end together, and waits for the end. The watch is not only for waiting: by
 * default a motion belongs to its watch, and one that nobody has watched for a second is cancelled.
 */
export async function move(kernel: Kernel, ...moves: readonly Move[]): Promise<Motion> {
  return ended(kernel, await start(kernel, moves));
}

/** Returns where the joints are now, in radians, in the order of `jointNames`. */
export async function positions(kernel: Kernel, arm: Arm): Promise<readonly number[]> {
  const { robots } = await kernel.call(RobotService.method.getRobotStates, {
    names: [arm.name],
    readMask: { paths: ["positions"] },
  });
  return given(robots[0], "robot").positions;
}

/** Returns where a node is in the world: x, y, z in meters, then the quaternion x, y, z, w. */
export async function worldTNode(kernel: Kernel, name: string): Promise<Float64Array> {
  const scene = await kernel.call(SceneService.method.getScene, { names: [name] });
  return float64s(given(scene.worldTNode, "poses"));
}

/** The contract's messages may leave out any field; these are always sent. */
export function given<T>(value: T | undefined, what: string): T {
  if (value === undefined) throw new Error(`the kernel sent no ${what}`);
  return value;
}
