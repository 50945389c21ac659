// What is proposed, as it is seen in the world: ghosts of the goal, of the whole way or of one moment of it, and the way of the
// tool as a line.
import { effect } from "@preact/signals";
import { BufferGeometry, Float32BufferAttribute, Group, Line, LineBasicMaterial, type Matrix4 } from "three";
import { rowAt } from "../kernel/trajectory";
import { below, chosen } from "../kernel/world";
import { placesIn } from "../view/postures";
import type { Viewport } from "../view/viewport";
import { Ghosts } from "./ghosts";
import { look } from "./looks";
import { proposal, type Way } from "./proposal";

/** Moments of a way that are shown at once. */
const MOMENTS = 8;

export class ShownWay {
  readonly group = new Group();
  #ghosts = new Ghosts(MOMENTS);
  #line = new Line(new BufferGeometry(), new LineBasicMaterial({ color: 0xffd65c }));
  #asked = 0;
  #goal?: ReadonlyMap<string, Matrix4>;
  #ends: (() => void)[];

  constructor(private readonly view: Viewport) {
    this.#line.frustumCulled = false;
    this.group.add(this.#ghosts.group, this.#line);
    this.#ends = [
      effect(() => {
        void chosen.value;
        this.rebuild();
      }),
      effect(() => this.#ghosts.tint(look.value.color)),
      effect(() => void this.#show(proposal.way.value, proposal.moment.value)),
      effect(() => this.#draw(proposal.way.value)),
    ];
  }

  /** Makes ghosts of what the chosen robot looks like now. */
  rebuild(): void {
    this.#ghosts.rebuild(below(chosen.peek()), this.view.solids.pieces);
  }

  /** Follows the goal's ghost, which the page asks for, as long as there is no way. */
  advance(): void {
    const { there } = this.view.ghost;
    if (proposal.way.peek() || there === this.#goal) return;
    this.#goal = there;
    this.#ghosts.show(there.size > 0 ? [there] : []);
  }

  dispose(): void {
    for (const end of this.#ends) end();
    this.#asked++;
    this.#ghosts.rebuild([], this.view.solids.pieces);
    this.#line.geometry.dispose();
  }

  async #show(way: Way | undefined, moment: number | undefined): Promise<void> {
    const number = ++this.#asked;
    this.#goal = undefined;
    if (!way) return;
    const whole = way.times.at(-1)!;
    const times = moment === undefined ? Array.from({ length: MOMENTS }, (_, place) => (whole * (place + 1)) / MOMENTS) : [moment];
    const asked = times.map((time) => {
      const row = rowAt(way.times, way.positions, time);
      const jointPositions = Object.fromEntries(way.joints.map((name, place) => [name, row[place]]));
      return placesIn(this.view, { robot: way.robot, jointPositions });
    });
    const moments = await Promise.all(asked);
    if (number === this.#asked) this.#ghosts.show(moments.filter((one) => one !== undefined));
  }

  #draw(way: Way | undefined): void {
    this.#line.geometry.dispose();
    this.#line.geometry = new BufferGeometry().setAttribute("position", new Float32BufferAttribute((way?.points ?? []).flat(), 3));
    this.#line.visible = way !== undefined;
  }
}
