// Which panel is shown below the view; what comes in by a file shows its own.
import { signal } from "@preact/signals";

export const shownBelow = signal("plot");

export type SignalsPart = "values" | "connections" | "timing";

/** Which part of the panel of signals is shown. */
export const signalsPart = signal<SignalsPart>("values");

/** Which panel is open over the view, if any. */
export const opened = signal<"" | Panel>("");

export type Panel = "speeds" | "films" | "devices";

export function toggle(panel: Panel): void {
  opened.value = opened.value === panel ? "" : panel;
}
