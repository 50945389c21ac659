// Numbers for people: units of the cell's floor for lengths (mm) and degrees for angles.
import type { MessageInitShape } from "@bufbuild/protobuf";
import type { PoseSchema, Quaternion } from "../generated/virtualrobot/v1/geometry_pb";
import { JointType } from "../generated/virtualrobot/v1/nodes_pb";

export const DEGREES = 180 / Math.PI;

export type AnyPose = MessageInitShape<typeof PoseSchema>;
export type Rotation = Pick<Quaternion, "x" | "y" | "z" | "w">;

export const UNTURNED: Rotation = { x: 0, y: 0, z: 0, w: 1 };

/** Returns factor and unit by which a joint's value is shown. */
export function unitOf(type: JointType): { factor: number; unit: string } {
  return type === JointType.PRISMATIC ? { factor: 1000, unit: "mm" } : { factor: DEGREES, unit: "°" };
}

/** Returns a number with so many decimals, and never -0. */
export function fixed(value: number, decimals: number): string {
  const text = value.toFixed(decimals);
  return Number(text) === 0 ? text.replace("-", "") : text;
}

/** Reads a number as people write it, with a comma or a point; undefined where it is none. */
export function read(text: string): number | undefined {
  const trimmed = text.trim().replace(",", ".");
  const value = Number(trimmed);
  return trimmed === "" || !Number.isFinite(value) ? undefined : value;
}

/** Returns why a text is no number, and what would be one; "" where it is one. */
export function whyNot(text: string): string {
  if (read(text) !== undefined) return "";
  if (text.trim() === "") return "Write a number";
  const meant = /^-?\d{1,3}(?:[.' ]\d{3})+,\d+$/.test(text.trim()) ? text.replace(/[.' ]/g, "") : /^-?\d{1,3}(?:[,' ]\d{3})+\.\d+$/.test(text.trim()) ? text.replace(/[,' ]/g, "") : "";
  return meant ? `“${text}”: write ${read(meant)}, without signs between thousands` : `“${text}” is no number: such as 12.5 or 12,5`;
}

const LEAST_ANGLE = 1e-6 - Math.PI;

/** Returns the angles about the fixed axes x, y and z, in this order (roll, pitch, yaw), in radians; half a turn is positive. */
export function rollPitchYaw({ x, y, z, w }: Rotation): [number, number, number] {
  const pitch = Math.asin(Math.max(-1, Math.min(1, 2 * (w * y - z * x))));
  const roll = Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)), yaw = Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
  return [roll < LEAST_ANGLE ? -roll : roll, pitch, yaw < LEAST_ANGLE ? -yaw : yaw];
}

/** Returns the rotation of `rollPitchYaw`'s angles. */
export function ofRollPitchYaw(roll: number, pitch: number, yaw: number): Rotation {
  const [cr, sr, cp, sp, cy, sy] = [roll, pitch, yaw].flatMap((angle) => [Math.cos(angle / 2), Math.sin(angle / 2)]);
  return {
    x: sr * cp * cy - cr * sp * sy,
    y: cr * sp * cy + sr * cp * sy,
    z: cr * cp * sy - sr * sp * cy,
    w: cr * cp * cy + sr * sp * sy,
  };
}

/** Returns axis times angle, in radians. */
export function rotationVector({ x, y, z, w }: Rotation): [number, number, number] {
  const sign = w < 0 ? -1 : 1;
  const sine = Math.hypot(x, y, z);
  const factor = sine < 1e-12 ? 2 : (2 * Math.atan2(sine, sign * w)) / sine;
  return [sign * x * factor, sign * y * factor, sign * z * factor];
}

export function positionOf(pose?: AnyPose): [number, number, number] {
  return [pose?.position?.x ?? 0, pose?.position?.y ?? 0, pose?.position?.z ?? 0];
}

export function orientationOf(pose?: AnyPose): Rotation {
  const { x = 0, y = 0, z = 0, w = 0 } = pose?.orientation ?? UNTURNED;
  return { x, y, z, w };
}
