// Where fingertips were before they pinched: a pinch takes the tip of the index finger centimeters away from what it touches.
import { Vector3 } from "three";
import type { Hand } from "./hands";

/** What counts is the middle of where a tip was from so long (ms) to so long before, while it was no farther (m) than that from there. */
const FROM_MS = 700, UNTIL_MS = 300, STILL_METERS = 0.01;
/** A pinch takes the tip no farther (m) away: else the hand went elsewhere since. */
const PINCH_METERS = 0.12;

export class Fingertips {
  #trails = new Map<XRInputSource, { time: number; tip: Vector3 }[]>();

  /** Has the hands that are seen at a time (ms); one that is lost begins anew. */
  follow(hands: readonly Hand[], time: number): void {
    this.#trails = new Map(
      hands.flatMap(({ source, tip }) => {
        if (!source.hand || !tip) return [];
        const trail = [...(this.#trails.get(source) ?? []), { time, tip }];
        while (trail.length > 1 && trail[1].time <= time - FROM_MS) trail.shift();
        return [[source, trail] as const];
      }),
    );
  }

  /** Returns what a hand touches as it pinches at a time (ms); undefined where its tip was not still before. A controller's is where it is. */
  touched({ source, tip }: Hand, time: number): Vector3 | undefined {
    if (!source.hand || !tip) return tip;
    const trail = this.#trails.get(source) ?? [], before = trail.filter((one) => one.time <= time - UNTIL_MS);
    if (before.length === 0 || before[0].time > time - FROM_MS) return undefined;
    const middle = before.reduce((sum, one) => sum.add(one.tip), new Vector3()).divideScalar(before.length);
    const wasStill = before.every((one) => one.tip.distanceTo(middle) <= STILL_METERS);
    return wasStill && tip.distanceTo(middle) <= PINCH_METERS ? middle : undefined;
  }
}
