// Traces: the ways that nodes go, of a robot that of its tool centre point; live, and kept in the world as lines.
import { signal } from "@preact/signals";
import { create } from "@bufbuild/protobuf";
import { NumericArraySchema, NumericType } from "../generated/virtualrobot/v1/geometry_pb";
import { apply } from "./orders";
import { hearers, items, simulationTime, states, type Renamed } from "./world";

/** How a node is traced; what it has gone is in `ways`. */
export interface Trace {
  node: string;
  /** As the browser writes colours, `#rrggbb`. */
  color: string;
  /** How far back it is shown, in seconds of simulation time; 0: all. */
  seconds: number;
  live: boolean;
}

type Point = readonly [x: number, y: number, z: number];

/** The way of a node: where it was, in meters in the world's frame, and when. */
export class Way {
  readonly points: Point[] = [];
  readonly times: number[] = [];

  /** Adds where the node is; returns whether it has gone any further. */
  add(point: Point, time: number): boolean {
    const last = this.points.at(-1);
    if (last && Math.hypot(point[0] - last[0], point[1] - last[1], point[2] - last[2]) < APART_METERS) return false;
    // Time that has gone back is that of another run.
    if (time < (this.times.at(-1) ?? time)) this.cut(Infinity);
    this.points.push(point);
    this.times.push(time);
    if (this.points.length > MOST) this.#drop(MOST / 4);
    return true;
  }

  /** Forgets what was before a time; returns whether anything was. */
  cut(before: number): boolean {
    const count = this.times.findIndex((time) => time >= before);
    this.#drop(count < 0 ? this.points.length : count);
    return count !== 0;
  }

  get meters(): number {
    return this.points.slice(1).reduce((sum, [x, y, z], place) => {
      const before = this.points[place];
      return sum + Math.hypot(x - before[0], y - before[1], z - before[2]);
    }, 0);
  }

  /** Returns the ends of its straight pieces: six numbers each. */
  segments(): number[] {
    return this.points.slice(1).flatMap((point, place) => [...this.points[place], ...point]);
  }

  #drop(count: number): void {
    this.points.splice(0, count);
    this.times.splice(0, count);
  }
}

export const MOST = 6000;
const APART_METERS = 0.002;
const COLORS = ["#38bdf8", "#ff9e4a", "#4cc38a", "#c58bff", "#f0616d", "#ffd65c"];

export const traces = signal<readonly Trace[]>([]);
export const ways = new Map<string, Way>();

/** Goes up when a way has changed. */
export const gone = signal(0);

export function trace(node: string): void {
  if (!node || node === "world" || isTraced(node)) return;
  ways.set(node, new Way());
  const taken = new Set(traces.value.map(({ color }) => color));
  const color = COLORS.find((one) => !taken.has(one)) ?? COLORS[0];
  traces.value = [...traces.value, { node, color, seconds: 0, live: true }];
}

export function isTraced(node: string): boolean {
  return traces.value.some((one) => one.node === node);
}

export function setTrace(node: string, change: Partial<Trace>): void {
  traces.value = traces.value.map((one) => (one.node === node ? { ...one, ...change } : one));
}

export function untrace(node: string): void {
  ways.delete(node);
  traces.value = traces.value.filter((one) => one.node !== node);
}

export function clearTrace(node: string): void {
  ways.get(node)?.cut(Infinity);
  gone.value++;
}

/** Keeps what a node has gone as a node of the world, which everybody sees, and which scene files and undo know. */
export async function keepTrace({ node, color }: Trace): Promise<boolean> {
  const segments = ways.get(node)?.segments() ?? [];
  if (segments.length === 0) return false;
  let name = `trace of ${node}`;
  for (let number = 2; items.peek().has(name); number++) name = `trace of ${node} ${number}`;
  const data = new Uint8Array(Float32Array.from(segments).buffer);
  const lines = { segments: create(NumericArraySchema, { type: NumericType.FLOAT32, shape: [segments.length / 6, 2, 3], data }) };
  const [red, green, blue] = [1, 3, 5].map((at) => parseInt(color.slice(at, at + 2), 16) / 255);
  const figure = { geometry: { case: "lines" as const, value: lines }, material: { color: { red, green, blue, alpha: 1 } } };
  return apply({ case: "createNode", value: { node: { name, figures: [figure], kind: { case: "annotation", value: {} } } } });
}

/** Adds to all ways that are live; `places` gives where nodes are. */
export function follow(places: (node: string) => Point | undefined): boolean {
  let changed = false;
  const time = simulationTime.peek();
  for (const { node, live, seconds } of traces.peek()) {
    const way = ways.get(node);
    if (!way || !live) continue;
    const point = tipOf(node) ?? places(node);
    if (point && way.add(point, time)) changed = true;
    if (seconds > 0 && way.cut(time - seconds)) changed = true;
  }
  if (changed) gone.value++;
  return changed;
}

function tipOf(node: string): Point | undefined {
  const at = states.peek().get(node)?.worldTTcp?.position;
  return at && [at.x, at.y, at.z];
}

hearers.structure.add((renamed: Renamed) => {
  for (const [from, to] of renamed) {
    const way = ways.get(from);
    if (!way) continue;
    ways.delete(from);
    ways.set(to, way);
    setTrace(from, { node: to });
  }
});
