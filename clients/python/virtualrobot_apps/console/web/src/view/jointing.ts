// Joints between bodies: an axis is picked by a click at a hole or an edge, and two nodes become links of a robot, or one a further link.
import { create } from "@bufbuild/protobuf";
import { computed, effect, signal } from "@preact/signals";
import { Matrix4, Vector3 } from "three";
import { PoseSchema } from "../generated/virtualrobot/v1/geometry_pb";
import { JointType, type Figure } from "../generated/virtualrobot/v1/nodes_pb";
import { say } from "../kernel/messages";
import { apply, type Commands } from "../kernel/orders";
import { children, items, moves as poses, robotOf, selected, type Item } from "../kernel/world";
import { aim, leave, take } from "./aiming";
import type { Axis } from "./axes";
import { axisAt, featureAim, nodeAt } from "./finding";
import { matrixOf, poseOf } from "./poses";
import { showSpans } from "./spans";
import type { Viewport } from "./viewport";

export type Motion = "turns" | "turns freely" | "slides";

const TYPES: Record<Motion, JointType> = { turns: JointType.REVOLUTE, "turns freely": JointType.CONTINUOUS, slides: JointType.PRISMATIC };
/** How far the axis is drawn beyond what it is of, and the least that is drawn of it. */
const BEYOND = 0.6, LEAST_METERS = 0.06;
const COLOR = "#ffd65c";

/** An axis in the frame of a node that it was picked at. */
export const picked = signal<{ node: string; axis: Axis } | undefined>(undefined);
/** What the joint shall be: which body moves on which, how, and how far (rad or m); the name is that of a device that begins with it. */
export const joint = signal({ moves: "", on: "", motion: "turns" as Motion, name: "" });
export const limits = signal<Record<Motion, readonly [number, number]>>({ turns: [-Math.PI / 2, Math.PI / 2], "turns freely": [0, 0], slides: [-0.1, 0.1] });

/** Whether the body on which the other one moves is of a device already. */
export const grows = computed(() => items.value.get(joint.value.on)?.kind === "link");

/** Takes the axis that is clicked; the body there moves, unless it is a link, on which the selected one moves then. */
const axisAim = featureAim(axisAt, (found, view, pointer) => {
  if (found) {
    takeAxis(found.node, found.feature);
    leave(axisAim);
    return;
  }
  const node = nodeAt(view, pointer);
  say(`${node ? `${node} has no axis there` : "no body is there"}; click at the wall of a hole or a pin, or at an edge`, "warning");
});

/** Whether the next click in the view picks an axis. */
export const picking = computed(() => aim.value === axisAim);

export function togglePicking(): void {
  if (picking.peek()) leave(axisAim);
  else take(axisAim);
}

/** Takes an axis in the frame of a node, as if it had been clicked there. */
export function takeAxis(node: string, axis: Axis): void {
  picked.value = { node, axis };
  const item = items.peek().get(node)!, chosen = selected.peek(), before = joint.peek();
  const other = isBody(items.peek().get(chosen)) && chosen !== node ? chosen : "";
  if (item.kind === "link") joint.value = { ...before, on: node, moves: other || (before.moves === node ? "" : before.moves) };
  else joint.value = { ...before, moves: node, on: other || (before.on === node ? "" : before.on) };
}

/** Turns the picked axis to point the other way. */
export function reverse(): void {
  const now = picked.peek();
  if (now) picked.value = { ...now, axis: { ...now.axis, direction: now.axis.direction.clone().negate() } };
}

export function isBody(item: Item | undefined): boolean {
  return item?.kind === "object" || item?.kind === "part";
}

/** Returns why the joint can't be made yet, as it is told to people; "" where it can. */
export const missing = computed(() => {
  const { moves, on, motion } = joint.value, [lower, upper] = limits.value[motion];
  const mover = items.value.get(moves), base = items.value.get(on);
  if (!picked.value) return "pick an axis: click at the wall of a hole or a pin, or at an edge";
  if (!mover || !isBody(mover)) return moves ? `${moves} is no body: objects and parts become links` : "name the body that moves";
  if (!base || (!isBody(base) && base.kind !== "link")) return on ? `${on} is neither a body nor a link` : "name the body that it moves on";
  if (moves === on) return `${moves} can't move on itself`;
  for (let one = items.value.get(base.parent); one; one = items.value.get(one.parent)) if (one.name === moves) return `${on} hangs on ${moves}: the other one moves on it`;
  if (motion !== "turns freely" && lower >= upper) return "the lower limit is below the upper one";
  return "";
});

/** Makes the joint, as one step of the history: what hangs on the bodies hangs on their links then. */
export async function makeJoint({ solids: { places } }: Viewport): Promise<boolean> {
  const { moves, on, motion } = joint.peek(), now = picked.peek();
  const mover = items.peek().get(moves), base = items.peek().get(on), axisNode = now && places.get(now.node);
  if (missing.peek() || !mover || !base || !axisNode) return false;
  const world = (name: string) => places.get(name)?.clone() ?? new Matrix4();
  const robot = grows.peek() ? robotOf(on) : freeName(joint.peek().name.trim() || "device");
  const baseLink = grows.peek() ? on : `${robot}.${on}`, link = `${robot}.${moves}`;
  // The link's frame is the body's, moved to the axis.
  const moved = world(moves), there = moved.clone().setPosition(now.axis.point.clone().applyMatrix4(axisNode));
  const direction = now.axis.direction.clone().transformDirection(axisNode).transformDirection(moved.clone().invert());
  const [lower, upper] = limits.peek()[motion];
  const bounds = motion === "turns freely" ? {} : { lower, upper };
  const value = { name: moves, type: TYPES[motion], axis: vector(direction), limits: bounds };
  const begins: Commands[] = grows.peek() ? [] : [
    { case: "createNode", value: { node: { name: robot, parent: base.parent, parentTNode: poseIn(world(base.parent), world(on)), kind: { case: "robot", value: {} } } } },
    { case: "createNode", value: { node: { name: baseLink, parent: robot, figures: base.node.figures, kind: { case: "link", value: { joint: { name: on, type: JointType.FIXED } } } } } },
  ];
  const figures = mover.node.figures.map((figure) => movedFigure(figure, there.clone().invert().multiply(moved)));
  const hanging = [[moves, link], ...(grows.peek() ? [] : [[on, baseLink]])].flatMap(([from, to]) => (
    (children.peek().get(from) ?? []).filter(({ name }) => name !== moves).map(({ name }) => ({ case: "attachNode" as const, value: { name, parent: to } }))
  ));
  const done = await apply(
    ...begins,
    { case: "createNode", value: { node: { name: link, parent: baseLink, parentTNode: poseIn(world(on), there), figures, kind: { case: "link", value: { joint: value } } } } },
    ...hanging,
    { case: "removeNode", value: { name: moves } },
    ...(grows.peek() ? [] : [{ case: "removeNode" as const, value: { name: on } }]),
  );
  if (!done) return false;
  say(`${moves} ${motion} on ${on}, as the joint ${moves} of ${robot}`, "good");
  picked.value = undefined;
  joint.value = { ...joint.peek(), moves: "", on: "", name: "" };
  selected.value = robot;
  return true;
}

/** Draws the picked axis into a view from now on. */
export function drawAxis(view: Viewport): void {
  effect(() => {
    void poses.value;
    const now = picked.value, place = now && view.solids.places.get(now.node);
    if (!now || !place) {
      showSpans("axis", []);
      return;
    }
    const { point, direction, radius, length } = now.axis;
    const half = Math.max(LEAST_METERS, length / 2, radius) * (1 + BEYOND);
    const end = (side: number) => point.clone().addScaledVector(direction, side * half).applyMatrix4(place);
    showSpans("axis", [{ from: end(-1), to: end(1), color: COLOR }]);
  });
}

function freeName(wanted: string): string {
  let name = wanted;
  for (let number = 2; items.peek().has(name); number++) name = `${wanted} ${number}`;
  return name;
}

function poseIn(parent: Matrix4, world: Matrix4) {
  return poseOf(parent.clone().invert().multiply(world));
}

function movedFigure(figure: Figure, by: Matrix4): Figure {
  return { ...figure, nodeTFigure: create(PoseSchema, poseOf(by.clone().multiply(matrixOf(figure.nodeTFigure)))) };
}

function vector({ x, y, z }: Vector3) {
  return { x, y, z };
}
