// A motion that a person in the room proposes by hand: asked for, planned and checked by the kernel, shown, and run only while
// it is held, as it was shown.
import { effect, signal } from "@preact/signals";
import { BusyPolicy, DisconnectPolicy, MotionPhase, type PlanMotionResponse, type PlanReference } from "../generated/virtualrobot/v1/motion_pb";
import { ofArray, rowsOf } from "../kernel/arrays";
import { goal } from "../kernel/goal";
import { HeldMotion } from "../kernel/held_motion";
import { attempt } from "../kernel/messages";
import * as orders from "../kernel/orders";
import { start } from "../kernel/own_motions";
import { metadataOf, reasonOf } from "../kernel/page_calls";
import { motions } from "../kernel/services";
import { forPeople, wordsOf } from "../kernel/words";
import { chosen, clock } from "../kernel/world";
import { DEGREES, fixed, type AnyPose } from "../parts/numbers";

export type Phase = "idle" | "asking" | "planning" | "free" | "refused" | "running" | "paused" | "done";

/** Samples of a plan at times (s) from 0, a column for each joint; points of the tool in the world, x, y, z in meters. */
export interface Way {
  robot: string;
  joints: readonly string[];
  times: readonly number[];
  positions: readonly number[][];
  points: readonly number[][];
}

interface Wanted {
  robot: string;
  pose: AnyPose;
}

/** Part of the greatest speed: people are near. */
const SPEED = 0.3;
const SAMPLE_SECONDS = 0.02, NANO = 1e-9;
const RATE_HERTZ = 20;
const REACHED = { meters: 5e-4, radians: 1e-3 };
const REJECTED = "rejected by who proposed it";
const ENDED = new Set<MotionPhase>([MotionPhase.SUCCEEDED, MotionPhase.CANCELLED, MotionPhase.ABORTED]);

class Proposals {
  readonly phase = signal<Phase>("idle");
  /** What there is to say about it, for people. */
  readonly words = signal("");
  readonly way = signal<Way | undefined>(undefined);
  /** The time (s) of the way that is looked at; undefined for the whole of it. */
  readonly moment = signal<number | undefined>(undefined);
  /** Grows with all that makes answers to earlier questions worthless. */
  #number = 0;
  #asked: Promise<void> = Promise.resolve();
  #wanted?: Wanted;
  /** Goals that were let go, the newest last. */
  #before: Wanted[] = [];
  #plan?: PlanReference;
  #motion?: HeldMotion;
  #isPressed = false;
  #note = "";

  constructor() {
    // It is of one robot, as its goal is.
    effect(() => {
      void chosen.value;
      if (!this.isBegun) this.#end("idle", "");
    });
    effect(() => {
      if (this.phase.value === "asking") this.words.value = goal.reach.value === "unreachable" ? away() : "";
    });
  }

  /** Whether a motion has begun and not ended. */
  get isBegun(): boolean {
    return this.phase.peek() === "running" || this.phase.peek() === "paused";
  }

  /** Wants a robot's tool at a pose in the world, as a hand moves it. */
  ask(robot: string, pose: AnyPose): void {
    if (this.isBegun) return;
    this.#number++;
    this.#drop();
    this.#wanted = { robot, pose };
    this.phase.value = "asking";
    this.#asked = goal.ask(robot, pose);
  }

  /** Has the kernel plan and check the way to what is wanted, which nobody moves any more; nothing moves. */
  async letGoal(): Promise<void> {
    if (this.isBegun || !this.#wanted) return;
    this.#before.push(this.#wanted);
    await this.#propose();
  }

  /** Holds what was shown, once in each frame: starts it, and lets it go on. */
  hold(): void {
    if (this.#motion) return this.#motion.beat();
    if (this.#isPressed) return;
    this.#isPressed = true;
    if (this.phase.peek() === "free") void this.#start();
    else if (this.phase.peek() === "refused" && goal.shown.peek()) void this.#propose();
  }

  /** Has it brake on its path. */
  letGo(): void {
    this.#isPressed = false;
    this.#motion?.letGo();
  }

  /** Drops it; where it runs it ends on its path. */
  reject(words = REJECTED): void {
    const id = this.#motion?.id;
    if (id) void attempt(motions.cancelMotion({ id, reason: words }));
    this.#end("idle", this.phase.peek() === "idle" ? "" : words);
  }

  /** Takes the goal back to the one before, or, where none is wanted, the last edit of the cell. */
  async undo(): Promise<void> {
    if (this.isBegun) return;
    if (!this.#before.pop()) return orders.undo();
    const wanted = this.#before.at(-1);
    if (!wanted) return this.reject("taken back");
    this.ask(wanted.robot, wanted.pose);
    await this.#propose();
  }

  /** Looks at a time farther on by a share of the whole way. */
  scrub(share: number): void {
    const way = this.way.peek();
    if (!way || this.isBegun) return;
    const whole = way.times.at(-1)!;
    this.moment.value = Math.min(whole, Math.max(0, (this.moment.peek() ?? whole) + share * whole));
  }

  async #propose(): Promise<void> {
    const number = ++this.#number, isOld = () => number !== this.#number;
    this.#drop();
    await this.#asked;
    if (isOld()) return;
    const shown = goal.shown.peek();
    if (!shown) return this.#refuse(away());
    this.phase.value = "planning";
    this.words.value = this.#note;
    const spec = goal.motion(shown, SPEED);
    try {
      const sampleSeconds = Math.max(SAMPLE_SECONDS, Number(clock.peek()?.tickNanoseconds ?? 0) * NANO);
      const planned = await motions.planMotion({ spec, sampleSeconds });
      if (isOld()) return;
      this.way.value = wayOf(planned, shown.robot);
      const { plan, firstViolation: found, durationSeconds } = await motions.checkMotion({ plan: planned.plan });
      if (isOld()) return;
      this.moment.value = found?.timeSeconds;
      if (!plan) return this.#refuse(found ? forPeople(found.message) : "the kernel keeps no plan of this motion");
      this.#plan = plan;
      this.words.value = [`free, ${fixed(durationSeconds, 1)} s`, this.#note].filter(Boolean).join("; ");
      this.phase.value = "free";
      this.#note = "";
    } catch (error) {
      if (!isOld()) this.#refuse(wordsOf(error));
    }
  }

  /** Starts what was shown, as it was; where the cell is another one since, it is planned and shown anew. */
  async #start(): Promise<void> {
    const number = ++this.#number;
    this.phase.value = "paused";
    this.words.value = "";
    try {
      const { motion } = await start({ plan: this.#plan, hold: true, busyPolicy: BusyPolicy.REJECT, onDisconnect: DisconnectPolicy.STOP });
      const held = new HeldMotion(motion!.id, (error) => (this.words.value = wordsOf(error)));
      if (number !== this.#number) return void attempt(motions.cancelMotion({ id: held.id, reason: REJECTED }));
      this.#motion = held;
      void this.#watch(held);
    } catch (error) {
      if (number !== this.#number) return;
      this.#refuse(wordsOf(error));
      if (reasonOf(error) !== "PLAN_OUTDATED") return;
      this.#note = `shown anew: ${forPeople(metadataOf(error, "changes")).replaceAll("\n", ", ")}`;
      await this.#propose();
    }
  }

  async #watch(held: HeldMotion): Promise<void> {
    try {
      for await (const { motion } of motions.watchMotion({ id: held.id, maxRateHertz: RATE_HERTZ })) {
        if (this.#motion !== held || !motion) return;
        const { phase, progress, endReason } = motion;
        if (phase === MotionPhase.SUCCEEDED) return this.#end("done", "");
        if (ENDED.has(phase)) return this.#end("refused", forPeople(endReason));
        this.phase.value = phase === MotionPhase.RUNNING || phase === MotionPhase.WAITING ? "running" : "paused";
        this.words.value = `${fixed(100 * progress, 0)} %`;
      }
    } catch (error) {
      if (this.#motion === held) this.#end("refused", wordsOf(error));
    }
  }

  #refuse(words: string): void {
    this.words.value = words;
    this.phase.value = "refused";
  }

  #end(phase: Phase, words: string): void {
    this.#number++;
    this.#drop();
    this.#motion?.letGo();
    this.#motion = this.#wanted = undefined;
    this.#before = [];
    this.#note = "";
    goal.clear();
    this.words.value = words;
    this.phase.value = phase;
  }

  #drop(): void {
    this.#plan = undefined;
    this.way.value = this.moment.value = undefined;
  }
}

export const proposal = new Proposals();

/** Says how far the tool is off what is out of reach: a pinch turns it more than it moves it. */
function away(): string {
  const { meters, radians } = goal.off.value;
  // Joints beyond their limits reach it all the same.
  const far = meters > REACHED.meters || radians > REACHED.radians;
  return [far && `${fixed(1000 * meters, 0)} mm and ${fixed(DEGREES * radians, 1)}° off`, goal.explanation.value].filter(Boolean).join(": ");
}

function wayOf({ times, robots }: PlanMotionResponse, robot: string): Way {
  const { jointNames, positions, worldTTcp } = robots.find((one) => one.robot === robot)!;
  return {
    robot,
    joints: jointNames,
    times: [...ofArray(times!)],
    positions: rowsOf(ofArray(positions!), jointNames.length),
    points: rowsOf(ofArray(worldTTcp!), 7).map((row) => row.slice(0, 3)),
  };
}
