// The program in the panel: its text, its run in the debugger, where it is, and what it asks.
import { computed, effect, signal } from "@preact/signals";
import { say } from "../kernel/messages";
import { wordsOf } from "../kernel/words";
import { hearEvents, request } from "./adapter";
import { hideAhead, showAhead } from "./ahead";

export interface Frame {
  id: number;
  name: string;
  line: number;
  /** Where the robot is, not the program. */
  isMotion: boolean;
}

export interface Variable {
  name: string;
  value: string;
  type: string;
  /** By which its parts are asked for; 0 for none. */
  reference: number;
  /** By which it is set. */
  holder: number;
}

export interface Scope {
  name: string;
  reference: number;
  open: boolean;
}

export interface Question {
  text: string;
  choices: readonly string[];
}

/** How a program is: it is loaded, runs, stands before a statement, or is about to end. */
export type State = "begins" | "runs" | "stands" | "ends";

export interface Said {
  number: number;
  text: string;
  isFault: boolean;
}

const LOOK_MS = 80;
const AHEAD_MS = 300;
const MOST_LINES = 500;
const SCRIPT = /\.(script|urscript)$/i;
const FIRST = `MODULE MainModule
  PROC main()
    TPWrite "Hello";
  ENDPROC
ENDMODULE
`;

export const name = signal("main.mod");
export const text = signal(FIRST);
/** Lines, from 1, before which it stops, with conditions; "" for always. */
export const breakpoints = signal<ReadonlyMap<number, string>>(new Map());
/** The line of a breakpoint whose condition is asked for. */
export const conditioned = signal<number | undefined>(undefined);
/** The robot that it moves; "" for none: it computes only, or a script moves an arm of its own. */
export const robot = signal<string | undefined>(undefined);
export const state = signal<State | undefined>(undefined);
/** Lines, from 1, that the program does and the robot makes. */
export const programLine = signal<number | undefined>(undefined);
export const motionLine = signal<number | undefined>(undefined);
export const frames = signal<readonly Frame[]>([]);
export const chosenFrame = signal<number | undefined>(undefined);
export const scopes = signal<readonly Scope[]>([]);
/** Variables by what holds them. */
export const variables = signal<ReadonlyMap<number, readonly Variable[]>>(new Map());
export const question = signal<Question | undefined>(undefined);
export const said = signal<readonly Said[]>([]);
/** Whether it is a script in URScript, which has an emulated controller of its own. */
export const isScript = computed(() => SCRIPT.test(name.value));

let count = 0;

hearEvents((event, body) => {
  if (event === "output") {
    const asks = (body.data as { asks?: Question | null } | undefined)?.asks;
    if (asks !== undefined) question.value = asks ?? undefined;
    else tell((body.output as string).replace(/\n$/, ""), body.category === "stderr");
  } else if (event === "stopped") {
    void stand(body.text as string | undefined);
  } else if (event === "terminated") {
    void request("disconnect").catch(() => undefined);
    forget();
  } else if (event === "ended") {
    if (state.peek()) tell(body.why as string, true);
    forget();
  }
});

/** Runs the text that is shown, from its begin; `stands`: it stops before its first statement. */
export async function run(stands: boolean): Promise<void> {
  if (state.peek()) return;
  state.value = "begins";
  said.value = [];
  try {
    await request("initialize", { adapterID: "virtualrobot" });
    const moves = robot.peek() ? { robot: robot.peek(), ...(isScript.peek() ? {} : { createSignals: true }) } : {};
    await request("launch", { program: name.peek(), texts: { [name.peek()]: text.peek() }, stopOnEntry: stands, ...moves });
    await setBreakpoints();
    await request("setExceptionBreakpoints", { filters: ["uncaught"] });
    await request("configurationDone");
    if (state.peek() === "begins") state.value = "runs";
  } catch (error) {
    tell(wordsOf(error), true);
    void request("disconnect").catch(() => undefined);
    forget();
  }
}

/** Has it stand before its next statement. */
export const pause = () => ask("pause");

/** Has a program that stands go on: for good, to the next statement, into what it calls, or out of it. */
export function goOn(how: "continue" | "next" | "stepIn" | "stepOut"): Promise<void> {
  if (state.peek() !== "stands") return Promise.resolve();
  state.value = "runs";
  leave();
  return ask(how);
}

/** Ends it; the robot brakes on its path. */
export function end(): Promise<void> {
  if (!state.peek()) return Promise.resolve();
  state.value = "ends";
  return ask("terminate");
}

/** Answers what it asks. */
export async function answer(words: string): Promise<void> {
  if (!question.peek()) return;
  question.value = undefined;
  tell(`> ${words}`, false);
  await ask("evaluate", { expression: words, context: "repl" });
}

export function setBreakpoint(line: number, condition: string | undefined): void {
  const more = new Map(breakpoints.peek());
  if (condition === undefined) more.delete(line);
  else more.set(line, condition);
  breakpoints.value = more;
  if (state.peek()) void setBreakpoints().catch((error: unknown) => say(wordsOf(error), "error"));
}

async function setBreakpoints(): Promise<void> {
  const shown = breakpoints.peek();
  const asked = [...shown].map(([line, condition]) => ({ line, condition }));
  const became = await request<{ breakpoints: { line: number; message?: string }[] }>("setBreakpoints", { source: { path: name.peek() }, breakpoints: asked });
  for (const { line, message } of became.breakpoints) if (message) tell(`breakpoint in line ${line}: ${message}`, true);
  // One at a line without a statement is where the program stops for it.
  if (breakpoints.peek() === shown) breakpoints.value = new Map(asked.map(({ condition }, place) => [became.breakpoints[place].line, condition]));
}

/** Shows the data of an entry of the call stack. */
export async function look(frame: number): Promise<void> {
  chosenFrame.value = frame;
  const found = await request<{ scopes: { name: string; variablesReference: number; expensive: boolean }[] }>("scopes", { frameId: frame });
  if (chosenFrame.peek() !== frame) return;
  scopes.value = found.scopes.map((one) => ({ name: one.name, reference: one.variablesReference, open: !one.expensive }));
  variables.value = new Map();
  for (const one of scopes.peek()) if (one.open) await unfold(one.reference);
}

/** Asks for the variables that something holds. */
export async function unfold(holder: number): Promise<void> {
  const found = await request<{ variables: { name: string; value: string; type: string; variablesReference: number }[] }>("variables", { variablesReference: holder });
  const shown = found.variables.map((one) => ({ name: one.name, value: one.value, type: one.type, reference: one.variablesReference, holder }));
  variables.value = new Map(variables.peek()).set(holder, shown);
}

export function fold(holder: number): void {
  const fewer = new Map(variables.peek());
  fewer.delete(holder);
  variables.value = fewer;
}

/** Gives a variable the value of an expression; a refusal is told. */
export async function setVariable({ holder, name }: Variable, value: string): Promise<void> {
  await ask("setVariable", { variablesReference: holder, name, value });
  if (variables.peek().has(holder)) await unfold(holder);
}

/** Takes another text in place of what is here. */
export function open(file: string, words: string): void {
  if (state.peek()) throw new Error(`${file}: the program here runs; end it first`);
  name.value = file;
  breakpoints.value = new Map();
  text.value = words;
  said.value = [];
}

async function stand(words: string | undefined): Promise<void> {
  const found = await request<{ stackFrames: { id: number; name: string; line: number; presentationHint?: string }[] }>("stackTrace", { threadId: 1 }).catch(() => undefined);
  if (!found || !state.peek()) return;
  if (words) tell(words, true);
  frames.value = found.stackFrames.map((one) => ({ id: one.id, name: one.name, line: one.line, isMotion: one.presentationHint === "subtle" }));
  programLine.value = frames.peek()[0]?.line;
  motionLine.value = frames.peek().find(({ isMotion }) => isMotion)?.line;
  state.value = "stands";
  const [first] = frames.peek();
  if (first && !first.isMotion) await look(first.id).catch(() => undefined);
}

/** Asks where it is as long as it runs, or the robot is on its way. */
async function follow(): Promise<void> {
  while (state.peek()) {
    if (state.peek() !== "begins") {
      const found = await request<{ tasks: { stands: boolean; program?: { line: number }; motion?: { line: number } }[] }>("virtualrobot/where").catch(() => undefined);
      const [one] = found?.tasks ?? [];
      if (one && state.peek()) {
        if (!one.stands) programLine.value = one.program?.line;
        motionLine.value = one.motion?.line;
      }
    }
    await new Promise((resolve) => setTimeout(resolve, LOOK_MS));
  }
}

/** Shows what is planned of the robot's motion as long as it runs. A script plans as it goes. */
async function lookAhead(): Promise<void> {
  while (state.peek()) {
    if (robot.peek() && !isScript.peek()) await showAhead(robot.peek()!);
    await new Promise((resolve) => setTimeout(resolve, AHEAD_MS));
  }
  hideAhead();
}

const isAtWork = computed(() => state.value !== undefined);
effect(() => {
  if (!isAtWork.value) return;
  void follow();
  void lookAhead();
});

async function ask(command: string, given: Record<string, unknown> = {}): Promise<void> {
  await request(command, { threadId: 1, ...given }).catch((error: unknown) => tell(wordsOf(error), true));
}

function leave(): void {
  frames.value = [];
  scopes.value = [];
  variables.value = new Map();
  chosenFrame.value = undefined;
}

function forget(): void {
  leave();
  state.value = question.value = programLine.value = motionLine.value = undefined;
}

function tell(words: string, isFault: boolean): void {
  said.value = [...said.peek().slice(1 - MOST_LINES), { number: ++count, text: words, isFault }];
}
