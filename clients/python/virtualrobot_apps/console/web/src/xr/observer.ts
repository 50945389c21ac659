// How a person in the room sees the cell: settings of display and observer, by the names that the file of walls has for them.
import { signal } from "@preact/signals";
import { MathUtils } from "three";

export interface Settings {
  /** Distances (m) from an eye before and behind which nothing is seen. */
  near: number;
  far: number;
  /** The saved view from which the cell is entered; "" for a place before the chosen robot. */
  pose: string;
  /** Height (m) of the eyes over the floor when virtual reality is entered, as for who sits; 0 for their own. */
  height: number;
  /** By which the stick walks, m/s. */
  speed: number;
}

const USUAL: Settings = { near: 0.02, far: 200, pose: "", height: 0, speed: 1 };
const BOUNDS = { near: [0.01, 1], far: [2, 1000], height: [0, 10], speed: [0.1, 10] } as const;
const KEY = "virtualrobot-observer";

export const settings = signal<Readonly<Settings>>({ ...USUAL, ...(JSON.parse(localStorage.getItem(KEY) ?? "{}") as Partial<Settings>) });

/** Sets some of them, for this browser; numbers beyond what makes sense are the nearest that does. */
export function change(part: Partial<Settings>): void {
  const next = { ...settings.peek(), ...part };
  for (const [name, [least, most]] of Object.entries(BOUNDS)) {
    const field = name as keyof typeof BOUNDS;
    next[field] = MathUtils.clamp(next[field], least, most);
  }
  settings.value = next;
  localStorage.setItem(KEY, JSON.stringify(next));
}
