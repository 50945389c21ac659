// The ball at the tool that a hand takes to where the tool shall be: gripped when it is near, or taken by a ray from afar.
import { AxesHelper, Group, Matrix4, Mesh, MeshStandardMaterial, Ray, Sphere, SphereGeometry, Vector3 } from "three";
import { goal } from "../kernel/goal";
import { chosen, states } from "../kernel/world";
import { matrixOf, poseOf } from "../view/poses";
import { proposal } from "./proposal";
import { leads, teleop } from "./teleop";

const YELLOW = 0xffd65c, RED = 0xe5393f;
const BALL_METERS = 0.03, AXES_METERS = 0.14;
/** How near (m) a grip takes hold, and by how much a ray may miss the middle. */
const REACH_METERS = 0.12, AIM_METERS = 0.05;
/** A hand that lets go jerks: where it was so long (ms) before counts. */
const BEFORE_MS = 80;
/** Elements of poses (m, or parts of a turn) that differ by less are the same: a hand is never quite still. */
const SAME = 2e-4;

interface Taken {
  source: XRInputSource;
  by: "grip" | "ray";
  /** The ball in the frame of what took it. */
  offset: Matrix4;
  trail: { time: number; pose: Matrix4 }[];
}

export class Handle {
  readonly group = new Group();
  #ball = new Mesh(new SphereGeometry(BALL_METERS, 24, 16), new MeshStandardMaterial({ color: YELLOW }));
  #axes = new AxesHelper(AXES_METERS);
  #taken?: Taken;
  #asked = new Matrix4();
  #scale = 1;

  constructor() {
    this.group.add(this.#ball, this.#axes);
    this.group.matrixAutoUpdate = false;
  }

  /** Has as many meters of the world as there are for each of the room: it is as large, and as easily taken, in each size of the cell. */
  set scale(meters: number) {
    this.#scale = meters;
    this.#ball.scale.setScalar(meters);
    this.#axes.scale.setScalar(meters);
  }

  /** The hand that has taken it. */
  get source(): XRInputSource | undefined {
    return this.#taken?.source;
  }

  /** Takes it by a hand, whose poses are in the world; returns whether it was in reach. */
  take(source: XRInputSource, grip: Matrix4 | undefined, ray: Matrix4 | undefined): boolean {
    if (this.#taken || proposal.isBegun || !this.group.visible) return false;
    const here = new Vector3().setFromMatrixPosition(this.group.matrix);
    const isNear = grip && new Vector3().setFromMatrixPosition(grip).distanceTo(here) < REACH_METERS * this.#scale;
    const by = isNear ? "grip" : ray && rayOf(ray).intersectsSphere(new Sphere(here, AIM_METERS * this.#scale)) ? "ray" : undefined;
    const from = by && { grip, ray }[by];
    if (!by || !from) return false;
    this.#taken = { source, by, offset: from.clone().invert().multiply(this.group.matrix), trail: [] };
    this.#asked.copy(this.group.matrix);
    return true;
  }

  /** Goes along with the hand that has taken it, and asks for where it is; at `time` (ms). */
  drag(grip: Matrix4 | undefined, ray: Matrix4 | undefined, time: number): void {
    const from = this.#taken && { grip, ray }[this.#taken.by];
    if (!this.#taken || !from) return;
    const { offset, trail } = this.#taken, pose = from.clone().multiply(offset);
    while (trail.length > 1 && trail[1].time <= time - BEFORE_MS) trail.shift();
    trail.push({ time, pose });
    if (!leads.peek()) return this.#ask(pose);
    this.#put(pose);
    teleop.lead(chosen.peek(), pose);
  }

  /** Leaves it where it was before the hand began to let go, and has the way there planned. */
  drop(): void {
    const { trail = [] } = this.#taken ?? {};
    this.#taken = undefined;
    teleop.end();
    if (trail.length === 0 || leads.peek()) return;
    this.#ask(trail[0].pose);
    void proposal.letGoal();
  }

  /** Stands at the goal, or at the tool where there is none. */
  follow(): void {
    this.#ball.material.color.set(goal.reach.peek() === "unreachable" ? RED : YELLOW);
    if (this.#taken) return;
    const pose = goal.pose.peek() ?? states.peek().get(chosen.peek())?.worldTTcp;
    this.group.visible = pose !== undefined;
    if (pose) this.#put(matrixOf(pose));
  }

  dispose(): void {
    this.#ball.geometry.dispose();
    this.#ball.material.dispose();
    this.#axes.dispose();
  }

  #ask(pose: Matrix4): void {
    this.#put(pose);
    if (pose.elements.every((value, place) => Math.abs(value - this.#asked.elements[place]) < SAME)) return;
    this.#asked.copy(pose);
    proposal.ask(chosen.peek(), poseOf(pose));
  }

  #put(pose: Matrix4): void {
    this.group.matrix.copy(pose);
    this.group.matrixWorldNeedsUpdate = true;
  }
}

/** Returns the ray along -z of a pose. */
export function rayOf(pose: Matrix4): Ray {
  return new Ray(new Vector3().setFromMatrixPosition(pose), new Vector3(0, 0, -1).transformDirection(pose));
}
