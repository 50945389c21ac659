// How a proposal's states look, and what they are called, in the room.
import { computed } from "@preact/signals";
import { goal } from "../kernel/goal";
import { connection } from "../kernel/world";
import { proposal, type Phase } from "./proposal";

const BLUE = 0x3b9eff, GREEN = 0x35c27b, RED = 0xe5393f, AMBER = 0xf0a92c, GREY = 0x8a96a5;

interface Look {
  title: string;
  color: number;
}

const LOOKS: Record<Phase, Look> = {
  idle: { title: "Take the ball at the tool", color: GREY },
  asking: { title: "Where to?", color: BLUE },
  planning: { title: "Planning", color: BLUE },
  free: { title: "Hold to run", color: GREEN },
  refused: { title: "Not so", color: RED },
  running: { title: "Running", color: BLUE },
  paused: { title: "Paused: hold to go on", color: AMBER },
  done: { title: "There", color: GREEN },
};

/** How what is proposed looks now, and what that is called. */
export const look = computed<Look>(() => {
  if (connection.value !== "connected") return { title: "No connection", color: RED };
  if (proposal.phase.value === "asking" && goal.reach.value === "unreachable") return { title: "Out of reach", color: RED };
  return LOOKS[proposal.phase.value];
});

/** Returns a color as canvases take it. */
export function cssOf(color: number): string {
  return `#${color.toString(16).padStart(6, "0")}`;
}
