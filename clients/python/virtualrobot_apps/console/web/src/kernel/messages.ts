// Words for people: what was refused, what has begun and ended.
import { signal } from "@preact/signals";
import { wordsOf } from "./words";

export type Level = "info" | "good" | "warning" | "error";

export interface Message {
  number: number;
  time: string;
  level: Level;
  text: string;
}

const MOST = 200;
let count = 0;

/** What has been told since the page was loaded, the newest last. */
export const messages = signal<readonly Message[]>([]);

export function say(text: string, level: Level = "info"): void {
  const time = new Date().toTimeString().slice(0, 8);
  messages.value = [...messages.value.slice(1 - MOST), { number: ++count, time, level, text }];
}

/** Returns what a call is answered; undefined, and a message, when it is refused. */
export async function attempt<T>(answer: Promise<T>): Promise<T | undefined> {
  try {
    return await answer;
  } catch (error) {
    say(wordsOf(error), "error");
    return undefined;
  }
}
