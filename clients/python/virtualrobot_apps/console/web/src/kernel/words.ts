// The kernel's words as people read them here: millimeters and degrees, figures of use, steps as the program's list counts
// them, and who somebody is.
import { ConnectError } from "@connectrpc/connect";
import { DEGREES } from "../parts/numbers";

/** What is quoted is a name, and stays as it is; an apostrophe within a word quotes nothing. */
const QUOTED = /((?<!\w)'(?:[^'\\]|\\.)*'(?!\w)|"(?:[^"\\]|\\.)*")/;
const NUMBER = String.raw`-?\d+(?:\.\d+)?(?:e[+-]?\d+)?`;
/** Numbers that have one unit together: `x 0.1, y 0.2, z 0.3`, `0 to 0.2`. */
const NUMBERS = String.raw`(?<![\w.])${NUMBER}(?:(?:, | to | of )(?:[xyz] )?${NUMBER})*`;

/** What the kernel counts in, by how it is written, and what people read. */
const UNITS: readonly (readonly [written: RegExp, factor: number, unit: string])[] = [
  [new RegExp(`(${NUMBERS}) m(/s)?(?![\\w/^])`, "g"), 1000, " mm"],
  [new RegExp(`(${NUMBERS}) rad(/s)?(?![\\w/^])`, "g"), DEGREES, "°"],
  [new RegExp(`(${NUMBERS}) mm(/s)?(?![\\w/^])`, "g"), 1, " mm"],
  [new RegExp(`(${NUMBERS}) degrees(/s)?(?![\\w/^])`, "g"), 1, "°"],
];

/** What the kernel tells those who write programs, and what it is in this page. */
const SAID: readonly (readonly [RegExp, string])[] = [
  [/the cell is stopped: .*? stopped it at .*; nothing moves until it is released, by .*$/s, "all robots are stopped: press Release, and then this again"],
  [/an operator moves and changes what the call has leased, and (.*?) is free: lease it/g, "an operator leases a robot before moving it, and $1 is free: press Lease at the pendant"],
  [/; \S+ m: millimetres\? lengths are in meters/g, ""],
  [/; \S+ rad is \S+ turns: degrees\? use `math\.radians` or `--degrees`/g, ""],
  [/: degrees or millimetres\? speeds are in rad\/s and m\/s/g, ""],
];

/** Returns a sentence of the kernel for people. */
export function forPeople(said: string): string {
  const text = SAID.reduce((before, [written, words]) => before.replace(written, words), said);
  return outsideQuotes(text, (part) => UNITS.reduce((before, [written, factor, unit]) => before.replace(written, (_, numbers: string, second = "") => {
    const shown = numbers.replace(new RegExp(NUMBER, "g"), (number) => figure(factor * Number(number)));
    return `${shown}${unit}${second as string}`;
  }), part));
}

/** Returns why a call was refused, or ended, for people. */
export function wordsOf(error: unknown): string {
  return forPeople(ConnectError.from(error).rawMessage);
}

/** Returns a sentence about steps, which the kernel counts from 0 in what it was given: that began with step `from` of a list. */
export function asListed(said: string, from: number): string {
  return outsideQuotes(said, (part) => part.replace(/\bstep (\d+(?:\[\d+\])?(?:\.\d+(?:\[\d+\])?)*)/g, (_, path: string) => {
    const [first, ...within] = path.split(".").map((place) => /^(\d+)(?:\[(\d+)\])?$/.exec(place)!.slice(1));
    const words = ([place, round]: string[], before: number) => `step ${Number(place) + before + 1}${round === undefined ? "" : `, round ${Number(round) + 1}`}`;
    return [words(first, from), ...within.map((one) => words(one, 0))].join(", ");
  }));
}

/** Returns who an author of the kernel's history is: the name of a token, else what the client calls itself. */
export function personOf(author: string): string {
  const [, who] = /^(.*?)(?: at [a-z\d]+:\S*)?$/s.exec(author)!;
  const named = who.lastIndexOf(" with ");
  if (named > 0) return who.slice(0, named);
  const [, from] = /^console(?: on (\S+))?$/.exec(who) ?? [];
  if (who !== "console" && from === undefined) return who;
  return from === undefined || /^(127\.|::1$|localhost$)/.test(from) ? "a page of the console" : `a page of the console on ${from}`;
}

function outsideQuotes(text: string, change: (part: string) => string): string {
  return text.split(QUOTED).map((part, place) => (place % 2 ? part : change(part))).join("");
}

/** Returns a number with a figure after the point, and three where it is small. */
function figure(value: number): string {
  return String(Number(value.toFixed(Math.abs(value) < 1 ? 3 : 1)) + 0);
}
