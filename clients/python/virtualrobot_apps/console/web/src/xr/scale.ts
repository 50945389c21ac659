// The size in which the cell stands in the room, from a tenth to ten times: by two hands that squeeze and go apart or together,
// or by the panel.
import { signal } from "@preact/signals";
import { Matrix4, Vector3 } from "three";

/** Meters of the world for each of the room. */
export const scale = signal(1);

const LEAST = 0.1, MOST = 10;
const STEPS = [LEAST, 0.2, 0.5, 1, 2, 5, MOST];
/** Hands that are nearer to each other (m) tell no size. */
const APART = 0.02;

/** Returns a size as people say it, such as 1:5. */
export function sizeWords(meters: number): string {
  const told = (value: number) => String(Number(value.toPrecision(2)));
  return meters >= 1 ? `1:${told(meters)}` : `${told(1 / meters)}:1`;
}

/** Returns the next step from a size: what is larger in the room has fewer meters of the world for each of the room. */
export function stepFrom(meters: number, isLarger: boolean): number {
  const found = isLarger ? STEPS.findLast((step) => step < meters - 1e-9) : STEPS.find((step) => step > meters + 1e-9);
  return found ?? meters;
}

export function scaleOf(world_t_room: Matrix4): number {
  return new Vector3().setFromMatrixColumn(world_t_room, 0).length();
}

/** Returns world_t_room in another size, by which a point of the room is at that point of the world. */
export function resized(world_t_room: Matrix4, meters: number, inRoom: Vector3, inWorld: Vector3): Matrix4 {
  const made = world_t_room.clone().scale(new Vector3().setScalar(meters / scaleOf(world_t_room)));
  const shift = inWorld.clone().sub(inRoom.clone().applyMatrix4(made));
  return made.premultiply(new Matrix4().makeTranslation(shift));
}

/** Two hands that hold the room between them. */
export class Stretch {
  #begun?: { apart: number; scale: number; between: Vector3 };

  /** Returns world_t_room as the hands (poses in the room) have it; undefined as long as they hold nothing. */
  follow(grips: readonly Matrix4[], world_t_room: Matrix4): Matrix4 | undefined {
    const [one, other] = grips.map((grip) => new Vector3().setFromMatrixPosition(grip));
    if (!other) return void (this.#begun = undefined);
    const between = one.clone().lerp(other, 0.5), apart = Math.max(one.distanceTo(other), APART);
    this.#begun ??= { apart, scale: scaleOf(world_t_room), between: between.clone().applyMatrix4(world_t_room) };
    const meters = (this.#begun.scale * this.#begun.apart) / apart;
    return resized(world_t_room, Math.min(Math.max(meters, LEAST), MOST), between, this.#begun.between);
  }
}
