// A process of a file: its text, edges that are picked for it, how it is along its ways, its plan, and the way to run it.
import { computed, signal } from "@preact/signals";
import { askConsole } from "./console_calls";
import { attempt, say } from "./messages";
import { play, read as readProgram, running } from "./program";
import { wordsOf } from "./words";
import { chosen } from "./world";

type Point = readonly [x: number, y: number, z: number];

/** What a text says, as far as pages change it by themselves: m/s, and degrees or `free`. */
interface Said {
  text: string;
  process: string | null;
  speed: number | null;
  rotation: number | "free" | null;
  work: number | null;
  travel: number | null;
}

export type Field = "speed" | "rotation" | "work" | "travel";
export type State = "free" | "touches" | "unreached";

/** A way that was looked along, by places in the world's frame. */
export interface Look {
  name: string;
  points: readonly Point[];
  /** How far along it they are, in meters. */
  at: readonly number[];
  states: readonly State[];
  /** In words: what is not free, each with how it is there. */
  lines: readonly (readonly [State, string])[];
}

interface Plan {
  measures: readonly string[];
  /** Which limit it breaks, or what touches; "" for none. */
  fault: string;
  seconds: number;
  program: string;
}

const PAUSE_MS = 600;
const FILE = "process.yaml";

export const names = signal<readonly string[]>([]);
export const text = signal("");
export const said = signal<Said | undefined>(undefined);
/** Why the text is none, or can't be looked along or planned. */
export const fault = signal("");
/** What the console is at. */
export const busy = signal<"" | "look" | "plan">("");
export const looks = signal<readonly Look[]>([]);
export const plan = signal<Plan | undefined>(undefined);
/** The edge that was picked last: its points, and what it is. */
export const picked = signal<{ points: readonly Point[]; told: string } | undefined>(undefined);

export const canRun = computed(() => plan.value !== undefined && !plan.value.fault && !busy.value && !running.value);

let file = FILE;
/** Texts of files that the process names, such as G-code. */
let beside: Record<string, string> = {};
let timer: ReturnType<typeof setTimeout> | undefined;
/** Goes up with each change: what was asked before it is no longer of this text. */
let asked = 0;

export async function listNames(): Promise<void> {
  names.value = (await attempt(askConsole<string[]>("/processes"))) ?? [];
}

/** Begins with the example of a process, for the chosen robot. */
export async function begin(process: string): Promise<void> {
  file = FILE;
  beside = {};
  await take(askConsole<Said>("/processes/new", { process, robot: chosen.peek() }), false);
}

/** Takes the files of a process: its own, which is YAML, and those that it names. */
export async function open(given: readonly File[]): Promise<void> {
  const texts: [string, string][] = await Promise.all(given.map(async (one) => [one.name, await one.text()]));
  const own = texts.find(([name]) => /\.ya?ml$/.test(name));
  if (!own) return say("a process is a file .yaml; open it together with the files that it names", "error");
  file = own[0];
  beside = Object.fromEntries(texts.filter((one) => one !== own));
  write(own[1], 0);
}

/** Takes what is written, and reads it after a pause. */
export function write(words: string, pause = PAUSE_MS): void {
  forget();
  text.value = words;
  clearTimeout(timer);
  timer = setTimeout(() => void take(askConsole<Said>("/processes/read", { text: words, name: file }), false), pause);
}

/** Changes a field of the text, and looks again where it has been looked along. */
export async function change(field: Field, value: number | "free"): Promise<void> {
  await take(askConsole<Said>("/processes/change", { text: text.peek(), field, value }), looks.peek().length > 0);
}

/** Has it go along the edge nearest to a point of a node: along that alone, or along that, too. */
export async function pick(node: string, point: Point, add: boolean): Promise<void> {
  const answer = askConsole<Said & { points: Point[]; told: string }>("/processes/edge", { text: text.peek(), node, point, add });
  if (!(await take(answer, false))) return;
  const { points, told } = await answer;
  picked.value = { points, told };
  await look();
}

/** Sees where along its ways the tool gets to. */
export async function look(): Promise<void> {
  const found = await ask<Look[]>("look");
  if (found) [looks.value, picked.value] = [found, undefined];
}

/** Plans it; its program is then the page's program, which shows it and runs it. */
export async function planIt(): Promise<void> {
  const found = await ask<Plan>("plan");
  if (!found) return;
  plan.value = found;
  if (!found.fault) await attempt(readProgram(found.program, file.replace(/\.ya?ml$/, "-program.yaml")));
}

export async function run(): Promise<void> {
  if (canRun.peek()) await play();
}

async function ask<T>(verb: "look" | "plan"): Promise<T | undefined> {
  const number = ++asked;
  [busy.value, fault.value] = [verb, ""];
  try {
    const answer = await askConsole<T>(`/processes/${verb}`, { text: text.peek(), name: file, files: beside });
    return number === asked ? answer : undefined;
  } catch (error) {
    if (number === asked) [fault.value, looks.value] = [wordsOf(error), []];
    return undefined;
  } finally {
    if (number === asked) busy.value = "";
  }
}

/** Takes a text as the console tells it; returns whether it did. */
async function take(answer: Promise<Said>, lookAgain: boolean): Promise<boolean> {
  const number = forget();
  try {
    const told = await answer;
    if (number !== asked) return false;
    [said.value, text.value, fault.value] = [told, told.text, ""];
  } catch (error) {
    if (number === asked) fault.value = wordsOf(error);
    return false;
  }
  if (lookAgain) await look();
  else looks.value = [];
  return true;
}

/** Forgets what was found of the text before; returns the number of this change. */
function forget(): number {
  [plan.value, picked.value, busy.value] = [undefined, undefined, ""];
  return ++asked;
}
