// What is said in the room of a proposal, or of what is to be touched, and how that looks.
import { computed } from "@preact/signals";
import { goal } from "../kernel/goal";
import { chosen, connection, trouble } from "../kernel/world";
import { heard } from "./heard";
import { proposal, type Phase } from "./proposal";
import { registration } from "./registration";
import { ledWords, leads } from "./teleop";

const BLUE = 0x3b9eff, GREEN = 0x35c27b, RED = 0xe5393f, AMBER = 0xf0a92c, GREY = 0x8a96a5;

interface Look {
  title: string;
  words: string;
  color: number;
}

const LOOKS: Record<Phase, Omit<Look, "words">> = {
  idle: { title: "Take the ball at the tool", color: GREY },
  asking: { title: "Where to?", color: BLUE },
  planning: { title: "Planning", color: BLUE },
  free: { title: "Hold to run", color: GREEN },
  refused: { title: "Not so", color: RED },
  running: { title: "Running", color: BLUE },
  paused: { title: "Paused: hold to go on", color: AMBER },
  done: { title: "There", color: GREEN },
};

const NO_SESSION = "it has no session here any more: leave the room, and open a new link or code of the console";

/** What is to be said now, and in which color. */
export const look = computed<Look>(() => {
  const words = [heard.value, proposal.words.value].filter(Boolean).join("; "), phase = proposal.phase.value;
  if (connection.value === "refused") return { title: "This page may not come in", words: NO_SESSION, color: RED };
  if (connection.value !== "connected") return { title: "No connection", words: [trouble.value, "trying again"].filter(Boolean).join("; "), color: RED };
  if (registration.next.value) return { title: `Touch ${registration.next.value}`, words: registration.words.value, color: AMBER };
  if (leads.value) return { title: "The ball leads the tool", words: ledWords.value, color: BLUE };
  if (phase === "asking" && goal.reach.value === "unreachable") return { title: "Out of reach", words, color: RED };
  if (phase === "idle") {
    const [idle, how] = chosen.value ? [LOOKS.idle, ""] : [{ ...LOOKS.idle, title: "No robot is chosen" }, "the page's tree has those that there are"];
    return { ...idle, words: [heard.value, registration.words.value || proposal.words.value, how].filter(Boolean).join("; ") };
  }
  return { ...LOOKS[phase], words };
});

/** Returns a color as canvases take it. */
export function cssOf(color: number): string {
  return `#${color.toString(16).padStart(6, "0")}`;
}
