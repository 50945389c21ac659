// Driving of a craft while something is held: keys, a button, or the dead man's button of a gamepad. The page sends a twist
// 20 times a second; when none comes for 0.2 s, since it hangs or is gone, the kernel brakes the craft.
import { ConnectError } from "@connectrpc/connect";
import { signal } from "@preact/signals";
import { BusyPolicy, SetpointMode } from "../generated/virtualrobot/v1/motion_pb";
import { say } from "./messages";
import { motions } from "./services";

/** Ahead, to the left and turning to the left: parts of the limits from -1 to 1, or m/s, m/s and rad/s. */
export type Twist = readonly [number, number, number];

export const REST: Twist = [0, 0, 0];

/** Greatest speed (m/s) and turning rate (rad/s), as somebody has set them. */
export const speedLimit = signal(0.3);
export const turnLimit = signal(0.6);

/** Twist that is wanted now: m/s and rad/s. */
export const wanted = signal<Twist>(REST);

const BEAT_MS = 50;
const TIMEOUT_SECONDS = 0.2;

const held = new Map<string, Twist>();
let robot = "";
let drive: Drive | undefined;
/** Whether a drive has ended though something is held: that has to be let go first. */
let spent = false;

/** Holds a source, such as a key, that drives a craft by parts of the limits until it is let go. */
export function hold(craft: string, source: string, parts: Twist): void {
  if (robot !== craft) held.clear();
  robot = craft;
  held.set(source, parts);
  update();
}

/** Lets a source go, or all of them. */
export function release(source?: string): void {
  if (source === undefined) held.clear();
  else if (!held.delete(source)) return;
  update();
}

/** Returns the twist of all that is held, within the limits as they are now. */
function told(): number[] {
  const parts = ([0, 1, 2] as const).map((place) => [...held.values()].reduce((sum, twist) => sum + twist[place], 0));
  const [ahead, left, turn] = parts.map((part) => Math.max(-1, Math.min(1, part)));
  wanted.value = [ahead * speedLimit.value, left * speedLimit.value, turn * turnLimit.value];
  return [...wanted.value];
}

function update(): void {
  told();
  if (drive && (held.size === 0 || drive.robot !== robot)) {
    drive.end();
    drive = undefined;
  }
  if (held.size === 0) spent = false;
  else if (drive) drive.wake();
  else if (!spent) drive = new Drive(robot);
}

class Drive {
  #held = true;
  wake = () => {};

  constructor(readonly robot: string) {
    this.#run()
      .catch((error) => this.#held && say(ConnectError.from(error).rawMessage, "error"))
      .finally(() => {
        this.#held = false;
        if (drive !== this) return;
        drive = undefined;
        spent = held.size > 0;
      });
  }

  /** Ends the stream, at which the craft brakes. */
  end(): void {
    this.#held = false;
    this.wake();
  }

  async #run(): Promise<void> {
    let reason = "";
    for await (const { motion } of motions.streamSetpoints(this.#twists())) reason = motion?.endReason ?? "";
    if (this.#held && reason) say(reason, "warning");
  }

  async *#twists() {
    const target = {
      robot: this.robot,
      mode: SetpointMode.TWIST,
      timeoutSeconds: TIMEOUT_SECONDS,
      busyPolicy: BusyPolicy.PREEMPT,
    };
    yield { target, values: told() };
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
