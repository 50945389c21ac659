// Connections between signals, which the console's server runs: what there is, and how it is changed.
import { signal } from "@preact/signals";
import type { JsonObject, JsonValue } from "@bufbuild/protobuf";
import { read } from "../parts/numbers";
import { yaml } from "../parts/yaml";
import { askConsole } from "./console_calls";
import { attempt, say } from "./messages";
import { shownBelow, signalsPart } from "./shown";
import { cellSignals } from "./world";

/** An operator as the console's server tells it; `...` among its inputs stands for a list of two or more. */
export interface Operator {
  name: string;
  about: string;
  inputs: readonly string[];
  optional: readonly string[];
  settings: readonly string[];
}

interface Wiring {
  name: string;
  /** A file of connections as JSON has it. */
  file: JsonObject;
  running: boolean;
  /** Why what ran has ended by itself. */
  fault: string;
  said: readonly string[];
  operators: readonly Operator[];
}

export const wiring = signal<Wiring | undefined>(undefined);

/** The signal that each connection drives, with what gives its value. */
export function connections(): [target: string, source: JsonValue][] {
  return Object.entries((wiring.value?.file.connections ?? {}) as JsonObject);
}

export async function look(): Promise<void> {
  try {
    wiring.value = await askConsole<Wiring>("/connections");
  } catch {
    // The page says already that console or kernel are gone.
  }
}

export function connect(target: string, source: JsonValue): Promise<boolean> {
  return change("set", { target, source });
}

export function disconnect(target: string): Promise<boolean> {
  return change("remove", { target });
}

export function setRunning(on: boolean): Promise<boolean> {
  return change(on ? "run" : "pause", {});
}

/** Runs the connections of a file in place of those before; throws in words where it is none, or doesn't fit. */
export async function open(file: File): Promise<void> {
  await askConsole("/connections/open", { name: file.name, text: await file.text() });
  await look();
  shownBelow.value = "signals";
  signalsPart.value = "connections";
  say(`${file.name}: ${connections().length} connections`, "good");
}

/** Returns the file for `virtualrobot connections`. */
export function text(): string {
  return yaml(wiring.peek()?.file ?? {});
}

async function change(verb: string, said: object): Promise<boolean> {
  const done = await attempt(askConsole(`/connections/${verb}`, said));
  await look();
  return done !== undefined;
}

/** Reads what an operator works on as people write it: a signal, `not` a signal, a number, on or off. */
export function operandOf(words: string): JsonValue | undefined {
  const word = words.trim();
  if (word === "") return undefined;
  if (cellSignals.peek().has(word)) return word;
  if (/^not\s/i.test(word)) {
    const inner = operandOf(word.slice(4));
    return inner === undefined ? undefined : { not: inner };
  }
  if (/^(on|true)$/i.test(word)) return true;
  if (/^(off|false)$/i.test(word)) return false;
  return read(word) ?? word;
}
