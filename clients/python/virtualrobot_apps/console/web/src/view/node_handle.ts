// Handle at the selected node, which moves or turns it: dragged, a ghost shows where the node would be; let go, it is there. It
// snaps to a raster and, by the boxes around figures, to the faces of what is beside it; turned, to steps of an angle.
import { computed, effect, signal } from "@preact/signals";
import { MathUtils, Matrix4, Object3D, Quaternion, Vector3, type Box3 } from "three";
import { TransformControls } from "three/examples/jsm/controls/TransformControls.js";
import { place } from "../kernel/orders";
import { below, hearers, items, selected } from "../kernel/world";
import { inToolAxes, tool } from "./gizmo";
import { Ghost } from "./copies";
import { poseOf } from "./poses";
import type { Viewport } from "./viewport";

const RASTER_METERS = 0.01;
const NEAR_METERS = 0.02;
const STEP_DEGREES = 5;
const FLOOR = "the floor";
const AXES = ["x", "y", "z"] as const;
const ONE = new Vector3(1, 1, 1);

/** Whether what is dragged snaps. */
export const snaps = signal(true);

/** Where a node would be that is dragged, in the world's frame, and what its faces have snapped to. */
export interface Dragged {
  name: string;
  position: Vector3;
  /** How far it has been turned from where it is; undefined while it is moved. */
  turnDegrees?: number;
  /** How large a figure would be; undefined while the node itself is moved or turned. */
  size?: { name: string; meters: number };
  beside: readonly string[];
}

export const draggedNode = signal<Dragged | undefined>(undefined);

/** The node that may be dragged; "" for none: the world and what is locked stay where they are, and links are where their joints have them. */
const movable = computed(() => {
  const item = items.value.get(selected.value);
  return item && item.kind !== "world" && item.kind !== "link" && !item.node.locked && (tool.value === "move" || tool.value === "turn") ? item.name : "";
});

export class NodeHandle {
  readonly objects: Object3D[];
  #handle = new Object3D();
  #controls: TransformControls;
  #ghost = new Ghost(0xf5a623);
  #start = new Matrix4();
  #box?: Box3;
  #others: (readonly [string, Box3])[] = [];
  dragging = false;

  constructor(private readonly view: Viewport) {
    this.#controls = new TransformControls(view.observer.camera, view.canvas);
    this.#controls.setSize(0.62);
    this.#controls.setColors(0xf0616d, 0x4cc38a, 0x4b9dff, 0xffd65c);
    this.objects = [this.#handle, this.#controls.getHelper(), this.#ghost.group];
    this.#controls.addEventListener("change", () => view.invalidate());
    this.#controls.addEventListener("objectChange", () => this.dragging && this.#show());
    this.#controls.addEventListener("dragging-changed", ({ value }) => (value ? this.#begin() : void this.#end()));
    hearers.poses.add(() => this.#follow());
    effect(() => {
      if (movable.value) this.#controls.attach(this.#handle);
      else this.#controls.detach();
      this.#controls.setMode(tool.value === "turn" ? "rotate" : "translate");
      this.#controls.setSpace(inToolAxes.value ? "local" : "world");
      this.#controls.setRotationSnap(snaps.value ? MathUtils.degToRad(STEP_DEGREES) : null);
      this.#controls.setTranslationSnap(snaps.value ? RASTER_METERS : null);
      this.#follow();
      view.invalidate();
    });
  }

  /** Leaves the node where it is. */
  leave(): void {
    if (!this.dragging) return;
    this.#start.decompose(this.#handle.position, this.#handle.quaternion, new Vector3());
    this.#controls.dragging = false;
  }

  #follow(): void {
    const now = this.view.solids.places.get(movable.peek());
    if (now && !this.dragging) now.decompose(this.#handle.position, this.#handle.quaternion, new Vector3());
  }

  #begin(): void {
    const name = movable.peek(), { solids } = this.view;
    const along = new Set(below(name));
    this.dragging = true;
    this.view.observer.orbit.enabled = false;
    this.#start.copy(this.#at());
    this.#box = solids.boxOf(along);
    this.#others = [...solids.pieces.keys()].filter((one) => !along.has(one)).map((one) => [one, solids.boxOf([one])] as const);
    this.#show();
  }

  #show(): void {
    const name = movable.peek(), { pieces, places } = this.view.solids;
    const turns = tool.peek() === "turn";
    const beside = snaps.peek() && !turns ? this.#snap() : [];
    const motion = this.#at().multiply(this.#start.clone().invert());
    const there = new Map<string, Matrix4>();
    for (const one of below(name)) {
      const now = places.get(one);
      if (now) there.set(one, motion.clone().multiply(now));
    }
    this.#ghost.show(there, pieces, places);
    const before = new Quaternion().setFromRotationMatrix(this.#start);
    const turnDegrees = turns ? MathUtils.radToDeg(this.#handle.quaternion.angleTo(before)) : undefined;
    draggedNode.value = { name, position: this.#handle.position.clone(), turnDegrees, beside };
    this.view.invalidate();
  }

  /** Puts faces that are nearly at faces of others there, along the world's axes that are dragged; returns whose these are. */
  #snap(): string[] {
    if (!this.#box || this.#box.isEmpty()) return [];
    const box = this.#box.clone().translate(this.#handle.position.clone().sub(new Vector3().setFromMatrixPosition(this.#start)));
    const near = this.#others.filter(([, other]) => other.clone().expandByScalar(NEAR_METERS).intersectsBox(box));
    const found = new Set<string>();
    for (const axis of AXES.filter((one) => this.#controls.axis?.toLowerCase().includes(one))) {
      const gaps: (readonly [number, string])[] = axis === "z" ? [[-box.min.z, FLOOR]] : [];
      for (const [name, { min, max }] of near) {
        for (const face of [min[axis], max[axis]]) gaps.push([face - box.min[axis], name], [face - box.max[axis], name]);
      }
      const [least] = gaps.filter(([gap]) => Math.abs(gap) < NEAR_METERS).sort(([one], [other]) => Math.abs(one) - Math.abs(other));
      if (!least) continue;
      this.#handle.position[axis] += least[0];
      found.add(least[1]);
    }
    return [...found];
  }

  /** Tells the kernel where the node is now; the ghost stays until it has answered. */
  async #end(): Promise<void> {
    const item = items.peek().get(movable.peek()), there = this.#at();
    const parent = this.view.solids.places.get(item?.parent ?? "") ?? new Matrix4();
    this.view.observer.orbit.enabled = true;
    if (item && !there.equals(this.#start)) await place(item.name, poseOf(parent.clone().invert().multiply(there)));
    this.dragging = false;
    draggedNode.value = undefined;
    this.#ghost.hide();
    this.#follow();
    this.view.invalidate();
  }

  #at(): Matrix4 {
    return new Matrix4().compose(this.#handle.position, this.#handle.quaternion, ONE);
  }
}
