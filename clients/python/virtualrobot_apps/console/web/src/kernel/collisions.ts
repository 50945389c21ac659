// Collisions: what touches now and how deep, what has begun and ended, how far things are apart, what may touch, what is done.
import type { MessageInitShape } from "@bufbuild/protobuf";
import { computed, signal } from "@preact/signals";
import { CollisionDetail, CollisionMode } from "../generated/virtualrobot/v1/collision_pb";
import type {
  AllowedPair, CollisionEvent, CollisionPair, CollisionSettings, DistancePair, GuardCost, SetCollisionSettingsSchema, WatchCollisionsResponse,
} from "../generated/virtualrobot/v1/collision_pb";
import { attempt, say } from "./messages";
import { apply } from "./orders";
import { collisions } from "./services";
import { wordsOf } from "./words";
import { items, touching } from "./world";

const MOST_EVENTS = 500;

/** Modes as the command line calls them. */
export const MODES = { off: CollisionMode.OFF, monitor: CollisionMode.MONITOR, stop: CollisionMode.STOP, guard: CollisionMode.GUARD };
export type Mode = keyof typeof MODES;

export const events = signal<readonly CollisionEvent[]>([]);
/** How many events this page was not told, of those since the first that it has. */
export const missed = signal(0);
/** Why the monitor's last check failed; "" where it did not. */
export const fault = signal("");

/** What touches now and may not, of all robots, whether anybody watches them or not. */
export const touches = signal<readonly CollisionPair[]>([]);
/** What may touch, and what is done about the rest; read while it is shown. */
export const allowed = signal<readonly AllowedPair[]>([]);
export const settings = signal<CollisionSettings | undefined>(undefined);
export const guardCost = signal<GuardCost | undefined>(undefined);

/** The pair that a person has chosen. */
const marked = signal<readonly string[]>([]);

/** The nodes that are marked in the view: those of the chosen pair while there is one, else all that are told to touch. */
export const outlined = computed(() => (marked.value.length > 0 && marked.value.every((name) => items.value.has(name)) ? marked.value : touching.value.flatMap(({ pair }) => (pair ? [pair.first, pair.second] : []))));

/** What is measured: from a node with all below it to another one, "" being everything else; pairs within so many meters, 0: the nearest one. */
export const measured = signal({ from: "", to: "", meters: 0.2 });
export const distances = signal<readonly DistancePair[]>([]);
/** Why there are none; "" where they could be measured. */
export const unmeasured = signal("");

/** Takes what the watch tells. */
export function take(said: WatchCollisionsResponse): void {
  touching.value = said.touching;
  fault.value = said.fault;
  const [first] = said.events;
  if (!first) return;
  const last = events.peek().at(-1);
  // Numbers that begin again are those of another kernel.
  const kept = last && first.number > last.number ? events.peek() : [];
  missed.value = kept.length > 0 ? missed.peek() + Number(first.number - last!.number) - 1 : 0;
  events.value = [...kept, ...said.events].slice(-MOST_EVENTS);
  for (const { what } of said.events) {
    if (what.case === "begun") say(`${what.value.pair?.first} touches ${what.value.pair?.second}`, "warning");
    if (what.case === "stopped") say(what.value.reason, "warning");
  }
}

export async function check(): Promise<void> {
  const said = await attempt(collisions.checkCollision({ detail: CollisionDetail.CONTACTS }));
  if (said) touches.value = said.pairs;
}

export async function measure(): Promise<void> {
  const { from, to, meters } = measured.peek();
  try {
    const said = await collisions.measureDistances({ first: [from], second: to ? [to] : [], rangeMeters: meters });
    distances.value = said.pairs;
    unmeasured.value = "";
  } catch (error) {
    distances.value = [];
    unmeasured.value = wordsOf(error);
  }
}

export async function readSettings(): Promise<void> {
  const said = await attempt(collisions.getCollisionSettings({}));
  settings.value = said?.settings ?? settings.peek();
  guardCost.value = said?.guardCost ?? guardCost.peek();
}

export async function readAllowed(): Promise<void> {
  const said = await attempt(collisions.listAllowedPairs({}));
  if (said) allowed.value = said.pairs;
}

/** Changes what is done about collisions; what isn't named stays. */
export async function set(change: MessageInitShape<typeof SetCollisionSettingsSchema>): Promise<void> {
  await apply({ case: "setCollisionSettings", value: change });
  await readSettings();
}

/** Returns a robot's own mode; undefined where it has that of all. */
export function modeOf(robot: string): Mode | undefined {
  return nameOf(settings.value?.robots.find((one) => one.robot === robot)?.mode);
}

export function nameOf(mode: CollisionMode | undefined): Mode | undefined {
  return (Object.keys(MODES) as Mode[]).find((name) => MODES[name] === mode);
}

/** Whether there is a robot whose collisions are told. */
export function isWatched(): boolean {
  const all = settings.value?.mode ?? CollisionMode.OFF;
  return [all, ...(settings.value?.robots ?? []).map(({ mode }) => mode)].some((mode) => mode !== CollisionMode.OFF);
}

/** Lets two nodes touch; returns whether they may. */
export async function allow(first: string, second: string, reason: string): Promise<boolean> {
  const done = await apply({ case: "setAllowedPairs", value: { allow: [{ first, second, reason }] } });
  const bare = [first, second].find((name) => items.peek().get(name)?.node.figures.length === 0);
  if (done && bare) say(`${bare} has no figures of its own, so this changes nothing: name nodes below it, such as its links`, "warning");
  await readAllowed();
  return done;
}

/** Takes back what a client or an import has allowed. */
export async function forbid(first: string, second: string): Promise<void> {
  await apply({ case: "setAllowedPairs", value: { forbid: [{ first, second }] } });
  await readAllowed();
}

export function isMarked(first: string, second: string): boolean {
  return marked.value[0] === first && marked.value[1] === second;
}

/** Marks a pair in the view, and no other; the one that is marked, no more. */
export function mark(first: string, second: string): void {
  marked.value = isMarked(first, second) ? [] : [first, second];
}
