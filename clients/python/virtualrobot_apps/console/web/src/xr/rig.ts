// How the room lies in the world: the room's frame has y up and -z where the headset looked when it began.
import { Euler, Matrix4, Quaternion, Vector3 } from "three";

/** How far ahead of the person the robot stands at first, along the floor. */
export const AHEAD_METERS = 1.5;
const LEAST = 1e-3;

/** Returns the direction in which a pose looks along its -z, on a plane across `up`; undefined where it looks straight up or down. */
function heading(pose: Matrix4, up: Vector3): Vector3 | undefined {
  const ahead = new Vector3(0, 0, -1).transformDirection(pose).projectOnPlane(up);
  return ahead.length() < LEAST ? undefined : ahead.normalize();
}

/**
 * Returns world_t_room: both floors are one, a person whose head has a pose in the room looks into the world as the eye of the
 * page does, and has the robot's base ahead.
 */
export function roomInWorld(room_t_head: Matrix4, world_t_eye: Matrix4, base: Vector3): Matrix4 {
  const there = heading(world_t_eye, new Vector3(0, 0, 1)) ?? new Vector3(0, 1, 0);
  const here = heading(room_t_head, new Vector3(0, 1, 0)) ?? new Vector3(0, 0, -1);
  // With y up turned to z up the room's -z is y.
  const turn = Math.atan2(there.y, there.x) - Math.atan2(-here.z, here.x);
  const rotation = new Quaternion().setFromEuler(new Euler(Math.PI / 2, 0, turn, "ZYX"));
  const head = new Vector3().setFromMatrixPosition(room_t_head).applyQuaternion(rotation);
  const place = base.clone().addScaledVector(there, -AHEAD_METERS).sub(head).setZ(0);
  return new Matrix4().compose(place, rotation, new Vector3(1, 1, 1));
}

/** Returns world_t_room after a person has turned to the left (rad) and then walked along the floor, to the right and ahead (m). */
export function walked(world_t_room: Matrix4, room_t_head: Matrix4, turn: number, right: number, ahead: number): Matrix4 {
  const world_t_head = world_t_room.clone().multiply(room_t_head), head = new Vector3().setFromMatrixPosition(world_t_head);
  const turned = new Matrix4().makeRotationZ(turn), up = new Vector3(0, 0, 1);
  const there = (heading(world_t_head, up) ?? new Vector3(0, 1, 0)).applyMatrix4(turned);
  const way = there.clone().cross(up).multiplyScalar(right).addScaledVector(there, ahead);
  // About the head: away from the world's origin, turned, and back.
  const moved = turned.multiply(new Matrix4().makeTranslation(head.clone().negate())).premultiply(new Matrix4().makeTranslation(head.add(way)));
  return moved.multiply(world_t_room);
}

/** Returns the pose in the room of what hangs before a person: to the right, ahead and up (m) of the head, upright and facing it. */
export function beforeHead(room_t_head: Matrix4, right: number, ahead: number, up: number): Matrix4 {
  const to = heading(room_t_head, new Vector3(0, 1, 0)) ?? new Vector3(0, 0, -1);
  const turn = new Matrix4().makeRotationY(Math.atan2(-to.x, -to.z));
  return turn.setPosition(new Vector3(right, up, -ahead).applyMatrix4(turn).add(new Vector3().setFromMatrixPosition(room_t_head)));
}
