// Ghosts that the picture of all viewers has: robots in other configurations, on their bases, each ghost in one drawing.
import { toBinary } from "@bufbuild/protobuf";
import { effect, signal } from "@preact/signals";
import { Color, Matrix4, SRGBColorSpace, Vector3 } from "three";
import { JointType } from "../generated/virtualrobot/v1/nodes_pb";
import { GhostSchema, type Ghost } from "../generated/virtualrobot/v1/view_pb";
import { ofArray, rowsOf } from "../kernel/arrays";
import { picture } from "../kernel/shared_picture";
import { below, items, moves, robots } from "../kernel/world";
import { Ghosts } from "../xr/ghosts";
import { placesIn } from "./postures";
import type { Viewport } from "./viewport";

const BLUE = new Color(0x3b9eff), OPACITY = 0.3;
/** Size beside that of the robot, which is seen where both are at one place. */
const SLIM = new Vector3().setScalar(0.985);

interface Shown {
  ghosts: Ghosts;
  robot: string;
  /** Where the base was when the ghost was asked for. */
  base_t_world: Matrix4;
}

/** Draws them into a view from now on; what it returns is to be called when figures have come or gone. */
export function drawGhosts(view: Viewport): () => void {
  const figures = signal(0);
  let shown: Shown[] = [], known = "", number = 0;
  const renew = async (wanted: readonly Ghost[]) => {
    const mine = ++number, next = (await Promise.all(wanted.map((one) => made(view, one)))).filter((one) => one !== undefined);
    if (mine !== number) return next.forEach(({ ghosts }) => ghosts.rebuild([], new Map()));
    for (const { ghosts } of shown) {
      view.overlay.remove(ghosts.group);
      ghosts.rebuild([], new Map());
    }
    shown = next;
    for (const { ghosts } of shown) view.overlay.add(ghosts.group);
    follow(view, shown);
  };
  effect(() => {
    const wanted = picture.value?.ghosts ?? [], now = [figures.value, ...wanted.map((one) => toBinary(GhostSchema, one))].join(" ");
    if (now === known || (wanted.length === 0 && shown.length === 0 && number === 0)) return;
    known = now;
    void renew(wanted);
  });
  effect(() => {
    void moves.value;
    if (shown.length > 0) follow(view, shown);
  });
  return () => void figures.value++;
}

async function made(view: Viewport, { configurations, color, opacity = OPACITY }: Ghost): Promise<Shown | undefined> {
  const { robot = "", jointNames: named = [], positions } = configurations ?? {}, base = view.solids.places.get(robot);
  if (!base || !positions?.shape[1]) return undefined;
  const jointNames = named.length > 0 ? named : (robots.peek().get(robot)?.joints ?? []).flatMap(({ coordinateNames }) => (coordinateNames.length === 1 ? coordinateNames : []));
  const base_t_world = base.clone().invert(), rows = rowsOf(ofArray(positions), positions.shape[1]);
  const asked = rows.map((row) => placesIn(view, { robot, jointPositions: Object.fromEntries(jointNames.map((name, place) => [name, row[place]])) }));
  const moments = (await Promise.all(asked)).filter((one) => one !== undefined);
  if (moments.length === 0) return undefined;
  const ghosts = new Ghosts(moments.length, opacity), nodes = below(robot).filter((name) => isMoved(name, robot));
  const slim = nodes.map((name) => [name, (view.solids.pieces.get(name) ?? []).map((one) => ({ ...one, local: one.local.clone().scale(SLIM) }))] as const);
  ghosts.tint(color ? new Color().setRGB(color.red, color.green, color.blue, SRGBColorSpace) : BLUE);
  ghosts.rebuild(nodes, new Map(slim));
  ghosts.show(moments);
  ghosts.group.matrixAutoUpdate = false;
  return { ghosts, robot, base_t_world };
}

/** Has ghosts go along with their robots' bases. */
function follow(view: Viewport, shown: readonly Shown[]): void {
  for (const { ghosts, robot, base_t_world } of shown) {
    ghosts.group.matrix.copy(view.solids.places.get(robot) ?? new Matrix4()).multiply(base_t_world);
    ghosts.group.matrixWorldNeedsUpdate = true;
  }
  view.invalidate();
}

/** Returns whether a node goes along with a joint of the robot. */
function isMoved(name: string, robot: string): boolean {
  for (let at = name; at && at !== robot; at = items.peek().get(at)?.parent ?? "") {
    const { kind } = items.peek().get(at)?.node ?? {};
    if (kind?.case === "link" && kind.value.joint && kind.value.joint.type !== JointType.FIXED) return true;
  }
  return false;
}
