// What signals were when, since the page was opened: the kernel tells each change with its time, and leaves none out.
import { signal } from "@preact/signals";
import type { SignalValue } from "../generated/virtualrobot/v1/signal_pb";
import { hearers, type SignalChanges } from "./world";

/** Changes of one signal, the oldest first; texts are shown as words, all else as a level. */
export interface Lane {
  times: number[];
  values: (number | string)[];
}

const MOST = 2000;

export const lanes = new Map<string, Lane>();

/** Goes up when a signal has changed. */
export const changes = signal(0);

hearers.signals.add(({ signals, removed, time }: SignalChanges) => {
  for (const name of removed) lanes.delete(name);
  for (const { name, value } of signals) {
    const level = levelOf(value);
    let lane = lanes.get(name);
    // Time that has gone back is that of another run.
    if (!lane || time < (lane.times.at(-1) ?? time)) lanes.set(name, (lane = { times: [], values: [] }));
    if (lane.values.at(-1) === level) continue;
    lane.times.push(time);
    lane.values.push(level);
    if (lane.times.length > MOST) for (const list of [lane.times, lane.values]) list.splice(0, MOST / 4);
  }
  changes.value++;
});

function levelOf(value?: SignalValue): number | string {
  const kind = value?.kind;
  switch (kind?.case) {
    case "boolean":
      return kind.value ? 1 : 0;
    case "integer":
      return Number(kind.value);
    case "number":
      return kind.value;
    case "text":
      return kind.value;
    case "group":
      return kind.value.values.map((on) => (on ? "1" : "0")).join("");
    default:
      return 0;
  }
}

/** Returns how long a signal was on when it was on last, in seconds; undefined where that isn't known. */
export function lastPulse({ times, values }: Lane): number | undefined {
  for (let place = values.length - 1; place > 1; place--) {
    // What was on before the page was opened began nobody knows when.
    if (values[place] === 0 && values[place - 1] === 1) return times[place] - times[place - 1];
  }
  return undefined;
}
