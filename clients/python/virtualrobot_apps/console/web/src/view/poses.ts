// Poses of the contract as matrices.
import { Matrix4, Quaternion, Vector3 } from "three";
import { orientationOf, positionOf, type AnyPose } from "../parts/numbers";

const ONE = new Vector3(1, 1, 1);
const STRAIGHT = 1e-6;
const position = new Vector3(), orientation = new Quaternion();

export function matrixOf(pose?: AnyPose): Matrix4 {
  const { x, y, z, w } = orientationOf(pose);
  return new Matrix4().compose(position.set(...positionOf(pose)), orientation.set(x, y, z, w), ONE);
}

export function poseOf(matrix: Matrix4): AnyPose {
  matrix.decompose(position, orientation, new Vector3());
  const { x, y, z, w } = orientation;
  return { position: { x: position.x, y: position.y, z: position.z }, orientation: { x, y, z, w } };
}

/** Writes row `place` of poses, x, y, z and a quaternion each, to a matrix. */
export function readRow(rows: Float64Array, place: number, matrix: Matrix4): Matrix4 {
  const at = 7 * place;
  position.set(rows[at], rows[at + 1], rows[at + 2]);
  orientation.set(rows[at + 3], rows[at + 4], rows[at + 5], rows[at + 6]);
  return matrix.compose(position, orientation, ONE);
}

/** Returns the pose of what is at a point and looks at another one along its z, as cameras do with y down, or along its x, as beams go with z up. */
export function lookingAt(from: readonly number[], to: readonly number[], axis: "z" | "x"): AnyPose {
  const ahead = new Vector3().fromArray([...to]).sub(new Vector3().fromArray([...from])).normalize();
  // Straight up or down the picture's upper edge is along y.
  const up = Math.hypot(ahead.x, ahead.y) < STRAIGHT ? new Vector3(0, 1, 0) : new Vector3(0, 0, 1);
  const right = ahead.clone().cross(up).normalize();
  const over = right.clone().cross(ahead);
  const matrix = new Matrix4();
  if (axis === "z") matrix.makeBasis(right, over.negate(), ahead);
  else matrix.makeBasis(ahead, right.negate(), over);
  return poseOf(matrix.setPosition(from[0], from[1], from[2]));
}
