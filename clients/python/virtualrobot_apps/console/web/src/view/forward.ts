// Where a robot and all that hangs on it would be with other joints, as the kernel tells it.
import { Matrix4 } from "three";
import { ofArray } from "../kernel/arrays";
import type { Goal } from "../kernel/goal";
import { attempt } from "../kernel/messages";
import { robots } from "../kernel/services";
import { below, items } from "../kernel/world";
import { readRow } from "./poses";

/** Returns the poses in the world of a robot's nodes with these joints, by `places`, where they are now; undefined when it is refused. */
export async function placesAt({ robot, jointPositions }: Goal, places: ReadonlyMap<string, Matrix4>): Promise<Map<string, Matrix4> | undefined> {
  const said = await attempt(robots.solveForward({ robot, jointPositions }));
  if (said?.worldTLink === undefined) return undefined;
  const rows = ofArray(said.worldTLink);
  const links = new Map(said.links.map((name, place) => [name, readRow(rows, place, new Matrix4())]));
  const there = new Map<string, Matrix4>();
  for (const name of below(robot)) {
    let link = name;
    while (link && !links.has(link)) link = items.peek().get(link)?.parent ?? "";
    const now = places.get(name), linkNow = places.get(link), linkThere = links.get(link);
    if (now && linkNow && linkThere) there.set(name, linkThere.clone().multiply(linkNow.clone().invert()).multiply(now));
  }
  return there;
}
