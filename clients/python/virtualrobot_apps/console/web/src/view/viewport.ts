// The 3D view: draws what there is when something has changed, and is the one place that its parts meet at.
import { effect, signal } from "@preact/signals";
import { Group, Timer, type Vector3 } from "three";
import { outlined } from "../kernel/collisions";
import { isolated } from "../kernel/isolation";
import * as world from "../kernel/world";
import { theme } from "../parts/theme";
import { drawAids } from "./aids";
import { drawCoats } from "./coats";
import { Ghost } from "./copies";
import { Follower } from "./follower";
import { Gizmo } from "./gizmo";
import { drawAxis } from "./jointing";
import { NodeHandle } from "./node_handle";
import { Names, namesShown } from "./names";
import { drawHeads } from "./heads";
import { Observer } from "./observer";
import { hearPointer } from "./pointer";
import { drawGhosts } from "./other_ghosts";
import { drawSwept } from "./postures";
import { SizeHandle } from "./size_handle";
import { Solids } from "./solids";
import { drawSpans } from "./spans";
import { followHead } from "./spectator";
import { Stage } from "./stage";
import { drawTraces } from "./trails";

export const framesPerSecond = signal(0);
export const drawCalls = signal(0);

/** What draws the frames of a headset or phone in place of the page's. */
export interface Room {
  draw(frame: XRFrame): void;
  /** Is told when nodes came, went or changed. */
  rebuild(): void;
}

export class Viewport {
  readonly observer: Observer;
  readonly solids = new Solids(() => this.invalidate());
  readonly ghost = new Ghost(0x38a3ff);
  readonly gizmo: Gizmo;
  readonly nodeHandle: NodeHandle;
  readonly sizeHandle: SizeHandle;
  /** What panels draw into the view. */
  readonly overlay = new Group();
  readonly stage = new Stage();
  room?: Room;
  #names = new Names();
  #timer = new Timer();
  #follower = new Follower();
  #redrawAids: () => void;
  #redrawGhosts: () => void;
  /** From where it looks by itself, as long as figures are yet to come. */
  #framedFrom?: Vector3;
  #dirty = true;
  #frames = 0;
  #rested = 0;

  constructor(private readonly host: HTMLElement) {
    const { renderer, scene } = this.stage;
    this.canvas.setAttribute("aria-label", "3D view of the cell");
    host.append(this.canvas, this.#names.element);
    this.observer = new Observer(this.canvas, () => this.invalidate());
    this.gizmo = new Gizmo(this);
    this.nodeHandle = new NodeHandle(this);
    this.sizeHandle = new SizeHandle(this, host);
    scene.add(...this.solids.objects, this.ghost.group, this.overlay, ...this.gizmo.objects, ...this.nodeHandle.objects, ...this.sizeHandle.objects);
    new ResizeObserver(() => this.#resize()).observe(host);
    hearPointer(this);
    drawTraces(this);
    drawSpans(this);
    drawCoats(this);
    drawSwept(this);
    this.#redrawAids = drawAids(this);
    this.#redrawGhosts = drawGhosts(this);
    drawAxis(this);
    drawHeads(this);
    followHead(this);
    effect(() => {
      this.stage.setTheme(theme.value);
      this.invalidate();
    });
    effect(() => {
      this.#names.rebuild(namesShown.value ? world.items.value.values() : []);
      this.invalidate();
    });
    effect(() => this.solids.isolate(isolated.value));
    effect(() => this.solids.select(world.selected.value));
    effect(() => this.solids.mark(outlined.value));
    setInterval(() => {
      framesPerSecond.value = this.#frames;
      this.#frames = 0;
      drawCalls.value = renderer.info.render.calls;
    }, 1000);
    renderer.setAnimationLoop((_, frame) => this.#frame(frame));
  }

  invalidate(): void {
    this.#dirty = true;
    this.#tellBusy(true);
  }

  get canvas(): HTMLCanvasElement {
    return this.stage.renderer.domElement;
  }

  toggleGrid(): boolean {
    this.stage.grid.visible = !this.stage.grid.visible;
    this.invalidate();
    return this.stage.grid.visible;
  }

  /** Looks at all of the world, or at a node and what hangs below it. */
  frame(name = ""): void {
    this.observer.frame(this.solids.boxOf(name ? world.below(name) : this.solids.pieces.keys()), name === "");
  }

  /** Looks at these nodes, without what hangs below them, from the present side. */
  look(names: readonly string[]): void {
    this.observer.frame(this.solids.boxOf(names), false);
  }

  /** Returns a picture of the view as it is, PNG. */
  picture(): Promise<Blob | null> {
    this.#render();
    return new Promise((resolve) => this.canvas.toBlob(resolve));
  }

  #frame(frame: XRFrame | undefined): void {
    this.#timer.update();
    if (this.solids.update()) {
      this.ghost.renew(this.solids.pieces, this.solids.places);
      this.room?.rebuild();
      this.#redrawAids();
      this.#redrawGhosts();
      if (this.solids.pieces.size > 0) this.#frameFirst();
    }
    this.#follower.advance(this.observer, this.solids.places);
    this.observer.advance(this.#timer.getDelta());
    this.#tellBusy(this.#dirty || !this.solids.isComplete || this.ghost.isAwaited);
    if (frame) {
      this.#frames++;
      this.#dirty = false;
      return this.room?.draw(frame);
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

  /** Looks at all of the world until its figures have all come, as long as nobody looks from elsewhere. */
  #frameFirst(): void {
    const { camera, isHeld, isPlaced } = this.observer;
    if (isHeld || (isPlaced && !this.#framedFrom?.equals(camera.position))) return;
    this.frame();
    this.#framedFrom = this.solids.isComplete ? undefined : camera.position.clone();
  }

  /** Tells whoever looks at the page whether the picture isn't what is known yet. */
  #tellBusy(busy: boolean): void {
    if (this.host.ariaBusy !== String(busy)) this.host.ariaBusy = String(busy);
  }

  #render(): void {
    const { renderer, scene } = this.stage;
    renderer.autoClear = true;
    renderer.render(scene, this.observer.camera);
    renderer.autoClear = false;
    this.observer.drawAxes(renderer);
    this.#names.place(this.solids.places, (name) => this.solids.isShown(name), this.observer.camera);
  }

  /** Draws the page again after a room, which had a size of its own. */
  leaveRoom(): void {
    this.room = undefined;
    this.#resize();
    this.invalidate();
  }

  #resize(): void {
    const { clientWidth: width, clientHeight: height } = this.host;
    if (!width || !height || this.room) return;
    this.stage.renderer.setSize(width, height);
    this.solids.setSize(width, height);
    this.observer.setSize(width, height);
    this.#render();
  }
}
