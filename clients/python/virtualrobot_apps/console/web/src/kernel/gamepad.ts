// A gamepad as the browser tells it, in the standard layout, by the names that mappings have for its axes and buttons.
import type { State } from "./devices";

const AXES = ["left_x", "left_y", "right_x", "right_y"];
const TRIGGERS: Readonly<Record<number, string>> = { 6: "left_trigger", 7: "right_trigger" };
const BUTTONS = [
  "a", "b", "x", "y", "left_shoulder", "right_shoulder", "", "", "back", "start", "left_stick", "right_stick",
  "dpad_up", "dpad_down", "dpad_left", "dpad_right", "guide",
];

/** Returns how the first gamepad in the standard layout is; undefined without one. */
export function readPad(): State | undefined {
  const pad = [...navigator.getGamepads()].find((one) => one?.connected && one.mapping === "standard");
  if (!pad) return undefined;
  const axes = Object.fromEntries(AXES.map((name, place) => [name, pad.axes[place] ?? 0]));
  for (const [place, name] of Object.entries(TRIGGERS)) axes[name] = pad.buttons[Number(place)]?.value ?? 0;
  return { name: pad.id, axes, buttons: new Set(BUTTONS.filter((name, place) => name && pad.buttons[place]?.pressed)) };
}
