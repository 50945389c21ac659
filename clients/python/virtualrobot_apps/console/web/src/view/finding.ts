// Features that are pointed at: a panel asks for one, what the pointer is at lights up, and a click or a touch gives it.
import { effect, signal } from "@preact/signals";
import { Matrix3, Matrix4, Vector3, type BufferGeometry } from "three";
import { Surface, type Axis } from "./axes";
import { pointerRay, type Pointer } from "./pointing";
import { showSpans, type Span } from "./spans";
import type { Viewport } from "./viewport";

/** Something by which a body is measured. */
export interface Feature {
  kind: Axis["kind"] | "corner" | "face";
  /** The corner; the middle of an edge, a circle or an axis; the point of a face that was pointed at. */
  point: Vector3;
  /** Along a straight edge or an axis, or a face's normal; a corner has none. */
  direction?: Vector3;
  /** Of holes, pins and round edges, meters. */
  radius?: number;
  /** Of straight edges, holes and pins, meters. */
  length?: number;
}

/** A feature of a node, in the node's frame. */
export interface Found {
  node: string;
  feature: Feature;
}

/** Who wants a feature, and takes it; undefined: clicks select. */
export const asked = signal<((found: Found) => void) | undefined>(undefined);

const CLICK_PIXELS = 4;
const NEAR_PIXELS = 11;
const COLOR = "#ffd65c";
/** Of larger meshes faces alone are found. */
const MOST_TRIANGLES = 100_000;
const CHORDS = 48;
const MARK_PIXELS = 9;
const AXIS_PIXELS = 60;

const surfaces = new WeakMap<BufferGeometry, Map<string, Surface>>();

/** Returns a feature in the frame that a pose leads to. */
export function moved({ point, direction, ...rest }: Feature, pose: Matrix4): Feature {
  return { ...rest, point: point.clone().applyMatrix4(pose), direction: direction?.clone().transformDirection(pose) };
}

/** Has a view light up and give features while somebody asks for one, from now on. */
export function findFeatures(view: Viewport): void {
  let down: PointerEvent | undefined;
  const show = (found: Found | undefined) => {
    const place = found && view.solids.places.get(found.node);
    showSpans("pointed", place ? drawn(moved(found.feature, place), (at) => metersOf(view, at)) : []);
  };
  view.canvas.addEventListener("pointermove", (event) => asked.peek() && event.buttons === 0 && show(featureAt(view, event)));
  view.canvas.addEventListener("pointerleave", () => show(undefined));
  view.canvas.addEventListener("pointerdown", (event) => (down = event));
  view.canvas.addEventListener("click", (event) => {
    const still = down && Math.hypot(event.clientX - down.clientX, event.clientY - down.clientY) < CLICK_PIXELS;
    const found = asked.peek() && still ? featureAt(view, event) : undefined;
    if (found) asked.peek()!(found);
  });
  effect(() => {
    view.canvas.style.cursor = asked.value ? "crosshair" : "";
    if (!asked.value) show(undefined);
  });
}

/** Returns the feature that the pointer is at; undefined where it is at no node. */
export function featureAt(view: Viewport, pointer: Pointer): Found | undefined {
  const met = view.solids.hit(pointerRay(view, pointer)), place = met && view.solids.places.get(met.name);
  if (!place) return undefined;
  const { name: node, geometry, local, hit } = met;
  const point = hit.point.clone().applyMatrix4(place.clone().invert());
  const face = { kind: "face" as const, point, direction: hit.face!.normal.clone().applyNormalMatrix(new Matrix3().getNormalMatrix(local)) };
  if ((geometry.index ?? geometry.attributes.position).count > 3 * MOST_TRIANGLES) return { node, feature: face };
  const surface = surfaceOf(geometry, local), reach = NEAR_PIXELS * metersOf(view, hit.point);
  const corner = surface.cornerNear(point, reach);
  return { node, feature: corner ? { kind: "corner", point: corner.clone() } : (surface.axisAt(hit.faceIndex!, point, reach) ?? face) };
}

function surfaceOf(geometry: BufferGeometry, local: Matrix4): Surface {
  const known = surfaces.get(geometry) ?? new Map<string, Surface>();
  surfaces.set(geometry, known);
  const key = local.elements.join();
  let surface = known.get(key);
  if (!surface) known.set(key, (surface = new Surface([{ geometry, local }])));
  return surface;
}

/** Returns how long what is as long as a pixel in the picture is at a point of the world. */
function metersOf({ observer, canvas }: Viewport, at: Vector3): number {
  const { camera } = observer;
  return (2 * camera.position.distanceTo(at) * Math.tan((camera.fov * Math.PI) / 360)) / canvas.clientHeight;
}

/** Returns the lines by which a feature is shown, in the world; `metersOf` tells the length of a pixel. */
export function drawn({ kind, point, direction, radius = 0, length = 0 }: Feature, metersOf: (at: Vector3) => number): Span[] {
  const line = (from: Vector3, to: Vector3): Span => ({ from, to, color: COLOR });
  const through = (along: Vector3, half: number) => line(point.clone().addScaledVector(along, -half), point.clone().addScaledVector(along, half));
  const pixel = metersOf(point), mark = MARK_PIXELS * pixel;
  const cross = [new Vector3(1, 0, 0), new Vector3(0, 1, 0), new Vector3(0, 0, 1)].map((along) => through(along, mark));
  if (!direction) return cross;
  if (kind === "straight edge") return [...cross, through(direction, Math.max(length / 2, mark))];
  const [one, other] = across(direction);
  if (kind === "face") return [line(point, point.clone().addScaledVector(direction, AXIS_PIXELS * pixel)), through(one, mark), through(other, mark)];
  const at = (chord: number) => {
    const angle = (2 * Math.PI * chord) / CHORDS;
    return point.clone().addScaledVector(one, radius * Math.cos(angle)).addScaledVector(other, radius * Math.sin(angle));
  };
  return [through(direction, Math.max(AXIS_PIXELS * pixel, length / 2)), ...Array.from({ length: CHORDS }, (_, chord) => line(at(chord), at(chord + 1)))];
}

/** Returns two directions that are square to one and to each other. */
function across(direction: Vector3): [Vector3, Vector3] {
  const least = Math.abs(direction.z) < 0.9 ? new Vector3(0, 0, 1) : new Vector3(1, 0, 0);
  const one = least.cross(direction).normalize();
  return [one, direction.clone().cross(one)];
}
