// The way that the chosen robot's tool centre point has gone lately.
import { BufferAttribute, BufferGeometry, Line, LineBasicMaterial, Vector3 } from "three";
import { chosen, states } from "../kernel/world";
import { positionOf } from "../parts/numbers";

const MOST = 900;
const APART_METERS = 0.004;

export class Trail {
  readonly line: Line<BufferGeometry, LineBasicMaterial>;
  #numbers = new Float32Array(3 * MOST);
  #count = 0;
  #robot = "";
  #last = new Vector3(Infinity, 0, 0);

  constructor() {
    const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(this.#numbers, 3));
    this.line = new Line(geometry, new LineBasicMaterial({ color: 0x38bdf8, transparent: true, opacity: 0.85 }));
    this.line.frustumCulled = false;
    this.line.visible = false;
  }

  toggle(): boolean {
    this.#count = 0;
    this.line.visible = !this.line.visible;
    return this.line.visible;
  }

  /** Adds where the robot is now; returns whether that is seen. */
  follow(): boolean {
    if (!this.line.visible) return false;
    if (this.#robot !== chosen.peek()) this.#count = 0;
    this.#robot = chosen.peek();
    const now = new Vector3(...positionOf(states.peek().get(this.#robot)?.worldTTcp));
    if (this.#count > 0 && now.distanceTo(this.#last) < APART_METERS) return false;
    if (this.#count === MOST) {
      this.#numbers.copyWithin(0, MOST);
      this.#count -= MOST / 3;
    }
    now.toArray(this.#numbers, 3 * this.#count++);
    this.#last = now;
    this.line.geometry.getAttribute("position").needsUpdate = true;
    this.line.geometry.setDrawRange(0, this.#count);
    return true;
  }
}
