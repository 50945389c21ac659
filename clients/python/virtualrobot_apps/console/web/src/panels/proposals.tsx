// Proposals: what anybody wants the robots to do, looked at as ghosts, changed, turned down, and run only while a button is held.
import { effect, signal } from "@preact/signals";
import { Role } from "../generated/virtualrobot/v1/token_pb";
import { ProposalState, type Proposal } from "../generated/virtualrobot/v1/proposal_pb";
import { approving, looked, planAnew, propose, reject, shownProposal, takeBack } from "../kernel/approving";
import { goal } from "../kernel/goal";
import { forPeople, personOf } from "../kernel/words";
import { info, motions, proposals } from "../kernel/world";
import { useHeld } from "../parts/held";
import { Icon } from "../parts/icons";
import { fixed } from "../parts/numbers";
import { evenly, swept } from "../view/postures";
import { showSpans } from "../view/spans";

const WAY_COLOR = "#4ade80";

const { PROPOSED, APPROVED, EXECUTED, STOPPED, REJECTED } = ProposalState;
const WORDS: Partial<Record<ProposalState, string>> = { [PROPOSED]: "proposed", [APPROVED]: "approved", [EXECUTED]: "done", [STOPPED]: "stopped", [REJECTED]: "rejected" };

/** What it is for, or why not, as somebody writes it. */
const words = signal("");

let isSwept = false;
effect(() => {
  const shown = shownProposal.value;
  if (shown || isSwept) swept.value = evenly(shown?.postures ?? []);
  isSwept = shown !== undefined;
  const at = ([x, y, z]: readonly number[]) => ({ x, y, z });
  showSpans("proposal", (shown?.ways ?? []).flatMap((way) => way.slice(1).map((point, place) => ({ from: at(way[place]), to: at(point), color: WAY_COLOR }))));
});

/** How many wait for somebody. */
export function waiting(): number {
  return [...proposals.value.values()].filter(({ state }) => state === PROPOSED).length;
}

export function Proposals() {
  const all = [...proposals.value.values()].toReversed(), one = proposals.value.get(looked.value);
  return (
    <>
      <div class="list" role="list" aria-label="Proposals">
        {all.length === 0 && <p class="hint">Nobody has proposed a motion. Drag a robot's tool, or its joints, and propose what the ghost shows: it is planned and checked, and nothing moves.</p>}
        {all.map((each) => <Row key={each.id} one={each} />)}
      </div>
      <Bar one={one} />
    </>
  );
}

function Row({ one }: { one: Proposal }) {
  const { id, title, state, robots, author, changedBy } = one;
  const isLooked = looked.value === id;
  const color = state === PROPOSED ? (one.check?.plan ? "var(--good)" : "var(--bad)") : "var(--muted)";
  return (
    <div class="entry" role="listitem" aria-label={`Proposal ${title || id}`}>
      <button type="button" class="tool small" aria-pressed={isLooked} aria-label={`Look at ${title || id}`} title="Its way as ghosts" onClick={() => (looked.value = isLooked ? "" : id)}><Icon name="eye" size={14} color={color} /></button>
      <button type="button" class="link grow cut" title={`${id}, revision ${one.revision}`} onClick={() => (looked.value = id)}>{title || id}</button>
      <span class="muted cut">{robots.join(", ")}</span>
      <span class="cut grow" style={{ color }}>{told(one)}</span>
      <span class="muted cut" title={`proposed by ${author}`}>{personOf(changedBy)}</span>
    </div>
  );
}

/** Says what has become of it. */
function told({ state, reason, check, motionId }: Proposal): string {
  const word = WORDS[state] ?? "";
  if (state === APPROVED) return `${word}, ${fixed(100 * (motions.value.find(({ id }) => id === motionId)?.progress ?? 0), 0)} %`;
  if (state !== PROPOSED) return reason ? `${word}: ${forPeople(reason)}` : word;
  return check?.firstViolation ? `not so: ${forPeople(check.firstViolation.message)}` : `free, ${fixed(check?.durationSeconds ?? 0, 1)} s`;
}

function Bar({ one }: { one?: Proposal }) {
  const may = (info.value?.role ?? Role.OBSERVER) >= Role.OPERATOR;
  const waits = one?.state === PROPOSED, runs = one?.state === APPROVED;
  const why = may ? undefined : "An observer looks: an operator proposes, changes, approves and rejects";
  const clear = (asked: Promise<void>) => void asked.then(() => (words.value = ""));
  return (
    <div class="under program-bar" title={why}>
      <label class="field grow"><input aria-label="What it is for, or why not" placeholder="what for, or why not" maxLength={200} value={words.value} disabled={!may} onInput={(event) => (words.value = event.currentTarget.value)} /></label>
      <button type="button" class="button small" disabled={!may || !goal.shown.value} title={why ?? "Propose what the ghost shows"} onClick={() => clear(propose(words.peek()))}><Icon name="plus" size={13} />Propose</button>
      <button type="button" class="button small" disabled={!may || !one || runs || !goal.shown.value} title={why ?? "Give it the goal that the ghost shows"} onClick={() => clear(propose(words.peek(), one))}>Change</button>
      <button type="button" class="button small" disabled={!may || !one || runs} title={why ?? "Plan and check it on the cell as it is now; what is over is proposed again"} onClick={() => void planAnew(one!)}>Plan anew</button>
      <button type="button" class="tool small" aria-label="Take back" disabled={!may || !one?.undoCount || runs} title={why ?? "Take back the last change of its motion"} onClick={() => void takeBack(one!)}><Icon name="undo-2" size={14} /></button>
      <button type="button" class="button small" disabled={!may || !waits} title={why ?? "Turn it down, for all who see it"} onClick={() => clear(reject(one!, words.peek()))}><Icon name="x" size={13} />Reject</button>
      <Hold one={one} may={may && !!one && ((waits && !!one.check?.plan && shownProposal.value?.revision === one.revision) || (runs && approving.isOwn(one)))} />
    </div>
  );
}

/** Runs what is looked at while it is held, by pointer or by Enter; let go it brakes on its path. */
function Hold({ one, may }: { one?: Proposal; may: boolean }) {
  const { held, listeners } = useHeld(() => one && may && approving.hold(one), () => approving.letGo());
  return (
    <button type="button" class={`button small ${may ? "primary" : ""} ${held && may ? "held" : ""}`} id="hold-proposal" aria-disabled={!may} title="Approve it: it runs while this is held, as it was shown, and brakes on its path when it is let go" {...listeners}>
      <Icon name="hand" size={13} />Hold to run
    </button>
  );
}
