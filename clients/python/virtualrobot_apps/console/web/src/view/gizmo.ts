// Handle at the tool centre point of the chosen robot: dragged, it asks for the postures that reach there.
import { effect, signal } from "@preact/signals";
import { Matrix4, Object3D, Quaternion, Vector3 } from "three";
import { TransformControls } from "three/examples/jsm/controls/TransformControls.js";
import { goal, type Goal } from "../kernel/goal";
import { chosen, hearers, states } from "../kernel/world";
import { orientationOf, positionOf } from "../parts/numbers";
import { placesIn } from "./postures";
import type { Viewport } from "./viewport";

export type Tool = "select" | "translate" | "rotate" | "move" | "turn" | "size";

/** What the pointer does in the view, besides clicks: drag or turn the robot's tool, or move, turn or size the selected node; and whether the tool's handle has its axes. */
export const tool = signal<Tool>("select");
export const inToolAxes = signal(false);

export class Gizmo {
  readonly objects: Object3D[];
  #handle = new Object3D();
  #controls: TransformControls;
  #showing = 0;
  /** Where the base of the robot was when it was asked where its ghost stands. */
  #base = new Matrix4();
  dragging = false;

  constructor(private readonly view: Viewport) {
    this.#controls = new TransformControls(view.observer.camera, view.canvas);
    this.#controls.setSize(0.62);
    this.#controls.setColors(0xf0616d, 0x4cc38a, 0x4b9dff, 0xffd65c);
    this.objects = [this.#handle, this.#controls.getHelper()];
    this.#controls.addEventListener("change", () => view.invalidate());
    this.#controls.addEventListener("dragging-changed", ({ value }) => {
      this.dragging = Boolean(value);
      view.observer.orbit.enabled = !this.dragging;
    });
    this.#controls.addEventListener("objectChange", () => this.dragging && this.#ask());
    hearers.states.add(() => this.#follow());
    hearers.poses.add(() => this.#renew());
    effect(() => {
      const mode = tool.value;
      if ((mode !== "translate" && mode !== "rotate") || !chosen.value) this.#controls.detach();
      else {
        this.#controls.attach(this.#handle);
        this.#controls.setMode(mode);
      }
      this.#controls.setSpace(inToolAxes.value ? "local" : "world");
      this.#follow();
      view.invalidate();
    });
    effect(() => void this.#show(goal.shown.value));
  }

  #ask(): void {
    const { x, y, z } = this.#handle.position, turn = this.#handle.quaternion;
    goal.ask(chosen.peek(), { position: { x, y, z }, orientation: { x: turn.x, y: turn.y, z: turn.z, w: turn.w } });
  }

  #follow(): void {
    const pose = states.peek().get(chosen.peek())?.worldTTcp;
    if (!pose || this.dragging || goal.shown.peek()) return;
    const { x, y, z, w } = orientationOf(pose);
    this.#handle.position.copy(new Vector3(...positionOf(pose)));
    this.#handle.quaternion.copy(new Quaternion(x, y, z, w));
  }

  /** Shows the chosen robot where a goal has it. */
  async #show(shown: Goal | undefined): Promise<void> {
    const number = ++this.#showing;
    if (shown === undefined) {
      this.view.ghost.hide();
      this.#follow();
      this.view.invalidate();
      return;
    }
    this.view.ghost.isAwaited = true;
    this.#base.copy(this.view.solids.places.get(shown.robot) ?? this.#base);
    this.view.invalidate();
    const there = await placesIn(this.view, shown);
    if (number !== this.#showing) return;
    this.view.ghost.isAwaited = false;
    if (!there) return;
    this.view.ghost.show(there, this.view.solids.pieces, this.view.solids.places);
    this.view.invalidate();
    this.#renew();
  }

  /** Shows the ghost anew where the robot's base has moved since: its links stand on that. */
  #renew(): void {
    const shown = goal.shown.peek(), base = shown && this.view.solids.places.get(shown.robot);
    if (base && !this.view.ghost.isAwaited && !base.equals(this.#base)) void this.#show(shown);
  }
}
