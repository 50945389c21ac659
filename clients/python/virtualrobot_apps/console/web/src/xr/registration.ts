// Where the cell stands in the real room: frames of the cell whose real places a person touches, one after the other. The
// console finds the room from them, and keeps it as a frame of the world where the person may change that.
import { signal } from "@preact/signals";
import { Matrix4, type Vector3 } from "three";
import { askConsole } from "../kernel/console_calls";
import { wordsOf } from "../kernel/words";
import { chosen, items } from "../kernel/world";
import { fixed } from "../parts/numbers";

/** Frames that are touched have names that begin so, and are touched in the order of these. */
const PREFIX = "touch";
const LEAST = 3;
/** The frame of the world that the room is kept as. */
export const KEPT = "headset";

interface Found {
  /** Row by row. */
  world_t_device: readonly number[];
  /** How far off (m) each touched point is. */
  residuals: readonly number[];
  /** Errors (m) at nodes that 95 of 100 registrations keep. */
  errors: Readonly<Record<string, number>>;
}

class Registration {
  /** The frame that is to be touched; "" for none. */
  readonly next = signal("");
  readonly words = signal("");
  #left: string[] = [];
  #points: { model: string; touched: number[] }[] = [];

  /** Asks for all frames to be touched; once more takes that back. */
  begin(): void {
    const names = [...items.peek().keys()].filter((name) => name.startsWith(PREFIX)).sort();
    const isRunning = this.next.peek() !== "";
    this.stop();
    if (isRunning) return;
    if (names.length < LEAST) {
      this.words.value = `three frames are needed, 0.6 m apart and not on a line, with names that begin with ${PREFIX}; there are ${names.length}`;
      return;
    }
    this.#left = names;
    this.#ask();
  }

  /** Takes a point of the room as the next frame's; returns world_t_room with the last one. */
  async touch({ x, y, z }: Vector3): Promise<Matrix4 | undefined> {
    const model = this.#left.shift();
    if (model === undefined) return undefined;
    this.#points.push({ model, touched: [x, y, z] });
    this.#ask();
    return this.#left.length > 0 ? undefined : this.#find();
  }

  /** Says that a finger has to be still before it pinches. */
  askForStill(): void {
    this.#ask("hold the fingertip still there for a second, and then pinch");
  }

  stop(): void {
    this.#left = [];
    this.#points = [];
    this.next.value = this.words.value = "";
  }

  #ask(how = "put the tip there and pull the trigger; a finger is still for a second, and then pinches"): void {
    this.next.value = this.#left[0] ?? "";
    this.words.value = this.next.peek() && `${this.#points.length + 1} of ${this.#points.length + this.#left.length}: ${how}`;
  }

  async #find(): Promise<Matrix4 | undefined> {
    const robot = chosen.peek(), said = { up: "y", points: this.#points, tools: robot ? [robot] : [], ...(robot && { relative_to: robot }) };
    let note = "";
    const keep = async () => askConsole<Found>("/registration/touched", { ...said, frame: KEPT });
    try {
      const found = await keep().catch((error: unknown) => {
        // Who may only look may register all the same.
        note = `not kept: ${wordsOf(error)}`;
        return askConsole<Found>("/registration/touched", said);
      });
      const off = Math.max(...found.residuals), error = found.errors[robot];
      const good = error === undefined ? "" : `the robot is right to ${millimeters(error)} in 95 of 100 cases`;
      this.words.value = [`registered, points off by ${millimeters(off)} at most`, good, note].filter(Boolean).join("; ");
      return new Matrix4().fromArray([...found.world_t_device]).transpose();
    } catch (error) {
      this.words.value = wordsOf(error);
      return undefined;
    } finally {
      this.#points = [];
    }
  }
}

export const registration = new Registration();

function millimeters(meters: number): string {
  return `${fixed(1000 * meters, 1)} mm`;
}
