// Features that are pointed at: corners, edges, holes, faces. What the pointer is at lights up, and a click or a touch gives it.
import { Matrix3, Matrix4, Vector3, type BufferGeometry } from "three";
import type { Aim } from "./aiming";
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

const NEAR_PIXELS = 11, AXIS_NEAR_PIXELS = 7;
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

/** Returns who takes features: those that `find` finds light up, and a click gives one, or nothing, to `take`. */
export function featureAim<One extends Found>(find: (view: Viewport, pointer: Pointer) => One | undefined, take: (found: One | undefined, view: Viewport, pointer: Pointer) => void, left?: () => void): Aim {
  const show = (view: Viewport, found: Found | undefined) => {
    const place = found && view.solids.places.get(found.node);
    showSpans("pointed", place ? drawn(moved(found.feature, place), (at) => metersOf(view, at)) : []);
  };
  return {
    over: (view, pointer) => show(view, pointer && find(view, pointer)),
    click: (view, pointer) => take(find(view, pointer), view, pointer),
    left,
  };
}

/** Returns the feature that the pointer is at; undefined where it is at no node. */
export function featureAt(view: Viewport, pointer: Pointer): Found | undefined {
  const met = metAt(view, pointer);
  if (!met) return undefined;
  const { node, point, normal, surface, triangle, pixel } = met, reach = NEAR_PIXELS * pixel;
  const corner = surface?.cornerNear(point, reach);
  const face: Feature = { kind: "face", point, direction: normal };
  return { node, feature: corner ? { kind: "corner", point: corner.clone() } : (surface?.axisAt(triangle, point, reach) ?? face) };
}

/** Returns the place of a face that the pointer is at; undefined where it is at no node. */
export function placeAt(view: Viewport, pointer: Pointer): Found | undefined {
  const met = metAt(view, pointer);
  return met && { node: met.node, feature: { kind: "face", point: met.point, direction: met.normal } };
}

/** Returns the axis that the pointer is at: of an edge, or of the wall of a hole or a pin; undefined for none. */
export function axisAt(view: Viewport, pointer: Pointer): { node: string; feature: Axis } | undefined {
  const met = metAt(view, pointer), axis = met?.surface?.axisAt(met.triangle, met.point, AXIS_NEAR_PIXELS * met.pixel);
  return met && axis && { node: met.node, feature: axis };
}

/** Returns the name of the node that the pointer is at; undefined for none. */
export function nodeAt(view: Viewport, pointer: Pointer): string | undefined {
  return view.solids.hit(pointerRay(view, pointer))?.name;
}

/** What the pointer meets, in its node's frame; without a surface where the mesh is too large to look for edges. */
interface Met {
  node: string;
  point: Vector3;
  normal: Vector3;
  triangle: number;
  surface?: Surface;
  /** Length that is as long as a pixel there, meters. */
  pixel: number;
}

function metAt(view: Viewport, pointer: Pointer): Met | undefined {
  const met = view.solids.hit(pointerRay(view, pointer)), place = met && view.solids.places.get(met.name);
  if (!place) return undefined;
  const { name: node, geometry, local, hit } = met;
  const isLarge = (geometry.index ?? geometry.attributes.position).count > 3 * MOST_TRIANGLES;
  return {
    node, triangle: hit.faceIndex!, pixel: metersOf(view, hit.point),
    point: hit.point.clone().applyMatrix4(place.clone().invert()),
    normal: hit.face!.normal.clone().applyNormalMatrix(new Matrix3().getNormalMatrix(local)),
    surface: isLarge ? undefined : surfaceOf(geometry, local),
  };
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
