// People who stand in the cell with headsets: where the heads of the others are, and the one of this page.
import { signal } from "@preact/signals";
import type { Matrix4 } from "three";
import type { Viewer } from "../generated/virtualrobot/v1/view_pb";
import { poseOf } from "../view/poses";

/** Those of other pages. */
export const viewers = signal<readonly Viewer[]>([]);

/** Shortest time (ms) between two messages, and elements of poses (m, or parts of a turn) that differ by less are the same. */
const PAUSE_MS = 50, SAME = 1e-3;

type Head = { worldTHead?: ReturnType<typeof poseOf>; scale?: number };

let head: Head = {};
let told: Matrix4 | undefined;
let at = 0;
let wake = () => {};

/** Tells the others where the head is in the world, which may have another size; none for a person who has left. */
export function showHead(world_t_head: Matrix4 | undefined, scale = 1): void {
  const now = performance.now(), before = told;
  const isSame = world_t_head === before || (world_t_head && before?.elements.every((value, place) => Math.abs(value - world_t_head.elements[place]) < SAME));
  if (isSame || (world_t_head && now - at < PAUSE_MS)) return;
  at = now;
  told = world_t_head?.clone();
  head = world_t_head ? { worldTHead: poseOf(world_t_head), scale } : {};
  wake();
}

/** Gives the head of this page, and again when it has moved, for ever. */
export async function* heads(): AsyncGenerator<Head> {
  for (;;) {
    const next = new Promise<void>((resolve) => (wake = resolve));
    yield head;
    await next;
  }
}
