// Where cells are looked at from: what this browser keeps under names, and the view of all, which viewers, pictures and films have.
import { signal } from "@preact/signals";
import { attempt, say } from "./messages";
import { views } from "./services";

type Point = [x: number, y: number, z: number];

/** An eye and what it looks at, meters in the world's frame, and the vertical field of view. */
export interface Viewpoint {
  position: Point;
  target: Point;
  fieldDegrees: number;
}

const KEY = "virtualrobot-views";
const DEGREES = 180 / Math.PI;
/** Vertical field of view of a camera that tells none, as the contract has it. */
const FIELD_RADIANS = 0.9;

/** Viewpoints that this browser keeps, for whatever cell it shows, by name. */
export const kept = signal<ReadonlyMap<string, Viewpoint>>(stored());

export function keep(name: string, viewpoint: Viewpoint): void {
  store(new Map(kept.peek()).set(name, viewpoint));
}

export function drop(name: string): void {
  store(new Map([...kept.peek()].filter(([one]) => one !== name)));
}

/** Returns where the kernel's own pictures are taken from; undefined while it frames the world, and where it can't be asked. */
export async function readViewpoint(): Promise<Viewpoint | undefined> {
  try {
    const camera = (await views.getView({})).view?.camera;
    const { position, target } = camera ?? {};
    if (!camera || !position || !target) return undefined;
    const fieldDegrees = DEGREES * (camera.fieldOfViewRadians || FIELD_RADIANS);
    return { position: [position.x, position.y, position.z], target: [target.x, target.y, target.z], fieldDegrees };
  } catch {
    return undefined;
  }
}

/** Has the kernel's viewer, its pictures and films look from here. */
export async function share({ position, target, fieldDegrees }: Viewpoint): Promise<void> {
  const vector = ([x, y, z]: Point) => ({ x, y, z });
  const camera = { position: vector(position), target: vector(target), fieldOfViewRadians: fieldDegrees / DEGREES };
  if (await attempt(views.updateView({ view: { camera }, updateMask: { paths: ["camera"] } }))) say("viewers, pictures and films look from here now", "good");
}

function store(now: ReadonlyMap<string, Viewpoint>): void {
  try {
    localStorage.setItem(KEY, JSON.stringify(Object.fromEntries(now)));
    kept.value = now;
  } catch (error) {
    say(`this browser keeps no views: ${(error as Error).message}`, "error");
  }
}

/** Returns what the browser has kept; what is no view, of whomever it is, is left out. */
function stored(): ReadonlyMap<string, Viewpoint> {
  try {
    const found = JSON.parse(localStorage.getItem(KEY) ?? "{}") as Record<string, unknown>;
    return new Map(Object.entries(found).filter((entry): entry is [string, Viewpoint] => isViewpoint(entry[1])));
  } catch {
    return new Map();
  }
}

function isViewpoint(value: unknown): value is Viewpoint {
  const { position, target, fieldDegrees } = (value ?? {}) as Partial<Viewpoint>;
  const isPoint = (point: unknown) => Array.isArray(point) && point.length === 3 && point.every(Number.isFinite);
  return isPoint(position) && isPoint(target) && Number.isFinite(fieldDegrees);
}
