// From where the cell is looked at: viewpoints that are saved in it, and the view of all, which viewers, pictures and films have.
import { computed } from "@preact/signals";
import { Matrix4, Vector3 } from "three";
import { ofArray } from "./arrays";
import { attempt, say } from "./messages";
import { apply } from "./orders";
import { scenes, views } from "./services";
import { items, type Item } from "./world";
import { DEGREES } from "../parts/numbers";
import { lookingAt, matrixOf, poseOf, readRow } from "../view/poses";

type Point = [x: number, y: number, z: number];

/** An eye and what it looks at, meters in the world's frame, and the vertical field of view. */
export interface Viewpoint {
  position: Point;
  target: Point;
  fieldDegrees: number;
}

/** What the contract takes where a camera or a viewpoint tells none. */
const FIELD_RADIANS = 0.9;
const DISTANCE_METERS = 1;

/** The viewpoints of the scene. */
export const kept = computed(() => [...items.value.values()].filter(({ kind }) => kind === "viewpoint"));

/** Saves a viewpoint in the cell under a name, on a parent that it goes along with then; one of this name looks from there. */
export function keep(name: string, viewpoint: Viewpoint, parent: string, world_t_parent: Matrix4): Promise<boolean> {
  const { position, target, fieldDegrees } = viewpoint;
  const world_t_eye = matrixOf(lookingAt(position, target, "z"));
  const parentTNode = poseOf(world_t_parent.clone().invert().multiply(world_t_eye));
  const distanceMeters = new Vector3(...position).distanceTo(new Vector3(...target));
  const kind = { case: "viewpoint" as const, value: { distanceMeters, fieldOfViewRadians: fieldDegrees / DEGREES } };
  if (items.peek().get(name)?.kind !== "viewpoint") return apply({ case: "createNode", value: { node: { name, parent, parentTNode, kind } } });
  return apply(
    { case: "attachNode", value: { name, parent, parentTNode } },
    { case: "updateNode", value: { name, node: { kind }, updateMask: { paths: ["viewpoint"] } } },
  );
}

/** Returns from where a viewpoint of the scene looks, whose place in the world is given. */
export function viewpointOf({ node }: Item, world_t_eye: Matrix4): Viewpoint | undefined {
  if (node.kind.case !== "viewpoint") return undefined;
  const { distanceMeters, fieldOfViewRadians } = node.kind.value;
  const position = new Vector3().setFromMatrixPosition(world_t_eye);
  const target = new Vector3(0, 0, distanceMeters || DISTANCE_METERS).applyMatrix4(world_t_eye);
  return { position: position.toArray(), target: target.toArray(), fieldDegrees: DEGREES * (fieldOfViewRadians || FIELD_RADIANS) };
}

/** The view of all, and the node that it goes along with, if any. */
export interface SharedView {
  viewpoint: Viewpoint;
  along?: { node: string; turns: boolean };
}

/** Returns where the kernel's own pictures are taken from; undefined while it frames the world, and where it can't be asked. */
export async function readViewpoint(): Promise<SharedView | undefined> {
  try {
    const camera = (await views.getView({})).view?.camera;
    if (!camera?.position || !camera.target) return undefined;
    const fieldDegrees = DEGREES * (camera.fieldOfViewRadians || FIELD_RADIANS);
    const { node, keepsDirection } = camera;
    const frame = node ? frameOf(await poseInWorld(node), !keepsDirection) : new Matrix4();
    const [position, target] = [camera.position, camera.target].map(({ x, y, z }) => new Vector3(x, y, z).applyMatrix4(frame).toArray());
    return { viewpoint: { position, target, fieldDegrees }, along: node ? { node, turns: !keepsDirection } : undefined };
  } catch {
    return undefined;
  }
}

/** Has the kernel's viewer, its pictures and films look from here, along with a node where one is given with its place. */
export async function share({ position, target, fieldDegrees }: Viewpoint, along?: { node: string; turns: boolean; place: Matrix4 }): Promise<void> {
  const frame = along ? frameOf(along.place, along.turns).invert() : new Matrix4();
  const vector = (point: Point) => {
    const { x, y, z } = new Vector3(...point).applyMatrix4(frame);
    return { x, y, z };
  };
  const camera = {
    position: vector(position), target: vector(target), fieldOfViewRadians: fieldDegrees / DEGREES,
    node: along?.node ?? "", keepsDirection: along !== undefined && !along.turns,
  };
  if (await attempt(views.updateView({ view: { camera }, updateMask: { paths: ["camera"] } }))) say("viewers, pictures and films look from here now", "good");
}

/** Returns the frame of a node at a place, or of its origin along the world's axes. */
function frameOf(place: Matrix4, turns: boolean): Matrix4 {
  return turns ? place.clone() : new Matrix4().makeTranslation(new Vector3().setFromMatrixPosition(place));
}

async function poseInWorld(name: string): Promise<Matrix4> {
  const { worldTNode } = await scenes.getScene({ names: [name], readMask: { paths: ["name"] } });
  if (!worldTNode) throw new Error(`the kernel told no pose of ${name}`);
  return readRow(ofArray(worldTNode), 0, new Matrix4());
}
