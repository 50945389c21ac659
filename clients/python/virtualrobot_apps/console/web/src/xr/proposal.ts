// A motion that a person in the room proposes by hand, or that somebody else has proposed: planned and checked by the kernel,
// which keeps it for all of its clients, shown, and run only while it is held, as it was shown.
import { effect, signal } from "@preact/signals";
import type { MessageInitShape } from "@bufbuild/protobuf";
import { BusyPolicy, DisconnectPolicy, MotionPhase, type MotionSpecSchema, type PlanMotionResponse } from "../generated/virtualrobot/v1/motion_pb";
import { ProposalState, type Proposal } from "../generated/virtualrobot/v1/proposal_pb";
import { ofArray, rowsOf } from "../kernel/arrays";
import { goal } from "../kernel/goal";
import { HeldMotion } from "../kernel/held_motion";
import { attempt } from "../kernel/messages";
import * as orders from "../kernel/orders";
import { start } from "../kernel/own_motions";
import { metadataOf, reasonOf } from "../kernel/page_calls";
import * as service from "../kernel/services";
import { forPeople, personOf, wordsOf } from "../kernel/words";
import { chosen, clock, proposals } from "../kernel/world";
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
const TITLE = "by hand, in the room", REJECTED = "rejected in the room";
const ENDED = new Set<MotionPhase>([MotionPhase.SUCCEEDED, MotionPhase.CANCELLED, MotionPhase.ABORTED]);

class Proposals {
  readonly phase = signal<Phase>("idle");
  /** What there is to say about it, for people. */
  readonly words = signal("");
  readonly way = signal<Way | undefined>(undefined);
  /** The time (s) of the way that is looked at; undefined for the whole of it. */
  readonly moment = signal<number | undefined>(undefined);
  /** Whether somebody is in the room, who sees what others propose. */
  readonly isSeen = signal(false);
  /** Grows with all that makes answers to earlier questions worthless. */
  #number = 0;
  #asked: Promise<void> = Promise.resolve();
  #wanted?: Wanted;
  /** Goals of this person that the kernel has kept, the newest last. */
  #before: Wanted[] = [];
  /** What the kernel keeps, as it was seen last; one call after the other changes it. */
  #kept?: Proposal;
  #keeping: Promise<unknown> = Promise.resolve();
  /** Up to which revision proposals were seen to their end here. */
  #over = new Map<string, bigint>();
  #motion?: HeldMotion;
  #isPressed = false;
  #note = "";

  constructor() {
    // It is of one robot, as its goal is.
    effect(() => {
      void chosen.value;
      if (!this.isBegun) this.#end("idle", "", this.#before.length > 0 ? "another robot was chosen" : undefined);
    });
    effect(() => {
      if (this.phase.value === "asking") this.words.value = goal.reach.value === "unreachable" ? away() : "";
    });
    effect(() => {
      if (this.isSeen.value) this.#hear(proposals.value);
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
    if (!this.isBegun && this.#wanted) await this.#propose();
  }

  /** Holds what was shown, once in each frame: starts it, and lets it go on. */
  hold(): void {
    if (this.#motion) return this.#motion.beat();
    if (this.#isPressed) return;
    this.#isPressed = true;
    if (this.phase.peek() === "free") void this.#start();
    else if (this.phase.peek() === "refused" && (goal.shown.peek() || this.#kept)) void this.#propose();
  }

  /** Has it brake on its path. */
  letGo(): void {
    this.#isPressed = false;
    this.#motion?.letGo();
  }

  /** Drops it, for all who see it; where it runs it ends on its path. */
  reject(words = REJECTED): void {
    this.#cancel(words);
    this.#end("idle", this.phase.peek() === "idle" ? "" : words, words);
  }

  /** Drops what the person has proposed, or runs; what others have proposed waits on. */
  leave(words: string): void {
    this.isSeen.value = false;
    this.#cancel(words);
    this.#end("idle", "", this.#before.length > 0 ? words : undefined);
  }

  /** Takes the goal back to the one before, or, where nothing is proposed, the last edit of the cell. */
  async undo(): Promise<void> {
    if (this.isBegun) return;
    const kept = this.#kept, isKept = this.#wanted === this.#before.at(-1);
    if (!kept) return this.#wanted ? this.reject("taken back") : orders.undo();
    if (isKept && kept.undoCount === 0) return this.#before.length > 0 ? this.reject("taken back") : orders.undo();
    if (isKept) this.#before.pop();
    this.#wanted = this.#before.at(-1);
    await this.#ask(async () => {
      if (this.#wanted) await goal.ask(this.#wanted.robot, this.#wanted.pose);
      else goal.clear();
      return isKept ? (await service.proposals.undoProposal({ id: kept.id, expectedRevision: kept.revision })).proposal! : kept;
    });
  }

  /** Looks at a time farther on by a share of the whole way. */
  scrub(share: number): void {
    const way = this.way.peek();
    if (!way || this.isBegun) return;
    const whole = way.times.at(-1)!;
    this.moment.value = Math.min(whole, Math.max(0, (this.moment.peek() ?? whole) + share * whole));
  }

  /** Has what is wanted planned and checked, or where nothing is, what somebody else wants, on the cell as it is. */
  async #propose(): Promise<void> {
    const number = ++this.#number;
    this.#drop();
    await this.#asked;
    if (number !== this.#number) return;
    const wanted = this.#wanted, shown = goal.shown.peek();
    if (wanted && !shown) return this.#refuse(away());
    const spec = wanted && goal.motion(shown!, SPEED);
    await this.#ask(async () => {
      const now = await this.#keep(spec);
      if (wanted && wanted !== this.#before.at(-1)) this.#before.push(wanted);
      return now;
    });
  }

  /** Creates what the kernel keeps, or changes it; it is planned anew in any case. */
  async #keep(spec?: MessageInitShape<typeof MotionSpecSchema>): Promise<Proposal> {
    const { id, revision: expectedRevision } = this.#kept ?? {};
    const { proposal } = id ? await service.proposals.updateProposal({ id, expectedRevision, spec }) : await service.proposals.createProposal({ spec, title: TITLE });
    return proposal!;
  }

  /** Shows what the kernel keeps once it has answered. */
  async #ask(answer: () => Promise<Proposal>): Promise<void> {
    const number = ++this.#number;
    this.#drop();
    this.phase.value = "planning";
    this.words.value = this.#note;
    const asked = this.#keeping.then(async () => {
      if (number !== this.#number) return;
      try {
        this.#kept = await answer();
        if (number === this.#number) await this.#show(this.#kept);
        else if (!this.#wanted) this.#forget(REJECTED); // it was rejected meanwhile
      } catch (error) {
        if (number !== this.#number) return;
        if (reasonOf(error) === "UNKNOWN_NAME") this.#kept = undefined; // another kernel
        this.#refuse(wordsOf(error));
      }
    });
    await (this.#keeping = asked);
    this.#hear(proposals.peek());
  }

  /** Shows what the kernel has found, and the way, which it tells as it planned it. */
  async #show({ spec, check, changedBy, title }: Proposal): Promise<void> {
    const number = this.#number, robot = chosen.peek();
    const { plan, firstViolation: found, durationSeconds } = check!;
    const sampleSeconds = Math.max(SAMPLE_SECONDS, Number(clock.peek()?.tickNanoseconds ?? 0) * NANO);
    const planned = await service.motions.planMotion(plan ? { plan, sampleSeconds } : { spec, sampleSeconds }).catch((error: unknown) => {
      if (!found) throw error;
    });
    if (number !== this.#number) return;
    if (planned) this.way.value = wayOf(planned, robot);
    this.moment.value = found?.timeSeconds;
    const whose = this.#wanted ? "" : [personOf(changedBy), title].filter(Boolean).join(": ");
    const told = found ? forPeople(found.message) : `free, ${fixed(durationSeconds, 1)} s`;
    this.words.value = [whose, told, this.#note].filter(Boolean).join("; ");
    this.phase.value = plan ? "free" : "refused";
    this.#note = "";
  }

  /** Takes what others have done with it, or have proposed where there is nothing yet. */
  #hear(all: ReadonlyMap<string, Proposal>): void {
    const phase = this.phase.peek();
    if (!this.isSeen.peek() || this.isBegun || phase === "planning") return;
    if (this.#kept) {
      const now = all.get(this.#kept.id);
      if (!now || now.revision <= this.#kept.revision) return;
      const by = personOf(now.changedBy);
      if (now.state === ProposalState.PROPOSED && phase !== "asking") this.#take(now);
      else if (now.state === ProposalState.REJECTED) this.#end("refused", [`rejected by ${by}`, now.reason].filter(Boolean).join(": "));
      else if (now.state === ProposalState.APPROVED) this.#end("idle", `approved by ${by}`);
    } else if (phase !== "asking" && !this.#wanted) {
      const isNew = ({ id, revision, state, robots }: Proposal) =>
        state === ProposalState.PROPOSED && robots.length === 1 && robots[0] === chosen.peek() && revision > (this.#over.get(id) ?? 0n);
      const newest = [...all.values()].filter(isNew).at(-1);
      if (newest) this.#take(newest);
    }
  }

  /** Shows what somebody else wants. */
  #take(now: Proposal): void {
    this.#wanted = undefined;
    this.#before = [];
    goal.clear();
    void this.#ask(async () => now);
  }

  /** Starts what was shown, as it was; where the cell is another one since, it is planned and shown anew. */
  async #start(): Promise<void> {
    const number = ++this.#number, { id, revision } = this.#kept!;
    this.phase.value = "paused";
    this.words.value = "";
    try {
      const { motion } = await start({ proposal: { id, revision }, hold: true, busyPolicy: BusyPolicy.REJECT, onDisconnect: DisconnectPolicy.STOP });
      const held = new HeldMotion(motion!.id, (error) => (this.words.value = wordsOf(error)));
      if (number !== this.#number) return void attempt(service.motions.cancelMotion({ id: held.id, reason: REJECTED }));
      this.#motion = held;
      // The last frame has seen the trigger pulled: the motion doesn't wait for the next one.
      if (this.#isPressed) held.beat();
      void this.#watch(held);
    } catch (error) {
      if (number !== this.#number) return this.#turnDown(id, REJECTED);
      this.#refuse(wordsOf(error));
      if (reasonOf(error) === "STALE_REVISION") return this.#hear(proposals.peek());
      if (reasonOf(error) !== "PLAN_OUTDATED") return;
      this.#note = `shown anew: ${forPeople(metadataOf(error, "changes")).replaceAll("\n", ", ")}`;
      await this.#propose();
    }
  }

  async #watch(held: HeldMotion): Promise<void> {
    try {
      for await (const { motion } of service.motions.watchMotion({ id: held.id, maxRateHertz: RATE_HERTZ })) {
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

  /** `rejected` says why others shall not run what has not run, if that is so. */
  #end(phase: Phase, words: string, rejected?: string): void {
    this.#number++;
    this.#drop();
    this.#motion?.letGo();
    this.#forget(rejected);
    this.#motion = this.#wanted = undefined;
    this.#before = [];
    this.#note = "";
    goal.clear();
    this.words.value = words;
    this.phase.value = phase;
  }

  /** Looks no more at what the kernel keeps, and turns it down for a reason if there is one, unless it is over or runs. */
  #forget(rejected?: string): void {
    if (!this.#kept) return;
    const { id, revision } = this.#kept, now = proposals.peek().get(id);
    this.#kept = undefined;
    this.#over.set(id, now && now.revision > revision ? now.revision : revision);
    if (rejected && !this.isBegun) this.#turnDown(id, rejected);
  }

  #turnDown(id: string, reason: string): void {
    service.proposals.rejectProposal({ id, reason }).catch(() => {}); // it is over already
  }

  #cancel(reason: string): void {
    const id = this.#motion?.id;
    if (id) void attempt(service.motions.cancelMotion({ id, reason }));
  }

  #drop(): void {
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
