// A gamepad as the browser tells it, in the standard layout: nothing is driven unless the right shoulder button is held.
import { hold, release, type Twist } from "./drive";

const SOURCE = "gamepad";
const HOLD = 5;
const PAD_LEFT = 14, PAD_RIGHT = 15;
const LEFT_Y = 1, RIGHT_X = 2;
const DEAD_ZONE = 0.15;

export interface PadLike {
  id: string;
  mapping: string;
  axes: readonly number[];
  buttons: readonly { pressed: boolean }[];
}

/** Returns the first gamepad in the standard layout. */
export function firstPad(): PadLike | undefined {
  return [...navigator.getGamepads()].find((pad) => pad?.connected && pad.mapping === "standard") ?? undefined;
}

/** Drives a craft as the gamepad says now, and returns its name, "" without one; a gamepad that has gone lets go. */
export function drivePad(craft: string): string {
  const pad = document.hidden ? undefined : firstPad();
  if (pad?.buttons[HOLD]?.pressed) hold(craft, SOURCE, parts(pad));
  else release(SOURCE);
  return pad?.id ?? "";
}

export function releasePad(): void {
  release(SOURCE);
}

function parts({ axes, buttons }: PadLike): Twist {
  const left = Number(buttons[PAD_LEFT]?.pressed ?? false) - Number(buttons[PAD_RIGHT]?.pressed ?? false);
  return [-beyond(axes[LEFT_Y]), left, -beyond(axes[RIGHT_X])];
}

/** Returns how far a stick is beyond its dead zone, from there to its end 0 to 1. */
function beyond(moved = 0): number {
  const way = Math.max(0, Math.min(1, (Math.abs(moved) - DEAD_ZONE) / (1 - DEAD_ZONE)));
  return Math.sign(moved) * way;
}
