// Who takes the clicks in the view in place of selecting, one at a time: what measures, what picks an axis, what places a model.
import { signal } from "@preact/signals";
import type { Pointer } from "./pointing";
import type { Viewport } from "./viewport";

export interface Aim {
  /** Shows what a click would take; without a pointer it shows nothing. */
  over(view: Viewport, pointer: Pointer | undefined): void;
  click(view: Viewport, pointer: Pointer): void;
  /** Is told that it takes clicks no more. */
  left?(): void;
}

/** Who takes clicks; undefined: they select. */
export const aim = signal<Aim | undefined>(undefined);

/** Has clicks taken by one from now on; who took them before is told. */
export function take(one: Aim): void {
  if (aim.peek() === one) return;
  const before = aim.peek();
  aim.value = one;
  before?.left?.();
}

/** Has clicks select again; where one is named, only if it takes them. */
export function leave(one = aim.peek()): void {
  if (!one || aim.peek() !== one) return;
  aim.value = undefined;
  one.left?.();
}
