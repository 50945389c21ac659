// Coats: what processes leave on nodes, as triangles with a value at each corner; values come ten times a second at most.
import { signal } from "@preact/signals";
import type { Coat, WatchCoatsResponse } from "../generated/virtualrobot/v1/view_pb";

/** A coat and its values, of which some change by and by: `changed` counts how often. */
export interface Worn {
  coat: Coat;
  values: Uint8Array;
  changed: number;
}

export const coats = signal<ReadonlyMap<string, Worn>>(new Map());

/** Takes what the kernel tells; `first` says that all is told anew. */
export function takeCoats(said: WatchCoatsResponse, first: boolean): void {
  const next = new Map(first ? [] : coats.peek());
  for (const name of said.removedNames) next.delete(name);
  for (const coat of said.coats) next.set(coat.name, { coat, values: coat.values.slice(), changed: 0 });
  for (const { name, first: row, values } of said.values) {
    const worn = next.get(name);
    if (!worn) continue;
    worn.values.set(values, row);
    next.set(name, { ...worn, changed: worn.changed + 1 });
  }
  coats.value = next;
}
