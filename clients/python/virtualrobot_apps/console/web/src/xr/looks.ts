// How a proposal's states look, and what they are called, in the room.
import type { Phase } from "./proposal";

const BLUE = 0x3b9eff, GREEN = 0x35c27b, RED = 0xe5393f, AMBER = 0xf0a92c, GREY = 0x8a96a5;

export const COLORS: Record<Phase, number> = {
  idle: GREY, asking: BLUE, planning: BLUE, free: GREEN, refused: RED, running: BLUE, paused: AMBER, done: GREEN,
};

export const TITLES: Record<Phase, string> = {
  idle: "Take the ball at the tool", asking: "Where to?", planning: "Planning", free: "Hold to run", refused: "Not so",
  running: "Running", paused: "Paused: hold to go on", done: "There",
};

/** Returns a color as canvases take it. */
export function cssOf(color: number): string {
  return `#${color.toString(16).padStart(6, "0")}`;
}
