// Simple things that people add: tables, boxes, cylinders and balls, each by how large it is and where it stands; cameras and
// range sensors, by where they are and what they look at.
import { create } from "@bufbuild/protobuf";
import { FigureSchema, MaterialSchema, NodeSchema, PartSchema, SceneObjectSchema, type Figure } from "../generated/virtualrobot/v1/nodes_pb";
import type { AnyPose } from "../parts/numbers";
import { watched } from "./camera_picture";
import { say } from "./messages";
import { apply } from "./orders";
import { items, selected } from "./world";

type Triple = readonly [number, number, number];
export type Shape = "table" | "box" | "cylinder" | "ball";
export type Sensor = "camera" | "range sensor";

/** What is to be added; lengths in meters. */
export interface Body {
  shape: Shape;
  name: string;
  /** Edges of a table or a box; diameter and height of a cylinder; diameter of a ball. */
  size: readonly number[];
  /** Where the middle of its underside is in the world. */
  stands: Triple;
  /** Whether robots handle it, and its mass in kilograms; 0 is unknown. */
  part: boolean;
  mass: number;
}

/** Edges (m) of what tables are made of, as `virtualrobot add table` has them. */
const TOP = 0.04, LEG = 0.06;
const COLORS = { table: [0.72, 0.66, 0.58], part: [0.79, 0.6, 0.38], object: [0.6, 0.64, 0.69] } as const;

/** Adds it, and selects it; returns whether that was done. */
export async function add({ shape, name, size, stands: [x, y, z], part, mass }: Body): Promise<boolean> {
  const [red, green, blue] = COLORS[shape === "table" ? "table" : part ? "part" : "object"];
  const figures = figuresOf(shape, size);
  for (const one of figures) one.material = create(MaterialSchema, { color: { red, green, blue } });
  // A table's origin is on the floor, that of anything else in its middle.
  const up = shape === "table" ? 0 : size.at(-1)! / 2;
  const parentTNode = { position: { x, y, z: z + up }, orientation: { x: 0, y: 0, z: 0, w: 1 } };
  const node = create(NodeSchema, { name, parentTNode });
  node.figures = figures;
  node.kind = part ? { case: "part", value: create(PartSchema, { massKilograms: mass }) } : { case: "object", value: create(SceneObjectSchema) };
  const done = await apply({ case: "createNode", value: { node } });
  if (done) {
    say(`${name} is here`, "good");
    selected.value = name;
  }
  return done;
}

/** Adds a camera, whose picture is shown then, or a range sensor of one beam, as the kernel has them by itself; and selects it. */
export async function addSensor(sensor: Sensor, name: string, parentTNode: AnyPose): Promise<boolean> {
  const kind = sensor === "camera" ? { case: "cameraSensor" as const, value: {} } : { case: "rangeSensor" as const, value: { running: true } };
  const done = await apply({ case: "createNode", value: { node: { name, parentTNode, kind } } });
  if (!done) return false;
  say(`${name} is here`, "good");
  selected.value = name;
  if (sensor === "camera") watched.value = name;
  return true;
}

/** Returns a name that nothing has. */
export function freeName(shape: Shape | Sensor): string {
  let name: string = shape;
  for (let number = 2; items.value.has(name); number++) name = `${shape} ${number}`;
  return name;
}

function figuresOf(shape: Shape, size: readonly number[]): Figure[] {
  const [first, second, third] = size;
  if (shape === "ball") return [create(FigureSchema, { geometry: { case: "sphere", value: { radiusMeters: first / 2 } } })];
  if (shape === "cylinder") return [create(FigureSchema, { geometry: { case: "cylinder", value: { radiusMeters: first / 2, lengthMeters: second } } })];
  if (shape === "box") return [boxOf([first, second, third])];
  if (Math.min(first, second) <= 2 * LEG || third <= TOP) return [boxOf([first, second, third], [0, 0, third / 2])];
  const below = third - TOP;
  const legs = [[-1, -1], [-1, 1], [1, -1], [1, 1]].map(([x, y]) => boxOf([LEG, LEG, below], [(x * (first - LEG)) / 2, (y * (second - LEG)) / 2, below / 2]));
  return [boxOf([first, second, TOP], [0, 0, third - TOP / 2]), ...legs];
}

function boxOf([x, y, z]: Triple, at: Triple = [0, 0, 0]): Figure {
  const position = { x: at[0], y: at[1], z: at[2] };
  return create(FigureSchema, { geometry: { case: "box", value: { size: { x, y, z } } }, nodeTFigure: { position, orientation: { x: 0, y: 0, z: 0, w: 1 } } });
}
