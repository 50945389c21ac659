// What people ask of the kernel, besides jogs and STOP.
import type { MessageInitShape } from "@bufbuild/protobuf";
import type { PoseSchema } from "../generated/virtualrobot/v1/geometry_pb";
import { BusyPolicy, DisconnectPolicy, MotionPhase, type MotionSpecSchema } from "../generated/virtualrobot/v1/motion_pb";
import type { Node } from "../generated/virtualrobot/v1/nodes_pb";
import type { CommandSchema } from "../generated/virtualrobot/v1/scene_pb";
import type { SignalValue } from "../generated/virtualrobot/v1/signal_pb";
import { attempt, say } from "./messages";
import { start } from "./own_motions";
import { history, motions, scenes } from "./services";
import { forPeople, wordsOf } from "./words";
import * as world from "./world";

export type Commands = MessageInitShape<typeof CommandSchema>["command"];

/** The last change that this page has asked for: each begins when the one before has been answered. */
let last: Promise<unknown> = Promise.resolve();

/** Changes the world by commands, all of them or none, after all earlier changes; returns whether they were applied. */
export function apply(...commands: Commands[]): Promise<boolean> {
  return inTurn(() => send(...commands));
}

/** Changes one field of a node, named as the contract names it: `edit` changes the node as the kernel has it after all earlier changes. */
export function change(name: string, field: string, edit: (node: Node) => void): Promise<boolean> {
  return inTurn(async () => {
    const [node] = (await attempt(scenes.getScene({ names: [name] })))?.nodes ?? [];
    if (!node) return false;
    edit(node);
    return send({ case: "updateNode", value: { name, node, updateMask: { paths: [field] } } });
  });
}

function inTurn(make: () => Promise<boolean>): Promise<boolean> {
  const done = last.then(make);
  last = done.catch(() => {});
  return done;
}

async function send(...commands: Commands[]): Promise<boolean> {
  return (await attempt(scenes.apply({ commands: commands.map((command) => ({ command })) }))) !== undefined;
}

export function rename(name: string, to: string): Promise<boolean> {
  return apply({ case: "updateNode", value: { name, node: { name: to }, updateMask: { paths: ["name"] } } });
}

export function setHidden(name: string, hidden: boolean): Promise<boolean> {
  return apply({ case: "updateNode", value: { name, node: { hidden }, updateMask: { paths: ["hidden"] } } });
}

/** Keeps a node as it is, or lets go of it. */
export function setLocked(name: string, locked: boolean): Promise<boolean> {
  return apply({ case: "updateNode", value: { name, node: { locked }, updateMask: { paths: ["locked"] } } });
}

/** Changes what people say of a node. */
export function describe(name: string, said: { description: string } | { tags: string[] } | { icon: string }): Promise<boolean> {
  return apply({ case: "updateNode", value: { name, node: said, updateMask: { paths: Object.keys(said) } } });
}

export function place(name: string, parent_t_node: MessageInitShape<typeof PoseSchema>): Promise<boolean> {
  const value = { name, node: { parentTNode: parent_t_node }, updateMask: { paths: ["parent_t_node"] } };
  return apply({ case: "updateNode", value });
}

export function attach(name: string, parent: string): Promise<boolean> {
  return apply({ case: "attachNode", value: { name, parent } });
}

export function remove(name: string): Promise<boolean> {
  return apply({ case: "removeNode", value: { name } });
}

/** Slows all robots, or one besides. */
export function setSpeedFactor(factor: number, robot = ""): Promise<boolean> {
  return apply({ case: "setSpeedFactor", value: { factor, robot } });
}

/** Limits the speed of a robot's tool centre point (m/s); 0 is no limit. */
export function setTcpSpeedLimit(limit: number, robot: string): Promise<boolean> {
  return apply({ case: "setTcpSpeedLimit", value: { robot, metersPerSecond: limit } });
}

export function setSignal(name: string, kind: SignalValue["kind"]): Promise<boolean> {
  return apply({ case: "setSignal", value: { name, value: { kind } } });
}

export function createSignal(name: string, kind: SignalValue["kind"]): Promise<boolean> {
  return apply({ case: "createSignal", value: { signal: { name, value: { kind } } } });
}

export function removeSignal(name: string): Promise<boolean> {
  return apply({ case: "removeSignal", value: { name } });
}

/** Makes a target where the robot's tool centre point is now, with its posture; returns its name, "" when it is refused. */
export async function teach(robot: string): Promise<string> {
  const state = world.states.value.get(robot), about = world.robots.value.get(robot);
  if (!state || !about) return "";
  const single = about.joints.flatMap(({ coordinateNames }) => coordinateNames);
  const jointPositions = Object.fromEntries(single.map((name, place) => [name, state.positions[place]]));
  let number = 1;
  while (world.items.value.has(`P${number}`)) number++;
  const target = { robot, tool: state.tool ?? "", toolCenterPoint: state.toolCenterPoint, jointPositions };
  const node = { name: `P${number}`, parentTNode: state.worldTTcp, kind: { case: "target" as const, value: target } };
  if (!(await apply({ case: "createNode", value: { node } }))) return "";
  say(`taught P${number} with ${robot}`, "good");
  world.selected.value = `P${number}`;
  return `P${number}`;
}

/** Starts a motion, which goes on only while this page is there, and tells how it ends. */
export async function run(spec: MessageInitShape<typeof MotionSpecSchema>): Promise<boolean> {
  try {
    const options = { busyPolicy: BusyPolicy.PREEMPT, onDisconnect: DisconnectPolicy.STOP };
    const { motion, notes } = await start({ spec, ...options });
    for (const note of notes) say(forPeople(note.message));
    for await (const now of motions.watchMotion({ id: motion?.id ?? "", maxRateHertz: 5 })) {
      if (now.motion?.phase === MotionPhase.SUCCEEDED) return true;
      if (now.motion?.endReason) say(forPeople(now.motion.endReason), "warning");
    }
  } catch (error) {
    say(wordsOf(error), "error");
  }
  return false;
}

export async function undo(): Promise<void> {
  const said = await attempt(history.undo({}));
  if (said?.undone) say(`undone: ${said.undone.label}`);
}

export async function redo(): Promise<void> {
  const said = await attempt(history.redo({}));
  if (said?.redone) say(`done again: ${said.redone.label}`);
}
