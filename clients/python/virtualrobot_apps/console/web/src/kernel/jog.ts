// Jogs that run only while a key is held: the motion gets a beat with each picture of the page, and brakes on its path when
// none comes, 0.2 s after the last one.
import type { MessageInitShape } from "@bufbuild/protobuf";
import { signal } from "@preact/signals";
import { BusyPolicy, DisconnectPolicy, type MoveSchema } from "../generated/virtualrobot/v1/motion_pb";
import { HeldMotion } from "./held_motion";
import { say } from "./messages";
import { start } from "./own_motions";
import { eachPicture } from "./pictures";
import { motions } from "./services";
import { forPeople, wordsOf } from "./words";

export type Move = MessageInitShape<typeof MoveSchema>;

const RELEASED = "the key was let go";

/** Part of the greatest speed by which robots are jogged. */
export const jogSpeed = signal(0.3);

let held: Jog | undefined;

/** Begins to jog; what was jogged before is let go. */
export function press(move: Move): void {
  held?.letGo();
  held = new Jog(move);
}

/** Lets go what is jogged, if anything is. */
export function letGo(): void {
  held?.letGo();
  held = undefined;
}

class Jog {
  #held = true;
  #motion?: HeldMotion;
  #rest = () => {};

  constructor(move: Move) {
    this.#run(move).catch((error) => say(wordsOf(error), "error"));
  }

  letGo(): void {
    this.#held = false;
    this.#rest();
    this.#motion?.letGo();
    if (this.#motion) cancel(this.#motion.id);
  }

  async #run(move: Move): Promise<void> {
    const { motion, notes } = await start({
      spec: { moves: [move] },
      busyPolicy: BusyPolicy.PREEMPT,
      onDisconnect: DisconnectPolicy.STOP,
      hold: true,
    });
    const held = new HeldMotion(motion?.id ?? "", (error) => say(wordsOf(error), "error"));
    for (const note of notes) say(forPeople(note.message));
    if (!this.#held) return cancel(held.id);
    this.#motion = held;
    this.#rest = eachPicture(() => held.beat());
  }
}

/** Ends a motion that has been let go. */
function cancel(id: string): void {
  motions.cancelMotion({ id, reason: RELEASED }).catch(() => {}); // it has ended already
}

// Whatever takes the key from the page lets go.
for (const event of ["pointerup", "pointercancel", "blur", "pagehide"]) addEventListener(event, letGo);
document.addEventListener("visibilitychange", () => document.hidden && letGo());
