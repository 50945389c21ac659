// Where the view is looked at from: the camera, how it is turned by the pointer, and the axes in the corner.
import { Box3, PerspectiveCamera, Vector3, type WebGLRenderer } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { ViewHelper } from "three/examples/jsm/helpers/ViewHelper.js";
import { views } from "../kernel/services";

const FROM = new Vector3(0.62, -0.78, 0.5).normalize();
const LARGEST = 12;

export class Observer {
  readonly camera = new PerspectiveCamera(42, 1, 0.02, 200);
  readonly orbit: OrbitControls;
  readonly axes: ViewHelper;
  /** Whether it looks at something already: as the kernel said, or at all that there was. */
  isPlaced = false;

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
    void this.#lookAsTheKernel();
  }

  /** Looks at a box, from the present side or (`anew`) from the usual one. */
  frame(box: Box3, anew: boolean): void {
    if (box.isEmpty()) return;
    const size = Math.min(box.getSize(new Vector3()).length(), LARGEST);
    const direction = this.isPlaced && !anew ? this.camera.position.clone().sub(this.orbit.target).normalize() : FROM;
    box.getCenter(this.orbit.target);
    this.camera.position.copy(this.orbit.target).addScaledVector(direction, Math.max(size, 0.2) * 1.25);
    this.orbit.update();
    this.isPlaced = true;
    this.changed();
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

  async #lookAsTheKernel(): Promise<void> {
    try {
      const camera = (await views.getView({})).view?.camera;
      const { position, target } = camera ?? {};
      if (!position || !target) return;
      this.camera.position.set(position.x, position.y, position.z);
      this.orbit.target.set(target.x, target.y, target.z);
      this.orbit.update();
      this.isPlaced = true;
    } catch {
      // Then it is framed when the world is there.
    }
  }
}
