// Jogs that run only while a key is held: the motion gets beats as long as the page is well, and brakes on its path when
// they don't come, 0.2 s after the last one.
import type { MessageInitShape } from "@bufbuild/protobuf";
import { signal } from "@preact/signals";
import { BusyPolicy, DisconnectPolicy, type MoveSchema } from "../generated/virtualrobot/v1/motion_pb";
import { say } from "./messages";
import { start } from "./own_motions";
import { motions } from "./services";
import { forPeople, wordsOf } from "./words";

export type Move = MessageInitShape<typeof MoveSchema>;

const BEAT_MS = 50;
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
  #wake = () => {};

  constructor(move: Move) {
    this.#run(move).catch((error) => say(wordsOf(error), "error"));
  }

  letGo(): void {
    this.#held = false;
    this.#wake();
  }

  async #run(move: Move): Promise<void> {
    const { motion, notes } = await start({
      spec: { moves: [move] },
      busyPolicy: BusyPolicy.PREEMPT,
      onDisconnect: DisconnectPolicy.STOP,
      hold: true,
    });
    const id = motion?.id ?? "";
    for (const note of notes) say(forPeople(note.message));
    try {
      if (this.#held) for await (const _ of motions.holdMotion(this.#beats(id))) continue;
    } finally {
      this.#held = false;
      this.#cancel(id);
    }
  }

  async *#beats(id: string) {
    while (this.#held) {
      yield { id };
      await new Promise<void>((resolve) => {
        this.#wake = resolve;
        setTimeout(resolve, BEAT_MS);
      });
    }
    this.#cancel(id);
  }

  #cancel(id: string): void {
    motions.cancelMotion({ id, reason: RELEASED }).catch(() => {}); // it has ended already
  }
}

// Whatever takes the key from the page lets go.
for (const event of ["pointerup", "pointercancel", "blur", "pagehide"]) addEventListener(event, letGo);
document.addEventListener("visibilitychange", () => document.hidden && letGo());
