// Setpoints while something is held: keys, buttons, or the dead man's button of a device. The page sends them 20 times a
// second; when none comes for 0.2 s, since it hangs or is gone, the kernel brakes what they lead.
import type { MessageInitShape } from "@bufbuild/protobuf";
import { signal } from "@preact/signals";
import { BusyPolicy, type SetpointTargetSchema } from "../generated/virtualrobot/v1/motion_pb";
import { say } from "./messages";
import { expectMotion } from "./own_motions";
import { motions } from "./services";
import { forPeople, wordsOf } from "./words";

/** Parts of the limits, from -1 to 1. */
export type Parts = readonly number[];

export interface Led {
  target: MessageInitShape<typeof SetpointTargetSchema>;
  /** Returns the setpoint that parts are, in the contract's units, by the limits as they are now. */
  setpoint: (parts: Parts) => number[];
}

/** Setpoint that is sent now, and what keeps a tool slower than that: a joint's name, `singularity`, "" for nothing. */
export const wanted = signal<readonly number[]>([]);
export const heldBy = signal("");

const BEAT_MS = 50;
const TIMEOUT_SECONDS = 0.2;

const held = new Map<string, Parts>();
let led: Led | undefined;
let stream: Stream | undefined;
/** Whether a stream has ended though something is held: that has to be let go first. */
let spent = false;

/** Holds a source, such as a key, that leads something by parts of the limits until it is let go. */
export function hold(what: Led, source: string, parts: Parts): void {
  if (!led || keyOf(led) !== keyOf(what)) held.clear();
  led = what;
  held.set(source, parts);
  update();
}

/** Lets a source go, or all of them. */
export function release(source?: string): void {
  if (source === undefined) held.clear();
  else if (!held.delete(source)) return;
  update();
}

/** Returns the sum of all that is held, within the limits. */
function told(): number[] {
  const all = [...held.values()];
  const sum = (all[0] ?? []).map((_, place) => all.reduce((before, parts) => before + parts[place], 0));
  wanted.value = sum.length ? led!.setpoint(sum.map((part) => Math.max(-1, Math.min(1, part)))) : [];
  return [...wanted.value];
}

function update(): void {
  told();
  if (stream && (held.size === 0 || stream.key !== keyOf(led!))) {
    stream.end();
    stream = undefined;
  }
  if (held.size === 0) spent = false;
  else if (stream) stream.wake();
  else if (!spent) stream = new Stream(led!);
}

function keyOf({ target }: Led): string {
  return JSON.stringify(target);
}

class Stream {
  #held = true;
  readonly key: string;
  wake = () => {};

  constructor(private readonly led: Led) {
    this.key = keyOf(led);
    this.#run()
      .catch((error) => this.#held && say(wordsOf(error), "error"))
      .finally(() => {
        this.#held = false;
        if (stream !== this) return;
        stream = undefined;
        heldBy.value = "";
        spent = held.size > 0;
      });
  }

  /** Ends the stream, at which what it leads comes to rest. */
  end(): void {
    this.#held = false;
    heldBy.value = "";
    this.wake();
  }

  async #run(): Promise<void> {
    let reason = "";
    const tell = expectMotion();
    try {
      for await (const { motion, heldBy: by } of motions.streamSetpoints(this.#setpoints())) {
        tell(motion?.id);
        reason = motion?.endReason ?? "";
        if (this.#held) heldBy.value = by;
      }
    } finally {
      tell();
    }
    if (this.#held && reason) say(forPeople(reason), "warning");
  }

  async *#setpoints() {
    yield { target: { ...this.led.target, timeoutSeconds: TIMEOUT_SECONDS, busyPolicy: BusyPolicy.PREEMPT }, values: told() };
    while (this.#held) {
      await new Promise<void>((resolve) => {
        this.wake = resolve;
        setTimeout(resolve, BEAT_MS);
      });
      if (this.#held) yield { values: told() };
    }
  }
}

// Whatever takes keys and buttons from the page lets go.
for (const event of ["pointercancel", "blur", "pagehide"]) addEventListener(event, () => release());
document.addEventListener("visibilitychange", () => document.hidden && release());
