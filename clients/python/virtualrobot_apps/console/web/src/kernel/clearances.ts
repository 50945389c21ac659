// Least distances that the picture of all viewers has: measured by the kernel, anew as things move, one question at a time.
import { effect, signal } from "@preact/signals";
import type { Vector3 } from "../generated/virtualrobot/v1/geometry_pb";
import type { Clearance } from "../generated/virtualrobot/v1/view_pb";
import { picture } from "./shared_picture";
import { collisions } from "./services";
import { items, moves } from "./world";

interface Nearest {
  name: string;
  from: Vector3;
  to: Vector3;
  /** Distance (m), less the paddings of both. */
  meters: number;
}

const REST_MS = 100;
let isAsked = false, isDue = false;

/** The nearest points, as they were measured last. */
export const nearest = signal<readonly Nearest[]>([]);

effect(() => {
  void [moves.value, items.value];
  const isWanted = (picture.value?.clearances ?? []).length > 0;
  if (isWanted || nearest.peek().length > 0) void measureAll();
});

async function measureAll(): Promise<void> {
  isDue = true;
  if (isAsked) return;
  isAsked = true;
  while (isDue) {
    isDue = false;
    nearest.value = (await Promise.all((picture.peek()?.clearances ?? []).map(measure))).flat();
    await new Promise((go) => setTimeout(go, REST_MS));
  }
  isAsked = false;
}

async function measure({ name, first, second }: Clearance): Promise<Nearest[]> {
  try {
    const [pair] = (await collisions.measureDistances({ first, second })).pairs;
    return pair?.firstPoint && pair.secondPoint ? [{ name, from: pair.firstPoint, to: pair.secondPoint, meters: pair.distanceMeters }] : [];
  } catch {
    return []; // one of the nodes is gone, which the picture will say, too
  }
}
