// A trajectory of a file: what the kernel plans of it, whether it may be played, and what was measured when it was.
import { effect, signal } from "@preact/signals";
import { create, fromJson, type JsonValue } from "@bufbuild/protobuf";
import {
  BusyPolicy, DisconnectPolicy, JointTrajectorySchema, MotionPhase, MotionSpecSchema, type JointTrajectory, type MotionSpec, type PlanMotionResponse,
} from "../generated/virtualrobot/v1/motion_pb";
import { JointType } from "../generated/virtualrobot/v1/nodes_pb";
import { ofArray, rowsOf } from "./arrays";
import { askConsole } from "./console_calls";
import { goal } from "./goal";
import { attempt, say } from "./messages";
import { start as startMotion } from "./own_motions";
import { motions } from "./services";
import { shownBelow } from "./shown";
import { forPeople, wordsOf } from "./words";
import { chosen, clock, hearers, items, robots, states } from "./world";

/** Rows of samples at times (s) from 0, a column for each joint; what isn't known is left out. */
export interface Curve {
  joints: readonly string[];
  times: readonly number[];
  positions: readonly number[][];
  velocities?: readonly number[][];
  /** Of each joint on the link that it moves, N m or N. */
  efforts?: readonly number[][];
  /** Of the tool centre point in the world, x, y, z in meters. */
  points?: readonly number[][];
}

/** Why it may not be played, with the time (s) where that is known. */
export interface Fault {
  words: string;
  time?: number;
}

export interface Trajectory {
  robot: string;
  file: string;
  /** The way to its start, then itself. */
  spec: MotionSpec;
  curve: Curve;
  /** Length (s) of the way to its start. */
  before: number;
  /** Whether the kernel has looked at it; what it found. */
  checked: boolean;
  fault?: Fault;
}

/** What was measured at times of the trajectory, and by how much that was beside what was commanded. */
export interface Measured {
  times: readonly number[];
  positions: readonly number[][];
  velocities: readonly number[][];
  errors: readonly number[][];
  /** Whether the joints are measured at all: those of robots without a driver are where they are commanded. */
  real: boolean;
}

interface Sample {
  time: number;
  positions: readonly number[];
  velocities: readonly number[];
  commanded: readonly number[];
}

const MOST_SAMPLES = 600;
const MOST_MEASURED = 5000;
const RATE_HERTZ = 20;
const NANO = 1e-9;
const SOON = 1e-9;
/** Part of the greatest speed by which the robot goes to the start. */
const APPROACH = 0.5;

export const trajectory = signal<Trajectory | undefined>(undefined);
export const moment = signal(0);
export const measured = signal<Measured | undefined>(undefined);
/** The motion that plays it, "" while it is planned; undefined for none. */
export const playing = signal<string | undefined>(undefined);

let samples: Sample[] = [];
let asked = 0;

/** Reads a file for the chosen robot, and shows it; throws what is wrong with it, with line and column. */
export async function open(file: File): Promise<void> {
  const robot = chosen.peek();
  if (!robot) throw new Error(`${file.name}: there is no robot that could follow it`);
  const said = await askConsole<JsonValue>("/trajectory", { robot, name: file.name, text: await file.text() });
  const path = fromJson(JointTrajectorySchema, said);
  close();
  shownBelow.value = "trajectory";
  const curve = read(path);
  trajectory.value = { robot, file: file.name, spec: specOf(robot, path, curve), curve, before: 0, checked: false };
  say(`${file.name}: ${curve.times.length} samples of ${curve.joints.length} joints`, "good");
  await look();
}

export function close(): void {
  if (trajectory.peek() && goal.joints.peek()?.robot === trajectory.peek()!.robot) goal.clear();
  asked++;
  trajectory.value = measured.value = undefined;
  moment.value = 0;
}

/** Goes to a time of it; the ghost shows the robot there. */
export function seek(time: number): void {
  const one = trajectory.peek();
  if (!one) return;
  const { curve, robot } = one;
  moment.value = Math.min(Math.max(0, time), curve.times.at(-1)!);
  const row = rowAt(curve.times, curve.positions, moment.peek());
  if (playing.peek() === undefined) goal.show(robot, Object.fromEntries(curve.joints.map((name, place) => [name, row[place]])));
}

/** Plays it from where the robot is, when the kernel finds nothing against it. */
export async function play(): Promise<void> {
  const robot = trajectory.peek()?.robot;
  if (robot === undefined || playing.peek() !== undefined) return;
  playing.value = "";
  try {
    goal.clear();
    await look();
    const one = trajectory.peek();
    if (!one?.checked || one.fault) return void say(one?.fault?.words ?? "the trajectory is gone", "error");
    samples = [];
    measured.value = undefined;
    const { motion } = await startMotion({ spec: one.spec, busyPolicy: BusyPolicy.PREEMPT, onDisconnect: DisconnectPolicy.STOP });
    const { id, startTimeSeconds: start, plannedDurationSeconds: whole } = motion!;
    playing.value = id;
    const course: [time: number[], done: number[][]] = [[start], [[-one.before]]];
    for await (const { motion: now, stamp } of motions.watchMotion({ id, maxRateHertz: RATE_HERTZ })) {
      if (!now || !stamp) continue;
      course[0].push(stamp.simulationTimeSeconds);
      course[1].push([now.progress * whole - one.before]);
      measured.value = taken(one, course);
      moment.value = Math.min(Math.max(0, course[1].at(-1)![0]), one.curve.times.at(-1)!);
      if (now.phase === MotionPhase.SUCCEEDED) say(`${robot} has followed ${one.file}`, "good");
      if (now.endReason) say(forPeople(now.endReason), "warning");
    }
  } catch (error) {
    say(wordsOf(error), "error");
  } finally {
    playing.value = undefined;
  }
}

export async function halt(): Promise<void> {
  if (playing.peek()) await attempt(motions.cancelMotion({ id: playing.peek()!, reason: "the trajectory was stopped in the console" }));
}

/** Returns the row at a time, between samples as far as it has gone. */
export function rowAt(times: readonly number[], rows: readonly (readonly number[])[], time: number): number[] {
  let low = 0, high = times.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle;
  }
  const span = times[high] - times[low];
  const part = span > 0 ? Math.min(1, Math.max(0, (time - times[low]) / span)) : 0;
  return rows[low].map((value, place) => value + part * (rows[high][place] - value));
}

/** Has the kernel plan and check it from where the robot is now. */
async function look(): Promise<void> {
  const number = ++asked;
  const change = (more: Partial<Trajectory>) => {
    if (number === asked && trajectory.peek()) trajectory.value = { ...trajectory.peek()!, ...more };
  };
  const { spec, robot, curve } = trajectory.peek()!;
  change({ checked: false, fault: undefined });
  try {
    const every = Math.max(Number(clock.peek()?.tickNanoseconds ?? 0) * NANO, curve.times.at(-1)! / MOST_SAMPLES);
    const planned = planOf(await motions.planMotion({ spec, sampleSeconds: every }), robot, curve.times.at(-1)!);
    change(planned);
    const { firstViolation: found } = await motions.checkMotion({ spec });
    const time = found?.timeSeconds === undefined ? undefined : found.timeSeconds - planned.before;
    change({ checked: true, fault: found && { words: forPeople(found.message), time } });
  } catch (error) {
    change({ checked: true, fault: { words: wordsOf(error).replace(/^step \d+: /, "") } });
  }
}

function read({ jointNames, times, positions }: JointTrajectory): Curve {
  return { joints: jointNames, times: [...ofArray(times!)], positions: rowsOf(ofArray(positions!), jointNames.length) };
}

function specOf(robot: string, path: JointTrajectory, { joints, positions: [first] }: Curve): MotionSpec {
  const jointPositions = Object.fromEntries(joints.map((name, place) => [name, first[place]]));
  const toStart = { robot, speedFactor: APPROACH, move: { case: "pointToPoint" as const, value: { goal: { case: "joints" as const, value: { jointPositions } } } } };
  const along = { robot, move: { case: "jointTrajectory" as const, value: path } };
  return create(MotionSpecSchema, { steps: [toStart, along].map((move) => ({ step: { case: "move" as const, value: { moves: [move] } } })) });
}

/** Returns what was planned of the trajectory itself, without the way to its start. */
function planOf(said: PlanMotionResponse, robot: string, length: number): { curve: Curve; before: number } {
  const told = said.robots.find((one) => one.robot === robot)!;
  const before = said.durationSeconds - length;
  const all = ofArray(said.times!), from = Math.max(0, all.findIndex((time) => time >= before - SOON));
  const table = (numbers: Float64Array, width: number) => rowsOf(numbers, width).slice(from);
  const efforts = table(ofArray(told.efforts!), told.jointNames.length);
  const curve: Curve = {
    joints: told.jointNames,
    times: [...all.slice(from)].map((time) => Math.max(0, time - before)),
    positions: table(ofArray(told.positions!), told.jointNames.length),
    velocities: table(ofArray(told.velocities!), told.jointNames.length),
    efforts: efforts.some((row) => row.some((value) => value !== 0)) ? efforts : undefined,
    points: table(ofArray(told.worldTTcp!), 7).map((row) => row.slice(0, 3)),
  };
  return { curve, before };
}

/** Returns what was measured so far by the trajectory's own time, which goes by as `course` tells. */
function taken({ curve, robot }: Trajectory, [times, done]: [readonly number[], readonly number[][]]): Measured {
  const places = placesOf(robot), at = curve.joints.map((name) => places.get(name)!);
  const last = times.at(-1)!;
  const some = samples.filter(({ time }) => time <= last).map((one) => ({ ...one, time: rowAt(times, done, one.time)[0] })).filter(({ time }) => time >= 0);
  return {
    times: some.map(({ time }) => time),
    positions: some.map(({ positions }) => at.map(([place]) => positions[place])),
    velocities: some.map(({ velocities }) => at.map(([, place]) => velocities[place])),
    errors: some.map(({ positions, commanded }) => at.map(([place]) => (commanded.length ? positions[place] - commanded[place] : 0))),
    real: some.some(({ commanded }) => commanded.length > 0),
  };
}

/** Returns where the position and the velocity of each coordinate stand in a robot's state. */
function placesOf(robot: string): Map<string, [position: number, velocity: number]> {
  const found = new Map<string, [number, number]>();
  let position = 0, velocity = 0;
  for (const { coordinateNames, velocityCount, type } of robots.peek().get(robot)?.joints ?? []) {
    for (const [place, name] of coordinateNames.entries()) found.set(name, [position + place, velocity + (type === JointType.FLOATING ? Math.min(place, velocityCount - 1) : place)]);
    position += coordinateNames.length;
    velocity += velocityCount;
  }
  return found;
}

hearers.states.add((time) => {
  const state = playing.peek() ? states.peek().get(trajectory.peek()?.robot ?? "") : undefined;
  if (!state || samples.length >= MOST_MEASURED || samples.at(-1)?.time === time) return;
  samples.push({ time, positions: state.positions, velocities: state.velocities, commanded: state.commandedPositions });
});

hearers.structure.add((renamed) => {
  const one = trajectory.peek(), to = one && renamed.get(one.robot);
  if (to) trajectory.value = { ...one, robot: to, spec: specOf(to, pathOf(one.spec)!, one.curve) };
});

function pathOf({ steps }: MotionSpec): JointTrajectory | undefined {
  const step = steps[1].step;
  const move = step.case === "move" ? step.value.moves[0].move : undefined;
  return move?.case === "jointTrajectory" ? move.value : undefined;
}

// That of a robot which is gone is gone, too.
effect(() => {
  if (trajectory.value && !items.value.has(trajectory.value.robot)) close();
});
