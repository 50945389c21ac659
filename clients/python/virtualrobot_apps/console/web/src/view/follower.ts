// A view that goes along with a node, so that this stays where it is in the picture.
import { effect, signal } from "@preact/signals";
import { Matrix4, Vector3 } from "three";
import { hearers } from "../kernel/world";
import type { Observer } from "./observer";

/** The node that the view goes along with, and whether it turns with it, as a camera that is mounted on it. */
export const followed = signal<{ node: string; turns: boolean } | undefined>(undefined);

export class Follower {
  #before: Matrix4 | undefined;

  constructor() {
    effect(() => {
      void followed.value;
      this.#before = undefined;
    });
    hearers.structure.add((renamed) => {
      const now = followed.peek();
      const node = now && renamed.get(now.node);
      if (now && node) followed.value = { ...now, node };
    });
  }

  /** Carries an observer by what the node has moved since the last time. */
  advance(observer: Observer, places: ReadonlyMap<string, Matrix4>): void {
    const { node, turns } = followed.peek() ?? {};
    const place = node === undefined ? undefined : places.get(node);
    if (!place || this.#before?.equals(place)) return;
    if (this.#before) observer.carry(turns ? place.clone().multiply(this.#before.clone().invert()) : shift(this.#before, place));
    this.#before = place.clone();
  }
}

function shift(before: Matrix4, now: Matrix4): Matrix4 {
  const way = new Vector3().setFromMatrixPosition(now).sub(new Vector3().setFromMatrixPosition(before));
  return new Matrix4().makeTranslation(way);
}
