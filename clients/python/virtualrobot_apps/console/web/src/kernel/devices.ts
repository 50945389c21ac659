// Gamepads, space mice and the keyboard, which lead the chosen robot while their dead man's button is held, and move the view
// while it isn't, as a mapping says: the same files as at the command line, which the console reads.
import { signal } from "@preact/signals";
import { askConsole } from "./console_calls";
import { readPad } from "./gamepad";
import { keyboard } from "./keyboard";
import { craftOf, jointsOf, toolOf } from "./leads";
import { attempt, say } from "./messages";
import { hold, release, type Led } from "./setpoints";
import { mouse } from "./space_mouse";
import { robots } from "./world";

export type Device = "gamepad" | "space-mouse" | "keyboard";

/** How a device is: axes from -1 to 1, and the buttons that are down, by the names that mappings have for them. */
export interface State {
  name: string;
  axes: Readonly<Record<string, number>>;
  buttons: ReadonlySet<string>;
}

interface Control {
  axis: string;
  sign: number;
  /** That for 1, and that for -1. */
  buttons: readonly [string, string];
}

type Controls = Readonly<Record<string, Control>>;

export interface Mapping {
  hold: string;
  dead_zone: number;
  drive: Controls;
  jog: Controls;
  tool: Controls;
  frame: string;
  camera: Controls;
  slower: string;
  faster: string;
}

const PERIOD_MS = 50;
const DIRECTIONS = ["forward", "left", "turn"];
const TOOL = ["vx", "vy", "vz", "wx", "wy", "wz"];
const CAMERA = ["right", "up", "nearer", "turn", "tilt"];
const NAMES: Record<Device, string> = { gamepad: "gamepad", "space-mouse": "space mouse", keyboard: "keyboard" };
const READ: Record<Device, () => State | undefined> = { gamepad: readPad, "space-mouse": () => mouse.state, keyboard: () => keyboard.state };

/** Moves the view by parts of CAMERA, -1 to 1, for so many seconds. */
export type Look = (parts: readonly number[], seconds: number) => void;

/** What a device means, the file of it ("" for the usual one), and its share of the speeds, 0.1 to 1. */
class Meaning {
  readonly mapping = signal<Mapping | undefined>(undefined);
  readonly file = signal("");
  readonly share = signal(1);
  /** Name of the device that is there, "" for none. */
  readonly name = signal("");
  #asked = false;
  #pressed: ReadonlySet<string> = new Set();
  #robot = "";
  /** Whether the dead man's button has to be let go before it counts. */
  #spent = false;

  constructor(readonly device: Device) {}

  /** Takes a file, or the usual mapping. */
  async read(file?: File): Promise<void> {
    this.#asked = true;
    const said = { device: this.device, name: file?.name ?? "", text: await file?.text() };
    const mapping = await attempt(askConsole<Mapping>("/mapping", said));
    if (!mapping) return;
    release(this.device);
    this.#spent = !!READ[this.device]()?.buttons.has(mapping.hold);
    this.mapping.value = mapping;
    this.file.value = file?.name ?? "";
    if (file) say(`${file.name}: it counts for the ${NAMES[this.device]} of this page`, "good");
  }

  /** Leads a robot as the device says now, or moves the view. One that has gone lets go, and so does a window that is left. */
  lead(robot: string, look: Look): void {
    const state = READ[this.device]();
    this.name.value = state?.name ?? "";
    if (state && !this.#asked) void this.read();
    const mapping = this.mapping.peek();
    if (!state) return this.letGo();
    if (!mapping) return;
    const isHeld = state.buttons.has(mapping.hold);
    this.#spent = isHeld && (this.#spent || robot !== this.#robot || !document.hasFocus());
    this.#robot = robot;
    for (const [button, change] of [[mapping.slower, -0.1], [mapping.faster, 0.1]] as const) {
      if (button && state.buttons.has(button) && !this.#pressed.has(button)) this.share.value = Math.min(1, Math.max(0.1, this.share.value + change));
    }
    this.#pressed = state.buttons;
    if (!isHeld && document.hasFocus()) {
      const parts = CAMERA.map((name) => valueOf(mapping.camera[name], state, mapping.dead_zone));
      if (parts.some(Boolean)) look(parts, PERIOD_MS / 1000);
    }
    if (!isHeld || this.#spent) return release(this.device);
    const led = robot ? ledBy(robot, mapping) : undefined;
    if (led) return hold(led[0], this.device, led[1].map((control) => this.share.value * valueOf(control, state, mapping.dead_zone)));
    if (robot) say(`the mapping of the ${NAMES[this.device]} moves nothing of ${robot}`, "warning");
    this.letGo();
  }

  /** Lets go; its button has to be let go, too, before it counts again. */
  letGo(): void {
    this.#spent = true;
    release(this.device);
  }
}

export const gamepad = new Meaning("gamepad");
export const spaceMouse = new Meaning("space-mouse");
export const keys = new Meaning("keyboard");

/** Returns whether a robot drives by twists; what swims is told its thrusters instead. */
export function isCraft(robot: string): boolean {
  const craft = robots.value.get(robot)?.robot?.craft;
  return !!craft?.kinematics && !craft.water;
}

/** Returns what a mapping leads of a robot, and by which controls. */
function ledBy(robot: string, { drive, tool, jog, frame }: Mapping): [Led, (Control | undefined)[]] | undefined {
  if (isCraft(robot)) return Object.keys(drive).length > 0 ? [craftOf(robot), DIRECTIONS.map((name) => drive[name])] : undefined;
  if (Object.keys(tool).length > 0) return [toolOf(robot, frame), TOOL.map((name) => tool[name])];
  const single = (robots.peek().get(robot)?.joints ?? []).filter(({ coordinateCount }) => coordinateCount === 1).map(({ name }) => name);
  const names = Object.entries(jog).map(([name, control]) => [single.includes(name) ? name : single[Number(name) - 1], control] as const);
  const known = names.filter(([name]) => name !== undefined);
  return known.length > 0 ? [jointsOf(robot, known.map(([name]) => name)), known.map(([, control]) => control)] : undefined;
}

/** Returns a control's value: 0 within the dead zone, from there on growing to 1. */
function valueOf(control: Control | undefined, { axes, buttons }: State, deadZone: number): number {
  if (!control) return 0;
  if (!control.axis) return Number(buttons.has(control.buttons[0])) - Number(buttons.has(control.buttons[1]));
  const moved = axes[control.axis] ?? 0;
  return control.sign * Math.sign(moved) * Math.max(0, Math.min(1, (Math.abs(moved) - deadZone) / (1 - deadZone)));
}

/** Reads the devices for a robot, "" for none, and the view, until the returned function is called. */
export function readDevices(robot: () => string, look: Look): () => void {
  const all = [gamepad, spaceMouse, keys];
  const timer = setInterval(() => all.forEach((one) => one.lead(robot(), look)), PERIOD_MS);
  return () => {
    clearInterval(timer);
    all.forEach((one) => one.letGo());
  };
}
