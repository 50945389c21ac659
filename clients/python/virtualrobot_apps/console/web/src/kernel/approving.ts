// Proposals that this page looks at, approves by holding a button, changes, and turns down; the kernel keeps them for all.
import { effect, signal } from "@preact/signals";
import { BusyPolicy, DisconnectPolicy, type PlanMotionResponse } from "../generated/virtualrobot/v1/motion_pb";
import { ProposalState, type Proposal } from "../generated/virtualrobot/v1/proposal_pb";
import { ofArray, rowsOf } from "./arrays";
import { goal, type Goal } from "./goal";
import { HeldMotion } from "./held_motion";
import { attempt, say } from "./messages";
import { start } from "./own_motions";
import { metadataOf, reasonOf } from "./page_calls";
import { eachPicture } from "./pictures";
import { motions, proposals as service } from "./services";
import { forPeople, wordsOf } from "./words";
import { proposals } from "./world";

/** The proposal that is looked at, "" for none. */
export const looked = signal("");

/** What it would be, as the kernel has planned it: postures and the way of the tool, for each robot. */
export interface Shown {
  id: string;
  revision: bigint;
  postures: readonly Goal[];
  /** Points in the world, m. */
  ways: readonly (readonly number[][])[];
}

export const shownProposal = signal<Shown | undefined>(undefined);

/** Part of the greatest speed of what is proposed here. */
const SPEED = 0.5;
const SAMPLE_SECONDS = 0.02;
const RATE_HERTZ = 5;

/** Proposes what the ghost shows, or gives a proposal that goal. */
export async function propose(title: string, changed?: Proposal): Promise<void> {
  const shown = goal.shown.peek();
  if (!shown) return;
  const spec = goal.motion(shown, SPEED);
  const asked: Promise<{ proposal?: Proposal }> = changed
    ? service.updateProposal({ id: changed.id, expectedRevision: changed.revision, spec, title: title || undefined })
    : service.createProposal({ spec, title });
  const said = await attempt(asked);
  if (!said?.proposal) return;
  looked.value = said.proposal.id;
  goal.clear();
}

/** Has a proposal planned and checked anew, on the cell as it is. */
export async function planAnew({ id, revision: expectedRevision }: Proposal): Promise<void> {
  await attempt(service.updateProposal({ id, expectedRevision }));
}

export async function takeBack({ id, revision: expectedRevision }: Proposal): Promise<void> {
  await attempt(service.undoProposal({ id, expectedRevision }));
}

export async function reject({ id, revision: expectedRevision }: Proposal, reason: string): Promise<void> {
  await attempt(service.rejectProposal({ id, expectedRevision, reason }));
}

class Approving {
  /** The motion that this page has approved last, and of which proposal it is; a signal, since the proposal may be heard of before it. */
  #own = signal<{ of: string; motion: HeldMotion } | undefined>(undefined);
  /** Ends the beats of the press that is on. */
  #rest?: () => void;

  /** Whether this page holds what it has approved, or may hold it again. */
  isOwn({ id, motionId }: Proposal): boolean {
    const own = this.#own.value;
    return own?.of === id && own.motion.id === motionId;
  }

  /** Starts what is seen, or lets it go on, until it is let go. */
  hold(seen: Proposal): void {
    this.letGo();
    let held = this.isOwn(seen) ? this.#own.peek()?.motion : undefined;
    this.#rest = eachPicture(() => held?.beat());
    if (held) return;
    const rest = this.#rest;
    void this.#start(seen).then((motion) => {
      if (this.#rest === rest) held = motion;
    });
  }

  letGo(): void {
    this.#rest?.();
    this.#rest = undefined;
    this.#own.peek()?.motion.letGo();
  }

  async #start({ id, revision }: Proposal): Promise<HeldMotion | undefined> {
    try {
      const { motion } = await start({ proposal: { id, revision }, hold: true, busyPolicy: BusyPolicy.REJECT, onDisconnect: DisconnectPolicy.STOP });
      const own = new HeldMotion(motion!.id, (error) => say(wordsOf(error), "error"));
      this.#own.value = { of: id, motion: own };
      void this.#watch(own.id);
      return own;
    } catch (error) {
      say(reasonOf(error) === "PLAN_OUTDATED" ? `another cell than was looked at: ${forPeople(metadataOf(error, "changes")).replaceAll("\n", ", ")}; plan it anew` : wordsOf(error), "error");
      return undefined;
    }
  }

  /** The kernel ends what nobody watches; the proposal tells how it ends. */
  async #watch(id: string): Promise<void> {
    await attempt((async () => {
      for await (const _ of motions.watchMotion({ id, maxRateHertz: RATE_HERTZ })) continue;
    })());
  }
}

export const approving = new Approving();

// Whatever takes the button from the page lets go.
for (const event of ["pointercancel", "blur", "pagehide"]) addEventListener(event, () => approving.letGo());
document.addEventListener("visibilitychange", () => document.hidden && approving.letGo());

// What is looked at is shown as it is now, whoever has changed it.
effect(() => {
  const one = proposals.value.get(looked.value);
  const isOver = one?.state === ProposalState.REJECTED || one?.state === ProposalState.EXECUTED;
  if (!one?.check?.plan || isOver) return void (shownProposal.value = undefined);
  const before = shownProposal.peek();
  if (before?.id !== one.id || before.revision !== one.revision) void show(one);
});

async function show({ id, revision, check }: Proposal): Promise<void> {
  const said = await motions.planMotion({ plan: check!.plan, sampleSeconds: SAMPLE_SECONDS }).catch(() => undefined); // forgotten meanwhile
  if (looked.peek() !== id || proposals.peek().get(id)?.revision !== revision) return;
  shownProposal.value = said && { id, revision, ...wayOf(said) };
}

function wayOf({ robots }: PlanMotionResponse): Pick<Shown, "postures" | "ways"> {
  const postures = robots.flatMap(({ robot, jointNames, positions }) =>
    rowsOf(ofArray(positions!), jointNames.length).map((row) => ({ robot, jointPositions: Object.fromEntries(jointNames.map((name, place) => [name, row[place]])) })));
  return { postures, ways: robots.map(({ worldTTcp }) => (worldTTcp ? rowsOf(ofArray(worldTTcp), 7).map((row) => row.slice(0, 3)) : [])) };
}
