// What this browser can show in a room, and why it can't.
import { signal } from "@preact/signals";

export type Mode = "immersive-ar" | "immersive-vr";

const MODES: readonly Mode[] = ["immersive-ar", "immersive-vr"];

/** What can be entered, and, where that is nothing, the reason for people. */
export const able = signal<readonly Mode[]>([]);
export const why = signal("");

const NO_TLS = "This page came by http from another machine: browsers show a cell in a room, and a camera, take files and know space mice only by https. `virtualrobot console --listen 0.0.0.0 --own-certificate` has it; all else works here, Still and what is proposed among it";
const NO_XR = "This browser has no WebXR: browsers of headsets have it, Chrome on Android, and Chrome and Edge with a headset at the computer";
const NO_DEVICE = "This browser finds no headset, and has no augmented reality of its own";

/** Why a browser refused to begin, by the name of its error. */
const REFUSED: Record<string, string> = {
  NotAllowedError: "the browser was not allowed to: allow this page virtual and augmented reality, and press the button again",
  NotSupportedError: "this headset or phone has not what it takes: a floor that it knows",
  InvalidStateError: "another page is shown in the headset: leave it first",
  SecurityError: "the browser doesn't let this page: open it in a tab of its own, and press the button there",
};

/** Browsers that don't say within that time (ms) what can be entered have nothing. */
const PATIENCE_MS = 500;
let asked: Promise<void> | undefined;

/** Finds out what can be entered, and does so again when a headset comes or goes. */
export function look(): void {
  navigator.xr?.addEventListener("devicechange", () => void ask());
  asked = ask();
}

/** Whether the cell is drawn by a headset or a phone, to which each triangle and byte counts. */
export async function isSmall(): Promise<boolean> {
  if (matchMedia("(pointer: coarse)").matches) return true;
  await Promise.race([asked, new Promise((go) => setTimeout(go, PATIENCE_MS))]);
  return able.peek().length > 0;
}

async function ask(): Promise<void> {
  if (!navigator.xr) {
    why.value = isSecureContext ? NO_XR : NO_TLS;
    return;
  }
  const { xr } = navigator;
  try {
    const can = await Promise.all(MODES.map((mode) => xr.isSessionSupported(mode)));
    able.value = MODES.filter((_, place) => can[place]);
    why.value = able.value.length > 0 ? "" : NO_DEVICE;
  } catch (error) {
    able.value = [];
    why.value = reasonOf(error);
  }
}

/** Returns why a browser refuses, for people. */
export function reasonOf(error: unknown): string {
  const { name, message } = error as DOMException;
  return REFUSED[name] ?? message;
}
