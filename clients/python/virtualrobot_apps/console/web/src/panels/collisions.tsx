// Collisions: what touches now, what has begun and ended, how far things are apart, what may touch, what is done about the rest.
import { computed, effect, signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { AllowedCause, type CollisionEvent, type CollisionPair } from "../generated/virtualrobot/v1/collision_pb";
import { askedAnew } from "../kernel/asked_anew";
import * as collisions from "../kernel/collisions";
import { chosen, items, robotNames, selected, steps, touching } from "../kernel/world";
import { Choice } from "../parts/choice";
import { Icon } from "../parts/icons";
import { NodeField } from "../parts/node_field";
import { NumberField } from "../parts/number_field";
import { fixed } from "../parts/numbers";
import { showSpans } from "../view/spans";
import { viewport } from "./view";

type Part = "now" | "events" | "distances" | "allowed" | "settings";

const MOST_ROWS = 200;
const shown = signal<Part>("now");

/** Nodes that a person is about to let touch, and why. */
const draft = signal({ first: "", second: "", reason: "" });
const filter = signal("");
const byRule = signal(false);

export function Collisions() {
  const parts = [["now", "Now"], ["events", "Events"], ["distances", "Distances"], ["allowed", "Allowed"], ["settings", "Modes"]] as const;
  return (
    <>
      {shown.value === "now" && <Now />}
      {shown.value === "events" && <Events />}
      {shown.value === "distances" && <Distances />}
      {shown.value === "allowed" && <Allowed />}
      {shown.value === "settings" && <Settings />}
      <div class="under program-bar" role="group" aria-label="About collisions">
        <Choice label="What is shown about collisions" options={parts} chosen={shown.value} choose={(one) => (shown.value = one)} />
        <span class="grow" />
        {shown.value === "events" && <button type="button" class="button small" onClick={() => (collisions.events.value = [])}>Clear</button>}
        {shown.value === "distances" && <Measuring />}
        {shown.value === "allowed" && <Filter />}
      </div>
    </>
  );
}

interface PairProps {
  first: string;
  second: string;
  words: string;
  icon: string;
  color: string;
  children?: ComponentChildren;
}

/** Two nodes; pressed, it marks both in the view. */
function Pair({ first, second, words, icon, color, children }: PairProps) {
  return (
    <div class="entry" role="listitem" aria-label={`${first} and ${second}`}>
      <Icon name={icon} size={14} color={color} />
      <button type="button" class="pair grow" aria-label={`${first} ${words} ${second}`} aria-pressed={collisions.isMarked(first, second)} title="Mark both in the view" onClick={() => collisions.mark(first, second)}>
        <span class="cut">{first}</span><span class="muted">{words}</span><span class="cut">{second}</span>
      </button>
      {children}
      <button type="button" class="tool small" title={`Look at ${first} and ${second}`} onClick={() => viewport.current?.look([first, second])}><Icon name="crosshair" size={13} /></button>
    </div>
  );
}

function Now() {
  useEffect(() => askedAnew(collisions.check), []);
  useEffect(() => void collisions.readSettings(), [steps.value]);
  const since = new Map(touching.value.map((one) => [`${one.pair?.first} ${one.pair?.second}`, one.simulationTimeSeconds]));
  return (
    <div class="list" role="list" aria-label="What touches now">
      {collisions.fault.value && <p class="hint warned" role="alert"><Icon name="triangle-alert" size={13} />{collisions.fault.value}</p>}
      {collisions.touches.value.length === 0 && <p class="hint">Nothing touches that may not.</p>}
      {collisions.touches.value.map((pair) => (
        <Pair key={`${pair.first} ${pair.second}`} first={pair.first} second={pair.second} words="touches" icon="zap" color="var(--danger)">
          <span class="mono muted" title="How far one must be moved until they only touch">{depth(pair)}</span>
          <span class="mono muted">{told(since.get(`${pair.first} ${pair.second}`))}</span>
          <button type="button" class="button small" title="Let them touch, and say why" onClick={() => letTouch(pair)}>Allow …</button>
        </Pair>
      ))}
      {collisions.settings.value && !collisions.isWatched() && (
        <p class="hint">Every robot's mode is off: what begins to touch is neither told nor stopped. <button type="button" class="link accent" onClick={() => (shown.value = "settings")}>Modes</button> changes that.</p>
      )}
    </div>
  );
}

function depth({ depthMeters, depthApproximate }: CollisionPair): string {
  return depthMeters === undefined ? "" : `${depthApproximate ? "≈ " : ""}${fixed(1000 * depthMeters, 1)} mm deep`;
}

function told(since?: number): string {
  return since === undefined ? "" : `since ${since.toFixed(2)} s`;
}

function letTouch({ first, second }: CollisionPair): void {
  draft.value = { first, second, reason: "" };
  shown.value = "allowed";
}

function Events() {
  return (
    <div class="list" role="list" aria-label="What began and ended">
      {collisions.events.value.length === 0 && <p class="hint">Nothing has begun or ended to touch since this page was opened. Only robots are watched whose mode is not off.</p>}
      {collisions.events.value.toReversed().map((one) => <Event key={one.number} event={one} />)}
      {collisions.missed.value > 0 && <p class="hint">{collisions.missed.value} events were not told to this page.</p>}
    </div>
  );
}

function Event({ event: { simulationTimeSeconds, what } }: { event: CollisionEvent }) {
  const time = <span class="mono muted" title="Simulation time">{simulationTimeSeconds.toFixed(3)} s</span>;
  if (what.case === "begun") {
    const { pair, tolerated } = what.value;
    return <Pair first={pair?.first ?? ""} second={pair?.second ?? ""} words={tolerated ? "touched already" : "began to touch"} icon="zap" color="var(--danger)">{time}</Pair>;
  }
  if (what.case === "ended") {
    const { first, second, apart } = what.value;
    return <Pair first={first} second={second} words={apart ? "is apart from" : "is watched no more with"} icon="zap" color="var(--muted)">{time}</Pair>;
  }
  const words = what.case === "stopped" ? `${what.value.robots.join(", ")} stopped: ${what.value.reason}` : what.value || "checks succeed again";
  return (
    <div class="entry" role="listitem">
      <Icon name={what.case === "stopped" ? "stop" : "triangle-alert"} size={14} color="var(--warning)" />
      <span class="grow words">{words}</span>
      {time}
    </div>
  );
}

const NEAR = "#ffd65c";
const LINES = 20;

function Distances() {
  const { from } = collisions.measured.value;
  useEffect(() => {
    if (!from && chosen.value) collisions.measured.value = { ...collisions.measured.peek(), from: chosen.value };
  }, [from, chosen.value]);
  useEffect(() => (from ? askedAnew(collisions.measure) : undefined), [collisions.measured.value]);
  useEffect(() => () => showSpans("distances", []), []);
  // The pair that is marked in its own colour; all where none is.
  useEffect(() => effect(() => {
    const pairs = collisions.distances.value.slice(0, LINES);
    const one = pairs.filter(({ first, second }) => collisions.isMarked(first, second));
    showSpans("distances", (one.length > 0 ? one : pairs).flatMap(({ firstPoint, secondPoint }) => (firstPoint && secondPoint ? [{ from: firstPoint, to: secondPoint, color: NEAR }] : [])));
  }), []);
  const pairs = collisions.distances.value;
  return (
    <div class="list" role="list" aria-label="Distances">
      {!from && <p class="hint">Name a robot, or any other node, below.</p>}
      {collisions.unmeasured.value && <p class="hint warned" role="alert"><Icon name="triangle-alert" size={13} />{collisions.unmeasured.value}</p>}
      {from && !collisions.unmeasured.value && pairs.length === 0 && <p class="hint">Nothing is so near.</p>}
      {pairs.slice(0, MOST_ROWS).map(({ first, second, distanceMeters }) => (
        <Pair key={`${first} ${second}`} first={first} second={second} words="to" icon="move-horizontal" color="var(--light)">
          <span class="mono distance">{fixed(1000 * distanceMeters, 1)} mm</span>
        </Pair>
      ))}
      <Rest count={pairs.length} />
    </div>
  );
}

function Measuring() {
  const { from, to, meters } = collisions.measured.value;
  const change = (some: Partial<typeof collisions.measured.value>) => (collisions.measured.value = { ...collisions.measured.peek(), ...some });
  return (
    <>
      <NodeField label="Measured from, with all below it" value={from} placeholder="from" choose={(name) => change({ from: name })} />
      <NodeField label="Measured to, with all below it" value={to} placeholder="everything else" choose={(name) => change({ to: name })} />
      <NumberField label="Farthest pairs that are told; 0 is the nearest pair alone" value={1000 * meters} unit="mm" decimals={0} write={(range) => change({ meters: Math.max(0, range / 1000) })} />
    </>
  );
}

const CAUSES: Record<AllowedCause, string> = {
  [AllowedCause.UNSPECIFIED]: "", [AllowedCause.RIGID]: "rigid", [AllowedCause.ADJACENT]: "adjacent", [AllowedCause.MOUNTED]: "mounted",
  [AllowedCause.HELD]: "held", [AllowedCause.FILE]: "file", [AllowedCause.CLIENT]: "client", [AllowedCause.BUILT]: "built",
};
const CHANGEABLE = new Set([AllowedCause.CLIENT, AllowedCause.BUILT]);

const found = computed(() => {
  const words = filter.value.toLowerCase().split(/\s+/).filter(Boolean);
  return collisions.allowed.value.filter(({ first, second, cause, reason }) => {
    const text = `${first} ${second} ${CAUSES[cause]} ${reason}`.toLowerCase();
    return (byRule.value || CHANGEABLE.has(cause)) && words.every((word) => text.includes(word));
  });
});

function Allowed() {
  useEffect(() => void collisions.readAllowed(), [steps.value, items.value]);
  return (
    <div class="list" role="list" aria-label="Pairs that may touch">
      <Draft />
      {found.value.length === 0 && <p class="hint">No such pair{byRule.value ? "" : " was allowed by a person, a program or a load"}.</p>}
      {found.value.slice(0, MOST_ROWS).map(({ first, second, cause, reason }) => (
        <Pair key={`${first} ${second}`} first={first} second={second} words="may touch" icon="link" color="var(--muted)">
          <span class="muted cut reason" title={reason}>{reason}</span>
          <span class="badge" title={CHANGEABLE.has(cause) ? "It can be taken back" : "It is so by rule, and can't be taken back"}>{CAUSES[cause]}</span>
          <button type="button" class="tool small" disabled={!CHANGEABLE.has(cause)} title={`Let ${first} and ${second} touch no more`} onClick={() => void collisions.forbid(first, second)}><Icon name="trash-2" size={13} /></button>
        </Pair>
      ))}
      <Rest count={found.value.length} />
    </div>
  );
}

/** Two nodes to let touch. */
function Draft() {
  const { first, second, reason } = draft.value;
  const change = (some: Partial<typeof draft.value>) => (draft.value = { ...draft.peek(), ...some });
  const field = useRef<HTMLInputElement>(null);
  useEffect(() => {
    if (draft.peek().first && draft.peek().second) field.current?.focus();
  }, []);
  const allow = async () => {
    const { first, second, reason } = draft.peek();
    if (await collisions.allow(first, second, reason)) draft.value = { first: "", second: "", reason: "" };
  };
  const pick = (which: "first" | "second") => (
    <button type="button" class="tool small" disabled={!selected.value} title={`The selected node: ${selected.value || "none"}`} onClick={() => change({ [which]: selected.peek() })}><Icon name="mouse-pointer-2" size={13} /></button>
  );
  return (
    <form class="entry draft" aria-label="Let two nodes touch" onSubmit={(event) => (event.preventDefault(), void allow())}>
      <NodeField label="First node" value={first} placeholder="first node" choose={(name) => change({ first: name })} />{pick("first")}
      <NodeField label="Second node" value={second} placeholder="second node" choose={(name) => change({ second: name })} />{pick("second")}
      <label class="field node-field grow" title="Why they may touch">
        <input ref={field} aria-label="Reason" value={reason} placeholder="why they may touch" onInput={(event) => change({ reason: event.currentTarget.value })} />
      </label>
      <button type="submit" class="button small primary">Allow</button>
    </form>
  );
}

function Filter() {
  return (
    <>
      <button type="button" class="chip" aria-pressed={byRule.value} title="Links beside each other, what is mounted or held, what the robot's files say" onClick={() => (byRule.value = !byRule.value)}>by rule, too</button>
      <label class="field node-field"><input aria-label="Filter pairs" placeholder="Filter pairs" value={filter.value} onInput={(event) => (filter.value = event.currentTarget.value)} /></label>
    </>
  );
}

function Rest({ count }: { count: number }) {
  return count > MOST_ROWS ? <p class="hint">and {count - MOST_ROWS} more</p> : null;
}

const MODE_WORDS: Record<collisions.Mode, string> = {
  off: "Nothing is done", monitor: "What begins to touch is told", stop: "It is told, and stops the robots",
  guard: "Robots go on only as long as they can still brake before they touch anything",
};
const MODES = Object.keys(collisions.MODES) as collisions.Mode[];

function Settings() {
  useEffect(() => void collisions.readSettings(), [steps.value, items.value]);
  const { settings, guardCost } = collisions;
  const now = settings.value, cost = guardCost.value;
  if (!now) return <div class="list" />;
  const all = collisions.nameOf(now.mode) ?? "off";
  const pad = (items.value.get(selected.value)?.node.figures.length ?? 0) > 0 && !now.paddings.some(({ node }) => node === selected.value);
  return (
    <div class="list" role="list" aria-label="What is done about collisions">
      <div class="entry" role="listitem">
        <Icon name="shield" size={14} color="var(--accent)" /><b class="what">All robots</b>
        <Choice label="Mode of all robots" options={MODES.map((one) => [one, one, MODE_WORDS[one]] as const)} chosen={all} choose={(one) => void collisions.set({ mode: collisions.MODES[one] })} />
        <span class="muted grow words">{MODE_WORDS[all]}.</span>
        <NumberField label="How far ahead running motions are checked; 0 is not at all" name="ahead" value={now.lookAheadSeconds} unit="s" decimals={1} write={(to) => void collisions.set({ lookAheadSeconds: to })} />
      </div>
      {robotNames.value.map((robot) => (
        <div key={robot} class="entry" role="listitem">
          <Icon name="robot" size={14} color="var(--robot)" /><b class="what cut">{robot}</b>
          <Choice label={`Mode of ${robot}`} options={[["inherit", "as all", "As it is for all robots"] as const, ...MODES.map((one) => [one, one, MODE_WORDS[one]] as const)]} chosen={collisions.modeOf(robot) ?? "inherit"}
            choose={(one) => void collisions.set({ robots: [{ robot, mode: one === "inherit" ? undefined : collisions.MODES[one] }] })} />
        </div>
      ))}
      {now.paddings.map(({ node, paddingMeters }) => (
        <div key={node} class="entry" role="listitem">
          <Icon name="box" size={14} color="var(--muted)" /><b class="what cut">{node}</b>
          <NumberField label={`Padding of ${node}: how much thicker it counts`} value={1000 * paddingMeters} unit="mm" decimals={1} write={(to) => void collisions.set({ paddings: [{ node, paddingMeters: to / 1000 }] })} />
          <span class="muted grow">thicker</span>
          <button type="button" class="tool small" title={`Pad ${node} no more`} onClick={() => void collisions.set({ paddings: [{ node, paddingMeters: 0 }] })}><Icon name="x" size={13} /></button>
        </div>
      ))}
      {pad && <button type="button" class="button small" onClick={() => void collisions.set({ paddings: [{ node: selected.peek(), paddingMeters: PADDING_METERS }] })}><Icon name="plus" size={13} />Pad {selected.value}</button>}
      {!!cost?.ticks && <p class="hint">Guarding took {fixed(1000 * cost.meanSeconds, 2)} ms a tick, {fixed(1000 * cost.worstSeconds, 1)} ms at most, in {String(cost.ticks)} ticks.</p>}
    </div>
  );
}

const PADDING_METERS = 0.01;
