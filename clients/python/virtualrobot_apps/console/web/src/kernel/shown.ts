// Which panel is shown below the view; what comes in by a file shows its own.
import { signal } from "@preact/signals";

export const shownBelow = signal("plot");

/** Which panel is shown on the left. */
export const shownLeft = signal("scene");

/** Which panel is shown on the right. */
export const shownRight = signal("pendant");

/** The menu of a node, where it was asked for in the window; `part` is the link of a robot that was pointed at. */
export interface NodeMenu {
  name: string;
  part: string;
  x: number;
  y: number;
}

export const nodeMenu = signal<NodeMenu | undefined>(undefined);

export type SignalsPart = "values" | "connections" | "timing";

/** Which part of the panel of signals is shown. */
export const signalsPart = signal<SignalsPart>("values");

/** Which panel is open over the view, if any. */
export const opened = signal<"" | Panel>("");

export type Panel = "speeds" | "films" | "devices" | "measuring";

export function toggle(panel: Panel): void {
  opened.value = opened.value === panel ? "" : panel;
}
