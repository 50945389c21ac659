// Where a robot, and what hangs on it, would be in other postures than now; and ghosts of a whole motion.
import { effect, signal } from "@preact/signals";
import { Matrix4 } from "three";
import { ofArray } from "../kernel/arrays";
import type { Goal } from "../kernel/goal";
import { attempt } from "../kernel/messages";
import { robots } from "../kernel/services";
import { below, items } from "../kernel/world";
import { Ghost } from "./copies";
import { readRow } from "./poses";
import type { Viewport } from "./viewport";

const COLOR = 0x38bdf8;
const OPACITY = 0.14;
/** Ghosts of a motion at most: each is all of a robot. */
const MOST = 16;

/** Postures that are shown together, one ghost each. */
export const swept = signal<readonly Goal[]>([]);

/** Returns so many postures of a motion, evenly chosen, the last among them. */
export function evenly(postures: readonly Goal[]): Goal[] {
  if (postures.length <= MOST) return [...postures];
  return Array.from({ length: MOST }, (_, number) => postures[Math.round((number * (postures.length - 1)) / (MOST - 1))]);
}

/** Asks where nodes of a robot would be in a posture; undefined where the kernel doesn't say. */
export async function placesIn({ solids }: Viewport, { robot, jointPositions }: Goal): Promise<Map<string, Matrix4> | undefined> {
  const said = await attempt(robots.solveForward({ robot, jointPositions }));
  if (said?.worldTLink === undefined) return undefined;
  const rows = ofArray(said.worldTLink);
  const links = new Map(said.links.map((name, place) => [name, readRow(rows, place, new Matrix4())]));
  const there = new Map<string, Matrix4>();
  for (const name of below(robot)) {
    let link = name;
    while (link && !links.has(link)) link = items.peek().get(link)?.parent ?? "";
    const now = solids.places.get(name), linkNow = solids.places.get(link), linkThere = links.get(link);
    if (now && linkNow && linkThere) there.set(name, linkThere.clone().multiply(linkNow.clone().invert()).multiply(now));
  }
  return there;
}

/** Has a view show ghosts of what is swept, from now on. */
export function drawSwept(view: Viewport): void {
  let number = 0;
  const shown: Ghost[] = [];
  const show = async (goals: readonly Goal[]) => {
    const mine = ++number;
    for (const ghost of shown.splice(0)) view.overlay.remove(ghost.group);
    view.invalidate();
    for (const goal of goals) {
      const there = await placesIn(view, goal);
      if (mine !== number) return;
      if (!there) continue;
      const ghost = new Ghost(COLOR, OPACITY);
      ghost.show(there, view.solids.pieces, view.solids.places);
      view.overlay.add(ghost.group);
      shown.push(ghost);
      view.invalidate();
    }
  };
  effect(() => void show(swept.value));
}
