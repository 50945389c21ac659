// The 3D view: the world's figures where their nodes are, what is selected, ghosts, and how it is looked at.
import { effect, signal } from "@preact/signals";
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { ViewHelper } from "three/examples/jsm/helpers/ViewHelper.js";
import { views } from "../kernel/services";
import * as world from "../kernel/world";
import { theme } from "../parts/theme";
import { Batches } from "./batches";
import { Ghost, Silhouette } from "./copies";
import { contentOf, primitive, seen, type Piece } from "./figures";
import { Gizmo } from "./gizmo";
import { Marks } from "./marks";
import { Meshes } from "./meshes";
import { readRow } from "./poses";
import { Stage } from "./stage";
import { drawTraces } from "./trails";

export const framesPerSecond = signal(0);
export const drawCalls = signal(0);
/** Whether everything that is known has been drawn once. */
export const drawn = signal(false);

const CLICK_PIXELS = 4;
const FROM = new THREE.Vector3(0.62, -0.78, 0.5).normalize();

export class Viewport {
  readonly camera = new THREE.PerspectiveCamera(42, 1, 0.02, 200);
  readonly orbit: OrbitControls;
  readonly ghost = new Ghost(0x38a3ff);
  readonly gizmo: Gizmo;
  /** What panels draw into the view. */
  readonly overlay = new THREE.Group();
  readonly places = new Map<string, THREE.Matrix4>();
  readonly pieces = new Map<string, readonly Piece[]>();
  #stage = new Stage();
  #batches = new Batches();
  #silhouette = new Silhouette();
  #marks = new Marks();
  #meshes = new Meshes(() => this.#restructure());
  #axes: ViewHelper;
  #timer = new THREE.Timer();
  #dirty = true;
  #moved = true;
  #structure = true;
  #frames = 0;
  #rested = 0;
  #framed = false;

  constructor(private readonly host: HTMLElement) {
    const { renderer, scene } = this.#stage;
    const canvas = renderer.domElement;
    canvas.setAttribute("aria-label", "3D view of the cell");
    host.append(canvas);
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(2.6, -2.9, 2.1);
    this.orbit = new OrbitControls(this.camera, canvas);
    this.orbit.target.set(0.1, 0, 0.45);
    this.orbit.addEventListener("change", () => this.invalidate());
    this.gizmo = new Gizmo(this);
    this.#axes = new ViewHelper(this.camera, canvas);
    this.#axes.center = this.orbit.target;
    this.#axes.setLabels("X", "Y", "Z");
    scene.add(this.#batches.group, this.#silhouette.group, this.#marks.group, this.ghost.group, this.overlay, ...this.gizmo.objects);
    new ResizeObserver(() => this.#resize()).observe(host);
    this.#hearPointer(canvas);
    world.hearers.poses.add((uids, rows) => this.#takePoses(uids, rows));
    world.hearers.structure.add((renamed) => this.#rename(renamed));
    drawTraces(this);
    effect(() => {
      this.#stage.setTheme(theme.value);
      this.invalidate();
    });
    effect(() => {
      this.#select(world.selected.value);
    });
    setInterval(() => {
      framesPerSecond.value = this.#frames;
      this.#frames = 0;
      drawCalls.value = renderer.info.render.calls;
    }, 1000);
    renderer.setAnimationLoop(() => this.#frame());
    void this.#lookAsTheKernel();
  }

  invalidate(): void {
    this.#dirty = true;
  }

  setOrbiting(on: boolean): void {
    this.orbit.enabled = on;
  }

  get canvas(): HTMLCanvasElement {
    return this.#stage.renderer.domElement;
  }

  toggleGrid(): boolean {
    this.#stage.grid.visible = !this.#stage.grid.visible;
    this.invalidate();
    return this.#stage.grid.visible;
  }

  /** Looks at all of the world, or at a node and what hangs below it. */
  frame(name = ""): void {
    const names = name ? world.below(name) : [...this.pieces.keys()];
    const box = new THREE.Box3();
    for (const one of names) {
      const place = this.places.get(one);
      for (const { geometry, local } of (place && this.pieces.get(one)) || []) {
        geometry.computeBoundingBox();
        box.union(geometry.boundingBox!.clone().applyMatrix4(new THREE.Matrix4().multiplyMatrices(place!, local)));
      }
    }
    if (box.isEmpty()) return;
    const size = Math.min(box.getSize(new THREE.Vector3()).length(), 12);
    const direction = this.#framed && name ? this.camera.position.clone().sub(this.orbit.target).normalize() : FROM;
    box.getCenter(this.orbit.target);
    this.camera.position.copy(this.orbit.target).addScaledVector(direction, Math.max(size, 0.2) * 1.25);
    this.orbit.update();
    this.#framed = true;
    this.invalidate();
  }

  /** Returns a picture of the view as it is, PNG. */
  picture(): Promise<Blob | null> {
    this.#render();
    return new Promise((resolve) => this.canvas.toBlob(resolve));
  }

  async #lookAsTheKernel(): Promise<void> {
    try {
      const camera = (await views.getView({})).view?.camera;
      const { position, target } = camera ?? {};
      if (!position || !target) return;
      this.camera.position.set(position.x, position.y, position.z);
      this.orbit.target.set(target.x, target.y, target.z);
      this.orbit.update();
      this.#framed = true;
    } catch {
      // Then it is framed when the world is there.
    }
  }

  #restructure(): void {
    this.#structure = true;
    this.invalidate();
  }

  #rename(renamed: world.Renamed): void {
    const moved = [...renamed].map(([from, to]) => [to, this.places.get(from)] as const);
    for (const from of renamed.keys()) this.places.delete(from);
    for (const [to, place] of moved) if (place) this.places.set(to, place);
    this.#restructure();
  }

  #takePoses(uids: readonly bigint[], rows: Float64Array): void {
    uids.forEach((uid, place) => {
      const name = world.names.get(uid);
      if (name === undefined) return;
      let matrix = this.places.get(name);
      if (matrix === undefined) this.places.set(name, (matrix = new THREE.Matrix4()));
      readRow(rows, place, matrix);
    });
    this.#moved = true;
    this.invalidate();
  }

  #rebuild(): void {
    this.#structure = false;
    this.pieces.clear();
    const missing = new Map<string, string[]>();
    const shown = [...world.items.peek().values()].filter((item) => !isHidden(item));
    for (const item of shown) {
      const found: Piece[] = [];
      for (const figure of seen(item)) {
        const one = primitive(figure);
        if (one) found.push(one);
        else if (figure.geometry.case === "mesh") {
          const parts = this.#meshes.piecesOf(figure);
          if (parts) found.push(...parts);
          else {
            const root = world.robotOf(item.name) || item.name;
            missing.set(root, [...(missing.get(root) ?? []), contentOf(figure)]);
          }
        }
      }
      if (found.length > 0) this.pieces.set(item.name, found);
    }
    if (missing.size > 0) void this.#meshes.want(missing);
    this.#batches.rebuild(this.pieces);
    this.#marks.rebuild(shown);
    this.#select(world.selected.peek());
    if (!this.#framed && this.pieces.size > 0) this.frame();
    drawn.value = missing.size === 0 && shown.length > 0;
  }

  #place(): void {
    this.#moved = false;
    this.#batches.place(this.places);
    this.#silhouette.place(this.places);
    this.#marks.place(this.places);
  }

  #frame(): void {
    this.#timer.update();
    if (this.#structure) this.#rebuild();
    if (this.#moved) this.#place();
    if (this.#axes.animating) {
      this.#axes.update(this.#timer.getDelta());
      this.invalidate();
    }
    const now = performance.now();
    if (!this.#dirty || now < this.#rested) return;
    this.#dirty = false;
    this.#frames++;
    this.#render();
    // Drawings take all of the page's time where there is no graphics card; what the kernel tells waits no longer than one.
    setTimeout(() => (this.#rested = 2 * performance.now() - now));
    this.#rested = Infinity;
  }

  #render(): void {
    const { renderer, scene } = this.#stage;
    renderer.autoClear = true;
    renderer.render(scene, this.camera);
    renderer.autoClear = false;
    const { calls } = renderer.info.render;
    this.#axes.render(renderer);
    renderer.info.render.calls = calls;
  }

  #resize(): void {
    const { clientWidth: width, clientHeight: height } = this.host;
    if (!width || !height) return;
    this.#stage.renderer.setSize(width, height);
    this.#silhouette.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.#render();
  }

  #select(name: string): void {
    const item = world.items.peek().get(name);
    const names = item && item.kind !== "world" ? world.below(name) : [];
    this.#silhouette.show(names, this.pieces, this.places);
    this.#moved = true;
    this.invalidate();
  }

  #hearPointer(canvas: HTMLCanvasElement): void {
    let down: PointerEvent | undefined;
    canvas.addEventListener("pointerdown", (event) => (down = event));
    canvas.addEventListener("pointerup", (event) => {
      const still = down && Math.hypot(event.clientX - down.clientX, event.clientY - down.clientY) < CLICK_PIXELS;
      if (still && !this.gizmo.dragging && !this.#axes.handleClick(event)) this.#pick(event);
      this.invalidate();
    });
    canvas.addEventListener("dblclick", () => world.selected.value && this.frame(world.selected.value));
  }

  /** Selects what is under the pointer: of a robot the whole, with Alt the link. */
  #pick(event: PointerEvent): void {
    const area = this.canvas.getBoundingClientRect();
    const x = (2 * (event.clientX - area.left)) / area.width - 1, y = 1 - (2 * (event.clientY - area.top)) / area.height;
    const ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2(x, y), this.camera);
    const found = this.#batches.hit(ray)?.name ?? "";
    const isLink = world.items.peek().get(found)?.kind === "link";
    const name = isLink && !event.altKey ? world.robotOf(found) : found;
    world.selected.value = name;
    if (world.items.peek().get(name)?.kind === "robot") world.chosen.value = name;
  }
}

function isHidden(item: world.Item): boolean {
  for (let one: world.Item | undefined = item; one; one = world.items.peek().get(one.parent)) if (one.hidden) return true;
  return false;
}
