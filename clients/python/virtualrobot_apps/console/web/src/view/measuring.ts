// What lies between two features: how far their points are apart, what is between their axes or faces, and their angle.
import { Vector3 } from "three";
import type { Feature } from "./finding";

export interface Measured {
  /** From the first point to the second, meters, in the world. */
  between: Vector3;
  /** What is measured squarely, where anything is: its name, and meters. */
  square?: { name: string; meters: number };
  /** Between edges, axes and faces, 0 to 90, degrees. */
  angle?: number;
}

const PARALLEL_DEGREES = 0.05;

/** Returns what is between two features of the world. */
export function measure(first: Feature, second: Feature): Measured {
  const between = second.point.clone().sub(first.point);
  const angle = angleBetween(first, second);
  return { between, angle, square: squarely(first, second, between, angle) };
}

function angleBetween({ kind, direction: one }: Feature, { kind: otherKind, direction: other }: Feature): number | undefined {
  if (!one || !other) return undefined;
  const sine = one.clone().cross(other).length(), cosine = Math.abs(one.dot(other));
  const lines = (Math.atan2(sine, cosine) * 180) / Math.PI;
  // A line and a face: the normal's angle is told from the face.
  return (kind === "face") === (otherKind === "face") ? lines : 90 - lines;
}

function squarely(first: Feature, second: Feature, between: Vector3, angle: number | undefined): Measured["square"] {
  const face = [first, second].find(({ kind }) => kind === "face");
  if (face) {
    if (angle !== undefined && angle > PARALLEL_DEGREES) return undefined;
    const other = face === first ? second : first;
    return { name: other.kind === "face" ? "Between faces" : `${named(other)} to face`, meters: Math.abs(between.dot(face.direction!)) };
  }
  const line = [first, second].find(({ direction }) => direction);
  if (!line || (angle !== undefined && angle > PARALLEL_DEGREES)) return undefined;
  const other = line === first ? second : first;
  const meters = between.clone().projectOnPlane(line.direction!).length();
  return { name: other.direction ? `${named(first)} to ${named(second).toLowerCase()}` : `Point to ${named(line).toLowerCase()}`, meters };
}

function named({ kind }: Feature): string {
  return kind === "corner" ? "Point" : kind === "straight edge" ? "Edge" : "Axis";
}

/** Returns what a feature is, with its size in millimeters. */
export function wordsOf({ kind, radius = 0, length = 0 }: Feature): string {
  const sizes = [...(radius > 0 ? [`Ø ${(2000 * radius).toFixed(2)} mm`] : []), ...(length > 0 ? [`${(1000 * length).toFixed(1)} mm long`] : [])];
  return [kind, sizes.join(", ")].filter(Boolean).join(" ");
}
