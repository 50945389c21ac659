// The program that is taught here: steps of the contract, played, stepped and saved as the project's program files.
import { computed, effect, signal } from "@preact/signals";
import { clone, create, toJson, type JsonObject, type MessageInitShape } from "@bufbuild/protobuf";
import {
  BusyPolicy, DisconnectPolicy, MotionPhase, MotionSpecSchema, ProgramStepSchema, type Motion, type MotionSpec, type ProgramStep,
} from "../generated/virtualrobot/v1/motion_pb";
import { StepKind, type Checkpoint } from "../generated/virtualrobot/v1/history_pb";
import { yaml } from "../parts/yaml";
import { attempt, say } from "./messages";
import { teach } from "./orders";
import { start } from "./own_motions";
import { ground } from "./parts";
import { history, motions } from "./services";
import { asListed, forPeople, wordsOf } from "./words";
import { chosen, hearers, items, states, steps } from "./world";

export type Way = "pointToPoint" | "linear";

/** A step of the list; the number stays its own wherever it is moved. */
export interface Line {
  number: number;
  step: ProgramStep;
}

interface Run {
  /** Of the motion, "" until the kernel has planned it. */
  id: string;
  from: number;
  at: number;
  phase: MotionPhase;
}

const RATE_HERTZ = 20;
const SCHEMA_VERSION = 1;
const STILL = 1e-5;
const MOVED = 1e-3;
const APPROACH_METERS = 0.1;
const ROUND_BRACKETS = /[.[]/;

export const lines = signal<readonly Line[]>([]);
export const title = signal("program");
/** The step that comes next. */
export const next = signal(0);
export const running = signal<Run | undefined>(undefined);
export const recording = signal(false);
/** Part of the greatest speed that steps have which are taught. */
const TAUGHT_SPEED = 0.5;

/** How the world was before each Play from the first step, the last one at the end, as the kernel keeps it. */
const kept = signal<readonly Checkpoint[]>([]);
const MOST_KEPT = 8;
/** The tick at which this page went back last, which is no edit; undefined while it does. */
const returned = signal<bigint | undefined>(0n);
const EDITS: readonly StepKind[] = [StepKind.EDIT, StepKind.UNDO, StepKind.REDO, StepKind.RESTORE];

/** Whether the cell can go back to before Play. */
export const canGoBack = computed(() => kept.value.length > 0 && !running.value);

/** The place of the step that is lit. */
export const lit = computed(() => running.value?.at);

let count = 0;
let programs: MotionSpec["programs"] = {};

const lineOf = (step: ProgramStep): Line => ({ number: ++count, step });

export function append(step: MessageInitShape<typeof ProgramStepSchema>["step"]): void {
  lines.value = [...lines.value, lineOf(create(ProgramStepSchema, { step }))];
}

/** Teaches a target where the chosen robot is, and appends the way there. */
export async function appendMove(way: Way): Promise<void> {
  const robot = chosen.peek();
  const target = await teach(robot);
  if (!target) return;
  const goal = { reference: target };
  const move = way === "linear" ? { case: way, value: { goal } } : { case: way, value: { goal: { case: "pose" as const, value: goal } } };
  append({ case: "move", value: { moves: [{ robot, speedFactor: TAUGHT_SPEED, move }] } });
}

/** Teaches a target where the chosen robot's tool is, and appends a pick or a place there, with lines to it and away. */
export async function appendHandling(verb: "pickAt" | "placeAt"): Promise<void> {
  const robot = chosen.peek(), { tool = "" } = states.peek().get(robot) ?? {};
  const [open = "", holding = ""] = toolStatesOf(tool);
  const target = await teach(robot);
  if (!target) return;
  const common = { robot, goal: { reference: target }, approachMeters: APPROACH_METERS, retreatMeters: APPROACH_METERS };
  if (verb === "pickAt") append({ case: verb, value: { ...common, stateBefore: open, state: holding } });
  else append({ case: verb, value: { ...common, state: open, parent: ground.peek() } });
}

/** Returns the states of a tool: the first is that in which it holds nothing. */
export function toolStatesOf(tool: string): string[] {
  const kind = items.peek().get(tool)?.node.kind;
  return kind?.case === "tool" ? kind.value.states.map(({ name }) => name) : [];
}

/** Appends the way to a posture that the robot knows by name, such as home. */
export function appendPosture(robot: string, posture: string): void {
  const move = { case: "pointToPoint" as const, value: { goal: { case: "posture" as const, value: posture } } };
  append({ case: "move", value: { moves: [{ robot, speedFactor: TAUGHT_SPEED, move }] } });
}

export function appendTool(robot: string, tool: string, state: string): void {
  append({ case: "move", value: { moves: [{ robot, move: { case: "toolState", value: { tool, state } } }] } });
}

/** Changes a copy of a step. */
export function change(number: number, edit: (step: ProgramStep) => void): void {
  lines.value = lines.value.map((line) => {
    if (line.number !== number) return line;
    const step = clone(ProgramStepSchema, line.step);
    edit(step);
    return { number, step };
  });
}

export function drop(number: number): void {
  const place = lines.value.findIndex((line) => line.number === number);
  lines.value = lines.value.filter((line) => line.number !== number);
  if (place < next.value) next.value--;
}

export function shift(number: number, by: number): void {
  const place = lines.value.findIndex((line) => line.number === number), to = place + by;
  if (to < 0 || to >= lines.value.length) return;
  const moved = [...lines.value];
  moved.splice(to, 0, ...moved.splice(place, 1));
  lines.value = moved;
}

export function clear(): void {
  forget(kept.peek());
  lines.value = [];
  programs = {};
  next.value = 0;
  title.value = "program";
}

/** Plays from the next step to the end, or goes on after a pause. */
export async function play(): Promise<void> {
  if (running.peek()) return void (await attempt(motions.resumeMotion({ id: running.peek()!.id })));
  const from = next.peek() < lines.peek().length ? next.peek() : 0;
  if (from === 0) await keep();
  if (await run(from, lines.peek().slice(from))) say("the program is done", "good");
}

/** Has the kernel keep the world as it is. */
async function keep(): Promise<void> {
  try {
    const { checkpoint } = await history.createCheckpoint({ name: `before Play, ${new Date().toISOString()}` });
    kept.value = [...kept.peek(), checkpoint!];
    forget(kept.peek().slice(0, -MOST_KEPT));
  } catch {
    // Who may not keep the world may play all the same.
  }
}

function forget(these: readonly Checkpoint[]): void {
  for (const { name } of these) history.removeCheckpoint({ name }).catch(() => {}); // who plays may still not forget
  if (these.length > 0) kept.value = kept.peek().filter((one) => !these.includes(one));
}

// An edit of anybody would be lost on the way back.
effect(() => {
  const back = returned.value;
  if (back === undefined) return;
  const edited = (from: bigint) => steps.value.some(({ kind, tick }) => tick > from && tick > back && EDITS.includes(kind));
  forget(kept.value.filter(({ tick }) => edited(tick)));
});

/** Puts the cell back to how it was before Play: robots, parts and signals. */
export async function goBack(): Promise<void> {
  const before = kept.peek().at(-1);
  if (!before) return;
  const already = returned.peek();
  returned.value = undefined;
  const said = await attempt(history.restoreCheckpoint({ name: before.name }));
  if (said) forget([before]);
  returned.value = said?.stamp?.tick ?? already;
  if (!said) return;
  next.value = 0;
  say("the cell is as it was before Play", "good");
}

export async function pause(): Promise<void> {
  if (running.peek()) await attempt(motions.pauseMotion({ id: running.peek()!.id }));
}

export async function halt(): Promise<void> {
  if (running.peek()) await attempt(motions.cancelMotion({ id: running.peek()!.id, reason: "the program was stopped in the console" }));
}

/** Does one step, and stands. */
export async function forward(): Promise<void> {
  const from = next.peek() < lines.peek().length ? next.peek() : 0;
  await run(from, lines.peek().slice(from, from + 1));
}

/** Takes one step back: to where the move before led, or the tool to the state that it had before. */
export async function back(): Promise<void> {
  if (running.peek() || next.peek() === 0) return;
  const last = next.peek() - 1;
  const undone = subjectOf(lines.peek()[last]?.step);
  const before = undone ? lines.peek().slice(0, last).findLastIndex(({ step }) => subjectOf(step) === undone) : -1;
  if (before < 0) {
    if (undone) say("nothing before this step says where to go back to", "warning");
    next.value = last;
  } else if (await run(before, lines.peek().slice(before, before + 1))) next.value = last;
}

/** Returns what a step brings elsewhere: a robot, or a tool; undefined for steps that nothing takes back. */
function subjectOf(step: ProgramStep | undefined): string | undefined {
  if (step?.step.case !== "move") return undefined;
  return step.step.value.moves.map(({ robot, move }) => (move.case === "toolState" ? `${robot} ${move.value.tool}` : robot)).join(" ");
}

async function run(from: number, some: readonly Line[]): Promise<boolean> {
  if (running.peek() || some.length === 0) return false;
  const spec = create(MotionSpecSchema, { steps: some.map(({ step }) => step), programs });
  running.value = { id: "", from, at: from, phase: MotionPhase.UNSPECIFIED };
  let done = false;
  try {
    const { motion, notes } = await start({ spec, busyPolicy: BusyPolicy.PREEMPT, onDisconnect: DisconnectPolicy.STOP });
    for (const note of notes) say(asListed(forPeople(note.message), from));
    for await (const now of motions.watchMotion({ id: motion?.id ?? "", maxRateHertz: RATE_HERTZ })) {
      if (!now.motion) continue;
      running.value = { id: now.motion.id, from, at: from + placeOf(now.motion), phase: now.motion.phase };
      done = now.motion.phase === MotionPhase.SUCCEEDED;
      if (now.motion.endReason) say(asListed(forPeople(now.motion.endReason), from), "warning");
    }
    next.value = done ? from + some.length : running.peek()!.at;
  } catch (error) {
    say(asListed(wordsOf(error), from), "error");
  } finally {
    running.value = undefined;
  }
  return done;
}

/** Returns which step of the list a motion is at: the first number of its path. */
function placeOf({ stepPath, step }: Motion): number {
  return stepPath ? Number(stepPath.split(ROUND_BRACKETS)[0]) : step;
}

/** Returns the text of the program's file. */
export function text(): string {
  const spec = create(MotionSpecSchema, { steps: lines.peek().map(({ step }) => step), programs });
  return yaml({ schema_version: SCHEMA_VERSION, ...(toJson(MotionSpecSchema, spec, { useProtoFieldName: true }) as JsonObject) });
}

/** Takes a program file in place of what is here; throws as the kernel refuses it. */
export async function read(words: string, file: string): Promise<void> {
  const { spec } = await motions.readProgram({ text: words, uri: file });
  const steps = spec?.steps.length ? spec.steps : [create(ProgramStepSchema, { step: { case: "move", value: { moves: spec?.moves } } })];
  lines.value = steps.map(lineOf);
  programs = spec?.programs ?? {};
  title.value = file.split("/").at(-1)!.replace(/\.ya?ml$/, "");
  next.value = 0;
  say(`${file}: ${steps.length} steps`, "good");
}

let positions: readonly number[] = [];
let toolStates: Record<string, string> = {};
let rested = true;

effect(() => {
  const state = recording.value ? states.peek().get(chosen.value) : undefined;
  positions = state?.positions ?? [];
  toolStates = { ...state?.toolStates };
  rested = true;
});

/** Takes down where the robot comes to rest, and what its tools do, while a person moves it. */
function record(): void {
  const state = states.peek().get(chosen.peek());
  if (!recording.peek() || running.peek() || !state) return;
  for (const [tool, now] of Object.entries(state.toolStates)) if (toolStates[tool] !== now) appendTool(state.name, tool, now);
  toolStates = { ...state.toolStates };
  const rests = state.motionIds.length === 0 && state.velocities.every((velocity) => Math.abs(velocity) < STILL);
  const came = rests && !rested && state.positions.some((position, joint) => Math.abs(position - positions[joint]) > MOVED);
  rested = rests;
  if (!came) return;
  positions = [...state.positions];
  void appendMove("pointToPoint");
}

hearers.states.add(record);
