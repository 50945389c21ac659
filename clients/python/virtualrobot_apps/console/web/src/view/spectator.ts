// A second screen for those who stand beside: what somebody in the room sees, from where the head is.
import { effect, signal } from "@preact/signals";
import { viewers } from "../kernel/viewers";
import { matrixOf } from "./poses";
import type { Viewport } from "./viewport";

/** Vertical field of view, degrees. */
const FIELD = 75;

/** The id of whom this page looks with; "" for nobody. */
export const companion = signal("");

/** Has a view go along with the head of the one that was chosen, until this one has left. */
export function followHead(view: Viewport): void {
  let isHeld = false;
  effect(() => {
    const found = viewers.value.find(({ id }) => id === companion.value);
    if (found) view.observer.hold(matrixOf(found.worldTHead), FIELD);
    else if (isHeld) view.observer.release();
    isHeld = found !== undefined;
    if (!found) companion.value = "";
  });
}
