// Curves over time of anything that the world tells: the console's server watches their streams, and this page asks it again and again.
import { signal } from "@preact/signals";
import { askConsole } from "./console_calls";
import { wordsOf } from "./words";

/** What has just been: times in seconds of simulation time, and the curves' values at them; null where nothing was told yet. */
export interface Curves {
  times: number[];
  curves: { name: string; values: (number | null)[] }[];
  /** The numbers that the streams have, by which curves are called. */
  known: string[];
}

interface Stream {
  name: string;
  unit: string;
}

const ASKED_MS = 300;
export const MOST = 16;
const PAGE = crypto.randomUUID?.() ?? String(Math.random());
const NOTHING: Curves = { times: [], curves: [], known: [] };

/** The curves that are drawn: `STREAM:FIELD`, patterns, or `A - B`. */
export const wanted = signal<readonly string[]>([]);
export const drawn = signal<Curves>(NOTHING);
export const held = signal(false);
/** Why there are no curves. */
export const fault = signal("");
export const streams = signal<readonly Stream[]>([]);

export async function listStreams(): Promise<void> {
  try {
    streams.value = await askConsole<Stream[]>("/streams");
  } catch {
    // The page says already that console or kernel are gone.
  }
}

export function add(curve: string): void {
  if (curve && !wanted.peek().includes(curve)) wanted.value = [...wanted.peek(), curve].slice(-MOST);
}

export function drop(curve: string): void {
  wanted.value = wanted.peek().filter((one) => one !== curve);
}

/** Returns the unit of a curve's stream, where that is one for all of its numbers. */
export function unitOf(curve: string): string {
  const unit = streams.value.find(({ name }) => name === curve.split(":")[0])?.unit ?? "";
  return unit.includes(",") ? "" : unit;
}

/** Asks while somebody looks, until the returned function is called. */
export function followed(): () => void {
  let over = false;
  const ask = async () => {
    const curves = wanted.peek();
    if (curves.length === 0) [drawn.value, fault.value] = [NOTHING, ""];
    else if (!held.peek()) {
      try {
        const said = await askConsole<Curves>("/curves", { page: PAGE, curves });
        if (wanted.peek() === curves && !held.peek()) [drawn.value, fault.value] = [said, ""];
      } catch (error) {
        fault.value = wordsOf(error);
      }
    }
    if (!over) setTimeout(() => void ask(), ASKED_MS);
  };
  void ask();
  return () => void (over = true);
}
