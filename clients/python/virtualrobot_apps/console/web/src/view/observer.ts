// Where the view is looked at from: the camera, how it is turned by the pointer, and the axes in the corner.
import { signal } from "@preact/signals";
import { MathUtils, PerspectiveCamera, Spherical, Vector3, type Box3, type Matrix4, type WebGLRenderer } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { ViewHelper } from "three/examples/jsm/helpers/ViewHelper.js";
import { readViewpoint, type Viewpoint } from "../kernel/viewpoints";

const FROM = new Vector3(0.62, -0.78, 0.5).normalize();
const LARGEST = 12;
/** What a key does: turns (rad), goes nearer (factor), shifts (part of the distance). */
const KEY = { turn: Math.PI / 36, nearer: 0.87, shift: 0.05 };
/** Greatest speeds of devices: turns (rad/s), nearer and shifts (parts of the distance a second). */
const STEER = { turn: 1.2, nearer: 1, shift: 0.8 };
const FIELD = { usual: 42, least: 5, most: 120 };

/** Directions from what is looked at to the eye, in the world's frame. */
export const SIDES = {
  front: new Vector3(0, -1, 0), back: new Vector3(0, 1, 0), left: new Vector3(-1, 0, 0), right: new Vector3(1, 0, 0),
  top: new Vector3(0, 0, 1), bottom: new Vector3(0, 0, -1), iso: FROM,
};
export type Side = keyof typeof SIDES;

export class Observer {
  /** Vertical field of view, degrees. */
  readonly field = signal(FIELD.usual);
  readonly camera = new PerspectiveCamera(FIELD.usual, 1, 0.02, 200);
  readonly orbit: OrbitControls;
  readonly axes: ViewHelper;
  /** Whether it looks at something already: as the kernel said, or at all that there was. */
  isPlaced = false;
  /** The field of view and the place that it has again once it is not held any more. */
  #left?: { field: number; position: Vector3 };

  /** `changed` is called when it looks from elsewhere. */
  constructor(canvas: HTMLCanvasElement, private readonly changed: () => void) {
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(2.6, -2.9, 2.1);
    this.orbit = new OrbitControls(this.camera, canvas);
    this.orbit.target.set(0.1, 0, 0.45);
    this.orbit.addEventListener("change", changed);
    this.axes = new ViewHelper(this.camera, canvas);
    this.axes.center = this.orbit.target;
    this.axes.setLabels("X", "Y", "Z");
    canvas.tabIndex = 0;
    canvas.addEventListener("keydown", (event) => this.#key(event));
    // Without a viewpoint of all it is framed when the world is there.
    void readViewpoint().then((shared) => shared && this.look(shared.viewpoint));
  }

  /** Looks at a box, from the present side or (`anew`) from the usual one. */
  frame(box: Box3, anew: boolean): void {
    if (box.isEmpty()) return;
    const size = Math.min(box.getSize(new Vector3()).length(), LARGEST);
    const direction = this.isPlaced && !anew ? this.camera.position.clone().sub(this.orbit.target).normalize() : FROM;
    box.getCenter(this.orbit.target);
    this.camera.position.copy(this.orbit.target).addScaledVector(direction, Math.max(size, 0.2) * 1.25);
    this.#placed();
  }

  /** Looks at the same point from another side, as far away as now. */
  turn(side: Side): void {
    const meters = this.camera.position.distanceTo(this.orbit.target);
    this.camera.position.copy(this.orbit.target).addScaledVector(SIDES[side], meters);
    this.#placed();
  }

  get viewpoint(): Viewpoint {
    const { position } = this.camera, { target } = this.orbit;
    return { position: [position.x, position.y, position.z], target: [target.x, target.y, target.z], fieldDegrees: this.field.value };
  }

  look({ position, target, fieldDegrees }: Viewpoint): void {
    this.camera.position.set(...position);
    this.orbit.target.set(...target);
    this.setField(fieldDegrees);
    this.#placed();
  }

  /** Sets the vertical field of view, 5 to 120 degrees. */
  setField(degrees: number): void {
    this.field.value = this.camera.fov = MathUtils.clamp(degrees, FIELD.least, FIELD.most);
    this.camera.updateProjectionMatrix();
    this.changed();
  }

  /** Looks from a pose in the world, along its -z, and from nowhere else until it is released. */
  hold(place: Matrix4, fieldDegrees: number): void {
    this.#left ??= { field: this.camera.fov, position: this.camera.position.clone() };
    this.orbit.enabled = false;
    place.decompose(this.camera.position, this.camera.quaternion, this.camera.scale);
    this.camera.fov = fieldDegrees;
    this.camera.updateProjectionMatrix();
    this.changed();
  }

  get isHeld(): boolean {
    return this.#left !== undefined;
  }

  /** Looks from where it did before, and as the pointer wants it. */
  release(): void {
    if (this.#left === undefined) return;
    this.orbit.enabled = true;
    this.camera.fov = this.#left.field;
    this.camera.position.copy(this.#left.position);
    this.#left = undefined;
    this.camera.updateProjectionMatrix();
    this.#placed();
  }

  /** Moves along with what has moved by a rigid motion of the world. */
  carry(motion: Matrix4): void {
    this.camera.position.applyMatrix4(motion);
    this.orbit.target.applyMatrix4(motion);
    this.orbit.update();
  }

  /** Moves by parts of its speeds, -1 to 1, for so many seconds: right, up, nearer, around to the right, over what is looked at. */
  steer([right, up, nearer, turn, tilt]: readonly number[], seconds: number): void {
    const arm = this.camera.position.clone().sub(this.orbit.target);
    const shift = new Vector3(right, up, 0).multiplyScalar(STEER.shift * arm.length() * seconds).applyQuaternion(this.camera.quaternion);
    this.#around(arm, STEER.turn * turn * seconds, STEER.turn * tilt * seconds);
    arm.multiplyScalar(Math.exp(-STEER.nearer * nearer * seconds));
    this.orbit.target.add(shift);
    this.camera.position.copy(this.orbit.target).add(arm);
    this.#placed();
  }

  /** Goes on turning to the axis that was clicked. */
  advance(seconds: number): void {
    if (!this.axes.animating) return;
    this.axes.update(seconds);
    this.changed();
  }

  /** Draws the axes over a picture that is there, whose drawings are counted on. */
  drawAxes(renderer: WebGLRenderer): void {
    const { calls } = renderer.info.render;
    this.axes.render(renderer);
    renderer.info.render.calls = calls;
  }

  setSize(width: number, height: number): void {
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
  }

  /** Turns by arrows, shifts with Shift, and goes nearer and farther. */
  #key(event: KeyboardEvent): void {
    const sideways = { ArrowLeft: -1, ArrowRight: 1 }[event.key] ?? 0, up = { ArrowDown: -1, ArrowUp: 1 }[event.key] ?? 0;
    const nearer = { "+": 1, "=": 1, "-": -1 }[event.key] ?? 0;
    if ((!sideways && !up && !nearer) || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    const arm = this.camera.position.clone().sub(this.orbit.target);
    if (event.shiftKey && !nearer) {
      const shift = new Vector3(sideways, up, 0).multiplyScalar(KEY.shift * arm.length()).applyQuaternion(this.camera.quaternion);
      this.orbit.target.add(shift);
    } else if (nearer) arm.multiplyScalar(KEY.nearer ** nearer);
    else this.#around(arm, KEY.turn * sideways, KEY.turn * up);
    this.camera.position.copy(this.orbit.target).add(arm);
    this.#placed();
  }

  /** Turns the way from what is looked at to the eye: around the world's z to the right, and up; radians. */
  #around(arm: Vector3, right: number, up: number): void {
    const around = new Spherical().setFromVector3(new Vector3(arm.x, arm.z, -arm.y));
    around.theta += right;
    around.phi -= up;
    const turned = new Vector3().setFromSpherical(around.makeSafe());
    arm.set(turned.x, -turned.z, turned.y);
  }

  #placed(): void {
    if (this.#left === undefined) this.orbit.update();
    this.isPlaced = true;
    this.changed();
  }
}
