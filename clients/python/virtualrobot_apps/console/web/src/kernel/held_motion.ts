// A motion that runs only while somebody holds it, by beats of whoever reads the trigger: without one for 0.2 s the kernel
// brakes it on its path. There is no timer in it, so that what stands still lets go.
import { motions } from "./services";

/** The beats of one press. */
class Press {
  #isOver = false;
  #isDue = true;
  #wake = () => {};

  beat(): void {
    this.#isDue = true;
    this.#wake();
  }

  end(): void {
    this.#isOver = true;
    this.#wake();
  }

  get isOver(): boolean {
    return this.#isOver;
  }

  async *told(id: string) {
    while (!this.#isOver) {
      if (this.#isDue) {
        this.#isDue = false;
        yield { id, sentSeconds: performance.now() / 1000 };
      } else await new Promise<void>((resolve) => (this.#wake = resolve));
    }
  }
}

export class HeldMotion {
  #press?: Press;
  /** Ends with the last press's call: the kernel takes one at a time. */
  #last: Promise<void> = Promise.resolve();

  /** `refused` is told why the kernel doesn't let it be held. */
  constructor(readonly id: string, private readonly refused: (error: unknown) => void) {}

  /** Tells that it is held now. */
  beat(): void {
    if (this.#press) return this.#press.beat();
    const press = (this.#press = new Press());
    this.#last = this.#last.then(() => this.#hold(press));
  }

  /** Has it brake at once. */
  letGo(): void {
    this.#press?.end();
    this.#press = undefined;
  }

  async #hold(press: Press): Promise<void> {
    if (press.isOver) return;
    try {
      for await (const _ of motions.holdMotion(press.told(this.id))) continue;
    } catch (error) {
      if (!press.isOver) this.refused(error);
    }
  }
}
