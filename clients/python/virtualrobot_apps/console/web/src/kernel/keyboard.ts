// The keyboard as a device with a mapping: which keys are down, by what stands on them in the layout of the United States.
import type { State } from "./devices";

const ARROWS: Readonly<Record<string, string>> = { ArrowUp: "arrow_up", ArrowDown: "arrow_down", ArrowLeft: "arrow_left", ArrowRight: "arrow_right" };

class Keyboard {
  /** Whether a person has said that it leads robots. */
  isUsed = false;
  #down = new Set<string>();

  constructor() {
    addEventListener("keydown", (event) => this.#hear(event, true), { capture: true });
    addEventListener("keyup", (event) => this.#hear(event, false), { capture: true });
    // Keys that go up elsewhere are told to nobody.
    addEventListener("blur", () => this.#down.clear());
  }

  /** How it is; undefined while it leads nothing. */
  get state(): State | undefined {
    return this.isUsed ? { name: "keyboard", axes: {}, buttons: new Set(this.#down) } : undefined;
  }

  #hear(event: KeyboardEvent, down: boolean): void {
    const name = nameOf(event.code);
    if (!name) return;
    if (down && !isTyped(event) && !event.ctrlKey && !event.metaKey && !event.altKey) this.#down.add(name);
    else if (!down) this.#down.delete(name);
  }
}

function nameOf(code: string): string {
  if (code === "ShiftLeft" || code === "ShiftRight") return "shift";
  return ARROWS[code] ?? /^(?:Key|Digit)(\w)$/.exec(code)?.[1].toLowerCase() ?? "";
}

function isTyped({ target }: KeyboardEvent): boolean {
  return target instanceof HTMLInputElement || target instanceof HTMLTextAreaElement || target instanceof HTMLSelectElement;
}

export const keyboard = new Keyboard();
