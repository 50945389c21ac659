// Films that the console's server takes: of the view from where it is, or of a camera of the scene.
import { signal } from "@preact/signals";
import { askConsole } from "./console_calls";
import { attempt } from "./messages";
import type { Viewpoint } from "./viewpoints";

/** A film as the console's server tells it. */
export interface Film {
  name: string;
  /** The camera of the scene that takes it; "" for the view. */
  camera: string;
  /** Taken; drawn, when all is taken; whole. */
  phase: "taken" | "drawn" | "whole" | "failed";
  /** Simulation time that is drawn. */
  seconds: number;
  /** Pictures of what has happened that are still to be drawn. */
  behind: number;
  bytes: number;
  fault: string;
}

export type Size = readonly [width: number, height: number];

const LOOK_MS = 500;
const RADIANS = Math.PI / 180;

/** The newest first. */
export const films = signal<readonly Film[]>([]);

export const filming = () => films.value.some(({ phase }) => phase === "taken");

export async function look(): Promise<void> {
  try {
    films.value = await askConsole<Film[]>("/films");
  } catch {
    // The page says already that console or kernel are gone.
  }
}

/** Begins a film of a camera of the scene with its own size, or of the view from one place. */
export function start(from: string | Viewpoint, size?: Size): Promise<boolean> {
  const camera = typeof from === "string" ? from : { position: from.position, target: from.target, field: from.fieldDegrees * RADIANS };
  return ask("start", { camera, size });
}

export const stop = (name: string) => ask("stop", { name });
export const remove = (name: string) => ask("remove", { name });

/** Looks again and again while somebody looks, or a film is taken, until the returned function is called. */
export function followed(): () => void {
  void look();
  const timer = setInterval(() => void look(), LOOK_MS);
  return () => clearInterval(timer);
}

async function ask(verb: string, said: object): Promise<boolean> {
  const done = await attempt(askConsole(`/films/${verb}`, said));
  await look();
  return done !== undefined;
}
