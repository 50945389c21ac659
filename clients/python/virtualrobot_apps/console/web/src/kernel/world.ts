// The world as the kernel tells it, in signals that the panels read.
import { computed, signal } from "@preact/signals";
import type { ReportedCollision } from "../generated/virtualrobot/v1/collision_pb";
import type { CellStatus, DriverStatus } from "../generated/virtualrobot/v1/driver_pb";
import type { Clock, GetInfoResponse } from "../generated/virtualrobot/v1/kernel_pb";
import type { Lease } from "../generated/virtualrobot/v1/lease_pb";
import type { Motion } from "../generated/virtualrobot/v1/motion_pb";
import type { Node } from "../generated/virtualrobot/v1/nodes_pb";
import type { Proposal } from "../generated/virtualrobot/v1/proposal_pb";
import type { Record as Told } from "../generated/virtualrobot/v1/record_pb";
import type { GetRobotResponse, RobotState } from "../generated/virtualrobot/v1/robot_pb";
import type { Signal } from "../generated/virtualrobot/v1/signal_pb";
import type { Step } from "../generated/virtualrobot/v1/history_pb";

export type Kind = NonNullable<Node["kind"]["case"]>;

/** A node of the tree; `parent` is "" for the world alone. */
export interface Item {
  uid: bigint;
  name: string;
  parent: string;
  hidden: boolean;
  kind: Kind;
  node: Node;
}

export type Connection = "connecting" | "connected" | "lost" | "refused";

/** How the page and the kernel are; `trouble` says why it isn't connected. */
export const connection = signal<Connection>("connecting");
export const trouble = signal("");
/** Whether the kernel would hear nothing of what is pressed. */
export const isGone = computed(() => connection.value === "lost" || connection.value === "refused");
export const info = signal<GetInfoResponse | undefined>(undefined);

/** The nodes by name, parents before children. */
export const items = signal<ReadonlyMap<string, Item>>(new Map());
export const names = new Map<bigint, string>();
export const children = computed(() => {
  const found = new Map<string, Item[]>();
  for (const item of items.value.values()) {
    const list = found.get(item.parent);
    if (list) list.push(item);
    else found.set(item.parent, [item]);
  }
  // One that was removed comes back to its place by undo.
  for (const list of found.values()) list.sort((one, other) => (one.uid < other.uid ? -1 : 1));
  return found;
});

export const robotNames = computed(() => [...items.value.values()].filter(({ kind }) => kind === "robot").map(({ name }) => name));
export const robots = signal<ReadonlyMap<string, GetRobotResponse>>(new Map());
export const states = signal<ReadonlyMap<string, RobotState>>(new Map());

export const clock = signal<Clock | undefined>(undefined);
export const simulationTime = signal(0);
/** How often poses were told: what has moved is in no node of `items`, but where the view has it. */
export const moves = signal(0);
export const speedFactor = signal(1);
export const motions = signal<readonly Motion[]>([]);
export const cellSignals = signal<ReadonlyMap<string, Signal>>(new Map());
export const touching = signal<readonly ReportedCollision[]>([]);
export const leases = signal<readonly Lease[]>([]);
/** Motions that somebody has proposed, by their names, oldest first. */
export const proposals = signal<ReadonlyMap<string, Proposal>>(new Map());
/** Programs of robots' languages, by their records' names, oldest first. */
export const tasks = signal<ReadonlyMap<string, Told>>(new Map());
export const drivers = signal<readonly DriverStatus[]>([]);
export const cell = signal<CellStatus | undefined>(undefined);

/** Edits of anybody, the newest first. */
export const steps = signal<readonly Step[]>([]);

const STILL = 1e-5;

/** Whether a joint of any robot moves. */
export const moving = computed(() => [...states.value.values()].some(({ name, velocities }) => robots.value.has(name) && velocities.some((v) => Math.abs(v) > STILL)));

/** The node that people have selected, and the robot that the pendant moves. */
export const selected = signal("");
export const chosen = signal("");

export type Renamed = ReadonlyMap<string, string>;
/** Signals that are new or changed, and those that are gone, at a simulation time. */
export interface SignalChanges {
  signals: readonly Signal[];
  removed: readonly string[];
  time: number;
}
export type Poses = (uids: readonly bigint[], rows: Float64Array) => void;

/** Functions that are told what comes often, without a signal for it. */
export const hearers = {
  poses: new Set<Poses>(),
  structure: new Set<(renamed: Renamed) => void>(),
  states: new Set<(time: number) => void>(),
  signals: new Set<(told: SignalChanges) => void>(),
};

/** Returns the names of a node and of all that hangs below it. */
export function below(name: string): string[] {
  const found = [name];
  for (let place = 0; place < found.length; place++) {
    for (const child of children.peek().get(found[place]) ?? []) found.push(child.name);
  }
  return found;
}

/** Returns the robot that a node is, or is part of, or hangs on; "" for none. */
export function robotOf(name: string): string {
  let item = items.peek().get(name);
  while (item && item.kind !== "robot") item = items.peek().get(item.parent);
  return item?.name ?? "";
}
